"""Verbs with handier arguments or results than those of the table.

In: what a Python program has at hand: tuples, arrays, meshes, paths. Out: calls of the verbs.
"""

from __future__ import annotations

import os

from . import _native
from ._native import light_colour, verbs
from .shapes import Mesh, obj

# What type checkers take for true: an import of `typing` would take half the time of the package's.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable
    from typing import Any

    import numpy

    from ._types import Bytes, Color, LightColor, Number, Numbers, Source

_INDEX = {row[0]: index for index, row in enumerate(verbs())}
_SHAPES = ("OBJ", "BOX", "SPHERE", "CONE", "CYLINDER", "TEAPOT", "KNOT")
_AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}
_LIGHTS = {"point": "POINT", "dir": "DIR", "direction": "DIR", "directional": "DIR", "spot": "SPOT", "off": "OFF"}


def _is_path(source, begins):
    """Returns whether a source is a path, and not the file itself, which begins with `begins`."""
    if isinstance(source, os.PathLike):
        return True
    return isinstance(source, str) and "\n" not in source and not source.lstrip().startswith(begins)


def _file(source, begins=("\0",)):
    """Returns the bytes of a source: a path, or the file itself."""
    if _is_path(source, begins):
        with open(source, "rb") as file:
            return file.read()
    return source


def _light(value, what="a colour of light"):
    """Returns the red, green and blue of a colour of light: a name, "#rrggbb", three numbers, or
    one for a grey; 1 is full.
    """
    if isinstance(value, str):
        found = light_colour(value)
        if found is None:
            raise _refused("ECOLOUR", "LIGHT", "%s is a name, \"#rrggbb\" or numbers, got %r" % (what, value))
        return found
    try:
        return (float(value),) * 3
    except TypeError:
        pass
    found = tuple(map(float, value))
    if len(found) != 3:
        raise _refused("ECOLOUR", "LIGHT", "%s has 3 numbers, not %d" % (what, len(found)))
    return found


def _refused(code, verb, why):
    from .errors import refused

    return refused([(0, 0, verb, code, why)])


def _batch(numbers, color):
    """Returns the numbers of many figures as doubles, and their colours as bytes R, G, B, A."""
    if hasattr(numbers, "__array_interface__"):
        import numpy

        numbers = numpy.ascontiguousarray(numbers, numpy.float64).reshape(-1)
    else:
        from array import array

        numbers = array("d", _flat(numbers))
    shape = getattr(color, "shape", ())
    if len(shape) == 2 and shape[1] in (3, 4):
        import numpy

        color = numpy.asarray(color, numpy.uint8)
        if shape[1] == 3:
            color = numpy.concatenate([color, numpy.full((shape[0], 1), 255, numpy.uint8)], axis=1)
        return numbers, numpy.ascontiguousarray(color).reshape(-1)
    is_one = isinstance(color, (str, bytes)) or not any(hasattr(part, "__len__") for part in color)
    return numbers, b"".join(map(_rgba, [color] if is_one else color))


def _flat(values):
    """Returns the numbers of nested lists, tuples and arrays in their order."""
    for value in values:
        if hasattr(value, "__iter__"):
            yield from _flat(value)
        else:
            yield value


def _rgba(color):
    """Returns the bytes R, G, B, A of a colour."""
    found = _native.colour(color) if isinstance(color, str) else tuple(color)
    if found is None or len(found) not in (3, 4):
        raise _refused("ECOLOUR", "PX", "a colour is a name, \"#rrggbb\" or 3 or 4 numbers, got %r" % (color,))
    return bytes(found) + b"\xff"[: 4 - len(found)]


def _triple(value, what, verb):
    if isinstance(value, str) and value in _AXES:
        return _AXES[value]
    try:
        found = tuple(float(v) for v in value)
    except (TypeError, ValueError):
        found = ()
    if len(found) != 3:
        raise _refused("EARGS", verb, "%s has 3 numbers, got %r" % (what, value))
    return found


# At run time the class is mixed with the engine's; a type checker sees it as one of them.
if TYPE_CHECKING:
    _Base = _native.Framebuffer
else:
    _Base = object


