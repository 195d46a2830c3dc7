"""The window module of the course framework "Renderizador": the package's window in place of Matplotlib's.

In: a function that renders the scene and returns its colours. Out: a window in which it is called for
each frame, or, without a window, so many frames. The lists of geometry that the framework's reader of
scenes fills are kept, and not drawn.
"""

import sys


class Interface:
    """The window."""

    pontos = []
    linhas = []
    circulos = []
    poligonos = []

    # Set by `fbptr.course.renderizador`.
    headless = False
    frames = 1
    shown = None

    def __init__(self, width, height, filename=""):
        self.width = width
        self.height = height
        self.filename = filename
        self.image_saver = None

    def set_saver(self, image_saver):
        """Sets the function that saves the picture."""
        self.image_saver = image_saver

    def preview(self, pause, func):
        """Renders and shows: one frame if `pause`, else one after another until the window is closed."""
        # The module by the name that the student's code imports it by.
        gpu = sys.modules["gpu"]
        count = 1 if pause else Interface.frames
        for _ in range(count if Interface.headless else 1):
            Interface.shown = gpu.picture_of(func())
        if not Interface.headless:
            self._show(gpu, pause, func)

    def _show(self, gpu, pause, func):
        from .. import run

        first = [True]

        def draw(fb, _input):
            if not pause and not first[0]:
                Interface.shown = gpu.picture_of(func())
            first[0] = False
            fb.numpy()[:] = Interface.shown.numpy()

        run(Interface.shown.width, Interface.shown.height, draw)
