"""Questions to a framebuffer, and its ways out: views, text streams, traces, files, goldens.

In: the native framebuffer. Out: Python values.
"""

from __future__ import annotations

from . import _native

# What type checkers take for true: an import of `typing` would take half the time of the package's.
TYPE_CHECKING = False
if TYPE_CHECKING:
    import os
    from typing import Any

    import numpy

# At run time the class is mixed with the engine's; a type checker sees it as one of them.
if TYPE_CHECKING:
    _Base = _native.Framebuffer
else:
    _Base = object


class Questions(_Base):
    """Methods of a framebuffer that are no verbs."""

    __slots__ = ()

    def run(self, text: Any) -> Any:
        """Runs a text of commands ("LINE 0 0 9 9 red\\nCRC\\n"), with payloads where they have some, and
        returns the replies: bytes for bytes, text for text, in which bytes of pictures that are no
        UTF-8 stand as surrogates. All commands run, then those that were refused raise one
        `CommandError`, whose `errors` are (line, byte, code, message) and whose `replies` are those
        of the others.
        """
        if isinstance(text, str):
            return self._run(text.encode("utf-8", "surrogateescape")).decode("utf-8", "surrogateescape")
        if isinstance(text, int):
            raise TypeError("a text of commands is str or bytes, got %r" % (text,))
        return self._run(bytes(text))

    def numpy(self, copy: bool = False) -> numpy.ndarray:
        """Returns the frame as a numpy array of shape (height, width, 4), dtype uint8: R, G, B, A of
        pixel (x, y) at [y, x]. It is the video memory itself, writable: what is drawn later is seen
        in it. The class says what other threads may do while it is held. With `copy` it is a copy.
        """
        import numpy

        if copy:
            # Not by a view: while one is held other threads may not draw, and numpy copies without
            # the interpreter's lock.
            taken = numpy.frombuffer(bytearray(self[:]), numpy.uint8)
            return taken.reshape(self.height, self.width, 4)
        return numpy.asarray(memoryview(self))

    def trace(self, x: Any = None, y: int | None = None, triangle: int | None = None) -> str:
        """Returns every number of the surface seen at pixel (x, y), from the corners of its triangle to
        its four bytes, as text; or of a triangle, counted from 0 through all draws since the last
        clear. Where `line`, `lineaa`, `circle`, `fill` or `fillpoly` drew the pixel later, the text has
        the numbers that decided it. Where none of them did, the text says so, and ends with the
        pixel's bytes.
        """
        if y is None and x is not None:
            x, y = x
        text = self._trace(None if x is None else (x, y), triangle)
        return self._not_traced(x, y, triangle) if text is None else text

    def _not_traced(self, x: int | None, y: int | None, triangle: int | None) -> str:
        """Returns what there is to say where no draw is found."""
        if triangle is not None or x is None or y is None:
            return "triangle %d: no draw since the last clear has it\n" % (triangle or 0)
        if not (0 <= x < self.width and 0 <= y < self.height):
            return "pixel (%d, %d) is off the frame of %d x %d\n" % (x, y, self.width, self.height)
        offset = (self.width * y + x) * 4
        r, g, b, a = self[offset : offset + 4]
        bytes_text = "%d %d %d %d = #%02x%02x%02x at FBptr[%d]" % (r, g, b, a, r, g, b, offset)
        return "pixel (%d, %d): no 3-D draw since the last clear gave it its colour\n  bytes       %s\n" % (x, y, bytes_text)

    def assert_golden(self, path: str | os.PathLike[str], tolerance: int = 0, pixels: int = 0) -> None:
        """Compares the frame with the PNG file at `path`; raises `AssertionError` if it differs.

        Up to `pixels` pixels may differ by more than `tolerance` (0 to 255) in a channel. A failure
        writes NAME.actual.png and NAME.diff.png beside the file. With BLESS=1 in the environment the
        file is written, and the assertion still fails, so that no run blesses unnoticed.
        """
        self._golden(path, tolerance, pixels)

    def _target_size(self) -> tuple[int, int]:
        return self._canvas_size() or (self.width, self.height)

    def _repr_png_(self) -> bytes:
        return self.png()
