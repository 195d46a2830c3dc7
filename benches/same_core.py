#!/usr/bin/env python3
"""Compares builds of fbptr on a machine whose speed varies: all run at the same time on one core.

    python3 benches/same_core.py OLD_FBPTR NEW_FBPTR [...] --only W1,W5 [--rounds 6] [--core 0]

In: programs, of which the first is the base. Out: a Markdown table, a row for each workload and program: frames drawn in
a round, and the speed over the base's, as the median of the rounds' own ratios with the least and the largest.

The system gives programs on one core alternate slices of a few milliseconds, so what slows the machine down slows all of
them alike; speed is the number of frames for each second of the program's own processor time, of which a run of one frame
is taken off: before it times `fbptr bench` draws the truth and compares its picture with it, which takes a second or two. A
refused picture ends the script. The caches are shared: a build that needs more
of them slows the others down as well. A program compared with its own copy shows what the ratios are worth.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile

# More than the time limit of `fbptr bench` lets it draw, which then ends all programs after the same time.
MOST_FRAMES = "65535"


def start(program, workload, core, frames, output):
    command = ["taskset", "-c", core, program, "bench", workload, "--json", "--threads", "1", "--frames", frames]
    return subprocess.Popen(command, stdout=output)


def all_at_once(programs, workload, core, most_frames):
    """Runs all programs at the same time; returns frames and processor seconds of each."""
    outputs = [tempfile.TemporaryFile("w+") for _ in programs]
    running = {start(p, workload, core, most_frames, o).pid: k for k, (p, o) in enumerate(zip(programs, outputs))}
    found = [None] * len(programs)
    while running:
        pid, status, usage = os.wait4(-1, 0)
        k = running.pop(pid, None)
        if k is None:
            continue
        outputs[k].seek(0)
        lines = outputs[k].read().splitlines()
        if status != 0 or len(lines) != 1:
            sys.exit(f"{programs[k]}: no single time for {workload}")
        found[k] = (json.loads(lines[0])["n"], usage.ru_utime + usage.ru_stime)
    return found


def one_round(programs, workload, core):
    """Returns the frames of each program after its first, and their processor seconds."""
    first, all_frames = (all_at_once(programs, workload, core, n) for n in ("1", MOST_FRAMES))
    return [(n - n1, seconds - seconds1) for (n, seconds), (n1, seconds1) in zip(all_frames, first)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("programs", nargs="+")
    parser.add_argument("--only", default="W1,W2,W4_tex_trilinear,W5", help="workloads")
    parser.add_argument("--rounds", type=int, default=6)
    parser.add_argument("--core", default="0")
    given = parser.parse_args()
    print("| workload | program | frames a round | speed over the first (least to largest) |\n|---|---|---|---|")
    for workload in given.only.split(","):
        rounds = [one_round(given.programs, workload, given.core) for _ in range(given.rounds)]
        for k, program in enumerate(given.programs):
            ratios = sorted(
                (frames / seconds) / (base_frames / base_seconds)
                for (base_frames, base_seconds), (frames, seconds) in ((r[0], r[k]) for r in rounds)
            )
            frames = statistics.median(r[k][0] for r in rounds)
            ratio = f"{statistics.median(ratios):.3f} ({ratios[0]:.3f} to {ratios[-1]:.3f})"
            print(f"| {workload} | {program} | {frames:.0f} | {ratio} |", flush=True)


if __name__ == "__main__":
    main()
