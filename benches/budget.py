#!/usr/bin/env python3
"""Measures what `QUALITY max-error` saves, what choosing costs, and how wrong the pictures are.

    python3 benches/budget.py target/release/fbptr                        # the test data and made scenes
    python3 benches/budget.py target/release/fbptr tests/data/meshes/spot/spot_control_mesh.obj --rounds 31

In: meshes and X3D files below the folder tests/data, and scenes that are made here. Out: a Markdown table, and a
summary. Ends with status 1 where a picture is further from the exact one than its E.

For each scene one connection to a server of its own (640x480, one thread or --threads) draws it exactly and within
each E in turns, as a program's stream does: CLEAR, then DRAW or DRAWSCENE. A time is that of a run of frames up to
the answer to a SYNC; a cell is the median of the rounds' ratios, exact over E: 1.00 means no gain, and an E whose
settings are exact is timed like the others, so that its cell shows the noise. "Choosing" is the time by which the
second draw of a new mesh, which measures it, exceeds the third, in exact frames: the most over all E, each a median.
The error is the 99.9th percentile over the pixels drawn on of the whole picture against the exact one; the share is
that of the pixels over E. What was chosen is read from the plans of `fbptr play --explain`: shading mode, and under
Phong the number of lights.
"""

import argparse
import itertools
import operator
import os
import re
import socket
import statistics
import subprocess
import sys
import tempfile
import time

WIDTH, HEIGHT = 640, 480
LIMITS = [1, 2, 4, 8, 16, 32, 64]
# Seconds and frames of a run, least pixels of a picture that counts, new meshes for the cost of choosing.
RUN_SECONDS, LEAST_FRAMES, MOST_FRAMES, LEAST_PIXELS, CHOICES = 0.006, 3, 90, 500, 5
FOLDER = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "tests/data")
SOURCES = ["meshes", "formats/stl", "formats/ply", "x3d/x3d-cpp", "x3d/lecture-003", "x3d/x_ite"]
# A sky covers the frame, so that the pixels drawn on by objects are not known.
SKY = re.compile(rb"<(Texture)?Background\b")

