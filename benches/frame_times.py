#!/usr/bin/env python3
"""Frame times of what users draw, for one build of fbptr or several, as a Markdown table.

    python3 benches/frame_times.py target/release/fbptr [OTHER/fbptr ...]

In: programs that have `--frame-times` (`play`, `view`) and `p99_ms` (`bench --json`). Out: a row for
each picture and size with median and 99th percentile of a frame in milliseconds, for each build the
medians of the rounds; with several builds the ratio of the first one's median to the last one's:
the median of the rounds' own ratios, least and largest in brackets. The builds take turns in each
round, each round in the other order, so that slow minutes affect all of them. Of less than 100
frames the 99th percentile is the longest.

- `play`: time between two PRESENTs, decoding of the stream included, without a window. The tour's
  own frames, several times over; a room, whose walls have a texture, with the camera turning.
- `view --turntable`: the step of the scene and the drawing of the frame, without a window.
- `bench`: the frames of S1 to S7, each picture compared with its truth before; 1920x1080, and
  7680x4320 for S5.

The last pictures of streams and models must have the same bytes in every build, or the script ends.
"""

import argparse
import hashlib
import json
import math
import os
import re
import shutil
import statistics
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
MESHES = os.path.join(ROOT, "tests/data/meshes")
LINE = re.compile(r"frames: median ([\d.]+) ms, 99th percentile ([\d.]+) ms")
SIZES = ["1280x720", "1920x1080"]


def tour(times):
    """Returns the tour's commands, so many times over; only the first may set the frame's size."""
    with open(os.path.join(ROOT, "demos/tour.fbs"), "rb") as file:
        lines = [line for line in file.read().splitlines(True) if not line.startswith(b"QUIT")]
    again = [line for line in lines if not line.startswith(b"SIZE")]
    return b"".join(lines + again * (times - 1))


def room(frames):
    """Returns a stream that looks around in a textured room."""
    lines = """AUTO off
LOAD TEX wall spot_texture.png
LOAD MESH spot spot_control_mesh.obj
LOAD MESH room walls.obj
MESH box BOX 1 1 1
PERSPECTIVE 1.2 0.1 40
AMBIENT 1 1 1
LIGHT 0 POINT 0 1.5 0 1 1 1
MATERIAL .3 .3 .3 .7 .7 .7 .2 .2 .2 20
SHADE phong
CULL none
TEXTURE wall trilinear""".split("\n")
    for frame in range(frames):
        angle = 2 * math.pi * frame / 240
        lines += ["CLEAR", f"LOOKAT 0 0 0 {math.cos(angle):.6f} -.1 {math.sin(angle):.6f} 0 1 0"]
        lines += ["IDENTITY", "DRAW room"]
        for i in range(12):
            turn = 2 * math.pi * i / 12
            place = f"TRANSLATE {2.8 * math.cos(turn):.4f} -1 {2.8 * math.sin(turn):.4f}"
            lines += ["IDENTITY", place, f"DRAW {'spot' if i % 3 == 0 else 'box'}"]
        lines.append("PRESENT")
    return "\n".join(lines).encode() + b"\n"


def walls(path):
    """Writes the walls of a room of 8 by 4 by 8 as OBJ, with normals to its inside."""
    with open(path, "w", encoding="ascii") as file:
        file.write("vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n")
        for face in range(6):
            axis, sign = face // 2, 1 - face % 2 * 2
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                place = [a * sign, b]
                place.insert(axis, sign)
                file.write("v %d %d %d\n" % (4 * place[0], 2 * place[1], 4 * place[2]))
            normal = [0, 0, 0]
            normal[axis] = -sign
            file.write("vn %d %d %d\n" % tuple(normal))
            file.write("f " + " ".join(f"{4 * face + k}/{k}/{face + 1}" for k in (1, 2, 3, 4)) + "\n")


def knot(path, around, across):
    """Writes a torus knot of 2 * around * across triangles as OBJ, with normals."""
    with open(path, "w", encoding="ascii") as file:
        for i in range(around):
            t = 2 * math.pi * i / around
            r = 2 + math.cos(3 * t)
            centre = (r * math.cos(2 * t), r * math.sin(2 * t), math.sin(3 * t))
            for j in range(across):
                s = 2 * math.pi * j / across
                out = (math.cos(2 * t) * math.cos(s), math.sin(2 * t) * math.cos(s), math.sin(s))
                file.write("v %.6f %.6f %.6f\n" % tuple(c + 0.45 * o for c, o in zip(centre, out)))
                file.write("vn %.5f %.5f %.5f\n" % out)
        corner = lambda i, j: "{0}//{0}".format(i % around * across + j % across + 1)
        for i in range(around):
            for j in range(across):
                a, b, c, d = corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)
                file.write(f"f {a} {b} {c}\nf {a} {c} {d}\n")


