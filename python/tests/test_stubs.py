"""The type stubs: current, and true of what there is at run time."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

import fbptr
from make_stubs import text

STUB = Path(fbptr.__file__).with_name("framebuffer.pyi")
SOURCE = Path(__file__).parent.parent / "fbptr" / "framebuffer.pyi"


def test_the_stubs_are_those_of_the_verb_table():
    wanted = text()
    if os.environ.get("BLESS"):
        blessed = SOURCE.read_text() != wanted if SOURCE.exists() else True
        SOURCE.write_text(wanted)
        assert not blessed, "framebuffer.pyi is written: build and run again"
    assert SOURCE.read_text() == wanted, "BLESS=1 writes framebuffer.pyi anew"
    assert STUB.read_text() == wanted, "the installed package has older stubs"


def test_every_stubbed_method_is_there():
    for stub in ("framebuffer.pyi", "_native.pyi"):
        tree = ast.parse(STUB.with_name(stub).read_text())
        for cls in [n for n in tree.body if isinstance(n, ast.ClassDef)]:
            found = getattr(fbptr, cls.name, None) or getattr(fbptr._native, cls.name)
            for method in [n for n in cls.body if isinstance(n, ast.FunctionDef)]:
                # The buffer protocol has names of its own from Python 3.12 on.
                assert "buffer__" in method.name or hasattr(found, method.name), method.name


def test_a_type_checker_takes_right_programs_and_refuses_wrong_ones(tmp_path):
    pytest.importorskip("mypy")
    program = tmp_path / "program.py"
    right = """
import fbptr
fb = fbptr.Framebuffer(64, 48)
fb.clear("navy"); fb.line(0, 0, 63, 47, "red", "gold"); fb.line((0, 0), (63, 47), ["red", "gold"])
fb.fill([(2, 2), (60, 8), (30, 46)], ["red", "lime", "blue"])
fb.mesh("pot", fbptr.teapot()); fb.lookat((0, 2, 6)); fb.draw("pot", shade="phong")
shape: tuple[int, ...] = fb.numpy().shape
text: str = fb.run("CRC")
byte: int = fb[0]
pot: fbptr.Mesh = fbptr.teapot()
movie: fbptr.Animation = fbptr.animate(lambda fb, i: fb.clear("red"), 2)
frame: bytes = fbptr.Scene.load("scene.x3d", frames=3).png(0)
fbptr.Client("127.0.0.1:1234").close()
"""
    wrong = right + "fb.circle(1, 2)\nfb.nothing()\nbyte = fb[0:4]\npot = fbptr.box(\"2\")\nfbptr.animate(2, 2)\n"

    def errors(source):
        program.write_text(source)
        run = [sys.executable, "-m", "mypy", "--no-error-summary", "--cache-dir", str(tmp_path / "cache"), str(program)]
        done = subprocess.run(run, capture_output=True, text=True)
        return [line for line in done.stdout.splitlines() if "error:" in line]

    assert errors(right) == []
    assert len(errors(wrong)) == 5
