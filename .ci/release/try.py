"""Tries a program of any system: its pictures, a server with a real client, the prompt, the shared file.

    python3 .ci/release/try.py COMMAND ...       for example: wine target/packed/x86_64-pc-windows-gnu/fbptr.exe

In: the words that start the program, in the repository's folder (or with TRY_ROOT in a folder that has `tests/data`). Out: a
line for each thing that was seen to work; the first that does not ends with status 1. Right is: the same bytes as the golden
pictures and as what the program itself says through another door.
"""

import json
import os
import pathlib
import re
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import zlib

COMMAND = sys.argv[1:]
# Programs of other systems start slowly under an emulator.
PATIENCE_S = 120
RELEASES = sorted(pathlib.Path("tests/data/releases").glob("*/*.fbs"))
SCENES = [
    ("tests/data/x3d/x3d-cpp/lit_scene.x3d", "tests/data/x3d/golden/x3d-cpp-lit_scene-at-0.png", []),
    ("tests/data/x3d/x3d-cpp/demos/anim_dvd.x3d", "tests/data/x3d/golden/x3d-cpp-demos-anim_dvd-at-1.png", ["--time", "1"]),
    ("tests/data/formats/gltf/skin.glb", "tests/data/formats/golden/gltf-skin-glb-at-0.6.png", ["--time", "0.6"]),
]


def run(*arguments, data=b"", status=0):
    """Runs the program to its end, and returns what it printed on both streams."""
    done = subprocess.run([*COMMAND, *map(str, arguments)], input=data, capture_output=True, timeout=PATIENCE_S)
    said = done.stdout.decode(errors="replace"), done.stderr.decode(errors="replace")
    assert done.returncode == status, f"{arguments}: status {done.returncode}\n{said[0]}{said[1]}"
    return said


def checksum_of(ppm):
    """Returns the checksum of the RGBA bytes of an opaque frame that is a PPM file."""
    magic, width, height, _, pixels = ppm.split(maxsplit=4)
    assert magic == b"P6"
    count = int(width) * int(height)
    # The pixels may begin with bytes that are blanks.
    pixels = ppm[len(ppm) - count * 3:]
    rgba = bytearray(b"\xff" * (count * 4))
    for channel in range(3):
        rgba[channel::4] = pixels[channel::3]
    return f"{zlib.crc32(rgba):08x}"


def pictures():
    for stream in RELEASES:
        run("play", stream, "--headless", "--expect", stream.with_suffix(".png"))
    print(f"play: {len(RELEASES)} streams of releases, the same bytes")
    for scene, golden, more in SCENES:
        run("render", scene, "--size", "120x90", *more, "--expect", golden)
    print(f"render: {len(SCENES)} golden pictures, the same bytes")


def prompt(folder):
    picture = folder / "draw.ppm"
    said = run("draw", "--headless", "--size", "64x48", "--snap", picture, data=b"CLEAR navy\nCIRCLE 32 24 20 gold\nCRC\n")
    found = re.search(r"CRC ([0-9a-f]{8})", said[0] + said[1])
    assert found and found[1] == checksum_of(picture.read_bytes()), said
    print(f"draw: CRC {found[1]}, as in the picture that it wrote")


class Server:
    """A server of the program, with what it says on its way."""

    def __init__(self, *arguments):
        words = [*COMMAND, "serve", "--headless", "--size", "160x120", "--listen", "127.0.0.1:0", *map(str, arguments)]
        self.process = subprocess.Popen(words, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL)
        self.said, self.port, has_port = "", None, threading.Event()

        def read():
            for line in self.process.stderr:
                self.said += line.decode(errors="replace")
                found = re.search(r"listening on tcp \S+:(\d+)", self.said)
                if found:
                    self.port = int(found[1])
                    has_port.set()

        threading.Thread(target=read, daemon=True).start()
        assert has_port.wait(PATIENCE_S), self.said

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait(PATIENCE_S)


def serve(folder):
    shared = folder / "frame"
    with Server("--shm", shared) as server:
        with socket.create_connection(("127.0.0.1", server.port), PATIENCE_S) as link, link.makefile("rb") as replies:
            link.sendall(b"CLEAR navy\nFILL 10 10 150 20 80 110 red lime blue\nTEXT 8 8 white :5\nhello"
                         b"PB" + struct.pack("<HH4B", 3, 4, 1, 2, 3, 255) + b"HELLO\nCRC\nREAD 0 0 160 120\n")
            hello, crc, read = (replies.readline().decode().strip() for _ in range(3))
            assert hello == "HELLO fbptr 1 160 120 640 rgba", hello
            rows = replies.read(160 * 120 * 4)
            assert crc == f"CRC {zlib.crc32(rows):08x}", (crc, read)
            assert rows[(160 * 4 + 3) * 4:][:4] == bytes([1, 2, 3, 255])
            print(f"serve: a client over TCP, text and binary, {crc} is that of the bytes that READ returned")
            link.sendall(b"STATS\n")
            stats = replies.readline().decode()
            place = re.search(r"shm_offset=(\d+)", stats)
            assert place, stats
            # The file is filled as the memory changes.
            until = time.monotonic() + PATIENCE_S
            while shared.read_bytes()[int(place[1]):][:len(rows)] != rows:
                assert time.monotonic() < until, "the shared file has other bytes"
                time.sleep(0.05)
            print("serve --shm: the file has the memory's bytes")
            picture = folder / "snap.ppm"
            run("snap", f"127.0.0.1:{server.port}", picture)
            assert crc == f"CRC {checksum_of(picture.read_bytes())}"
            print("snap: the same bytes")


def starts():
    """Prints the least and the median of five times from the start to the end of `--version`."""
    times = []
    for _ in range(5):
        start = time.perf_counter()
        said = run("--version")[0]
        times.append((time.perf_counter() - start) * 1000)
    print(f"--version: {said.strip()}, {min(times):.1f} ms at best, median {sorted(times)[2]:.1f} ms")


def borrowed(folder):
    """Runs another program on an emulated /dev/fb0, or sees that this system's version says that it cannot."""
    name = folder / "fb0.ppm"
    words = ["run", "--headless", "--size", "64x48", "--snap", name, "--", "sh", "-c", "head -c 12288 /dev/zero > /dev/fb0"]
    done = subprocess.run([*COMMAND, *map(str, words)], capture_output=True, timeout=PATIENCE_S)
    if done.returncode == 0:
        assert checksum_of(name.read_bytes()) == f"{zlib.crc32(bytes([0, 0, 0, 255]) * 64 * 48):08x}"
        print("run: a program that writes /dev/fb0")
        return
    said = done.stderr.decode(errors="replace")
    assert "Linux" in said and "panicked" not in said, said
    print(f"run: refused: {said.strip()}")


def main():
    starts()
    pictures()
    with tempfile.TemporaryDirectory(dir=os.environ.get("TRY_FOLDER")) as name:
        # Names as the program sees them: it may have another root.
        folder = pathlib.Path(name)
        prompt(folder)
        serve(folder)
        if "TRY_WITHOUT_RUN" not in os.environ:
            borrowed(folder)
    print("all of it works:", json.dumps(COMMAND))


main()
