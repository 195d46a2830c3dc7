"""The window of `fbptr.run`, without one: the frames that a script draws by its arguments."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import fbptr

EXAMPLES = Path(__file__).parent.parent / "examples"
ENVIRONMENT = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}


def script(path, *arguments):
    """Runs a script in an interpreter of its own."""
    command = [sys.executable, str(path), *arguments]
    return subprocess.run(command, capture_output=True, text=True, env=ENVIRONMENT, timeout=120)


def test_frames_follow_each_other_and_the_last_is_saved(tmp_path):
    program = tmp_path / "program.py"
    program.write_text(
        """
import fbptr
seen = []
def draw(fb, input):
    seen.append((input.frame, round(input.delta * 60), input.is_down("a"), input.mouse))
    fb.pixel(input.frame, 0, "red")
    input.close = input.frame == 5
fb = fbptr.run(8, 4, draw)
print(seen, fb.get_pixel(2, 0))
"""
    )
    picture = tmp_path / "last.png"
    done = script(program, "--headless", "--frames", "3", "--snap", str(picture))
    assert done.returncode == 0, done.stderr
    inputs = [(frame, int(frame > 0), False, (0, 0)) for frame in range(3)]
    assert done.stdout.strip() == "%s %s" % (inputs, (255, 0, 0, 255))
    wanted = fbptr.Framebuffer(8, 4)
    for x in range(3):
        wanted.pixel(x, 0, "red")
    assert picture.read_bytes() == wanted.png()
    assert script(program, "--headless", "--frames", "90").stdout.count("(0, 0)") == 6, "closed by the program"


def test_an_exception_ends_it(tmp_path):
    program = tmp_path / "program.py"
    program.write_text("import fbptr\nfbptr.run(8, 8, lambda fb, input: 1 / 0)\n")
    done = script(program, "--headless")
    assert done.returncode == 1 and "ZeroDivisionError" in done.stderr


def test_without_a_screen_there_is_no_window(tmp_path):
    program = tmp_path / "program.py"
    program.write_text("import fbptr\nfbptr.Framebuffer(8, 8).show()\n")
    done = script(program)
    assert done.returncode == 1 and "OSError" in done.stderr, done.stderr


@pytest.mark.parametrize("name", ["pong", "snake", "paint", "fountain", "plasma", "raycaster"])
def test_the_examples_draw(name, tmp_path):
    source = EXAMPLES / (name + ".py")
    assert len(source.read_text().splitlines()) < 60
    first, last = tmp_path / "first.png", tmp_path / "last.png"
    for picture, frames in (first, "1"), (last, "40"):
        done = script(source, "--headless", "--frames", frames, "--snap", str(picture))
        assert done.returncode == 0, done.stderr
    still = name in ("paint", "raycaster")
    assert (first.read_bytes() == last.read_bytes()) == still
    assert len(last.read_bytes()) > 300
