#!/usr/bin/env python3
"""Measures how evenly a server's window shows frames, and what it costs, on a virtual X server.

    python3 benches/window_frames.py target/release/fbptr

Needs Xvfb. For each size a server with a window of one pixel a pixel; a client draws over a Unix
socket, each frame (`PRESENT wait`) once the one before was shown, and no more than 60 a second. Out:
a Markdown table: the median, the 99th percentile and the longest time from the first command of a
frame to the answer, the frames that took longer than a period of 60 a second, and the server's
processor time, of these frames and of seconds in which nothing changes.
"""

import argparse
import os
import socket
import statistics
import subprocess
import tempfile
import time

PERIOD = 1 / 60


def processor_seconds(pid):
    with open(f"/proc/{pid}/stat") as file:
        fields = file.read().rpartition(") ")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def connect(path):
    client = socket.socket(socket.AF_UNIX)
    for _ in range(100):
        try:
            client.connect(path)
            return client
        except OSError:
            time.sleep(0.1)
    raise SystemExit("the server does not listen")


def answer(client):
    reply = b""
    while not reply.endswith(b"\n"):
        piece = client.recv(4096)
        if not piece:
            raise SystemExit("the server has closed the connection")
        reply += piece
    if reply.startswith(b"ERR"):
        raise SystemExit(reply.decode())


def share(pid, work):
    """Returns what `work` returns, and the server's processor time meanwhile as a share of a core."""
    used, begun = processor_seconds(pid), time.perf_counter()
    result = work()
    return result, (processor_seconds(pid) - used) / (time.perf_counter() - begun)


def times_of(client, frames, commands):
    """Returns the seconds that each frame took until it was shown."""
    times, due = [], time.perf_counter()
    for i in range(frames):
        due = max(due + PERIOD, time.perf_counter())
        time.sleep(max(0, due - time.perf_counter()))
        begun = time.perf_counter()
        client.sendall(commands(i) + b"PRESENT wait\n")
        answer(client)
        times.append(time.perf_counter() - begun)
    return times


def row(name, found, used):
    longest = sorted(found)
    p99 = longest[min(len(longest) - 1, len(longest) * 99 // 100)]
    late = sum(seconds > PERIOD for seconds in found)
    figures = [statistics.median(found), p99, longest[-1]]
    cells = " | ".join(f"{1e3 * seconds:.1f}" for seconds in figures)
    print(f"| {name} | {cells} | {late} of {len(found)} | {100 * used:.1f} % |", flush=True)


def measure(given, size, display):
    width, height = map(int, size.split("x"))
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "socket")
        environment = {k: v for k, v in os.environ.items() if k != "WAYLAND_DISPLAY"} | {"DISPLAY": display}
        server = subprocess.Popen([given.fbptr, "serve", "--size", size, "--unix", path], env=environment)
        try:
            client = connect(path)
            client.sendall(b"AUTO off\nPRESENT wait\n")
            answer(client)
            time.sleep(2)
            everything = lambda i: b"CLEAR #%06x\n" % (i * 65793 % (1 << 24))
            disc = lambda i: b"FILLCIRCLE %d 100 20 #%06x\n" % (i * 7 % width, i * 65793 % (1 << 24))
            for name, commands in (("every row changes", everything), ("40 rows change", disc)):
                found, used = share(server.pid, lambda: times_of(client, given.frames, commands))
                row(f"{size}, {name}", found, used)
            _, used = share(server.pid, lambda: time.sleep(10))
            print(f"| {size}, nothing changes | | | | | {100 * used:.1f} % |", flush=True)
        finally:
            server.terminate()
            server.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("fbptr")
    parser.add_argument("--frames", type=int, default=600)
    parser.add_argument("--sizes", default="1920x1080,3840x2160")
    given = parser.parse_args()
    display = ":78"
    print("| size | median, ms | p99, ms | longest, ms | late | of a core |")
    print("|---|---|---|---|---|---|")
    for size in given.sizes.split(","):
        screen = ["Xvfb", display, "-screen", "0", f"{size}x24", "-nolisten", "tcp", "-noreset"]
        x_server = subprocess.Popen(screen, stderr=subprocess.DEVNULL)
        try:
            time.sleep(1.5)
            measure(given, size, display)
        finally:
            x_server.terminate()
            x_server.wait()


if __name__ == "__main__":
    main()
