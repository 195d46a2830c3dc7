"""Draw on a running fbptr server from Python, without dependencies.

    from fbptr import Client
    with Client() as fb:                       # 127.0.0.1:1234; Client("unix:/tmp/fb.sock") works too
        fb.clear("203040")
        fb.line(0, 0, 99, 49, "ff0000", "ffff00")
        fb.fill([(10, 10), (90, 20), (50, 80)], "red", "lime", "blue")
        fb.snapshot("picture.png")

Commands are buffered and sent by a query, when the buffer is full, or by `flush`. A colour is a
string of the command language ("rrggbb", "rrggbbaa", "gg", a CSS name) or a tuple of 3 or 4 bytes. A
refused command raises `CommandError` at the next call that waits for a reply. `SharedMemory` maps the
file of `fbptr serve --shm PATH`.
"""

import mmap
import re
import socket
import struct
import sys

__all__ = ["Client", "CommandError", "SharedMemory"]

_FLUSH_AT = 1 << 16


class CommandError(Exception):
    """Raised for refused commands.

    `errors` holds a (line, byte, code, message) for each since the last report.
    """

    def __init__(self, errors):
        self.errors = errors
        super().__init__("; ".join("line %d: %s %s" % (e[0], e[2], e[3]) for e in errors))


def colour(value):
    """Returns the text form of a colour: a string unchanged, 3 or 4 bytes as hex."""
    if isinstance(value, str):
        return value
    if len(value) not in (3, 4):
        raise ValueError("a colour has 3 or 4 bytes, not %d" % len(value))
    return bytes(value).hex()


def _number(value):
    # repr gives the shortest text that reads back as the same float.
    return repr(float(value)) if isinstance(value, float) else str(value)


