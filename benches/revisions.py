#!/usr/bin/env python3
"""Compares two builds on the scenes of budget.py: exact frames, and frames within an E, over exact ones of the base.

    python3 benches/revisions.py OLD_FBPTR NEW_FBPTR
    python3 benches/revisions.py OLD_FBPTR NEW_FBPTR tests/data/formats/stl/*.stl --rounds 31 --simd avx2

In: two programs, the base first, and files as for budget.py. Out: a Markdown table, a row for each scene: pixels of the
new exact picture that are more than one step from the base's, milliseconds of the base's exact frame, and the median of
the rounds' ratios, the base's exact time over the new one's, exact and within E; then a summary. Ends with status 1
where the new picture within E is further from its exact one than E in more than 0.1 % of its pixels.

Each program has a server and a connection for a scene; rounds time the three in turns, each round in the other order.
"""

import argparse
import os
import statistics
import sys

import budget
from budget import HEIGHT, LEAST_FRAMES, MOST_FRAMES, RUN_SECONDS, WIDTH, Server


def differing(a, b):
    """Returns the number of pixels that differ by more than one step in a channel."""
    rows = zip(budget.words(a), budget.words(b))
    changed = [4 * i for i, (old, new) in enumerate(rows) if old != new]
    return sum(max(abs(a[i + c] - b[i + c]) for c in range(3)) > 1 for i in changed)


def compared(servers, setup, one, limit, rounds):
    """Returns pixels that differ, the base's milliseconds, the ratios exact and within E, and the share over E; None
    if nothing is seen."""
    base, new = servers
    if any(server.run(setup)[1] for server in servers):
        return None
    pictures = [server.picture("QUALITY exact\n" + one) for server in servers]
    drawn = budget.pixels_drawn(new, pictures[1], one)
    if drawn < budget.LEAST_PIXELS:
        return None
    within = f"QUALITY max-error {limit}\n"
    _, over = budget.error_of(pictures[1], new.picture(within + one * 3), drawn, limit)
    for server in servers:
        server.run("QUALITY exact\n" + one * 10)
    frames = max(LEAST_FRAMES, min(MOST_FRAMES, round(RUN_SECONDS * 10 / base.run(one * 10)[0])))
    kinds = [(base, "QUALITY exact\n"), (new, "QUALITY exact\n"), (new, within)]
    times = [[], [], []]
    for i in range(rounds):
        for k in [0, 1, 2][:: 1 - 2 * (i % 2)]:
            server, quality = kinds[k]
            times[k].append(server.run(quality + one * frames)[0] / frames)
    ratios = [statistics.median(a / b for a, b in zip(times[0], own)) for own in times[1:]]
    return differing(*pictures), statistics.median(times[0]) * 1e3, *ratios, over


def main():
    """Prints the table and its summary."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("base")
    parser.add_argument("program")
    parser.add_argument("files", nargs="*")
    parser.add_argument("--limit", type=int, default=4, help="E")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--threads", default="1")
    parser.add_argument("--simd", default="auto", help="a level of --simd")
    options = parser.parse_args()
    programs = [os.path.abspath(path) for path in (options.base, options.program)]
    print(f"| scene, {WIDTH}x{HEIGHT} | other pixels | exact before, ms | exact | E {options.limit} |")
    print("|---|---:|---:|---:|---:|")
    every, broken = [], []
    for name, setup, frame in budget.scenes([os.path.abspath(f) for f in options.files]):
        one = "CLEAR 000000\n" + frame
        base, new = (Server(program, options.threads, options.simd) for program in programs)
        with base, new:
            found = compared([base, new], setup, one, options.limit, options.rounds)
        if found is None:
            print(f"{name}: not drawn", file=sys.stderr)
            continue
        others, ms, exact, within, over = found
        print(f"| {name} | {others:,} | {ms:.3f} | {exact:.2f} | {within:.2f} |", flush=True)
        every.append((exact, within))
        broken += [f"{name}: {over:.2%} over E"] if over > 0.001 else []
    for title, speeds in zip(["exact", f"E {options.limit}"], map(sorted, zip(*every))):
        counts = f"{sum(s >= 1.5 for s in speeds)} at least 1.5, {sum(s >= 1.3 for s in speeds)} at least 1.3"
        slow = sum(s < 0.98 for s in speeds)
        print(f"{title}: of {len(speeds)} {counts}, {slow} below 0.98; median {statistics.median(speeds):.2f}, least {speeds[0]:.2f}")
    print("\n".join(broken) or "no picture has more than 0.1 % of its pixels over E")
    sys.exit(1 if broken else 0)


if __name__ == "__main__":
    main()
