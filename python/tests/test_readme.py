"""The Python of the pages runs as it is printed, and draws the pictures that it should."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent.parent


def blocks(page):
    """Returns the Python blocks of a page that begin with the import of the package."""
    parts = (ROOT / page).read_text().split("```python\n")[1:]
    programs = [part.split("```")[0] for part in parts]
    return [program for program in programs if program.startswith("import fbptr")]


@pytest.mark.parametrize("page", ["README.md", "python/README.md"])
def test_the_block_draws_its_picture(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    programs = [program for program in blocks(page) if "fbptr.run(" not in program]
    assert len(programs) == 1
    if "numpy()" in programs[0]:
        pytest.importorskip("numpy")
    names = {}
    exec(programs[0], names)
    fb = names["fb"]
    # The picture that these verbs give in a stream, looked at: a golden pot before a triangle.
    assert fb.crc() == 0xEE1381A8
    if "a" in names:
        assert names["a"].shape == (480, 640, 4)
    else:
        assert (tmp_path / "picture.png").read_bytes() == fb.png()
        assert capsys.readouterr().out == "%d\n" % fb.get_pixel(320, 300)[0]


def test_the_sketch_moves(tmp_path):
    program = next(program for program in blocks("README.md") if "fbptr.run(" in program)
    source, pictures = tmp_path / "sketch.py", []
    source.write_text(program)
    assert len(program.splitlines()) <= 12
    for frames in "1", "30":
        picture = tmp_path / (frames + ".png")
        command = [sys.executable, str(source), "--headless", "--frames", frames, "--snap", str(picture)]
        subprocess.run(command, check=True, timeout=60)
        pictures.append(picture.read_bytes())
    assert pictures[0] != pictures[1]


def test_the_readme_needs_nothing_that_its_command_does_not_install():
    program = "".join(blocks("README.md"))
    assert "pip install ./python" in (ROOT / "README.md").read_text() and "numpy" not in program


def test_a_scene_may_be_a_built_in_model():
    import fbptr

    assert "teapot" in fbptr.models() and "tesseract" in fbptr.models()
    pot = fbptr.Scene.load("teapot", size=(64, 48))
    fb = fbptr.Framebuffer(64, 48)
    assert pot.pixels(0) != bytes(memoryview(fb))
    with pytest.raises(FileNotFoundError):
        fbptr.Scene.load("no-such-model")
    with pytest.raises(ValueError, match="no built-in model"):
        fbptr.Scene(b"", "model", "no-such-model")
    fb.mesh("monkey", fbptr.suzanne())
    fb.draw("monkey")
    assert fb.get_pixel(32, 20) != (0, 0, 0, 255)
