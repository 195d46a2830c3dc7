"""Meshes as values, for `Framebuffer.mesh` and `Framebuffer.draw`.

In: sizes in world units, or vertices and faces. Out: a `Mesh`, which is what the verb MESH takes.
"""

from __future__ import annotations

import os

# What type checkers take for true: an import of `typing` would take half the time of the package's.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable

    from ._types import Source


class Mesh:
    """A mesh that a framebuffer can make: a shape and its sizes, or the bytes of an OBJ file."""

    __slots__ = ("words", "data")

    def __init__(self, *words: str | float, data: bytes | None = None) -> None:
        self.words = words
        self.data = data

    def __repr__(self):
        size = "" if self.data is None else ", %d bytes" % len(self.data)
        return "Mesh(%s%s)" % (" ".join(map(str, self.words)), size)

    def __eq__(self, other):
        return isinstance(other, Mesh) and (self.words, self.data) == (other.words, other.data)

    def __hash__(self):
        return hash((self.words, self.data))


def teapot(level: int = 10) -> Mesh:
    """Newell's teapot, each of its patches cut into level x level quads."""
    return Mesh("TEAPOT", level)


def box(x: float = 2, y: float = 2, z: float = 2) -> Mesh:
    """A box of these sides, about the origin."""
    return Mesh("BOX", x, y, z)


def sphere(radius: float = 1) -> Mesh:
    """A sphere about the origin."""
    return Mesh("SPHERE", radius)


def cone(radius: float = 1, height: float = 2) -> Mesh:
    """A cone about the origin, its tip up (+y)."""
    return Mesh("CONE", radius, height)


def cylinder(radius: float = 1, height: float = 2) -> Mesh:
    """A cylinder about the origin, its axis upright (y)."""
    return Mesh("CYLINDER", radius, height)


def knot(nu: int = 200, nv: int = 20) -> Mesh:
    """A torus knot (2,3) of nu x nv quads."""
    return Mesh("KNOT", nu, nv)


def suzanne() -> Mesh:
    """Blender's monkey, 968 faces without normals."""
    from . import _native

    return Mesh("OBJ", data=_native.suzanne())


def models() -> list[str]:
    """The names of the built-in models, which `Scene.load` takes in place of a path."""
    from . import _native

    return _native.model_names()


def obj(source: Source) -> Mesh:
    """The mesh of an OBJ file: its bytes or its text, or a path to it.

    Text with a line feed is the file itself.
    """
    if isinstance(source, os.PathLike) or isinstance(source, str) and "\n" not in source:
        with open(source, "rb") as file:
            source = file.read()
    if hasattr(source, "__index__") and not hasattr(source, "tobytes"):
        # `bytes` would make that many zeros.
        raise TypeError("expected the bytes or the text of an OBJ file, or a path, got %r" % (source,))
    return Mesh("OBJ", data=source.encode() if isinstance(source, str) else bytes(source))


def faces(
    vertices: Iterable[Iterable[float]],
    faces: Iterable[Iterable[int]],
    normals: Iterable[Iterable[float]] | None = None,
    texcoords: Iterable[Iterable[float]] | None = None,
) -> Mesh:
    """The mesh of these faces.

    `vertices` is a sequence of (x, y, z), shape (n, 3), in world units; `faces` of lists of 3 or more
    indices of vertices from 0, counterclockwise as seen from the front. `normals` (n, 3) and
    `texcoords` (n, 2) belong to the vertices.
    """
    lines = ["v %r %r %r" % tuple(map(float, v)) for v in vertices]
    count = len(lines)
    corner = "%d"
    if texcoords is not None:
        lines += ["vt %r %r" % tuple(map(float, t)) for t in texcoords]
        corner = "%d/%d"
    if normals is not None:
        lines += ["vn %r %r %r" % tuple(map(float, n)) for n in normals]
        corner = "%d//%d" if texcoords is None else "%d/%d/%d"
    for face in faces:
        indices = [int(i) for i in face]
        if not all(0 <= i < count for i in indices):
            raise ValueError("a face has an index outside of 0..%d: %r" % (count, indices))
        lines.append("f " + " ".join(corner % ((i + 1,) * corner.count("%d")) for i in indices))
    return Mesh("OBJ", data=("\n".join(lines) + "\n").encode())
