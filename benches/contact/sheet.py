#!/usr/bin/env python3
"""Renders some two hundred X3D, OBJ, glTF, STL and PLY files onto contact sheets, for visual inspection.

    python3 benches/contact/sheet.py target/release/fbptr docs/sheets

The OBJ files are written by `objects.py`, the others are those of `tests/data`. Each is drawn by
`fbptr render` at 120x90 from its own camera, or from one that frames it. Writes `files-obj.png`,
`files-x3d.png` and `files-formats.png`, and prints each file's position on its sheet (row, column) with
the first line of the program's messages. A refused file leaves its position black. Exit status 1 unless
exactly the expected files are refused: XML that is not well formed, files that include themselves, and
those with `broken` in their name.
"""

import glob
import os
import subprocess
import sys
import tempfile

import objects

WIDTH, HEIGHT, GAP, COLUMNS = 120, 90, 2, 16
BACKGROUND = (24, 32, 48)
REFUSED = ("_malformed", "cycle_", "broken_")
TESTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../tests/data")


def render(program, path, folder):
    """Returns the picture's rows of (red, green, blue), or None, and the program's messages."""
    raw = os.path.join(folder, "picture.raw")
    done = subprocess.run([program, "render", path, "-o", raw, "--size", "%dx%d" % (WIDTH, HEIGHT),
                           "--background", "%02x%02x%02x" % BACKGROUND],
                          stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, errors="replace")
    if done.returncode != 0:
        return None, done.stderr
    data = open(raw, "rb").read()
    pixels = [tuple(data[i:i + 3]) for i in range(0, len(data), 4)]
    return [pixels[y * WIDTH:(y + 1) * WIDTH] for y in range(HEIGHT)], done.stderr


def sheet(program, paths, out, folder):
    """Writes one sheet; returns the number of files drawn instead of refused, or the reverse."""
    lines, refused, wrong = -(-len(paths) // COLUMNS), 0, 0
    rows = [[(0, 0, 0)] * ((WIDTH + GAP) * COLUMNS) for _ in range((HEIGHT + GAP) * lines)]
    for n, path in enumerate(paths):
        line, column = divmod(n, COLUMNS)
        picture, said = render(program, path, folder)
        said = said.replace(os.path.dirname(path) + "/", "").strip().splitlines()
        print("%d,%d %s%s" % (line, column, os.path.basename(path), ": " + said[0] if said else ""), flush=True)
        refused += picture is None
        wrong += (picture is None) != any(part in os.path.basename(path) for part in REFUSED)
        for y, pixels in enumerate(picture or []):
            x = column * (WIDTH + GAP)
            rows[line * (HEIGHT + GAP) + y][x:x + WIDTH] = pixels
    open(out, "wb").write(objects.png(rows))
    print("%s: %d files, %d refused, %d of them or others not as expected" % (out, len(paths), refused, wrong))
    return wrong


def main():
    program, folder_out = sys.argv[1:]
    scenes = sorted(glob.glob(os.path.join(TESTS, "x3d", "**", "*.x3d*"), recursive=True))
    others = sorted(path for path in glob.glob(os.path.join(TESTS, "formats", "*", "**", "*.*"), recursive=True)
                    if path.endswith((".gltf", ".glb", ".stl", ".ply")))
    with tempfile.TemporaryDirectory() as folder:
        wrong = sheet(program, objects.write_all(folder), os.path.join(folder_out, "files-obj.png"), folder)
        wrong += sheet(program, scenes, os.path.join(folder_out, "files-x3d.png"), folder)
        wrong += sheet(program, others, os.path.join(folder_out, "files-formats.png"), folder)
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