PERSPECTIVE = "PERSPECTIVE 0.6 0.1 100\n"
TEAPOT = "LOOKAT 0 4 8 0 1 0 0 1 0\n" + PERSPECTIVE + "MESH m TEAPOT 6\n"
SUN = "LIGHT 0 DIR -0.3 -0.4 -1 1 1 1\n"
DULL, SHINY = "MATERIAL 0.1 0.1 0.1 0.7 0.5 0.3 0 0 0 1\n", "MATERIAL 0.1 0.1 0.1 0.6 0.6 0.5 0.4 0.4 0.4 32\n"
AROUND = [(4, 0), (2.828, 2.828), (0, 4), (-2.828, 2.828), (-4, 0), (-2.828, -2.828), (0, -4), (2.828, -2.828)]
EIGHT = "".join(
    f"LIGHT {i} POINT {x} {1 + 2 * (i % 3)} {z} {0.1 + 0.2 * (i % 2)} 0.2 {0.3 - 0.2 * (i % 2)}\n"
    for i, (x, z) in enumerate(AROUND)
)
DIM = "".join(f"LIGHT {i} DIR {i - 4} 1 -1 0.002 0.002 0.002\n" for i in range(1, 8))
FAR = "".join(f"LIGHT {i} POINT {30 + 10 * i} 20 10 0.5 0.5 0.5 1 0 1\n" for i in range(1, 8))
COLUMNS = "MESH floor BOX 8 0.2 8\nMESH m BOX 0.8 2.4 0.8\nLOOKAT 0.5 2.6 4.6 0 0.9 0 0 1 0\nPERSPECTIVE 0.9 0.1 100\n"
FIVE = "IDENTITY\nDRAW floor\n" + "".join(
    f"IDENTITY\nTRANSLATE {1.1 * x} 1.3 {-0.6 * abs(x)}\nROTATE 0 1 0 {0.4 * x}\nDRAW m\n" for x in range(-2, 3)
)
PICTURE = "P3 64 64 255 " + " ".join(
    f"{255 * ((x // 8 + y // 8) % 2)} {4 * x} {4 * y}" for y in range(64) for x in range(64)
)
# A box of 6x3x8 seen from inside, each wall with the whole texture six times.
CORNERS = "".join(f"v {x} {y} {z}\n" for x in (-3, 3) for y in (-1.5, 1.5) for z in (-4, 4))
WALLS = [(1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6)]
INSIDE = CORNERS + "vt 0 0\nvt 6 0\nvt 6 6\nvt 0 6\n" + "".join(
    "f " + " ".join(f"{v}/{t}" for t, v in enumerate(wall, 1)) + "\n" for wall in WALLS
)
ROOM = (
    f"TEX t :{len(PICTURE)}\n{PICTURE}MESH m OBJ :{len(INSIDE)}\n{INSIDE}CULL none\n"
    "LOOKAT -0.8 0.2 3.4 0.4 -0.5 0 0 1 0\nPERSPECTIVE 0.9 0.1 100\nLIGHT 0 POINT 1.5 1 1 0.6 0.6 0.6\n"
    "LIGHT 1 DIR 0.3 -1 -0.5 0.4 0.4 0.4\nMATERIAL 0.1 0.1 0.1 0.9 0.9 0.9 0 0 0 1\n"
)
KNOT = "LOOKAT 0 0 12 0 0 0 0 1 0\n" + PERSPECTIVE
MANY = "MESH m BOX 0.5 0.5 0.5\nLOOKAT 0 0 30 0 0 0 0 1 0\n" + PERSPECTIVE + SUN + DULL
GRID = "".join(
    f"IDENTITY\nTRANSLATE {0.75 * x - 11.6} {0.75 * y - 7} 0\nROTATE 1 1 0 {0.1 * x}\nDRAW m\n"
    for x in range(32) for y in range(20)
)
# Name: commands before the frames, and those of a frame after CLEAR.
MADE = {
    "teapot, 1 light": (TEAPOT + SUN + DULL, "DRAW m\n"),
    "teapot, shiny, 8 points": (TEAPOT + EIGHT + SHINY, "DRAW m\n"),
    "teapot, 1 light, 7 dim ones": (TEAPOT + SUN + DIM + DULL, "DRAW m\n"),
    "teapot, 1 light, 7 far ones": (TEAPOT + SUN + FAR + DULL, "DRAW m\n"),
    "columns, shiny, 8 points": (COLUMNS + EIGHT + SHINY, FIVE),
    "columns, 1 light": (COLUMNS + SUN + DULL, FIVE),
    "room, 2 lights, trilinear": (ROOM + "TEXTURE t trilinear\n", "DRAW m\n"),
    "knot of 30,000 faces, 1 light": ("MESH m KNOT 250 60\n" + KNOT + SUN + DULL, "DRAW m\n"),
    "knot of 30,000 faces, 8 points": ("MESH m KNOT 250 60\n" + KNOT + EIGHT + DULL, "DRAW m\n"),
    "640 small boxes, a DRAW each": (MANY, GRID),
}