class Client:
    """A connection to a server: `address` is "host:port", ":port" (loopback) or "unix:PATH"."""

    def __init__(self, address="127.0.0.1:1234", timeout=30.0):
        if address.startswith("unix:"):
            self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            self._socket.settimeout(timeout)
            self._socket.connect(address[len("unix:"):])
        else:
            host, _, port = address.rpartition(":")
            self._socket = socket.create_connection((host.strip("[]") or "127.0.0.1", int(port)), timeout)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._replies = self._socket.makefile("rb")
        self._out = bytearray()
        self._errors = []
        self._syncs = 0
        self._sent = 0
        self.events = []
        #: Explanations of draws that showed nothing, as (line, byte, message).
        self.warnings = []
        self.command("ERRORS report")

    def __enter__(self):
        return self

    def __exit__(self, kind, value, trace):
        self.close(check=kind is None)

    def close(self, check=True):
        """Waits until everything is drawn, then ends the connection."""
        try:
            if check:
                self.sync()
        finally:
            self._replies.close()
            self._socket.close()

    # -- sending and asking

    def command(self, verb, *args, payload=None):
        """Sends any command: words, numbers, and a payload of bytes where the verb takes one.

        Returns its offset in the stream, in bytes, by which errors name the command.
        """
        words = [verb] + [a if isinstance(a, str) else _number(a) for a in args]
        if payload is not None:
            words.append(":%d" % len(payload))
        line = " ".join(words)
        if "\n" in line or "\r" in line:
            raise ValueError("a command is one line")
        encoded = line.encode("utf-8") + b"\n"
        place = self._sent
        self._sent += len(encoded) + (0 if payload is None else len(payload))
        self._out += encoded
        if payload is not None:
            self._send(payload)
        elif len(self._out) >= _FLUSH_AT:
            self.flush()
        return place

    def _send(self, payload):
        if len(payload) < _FLUSH_AT:
            self._out += payload
            if len(self._out) >= _FLUSH_AT:
                self.flush()
        else:
            self.flush()
            self._socket.sendall(payload)

    def flush(self):
        """Sends what is buffered, without waiting for it to be drawn."""
        if self._out:
            self._socket.sendall(self._out)
            self._out.clear()

    def _reply(self, verb, place):
        """Returns the words after `verb` of the reply to the query at byte `place`.

        Stores errors and events before it.
        """
        self.flush()
        while True:
            line = self._replies.readline()
            if not line.endswith(b"\n"):
                self._raise_errors()
                raise ConnectionError("the server ended the connection")
            text = line[:-1].decode("utf-8", "replace")
            words = text.split(" ")
            if words[0] == "ERR":
                self._keep_error(words)
                # Replies come in order, so this query itself was refused and has no other reply.
                if self._errors[-1][1] == place:
                    self._raise_errors()
            elif words[0] == "EVENT":
                self.events.append(words[1:])
            elif words[0] == "WARN":
                self._keep_warning(words)
            elif words[0] == verb:
                return words[1:]
            else:
                raise ConnectionError("expected a reply to %s, got %r" % (verb, text))

    def _keep_error(self, words):
        self._errors.append((int(words[1]), int(words[2]), words[3], " ".join(words[4:])))

    def _keep_warning(self, words):
        self.warnings.append((int(words[1]), int(words[2]), " ".join(words[3:])))

    def _raise_errors(self):
        errors, self._errors = self._errors, []
        if errors:
            raise CommandError(errors)

    def ask(self, verb, *args, answer=None):
        """Sends a query and returns the words of its reply after the verb.

        `answer` is the first word of the reply if it is not the verb.
        """
        words = self._reply(answer or verb, self.command(verb, *args))
        self._raise_errors()
        return words

    def _ask_bytes(self, verb, *args):
        """Sends a query whose reply ends with a payload, and returns the payload."""
        words = self._reply(verb, self.command(verb, *args))
        # The payload is read before an earlier command's error is raised, since the next reply
        # follows it.
        count = int(words[-1][1:])
        data = self._replies.read(count)
        if len(data) != count:
            raise ConnectionError("the server ended the connection")
        self._raise_errors()
        return data

    def sync(self):
        """Waits until everything sent so far has taken effect.

        Raises `CommandError` if a command was refused.
        """
        self._syncs += 1
        tag = "s%d" % self._syncs
        found = self.ask("SYNC", tag)
        if found != [tag]:
            raise ConnectionError("expected SYNC %s, got %r" % (tag, found))

    def listen(self, on=True):
        """Subscribes to the window's events, which `next_event` returns."""
        self.command("EVENTS", "on" if on else "off")

    def next_event(self):
        """Waits for the window's next event and returns its words, as ["mouse", "12", "30", "1"].

        `None` when the server ends.
        """
        self.flush()
        if self.events:
            return self.events.pop(0)
        timeout = self._socket.gettimeout()
        self._socket.settimeout(None)
        try:
            line = self._replies.readline()
        except ConnectionError:
            return None
        finally:
            self._socket.settimeout(timeout)
        if not line.endswith(b"\n"):
            return None
        words = line[:-1].decode("utf-8", "replace").split(" ")
        if words[0] == "ERR":
            self._keep_error(words)
            self._raise_errors()
        if words[0] == "WARN":
            self._keep_warning(words)
            return self.next_event()
        if words[0] != "EVENT":
            raise ConnectionError("expected an event, got %r" % line)
        return words[1:]

    # -- the frame

    def size(self):
        """Returns (width, height) in pixels."""
        w, h = self.ask("SIZE")
        return int(w), int(h)

    def clear(self, c="000000"):
        """Fills the frame with a colour and sets all depths to 1."""
        self.command("CLEAR", colour(c))

    def pixel(self, x, y, c):
        """Sets one pixel."""
        self.command("PX", x, y, colour(c))

    def get_pixel(self, x, y):
        """Returns the (r, g, b) of one pixel."""
        return tuple(bytes.fromhex(self.ask("PX", x, y)[2]))

    def pixels(self, items):
        """Sets many pixels at once, in binary form, from an iterable of (x, y, (r, g, b[, a]))."""
        pack = struct.Struct("<HH4B").pack
        packed = b"".join(pack(x, y, *(tuple(c) + (255,))[:4]) for x, y, c in items)
        self.command("POINTS", payload=packed)

    def blit(self, x, y, w, h, rgba):
        """Writes w x h pixels of RGBA bytes (or a numpy array of h x w x 4 bytes) at (x, y)."""
        data = rgba.tobytes() if hasattr(rgba, "tobytes") else bytes(rgba)
        if len(data) != w * h * 4:
            raise ValueError("%d x %d pixels are %d bytes, not %d" % (w, h, w * h * 4, len(data)))
        self.command("BLIT", x, y, w, h, payload=data)

    def read(self, x=0, y=0, w=None, h=None):
        """Returns the RGBA bytes of a rectangle, by default the whole frame."""
        if w is None or h is None:
            width, height = self.size()
            w, h = (width - x if w is None else w), (height - y if h is None else h)
        return self._ask_bytes("READ", x, y, w, h)

    def array(self, x=0, y=0, w=None, h=None):
        """Like `read`, as a numpy array of shape (h, w, 4); needs numpy."""
        import numpy

        if w is None or h is None:
            width, height = self.size()
            w, h = (width - x if w is None else w), (height - y if h is None else h)
        return numpy.frombuffer(self.read(x, y, w, h), numpy.uint8).reshape(h, w, 4)

    def peek(self, offset, count):
        """Returns `count` bytes of video memory from byte `offset` = (width * y + x) * 4."""
        return bytes.fromhex(self.ask("PEEK", offset, count)[1]) if count else b""

    def poke(self, offset, data):
        """Writes bytes into video memory from byte `offset`.

        Lines stay below the protocol's 4,096 bytes.
        """
        data = bytes(data)
        for at in range(0, len(data), 1024):
            self.command("POKE", offset + at, data[at : at + 1024].hex())

    def crc(self, *rect):
        """Returns the CRC-32 of the frame's (or a rectangle's) RGBA bytes."""
        return int(self.ask("CRC", *rect)[0], 16)

    def snapshot(self, path=None):
        """Returns the frame as PNG bytes, and writes them to `path` if given."""
        data = self._ask_bytes("SNAP", ":")
        if path is not None:
            with open(path, "wb") as file:
                file.write(data)
        return data

    # -- two dimensions

    def line(self, x0, y0, x1, y1, c0, c1=None):
        """Draws a Bresenham line; with c1 its colour is interpolated from c0 to c1."""
        self.command("LINE", x0, y0, x1, y1, colour(c0), *([] if c1 is None else [colour(c1)]))

    def fill(self, points, *colours):
        """Fills a triangle of three (x, y) in real coordinates, with one colour or three."""
        flat = [v for p in points for v in p]
        self.command("FILL", *flat, *map(colour, colours))

    def rect(self, x, y, w, h, c):
        """Fills a rectangle."""
        self.command("FILLRECT", x, y, w, h, colour(c))

    def circle(self, cx, cy, r, c):
        """Fills a circle."""
        self.command("FILLCIRCLE", cx, cy, r, colour(c))

    def text(self, x, y, c, text):
        """Draws text in the built-in 8x8 font; (x, y) is its upper left corner."""
        self.command("TEXT", x, y, colour(c), payload=text.encode("utf-8"))

    # -- three dimensions

    def mesh(self, name, obj):
        """Creates a mesh of this name from the bytes or the text of an OBJ file."""
        self.command("MESH", name, "OBJ", payload=obj.encode("utf-8") if isinstance(obj, str) else bytes(obj))

    def texture(self, name, file):
        """Creates a texture of this name from the bytes of a PNG or JPEG file."""
        self.command("TEX", name, payload=bytes(file))

    def look_at(self, eye, reference=(0, 0, 0), up=(0, 1, 0)):
        """Places the camera."""
        self.command("LOOKAT", *eye, *reference, *up)

    def draw(self, name):
        """Draws a mesh with the connection's camera, matrix, lights and material."""
        self.command("DRAW", name)

    def depth_at(self, x, y):
        """Returns the depth of a pixel, 0 near to 1 far."""
        return float(self.ask("DEPTHAT", x, y)[2])

    def present(self, wait=False):
        """Ends a frame; with `wait`, waits until it is shown and returns its number."""
        if wait:
            return int(self.ask("PRESENT", "wait", answer="FRAME")[0])
        self.command("PRESENT")
        return None


