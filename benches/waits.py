#!/usr/bin/env python3
"""Measures the wait of one client's SYNC while another client keeps the server busy.

In: the path of an `fbptr` program. Out: a Markdown table, one row per attack: the median, the 99th
percentile and the worst wait of up to 200 SYNC, the attacker's commands meanwhile, and the time
from SIGTERM to the end of the process in the middle of the attack.

Each attack runs against a server of its own (`serve --headless`, Unix socket in a temporary
folder), in a process of its own, and is bounded by --seconds. No port is opened and nothing is
left behind. The waits are taken by the clock of the asking client, so they include the scheduling
of the machine: run it with nothing else at work.

    python3 benches/waits.py target/release/fbptr
    python3 benches/waits.py target/release/fbptr --size 7680x4320 --only fill,read,snap
"""

import argparse
import math
import multiprocessing
import os
import random
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
import zlib


def payload(head, data):
    return f"{head} :{len(data)}\n".encode() + data


def png_gray(side):
    """Returns a PNG of side x side gray pixels, which decodes to side * side * 4 bytes."""
    def chunk(kind, data):
        crc = zlib.crc32(kind + data)
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", crc)
    packer = zlib.compressobj(1)
    rows = b"".join(packer.compress(bytes(side + 1)) for _ in range(side)) + packer.flush()
    head = struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")


def obj_grid(side):
    """Returns an OBJ file of side x side quads."""
    lines = [f"v {x} {y} {x * y % 7}" for y in range(side + 1) for x in range(side + 1)]
    n = side + 1
    for y in range(side):
        for x in range(side):
            a = y * n + x + 1
            lines.append(f"f {a} {a + 1} {a + n + 1} {a + n}")
    return ("\n".join(lines) + "\n").encode()


def x3d_grid(side):
    """Returns an X3D scene of one grid of side x side quads."""
    heights = " ".join(str((i * 7 % 11) / 10) for i in range(side * side))
    return (
        f'<X3D><Scene><Shape><ElevationGrid xDimension="{side}" zDimension="{side}" '
        f'height="{heights}"/></Shape></Scene></X3D>'
    ).encode()


def noise(width, height):
    """Returns BLIT commands that fill the frame with noise."""
    rng = random.Random(1)
    rows = 64
    out = []
    for y in range(0, height, rows):
        h = min(rows, height - y)
        out.append(payload(f"BLIT 0 {y} {width} {h}", rng.randbytes(width * h * 4)))
    return b"".join(out)


def star(points, width, height):
    """Returns a FILLPOLY of this many points across the frame, within a line's 4096 bytes."""
    rng = random.Random(2)
    words = ["FILLPOLY", "ff0000"]
    length = len(" ".join(words))
    for i in range(points):
        pair = f"{rng.randrange(width)} {0 if i % 2 else height}"
        length += len(pair) + 1
        if length > 4090:
            break
        words.append(pair)
    return (" ".join(words) + "\n").encode()


BALL = b"LIGHT 0 DIR 0 0 -1 1 1 1\nLOOKAT 0 0 6 0 0 0 0 1 0\nMESH m KNOT 2000 1000\n"


def layers(count):
    """Returns an OBJ file of triangles that fill the view, from far to near."""
    faces = (f"v -90 -60 {i / count}\nv 90 -60 {i / count}\nv 0 99 {i / count}\nf -3 -2 -1\n" for i in range(count))
    return "".join(faces).encode()


LAYERS = b"LIGHT 0 DIR 0 0 -1 1 1 1\nLOOKAT 0 0 6 0 0 0 0 1 0\nCULL none\n" + payload("MESH m OBJ", layers(10_000))

