"""The types of `fbptr.Framebuffer`.

Made from the verb table: BLESS=1 python -m pytest python/tests/test_stubs.py
"""

import os
from typing import Any, Literal, overload

from . import _native
from ._questions import Questions
from ._types import Bytes, Color, Colors, Number, Numbers
from ._verbs import Handy

class Framebuffer(Handy, Questions, _native.Framebuffer):
    def __init__(
        self,
        width: int = 640,
        height: int = 480,
        *,
        files: str | os.PathLike[str] | None = None,
        threads: int = 1,
    ) -> None: ...
    def show(self) -> None: ...
    @overload
    def run(self, text: str) -> str: ...
    @overload
    def run(self, text: bytes | bytearray | memoryview) -> bytes: ...

    def pb(self, x: Number, y: Number, color: Color) -> None:
        """`PBxxyyrgba`: sets a pixel in ten bytes: PB, x and y as u16 little-endian, r, g, b, a; no newline.

        x: whole number, pixels
        y: whole number, pixels
        color: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255
        """

    def pxmulti(self, x: Number, y: Number, rgba: Bytes | str) -> None:
        """`PXMULTIxxyynnnn`: then nnnn (u32) times rgba: a run of pixels from (x,y) on, wrapping at row ends.

        x: whole number, pixels
        y: whole number, pixels
        rgba: bytes, an array of bytes, or text in UTF-8
        """

    def offset(self, x: Number, y: Number) -> None:
        """`OFFSET x y`: moves all later text PX of this connection; replaces the last.

        x: whole number, pixels
        y: whole number, pixels
        """

    @overload
    def copy(self, sx: Number, sy: Number, w: Number, h: Number, dx: Number, dy: Number) -> None: ...
    @overload
    def copy(self, source: Numbers, dx: Number, dy: Number) -> None:
        """`COPY sx sy w h dx dy`: copies a rectangle, as through a temporary copy.

        sx: whole number, pixels
        sy: whole number, pixels
        w: whole number, pixels
        h: whole number, pixels
        dx: whole number, pixels
        dy: whole number, pixels
        """

    def clear(self, colour: Color = ...) -> None:
        """`CLEAR [colour]`: fills the frame (default 000000ff) and clears the depth.

        colour: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255 (may be left out)
        """

    @overload
    def line(self, x0: Number, y0: Number, x1: Number, y1: Number, c0: Color, c1: Color = ...) -> None: ...
    @overload
    def line(self, p0: Numbers, p1: Numbers, color: Colors) -> None:
        """`LINE x0 y0 x1 y1 c0 [c1]`: draws a line, both ends lit; with c1 the colour runs from c0 to c1.

        x0: whole number, pixels
        y0: whole number, pixels
        x1: whole number, pixels
        y1: whole number, pixels
        c0: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255
        c1: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255 (may be left out)
        """

    @overload
    def tri(
        self,
        x0: Number,
        y0: Number,
        x1: Number,
        y1: Number,
        x2: Number,
        y2: Number,
        c0: Color,
        c1: Color = ...,
        c2: Color = ...,
    ) -> None: ...
    @overload
    def tri(self, points: Numbers, colors: Colors) -> None:
        """`TRI x0 y0 x1 y1 x2 y2 c0 [c1 c2]`: draws a triangle's three lines.

        x0: whole number, pixels
        y0: whole number, pixels
        x1: whole number, pixels
        y1: whole number, pixels
        x2: whole number, pixels
        y2: whole number, pixels
        c0: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255
        c1: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255 (may be left out)
        c2: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255 (may be left out)
        """

    @overload
    def fill(
        self,
        x0: Number | str,
        y0: Number | str,
        x1: Number | str,
        y1: Number | str,
        x2: Number | str,
        y2: Number | str,
        c0: Color,
        c1: Color = ...,
        c2: Color = ...,
    ) -> None: ...
    @overload
    def fill(self, points: Numbers, colors: Colors) -> None:
        """`FILL x0 y0 x1 y1 x2 y2 c0 [c1 c2]`: fills a triangle, colours interpolated; reals.

        x0: number, pixels
        y0: number, pixels
        x1: number, pixels
        y1: number, pixels
        x2: number, pixels
        y2: number, pixels
        c0: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255
        c1: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255 (may be left out)
        c2: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255 (may be left out)
        """

    @overload
    def rect(self, x: Number, y: Number, w: Number, h: Number, c: Color) -> None: ...
    @overload
    def rect(self, rect: Numbers, color: Color) -> None:
        """`RECT x y w h c`: draws the border of a rectangle.

        x: whole number, pixels
        y: whole number, pixels
        w: whole number, pixels
        h: whole number, pixels
        c: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255
        """

    @overload
    def fillrect(self, x: Number | str, y: Number | str, w: Number | str, h: Number | str, c: Color) -> None: ...
    @overload
    def fillrect(self, rect: Numbers, color: Color) -> None:
        """`FILLRECT x y w h c`: fills the pixels with centres in [x,x+w) x [y,y+h); reals.

        x: number, pixels
        y: number, pixels
        w: number, pixels
        h: number, pixels
        c: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255
        """

    fill_rect = fillrect

    def circle(self, cx: Number, cy: Number, r: Number, c: Color) -> None:
        """`CIRCLE cx cy r c`: draws a circle about a pixel.

        cx: whole number, pixels
        cy: whole number, pixels
        r: whole number, pixels
        c: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255
        """

    def fillcircle(self, cx: Number | str, cy: Number | str, r: Number | str, c: Color) -> None:
        """`FILLCIRCLE cx cy r c`: fills the pixel centres nearer than r to a point; reals.

        cx: number, pixels
        cy: number, pixels
        r: number, pixels
        c: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255
        """

    fill_circle = fillcircle

    def poly(self, c: Color, *points: Any) -> None:
        """`POLY c x0 y0 [x1 y1 ...]`: draws a closed outline.

        c: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255
        points: numbers and words as the form says, also in tuples, lists and arrays, pixels
        """

    def fillpoly(self, c: Color, *points: Any) -> None:
        """`FILLPOLY c x0 y0 [x1 y1 ...]`: fills a polygon, even-odd; reals.

        c: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255
        points: numbers and words as the form says, also in tuples, lists and arrays, pixels
        """

    fill_poly = fillpoly

    def text(self, x: Number, y: Number, c: Color, utf8: Bytes | str) -> None:
        """`TEXT x y c :N`: writes N bytes of UTF-8 in 8x8 letters from the upper left corner (x,y).

        x: whole number, pixels
        y: whole number, pixels
        c: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255
        utf8: bytes, an array of bytes, or text in UTF-8
        """

    def print(self, x: Number, y: Number, c: Color, text: str) -> None:
        """`PRINT x y c text ...`: writes the rest of the line as TEXT does; no :N is read in it.

        x: whole number, pixels
        y: whole number, pixels
        c: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255
        text: one line of text
        """

    @overload
    def wideline(
        self,
        x0: Number | str,
        y0: Number | str,
        x1: Number | str,
        y1: Number | str,
        w: Number | str,
        c: Color,
    ) -> None: ...
    @overload
    def wideline(self, p0: Numbers, p1: Numbers, width: Number | str, color: Color) -> None:
        """`WIDELINE x0 y0 x1 y1 w c`: draws a line w wide with round ends: the pixel centres nearer than w/2; reals.

        x0: number, pixels
        y0: number, pixels
        x1: number, pixels
        y1: number, pixels
        w: number, pixels
        c: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255
        """

    wide_line = wideline

    @overload
    def ellipse(
        self,
        cx: Number | str,
        cy: Number | str,
        rx: Number | str,
        ry: Number | str,
        c: Color,
    ) -> None: ...
    @overload
    def ellipse(self, center: Numbers, radii: Numbers, color: Color) -> None:
        """`ELLIPSE cx cy rx ry c`: draws the rim of what FILLELLIPSE fills; reals.

        cx: number, pixels
        cy: number, pixels
        rx: number, pixels
        ry: number, pixels
        c: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255
        """

    @overload
    def fillellipse(
        self,
        cx: Number | str,
        cy: Number | str,
        rx: Number | str,
        ry: Number | str,
        c: Color,
    ) -> None: ...
    @overload
    def fillellipse(self, center: Numbers, radii: Numbers, color: Color) -> None:
        """`FILLELLIPSE cx cy rx ry c`: fills the pixel centres inside an ellipse; reals.

        cx: number, pixels
        cy: number, pixels
        rx: number, pixels
        ry: number, pixels
        c: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255
        """

    fill_ellipse = fillellipse

    @overload
    def arc(
        self,
        cx: Number | str,
        cy: Number | str,
        inner: Number | str,
        outer: Number | str,
        start: Number | str,
        end: Number | str,
        c: Color,
    ) -> None: ...
    @overload
    def arc(self, center: Numbers, radii: Numbers, angles: Numbers, color: Color) -> None:
        """`ARC cx cy inner outer start end c`: fills the part of a ring between two angles, clockwise from the right; reals.

        cx: number, pixels
        cy: number, pixels
        inner: number, pixels
        outer: number, pixels
        start: number, radians, or text such as '45deg'
        end: number, radians, or text such as '45deg'
        c: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255
        """

    @overload
    def bezier(
        self,
        x0: Number | str,
        y0: Number | str,
        x1: Number | str,
        y1: Number | str,
        x2: Number | str,
        y2: Number | str,
        x3: Number | str,
        y3: Number | str,
        w: Number | str,
        c: Color,
    ) -> None: ...
    @overload
    def bezier(self, points: Numbers, width: Number | str, color: Color) -> None:
        """`BEZIER x0 y0 x1 y1 x2 y2 x3 y3 w c`: draws a cubic Bezier curve w wide with round ends; reals.

        x0: number, pixels
        y0: number, pixels
        x1: number, pixels
        y1: number, pixels
        x2: number, pixels
        y2: number, pixels
        x3: number, pixels
        y3: number, pixels
        w: number, pixels
        c: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255
        """

    @overload
    def lineaa(
        self,
        x0: Number | str,
        y0: Number | str,
        x1: Number | str,
        y1: Number | str,
        c: Color,
    ) -> None: ...
    @overload
    def lineaa(self, p0: Numbers, p1: Numbers, color: Color) -> None:
        """`LINEAA x0 y0 x1 y1 c`: draws an anti-aliased line by exact coverage; reals.

        x0: number, pixels
        y0: number, pixels
        x1: number, pixels
        y1: number, pixels
        c: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255
        """

    line_aa = lineaa

    def blend(self, mode: Literal["replace", "over"]) -> None:
        """`BLEND replace|over`: stores colours as they are, or composes them source-over.

        mode: one of "replace", "over"
        """

    def stamp(self, name: str, x: Number, y: Number, c: Color = ...) -> None:
        """`STAMP name x y [c]`: puts a canvas with its upper left corner at (x,y), but for its pixels of colour c.

        name: name without blanks
        x: whole number, pixels
        y: whole number, pixels
        c: colour: a name, "#rrggbb", or 3 or 4 numbers from 0 to 255 (may be left out)
        """

    def textsize(self, size: int | str) -> None:
        """`TEXTSIZE 1|2|3|4|5|6|7|8`: makes the letters of TEXT and PRINT so many times as large.

        size: one of "1", "2", "3", "4", "5", "6", "7", "8"
        """

    text_size = textsize

    def free(self, name: str) -> None:
        """`FREE name`: forgets a mesh, texture, scene or canvas.

        name: name without blanks
        """

    def load(self, kind: Literal["MESH", "TEX", "SCENE"], *name: Any) -> None:
        """`LOAD MESH|TEX name path`: loads a file of the server's own folder.
        `LOAD SCENE path`: loads an X3D file of the server's own folder.

        kind: one of "MESH", "TEX", "SCENE"
        name: numbers and words as the form says, also in tuples, lists and arrays, units of the world
        """

    def plane(self, d: Number | str, near: Number | str, far: Number | str) -> None:
        """`PLANE d near far`: sees in perspective on a view plane at distance d.

        d: number, units of the world
        near: number, units of the world
        far: number, units of the world
        """

    @overload
    def frustum(
        self,
        l: Number | str,
        r: Number | str,
        b: Number | str,
        t: Number | str,
        near: Number | str,
        far: Number | str,
    ) -> None: ...
    @overload
    def frustum(self, window: Numbers, near: Number | str, far: Number | str) -> None:
        """`FRUSTUM l r b t near far`: sees in perspective through a window at the near plane.

        l: number, units of the world
        r: number, units of the world
        b: number, units of the world
        t: number, units of the world
        near: number, units of the world
        far: number, units of the world
        """

    @overload
    def ortho(
        self,
        l: Number | str,
        r: Number | str,
        b: Number | str,
        t: Number | str,
        near: Number | str,
        far: Number | str,
    ) -> None: ...
    @overload
    def ortho(self, window: Numbers, near: Number | str, far: Number | str) -> None:
        """`ORTHO l r b t near far`: sees in parallel.

        l: number, units of the world
        r: number, units of the world
        b: number, units of the world
        t: number, units of the world
        near: number, units of the world
        far: number, units of the world
        """

    @overload
    def oblique(
        self,
        kind: Literal["cavalier", "cabinet"],
        angle: Number | str,
        l: Number | str,
        r: Number | str,
        b: Number | str,
        t: Number | str,
        near: Number | str,
        far: Number | str,
    ) -> None: ...
    @overload
    def oblique(
        self,
        kind: Literal["cavalier", "cabinet"],
        angle_rad: Number | str,
        window: Numbers,
        near: Number | str,
        far: Number | str,
    ) -> None:
        """`OBLIQUE cavalier|cabinet angle l r b t near far`: sees in oblique parallel.

        kind: one of "cavalier", "cabinet"
        angle: number, radians, or text such as '45deg'
        l: number, units of the world
        r: number, units of the world
        b: number, units of the world
        t: number, units of the world
        near: number, units of the world
        far: number, units of the world
        """

    @overload
    def isometric(
        self,
        l: Number | str,
        r: Number | str,
        b: Number | str,
        t: Number | str,
        near: Number | str,
        far: Number | str,
    ) -> None: ...
    @overload
    def isometric(self, window: Numbers, near: Number | str, far: Number | str) -> None:
        """`ISOMETRIC l r b t near far`: sees isometrically.

        l: number, units of the world
        r: number, units of the world
        b: number, units of the world
        t: number, units of the world
        near: number, units of the world
        far: number, units of the world
        """

    @overload
    def pseudoiso(
        self,
        l: Number | str,
        r: Number | str,
        b: Number | str,
        t: Number | str,
        near: Number | str,
        far: Number | str,
    ) -> None: ...
    @overload
    def pseudoiso(self, window: Numbers, near: Number | str, far: Number | str) -> None:
        """`PSEUDOISO l r b t near far`: sees pseudo-isometrically.

        l: number, units of the world
        r: number, units of the world
        b: number, units of the world
        t: number, units of the world
        near: number, units of the world
        far: number, units of the world
        """

    pseudo_iso = pseudoiso

    @overload
    def window(
        self,
        vrp: Number | str,
        p: Number | str,
        vup: Number | str,
        cu: Number | str,
        cv: Number | str,
        su: Number | str,
        sv: Number | str,
        dp: Number | str,
        near: Number | str,
        far: Number | str,
    ) -> None: ...
    @overload
    def window(
        self,
        vrp: Number | str,
        p: Number | str,
        vup: Number | str,
        center: Numbers,
        half: Numbers,
        dp: Number | str,
        near: Number | str,
        far: Number | str,
    ) -> None:
        """`WINDOW vrp(3) p(3) vup(3) cu cv su sv dp near far`: sees by the viewing transformation.

        vrp: number, units of the world
        p: number, units of the world
        vup: number, units of the world
        cu: number, units of the world
        cv: number, units of the world
        su: number, units of the world
        sv: number, units of the world
        dp: number, units of the world
        near: number, units of the world
        far: number, units of the world
        """

    @overload
    def viewport(
        self,
        x: Number,
        y: Number,
        w: Number,
        h: Number,
        rule: Literal["centres", "corners"] | None = ...,
    ) -> None: ...
    @overload
    def viewport(self, rect: Numbers, rule: Literal["centres", "corners"] | None = ...) -> None:
        """`VIEWPORT x y w h [centres|corners]`: puts the picture into a part of the frame.

        x: whole number, pixels
        y: whole number, pixels
        w: whole number, pixels
        h: whole number, pixels
        rule: one of "centres", "corners" (may be left out)
        """

    def identity(self) -> None:
        """`IDENTITY`: resets the model matrix."""

    def push(self) -> None:
        """`PUSH`: keeps the model matrix."""

    def pop(self) -> None:
        """`POP`: brings back the model matrix kept last."""

    @overload
    def translate(self, x: Number | str, y: Number | str, z: Number | str) -> None: ...
    @overload
    def translate(self, by: Numbers) -> None:
        """`TRANSLATE x y z`: multiplies the model matrix on the right, as the next four do.

        x: number, units of the world
        y: number, units of the world
        z: number, units of the world
        """

    @overload
    def shear(
        self,
        xy: Number | str,
        xz: Number | str,
        yx: Number | str,
        yz: Number | str,
        zx: Number | str,
        zy: Number | str,
    ) -> None: ...
    @overload
    def shear(self, by: Numbers) -> None:
        """`SHEAR xy xz yx yz zx zy`: shears: x' = x + xy*y + xz*z and so on.

        xy: number, factor
        xz: number, factor
        yx: number, factor
        yz: number, factor
        zx: number, factor
        zy: number, factor
        """

    def matrix(self, *matrix: Any) -> None:
        """`MATRIX m00..m33`: sixteen numbers, row by row.

        matrix: numbers and words as the form says, also in tuples, lists and arrays, 4 x 4, row by row
        """

    def shade(self, mode: Literal["wire", "flat", "gouraud", "phong"]) -> None:
        """`SHADE wire|flat|gouraud|phong`: chooses how faces are coloured.

        mode: one of "wire", "flat", "gouraud", "phong"
        """

    def cull(self, mode: Literal["back", "front", "none"]) -> None:
        """`CULL back|front|none`: chooses the faces to leave out.

        mode: one of "back", "front", "none"
        """

    def hide(self, mode: Literal["zbuffer", "painter", "none"]) -> None:
        """`HIDE zbuffer|painter|none`: chooses how hidden surfaces are found.

        mode: one of "zbuffer", "painter", "none"
        """

    def interp(self, mode: Literal["perspective", "affine"]) -> None:
        """`INTERP perspective|affine`: chooses how values run across a face.

        mode: one of "perspective", "affine"
        """

    def drawscene(self, time: Number | str = ..., sorted: bool = ...) -> None:
        """`DRAWSCENE [time] [SORTED]`: draws the scene at a time, transparent faces in order or sorted.

        time: number, seconds (may be left out)
        sorted: True or False (may be left out)
        """

    draw_scene = drawscene

    @overload
    def draweye(self, name: str, x: Number, y: Number, w: Number, h: Number) -> None: ...
    @overload
    def draweye(self, name: str, rect: Numbers) -> None:
        """`DRAWEYE name x y w h`: draws an N-dimensional scene into a rectangle.

        name: name without blanks
        x: whole number, pixels
        y: whole number, pixels
        w: whole number, pixels
        h: whole number, pixels
        """

    draw_eye = draweye

    def hello(self) -> list[str]:
        """`HELLO`: answers HELLO fbptr 1 width height stride rgba."""

    def version(self) -> list[str]:
        """`VERSION`: answers VERSION and the program's version."""

    def title(self, text: str) -> None:
        """`TITLE text ...`: names the window by the rest of the line; no :N is read in it.

        text: one line of text
        """

    def wait(self, seconds: Number | str) -> None:
        """`WAIT seconds`: pauses this connection alone, at most 60 s; not where no window is.

        seconds: number, seconds
        """

    def auto(self, mode: bool | str) -> None:
        """`AUTO on|off`: shows the memory as it changes, or only at PRESENT.

        mode: one of "on", "off"
        """
