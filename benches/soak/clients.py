"""Clients of the soak test.

Each kind is a function that uses one connection, and raises `Wrong` on a wrong answer. Its arguments
are a connected socket, a random generator of its own and the time at which it must end. Its rate of
bytes is limited, so that a recording of the soak test fits a disk.
"""

import socket
import struct
import time
import zlib

WIDTH, HEIGHT = 640, 360


class Wrong(Exception):
    """Raised when the server's answer is wrong."""


class Line:
    """A socket with buffered reading of lines and payloads."""

    def __init__(self, sock):
        self.sock = sock
        self.file = sock.makefile("rb")

    def send(self, data):
        self.sock.sendall(data)

    def ask(self, data):
        """Sends a query and returns its reply line.

        Errors and warnings of earlier commands are passed over.
        """
        self.send(data)
        while True:
            line = self.file.readline()
            if not line:
                raise ConnectionError("closed while a reply was due")
            if not line.startswith((b"ERR ", b"WARN ")):
                return line

    def sync(self, tag):
        reply = self.ask(b"SYNC %s\n" % tag)
        if reply != b"SYNC %s\n" % tag:
            raise Wrong("SYNC %r answered %r" % (tag, reply))


def rest(rng, until):
    time.sleep(min(rng.uniform(0.01, 0.06), max(0.0, until - time.time())))


def pixels(sock, rng, until):
    """Text pixels, as Pixelflut clients send them."""
    line = Line(sock)
    while time.time() < until:
        line.send(b"".join(b"PX %d %d %06x\n" % (rng.randrange(WIDTH + 20), rng.randrange(HEIGHT),
                                                 rng.randrange(1 << 24)) for _ in range(400)))
        rest(rng, until)
    if not line.ask(b"SIZE\n").startswith(b"SIZE %d %d" % (WIDTH, HEIGHT)):
        raise Wrong("SIZE")


def binary_pixels(sock, rng, until):
    """Binary pixels."""
    line = Line(sock)
    while time.time() < until:
        line.send(b"".join(b"PB" + struct.pack("<HHI", rng.randrange(WIDTH), rng.randrange(HEIGHT),
                                               rng.getrandbits(32)) for _ in range(600)))
        rest(rng, until)
    line.sync(b"pb")


def runs(sock, rng, until):
    """Runs of pixels, some of which leave the frame's rows."""
    line = Line(sock)
    while time.time() < until:
        n = rng.randrange(1, 3000)
        line.send(b"PXMULTI" + struct.pack("<HHI", rng.randrange(WIDTH), rng.randrange(HEIGHT - 20), n)
                  + rng.randbytes(4 * n))
        rest(rng, until)
    line.sync(b"multi")


def blocks(sock, rng, until):
    """Rectangles written and copied."""
    line = Line(sock)
    while time.time() < until:
        w, h = rng.randrange(1, 60), rng.randrange(1, 40)
        line.send(b"BLIT %d %d %d %d :%d\n" % (rng.randrange(-30, WIDTH), rng.randrange(-30, HEIGHT), w, h,
                                               4 * w * h) + rng.randbytes(4 * w * h))
        line.send(b"COPY %d %d %d %d %d %d\n" % (rng.randrange(WIDTH - w), rng.randrange(HEIGHT - h), w, h,
                                                 rng.randrange(WIDTH), rng.randrange(HEIGHT)))
        rest(rng, until)
    line.sync(b"blit")


