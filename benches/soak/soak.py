#!/usr/bin/env python3
"""Runs a server under many kinds of clients for a bounded time, and verifies its guarantees.

    python3 benches/soak/soak.py target/release/fbptr [--minutes 30] [--seed 1]

The server is started several times. In each life, rounds of thirteen kinds of clients draw at once
over TCP and a Unix socket, some of them reset in the middle. After every round, when all clients have
disconnected, the server's resident memory is read. A life ends by SIGTERM or by SIGKILL. Verified:
every reply is right; the exit status after SIGTERM is 0; the replayed recording has the live frame's
CRC (after SIGKILL: it replays to where it ends, and the missing end mark is reported); and memory is
freed: the median resident memory after a life's last three rounds is within 5 % of that after its
second, third and fourth. Exit status 1 otherwise. Loopback only; only processes started here are
ended.
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
import threading
import time
import zlib

import clients

ROUND_SECONDS = 25
ROUNDS_OF_A_LIFE = 14
# After the first round the allocator's arenas and the threads' stacks have just been touched.
SETTLED = slice(1, 4)
LAST = slice(-3, None)
GROWTH = 1.05
SCENE = os.path.join(os.path.dirname(__file__), "../../tests/data/nd-cases/c06_4to2_tesseract.json")


def kinds():
    scene = open(SCENE, "rb").read()
    four = lambda sock, rng, until: clients.dimensions(sock, rng, until, scene)
    four.__name__ = "dimensions"
    return [clients.pixels, clients.binary_pixels, clients.runs, clients.blocks, clients.figures, clients.meshes,
            clients.scenes, four, clients.textures, clients.queries, clients.slow, clients.noise, clients.listener]


class Life:
    """One process of the server, with its recording."""

    def __init__(self, program, folder, number):
        self.record = os.path.join(folder, "life-%d.fbs" % number)
        self.unix = os.path.join(folder, "life-%d.sock" % number)
        for name in ("snaps", "loads"):
            os.makedirs(os.path.join(folder, name), exist_ok=True)
        self.process = subprocess.Popen(
            [program, "serve", "--headless", "--listen", "127.0.0.1:0", "--unix", self.unix, "--record", self.record,
             "--size", "%dx%d" % (clients.WIDTH, clients.HEIGHT), "--snap-dir", os.path.join(folder, "snaps"),
             "--load-dir", os.path.join(folder, "loads"), "--max-memory", "512M", "--max-payload", "4000000"],
            stderr=subprocess.PIPE, text=True)
        self.port = None
        self.said = []
        self.heard = threading.Event()
        threading.Thread(target=self.listen, daemon=True).start()
        if not self.heard.wait(30):
            raise SystemExit("the server did not say where it listens")

    def listen(self):
        for line in self.process.stderr:
            self.said.append(line)
            if "listening on tcp" in line:
                self.port = int(line.rsplit(":", 1)[1])
            if "listening on unix" in line:
                self.heard.set()

    def connect(self, over_unix):
        if over_unix:
            sock = socket.socket(socket.AF_UNIX)
            sock.settimeout(60)
            sock.connect(self.unix)
            return sock
        return socket.create_connection(("127.0.0.1", self.port), 60)

    def resident(self):
        for line in open("/proc/%d/status" % self.process.pid):
            if line.startswith("VmRSS"):
                return int(line.split()[1]) * 1024
        return 0

    def crc(self):
        with self.connect(False) as sock:
            return clients.Line(sock).ask(b"CRC\n").split()[1].decode()


def play_round(life, rng, failures):
    """Lets two clients of every kind draw, and waits until all have left."""
    until = time.time() + ROUND_SECONDS

    def run(kind, over_unix, seed):
        try:
            with life.connect(over_unix) as sock:
                kind(sock, random.Random(seed), until)
        except Exception as error:  # Any exception of a client is a finding.
            failures.append("%s (seed %d): %r" % (kind.__name__, seed, error))

    threads = [threading.Thread(target=run, args=(kind, over_unix, rng.getrandbits(32)))
               for kind in kinds() for over_unix in (False, True)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    time.sleep(2)


def replayed_crc(program, record, folder, is_cut):
    """Returns the CRC of the frame after a replay of a recording, which may lack its end.

    `None` if it is refused.
    """
    out = os.path.join(folder, "replay.raw")
    done = subprocess.run([program, "play", record, "--headless", "--snap", out], stdout=subprocess.DEVNULL,
                          stderr=subprocess.PIPE, text=True, errors="replace")
    if done.returncode != 0 and not (is_cut and "its end mark is missing" in done.stderr):
        return None, done.stderr[-500:]
    crc = "%08x" % zlib.crc32(open(out, "rb").read())
    os.remove(out)
    return crc, ""


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--minutes", type=float, default=30)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    rng, end, failures, number = random.Random(args.seed), time.time() + 60 * args.minutes, [], 0
    with tempfile.TemporaryDirectory() as folder:
        while time.time() < end:
            number += 1
            life = Life(args.program, folder, number)
            resident = []
            try:
                for _ in range(ROUNDS_OF_A_LIFE):
                    play_round(life, rng, failures)
                    resident.append(life.resident())
                crc, kills = life.crc(), number % 2 == 0
                life.process.send_signal(signal.SIGKILL if kills else signal.SIGTERM)
                began = time.time()
                status = life.process.wait(60)
                ended = time.time() - began
            finally:
                if life.process.poll() is None:
                    life.process.kill()
            again, why = replayed_crc(args.program, life.record, folder, kills)
            size = os.path.getsize(life.record)
            if not kills and (status != 0 or again != crc):
                failures.append("life %d: status %s, live CRC %s, replayed %s %s" % (number, status, crc, again, why))
            if kills and again is None:
                failures.append("life %d: its recording is refused after SIGKILL: %s" % (number, why))
            if statistics.median(resident[LAST]) > statistics.median(resident[SETTLED]) * GROWTH:
                failures.append("life %d: memory grew: %s" % (number, resident))
            print("life %d: %s, ended %s in %.2f s, CRC %s, replayed %s, record %.1f MB, resident MB %s, failures %d"
                  % (number, "killed" if kills else "terminated", status, ended, crc, again, size / 1e6,
                     " ".join("%.1f" % (r / 1e6) for r in resident), len(failures)), flush=True)
            os.remove(life.record)
    for failure in failures:
        print("FAILED " + failure)
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
