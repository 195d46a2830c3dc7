#!/usr/bin/env python3
"""Draws the ratios of docs/speed.md's tables as a stream of fbptr's own commands.

    python3 benches/peers/ratios.py > target/ratios.fbs
    fbptr play target/ratios.fbs --headless --snap docs/pictures/speed/ratios.png

Reads each row whose cell is "R (LOW to HIGH)" in the first such column of the tables "Two
dimensions" and "Three dimensions" (by AVX-512, then by AVX2). The bar ends at R, the thin line goes
from LOW to HIGH; the axis is logarithmic, and 1 means as fast as the fastest other program.
"""
import math
import re
import sys
from pathlib import Path

RATIO = re.compile(r"^(\d+\.?\d*) \((\d+\.?\d*) to (\d+\.?\d*)\)$")
WIDTH, LEFT, RIGHT, ROW, TOP = 960, 330, 24, 20, 56
LEAST, MOST = 0.5, 48.0
GROUPS = [
    ("Two dimensions", 0, "#2ec4b6", "beside the fastest of five others"),
    ("Three dimensions", 0, "#ffb000", "beside llvmpipe, AVX-512"),
    ("Three dimensions", 1, "#5b8cff", "beside llvmpipe, AVX2"),
]


def rows(text, heading, column):
    """Returns (label, ratio, least, largest) for each row of the heading's table."""
    section = text.split(f"\n## {heading}\n", 1)[1].split("\n## ", 1)[0]
    found = []
    for line in section.splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        ratios = [match for match in map(RATIO.match, cells) if match]
        if len(ratios) > column:
            threads = f", {cells[1]} thread{'s' if cells[1] != '1' else ''}" if cells[1].isdigit() else ""
            found.append((cells[0] + threads, *(float(n) for n in ratios[column].groups())))
    return found


def stream(text):
    """Returns the picture's commands."""
    groups = [(rows(text, heading, column), *rest) for heading, column, *rest in GROUPS]
    height = TOP + sum(ROW * (len(found) + 2) for found, *_ in groups) + 24
    x_of = lambda r: LEFT + round((WIDTH - LEFT - RIGHT) * math.log(max(LEAST, r) / LEAST) / math.log(MOST / LEAST))
    out = [f"SIZE {WIDTH} {height}", "CLEAR #0e1420"]
    out.append("PRINT 16 16 #e8e8f0 time of the fastest other program / time of fbptr")
    for mark in (0.5, 1, 2, 4, 8, 16, 32):
        x = x_of(mark)
        out.append(f"LINE {x} {TOP - 8} {x} {height - 24} {'#e8e8f0' if mark == 1 else '#2e3a52'}")
        out.append(f"PRINT {x - 4 * len(str(mark))} {height - 18} #808ca5 {mark}")
    y = TOP
    for found, color, title in groups:
        out.append(f"PRINT 16 {y} {color} {title}")
        y += ROW
        for label, ratio, least, largest in found:
            out.append(f"PRINT 32 {y + 3} #e8e8f0 {label}")
            left, right = sorted((x_of(1), x_of(ratio)))
            out.append(f"FILLRECT {left} {y} {max(1, right - left)} 14 {color if ratio >= 1 else '#ff5d5d'}")
            out.append(f"FILLRECT {x_of(least)} {y + 6} {max(1, x_of(largest) - x_of(least))} 2 #e8e8f0")
            out.append(f"PRINT {max(x_of(largest), right) + 6} {y + 3} #e8e8f0 {ratio:g}")
            y += ROW
        y += ROW
    return "\n".join(out) + "\n"


if __name__ == "__main__":
    page = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[2] / "docs/speed.md"
    sys.stdout.write(stream(page.read_text()))
