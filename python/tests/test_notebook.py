"""The tutorial: runs from its first cell to its last, and shows the outputs that are stored with it.

Pictures are compared by the CRC-32 of their pixels, printed text as it is; BLESS=1 stores the outputs
anew, and that run fails.
"""

import base64
import os
import struct
import zlib
from pathlib import Path

import pytest

import fbptr

HERE = Path(__file__).parent
NOTEBOOK = HERE.parent / "tutorial.ipynb"


def crc_of_png(data):
    """Returns the CRC-32 of a PNG file's pixels."""
    fb = fbptr.Framebuffer(*struct.unpack(">II", data[16:24]))
    fb.image(0, 0, data)
    return fb.crc()


def shown(notebook):
    """Returns what each cell of code shows: CRC-32 of pictures, printed text."""
    cells = []
    for cell in notebook.cells:
        if cell.cell_type != "code":
            continue
        found = []
        for output in cell.outputs:
            data = output.get("data", {})
            if "image/png" in data:
                found.append("png %08x" % crc_of_png(base64.b64decode(data["image/png"])))
            elif "image/gif" in data:
                found.append("gif %08x" % zlib.crc32(base64.b64decode(data["image/gif"])))
            elif output.output_type == "stream":
                found.append(output.text)
            else:
                found.append(data.get("text/plain", output.output_type))
        cells.append(found)
    return cells


def test_the_tutorial_runs_and_shows_its_outputs():
    nbclient = pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    pytest.importorskip("ipykernel")
    stored = nbformat.read(NOTEBOOK, 4)
    notebook = nbformat.read(NOTEBOOK, 4)
    client = nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3", record_timing=False)
    client.execute()
    found = shown(notebook)
    flat = [text for cell in found for text in cell]
    assert sum(text.startswith(("png ", "gif ")) for text in flat) >= 14
    assert any("light at the pixel" in text and "at FBptr[" in text for text in flat)
    if os.environ.get("BLESS") and found != shown(stored):
        # What names the machine's Python says nothing of the pictures.
        notebook.metadata = stored.metadata
        nbformat.write(notebook, NOTEBOOK)
        pytest.fail("tutorial.ipynb is written: look at it, and run again without BLESS")
    assert found == shown(stored), "other outputs than the stored ones; BLESS=1 stores them"
