"""A framebuffer you can point at, in this process: pixels, lines, areas, meshes, scenes.

    import fbptr
    fb = fbptr.Framebuffer(640, 480)
    fb.clear("navy")
    fb.line(0, 0, 639, 479, "red", "gold")
    fb.fill([(20, 20), (600, 80), (300, 460)], ["red", "lime", "blue"])
    fb.save("picture.png")

`Framebuffer` has a method for each verb of the command language. The memory is `fb[offset]` with
offset = (width * y + x) * 4, bytes R, G, B, A; `fb.numpy()` is the same memory as an array. A refused
command raises `CommandError`. `Client` and `SharedMemory` draw on a running server instead.
"""

from ._native import __version__
from .framebuffer import Framebuffer
from .shapes import Mesh, box, cone, cylinder, faces, knot, models, obj, sphere, suzanne, teapot

__all__ = [
    "Animation", "Client", "CommandError", "CommandWarning", "Framebuffer", "Input", "Mesh", "Scene",
    "SharedMemory", "__version__", "animate", "box", "cone", "cylinder", "faces", "knot", "models", "obj", "run", "sphere",
    "suzanne", "teapot",
]

# What type checkers take for true; a program has them from `__getattr__`.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from . import animation, batch, client, errors, scene, window
    from .animation import Animation, animate
    from .client import Client, SharedMemory
    from .errors import CommandError, CommandWarning
    from .scene import Scene
    from .window import Input, run

# Imported when they are first used: an import of the package takes less time than a frame is shown.
_LATER = {
    "Animation": "animation",
    "animate": "animation",
    "Client": "client",
    "SharedMemory": "client",
    "Scene": "scene",
    "Input": "window",
    "run": "window",
    "CommandError": "errors",
    "CommandWarning": "errors",
}
_MODULES = ("animation", "batch", "client", "errors", "scene", "window")


def __getattr__(name):
    from importlib import import_module

    if name in _LATER:
        value = getattr(import_module("." + _LATER[name], __name__), name)
        globals()[name] = value
        return value
    if name in _MODULES:
        return import_module("." + name, __name__)
    raise AttributeError("module 'fbptr' has no attribute %r" % name)


def __dir__():
    return sorted(set(globals()) | set(__all__))
