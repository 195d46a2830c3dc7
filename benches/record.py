#!/usr/bin/env python3
"""Measures how much of their speed text pixels keep while the server records.

In: the path of an `fbptr` program. Out: a Markdown table of the rate without and with `--record`, and
of the second's share in the first: median, least and largest of the rounds. Ends with status 1 where
the median share is below --least, or where the replay of a recording gives another picture.

In each round a server without and one with a recording take turns, in changing order, so that only
what was measured within the same seconds is compared. Each is a process of its own on a Unix socket
in a temporary folder; one client sends plain `PX` lines at random places of 1920x1080 in writes of
256 KiB, and the time runs from the first byte to the answer to a SYNC behind the last one. A
recording takes ten bytes a pixel: --folder names a folder on the disk that is to be measured.

    python3 benches/record.py target/release/fbptr
    python3 benches/record.py target/release/fbptr --pixels 6000000 --rounds 3 --folder /var/tmp
"""

import argparse
import os
import random
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import time
import zlib

WIDTH, HEIGHT = 1920, 1080
WRITE_BYTES = 256 << 10
# Every pixel is different, and the stream is short enough to be sent repeatedly.
LINES = 200_000


def pixels():
    rng = random.Random(1)
    at = lambda size: rng.randrange(size)
    return "".join(f"PX {at(WIDTH)} {at(HEIGHT)} {at(1 << 24):06x}\n" for _ in range(LINES)).encode()


def ask(wire, question):
    """Sends a query and returns its reply line."""
    wire.sendall(question)
    answer = b""
    while not answer.endswith(b"\n"):
        piece = wire.recv(4096)
        if not piece:
            raise EOFError(f"the server ends after {answer!r}")
        answer += piece
    return answer.decode().strip()


def connect(path):
    wire = socket.socket(socket.AF_UNIX)
    wire.settimeout(120)
    until = time.monotonic() + 30
    while True:
        try:
            wire.connect(path)
            return wire
        except (FileNotFoundError, ConnectionRefusedError):
            if time.monotonic() > until:
                raise
            time.sleep(0.01)


def measure(program, stream, times, record):
    """Returns the seconds that the pixels take, and the CRC of the frame afterwards."""
    with tempfile.TemporaryDirectory(prefix="fbptr-bench-") as folder:
        path = os.path.join(folder, "socket")
        command = [program, "serve", "--headless", "--size", f"{WIDTH}x{HEIGHT}", "--unix", path]
        command += ["--record", record] if record else []
        server = subprocess.Popen(command, stderr=subprocess.DEVNULL)
        try:
            with connect(path) as wire:
                ask(wire, b"SYNC begin\n")
                begun = time.perf_counter()
                for _ in range(times):
                    for at in range(0, len(stream), WRITE_BYTES):
                        wire.sendall(stream[at:at + WRITE_BYTES])
                ask(wire, b"SYNC end\n")
                took = time.perf_counter() - begun
                crc = ask(wire, b"CRC\n")
                is_recording = " record=ok " in ask(wire, b"STATS\n")
        finally:
            server.send_signal(signal.SIGTERM)
            status = server.wait(120)
        if bool(record) != is_recording or status != 0:
            raise RuntimeError(f"recording: {is_recording}, status {status}")
        return took, crc


def replayed(program, record):
    """Returns the CRC of the frame after a replay, as the server reports it."""
    with tempfile.TemporaryDirectory(prefix="fbptr-bench-") as folder:
        picture = os.path.join(folder, "frame.raw")
        command = [program, "play", record, "--headless", "--size", f"{WIDTH}x{HEIGHT}", "--snap", picture]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, timeout=600)
        with open(picture, "rb") as raw:
            return f"CRC {zlib.crc32(raw.read()):08x}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program")
    parser.add_argument("--pixels", type=int, default=20_000_000, help="of each run")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--folder", default=tempfile.gettempdir(), help="where recordings are written")
    parser.add_argument("--least", type=float, default=0.7, help="share that is kept")
    options = parser.parse_args()
    stream, times = pixels(), max(1, options.pixels // LINES)
    record = os.path.join(options.folder, f"fbptr-bench-{os.getpid()}.fbs")
    seconds, shares = {False: [], True: []}, []
    try:
        for number in range(options.rounds):
            crcs = {}
            for is_recorded in [False, True] if number % 2 == 0 else [True, False]:
                took, crcs[is_recorded] = measure(
                    options.program, stream, times, record if is_recorded else None)
                seconds[is_recorded].append(took)
            shares.append(seconds[False][-1] / seconds[True][-1])
            if crcs[False] != crcs[True]:
                sys.exit(f"the frames differ: {crcs}")
        found = replayed(options.program, record)
    finally:
        if os.path.exists(record):
            os.remove(record)
    if found != crcs[True]:
        sys.exit(f"the replay gives {found!r} and the server {crcs[True]!r}")
    print("| text pixels | Mpx/s, median | least | largest |\n|---|---:|---:|---:|")
    for is_recorded, name in [(False, "plain"), (True, "recorded")]:
        rates = [LINES * times / s / 1e6 for s in seconds[is_recorded]]
        print(f"| {name} | {statistics.median(rates):.1f} | {min(rates):.1f} | {max(rates):.1f} |")
    share = statistics.median(shares)
    print(f"| share | {share:.2f} | {min(shares):.2f} | {max(shares):.2f} |")
    if share < options.least:
        sys.exit(f"the share is below {options.least}")


if __name__ == "__main__":
    main()