class Server:
    """A server, and one connection to it."""

    def __init__(self, program, threads, simd="auto"):
        self.folder = tempfile.TemporaryDirectory(prefix="fbptr-bench-")
        path = os.path.join(self.folder.name, "socket")
        command = [program, "serve", "--headless", "--size", f"{WIDTH}x{HEIGHT}", "--unix", path, "--threads", threads]
        command += ["--simd", simd] if simd != "auto" else []
        self.process = subprocess.Popen([*command, "--load-dir", FOLDER], stderr=subprocess.DEVNULL)
        self.wire = socket.socket(socket.AF_UNIX)
        self.wire.settimeout(120)
        until = time.monotonic() + 30
        while True:
            try:
                self.wire.connect(path)
                break
            except (FileNotFoundError, ConnectionRefusedError):
                if time.monotonic() > until:
                    raise
                time.sleep(0.01)
        self.replies = self.wire.makefile("rb")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.wire.close()
        self.process.terminate()
        self.process.wait()
        self.folder.cleanup()

    def run(self, text):
        """Runs commands to their end; returns the seconds and the lines that came back."""
        data, lines, begun = (text + "SYNC end\n").encode(), [], time.perf_counter()
        self.wire.sendall(data)
        while (line := self.replies.readline()) != b"SYNC end\n":
            if not line:
                raise EOFError("the server ended")
            lines.append(line.decode().strip())
        return time.perf_counter() - begun, lines

    def picture(self, text):
        """Returns the pixels after these commands."""
        self.run(text)
        self.wire.sendall(f"READ 0 0 {WIDTH} {HEIGHT}\n".encode())
        header = self.replies.readline().decode()
        return self.replies.read(int(header.rsplit(":", 1)[1]))


def words(picture):
    return memoryview(picture).cast("I")


def error_of(exact, found, pixels, limit):
    """Returns the 99.9th percentile of the error over the pixels drawn on, and the share over the limit."""
    counts = [0] * 256
    for i in itertools.compress(range(WIDTH * HEIGHT), map(operator.ne, words(exact), words(found))):
        counts[max(abs(a - b) for a, b in zip(exact[4 * i : 4 * i + 3], found[4 * i : 4 * i + 3]))] += 1
    over, error = 0, 255
    while error > 0 and over + counts[error] <= 0.001 * pixels:
        over += counts[error]
        error -= 1
    return error, sum(counts[limit + 1 :]) / pixels


def pixels_drawn(server, exact, one):
    """Returns the number of pixels drawn on; `exact` is the picture of a frame's commands over black."""
    other = server.picture(one.replace("CLEAR 000000", "CLEAR ff00ff"))
    black, magenta = words(b"\0\0\0\xff")[0], words(b"\xff\0\xff\xff")[0]
    return sum(a != black or b != magenta for a, b in zip(words(exact), words(other)))


def chosen(program, setup, one):
    """Returns how the lit draws of a frame are lit, and from which E on, by the plans of its second drawing."""
    command = [program, "play", "-", "--headless", "--explain", "--size", f"{WIDTH}x{HEIGHT}", "--load-dir", FOLDER]
    names, last, changes = {"faces": "flat", "vertices": "Gouraud", "pixels": "Phong"}, None, []
    for e in [0, *LIMITS]:
        stream = (setup + f"QUALITY max-error {e}\n" + one + one).encode()
        plans = subprocess.run(command, input=stream, capture_output=True, check=False).stdout.decode(errors="replace")
        lit = re.findall(r"\+ light (faces|vertices|pixels) .*?(?:(\d+) lights)?$", plans, re.MULTILINE)
        ways = ", ".join(sorted({names[what] + (f" {lights}" if lights else "") for what, lights in lit})) or "unlit"
        if ways != last:
            changes.append(f"E {e}: {ways}" if e else ways)
        last = ways
    return "; ".join(changes)


