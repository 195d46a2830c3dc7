"""The verb table as Python sees it: names, parameters with kinds and units, docstrings.

In: rows of the engine's verb table. Out: for each verb a `Row`, from which the methods, their
docstrings and the type stubs are made.
"""

from ._native import verbs

# Kinds of numbers whose unit does not follow from the verb's group.
_UNITS = {
    "offset": "bytes", "n": "bytes", "angle": "radians, or text such as \"45deg\"",
    "fov": "radians, or text such as \"45deg\"", "start": "radians, or text such as \"45deg\"",
    "end": "radians, or text such as \"45deg\"", "seconds": "seconds", "time": "seconds",
    "xy": "factor", "xz": "factor", "yx": "factor", "yz": "factor", "zx": "factor", "zy": "factor",
    "size": "times 8 pixels", "args": "", "index": "from 0", "exponent": "",
}
_WORLD = "units of the world"
_GROUPS = {"Pixelflut": "pixels", "Memory": "pixels", "TwoD": "pixels", "ThreeD": _WORLD, "Control": "pixels"}
_PIXEL_VERBS = ("VIEWPORT", "DRAWEYE")
#: Second names of methods, whose words stand apart.
ALIASES = {
    "fillrect": "fill_rect", "fillcircle": "fill_circle", "fillpoly": "fill_poly", "fillellipse": "fill_ellipse",
    "wideline": "wide_line", "lineaa": "line_aa", "textsize": "text_size", "pseudoiso": "pseudo_iso",
    "drawscene": "draw_scene", "draweye": "draw_eye",
}
_FACTOR_VERBS = {"SCALE": "factor", "ROTATE": "direction", "MATRIX": "4 x 4, row by row"}


class Parameter:
    """A parameter of a method: its name, its kind and its unit."""

    __slots__ = ("name", "field", "kind", "is_optional", "unit", "words")

    def __init__(self, name, field, kind, is_optional, unit, words):
        self.name, self.field, self.kind = name, field, kind
        self.is_optional, self.unit, self.words = is_optional, unit, words

    def describe(self):
        """Returns what may be given, with its unit."""
        if self.kind == "integer":
            text = "whole number" + (", " + self.unit if self.unit else "")
        elif self.kind == "real":
            text = "number" + (", " + self.unit if self.unit else "")
        elif self.kind == "color":
            text = "colour: a name, \"#rrggbb\", or 3 or 4 numbers from 0 to 255"
        elif self.kind == "flag":
            text = "True or False"
        elif self.kind == "hex":
            text = "bytes, or text in hex"
        elif self.kind == "text":
            text = "one line of text"
        elif self.kind == "payload":
            text = "bytes, an array of bytes, or text in UTF-8"
        elif self.kind == "many":
            text = "numbers and words as the form says, also in tuples, lists and arrays"
            text += ", " + self.unit if self.unit else ""
        elif self.words:
            text = "one of " + ", ".join('"%s"' % word for word in self.words)
        else:
            text = "name without blanks"
        return text + (" (may be left out)" if self.is_optional and self.kind != "many" else "")


class Row:
    """A verb: its method's name, forms and parameters."""

    __slots__ = ("index", "verb", "name", "group", "is_binary", "reply", "forms", "example", "parameters")

    def __init__(self, index, row):
        self.index = index
        self.verb, self.group, self.is_binary, self.reply, self.forms, self.example, slots = row
        self.name = self.verb.lower()
        self.parameters = []
        for field, word, kind, is_optional, words in slots:
            if kind == "literal" or self.parameters and self.parameters[-1].name == word:
                continue
            unit = self._unit(word)
            self.parameters.append(Parameter(word, field, kind, is_optional, unit, words))

    def _unit(self, word):
        if word in _UNITS:
            return _UNITS[word]
        if self.verb in _FACTOR_VERBS:
            return _FACTOR_VERBS[self.verb]
        return "pixels" if self.verb in _PIXEL_VERBS else _GROUPS[self.group]

    def doc(self):
        """Returns the docstring: the verb's forms, then its parameters with their units."""
        lines = ["`%s`: %s." % (syntax, about) for syntax, about in self.forms]
        if self.parameters:
            lines.append("")
            lines += ["%s: %s" % (p.name, p.describe()) for p in self.parameters]
        return "\n".join(lines)


class Signature:
    """What `inspect.signature` finds behind a method made from the table: the parameters of its row.

    It is computed when somebody asks, since `inspect` takes longer to import than this package.
    """

    __slots__ = ("_row",)

    def __init__(self, row):
        self._row = row

    def __call__(self, *args, **kwargs):
        raise TypeError("%s is described, not called" % self._row.name)

    @property
    def __signature__(self):
        from inspect import Parameter as P
        from inspect import Signature as S

        found, may_be_left_out = [P("self", P.POSITIONAL_ONLY)], False
        for p in self._row.parameters:
            may_be_left_out = may_be_left_out or p.is_optional
            if p.kind == "many":
                found.append(P(p.name, P.VAR_POSITIONAL))
            else:
                kind = P.KEYWORD_ONLY if found[-1].kind is P.VAR_POSITIONAL else P.POSITIONAL_OR_KEYWORD
                found.append(P(p.name, kind, default=None if may_be_left_out else P.empty))
        return S(found)


def dedent(doc):
    """Returns a docstring without the indent of its source."""
    return "\n".join(line[8:] if line.startswith(" " * 8) else line for line in doc.rstrip().split("\n"))


def rows():
    """Returns the rows of the verb table, in its order."""
    return [Row(index, row) for index, row in enumerate(verbs())]