class Handy(_Base):
    """Methods of verbs, beside those that are made from the table alone."""

    __slots__ = ()

    def _call(self, verb: str, *args: Any, **kwargs: Any) -> Any:
        return self._verb(_INDEX[verb], args, kwargs)

    def _ask(self, verb: str, *args: Any, **kwargs: Any) -> list[str]:
        return self._verb(_INDEX[verb], args, kwargs).decode().split()[1:]

    # -- pixels and bytes

    def px(self, x: Any, y: Any = None, color: Color | None = None) -> tuple[int, ...] | None:
        """Sets the pixel (x, y), two numbers or a pair, to a colour; returns its (r, g, b) where no
        colour is given.
        """
        reply = self._call("PX", x, *(value for value in (y, color) if value is not None))
        return None if reply is None else tuple(bytes.fromhex(reply.decode().split()[3]))

    def pixel(self, x: Number, y: Number, color: Color) -> None:
        """Sets pixel (x, y) to a colour; off the frame it does nothing."""
        self._call("PX", x, y, color)

    put_pixel = pixel

    def get_pixel(self, x: int, y: int) -> tuple[int, ...]:
        """Returns the (r, g, b, a) of pixel (x, y) of the target, each 0 to 255."""
        return tuple(self.read(x, y, 1, 1))

    def pixels(self, items: Iterable[tuple[int, int, Iterable[int]]]) -> None:
        """Sets many pixels at once, from an iterable of (x, y, (r, g, b[, a]))."""
        from struct import Struct

        pack = Struct("<HH4B").pack
        self._call("POINTS", b"".join(pack(x, y, *(tuple(c) + (255,))[:4]) for x, y, c in items))

    def points(self, points: Any, color: Any = None) -> None:
        """Sets many pixels to a colour, or each to its own: `points` is an array or a list of shape
        (n, 2), `color` a colour, or an array or a list of n colours. Without a colour, `points` is the
        bytes of POINTS.
        """
        if color is None:
            self._call("POINTS", points)
        else:
            self._batch("points", *_batch(points, color))

    def lines(self, ends: Any, color: Any) -> None:
        """Draws many lines as `line` does: `ends` is an array or a list of shape (n, 4), x0, y0, x1, y1
        of each; `color` is one colour, or an array or a list of n colours.
        """
        self._batch("lines", *_batch(ends, color))

    def rects(self, rects: Any, color: Any) -> None:
        """Fills many rectangles as `fillrect` does: shape (n, 4), x, y, w, h of each; colours as of
        `lines`.
        """
        self._batch("rects", *_batch(rects, color))

    def discs(self, discs: Any, color: Any) -> None:
        """Fills many discs as `fillcircle` does: shape (n, 3), cx, cy, r of each; colours as of
        `lines`.
        """
        self._batch("discs", *_batch(discs, color))

    def peek(self, offset: int, n: int = 1) -> bytes:
        """Returns n bytes of video memory from byte `offset` = (width * y + x) * 4 on."""
        words = self._ask("PEEK", offset, n)
        return bytes.fromhex(words[1]) if len(words) > 1 else b""

    def poke(self, offset: int, data: Bytes | str) -> None:
        """Writes bytes into video memory from byte `offset` = (width * y + x) * 4 on."""
        self._call("POKE", offset, data)

    def read(self, x: int = 0, y: int = 0, w: int | None = None, h: int | None = None) -> bytes:
        """Returns the bytes of a rectangle, R, G, B, A of each pixel row by row; by default of the
        whole target.
        """
        if w is None or h is None:
            width, height = self._target_size()
            w, h = (width - x if w is None else w), (height - y if h is None else h)
        return self._call("READ", x, y, w, h).split(b"\n", 1)[1]

    def array(self, x: int = 0, y: int = 0, w: int | None = None, h: int | None = None) -> numpy.ndarray:
        """Returns a copy of a rectangle as a numpy array of shape (h, w, 4), dtype uint8."""
        import numpy

        if w is None or h is None:
            width, height = self._target_size()
            w, h = (width - x if w is None else w), (height - y if h is None else h)
        return numpy.frombuffer(self.read(x, y, w, h), numpy.uint8).reshape(h, w, 4).copy()

    def blit(self, x: int, y: int, w: Any = None, h: int | None = None, rgba: Any = None) -> None:
        """Writes RGBA rows at (x, y): `blit(x, y, w, h, data)`, or `blit(x, y, array)` with an array
        of shape (h, w, 4) or (h, w, 3), dtype uint8.
        """
        if h is None and rgba is None:
            w, rgba = None, w
        shape = getattr(rgba, "shape", None)
        if shape is not None and len(shape) == 3:
            if shape[2] == 3:
                import numpy

                opaque = numpy.full(shape[:2] + (1,), 255, numpy.uint8)
                rgba = numpy.concatenate([numpy.asarray(rgba, numpy.uint8), opaque], axis=2)
            if w is None:
                h, w = shape[:2]
        if w is None:
            raise _refused("EARGS", "BLIT", "w, h or the shape of an array say how large the picture is")
        self._call("BLIT", x, y, w, h, rgba)

    def crc(self, *rect: Numbers) -> int:
        """Returns the CRC-32 of the RGBA bytes of the target, or of a rectangle (x, y, w, h), as a
        number: that of `zlib.crc32(fb)` for the frame.
        """
        return int(self._ask("CRC", *rect)[0], 16)

    def size(self) -> tuple[int, int]:
        """Returns (width, height) of the frame in pixels."""
        w, h = self._ask("SIZE")
        return int(w), int(h)

    def clip(self, *rect: Numbers | str | None) -> None:
        """Lets later drawing touch a rectangle (x, y, w, h) alone; without one, all of the target."""
        self._call("CLIP", *(("OFF",) if rect in ((), (None,)) else rect))

    def target(self, name: str | None = None) -> None:
        """Draws and reads later on a canvas; without a name, on the frame again."""
        self._call("TARGET", name)

    def canvas(self, name: str, *size: Numbers, **sizes: Numbers) -> None:
        """Makes a transparent canvas of w x h pixels, with a depth of its own."""
        self._call("CANVAS", name, *size, **sizes)

    def image(self, x: Any, y: Any = None, file: Source | None = None) -> None:
        """Puts a PNG or JPEG picture at (x, y), or at a pair: its bytes, or a path to it."""
        if file is None:
            (x, y), file = x, y
        self._call("IMAGE", x, y, _file(file))

    # -- meshes, textures, scenes

    def mesh(
        self, name: str, source: Mesh | Source | None = None, *sizes: Number, payload: Bytes | None = None, **kwargs: Any
    ) -> None:
        """Makes a mesh of this name: of a `Mesh` (`fbptr.teapot()`, `fbptr.box(1, 2, 3)`), the word of a
        shape and its sizes ("sphere", 2), the bytes or the text of an OBJ file, a path to an OBJ, STL
        or PLY file, or `vertices=` and `faces=` as `fbptr.faces` takes them.
        """
        if kwargs:
            from .shapes import faces

            source = faces(kwargs.pop("vertices"), kwargs.pop("faces"), **kwargs)
        if isinstance(source, Mesh):
            self._call("MESH", name, *source.words, payload=source.data)
        elif isinstance(source, str) and source.upper() in _SHAPES:
            self._call("MESH", name, source, *sizes, payload=payload)
        elif source is None:
            raise _refused("EARGS", "MESH", "a mesh needs a source: a shape, a file, or vertices and faces")
        elif _is_path(source, ("\0",)):
            self._load_from("MESH " + _word(name, "MESH"), source)
        else:
            self._call("MESH", name, "OBJ", payload=obj(source).data)

    def tex(self, name: str, file: Source) -> None:
        """Makes a texture from a PNG or JPEG file: its bytes, or a path to it."""
        self._call("TEX", name, _file(file))

    def scene(self, source: Source, payload: Bytes | str | None = None) -> None:
        """Replaces camera, lights and objects by those of an X3D file: its text or bytes, or a path,
        beside which its textures are found.
        """
        if payload is not None:
            source = payload
        if _is_path(source, ("<",)):
            self._load_from("SCENE", source)
        else:
            self._call("SCENE", source)

    def eye(self, name: str, source: Source | dict[str, Any]) -> None:
        """Makes an N-dimensional scene from JSON: its text or bytes, a path to it, or a dict."""
        if isinstance(source, dict):
            import json

            source = json.dumps(source)
        self._call("EYE", name, _file(source, ("{", "[")))

    def _load_from(self, what: str, path: Any) -> None:
        folder, name = os.path.split(os.path.abspath(path))
        if not os.path.exists(path):
            raise FileNotFoundError(2, "no such file", os.fspath(path))
        if any(c.isspace() for c in name):
            raise _refused("EARGS", what.split()[0], "the file's name must have no blanks, got %r" % name)
        self._load(folder, "LOAD %s %s" % (what, name))

    # -- camera, lights, material, states

    def lookat(self, *eye: Numbers, reference: Numbers = (0, 0, 0), up: Numbers = (0, 1, 0), **kwargs: Any) -> None:
        """Puts the eye at a point, looking at another one, by default the origin; `up` is upwards."""
        if "eye" in kwargs:
            eye = (kwargs.pop("eye"),) + eye
        for other in ("at", "target", "center"):
            reference = kwargs.pop(other, reference)
        if kwargs:
            raise _refused("EARGS", "LOOKAT", "no argument %r is known" % next(iter(kwargs)))
        flat: list[Any] = []
        for value in eye:
            items: Any = value if hasattr(value, "__iter__") and not isinstance(value, str) else (value,)
            flat += items
        if len(flat) == 3:
            flat += [*_triple(reference, "reference", "LOOKAT"), *_triple(up, "up", "LOOKAT")]
        elif len(flat) == 6:
            flat += _triple(up, "up", "LOOKAT")
        self._call("LOOKAT", *flat)

    look_at = lookat

    def perspective(
        self, fov: Number | str = "45deg", near: Number = 0.1, far: Number = 100.0, on_smaller_side: bool = False
    ) -> None:
        """Sees in perspective: `fov` is the vertical angle of view."""
        self._call("PERSPECTIVE", fov, near, far, on_smaller_side)

    def rotate(self, *args: Any, axis: Numbers | str | None = None, angle: Number | str | None = None) -> None:
        """Turns about an axis (x, y, z), or "x", "y" or "z", by an angle."""
        if axis is None and args:
            is_one = args[0] in _AXES if isinstance(args[0], str) else hasattr(args[0], "__iter__")
            axis, args = (args[0], args[1:]) if is_one else (args[:3], args[3:])
        if angle is None and args:
            angle, args = args[0], args[1:]
        if angle is None or args:
            raise _refused("EARGS", "ROTATE", "takes an axis and an angle (ROTATE ax ay az angle)")
        self._call("ROTATE", _triple(axis, "axis", "ROTATE"), angle)

    def scale(self, *by: Numbers) -> None:
        """Scales along the axes: by three factors, or one for all."""
        self._call("SCALE", *(by * 3 if len(by) == 1 and not hasattr(by[0], "__iter__") else by))

    def ambient(self, *color: Any, **kwargs: LightColor) -> None:
        """Sets the ambient light: a name, "#rrggbb", three numbers, or one for a grey; 1 is full."""
        given: Any = color[0] if len(color) == 1 else color
        given = kwargs.pop("color", kwargs.pop("colour", given))
        if kwargs:
            raise _refused("EARGS", "AMBIENT", "no argument %r is known" % next(iter(kwargs)))
        self._call("AMBIENT", _light(given))

    def light(self, *args: Any, **kwargs: Any) -> int | None:
        """Puts a light: `light("point", (5, 6, 7))`, `light("dir", (0, -1, 0))`, `light("spot", position,
        direction, angle, exponent)`; `color=` (white), `attenuation=(c, l, q)`, `index=` (the lowest
        that is free). Returns the index. `light("off")` takes all lights away, `light("off", index=1)` one.
        """
        index = kwargs.pop("index", None)
        words = list(args)
        if words and not isinstance(words[0], str):
            index = words.pop(0)
        kind = words.pop(0) if words else kwargs.pop("kind", None)
        kind = _LIGHTS.get(str(kind).lower())
        if kind is None:
            raise _refused("EARGS", "LIGHT", "a light is \"point\", \"dir\", \"spot\" or \"off\"")
        if kind == "OFF":
            for i in range(self._light_count()) if index is None else (index,):
                self._call("LIGHT", i, "OFF")
            return index
        if index is None:
            index = self._free_light()
        self._call("LIGHT", index, kind, *_light_words(kind, words, kwargs))
        return index

    def material(self, *args: Any, **kwargs: LightColor) -> None:
        """Says how surfaces answer light: `material(ka, kd, ks, n)` in order, or `material(kd="gold",
        ks=0.5, n=30)`; also `emissive=` and `transparency=` (0 opaque to 1). What is left out is black,
        for `kd` 0.8, for `n` 1; `ka` is like `kd`.
        """
        if not args or kwargs:
            names = ("ka", "kd", "ks", "n", "emissive", "transparency")
            given = dict(zip(names, args))
            unknown = [name for name in kwargs if name not in names or name in given]
            if unknown or len(args) > len(names):
                raise _refused("EARGS", "MATERIAL", "no argument %r is known, or it was given twice" % (unknown or args)[0])
            given.update(kwargs)
            kd = given.get("kd", 0.8)
            args = (given.get("ka", kd), kd, given.get("ks", 0), given.get("n", 1))
            args += (given.get("emissive", 0), given.get("transparency", 0))
        if 4 <= len(args) <= 6:
            colours = [_light(c, "a colour of a material") for c in (*args[:3], *args[4:5])]
            args = (*colours[:3], args[3], *colours[3:], *args[5:])
        self._call("MATERIAL", *args)

    def texture(self, name: str | None = None, *sampling: str | None, **kwargs: str | None) -> None:
        """Lays a texture on what is drawn next; without a name, none. `filter=` and `wrap=` say how it
        is sampled.
        """
        words = [*sampling, kwargs.pop("filter", None), kwargs.pop("wrap", None), kwargs.pop("sampling", None)]
        self._call("TEXTURE", name, words, **kwargs)

    def quality(self, *quality: Any, max_error: Number | tuple[Number, Number] | None = None) -> None:
        """Draws exactly ("exact"), or more cheaply where that stays within `max_error` steps of colour,
        or steps of colour and a shift in pixels.
        """
        if quality and not isinstance(quality[0], str):
            max_error, quality = quality if len(quality) > 1 else quality[0], ()
        most = tuple(max_error) if isinstance(max_error, (tuple, list)) else (max_error,)
        self._call("QUALITY", *(("max-error", *most) if max_error is not None else quality or ("exact",)))

    def draw(self, name: str | Mesh, **states: Any) -> None:
        """Draws a mesh by its name, or a `Mesh`. Keyword arguments are states for this draw alone:
        `shade=`, `cull=`, `hide=`, `interp=`, `texture=`, `material=` (a dict or a tuple), `quality=`,
        `translate=`, `rotate=` (axis, angle), `scale=`, which act in this order.
        """
        if isinstance(name, Mesh):
            shape, name = name, "fbptr.Mesh-%x" % (hash(name) & 0xFFFFFFFFFFFF)
            made = self.__dict__.setdefault("_meshes", {})
            if made.get(name) != shape:
                self.mesh(name, shape)
                made[name] = shape
        if not states:
            self._call("DRAW", name)
            return
        unknown = [state for state in states if state not in _STATES]
        if unknown:
            raise _refused("EARGS", "DRAW", "no state %r is known: %s" % (unknown[0], ", ".join(_STATES)))
        self._push_states()
        try:
            for state in _STATES:
                if state in states:
                    value = states[state]
                    method = getattr(self, state)
                    if isinstance(value, dict):
                        method(**value)
                    elif isinstance(value, (tuple, list)):
                        method(*value)
                    else:
                        method(value)
            self._call("DRAW", name)
        finally:
            self._pop_states()

    def depth(self, format: str | None = None) -> Any:
        """Returns the depths as a numpy array of shape (height, width), dtype float64, 0 near to 1 far
        or never drawn; with a format, chooses how depth is stored, and clears it.
        """
        if format is not None:
            return self._call("DEPTH", format)
        import numpy

        return numpy.frombuffer(self._depths(), numpy.float64).reshape(self.height, self.width).copy()

    # -- queries and control

    def help(self, verb: str | None = None) -> str:
        """Returns what HELP says, as text."""
        return self._call("HELP", *(() if verb is None else (verb,))).decode()

    def stats(self) -> dict[str, int | str]:
        """Returns the counters as a dict."""
        pairs = (word.partition("=") for word in self._ask("STATS"))
        return {key: int(value) if value.isdigit() else value for key, _, value in pairs}

    def depthat(self, x: Any, y: Number | None = None) -> float:
        """Returns the depth of pixel (x, y), 0 near to 1 far or never drawn."""
        return float(self._ask("DEPTHAT", *((x,) if y is None else (x, y)))[2])

    depth_at = depthat

    def pick(self, x: Any, y: Number | None = None) -> tuple[str, int] | None:
        """Returns (name, triangle) of what is seen at pixel (x, y), or None."""
        _, _, name, triangle = self._ask("PICK", *((x,) if y is None else (x, y)))
        return None if triangle == "-1" else (name, int(triangle))

    def sync(self, tag: str = "-") -> str:
        """Returns the tag: a call here returns when its command is done."""
        return self._ask("SYNC", tag)[0]

    def present(self, wait: bool = False) -> int | None:
        """Ends a frame; returns its number with `wait`. There is no window in this process."""
        reply = self._call("PRESENT", wait)
        return int(reply.split()[1]) if reply else None

    def snap(self, name: str = ":") -> Any:
        """Writes the frame into the folder `files`, and returns (width, height, CRC-32); without a
        name, returns it as the bytes of a PNG file.
        """
        if name == ":":
            return self.png()
        words = self._ask("SNAP", name)
        return int(words[1]), int(words[2]), int(words[3], 16)

    def snapshot(self, path: str | os.PathLike[str] | None = None) -> bytes:
        """Returns the frame as the bytes of a PNG file, and writes them to `path` if given."""
        data = self.png()
        if path is not None:
            with open(path, "wb") as file:
                file.write(data)
        return data

    def quit(self) -> None:
        """Only for a server: raises `CommandError` (EPERM). There is no connection to end."""
        raise _refused("EPERM", "QUIT", "there is no connection to end: drop the framebuffer")

    def events(self, mode: bool | str = True) -> None:
        """Only for a server: raises `CommandError` (EPERM). There is no window that has events."""
        raise _refused("EPERM", "EVENTS", "there is no window here that has events: use Client and `fbptr serve`")

    def errors(self, mode: str | None = None) -> None:
        """Only for a server: raises `CommandError` (EPERM). Here each error is an exception."""
        raise _refused("EPERM", "ERRORS", "each error is an exception here")