# One unit is a pixel of a frame of 1920x1080.
PIXELS = b"CULL none\nORTHO -960 960 -540 540 0.1 100\nLOOKAT 0 0 10 0 0 0 0 1 0\n"
SUN, TRANSPARENT = b"LIGHT 0 DIR 0 0 -1 1 1 1\n", b"MATERIAL black #cc black 1 black .5\n"
SPOTS = b"".join(b"LIGHT %d SPOT %d 3 300 0 0 -1 1.2 7.3 .1 .1 .1 1 .001 .0001\n" % (i, i % 7) for i in range(250))
# A draw beside the view, which is short, and one of the same mesh in it: the time of the first says nothing of the
# second.
SHORT, LONG = (f"CLEAR\nIDENTITY\nTRANSLATE {x} 0 0\nDRAW m\n".encode() for x in (5000, 0))
UNLIT, LIT = b"MATERIAL black black black 1 white\n", b"MATERIAL #111111 #cccccc black 1\n"


def slivers(count, slope):
    """Returns an OBJ file of triangles across the frame that are 0.02 pixels high."""
    faces = []
    for i in range(count):
        y, z = i % 1000 - 499.5, i * 1e-5
        corners = [(-950, y - slope / 2 - 0.008), (0, y + 0.012), (950, y + slope / 2 - 0.008)]
        faces += [f"v {x} {v} {z}\n" for x, v in corners] + ["f -3 -2 -1\n"]
    return "".join(faces).encode()


def textured_layers(count):
    """Returns an OBJ file of quads across the frame with many texels a pixel, and tiny faces."""
    faces = [f"v 0 0 {i * 1e-6}\nv .01 0 0\nv 0 .01 0\nvt 0 0\nf -3/-1 -2/-1 -1/-1\n" for i in range(1300)]
    for i in range(count):
        faces += [f"v {x} {y} {i * 1e-3}\n" for x, y in [(-480, -300), (480, -300), (480, 300), (-480, 300)]]
        faces.append(f"vt 0 0\nvt {20 + i} 3\nvt {10 + i} 17\nvt 0 9\nf -4/-4 -3/-3 -2/-2 -1/-1\n")
    return "".join(faces).encode()


def fan(corners, radius):
    """Returns an OBJ file of one polygon."""
    angles = [2 * math.pi * i / corners for i in range(corners)]
    lines = [f"v {radius * math.cos(a)} {radius * math.sin(a)} 0" for a in angles]
    return ("\n".join(lines) + "\nf " + " ".join(str(i + 1) for i in range(corners)) + "\n").encode()


def equal_faces(count, corners):
    """Returns an OBJ file of one triangle again and again."""
    return ("".join(f"v {x} {y} 0\n" for x, y in corners) + "f 1 2 3\n" * count).encode()


SMALL_FACE, LARGE_FACE = [(0, 0), (1, 0), (0, 1)], [(-90, -60), (90, -60), (0, 99)]
VIEW = b"LIGHT 0 DIR 0 0 -1 1 1 1\nLOOKAT 0 0 6 0 0 0 0 1 0\nCULL none\n"
ONE_FACE = payload("MESH m OBJ", equal_faces(1, SMALL_FACE)) + b"SHADE wire\n"
# A curve of the most steps that one may have, and so wide that it covers each row.
BEZIER = b"BEZIER -1e6 1e6 1e6 -1e6 -1e6 1e6 1e6 -1e6 %s white\n"


def canvas(side):
    return f"CANVAS k {side} {side}\nTARGET k\n".encode()


def spokes(verb, side, count):
    """Returns lines from the top to the bottom of a canvas; those of POLY within a line's 4096 bytes."""
    if verb == "LINE":
        return b"".join(f"LINE {i * 7 % side} 0 {i * 11 % side} {side} red\n".encode() for i in range(count))
    return f"{verb} red {' '.join(f'{i * 7 % side} {side * (i % 2)}' for i in range(count))}"[:4000].encode() + b" 0\n"


FAR_FILL = b"FILL -1e300 -1e300 1e300 0 0 1e299 ff0000 00ff00 0000ff\n"

