"""Exceptions and warnings of the framebuffer in this process.

In: the codes of the command language. Out: one exception class, `CommandError`, which is that of
`Client` too; where Python has a class for the reason, the exception is of both.
"""

import warnings

from .client import CommandError

__all__ = ["CommandError", "CommandWarning"]


class CommandWarning(UserWarning):
    """Warning of a command that ran, but probably not as it was meant, or of a file's faults."""


class RefusedError(CommandError):
    """A refused command, with the place and the reason of the first one.

    `code` is one of the protocol's codes, `verb` the verb, `line` and `byte` its place in the text
    that `run` was given (0 for a method, whose place is in the traceback), `reason` one line of text.
    `errors` holds (line, byte, code, message) of each refused command, `replies` the replies of
    those that ran.
    """

    def __init__(self, refused, replies=b""):
        errors = [(line, byte, code, "%s: %s" % (verb, why)) for line, byte, verb, code, why in refused]
        super().__init__(errors)
        self.line, self.byte, self.verb, self.code, self.reason = refused[0]
        self.replies = replies
        texts = []
        for line, _, verb, code, why in refused:
            place = "line %d: " % line if line else ""
            texts.append("%s%s %s: %s" % (place, code, verb, why))
        self.args = ("; ".join(texts),)
        self._refused = refused

    def __reduce__(self):
        return refused, (self._refused, self.replies)


class ArgumentError(RefusedError, TypeError):
    """Wrong number or kind of arguments (EARGS)."""


class RangeError(RefusedError, ValueError):
    """A value that the verb does not accept (ENUM, ECOLOUR, ERANGE, EFORMAT, EVERB, EPROTO)."""


class MissingError(RefusedError, LookupError):
    """No mesh, texture, canvas, scene or file of this name (ENOENT)."""


_CLASSES = {
    "EARGS": ArgumentError,
    "ENUM": RangeError,
    "ECOLOUR": RangeError,
    "ERANGE": RangeError,
    "EFORMAT": RangeError,
    "EVERB": RangeError,
    "EPROTO": RangeError,
    "ENOENT": MissingError,
}


def refused(all_refused, replies=b""):
    """Returns the exception for refused commands: (line, byte, verb, code, reason) of each."""
    return _CLASSES.get(all_refused[0][3], RefusedError)(all_refused, replies)


def warn(text):
    """Warns at the line of the program that called a method."""
    warnings.warn(text, CommandWarning, stacklevel=4)
