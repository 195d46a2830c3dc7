#!/usr/bin/env python3
"""Compares fbptr with llvmpipe, or SwiftShader, on W1 to W5, workload by workload, in alternated rounds.

    benches/peers/run.sh setup              # once
    python3 benches/peers/pairs.py          # nine rounds, one and two threads, AVX-512 (where there is) and AVX2
    python3 benches/peers/pairs.py --peer swiftshader

In: what `run.sh setup` built (folder PEERS_DIR, else target/peers). Out: a Markdown table, a row for each width of
vectors, number of threads and workload: the medians of the rounds' median frames of both programs in milliseconds, and
the median of the rounds' own ratios (the peer's time over fbptr's) with the least and the largest.

A round times both programs on one workload right after each other, each round in the other order. `fbptr bench` compares
its picture with the truth before it times; a refused picture ends the script. llvmpipe has its tuned memory settings
and, beside `--simd avx2`, vectors of 256 bits of its own; SwiftShader always has 128 bits (PEERS_SWIFTSHADER names its
manifest, otherwise that of Debian's chromium). On one thread both run on the same core. A system may leave the threads
of a new program on one core for some 50 ms, so fbptr, whose frames are short, draws more of them.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
FOLDER = os.path.abspath(os.environ.get("PEERS_DIR", os.path.join(ROOT, "target/peers")))
# Name at `fbptr bench`, group at a peer's program.
WORKLOADS = {"W1_phong70k": "W1", "W2_phong1M": "W2", "W3_fill20": "W3", "W4_tex_trilinear": "W4", "W5_gouraud70k": "W5"}
# Mesa frees and maps large blocks in every frame unless told not to.
TUNED = {
    "MALLOC_TRIM_THRESHOLD_": "2000000000",
    "MALLOC_MMAP_THRESHOLD_": "1000000000",
    "MALLOC_TOP_PAD_": "268435456",
    "LIBGL_ALWAYS_SOFTWARE": "1",
    "GALLIUM_DRIVER": "llvmpipe",
}


def median_ms(command, workload, environment=None, folder=None):
    """Runs a program, in a folder, and returns the median frame of its row for `workload`, in milliseconds."""
    variables = {**os.environ, **(environment or {})}
    done = subprocess.run(command, env=variables, cwd=folder, capture_output=True, text=True)
    rows = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    found = [row["med_ms"] for row in rows if row["wl"] == workload]
    if not found:
        sys.exit(f"{' '.join(command)}: no time for {workload}\n{done.stderr}")
    return found[0]


def ours(binary, workload, threads, simd, frames):
    command = [binary, "bench", workload, "--json", "--frames", frames, "--threads", str(threads)]
    command += ["--simd", simd] if simd != "auto" else []
    return median_ms(["taskset", "-c", "0"] * (threads == 1) + command, workload)


def common(workload, threads, frames):
    """Returns the settings that all peers read (common.h)."""
    return {
        "PEERS_SCENE": os.path.join(FOLDER, "scene"),
        "PEERS_SHOTS": os.path.join(FOLDER, "shots"),
        "PEERS_FRAMES": frames,
        "PEERS_ONLY": WORKLOADS[workload],
        "PEERS_CFG": f"{threads}T",
    }


def llvmpipe(workload, threads, simd, frames):
    environment = {**TUNED, **common(workload, threads, frames)}
    environment["LP_NUM_THREADS"] = "0" if threads == 1 else str(threads)
    if simd == "avx2":
        environment["LP_NATIVE_VECTOR_WIDTH"] = "256"
    command = ["taskset", "-c", "0"] * (threads == 1) + [os.path.join(FOLDER, "llvmpipe")]
    return median_ms(command, workload, environment)


def swiftshader(workload, threads, _simd, frames):
    # SwiftShader reads its number of threads from a file of the working folder.
    folder = os.path.join(FOLDER, f"threads-{threads}")
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, "SwiftShader.ini"), "w", encoding="ascii") as file:
        file.write(f"[Processor]\nThreadCount={threads}\n")
    environment = {
        **common(workload, threads, frames),
        "PEERS_SHADERS": os.path.join(FOLDER, "shaders"),
        "VK_ICD_FILENAMES": os.environ.get("PEERS_SWIFTSHADER", "/usr/lib/chromium/vk_swiftshader_icd.json"),
    }
    command = ["taskset", "-c", "0"] * (threads == 1) + [os.path.join(FOLDER, "swiftshader")]
    return median_ms(command, workload, environment, folder)


PEERS = {"llvmpipe": llvmpipe, "swiftshader": swiftshader}


def pairs(given, workload, threads, simd):
    """Returns the median frames of both programs, a pair for each round."""
    own = lambda: ours(given.fbptr, workload, threads, simd, given.frames)
    peer = lambda: PEERS[given.peer](workload, threads, simd, given.peer_frames)
    found = []
    for turn in range(given.rounds):
        if turn % 2 == 0:
            found.append((own(), peer()))
        else:
            found.append((peer(), own())[::-1])
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fbptr", default=os.path.join(ROOT, "target/release/fbptr"))
    parser.add_argument("--peer", default="llvmpipe", choices=PEERS)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--frames", default="150", help="frames that fbptr draws in a round")
    parser.add_argument("--peer-frames", default="30", help="frames that the peer draws in a round, within 6 s")
    parser.add_argument("--threads", default="1,2", help="numbers of threads")
    parser.add_argument("--simd", default="auto,avx2", help="levels of --simd; auto is the widest of the machine")
    parser.add_argument("--only", default=",".join(WORKLOADS), help="workloads by their names at `fbptr bench`")
    given = parser.parse_args()
    print(f"| vectors | threads | workload | {given.peer}, ms | fbptr, ms | ratio (least to largest) |")
    print("|---|---|---|---|---|---|", flush=True)
    for simd in given.simd.split(","):
        for threads in map(int, given.threads.split(",")):
            for workload in given.only.split(","):
                found = pairs(given, workload, threads, simd)
                ratios = sorted(peer / own for own, peer in found)
                own, peer = (statistics.median(column) for column in zip(*found))
                print(
                    f"| {simd} | {threads} | {workload} | {peer:.1f} | {own:.1f} | "
                    f"{statistics.median(ratios):.1f} ({ratios[0]:.1f} to {ratios[-1]:.1f}) |",
                    flush=True,
                )


if __name__ == "__main__":
    main()