#: States of a draw, in the order in which they act.
_STATES = ("quality", "material", "texture", "shade", "cull", "hide", "interp", "translate", "rotate", "scale")
#: Verbs that need a server, with the reason.
SERVER_ONLY = {
    "QUIT": "there is no connection to end",
    "EVENTS": "there is no window that has events",
    "ERRORS": "each error is an exception",
}
#: Verbs that do nothing here, with the reason.
WITHOUT_EFFECT = {
    "TITLE": "there is no window to name",
    "WAIT": "there is no window that shows what was drawn",
    "AUTO": "there is no window that shows what was drawn",
}


def _word(name, verb):
    if not isinstance(name, str) or not name or any(c.isspace() for c in name):
        raise _refused("EARGS", verb, "a name is one word without blanks, got %r" % (name,))
    return name


def _light_words(kind, args, kwargs):
    """Returns the words of a light after its kind."""
    colour = kwargs.pop("color", kwargs.pop("colour", None))
    fades = kwargs.pop("attenuation", None)
    groups = {"POINT": ["position"], "DIR": ["direction"], "SPOT": ["position", "direction"]}[kind]
    words, rest = [], list(args)
    for group in groups:
        if group in kwargs:
            words += _triple(kwargs.pop(group), group, "LIGHT")
        elif rest and hasattr(rest[0], "__iter__") and not isinstance(rest[0], str):
            words += _triple(rest.pop(0), group, "LIGHT")
        elif len(rest) >= 3:
            words += _triple(rest[:3], group, "LIGHT")
            del rest[:3]
        else:
            raise _refused("EARGS", "LIGHT", "a %s light needs its %s, 3 numbers" % (kind.lower(), group))
    if kind == "SPOT":
        for name, default in (("angle", 0.5), ("exponent", 1)):
            words.append(kwargs.pop(name) if name in kwargs else rest.pop(0) if rest else default)
    if kwargs:
        raise _refused("EARGS", "LIGHT", "no argument %r is known" % next(iter(kwargs)))
    if colour is None and rest:
        is_one = isinstance(rest[0], str) or hasattr(rest[0], "__iter__")
        colour = rest.pop(0) if is_one else rest[:3]
        del rest[: 0 if is_one else 3]
    words += _light(1 if colour is None else colour)
    return words + ([*fades] if fades is not None else rest)
