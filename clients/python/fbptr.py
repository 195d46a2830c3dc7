"""Draw on a running fbptr server from Python, without dependencies.

    from fbptr import Client
    with Client() as fb:                       # 127.0.0.1:1234; Client("unix:/tmp/fb.sock") works too
        fb.clear("203040")
        fb.line(0, 0, 99, 49, "ff0000", "ffff00")
        fb.fill([(10, 10), (90, 20), (50, 80)], "red", "lime", "blue")
        fb.snapshot("picture.png")

Each verb of the protocol is a method of its name in lower case; `Client` has handier forms of some,
and further methods beside them. Commands are buffered and sent by a query, when the buffer is full,
or by `flush`. A colour is a string of the command language ("rrggbb", "rrggbbaa", "gg", a CSS name)
or a tuple of 3 or 4 bytes. A refused command raises `CommandError` at the next call that waits for
a reply. `SharedMemory` maps the file of `fbptr serve --shm PATH`.
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


def _colour(value):
    return None if value is None else colour(value)


def _rgba(value):
    """Returns the four bytes of a colour: 3 or 4 bytes, or "rrggbb", "rrggbbaa", "gg" in hex."""
    if isinstance(value, str):
        value = bytes.fromhex(value * 3 if len(value) == 2 else value)
    data = _bytes(value)
    if len(data) not in (3, 4):
        raise ValueError("a colour has 3 or 4 bytes, not %d" % len(data))
    return data + b"\xff" if len(data) == 3 else data


def _bytes(data):
    """Returns the bytes of a payload: text as UTF-8, an array's memory, bytes unchanged."""
    if isinstance(data, str):
        return data.encode("utf-8")
    if hasattr(data, "tobytes"):
        return data.tobytes()
    if hasattr(data, "__index__"):
        # `bytes` would make that many zeros.
        raise TypeError("expected bytes, text or an array of bytes, got %s" % type(data).__name__)
    return bytes(data)


def _hex(data):
    return data if isinstance(data, str) else _bytes(data).hex()


