"""The tutorial: runs from its first cell to its last, and shows the pictures that it showed before.

The CRC-32 of every picture's pixels stands in `tutorial.json`; BLESS=1 writes it anew, and that run
fails.
"""

import base64
import json
import os
import struct
from pathlib import Path

import pytest

import fbptr

HERE = Path(__file__).parent
NOTEBOOK = HERE.parent / "tutorial.ipynb"
KNOWN = HERE / "tutorial.json"


def crc_of_png(data):
    """Returns the CRC-32 of a PNG file's pixels."""
    fb = fbptr.Framebuffer(*struct.unpack(">II", data[16:24]))
    fb.image(0, 0, data)
    return fb.crc()


def pictures(outputs):
    """Returns the CRC-32 of each picture among a cell's outputs."""
    for output in outputs:
        data = output.get("data", {})
        if "image/png" in data:
            yield "%08x" % crc_of_png(base64.b64decode(data["image/png"]))
        elif "image/gif" in data:
            yield "gif %08x" % __import__("zlib").crc32(base64.b64decode(data["image/gif"]))


def test_the_tutorial_runs_and_shows_its_pictures():
    nbclient = pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    pytest.importorskip("ipykernel")
    notebook = nbformat.read(NOTEBOOK, 4)
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    found = [list(pictures(cell.outputs)) for cell in cells]
    assert sum(map(len, found)) >= 14
    if os.environ.get("BLESS"):
        KNOWN.write_text(json.dumps(found, indent=1) + "\n")
    known = json.loads(KNOWN.read_text())
    assert found == known, "other pictures than before; look at them, then BLESS=1"
    assert not os.environ.get("BLESS"), "tutorial.json is written: run again without BLESS"
    printed = "".join(o.get("text", "") for cell in cells for o in cell.outputs)
    assert "light at the pixel" in printed and "at FBptr[" in printed


def test_the_tutorial_is_stored_without_outputs():
    notebook = json.loads(NOTEBOOK.read_text())
    code = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert code and all(not cell["outputs"] and cell["execution_count"] is None for cell in code)
