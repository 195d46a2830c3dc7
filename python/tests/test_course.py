"""The GPU of the course framework "Renderizador", and a student's folder that runs with it.

The folder here is a small framework of our own with the names that the course's has: right is that its
code runs unchanged, and that the picture is what its calls say.
"""

import os
import subprocess
import sys
import textwrap

import pytest

np = pytest.importorskip("numpy")

import fbptr  # noqa: E402
from fbptr.course import gpu as module  # noqa: E402
from fbptr.course import renderizador  # noqa: E402

GPU = module.GPU

RENDERIZADOR = """
    import argparse
    import gpu
    import gl
    import interface
    import x3d

    def main():
        parser = argparse.ArgumentParser(add_help=False)
        parser.add_argument("-i")
        parser.add_argument("-w", type=int)
        parser.add_argument("-h", type=int)
        args = parser.parse_args()
        factor = 2
        gpu.GPU("tela.png", ".")
        scene = x3d.X3D(args.i)
        window = interface.Interface(args.w, args.h, args.i)
        front, large = gpu.GPU.gen_framebuffers(2)
        gpu.GPU.framebuffer_storage(front, gpu.GPU.COLOR_ATTACHMENT, gpu.GPU.RGB8, args.w, args.h)
        gpu.GPU.framebuffer_storage(
            large, gpu.GPU.COLOR_ATTACHMENT, gpu.GPU.RGB8, args.w * factor, args.h * factor)
        gpu.GPU.framebuffer_storage(
            large, gpu.GPU.DEPTH_ATTACHMENT, gpu.GPU.DEPTH_COMPONENT32F, args.w * factor, args.h * factor)

        def render():
            gpu.GPU.bind_framebuffer(gpu.GPU.FRAMEBUFFER, large)
            gpu.GPU.clear_color([0, 0, 40])
            gpu.GPU.clear_buffer()
            gl.GL.square(scene.color)
            gpu.GPU.bind_framebuffer(gpu.GPU.DRAW_FRAMEBUFFER, front)
            for y in range(args.h):
                for x in range(args.w):
                    four = [gpu.GPU.read_pixel([2 * x + i, 2 * y + j], gpu.GPU.RGB8)
                            for i in range(2) for j in range(2)]
                    mean = sum(p.astype(int) for p in four) // 4
                    gpu.GPU.draw_pixel([x, y], gpu.GPU.RGB8, [int(v) for v in mean])
            gpu.GPU.bind_framebuffer(gpu.GPU.READ_FRAMEBUFFER, front)
            return gpu.GPU.get_frame_buffer()

        window.set_saver(gpu.GPU.save_image)
        window.preview(False, render)

    if __name__ == "__main__":
        main()
"""

GL = """
    import gpu

    class GL:
        @staticmethod
        def square(color):
            for y in range(3, 9):
                for x in range(3, 9):
                    gpu.GPU.draw_pixel([x, y], gpu.GPU.RGB8, color)
                    gpu.GPU.draw_pixel([x, y], gpu.GPU.DEPTH_COMPONENT32F, [0.5])
"""

X3D = """
    class X3D:
        def __init__(self, path):
            with open(path) as file:
                self.color = [int(word) for word in file.read().split()]
"""


@pytest.fixture
def student(tmp_path):
    folder = tmp_path / "project" / "renderizador"
    folder.mkdir(parents=True)
    for name, text in [("renderizador", RENDERIZADOR), ("gl", GL), ("x3d", X3D)]:
        (folder / (name + ".py")).write_text(textwrap.dedent(text))
    # The one adds nothing, the other is not imported.
    for name in ("gpu", "interface"):
        (folder / (name + ".py")).write_text("raise ImportError('what is not here')")
    scene = tmp_path / "scene.x3d"
    scene.write_text("200 100 0")
    return scene, folder.parent


