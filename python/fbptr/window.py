"""A window in this process, and the picture of a framebuffer in it or in a notebook.

In: a function that draws a frame, or a framebuffer. Out: the frames on the screen, 60 a second. A
script that calls `run` takes `--headless` (no window, one frame or `--frames N`), and `--snap FILE`.
"""

from __future__ import annotations

from . import _native
from .framebuffer import Framebuffer

# What type checkers take for true: an import of `typing` would take half the time of the package's.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

Input = _native.Input


def run(width: int, height: int, draw: Callable[[Framebuffer, Input], Any]) -> Framebuffer:
    """Opens a window of `width` x `height` pixels and calls `draw(fb, input)` before each frame.

    Returns the framebuffer, with the last frame, when the window is closed or `input.close` is set;
    an exception of `draw` closes it, too. To be called on the main thread. Raises `OSError` if
    there is no window system.

        def draw(fb, input):
            fb.clear("navy")
            fb.fillcircle(*input.mouse, 20, "gold")

        fbptr.run(640, 480, draw)
    """
    fb = Framebuffer(width, height)
    _native.run(fb, lambda input: draw(fb, input))
    return fb


def show(fb: Framebuffer) -> None:
    """Shows a picture: in a notebook below the cell, where the next call of the cell replaces it,
    otherwise in a window until it is closed."""
    notebook = _notebook()
    if notebook is None:
        _native.run(fb, lambda input: None)
        return
    from IPython.display import display

    count = notebook.execution_count
    if getattr(fb, "_shown", None) != count:
        fb._shown = count
        display(fb, display_id="fbptr-%d-%s" % (id(fb), count))
    else:
        from IPython.display import update_display

        update_display(fb, display_id="fbptr-%d-%s" % (id(fb), count))


def _notebook():
    """Returns the shell of a notebook, or None elsewhere."""
    import sys

    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return shell if shell is not None and hasattr(shell, "kernel") else None
