#!/usr/bin/env python3
"""Compares the frames of W1 to W7 with what the machine allows: bytes at the speed of a copy, faces at that of set-up.

    python3 benches/limits.py target/release/fbptr            # five rounds on one core, a Markdown table

In: the program. Out: for each workload the least bytes that a frame must move, the time that takes on this machine, the
time of setting its faces up, and the sum's share of the frame's time: 100 % would be a frame in which nothing else is
done.

- Bytes are counted, not measured: each pixel of the frame is written once (4 bytes), and each covered pixel's depth once
  (4); a mesh's vertices (positions and normals, or positions and texture coordinates, in f32) and indices are read once;
  of a texture four texels of each covered pixel's level are read, at most all of it. Lines and single pixels write each
  of their pixels (4 bytes); layers need not leave a cache, but for the last one.
- They move at the speed of `numpy.copyto` between two blocks of as many bytes as the frame has, which counts for twice
  its length, on the same core in the same round.
- Faces are those of the mesh that face the eye; the time for one is that of the same mesh on a frame of 16x9 pixels,
  `fbptr bench --size 16x9`, in which next to nothing is left but reading, transforming and culling it.

Ends with status 1 where the program refuses a workload: then its picture was wrong.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time

import numpy

WIDTH, HEIGHT = 1920, 1080
PIXEL, DEPTH = 4, 4
# Workload: vertices, faces, floats of a vertex; bytes of the texture; pixels written where they are not those covered.
KNOTS = {"W1_phong70k": (35_000, 70_000, 6, 0), "W2_phong1M": (500_000, 1_000_000, 6, 0)}
TEXTURE = 1024 * 1024 * 4
WORKS = {
    **KNOTS,
    "W3_fill20": (80, 40, 3, 0),
    "W4_tex_trilinear": (35_000, 70_000, 5, TEXTURE * 4 // 3),
    "W4_tex_bilinear": (35_000, 70_000, 5, TEXTURE),
    "W4_tex_nearest": (35_000, 70_000, 5, TEXTURE),
    "W5_gouraud70k": (35_000, 70_000, 6, 0),
}
WRITTEN = {"W6_lines_long": 731_000_000, "W7_putpixel_100M": 100_000_000}


def rows_of(fbptr, works, frames, size):
    """Runs `fbptr bench`; returns its rows by name."""
    command = [fbptr, "bench", *works, "--json", "--threads", "1", "--frames", str(frames), "--size", size]
    lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
    return {row["wl"]: row for row in map(json.loads, lines)}


def copy_speed(rounds=15):
    """Returns the bytes that this core reads and writes in a second, copying one frame to another."""
    source = numpy.random.default_rng(1).integers(0, 255, WIDTH * HEIGHT * PIXEL, numpy.uint8)
    target = numpy.empty_like(source)
    times = []
    for _ in range(rounds):
        begin = time.perf_counter()
        numpy.copyto(target, source)
        times.append(time.perf_counter() - begin)
    return 2 * source.nbytes / statistics.median(times)


def bytes_of(name, covered):
    """Returns the least bytes that a frame of the workload reads and writes."""
    frame = WIDTH * HEIGHT * PIXEL
    if name in WRITTEN:
        return frame + WRITTEN[name] * PIXEL
    vertices, faces, floats, texture = WORKS[name]
    mesh = vertices * floats * 4 + faces * 3 * 4
    return frame + covered * DEPTH + mesh + min(texture, covered * 4 * 4)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("fbptr", nargs="?", default="target/release/fbptr")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--frames", type=int, default=20)
    parser.add_argument("--core", type=int, default=0)
    parser.add_argument("--only", help="workloads by name, with commas between")
    given = parser.parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {given.core})
    names = given.only.split(",") if given.only else [*WORKS, *WRITTEN]
    found = {name: [] for name in names}
    for _ in range(given.rounds):
        for name in names:
            try:
                row = rows_of(given.fbptr, [name], given.frames, f"{WIDTH}x{HEIGHT}")[name]
                small = rows_of(given.fbptr, [name], given.frames, "16x9")[name] if name in WORKS else None
            except subprocess.CalledProcessError as refused:
                sys.exit(f"{name}: {refused.stderr}")
            moved = bytes_of(name, row["covered"])
            moving = moved / copy_speed() * 1e3
            faces = small["med_ms"] if small else 0.0
            found[name].append((row["med_ms"], moved, moving, faces, (moving + faces) / row["med_ms"]))
    print("| workload | frame, ms | least bytes, MB | to move them, ms | its faces alone, ms | share of the frame |")
    print("|---|---|---|---|---|---|")
    for name, rounds in found.items():
        frame, moved, moving, faces, share = (statistics.median(column) for column in zip(*rounds))
        shares = [share for *_, share in rounds]
        print(
            f"| {name} | {frame:.2f} | {moved / 1e6:.1f} | {moving:.2f} | {faces:.2f} | {share:.0%} "
            f"({min(shares):.0%} to {max(shares):.0%}) |"
        )


if __name__ == "__main__":
    main()
