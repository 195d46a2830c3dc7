"""Types of arguments, for type checkers."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from typing import Any, Protocol, SupportsFloat, SupportsIndex, Union


class _Buffer(Protocol):
    def __buffer__(self, flags: int, /) -> memoryview: ...


#: A number; those of numpy are.
Number = Union[SupportsFloat, SupportsIndex]
#: A point, several points, a matrix: numbers in tuples, lists and arrays, however nested.
Numbers = Union[Iterable[Any], Number]
#: A name, "#rrggbb", or 3 or 4 whole numbers from 0 to 255.
Color = Union[str, bytes, Sequence[int], Iterable[int]]
#: One colour, or several.
Colors = Union[Color, Iterable[Color]]
#: A colour of light: a name, "#rrggbb", 3 numbers, or one for a grey; 1 is full.
LightColor = Union[str, Number, Iterable[Number]]
#: Bytes, or an array of bytes.
Bytes = Union[bytes, bytearray, memoryview, _Buffer, Iterable[int]]
#: A path, or the bytes or the text of a file.
Source = Union[str, "os.PathLike[str]", Bytes]