def _run(rgba):
    """Returns the bytes of a run of pixels: their number, and R, G, B, A of each."""
    data = _bytes(rgba)
    if len(data) % 4:
        raise ValueError("a run has 4 bytes a pixel, not %d in all" % len(data))
    return struct.pack("<I", len(data) // 4) + data


def _words(*words):
    """Returns words in one list: sequences are spread, `None` is left out."""
    spread = []
    for word in words:
        if isinstance(word, (tuple, list)):
            spread += _words(*word)
        elif word is not None:
            spread.append(word)
    return spread


class Verbs:
    """One method a verb of the protocol, by its name in lower case.

    A parameter is a word of the verb's form; `*parameters` are words in order, numbers also as
    tuples. What a form has in brackets may be left out. A query returns the words of its reply
    after the verb, or the bytes of its payload. `Client` replaces some methods by handier ones.
    """

    # Made from the verb table: BLESS=1 cargo test --test decoder python

    def pb(self, x, y, color):
        """`PBxxyyrgba`: sets a pixel in ten bytes: PB, x and y as u16 little-endian, r, g, b, a;
        no newline.
        """
        self._binary("PB", x, y, _rgba(color))

    def pxmulti(self, x, y, rgba):
        """`PXMULTIxxyynnnn`: then nnnn (u32) times rgba: a run of pixels from (x,y) on, wrapping
        at row ends.
        """
        self._binary("PXMULTI", x, y, _run(rgba))

    def offset(self, x, y):
        """`OFFSET x y`: moves all later text PX of this connection; replaces the last."""
        self._send_verb("OFFSET", x, y)

    def stats(self):
        """`STATS`: answers one line of key=value."""
        return self.ask("STATS")

    def quit(self):
        """`QUIT`: ends the connection."""
        self._send_verb("QUIT")

    def poke(self, offset, hexbytes):
        """`POKE offset hexbytes`: writes bytes; offset = (width*y + x)*4, bytes R G B A."""
        self._send_verb("POKE", offset, _hex(hexbytes))

    def peek(self, offset, n):
        """`PEEK offset n`: answers PEEK offset hexbytes."""
        return self.ask("PEEK", offset, n)

    def blit(self, x, y, w, h, rgba):
        """`BLIT x y w h :N`: draws a rectangle of RGBA rows, N = w*h*4 bytes."""
        self._send_verb("BLIT", x, y, w, h, payload=rgba)

    def read(self, x, y, w, h):
        """`READ x y w h`: answers READ x y w h :N and the RGBA rows."""
        return self._ask_bytes("READ", x, y, w, h)

    def copy(self, sx, sy, w, h, dx, dy):
        """`COPY sx sy w h dx dy`: copies a rectangle, as through a temporary copy."""
        self._send_verb("COPY", sx, sy, w, h, dx, dy)

    def points(self, packed):
        """`POINTS :N`: draws packed pixels, 8 bytes each: x and y as u16 little-endian, r, g, b,
        a.
        """
        self._send_verb("POINTS", payload=packed)

    def crc(self, x=None, y=None, w=None, h=None):
        """`CRC [x y w h]`: answers CRC xxxxxxxx, the CRC-32 of the RGBA bytes."""
        return self.ask("CRC", *_words(x, y, w, h))

    def clear(self, colour=None):
        """`CLEAR [colour]`: fills the frame (default 000000ff) and clears the depth."""
        self._send_verb("CLEAR", _colour(colour))

    def line(self, x0, y0, x1, y1, c0, c1=None):
        """`LINE x0 y0 x1 y1 c0 [c1]`: draws a line, both ends lit; with c1 the colour runs from
        c0 to c1.
        """
        self._send_verb("LINE", x0, y0, x1, y1, _colour(c0), _colour(c1))

    def tri(self, x0, y0, x1, y1, x2, y2, c0, c1=None, c2=None):
        """`TRI x0 y0 x1 y1 x2 y2 c0 [c1 c2]`: draws a triangle's three lines."""
        self._send_verb("TRI", x0, y0, x1, y1, x2, y2, _colour(c0), _colour(c1), _colour(c2))

    def fill(self, x0, y0, x1, y1, x2, y2, c0, c1=None, c2=None):
        """`FILL x0 y0 x1 y1 x2 y2 c0 [c1 c2]`: fills a triangle, colours interpolated; reals."""
        self._send_verb("FILL", x0, y0, x1, y1, x2, y2, _colour(c0), _colour(c1), _colour(c2))

    def rect(self, x, y, w, h, c):
        """`RECT x y w h c`: draws the border of a rectangle."""
        self._send_verb("RECT", x, y, w, h, _colour(c))

    def fillrect(self, x, y, w, h, c):
        """`FILLRECT x y w h c`: fills the pixels with centres in [x,x+w) x [y,y+h); reals."""
        self._send_verb("FILLRECT", x, y, w, h, _colour(c))

    def circle(self, cx, cy, r, c):
        """`CIRCLE cx cy r c`: draws a circle about a pixel."""
        self._send_verb("CIRCLE", cx, cy, r, _colour(c))

    def fillcircle(self, cx, cy, r, c):
        """`FILLCIRCLE cx cy r c`: fills the pixel centres nearer than r to a point; reals."""
        self._send_verb("FILLCIRCLE", cx, cy, r, _colour(c))

    def poly(self, c, *points):
        """`POLY c x0 y0 [x1 y1 ...]`: draws a closed outline."""
        self._send_verb("POLY", _colour(c), *points)

    def fillpoly(self, c, *points):
        """`FILLPOLY c x0 y0 [x1 y1 ...]`: fills a polygon, even-odd; reals."""
        self._send_verb("FILLPOLY", _colour(c), *points)

    def text(self, x, y, c, utf8):
        """`TEXT x y c :N`: writes N bytes of UTF-8 in 8x8 letters from the upper left corner
        (x,y).
        """
        self._send_verb("TEXT", x, y, _colour(c), payload=utf8)

    def print(self, x, y, c, text):
        """`PRINT x y c text ...`: writes the rest of the line as TEXT does; no :N is read in it."""
        self._send_verb("PRINT", x, y, _colour(c), text)

    def wideline(self, x0, y0, x1, y1, w, c):
        """`WIDELINE x0 y0 x1 y1 w c`: draws a line w wide with round ends: the pixel centres
        nearer than w/2; reals.
        """
        self._send_verb("WIDELINE", x0, y0, x1, y1, w, _colour(c))

    def ellipse(self, cx, cy, rx, ry, c):
        """`ELLIPSE cx cy rx ry c`: draws the rim of what FILLELLIPSE fills; reals."""
        self._send_verb("ELLIPSE", cx, cy, rx, ry, _colour(c))

    def fillellipse(self, cx, cy, rx, ry, c):
        """`FILLELLIPSE cx cy rx ry c`: fills the pixel centres inside an ellipse; reals."""
        self._send_verb("FILLELLIPSE", cx, cy, rx, ry, _colour(c))

    def arc(self, cx, cy, inner, outer, start, end, c):
        """`ARC cx cy inner outer start end c`: fills the part of a ring between two angles,
        clockwise from the right; reals.
        """
        self._send_verb("ARC", cx, cy, inner, outer, start, end, _colour(c))

    def bezier(self, x0, y0, x1, y1, x2, y2, x3, y3, w, c):
        """`BEZIER x0 y0 x1 y1 x2 y2 x3 y3 w c`: draws a cubic Bezier curve w wide with round
        ends; reals.
        """
        self._send_verb("BEZIER", x0, y0, x1, y1, x2, y2, x3, y3, w, _colour(c))

    def lineaa(self, x0, y0, x1, y1, c):
        """`LINEAA x0 y0 x1 y1 c`: draws an anti-aliased line by exact coverage; reals."""
        self._send_verb("LINEAA", x0, y0, x1, y1, _colour(c))

    def blend(self, mode):
        """`BLEND replace|over`: stores colours as they are, or composes them source-over."""
        self._send_verb("BLEND", mode)

    def clip(self, *rect):
        """`CLIP x y w h`: lets later drawing of this connection touch a rectangle alone.

        `CLIP OFF`: lets it touch everything.
        """
        self._send_verb("CLIP", *rect)

    def canvas(self, name, w, h):
        """`CANVAS name w h`: makes a transparent off-screen frame, with a depth of its own."""
        self._send_verb("CANVAS", name, w, h)

    def target(self, name):
        """`TARGET name|FRAME`: draws and reads later on a canvas, or on the frame again."""
        self._send_verb("TARGET", name)

    def stamp(self, name, x, y, c=None):
        """`STAMP name x y [c]`: puts a canvas with its upper left corner at (x,y), but for its
        pixels of colour c.
        """
        self._send_verb("STAMP", name, x, y, _colour(c))

    def textsize(self, size):
        """`TEXTSIZE 1|2|3|4|5|6|7|8`: makes the letters of TEXT and PRINT so many times as
        large.
        """
        self._send_verb("TEXTSIZE", size)

    def image(self, x, y, file):
        """`IMAGE x y :N`: puts a PNG or JPEG picture with its upper left corner at (x,y)."""
        self._send_verb("IMAGE", x, y, payload=file)

    def mesh(self, name, *source, payload=None):
        """`MESH name OBJ :N`: makes a mesh from the N bytes of an OBJ file.

        `MESH name BOX [x y z]`: makes a box (2 2 2).

        `MESH name SPHERE [r]`: makes a sphere (1).

        `MESH name CONE [r h]`: makes a cone (1 2).

        `MESH name CYLINDER [r h]`: makes a cylinder (1 2).

        `MESH name TEAPOT [level]`: makes Newell's teapot, each patch cut level x level.

        `MESH name KNOT nu nv`: makes a torus knot of nu x nv quads.
        """
        self._send_verb("MESH", name, *source, payload=payload)

    def tex(self, name, file):
        """`TEX name :N`: makes a texture from the N bytes of a PNG or JPEG file."""
        self._send_verb("TEX", name, payload=file)

    def scene(self, x3d):
        """`SCENE X3D :N`: replaces camera, lights and objects by those of an X3D file."""
        self._send_verb("SCENE", "X3D", payload=x3d)

    def eye(self, name, json):
        """`EYE name :N`: makes an N-dimensional scene from JSON."""
        self._send_verb("EYE", name, payload=json)

    def free(self, name):
        """`FREE name`: forgets a mesh, texture, scene or canvas."""
        self._send_verb("FREE", name)

    def load(self, kind, *name_and_path):
        """`LOAD MESH|TEX name path`: loads a file of the server's own folder.

        `LOAD SCENE path`: loads an X3D file of the server's own folder.
        """
        self._send_verb("LOAD", kind, *name_and_path)

    def lookat(self, ex, ey, ez, rx, ry, rz, ux, uy, uz):
        """`LOOKAT ex ey ez rx ry rz ux uy uz`: puts the eye at e, looking at r, u up."""
        self._send_verb("LOOKAT", ex, ey, ez, rx, ry, rz, ux, uy, uz)

    def perspective(self, fov, near, far, on_smaller_side=False):
        """`PERSPECTIVE fov near far [FOVMIN]`: sees in perspective; the angle is vertical, or on
        the smaller side.
        """
        self._send_verb("PERSPECTIVE", fov, near, far, "FOVMIN" if on_smaller_side else None)

    def plane(self, d, near, far):
        """`PLANE d near far`: sees in perspective on a view plane at distance d."""
        self._send_verb("PLANE", d, near, far)

    def frustum(self, l, r, b, t, near, far):
        """`FRUSTUM l r b t near far`: sees in perspective through a window at the near plane."""
        self._send_verb("FRUSTUM", l, r, b, t, near, far)

    def ortho(self, l, r, b, t, near, far):
        """`ORTHO l r b t near far`: sees in parallel."""
        self._send_verb("ORTHO", l, r, b, t, near, far)

    def oblique(self, kind, angle, l, r, b, t, near, far):
        """`OBLIQUE cavalier|cabinet angle l r b t near far`: sees in oblique parallel."""
        self._send_verb("OBLIQUE", kind, angle, l, r, b, t, near, far)

    def isometric(self, l, r, b, t, near, far):
        """`ISOMETRIC l r b t near far`: sees isometrically."""
        self._send_verb("ISOMETRIC", l, r, b, t, near, far)

    def pseudoiso(self, l, r, b, t, near, far):
        """`PSEUDOISO l r b t near far`: sees pseudo-isometrically."""
        self._send_verb("PSEUDOISO", l, r, b, t, near, far)

    def window(self, vrp, p, vup, cu, cv, su, sv, dp, near, far):
        """`WINDOW vrp(3) p(3) vup(3) cu cv su sv dp near far`: sees by the viewing
        transformation.
        """
        self._send_verb("WINDOW", vrp, p, vup, cu, cv, su, sv, dp, near, far)

    def viewport(self, x, y, w, h, rule=None):
        """`VIEWPORT x y w h [centres|corners]`: puts the picture into a part of the frame."""
        self._send_verb("VIEWPORT", x, y, w, h, rule)

    def identity(self):
        """`IDENTITY`: resets the model matrix."""
        self._send_verb("IDENTITY")

    def push(self):
        """`PUSH`: keeps the model matrix."""
        self._send_verb("PUSH")

    def pop(self):
        """`POP`: brings back the model matrix kept last."""
        self._send_verb("POP")

    def translate(self, x, y, z):
        """`TRANSLATE x y z`: multiplies the model matrix on the right, as the next four do."""
        self._send_verb("TRANSLATE", x, y, z)

    def rotate(self, ax, ay, az, angle):
        """`ROTATE ax ay az angle`: turns about an axis; in radians, or as 45deg."""
        self._send_verb("ROTATE", ax, ay, az, angle)

    def scale(self, x, y, z):
        """`SCALE x y z`: scales along the axes."""
        self._send_verb("SCALE", x, y, z)

    def shear(self, xy, xz, yx, yz, zx, zy):
        """`SHEAR xy xz yx yz zx zy`: shears: x' = x + xy*y + xz*z and so on."""
        self._send_verb("SHEAR", xy, xz, yx, yz, zx, zy)

    def matrix(self, *matrix):
        """`MATRIX m00..m33`: sixteen numbers, row by row."""
        self._send_verb("MATRIX", *matrix)

    def ambient(self, *color):
        """`AMBIENT r g b`: sets the ambient light; colours of light are 0..1 and above.

        `AMBIENT name`: the same by a CSS name or #rrggbb; so may any r g b of LIGHT and
        MATERIAL be given.
        """
        self._send_verb("AMBIENT", *color)

    def light(self, index, *light):
        """`LIGHT i POINT x y z r g b [c l q]`: puts a light at a point, fading by 1/(c + l d + q
        d^2).

        `LIGHT i DIR dx dy dz r g b`: lets light fall in a direction.

        `LIGHT i SPOT x y z dx dy dz angle exponent r g b [c l q]`: puts a spot light.

        `LIGHT i OFF`: takes a light away.
        """
        self._send_verb("LIGHT", index, *light)

    def material(self, *material):
        """`MATERIAL ka(3) kd(3) ks(3) n [emissive(3) [transparency]]`: says how surfaces answer
        light.

        `MATERIAL ka kd ks n [emissive [transparency]]`: the same with names of colours.
        """
        self._send_verb("MATERIAL", *material)

    def texture(self, name, *sampling):
        """`TEXTURE name|OFF [nearest|bilinear|mipmap|trilinear] [repeat|clamp]`: lays a texture
        on what is drawn next.
        """
        self._send_verb("TEXTURE", name, *sampling)

    def shade(self, mode):
        """`SHADE wire|flat|gouraud|phong`: chooses how faces are coloured."""
        self._send_verb("SHADE", mode)

    def cull(self, mode):
        """`CULL back|front|none`: chooses the faces to leave out."""
        self._send_verb("CULL", mode)

    def hide(self, mode):
        """`HIDE zbuffer|painter|none`: chooses how hidden surfaces are found."""
        self._send_verb("HIDE", mode)

    def depth(self, format):
        """`DEPTH u16|u24|u32|f32|reversed`: chooses how depth is stored, and clears it."""
        self._send_verb("DEPTH", format)

    def interp(self, mode):
        """`INTERP perspective|affine`: chooses how values run across a face."""
        self._send_verb("INTERP", mode)

    def draw(self, name):
        """`DRAW name`: draws a mesh."""
        self._send_verb("DRAW", name)

    def drawscene(self, time=None, sorted=False):
        """`DRAWSCENE [time] [SORTED]`: draws the scene at a time, transparent faces in order or
        sorted.
        """
        self._send_verb("DRAWSCENE", time, "SORTED" if sorted else None)

    def draweye(self, name, x, y, w, h):
        """`DRAWEYE name x y w h`: draws an N-dimensional scene into a rectangle."""
        self._send_verb("DRAWEYE", name, x, y, w, h)

    def quality(self, *quality):
        """`QUALITY exact`: draws exactly.

        `QUALITY max-error e [shift]`: draws more cheaply within e steps of colour and a shift
        in pixels.
        """
        self._send_verb("QUALITY", *quality)

    def depthat(self, x, y):
        """`DEPTHAT x y`: answers DEPTHAT x y z, 0 near and 1 far."""
        return self.ask("DEPTHAT", x, y)

    def pick(self, x, y):
        """`PICK x y`: answers PICK x y name|none triangle."""
        return self.ask("PICK", x, y)

    def sync(self, tag):
        """`SYNC tag`: answers SYNC tag when all before it is done."""
        return self.ask("SYNC", tag)

    def hello(self):
        """`HELLO`: answers HELLO fbptr 1 width height stride rgba."""
        return self.ask("HELLO")

    def version(self):
        """`VERSION`: answers VERSION and the program's version."""
        return self.ask("VERSION")

    def title(self, text):
        """`TITLE text ...`: names the window by the rest of the line; no :N is read in it."""
        self._send_verb("TITLE", text)

    def wait(self, seconds):
        """`WAIT seconds`: pauses this connection alone, at most 60 s; not where no window is."""
        self._send_verb("WAIT", seconds)

    def auto(self, mode):
        """`AUTO on|off`: shows the memory as it changes, or only at PRESENT."""
        self._send_verb("AUTO", mode)

    def events(self, mode):
        """`EVENTS on|off`: asks for EVENT lines: keys, text, mouse, resize, close."""
        self._send_verb("EVENTS", mode)

    def errors(self, mode):
        """`ERRORS count|report|close`: settles whether errors are counted, reported, or end the
        connection.
        """
        self._send_verb("ERRORS", mode)

    # The end of what is made from the verb table


class Client(Verbs):
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
        self._events = []
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

    def _send_verb(self, verb, *words, payload=None):
        """Sends a verb with its words, spread as by `_words`, and its payload."""
        data = None if payload is None else _bytes(payload)
        return self.command(verb, *_words(*words), payload=data)

    def _binary(self, verb, x, y, data):
        """Sends a binary verb: x and y as u16, and further bytes."""
        encoded = verb.encode("ascii") + struct.pack("<HH", x, y) + data
        place = self._sent
        self._sent += len(encoded)
        self._send(encoded)
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
                self._events.append(words[1:])
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

    def help(self):
        """Returns the lines of `HELP`."""
        self.command("HELP")
        self._syncs += 1
        end = "SYNC s%d" % self._syncs
        self.command("SYNC", end[len("SYNC "):])
        self.flush()
        lines = []
        while True:
            line = self._replies.readline()
            if not line.endswith(b"\n"):
                self._raise_errors()
                raise ConnectionError("the server ended the connection")
            text = line[:-1].decode("utf-8", "replace")
            words = text.split(" ")
            if text == end:
                self._raise_errors()
                return lines
            if words[0] == "ERR":
                self._keep_error(words)
            elif words[0] == "EVENT":
                self._events.append(words[1:])
            elif words[0] == "WARN":
                self._keep_warning(words)
            else:
                lines.append(text)

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
        self.events("on" if on else "off")

    def next_event(self):
        """Waits for the window's next event and returns its words, as ["mouse", "12", "30", "1"].

        `None` when the server ends.
        """
        self.flush()
        if self._events:
            return self._events.pop(0)
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

    def px(self, x, y, c=None):
        """Sets one pixel, or returns its (r, g, b) where no colour is given."""
        return self.get_pixel(x, y) if c is None else self.pixel(x, y, c)

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
        data = _bytes(rgba)
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
        data = _bytes(data)
        for at in range(0, len(data), 1024):
            self.command("POKE", offset + at, data[at : at + 1024].hex())

    def crc(self, *rect):
        """Returns the CRC-32 of the frame's (or a rectangle's) RGBA bytes."""
        return int(self.ask("CRC", *rect)[0], 16)

    def snap(self, name):
        """Writes the frame into the server's snapshot folder; returns (width, height, CRC-32)."""
        if name == ":":
            raise ValueError("`snapshot` returns the frame as a file")
        words = self.ask("SNAP", name)
        return int(words[1]), int(words[2]), int(words[3], 16)

    def snapshot(self, path=None):
        """Returns the frame as PNG bytes, and writes them to `path` if given."""
        data = self._ask_bytes("SNAP", ":")
        if path is not None:
            with open(path, "wb") as file:
                file.write(data)
        return data

    # -- two dimensions

    def fill(self, points, *colours):
        """Fills a triangle of three (x, y) in real coordinates, with one colour or three."""
        flat = [v for p in points for v in p]
        self.command("FILL", *flat, *map(colour, colours))

    # -- three dimensions

    def mesh(self, name, source, *sizes, payload=None):
        """Creates a mesh of this name.

        `source` is the bytes or the text of an OBJ file; or the word of a shape, as in
        `mesh("m", "BOX", 1, 2, 3)`, or `"OBJ"` with the file as `payload`.
        """
        if payload is None and not (isinstance(source, str) and source.isalpha()):
            source, payload = "OBJ", source
        self._send_verb("MESH", name, source, *sizes, payload=payload)

    def look_at(self, eye, reference=(0, 0, 0), up=(0, 1, 0)):
        """Places the camera."""
        self.command("LOOKAT", *eye, *reference, *up)

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
