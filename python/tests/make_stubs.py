"""Makes `fbptr/framebuffer.pyi` from the verb table.

In: the rows of the table. Out: one method a verb, with types, forms and units; the verbs with
handier methods are typed where they are written.
"""

import textwrap

from fbptr import _table
from fbptr._verbs import Handy

HEAD = '''"""The types of `fbptr.Framebuffer`.

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
'''

TYPES = {
    "integer": "Number", "real": "Number | str", "color": "Color", "flag": "bool", "hex": "Bytes | str",
    "text": "str", "payload": "Bytes | str", "word": "str",
}
RETURNS = {"never": "None", "line": "list[str]", "bytes": "bytes", "lines": "str", "form": "list[str] | None"}


def type_of(parameter):
    """Returns the type of one word."""
    if parameter.kind == "word":
        numbers = parameter.words and all(word.isdigit() for word in parameter.words)
        flags = "on" in parameter.words
        if not parameter.words or numbers or flags:
            return "int | str" if numbers else "bool | str" if flags else "str | None" if parameter.is_optional else "str"
        words = "Literal[%s]" % ", ".join('"%s"' % word for word in parameter.words)
        return words + " | None" if parameter.is_optional else words
    return TYPES[parameter.kind]


def by_words(row):
    """Returns the parameters word by word."""
    found = []
    for p in row.parameters:
        if p.kind == "many":
            found.append("*%s: Any" % p.name)
        else:
            kind = type_of(p)
            found.append("%s: %s%s" % (p.name, kind, " = ..." if p.is_optional else ""))
    return found


def by_fields(row):
    """Returns the parameters of the table, points as one value each."""
    found = []
    for p in row.parameters:
        if any(text.startswith((p.field + ":", "*" + p.field + ":")) for text in found):
            continue
        words = [q for q in row.parameters if q.field == p.field]
        if len(words) == 1:
            found.append(by_words(row)[row.parameters.index(p)].replace(p.name + ":", p.field + ":", 1))
        else:
            kind = "Colors" if p.kind == "color" else "Numbers"
            found.append("%s: %s%s" % (p.field, kind, " = ..." if p.is_optional else ""))
    return found


def method(row):
    """Returns the stub of a verb's method."""
    forms = [by_words(row)]
    fields = by_fields(row)
    if fields != forms[0] and len(fields) < len(forms[0]):
        forms.append(fields)
    lines = []
    for number, parameters in enumerate(forms):
        if len(forms) > 1:
            lines.append("    @overload")
        head = "    def %s(self, %s) -> %s:" % (row.name, ", ".join(parameters), RETURNS[row.reply])
        if len(head) > 110:
            body = "".join("        %s,\n" % p for p in parameters)
            head = "    def %s(\n        self,\n%s    ) -> %s:" % (row.name, body, RETURNS[row.reply])
        head = head.replace("(self, )", "(self)")
        if number + 1 < len(forms):
            lines.append(head + " ...")
            continue
        doc = textwrap.indent(row.doc().replace('"45deg"', "'45deg'"), " " * 8).lstrip()
        if "\n" in doc:
            doc += "\n" + " " * 8
        lines.append('%s\n        """%s"""' % (head, doc))
    if row.name in _table.ALIASES:
        lines.append("\n    %s = %s" % (_table.ALIASES[row.name], row.name))
    return "\n".join(lines) + "\n"


def text():
    """Returns the whole file."""
    rows = [row for row in _table.rows() if row.name not in Handy.__dict__]
    return HEAD + "".join("\n" + method(row) for row in rows)
