"""Runs a student's folder of the course framework "Renderizador" with this package's GPU and window.

    python -m fbptr.course.renderizador scene.x3d -i STUDENT_DIR
    python -m fbptr.course.renderizador scene.x3d -i STUDENT_DIR --size 300x200 -o mine.png
    python -m fbptr.course.renderizador scene.x3d -i STUDENT_DIR --size 300x200 --expect exact.png

In: a scene, and the folder with the student's `gl.py` and the framework's `renderizador.py` and `x3d.py`,
or one whose folder `renderizador` has them. Out: the picture in a window, in a file, or compared with a
golden one (BLESS=1 writes that). Nothing in the folder is changed: its `interface.py`, and so Matplotlib,
is not imported, and of its `gpu.py` only functions that the framework's does not have, and `swap_buffers`,
which the framework leaves to the student. Exit status: 0, 1 for another picture than the expected one or an error in
the student's code, 2 for invalid arguments.

Right is: the picture is that of the framework itself, byte for byte, for a scene without a clock.
"""

import argparse
import os
import runpy
import sys

NAMES = ("gl.py", "renderizador.py", "x3d.py")


def main(arguments=None):
    """Runs the program, and returns its exit status."""
    args = _parser().parse_args(arguments)
    folder = _folder(args.input)
    if folder is None:
        print("%s: there is no folder with %s" % (args.input, ", ".join(NAMES)), file=sys.stderr)
        return 2
    if not os.path.isfile(args.scene):
        print("%s: there is no such file" % args.scene, file=sys.stderr)
        return 2
    width, height = args.size
    try:
        fb = render(args.scene, folder, width, height, frames=args.frames, window=_wants_window(args))
    except Exception:
        import traceback

        traceback.print_exc()
        return 1
    if args.output:
        fb.save(args.output)
    if args.expect:
        try:
            fb.assert_golden(args.expect)
        except AssertionError as failure:
            print(failure, file=sys.stderr)
            return 1
    return 0


def render(scene, folder, width=60, height=40, frames=1, window=False):
    """Renders a scene by the code in a student's folder, and returns the picture as a `Framebuffer`."""
    from . import gpu, interface

    here, before, own = os.path.abspath(folder), sys.argv, set(sys.modules)
    interface.Interface.headless = not window
    interface.Interface.frames = frames
    interface.Interface.shown = None
    ours = {"gpu": gpu, "interface": interface}
    replaced = {name: sys.modules.get(name) for name in ours}
    sys.modules.update(ours)
    sys.path.insert(0, here)
    sys.argv = ["renderizador.py", "-i", os.path.abspath(scene), "-w", str(width), "-h", str(height)]
    added = os.path.join(here, "gpu.py")
    give_back = gpu.take_functions(added) if os.path.isfile(added) else lambda: None
    try:
        runpy.run_path(os.path.join(here, "renderizador.py"), run_name="__main__")
    finally:
        give_back()
        sys.argv = before
        sys.path.remove(here)
        # The next folder has modules of the same names.
        for name in set(sys.modules) - own:
            file = getattr(sys.modules[name], "__file__", None)
            if file and os.path.abspath(file).startswith(here + os.sep):
                del sys.modules[name]
        for name, module in replaced.items():
            if module is None:
                del sys.modules[name]
            else:
                sys.modules[name] = module
    if interface.Interface.shown is None:
        raise RuntimeError("%s rendered nothing" % folder)
    return interface.Interface.shown


def _folder(given):
    """Returns the folder that has the framework's files: the given one, or `renderizador` in it."""
    for folder in (given, os.path.join(given, "renderizador")):
        if all(os.path.isfile(os.path.join(folder, name)) for name in NAMES):
            return folder
    return None


def _wants_window(args):
    return not (args.headless or args.output or args.expect)


def _size(text):
    width, x, height = text.partition("x")
    if not (x and width.isdecimal() and height.isdecimal() and int(width) and int(height)):
        raise argparse.ArgumentTypeError("WxH is expected, as 300x200, not %r" % text)
    return int(width), int(height)


def _parser():
    parser = argparse.ArgumentParser(
        prog="python -m fbptr.course.renderizador",
        description="Runs a student's folder of the course framework Renderizador with fbptr's memory and window.",
    )
    parser.add_argument("scene", metavar="SCENE.x3d", help="the scene")
    parser.add_argument("-i", "--input", metavar="STUDENT_DIR", required=True, help="the folder with gl.py")
    parser.add_argument("-o", "--output", metavar="OUT.png", help="write the picture, and open no window")
    parser.add_argument("--expect", metavar="PNG", help="compare the picture with a golden one; BLESS=1 writes it")
    parser.add_argument("--size", metavar="WxH", type=_size, default=(60, 40), help="the picture's size [60x40]")
    parser.add_argument("--frames", metavar="N", type=int, default=1, help="frames to render without a window [1]")
    parser.add_argument("--headless", action="store_true", help="open no window")
    return parser


if __name__ == "__main__":
    sys.exit(main())