QUALITY = (
    b"LIGHT 0 DIR 0 0 -1 1 1 1\nLIGHT 1 POINT 3 3 3 1 0 0\nLOOKAT 0 0 6 0 0 0 0 1 0\n"
    b"MESH m KNOT 300 60\nSHADE phong\nQUALITY max-error 4\n"
)


def attacks(width, height, folder, program=""):
    """Returns a dict of name to the functions for bytes sent once and bytes sent repeatedly."""
    fill = f"FILL 0 0 {2 * width} 0 0 {2 * height} ff0000 00ff00 0000ff\n".encode()
    over = b"BLEND over\n" + fill.replace(b"ff0000", b"ff000080")
    name = "big.obj"

    def with_file():
        with open(os.path.join(folder, name), "wb") as out:
            out.write(obj_grid(700))
        return b""

    def eye():
        made = subprocess.run([program, "eye", "--make", "tesseract"], capture_output=True, check=True)
        return payload("EYE e", made.stdout) + b"\n"

    return {
        "none": (lambda: b"", lambda: b"SIZE\n"),
        "clear": (lambda: b"", lambda: b"CLEAR 102030\n"),
        "fill": (lambda: b"", lambda: fill),
        "fill-over": (lambda: over, lambda: fill),
        "fill-far": (lambda: b"", lambda: FAR_FILL),
        "fillpoly": (lambda: b"", lambda: star(2000, width, height)),
        "fillcircle": (lambda: b"BLEND over\n", lambda: f"FILLCIRCLE 9 9 {2 * width} ff000080\n".encode()),
        "copy": (lambda: b"", lambda: f"COPY 0 0 {width - 3} {height - 3} 3 3\n".encode()),
        "text": (lambda: b"", lambda: payload("TEXT 0 0 ff0000", b"W" * (32 << 20))),
        "points": (lambda: b"", lambda: payload("POINTS", points(width, height, 4 << 20))),
        "read": (lambda: b"", lambda: f"READ 0 0 {width} {height}\n".encode()),
        "peek": (lambda: b"", lambda: f"PEEK 0 {width * height * 4}\n".encode()),
        "crc": (lambda: b"", lambda: b"CRC\n"),
        "snap": (lambda: noise(width, height), lambda: b"SNAP :\n"),
        "mesh-obj": (lambda: b"", lambda: payload("MESH m OBJ", obj_grid(700))),
        "mesh-knot": (lambda: b"", lambda: b"MESH m KNOT 2000 1000\n"),
        "load": (with_file, lambda: f"LOAD MESH m {name}\n".encode()),
        "tex": (lambda: b"", lambda: payload("TEX t", png_gray(8192))),
        "scene": (lambda: b"", lambda: payload("SCENE X3D", x3d_grid(500))),
        "free": (lambda: b"", lambda: b"MESH m KNOT 2000 1000\nFREE m\n"),
        "quality": (lambda: QUALITY, lambda: b"ROTATE 0 1 0 0.01\nDRAW m\n"),
        "draw": (lambda: BALL, lambda: b"DRAW m\n"),
        "first-draw": (lambda: BALL, lambda: b"MESH m KNOT 2000 1000\nDRAW m\n"),
        "gouraud": (lambda: BALL + b"SHADE gouraud\n", lambda: b"DRAW m\n"),
        "layers": (lambda: LAYERS, lambda: b"DRAW m\n"),
        "transparent": (lambda: LAYERS + b"MATERIAL black #cc black 1 black .5\n", lambda: b"DRAW m\n"),
        "drawscene": (lambda: payload("SCENE X3D", x3d_grid(1000)), lambda: b"DRAWSCENE\n"),
        "draweye": (eye, lambda: f"DRAWEYE e 0 0 {width} {height}\n".encode()),
        "painter": (lambda: BALL + b"HIDE painter\n", lambda: b"DRAW m\n"),
        "wire": (lambda: BALL + b"SHADE wire\n", lambda: b"DRAW m\n"),
        "canvas": (lambda: b"", lambda: b"CANVAS k 16000 16000\n"),
        "leave": (lambda: b"", lambda: canvas(11200) + b"CLEAR red\n"),
        "stamp-own": (lambda: canvas(11200), lambda: b"STAMP k 3 3\n"),
        "stamp": (lambda: b"CANVAS a 8000 8000\n" + canvas(8000), lambda: b"STAMP a 3 3\n"),
        "wire-canvas": (lambda: ONE_FACE, lambda: canvas(8000) + b"DRAW m\n"),
        "wire-narrow": (lambda: ONE_FACE + b"DEPTH u16\n", lambda: canvas(8000) + b"DEPTH u16\nDRAW m\n"),
        "clip-clear": (
            lambda: canvas(8000) + ONE_FACE + b"DRAW m\n", lambda: b"CLIP 1 1 9000 9000\nCLEAR\nCLIP OFF\nCLEAR\n",
        ),
        "equal-faces": (lambda: payload("MESH m OBJ", equal_faces(2_000_000, SMALL_FACE)), lambda: b"CLEAR\nDRAW m\n"),
        "faces-of-own": (lambda: payload("MESH m OBJ", layers(600_000)), lambda: b"CLEAR\nDRAW m\n"),
        "equal-wire": (
            lambda: VIEW + b"SHADE wire\n" + payload("MESH m OBJ", equal_faces(2_000_000, LARGE_FACE)),
            lambda: b"DRAW m\n",
        ),
        "bezier": (lambda: b"", lambda: BEZIER % b"3"),
        "bezier-wide": (lambda: b"", lambda: BEZIER % b"1e308"),
        "lines-canvas": (lambda: canvas(11200), lambda: spokes("LINE", 11200, 1000)),
        "poly-canvas": (lambda: canvas(11200), lambda: spokes("POLY", 11200, 900)),
        "fill-canvas": (lambda: canvas(11200) + over, lambda: b"FILL 0 0 0 30000 30000 0 red lime #0000ff80\n"),
        "blit-canvas": (lambda: canvas(4096), lambda: payload("BLIT 0 0 4096 4096", bytes(64 << 20))),
        "pxmulti-canvas": (
            lambda: canvas(4096), lambda: b"PXMULTI" + struct.pack("<HHI", 0, 0, 16 << 20) + bytes(64 << 20),
        ),
        "image-canvas": (lambda: canvas(8192), lambda: payload("IMAGE 0 0", png_gray(8192))),
        "peek-canvas": (lambda: canvas(8192), lambda: b"PEEK 0 33000000\n"),
        "short-slivers": (
            lambda: PIXELS + SUN + TRANSPARENT + payload("MESH m OBJ", slivers(6000, 0)),
            lambda: SHORT + LONG,
        ),
        "short-diagonals": (lambda: PIXELS + SUN + payload("MESH m OBJ", slivers(9000, 900)), lambda: SHORT + LONG),
        "short-far-light": (
            lambda: PIXELS + SPOTS + b"LIGHT 250 POINT 1e200 0 0 1 1 1\n" + payload("MESH m OBJ", obj_grid(30)),
            lambda: SHORT + b"CLEAR\nIDENTITY\nSCALE 7 7 1\nDRAW m\n",
        ),
        "short-texture": (
            lambda: PIXELS + b"AMBIENT 1 1 1\n" + TRANSPARENT + payload("TEX t", png_gray(1024))
            + b"TEXTURE t trilinear\n" + payload("MESH m OBJ", textured_layers(12)),
            lambda: SHORT + LONG,
        ),
        "short-unlit": (
            lambda: PIXELS + SUN,
            lambda: payload("MESH m OBJ", obj_grid(300)) + UNLIT + SHORT + LIT + LONG,
        ),
        "short-flat": (
            lambda: PIXELS + SPOTS + b"SHADE flat\n" + payload("MESH m OBJ", fan(40_000, 150)),
            lambda: UNLIT + SHORT + LIT + LONG,
        ),
    }