def fresh(width=8, height=6, mode=GPU.RGB8):
    GPU("tela.png", ".")
    [position] = GPU.gen_framebuffers(1)
    GPU.bind_framebuffer(GPU.FRAMEBUFFER, position)
    GPU.framebuffer_storage(position, GPU.COLOR_ATTACHMENT, mode, width, height)
    GPU.framebuffer_storage(position, GPU.DEPTH_ATTACHMENT, GPU.DEPTH_COMPONENT32F, width, height)
    return position


def test_pixels_are_the_packages_memory():
    fresh()
    GPU.draw_pixel([3, 2], GPU.RGB8, [1, 2.9, 255])
    fb = GPU.picture()
    assert isinstance(fb, fbptr.Framebuffer)
    offset = (8 * 2 + 3) * 4
    assert bytes(fb.numpy().reshape(-1)[offset : offset + 4]) == bytes([1, 2, 255, 255])
    assert list(GPU.read_pixel((3, 2), GPU.RGB8)) == [1, 2, 255]
    fresh(mode=GPU.RGBA8)
    assert GPU.get_frame_buffer().max() == 0
    GPU.draw_pixel([0, 0], GPU.RGBA8, [1, 2, 3, 4])
    assert list(GPU.read_pixel([0, 0], GPU.RGBA8)) == [1, 2, 3, 4]


def test_what_decides_pictures_is_kept():
    fresh()
    GPU.draw_pixel([1, 1], GPU.RGB8, [9, 9, 9])
    GPU.draw_pixel([1, 1], GPU.RGB8, [0, 0, 0])
    assert list(GPU.read_pixel([1, 1], GPU.RGB8)) == [9, 9, 9], "black is ignored"
    GPU.draw_pixel([1, 1], GPU.DEPTH_COMPONENT32F, [0.25])
    GPU.draw_pixel([1, 1], GPU.DEPTH_COMPONENT32F, [0.0])
    assert GPU.read_pixel([1, 1], GPU.DEPTH_COMPONENT32F)[0] == 0.25, "depth 0 is ignored"
    seen = GPU.read_pixel([1, 1], GPU.RGB8)
    GPU.draw_pixel([1, 1], GPU.RGB8, [5, 6, 7])
    assert list(seen) == [5, 6, 7], "what was read is a view"


def test_clearing_and_binding():
    first = fresh()
    [second] = GPU.gen_framebuffers(1)
    assert (first, second) == (0, 1)
    GPU.framebuffer_storage(second, GPU.COLOR_ATTACHMENT, GPU.RGB8, 2, 2)
    GPU.clear_color([10, 20, 30])
    GPU.clear_depth(-1.0)
    GPU.clear_buffer()
    assert GPU.read_pixel([7, 5], GPU.DEPTH_COMPONENT32F)[0] == -1
    GPU.bind_framebuffer(GPU.DRAW_FRAMEBUFFER, second)
    GPU.draw_pixel([1, 1], GPU.RGB8, [1, 1, 1])
    assert list(GPU.read_pixel([1, 1], GPU.RGB8)) == [10, 20, 30], "the other one is read"
    GPU.bind_framebuffer(GPU.READ_FRAMEBUFFER, second)
    assert list(GPU.read_pixel([1, 1], GPU.RGB8)) == [1, 1, 1]
    with pytest.raises(ValueError, match="no memory for depths"):
        GPU.draw_pixel([1, 1], GPU.DEPTH_COMPONENT32F, [1.0])


@pytest.mark.parametrize(
    "coord, mode, data",
    [
        ([8, 0], GPU.RGB8, [1, 1, 1]),
        ([0, -1], GPU.RGB8, [1, 1, 1]),
        ([0, 0], GPU.RGB8, [1, 1, 256]),
        ([0, 0], GPU.RGB8, [1, 1]),
        ([0, 0], GPU.DEPTH_COMPONENT32F, [1.0, 2.0]),
        ([0, 0], 17, [1, 1, 1]),
    ],
)
def test_wrong_calls_raise(coord, mode, data):
    fresh()
    with pytest.raises(Exception):
        GPU.draw_pixel(coord, mode, data)