def figures(sock, rng, until):
    """Every figure of two dimensions, composed and stored."""
    line = Line(sock)
    x, y = (lambda: rng.randrange(-50, WIDTH + 50)), (lambda: rng.randrange(-50, HEIGHT + 50))
    color = lambda: "%08x" % rng.getrandbits(32)
    while time.time() < until:
        lines = ["BLEND " + rng.choice(["over", "replace"])]
        for _ in range(30):
            lines.append(rng.choice([
                f"LINE {x()} {y()} {x()} {y()} {color()} {color()}",
                f"TRI {x()} {y()} {x()} {y()} {x()} {y()} {color()}",
                f"FILL {x()}.5 {y()} {x()} {y()}.25 {x()} {y()} {color()} {color()} {color()}",
                f"RECT {x()} {y()} {abs(x())} {abs(y())} {color()}",
                f"FILLRECT {x()} {y()} {rng.randrange(90)} {rng.randrange(90)} {color()}",
                f"CIRCLE {x()} {y()} {rng.randrange(200)} {color()}",
                f"FILLCIRCLE {x()} {y()} {rng.randrange(60)} {color()}",
                f"FILLPOLY {color()} {x()} {y()} {x()} {y()} {x()} {y()} {x()} {y()}",
                f"LINEAA {x()}.3 {y()} {x()} {y()}.7 {color()}",
                f"FILL {rng.choice([-1, 1])}e{rng.randrange(309)} {y()} {x()} {y()} {x()} -1e300 {color()} {color()} {color()}",
                f"TEXT {x()} {y()} {color()} :5\nhello",
            ]))
        line.send(("\n".join(lines) + "\n").encode())
        rest(rng, until)
    line.sync(b"figures")


def meshes(sock, rng, until):
    """Lit meshes in every shading mode and depth format."""
    line = Line(sock)
    line.send(b"LOOKAT 0 0 6 0 0 0 0 1 0\nPERSPECTIVE 0.9 1 20\nAMBIENT 1 1 1\nLIGHT 0 POINT 3 4 5 1 1 1\n"
              b"MESH pot TEAPOT 4\nMESH knot KNOT 60 12\nMESH @box BOX\n")
    while time.time() < until:
        line.send(("VIEWPORT %d %d 200 150\nHIDE %s\nSHADE %s\nROTATE 0 1 0 0.3\nDRAW %s\n" % (
            rng.randrange(WIDTH), rng.randrange(HEIGHT), rng.choice(["zbuffer", "painter", "none"]),
            rng.choice(["wire", "flat", "gouraud", "phong"]), rng.choice(["pot", "knot", "@box"]))).encode())
        if rng.random() < 0.05:
            line.send(b"DEPTH %s\n" % rng.choice([b"u16", b"u24", b"f32", b"reversed"]))
        if rng.random() < 0.1:
            line.send(b"QUALITY max-error 8\nDRAW knot\nQUALITY exact\n")
        time.sleep(0.1)
    line.sync(b"meshes")


def scenes(sock, rng, until):
    """X3D scenes."""
    line = Line(sock)
    while time.time() < until:
        shapes = "".join(
            "<Transform translation='%d %d 0'><Shape><Appearance><Material diffuseColor='%.2f 0.5 0.3' "
            "transparency='%.1f'/></Appearance><%s/></Shape></Transform>" % (
                i - 2, i % 3 - 1, rng.random(), rng.choice([0, 0, 0.5]), rng.choice(["Box", "Sphere", "Cone"]))
            for i in range(5))
        text = ("<X3D><Scene>" + shapes + "</Scene></X3D>").encode()
        line.send(b"SCENE X3D :%d\n" % len(text) + text + b"VIEWPORT 300 20 200 150\nDRAWSCENE 0 SORTED\n")
        time.sleep(0.2)
    line.sync(b"scenes")


def dimensions(sock, rng, until, scene):
    """A scene of four dimensions."""
    line = Line(sock)
    line.send(b"EYE four :%d\n" % len(scene) + scene)
    while time.time() < until:
        line.send(b"DRAWEYE four %d %d 40 30\n" % (rng.randrange(WIDTH), rng.randrange(HEIGHT)))
        time.sleep(0.3)
    line.sync(b"eye")


