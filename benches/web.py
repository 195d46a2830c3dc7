#!/usr/bin/env python3
"""Measures the page in the browser: frames a second, latency, the server's share of a processor, and the other clients.

    benches/web.py target/release/fbptr [--seconds 10] [--viewers 0,1,10,100] [--page CHROMIUM] [--pairs N] [--deaf]

A Pixelflut client floods a server of 640x480 with one text command a pixel: two smooth pictures in turn, and the time in
milliseconds as the colour of pixel (0, 0). Viewers are WebSocket clients that acknowledge each frame; the first one reads
the time out of it. With --page one more viewer is the page itself in Chromium, driven by playwright-core, whose folder
node_modules must be the working directory's. With --pairs the flood is measured N times without and with the viewers,
in turns, on one server: they are a process of their own that runs where nothing else wants the processor, as it stands
for other machines; the rate is what the server has drawn. With --deaf the viewers read nothing while frames of
1920x1080 pixels of noise are drawn: the memory of the server.
"""
import argparse, os, re, select, socket, statistics, struct, subprocess, sys, threading, time, zlib

W, H = 640, 480


class Server:
    def __init__(self, program, size=f"{W}x{H}"):
        line = [program, "serve", "--headless", "--size", size, "--listen", "127.0.0.1:0", "--web", "127.0.0.1:0"]
        self.process = subprocess.Popen(line, stderr=subprocess.PIPE, text=True)
        said = ""
        while "listening on tcp" not in said or "browser:" not in said:
            said += self.process.stderr.readline()
        self.port = int(re.search(r"tcp \S+:(\d+)", said)[1])
        self.link = re.search(r"browser: (\S+)", said)[1]
        self.web = int(re.search(r":(\d+)/", self.link)[1])

    def ticks(self):
        """Returns processor seconds of all threads, and of the page's."""
        total = page = 0
        for task in os.listdir(f"/proc/{self.process.pid}/task"):
            name, rest = open(f"/proc/{self.process.pid}/task/{task}/stat").read().split("(", 1)[1].rsplit(")", 1)
            used = sum(map(int, rest.split()[11:13])) / os.sysconf("SC_CLK_TCK")
            total, page = total + used, page + used * (name == "web")
        return total, page

    def end(self):
        self.process.terminate()
        self.process.wait()


class Viewer:
    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port))
        head = (f"GET /socket HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nOrigin: http://127.0.0.1:{port}\r\n"
                "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n")
        self.socket.sendall(head.encode())
        answer = b""
        while b"\r\n\r\n" not in answer:
            answer += self.socket.recv(1)
        assert b" 101 " in answer, answer
        self.bytes, self.frames, self.received, self.latencies = bytearray(), 0, 0, []
        self.say("join")

    def say(self, text):
        data = text.encode()
        self.socket.sendall(bytes([0x81, 0x80 | len(data)]) + bytes(4) + data)

    def read(self, measures):
        part = self.socket.recv(1 << 20)
        assert part, "the server closed a viewer"
        self.received += len(part)
        self.bytes += part
        while len(self.bytes) >= 2:
            length, at = self.bytes[1], 2
            if length == 126:
                length, at = struct.unpack_from(">H", self.bytes.ljust(10), 2)[0], 4
            elif length == 127:
                length, at = struct.unpack_from(">Q", self.bytes.ljust(10), 2)[0], 10
            if len(self.bytes) < at + length:
                return
            if self.bytes[0] == 0x82:
                self.take(self.bytes[at:at + length], measures)
            del self.bytes[:at + length]

    def take(self, message, measures):
        kind, last, count, sequence = struct.unpack_from("<BBHQ", message)
        if measures and count and struct.unpack_from("<I", message, 20)[0] == 0:
            pixel = zlib.decompressobj(-15).decompress(bytes(message[20 + 4 * count:]), 4)
            self.stamp = int.from_bytes(pixel[:3], "big")
        if last:
            self.frames += 1
            if getattr(self, "stamp", None):
                self.latencies.append((int(time.time() * 1000) - self.stamp) & 0xffffff)
                self.stamp = None
            self.say(f"ack {sequence}")