def measured(server, setup, one, rounds):
    """Returns the milliseconds of an exact frame, the pixels drawn on, the cost of choosing, and a row of speed, error
    and share for each E; None if nothing is seen."""
    _, refused = server.run(setup)
    if refused:
        return None
    exact = server.picture("QUALITY exact\n" + one)
    pixels = pixels_drawn(server, exact, one)
    if pixels < LEAST_PIXELS:
        return None
    server.run(one * 10)
    frames = max(LEAST_FRAMES, min(MOST_FRAMES, round(RUN_SECONDS * 10 / server.run(one * 10)[0])))
    texts = [f"QUALITY max-error {e}\n" for e in LIMITS]
    errors = [error_of(exact, server.picture(text + one * 3), pixels, e) for e, text in zip(LIMITS, texts)]
    ratios, milliseconds = [[] for _ in LIMITS], []
    for i in range(rounds):
        for text, own in zip(texts, ratios):
            # Each goes first in every other round.
            pair = ["QUALITY exact\n", text][:: 1 - 2 * (i % 2)]
            exact_time, time_within = [server.run(quality + one * frames)[0] for quality in pair][:: 1 - 2 * (i % 2)]
            own.append(exact_time / time_within)
            milliseconds.append(exact_time / frames * 1e3)
    costs = []
    for text in texts:
        each = []
        for _ in range(CHOICES):
            server.run(setup + text + one)
            second, third = server.run(one)[0], min(server.run(one)[0] for _ in range(3))
            each.append((second - third) / min(server.run("QUALITY exact\n" + one)[0] for _ in range(3)))
        costs.append(statistics.median(each))
    rows = [(statistics.median(own), *error) for own, error in zip(ratios, errors)]
    return statistics.median(milliseconds), pixels, max(costs), rows


def scenes(paths):
    """Iterates over names, commands before the frames, and commands of a frame."""
    if not paths:
        yield from ((name, setup, frame) for name, (setup, frame) in MADE.items())
        for folder, _, names in sorted(itertools.chain(*(os.walk(os.path.join(FOLDER, source)) for source in SOURCES))):
            paths += [os.path.join(folder, n) for n in sorted(names) if n.endswith((".obj", ".stl", ".ply", ".x3d"))]
    for path in paths:
        name = os.path.relpath(path, FOLDER)
        if not path.endswith(".x3d"):
            yield name, f"LOAD MESH m {name}\n", "DRAW m\n"
        else:
            with open(path, "rb") as file:
                if not SKY.search(file.read()):
                    yield name, f"LOAD SCENE {name}\n", "DRAWSCENE\n"


def main():
    """Prints the table and its summary."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("program")
    parser.add_argument("files", nargs="*")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--threads", default="1")
    options = parser.parse_args()
    program = os.path.abspath(options.program)
    print(f"| scene | pixels | exact ms | choosing | {' | '.join(f'E {e}' for e in LIMITS)} | lit by (lights) |")
    print(f"|---|---:|---:|---:|{'---:|' * len(LIMITS)}---|")
    every, broken = [], []
    for name, setup, frame in scenes([os.path.abspath(f) for f in options.files]):
        one = "CLEAR 000000\n" + frame
        with Server(program, options.threads) as server:
            found = measured(server, setup, one, options.rounds)
        if found is None:
            print(f"{name}: not drawn", file=sys.stderr)
            continue
        ms, pixels, choosing, rows = found
        ways = chosen(program, setup, one)
        cells = " | ".join(f"{speed:.2f}" + (f" ({error})" if error else "") for speed, error, _ in rows)
        print(f"| {name} | {pixels:,} | {ms:.3f} | {choosing:.2f} | {cells} | {ways} |", flush=True)
        every.append((choosing, rows))
        broken += [f"{name} at {e}: {s:.2%} over it" for e, (_, _, s) in zip(LIMITS, rows) if s > 0.001]
    for i, e in enumerate(LIMITS):
        speeds = sorted(rows[i][0] for _, rows in every)
        fast = f"{sum(s >= 1.3 for s in speeds)} at least 1.3, {sum(s >= 1.6 for s in speeds)} at least 1.6 times as fast"
        print(f"E {e}: of {len(speeds)} {fast}; median {statistics.median(speeds):.2f}, least {speeds[0]:.2f}")
    print(f"choosing: median {statistics.median(c for c, _ in every):.2f}, most {max(c for c, _ in every):.2f} frames")
    print("\n".join(broken) or "no picture has more than 0.1 % of its pixels over E")
    sys.exit(1 if broken else 0)


if __name__ == "__main__":
    main()
