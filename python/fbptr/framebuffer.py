"""The framebuffer of this process: a method for each verb of the command language, and more.

In: pixels, colours, meshes, text streams. Out: the video memory, replies as Python values, files.
The methods of verbs are made from the verb table; those below have handier arguments or results.
"""

from . import _native, _questions, _table
from ._verbs import Handy


class Framebuffer(Handy, _questions.Questions, _native.Framebuffer):
    """A frame of width x height pixels, opaque black, with the engine that draws on it.

    `files` is the folder that LOAD and SNAP of text streams may use; without it they are refused.
    `threads` draw at a time: 1 is the calling thread, 0 as many as the machine has. Other threads than
    the calling one do not survive `os.fork`: make such a framebuffer in the child.

    Colours are names ("gold"), "#rrggbb" or "rrggbb", or 3 or 4 numbers from 0 to 255. Points are
    pairs, or their numbers one after the other. Angles are radians, or text such as "45deg".

    Each thread may have framebuffers of its own, which draw at the same time: the interpreter's
    lock is released while something is drawn. A framebuffer that several threads share runs
    their calls one after the other, in no given order, with one set of states (camera, colours of
    light, clip). While a view of the memory (`numpy()`, `memoryview(fb)`) is held, only the thread
    that asked for it may use the framebuffer, others get `BufferError`, and drawing keeps the
    interpreter's lock, so that no Python code sees half a picture. Code without that lock (numpy on
    large arrays) must not use a view in one thread while another one draws: give it a copy,
    `numpy(copy=True)`.
    """

    __slots__ = ("__dict__", "__weakref__")

    def __repr__(self):
        return "<fbptr.Framebuffer %dx%d>" % (self.width, self.height)

    def show(self) -> None:
        """Shows the picture: in a notebook below the cell, where the next call replaces it, else in a
        window until it is closed."""
        from .window import show

        show(self)

    def __reduce__(self):
        raise TypeError("a Framebuffer cannot be pickled or copied: take fb.png() or fb.read()")


def _add_methods():
    """Adds the methods of verbs that have none yet."""
    call = _native.Framebuffer._verb
    for row in _table.rows():
        doc = row.doc()
        own = Handy.__dict__.get(row.name)
        if own is not None:
            own.__doc__ = "%s\n\n%s" % (_table.dedent(own.__doc__), doc) if own.__doc__ else doc
            continue
        method = _method(call, row, doc)
        setattr(Framebuffer, row.name, method)
        if row.name in _table.ALIASES:
            setattr(Framebuffer, _table.ALIASES[row.name], method)


def _method(call, row, doc):
    index, verb = row.index, row.verb
    if row.reply == "never":

        def method(self, /, *args, **kwargs):
            call(self, index, args, kwargs)

    elif row.reply == "bytes":

        def method(self, /, *args, **kwargs):
            return call(self, index, args, kwargs).split(b"\n", 1)[1]

    else:

        def method(self, /, *args, **kwargs):
            reply = call(self, index, args, kwargs)
            return None if reply is None else reply.decode().split()[1:]

    method.__name__ = row.name
    method.__qualname__ = "Framebuffer." + row.name
    method.__doc__ = doc
    method.__module__ = "fbptr"
    method.verb = verb
    method.__wrapped__ = _table.Signature(row)
    return method


_add_methods()
Framebuffer.__module__ = "fbptr"