NAMES = list(attacks(9, 9, ""))


def points(width, height, count):
    rng = random.Random(3)
    some = b"".join(
        struct.pack("<HH", rng.randrange(width), rng.randrange(height)) + rng.randbytes(4)
        for _ in range(1 << 16)
    )
    return some * (count >> 16)


def connect(path):
    wire = socket.socket(socket.AF_UNIX)
    wire.connect(path)
    return wire


def read_until(wire, mark):
    tail = b""
    while not tail.endswith(mark):
        data = wire.recv(1 << 20)
        if not data:
            raise EOFError
        tail = (tail + data)[-len(mark):] if len(data) < len(mark) else data[-len(mark):]


def attack(path, once, again, seconds, pipe, leaves=False):
    """Runs the attacker in a process of its own, for each round on a connection of its own if it `leaves`; reports
    the number of its rounds at the end."""
    wire, rounds = connect(path), 0
    try:
        wire.sendall(once + b"SYNC begin\n")
        read_until(wire, b"SYNC begin\n")
        pipe.send("ready")
        until = time.monotonic() + seconds
        while time.monotonic() < until and not pipe.poll():
            if leaves:
                wire.close()
                wire = connect(path)
            wire.sendall(again + b"SYNC round\n")
            read_until(wire, b"SYNC round\n")
            rounds += 1
    except (OSError, EOFError):
        pass
    pipe.send(rounds)