def picture(phase):
    """Returns the commands of a smooth picture in lines of 16 rows."""
    def color(x, y):
        return (x + phase) & 255, (y * 2 + phase * 3) & 255, (x * y // 64 + phase) & 255
    rows = ["".join("PX %d %d %02x%02x%02x\n" % (x, y, *color(x, y)) for x in range(W) if x + y) for y in range(H)]
    return ["".join(rows[y:y + 16]).encode() for y in range(0, H, 16)]


PICTURES = [picture(0), picture(97)]


def flood(port, until, sent):
    client = socket.create_connection(("127.0.0.1", port))
    turn = 0
    while time.time() < until:
        for part in PICTURES[turn % 2]:
            client.sendall(b"PX 0 0 %06x\n" % (int(time.time() * 1000) & 0xffffff) + part)
            sent[0] += part.count(b"\n") + 1
        turn += 1
    client.sendall(b"SIZE\n")
    client.recv(64)
    client.close()


def watch(viewers, until):
    sockets = {viewer.socket: viewer for viewer in viewers}
    while time.time() < until:
        for ready in select.select(list(sockets), [], [], 0.2)[0]:
            sockets[ready].read(sockets[ready] is viewers[0])


def rate(server, seconds):
    """Returns the M pixels that the server draws a second for one client."""
    sent, begun = [0], time.time()
    flood(server.port, begun + seconds, sent)
    return sent[0] / (time.time() - begun) / 1e6


def pairs(program, count, seconds, rounds):
    """Compares the flood without and with viewers, in turns."""
    server, ratios = Server(program), []
    try:
        rate(server, 1)
        for turn in range(rounds):
            pair = {}
            for with_viewers in (False, True) if turn % 2 == 0 else (True, False):
                child = 0
                if with_viewers:
                    child = os.fork()
                    if not child:
                        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
                        watch([Viewer(server.web) for _ in range(count)], time.time() + 3600)
                    time.sleep(1)
                before, begun = server.ticks(), time.time()
                drawn = rate(server, seconds)
                total, web = (b - a for a, b in zip(before, server.ticks()))
                pair[with_viewers] = drawn
                print(f"    {count * with_viewers:3} viewers: {drawn:5.2f} M pixels/s, the page's thread "
                      f"{100 * web / (time.time() - begun):.0f} %", flush=True)
                if child:
                    os.kill(child, 9)
                    os.waitpid(child, 0)
                    time.sleep(0.5)
            ratios.append(pair[True] / pair[False])
        print(f"{rounds} pairs, {count} viewers: the flood keeps {statistics.median(ratios):.3f} of its rate (median; "
              f"{min(ratios):.3f} to {max(ratios):.3f})")
    finally:
        server.end()


def deaf(program, count, seconds):
    """Prints the most memory that a server had with viewers who read nothing."""
    server = Server(program, "1920x1080")
    try:
        viewers = [Viewer(server.web) for _ in range(count)]
        client, until, frames = socket.create_connection(("127.0.0.1", server.port)), time.time() + seconds, 0
        while time.time() < until:
            client.sendall(b"BLIT 0 0 1920 1080 :8294400\n" + os.urandom(8294400))
            frames += 1
        client.sendall(b"SIZE\n")
        client.recv(64)
        most = re.search(r"VmHWM:\s+(\d+)", open(f"/proc/{server.process.pid}/status").read())[1]
        print(f"{len(viewers):3} viewers that read nothing, {frames} frames: at most {int(most) / 1024:.0f} MiB", flush=True)
    finally:
        server.end()


def quantile(values, q):
    return sorted(values)[min(len(values) - 1, int(q * len(values)))] if values else float("nan")


def measure(program, count, seconds, chromium):
    server = Server(program)
    try:
        viewers = [Viewer(server.web) for _ in range(count)]
        page = None
        if chromium:
            script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "web_page.mjs")
            page = subprocess.Popen(["node", script, chromium, server.link, str(seconds)], stdout=subprocess.PIPE,
                                    text=True, env={**os.environ, "NODE_PATH": os.getcwd()})
            page.stdout.readline()
        before, begun, sent = server.ticks(), time.time(), [0]
        until = begun + seconds
        threads = [threading.Thread(target=flood, args=(server.port, until, sent))]
        for thread in threads:
            thread.start()
        if viewers:
            watch(viewers, until)
        for thread in threads:
            thread.join()
        took = time.time() - begun
        total, web = (b - a for a, b in zip(before, server.ticks()))
        line = f"{count:3} viewers: {sent[0] / took / 1e6:5.2f} M pixels/s, server {100 * total / took:3.0f} %, of it the page {100 * web / took:3.0f} %"
        if viewers:
            frames = [viewer.frames / took for viewer in viewers]
            ms = viewers[0].latencies
            line += (f"; frames/s {min(frames):.1f} to {max(frames):.1f}, {viewers[0].received / took / 1e6:.1f} MB/s each; "
                     f"latency p50 {quantile(ms, .5)} ms, p99 {quantile(ms, .99)} ms")
        print(line, flush=True)
        if page:
            print("    in Chromium:", page.communicate()[0].strip(), flush=True)
    finally:
        server.end()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program")
    parser.add_argument("--seconds", type=float, default=10)
    parser.add_argument("--viewers", default="0,1,10,100")
    parser.add_argument("--page", metavar="CHROMIUM")
    parser.add_argument("--pairs", type=int, default=0, metavar="N")
    parser.add_argument("--deaf", action="store_true")
    args = parser.parse_args()
    if args.deaf:
        for count in map(int, args.viewers.split(",")):
            deaf(args.program, count, args.seconds)
        return
    if args.pairs:
        pairs(args.program, max(map(int, args.viewers.split(","))), args.seconds, args.pairs)
        return
    for count in map(int, args.viewers.split(",")):
        measure(args.program, count, args.seconds, args.page)


if __name__ == "__main__":
    main()
