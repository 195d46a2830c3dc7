"""Frames of a scene file: X3D, glTF, OBJ, STL, PLY, or N-dimensional JSON.

In: a file, or its bytes, and the options of its frames. Out: frame k as pixels, PNG, CRC or file; any
frame, in any order, with the bytes that `fbptr render` gives it.
"""

from __future__ import annotations

import os

from . import _native

__all__ = ["Scene"]

# What type checkers take for true: an import of `typing` would take half the time of the package's.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    import numpy


class Scene(_native.Scene):
    """A scene file and the options of its frames.

        scene = fbptr.Scene.load("scene.x3d", frames=100, size=(640, 480))
        scene.write(7, "frame-0007.png")
        scene.crc(7)

    A frame depends on nothing but the scene, the options and its number. An animation is seen at
    `time + k / fps` seconds; a mesh makes one turn in `frames` frames; an N-dimensional scene turns
    by k / frames of each of `turns`, texts of two axes and degrees as in "0,3,360".
    """

    @classmethod
    def load(
        cls,
        source: str | os.PathLike[str] | bytes | bytearray | memoryview,
        *,
        format: str | None = None,
        name: str | None = None,
        root: str | os.PathLike[str] | None = None,
        **options: Any,
    ) -> Scene:
        """Returns the scene of a file's path, of a built-in model's name (`fbptr.models()`), or of
        the bytes of a file with their `format` ("x3d").

        Files that it names are read in the file's folder, or in `root`. Options: `frames`, `fps`,
        `time` in seconds, `size` as (width, height), `background` as a colour's name, `shade`
        ("wire", "flat", "gouraud", "phong"), `near` and `far` as distances to the planes, `turns`,
        `threads` (1; 0 is all cores).
        """
        data, format, name, root = read(source, format, name, root)
        scene = cls(data, format, name, folder=root, **options)
        return scene

    def png(self, frame: int) -> bytes:
        """Returns a frame as the bytes of a PNG."""
        return self.encoded(frame, "png")[1]

    def numpy(self, frame: int) -> numpy.ndarray:
        """Returns a frame as an array of shape (height, width, 4), uint8: R, G, B, A."""
        import numpy

        width, height = self.size
        return numpy.frombuffer(self.pixels(frame), numpy.uint8).reshape(height, width, 4)

    def __reduce__(self):
        raise TypeError("a Scene cannot be pickled or copied: send the file's path or bytes, and load it there")

    def _repr_png_(self) -> bytes:
        return self.png(0)


def read(source, format=None, name=None, root=None):
    """Returns the bytes, the format, the name and the folder of a scene that is a path or bytes."""
    if isinstance(source, (bytes, bytearray, memoryview)):
        if format is None:
            raise TypeError("bytes of a scene need their format, as in format='x3d'")
        return bytes(source), format, name or "scene." + format, root
    path = os.fspath(source)
    if format is None and isinstance(path, str) and path in _native.model_names() and not os.path.exists(path):
        return b"", "model", path, root
    with open(path, "rb") as file:
        data = file.read()
    ending = format or os.path.splitext(path)[1].lstrip(".")
    return data, ending, name or path, root or os.path.dirname(path) or "."