def rows(folder):
    """Writes the streams and models into `folder`, and returns the rows: name and arguments."""
    streams = {"tour": tour(12), "room": room(240)}
    for name, body in streams.items():
        with open(os.path.join(folder, name + ".fbs"), "wb") as file:
            file.write(body)
    # The teapot as a stream that `view` turns.
    with open(os.path.join(folder, "teapot.fbs"), "w", encoding="ascii") as file:
        file.write("MESH pot TEAPOT 12\nLIGHT 0 DIR -1 -1 -1 1 1 1\nDRAW pot\n")
    knot(os.path.join(folder, "knot.obj"), 10000, 50)
    place = lambda name: os.path.join(folder, name)
    found = [("tour, 480x360", ["play", place("tour.fbs"), "--headless", "--size", "480x360"])]
    walls(place("walls.obj"))
    for name in ("spot_texture.png", "spot_control_mesh.obj"):
        shutil.copy(os.path.join(MESHES, "spot", name), folder)
    models = {
        "teapot": place("teapot.fbs"),
        "Suzanne": os.path.join(MESHES, "suzanne-sphere/monkey_head2.obj"),
        "1,000,000 faces": place("knot.obj"),
    }
    for size in SIZES:
        for name, path in models.items():
            frames = "60" if "000" in name else "300"
            found.append(
                (f"viewer, {name}, {size}", ["view", path, "--headless", "--turntable", "--frames", frames, "--size", size])
            )
        found.append((f"room, {size}", ["play", place("room.fbs"), "--headless", "--load-dir", folder, "--size", size]))
    for name in "S1_room S2_layers64 S3_objects10k S3_scene10k S4_mesh4M S5_sizes S6_lights S7_hidden".split():
        size = "7680x4320" if name == "S5_sizes" else "1920x1080"
        found.append((f"`{name}`, {size}", ["bench", name, "--json", "--frames", "100"]))
    return found


def run(build, arguments, threads, simd, snap):
    """Returns median and 99th percentile in milliseconds, and the digest of the last picture."""
    command = [build, *arguments, "--threads", str(threads), "--simd", simd]
    is_bench = arguments[0] == "bench"
    command += [] if is_bench else ["--frame-times", "--snap", snap]
    done = subprocess.run(["taskset", "-c", "0"] * (threads == 1) + command, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(command)}: status {done.returncode}\n{done.stderr[-2000:]}")
    if is_bench:
        found = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
        found = [(row["med_ms"], row.get("p99_ms", float("nan"))) for row in found]
    else:
        found = [tuple(map(float, times)) for times in LINE.findall(done.stderr)]
    if len(found) != 1:
        sys.exit(f"{' '.join(command)}: {len(found)} rows of times\n{done.stderr[-2000:]}")
    if is_bench:
        return *found[0], None
    with open(snap, "rb") as file:
        return *found[0], hashlib.sha256(file.read()).hexdigest()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("builds", nargs="+")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--simd", default="auto")
    parser.add_argument("--only", default="", help="rows whose names contain this")
    given = parser.parse_args()
    if given.rounds < 1:
        parser.error("--rounds: at least one")
    for build in given.builds:
        if not os.access(build, os.X_OK):
            parser.error(f"{build}: no program")
    has_ratio = len(given.builds) > 1
    ratio = " ratio (least to largest) |" if has_ratio else ""
    print("| frame |" + "".join(f" `{build}`: median | 99th |" for build in given.builds) + ratio)
    print("|---|" + "---:|" * (2 * len(given.builds) + has_ratio))
    with tempfile.TemporaryDirectory() as folder:
        chosen = [row for row in rows(folder) if given.only in row[0]]
        if not chosen:
            parser.error(f"--only: no row has {given.only!r} in its name")
        for name, arguments in chosen:
            measure(name, arguments, given, os.path.join(folder, "last.ppm"))


def measure(name, arguments, given, snap):
    """Prints the row of one picture."""
    builds = list(range(len(given.builds)))
    times = [[] for _ in builds]
    for turn in range(given.rounds):
        for build in builds if turn % 2 == 0 else builds[::-1]:
            times[build].append(run(given.builds[build], arguments, given.threads, given.simd, snap))
    if len({picture for found in times for *_, picture in found}) != 1:
        sys.exit(f"{name}: the pictures differ")
    line = f"| {name} |"
    for found in times:
        line += "".join(f" {statistics.median(time[i] for time in found):.2f} |" for i in (0, 1))
    if len(builds) > 1:
        ratios = sorted(first[0] / last[0] for first, last in zip(times[0], times[-1]))
        line += f" {statistics.median(ratios):.2f} ({ratios[0]:.2f} to {ratios[-1]:.2f}) |"
    print(line, flush=True)


if __name__ == "__main__":
    main()