def textures(sock, rng, until):
    """Textures made, used, replaced and freed, some of them broken files."""
    line = Line(sock)
    line.send(b"LOOKAT 0 0 4 0 0 0 0 1 0\nPERSPECTIVE 0.9 1 20\nAMBIENT 1 1 1\nMESH b BOX\n")
    while time.time() < until:
        side = rng.choice([8, 64, 256])
        raw = b"".join(b"\0" + rng.randbytes(3 * side) for _ in range(side))
        chunk = lambda kind, data: (struct.pack(">I", len(data)) + kind + data
                                    + struct.pack(">I", zlib.crc32(kind + data)))
        png = (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0))
               + chunk(b"IDAT", zlib.compress(raw, 1)) + chunk(b"IEND", b""))
        if rng.random() < 0.2:
            png = png[:rng.randrange(len(png))]
        line.send(b"TEX t%d :%d\n" % (rng.randrange(4), len(png)) + png)
        line.send(b"TEXTURE t%d trilinear\nROTATE 0 1 1 0.2\nDRAW b\nTEXTURE OFF\nFREE t%d\n" % (
            rng.randrange(4), rng.randrange(4)))
        time.sleep(0.1)
    line.sync(b"textures")


def queries(sock, rng, until):
    """Every query; each reply is checked for its form and size."""
    line = Line(sock)
    while time.time() < until:
        x, y = rng.randrange(WIDTH - 32), rng.randrange(HEIGHT - 32)
        reply = line.ask(b"READ %d %d 32 32\n" % (x, y))
        if reply != b"READ %d %d 32 32 :4096\n" % (x, y) or len(line.file.read(4096)) != 4096:
            raise Wrong("READ answered %r" % reply)
        if len(line.ask(b"CRC\n")) != len("CRC 00000000\n"):
            raise Wrong("CRC")
        head = line.ask(b"SNAP :\n").split()
        png = line.file.read(int(head[4][1:]))
        if head[:4] != [b"SNAP", b"%d" % WIDTH, b"%d" % HEIGHT, b"png"] or png[:8] != b"\x89PNG\r\n\x1a\n":
            raise Wrong("SNAP answered %r" % head)
        if not line.ask(b"STATS\n").startswith(b"STATS "):
            raise Wrong("STATS")
        line.sync(b"%d" % rng.getrandbits(30))
        time.sleep(0.05)


def slow(sock, rng, until):
    """Commands a few bytes at a time, and replies that are not read until the end."""
    sock.settimeout(5)
    text = b"PX 1 1\nPX 2 2 ff0000\nHELP\nCRC\n" * 40
    sent = 0
    while time.time() < until and sent < len(text):
        n = rng.randrange(1, 8)
        sock.sendall(text[sent:sent + n])
        sent += n
        time.sleep(0.02)


def noise(sock, rng, until):
    """Invalid bytes, cut anywhere; ends with a reset half of the time."""
    verbs = [b"PX ", b"LINE ", b"MESH m OBJ :40\n", b"TEX t :9\n", b"EYE e :3\n", b"PB", b"PXMULTI", b"\xff\x00",
             b"1e308 ", b"-0 ", b"\n", b"SCENE X3D :12\n", b":99999999999999999999\n", b"QUALITY max-error 4\n"]
    try:
        while time.time() < until:
            sock.sendall(b"".join(rng.choice(verbs) if rng.random() < 0.7 else rng.randbytes(rng.randrange(9))
                                  for _ in range(60)))
            rest(rng, until)
    except OSError:
        # A length that is too large ends the connection, as specified.
        pass
    if rng.random() < 0.5:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))


def listener(sock, rng, until):
    """Subscribes to events and frames, and waits."""
    line = Line(sock)
    line.send(b"EVENTS on\nAUTO off\n")
    while time.time() < until:
        reply = line.ask(b"PX 0 0 %06x\nPRESENT wait\n" % rng.getrandbits(24))
        if not reply.startswith(b"FRAME "):
            raise Wrong("PRESENT wait answered %r" % reply)
        time.sleep(0.2)
    line.send(b"AUTO on\n")
    line.sync(b"listener")