def test_a_students_folder_runs_unchanged(student):
    scene, folder = student
    fb = renderizador.render(str(scene), os.path.join(folder, "renderizador"), 8, 6)
    picture = fb.numpy()
    assert (fb.width, fb.height) == (8, 6)
    assert list(picture[2, 2]) == [200, 100, 0, 255]
    assert list(picture[1, 1]) == [50, 25, 30, 255], "a quarter of four pixels"
    assert list(picture[5, 7]) == [0, 0, 40, 255]
    assert "gpu" not in sys.modules and "gl" not in sys.modules, "nothing is left"


# An older framework's window, which has no name; functions of the student's own `gpu.py`; and the mean of four
# pixels put in the place of the colours that are read.
OWN_GPU = """
    import numpy as np

    class GPU:
        frame_buffer = "another"

        @staticmethod
        def draw_pixel(coord, mode, data):
            raise RuntimeError("the package's is called")

        @staticmethod
        def set_pixel(x, y, *color):
            GPU.frame_buffer[GPU.draw_framebuffer].color[y][x] = color

        @staticmethod
        def swap_buffers():
            large = GPU.frame_buffer[GPU.draw_framebuffer].color
            height, width = large.shape[0] // 2, large.shape[1] // 2
            mean = large.reshape(height, 2, width, 2, 3).mean(axis=(1, 3))
            GPU.frame_buffer[GPU.read_framebuffer].color = mean.astype(np.uint8)
"""


def test_functions_that_a_student_adds_to_the_gpu_are_called(student):
    scene, folder = student
    own = folder / "renderizador"
    (own / "gpu.py").write_text(textwrap.dedent(OWN_GPU))
    text = (own / "renderizador.py").read_text()
    text = text.replace("Interface(args.w, args.h, args.i)", "Interface(args.w, args.h)")
    begin = text.index("        gpu.GPU.bind_framebuffer(gpu.GPU.DRAW")
    end = text.index("        return gpu.GPU.get_frame")
    (own / "renderizador.py").write_text(text[:begin] + "        gpu.GPU.swap_buffers()\n" + text[end:])
    text = (own / "gl.py").read_text()
    (own / "gl.py").write_text(text.replace("draw_pixel([x, y], gpu.GPU.RGB8, color)", "set_pixel(x, y, *color)"))
    before = dict(vars(GPU))
    picture = renderizador.render(str(scene), str(own), 8, 6).numpy()
    assert picture.shape == (6, 8, 4)
    assert list(picture[2, 2]) == [200, 100, 0, 255]
    assert list(picture[1, 1]) == [50, 25, 30, 255], "a quarter of four pixels"
    assert not hasattr(GPU, "set_pixel") and vars(GPU)["swap_buffers"] is before["swap_buffers"], "nothing is left"


def test_the_program_writes_compares_and_fails(student, tmp_path):
    scene, folder = student

    def run(*words, **env):
        command = [sys.executable, "-m", "fbptr.course.renderizador", *map(str, words)]
        return subprocess.run(command, env={**os.environ, **env}, capture_output=True, text=True)

    out = tmp_path / "mine.png"
    done = run(scene, "-i", folder, "--size", "8x6", "-o", out)
    assert done.returncode == 0, done.stderr
    assert out.read_bytes()[:4] == b"\x89PNG"
    assert run(scene, "-i", folder, "--size", "8x6", "--expect", out).returncode == 0
    scene.write_text("201 100 0")
    other = run(scene, "-i", folder, "--size", "8x6", "--expect", out)
    assert other.returncode == 1 and "pixels differ" in other.stderr, other.stderr
    assert run(scene, "-i", tmp_path).returncode == 2
    scene.write_text("999 0 0")
    failed = run(scene, "-i", folder, "--headless")
    assert failed.returncode == 1 and "from 0 to 255" in failed.stderr