class SharedMemory:
    """The video memory of `fbptr serve --shm PATH`, mapped: FBptr[offset] is `mem[offset]`.

    A write is shown within 50 ms, or at once after `ring`. If the server draws at the same position,
    either may win.
    """

    HEADER = 4096

    def __init__(self, path):
        with open(path, "r+b") as file:
            self._map = mmap.mmap(file.fileno(), 0)
        magic, version, header, width, height, stride, form = struct.unpack_from("<8s6I", self._map, 0)
        if magic != b"FBPTRSHM" or version != 1 or header != self.HEADER or form != 1:
            self._map.close()
            raise ValueError("%s is not an fbptr frame of version 1" % path)
        if len(self._map) < header + stride * height:
            self._map.close()
            raise ValueError("%s is shorter than its frame" % path)
        self.width, self.height, self.stride = width, height, stride
        #: The frame's bytes, writable: R, G, B, A of pixel (x, y) from (width * y + x) * 4 on.
        self.bytes = memoryview(self._map)[header : header + stride * height]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """Unmaps the memory."""
        self.bytes.release()
        self._map.close()

    def __getitem__(self, at):
        return self.bytes[at]

    def __setitem__(self, at, value):
        self.bytes[at] = value

    def pixel(self, x, y, c):
        """Sets one pixel to 4 bytes (r, g, b, a); off the frame it does nothing."""
        if 0 <= x < self.width and 0 <= y < self.height:
            at = (self.width * y + x) * 4
            self.bytes[at : at + 4] = bytes(c)

    def array(self):
        """Returns the frame as a writable numpy array of shape (height, width, 4); needs numpy."""
        import numpy

        return numpy.frombuffer(self.bytes, numpy.uint8).reshape(self.height, self.width, 4)

    def frame(self):
        """Returns the number of frames that the server has published."""
        return struct.unpack_from("<Q", self._map, 32)[0]

    def ring(self):
        """Notifies the server of writes."""
        (count,) = struct.unpack_from("<Q", self._map, 40)
        struct.pack_into("<Q", self._map, 40, (count + 1) & (2**64 - 1))

    def info(self):
        """Returns the header's key=value pairs."""
        text = bytes(self._map[256 : self.HEADER]).split(b"\0", 1)[0].decode("ascii", "replace")
        return dict(re.findall(r"^(\w+)=(.*)$", text, re.M))


def _demo(address):
    with Client(address) as fb:
        w, h = fb.size()
        fb.clear("102030")
        for i in range(0, w, 8):
            fb.line(0, 0, i, h - 1, (i % 256, 128, 255 - i % 256))
        fb.text(8, 8, "white", "drawn from Python")


if __name__ == "__main__":
    _demo(sys.argv[1] if len(sys.argv) > 1 else "127.0.0.1:1234")
