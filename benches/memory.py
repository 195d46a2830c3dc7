#!/usr/bin/env python3
"""Measures the memory that a server takes while a client tries to fill it.

In: the path of an `fbptr` program. Out: a Markdown table, one row per attack: the bytes that were
sent, the most memory that the process had at a time (VmHWM, by the kernel's count) in all and
beside what it had at its start, how the server answered, and how long another client's SYNC took
after the attack.

Each attack runs against a server of its own (`serve --headless --max-memory 512M`, Unix socket in
a temporary folder). No port is opened and nothing is left behind. A server that comes to hold more
than --stop is killed, and the row says so: a machine does not end by measuring it.

    python3 benches/memory.py target/release/fbptr
    python3 benches/memory.py old/fbptr --no-budget     # a program without --max-memory
    python3 benches/memory.py target/release/fbptr --only pngs,faces
"""

import argparse
import base64
import os
import re
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import zlib

MIB = 1 << 20
# Seconds after which a client gives up waiting for an answer.
PATIENCE = 120


def payload(head, data):
    return f"{head} :{len(data)}\n".encode() + data


def png(side, gray=0):
    """Returns a PNG of side x side pixels of one gray, which decodes to side * side * 4 bytes."""
    def chunk(kind, data):
        crc = zlib.crc32(kind + data)
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", crc)
    packer = zlib.compressobj(9)
    row = b"\0" + bytes([gray]) * (side * 4)
    rows = b"".join(packer.compress(row) for _ in range(side)) + packer.flush()
    head = struct.pack(">IIBBBBB", side, side, 8, 6, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")


def scene_of_pictures(count, side):
    """Returns a SCENE X3D command of boxes, each with its own picture inside the file."""
    def shape(i):
        url = "data:image/png;base64," + base64.b64encode(png(side, i)).decode()
        return f"<Shape><Appearance><ImageTexture url='\"{url}\"'/></Appearance><Box/></Shape>"
    shapes = "".join(map(shape, range(count)))
    return payload("SCENE X3D", f"<X3D><Scene>{shapes}</Scene></X3D>".encode())


def full_frames(count):
    """Returns a MESH command of equal triangles, each over the whole frame."""
    return payload("MESH m OBJ", b"v -9 -9 0\nv 27 -9 0\nv -9 27 0\n" + b"f 1 2 3\n" * count)


class Client:
    """A connection; sending stops when the server does not read."""

    def __init__(self, path, patience=PATIENCE):
        self.wire = socket.socket(socket.AF_UNIX)
        self.wire.settimeout(patience)
        self.wire.connect(path)
        self.wire.sendall(b"ERRORS report\n")

    def send(self, data):
        """Sends the bytes; returns how many the server accepted."""
        sent, view = 0, memoryview(data)
        try:
            while sent < len(view):
                sent += self.wire.send(view[sent:sent + MIB])
        except OSError:
            pass
        return sent

    def hear(self, mark, most=4096):
        """Reads until `mark`; returns the last `most` bytes of the replies."""
        said = b""
        try:
            while mark not in said:
                data = self.wire.recv(MIB)
                if not data:
                    break
                said = (said + data)[-most:]
        except OSError:
            pass
        return said


def at_once(data, patience=PATIENCE):
    """Returns an attack by one client that sends all of the data and waits for the answer."""
    def attack(path):
        client = Client(path, patience)
        sent = client.send(data + b"SYNC done\n")
        said = client.hear(b"SYNC done\n")
        return sent, told(said, b"SYNC done\n" in said), [client]
    return attack


def told(said, is_done):
    errors = [line for line in said.decode("utf-8", "replace").split("\n") if line.startswith("ERR ")]
    if errors:
        return re.sub(r"^ERR \d+ \d+ ", "", errors[0])[:160]
    return "done" if is_done else "no answer"


def many(count, each, rounds=1):
    """Returns an attack by clients that each send the same data repeatedly and read nothing."""
    def attack(path):
        clients, sent = [], 0
        try:
            for _ in range(count):
                clients.append(Client(path, 0.5))
        except OSError:
            pass
        for _ in range(rounds):
            sent += sum(client.send(each) for client in clients)
        time.sleep(2)
        said = b""
        for client in clients:
            client.wire.settimeout(0.01)
            try:
                said += b"".join(re.findall(rb"ERR [^\n]*\n", client.wire.recv(65536)))
            except OSError:
                pass
        return sent, f"{len(clients)} clients, " + told(said, True), clients
    return attack


def attacks(width, height):
    """Returns a dict of name to (further arguments of the server, function that makes the attack)."""
    frame = f"READ 0 0 {width} {height}\n".encode()
    half = width * height * 2
    views = b"CULL none\nHIDE zbuffer\nLOOKAT 0 0 5 0 0 0 0 1 0\n"
    return {
        "none": ([], lambda: at_once(b"SIZE\n")),
        "pngs": (["--max-resources", "50000000"], lambda: at_once(scene_of_pictures(10, 4096))),
        "pngs-1g": (["--max-resources", str(1 << 30)], lambda: at_once(scene_of_pictures(10, 4096))),
        "tex": (["--max-resources", "10000000"], lambda: at_once(payload("TEX t", png(4096)))),
        "faces": ([], lambda: at_once(full_frames(500_000) + views + b"DRAW m\n", 600)),
        "knots": ([], lambda: at_once(b"".join(b"MESH k%d KNOT 1000 1000\n" % i for i in range(40)))),
        "replies": ([], lambda: many(100, frame, 20)),
        "payloads": (
            [],
            lambda: many(100, f"BLIT 0 0 {width} {height} :{2 * half}\n".encode() + bytes(half)),
        ),
        "snaps": (
            ["--snap-dir", "SNAPS", "--max-snaps", "100000000"],
            lambda: at_once(b"".join(b"SNAP s%d.raw\n" % i for i in range(100))),
        ),
    }


NAMES = list(attacks(9, 9))


def status_of(pid):
    """Returns VmHWM and VmRSS of a process in bytes; zeros when it has ended."""
    try:
        with open(f"/proc/{pid}/status") as status:
            lines = dict(line.split(":", 1) for line in status)
        return tuple(int(lines[key].split()[0]) * 1024 for key in ("VmHWM", "VmRSS"))
    except (OSError, KeyError):
        return 0, 0


def watch(server, stop, peak, is_over):
    """Records the peak memory, and kills a server that holds more than `stop`."""
    while not is_over.wait(0.02):
        high, now = status_of(server.pid)
        peak[0] = max(peak[0], high)
        if now > stop:
            peak[1] = True
            server.kill()
            return


def folder_bytes(folder):
    return sum(os.stat(entry).st_blocks * 512 for entry in os.scandir(folder))


def still_answers(path):
    """Returns the milliseconds of another client's SYNC; None without an answer."""
    try:
        client, begun = Client(path, 30), time.monotonic()
        client.send(b"SYNC other\n")
        return (time.monotonic() - begun) * 1e3 if b"SYNC other\n" in client.hear(b"SYNC other\n") else None
    except OSError:
        return None


def measure(args, name):
    with tempfile.TemporaryDirectory() as folder:
        path, snaps = os.path.join(folder, "s"), os.path.join(folder, "snaps")
        os.mkdir(snaps)
        width, height = map(int, args.size.split("x"))
        further, make = attacks(width, height)[name]
        command = [args.program, "serve", "--headless", "--size", args.size, "--unix", path]
        command += [snaps if word == "SNAPS" else word for word in further]
        if args.no_budget:
            # The program may be older than the quota of snapshots, too.
            if "--max-snaps" in command and not knows(args.program, "--max-snaps"):
                at = command.index("--max-snaps")
                del command[at:at + 2]
        else:
            command += ["--max-memory", args.max_memory]
        server = subprocess.Popen(command, stdin=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        is_over, peak = threading.Event(), [0, False]
        try:
            while not os.path.exists(path) and server.poll() is None:
                time.sleep(0.01)
            time.sleep(0.1)
            attack, start = make(), status_of(server.pid)[0]
            watcher = threading.Thread(target=watch, args=(server, args.stop * MIB, peak, is_over))
            watcher.start()
            sent, answer, clients = attack(path)
            wait = still_answers(path)
            peak[0] = max(peak[0], status_of(server.pid)[0])
            is_over.set()
            watcher.join()
            if name == "snaps":
                answer += f" ({folder_bytes(snaps) / 1e6:.0f} MB on disk)"
            del clients
            return sent, start, peak, answer, wait, server.poll()
        finally:
            is_over.set()
            if server.poll() is None:
                server.kill()
            server.wait()


def knows(program, flag):
    return flag in subprocess.run([program, "serve", "--help"], capture_output=True, text=True).stdout


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program")
    parser.add_argument("--size", default="1920x1080")
    parser.add_argument("--only", help="names of attacks, with commas between: " + ", ".join(NAMES))
    parser.add_argument("--max-memory", default="512M")
    parser.add_argument("--no-budget", action="store_true", help="leave --max-memory out")
    parser.add_argument("--stop", type=int, default=4096, help="kill a server that holds so many MiB")
    args = parser.parse_args()
    budget = "no budget" if args.no_budget else f"--max-memory {args.max_memory}"
    print(f"| attack, {args.size}, {budget} | sent MB | peak MiB | beside the start | answer | next SYNC ms |")
    print("|---|---:|---:|---:|---|---:|")
    for name in args.only.split(",") if args.only else NAMES:
        sent, start, (peak, is_stopped), answer, wait, status = measure(args, name)
        if is_stopped:
            answer = f"killed beyond {args.stop} MiB"
        elif status is not None:
            answer = f"the server ended with {status}"
        after = "none" if wait is None else f"{wait:.1f}"
        print(
            f"| {name} | {sent / 1e6:.2f} | {peak / MIB:.0f} | {(peak - start) / MIB:.0f} | {answer} | {after} |",
            flush=True,
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
