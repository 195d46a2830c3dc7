"""Animations: frames drawn by a function, as a GIF that a notebook shows.

In: a function of a framebuffer and a frame's number. Out: an `Animation`. Each frame has a palette of
its own; equal frames give equal bytes.
"""

from __future__ import annotations

import os

# What type checkers take for true: an import of `typing` would take half the time of the package's.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from typing import Any

    from .framebuffer import Framebuffer


class Animation:
    """A movie as the bytes of a GIF file; a notebook shows it."""

    __slots__ = ("data", "frames", "size", "rate", "crcs")

    def __init__(self, data: bytes, frames: int, size: tuple[int, int], rate: float, crcs: list[int]) -> None:
        #: Bytes of the GIF file.
        self.data = data
        #: Number of frames.
        self.frames = frames
        #: Width and height in pixels.
        self.size = size
        #: Frames a second.
        self.rate = rate
        #: CRC-32 of the RGBA bytes of each frame.
        self.crcs = crcs

    def __repr__(self):
        return "<fbptr.Animation %d frames, %dx%d, %d bytes>" % (self.frames, *self.size, len(self.data))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the GIF file."""
        with open(path, "wb") as file:
            file.write(self.data)

    def _repr_mimebundle_(self, include=None, exclude=None):
        from base64 import b64encode

        text = b64encode(self.data).decode()
        html = '<img src="data:image/gif;base64,%s" width="%d" height="%d"/>' % (text, *self.size)
        return {"image/gif": text, "text/html": html, "text/plain": repr(self)}


def animate(
    fn: Callable[[Framebuffer, Any], Any],
    frames: int | Iterable[Any],
    size: tuple[int, int] = (320, 240),
    rate: float = 25,
    *,
    fb: Framebuffer | None = None,
    path: str | os.PathLike[str] | None = None,
) -> Animation:
    """Calls `fn(fb, i)` for each frame i, and returns the frames as an `Animation`.

    `frames` is a number (i from 0), or an iterable of the values that `fn` is given. The framebuffer
    is cleared before each frame, and keeps its meshes, lights and camera; it has `size` (width,
    height) in pixels, unless `fb` is given. If `fn` returns a framebuffer, that is the frame.
    `rate` is in frames a second, at most 50. With `path` the file is kept there.
    """
    from tempfile import TemporaryDirectory

    from ._native import Movie
    from .framebuffer import Framebuffer

    if not callable(fn):
        raise TypeError("fn(fb, i) draws a frame, got %r" % (fn,))
    values = range(frames) if hasattr(frames, "__index__") else list(frames)
    if len(values) == 0:
        raise ValueError("an animation has at least one frame")
    fb = Framebuffer(*size) if fb is None else fb
    crcs = []
    with TemporaryDirectory() as folder:
        file = os.path.join(folder, "animation.gif")
        movie = Movie(file, fb.width, fb.height, rate)
        for value in values:
            fb.clear()
            drawn = fn(fb, value)
            frame = drawn if isinstance(drawn, Framebuffer) else fb
            crcs.append(movie.push(frame))
        movie.finish()
        with open(file, "rb") as made:
            data = made.read()
    animation = Animation(data, len(values), (fb.width, fb.height), rate, crcs)
    if path is not None:
        animation.save(path)
    return animation