def measure(program, size, name, syncs, seconds, threads):
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "s")
        width, height = map(int, size.split("x"))
        command = [program, "serve", "--headless", "--size", size, "--unix", path, "--load-dir", folder]
        if threads:
            command += ["--threads", str(threads)]
        server = subprocess.Popen(command, stderr=subprocess.DEVNULL)
        try:
            while not os.path.exists(path):
                time.sleep(0.01)
            first, again = attacks(width, height, folder, program)[name]
            here, there = multiprocessing.Pipe()
            worker = multiprocessing.Process(target=attack, args=(path, first(), again(), seconds + 60, there, name == "leave"))
            worker.start()
            here.recv()
            time.sleep(0.05)
            wire, waits, until = connect(path), [], time.monotonic() + seconds
            rng = random.Random(4)
            while len(waits) < syncs and time.monotonic() < until:
                begun = time.monotonic()
                wire.sendall(b"SYNC me\n")
                read_until(wire, b"SYNC me\n")
                waits.append((time.monotonic() - begun) * 1e3)
                time.sleep(rng.uniform(0.001, 0.01))
            begun = time.monotonic()
            server.send_signal(signal.SIGTERM)
            server.wait(60)
            ended = time.monotonic() - begun
            here.send("stop")
            rounds = here.recv()
            worker.join(70)
            return waits, rounds, ended, server.returncode
        finally:
            if server.poll() is None:
                server.kill()
                server.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program")
    parser.add_argument("--size", default="1920x1080")
    parser.add_argument("--only", help="names of attacks, with commas between")
    parser.add_argument("--syncs", type=int, default=200)
    parser.add_argument("--seconds", type=float, default=15)
    parser.add_argument("--threads", type=int)
    args = parser.parse_args()
    names = args.only.split(",") if args.only else NAMES
    print(f"| attack, {args.size} | SYNCs | p50 ms | p99 ms | worst ms | rounds | SIGTERM s | status |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|")
    for name in names:
        waits, rounds, ended, status = measure(
            args.program, args.size, name, args.syncs, args.seconds, args.threads
        )
        waits.sort()
        at = lambda q: waits[max(0, math.ceil(q * len(waits)) - 1)]
        print(
            f"| {name} | {len(waits)} | {at(0.5):.2f} | {at(0.99):.1f} | {waits[-1]:.1f} | {rounds} "
            f"| {ended:.2f} | {status} |",
            flush=True,
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
