"""The lines of the pages run as they are printed."""

from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent.parent


@pytest.mark.parametrize("page", ["README.md", "python/README.md"])
def test_the_lines_run(page, tmp_path, monkeypatch):
    pytest.importorskip("numpy")
    blocks = (ROOT / page).read_text().split("```python\n")[1:]
    programs = [block.split("```")[0] for block in blocks if block.startswith("import fbptr\n")]
    assert programs
    monkeypatch.chdir(tmp_path)
    for program in programs:
        names = {}
        exec(program, names)
        assert names["a"].shape == (480, 640, 4)
        assert names["fb"].crc() == 0x82CFD30C
        if "picture.png" in program:
            assert (tmp_path / "picture.png").read_bytes() == names["fb"].png()
