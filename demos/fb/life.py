"""Conway's game of life on a torus: a cell lives with three neighbours, or with two if it lived."""

import random

from fb import Framebuffer, frames

SIZE = 4
fb = Framebuffer()
columns, rows = fb.width // SIZE, fb.height // SIZE
draw = random.Random(3)
alive = {(x, y) for x in range(columns) for y in range(rows) if draw.random() < 0.3}
for _ in frames():
    for y in range(rows):
        cells = b"".join((b"\x40\xe0\x60\x00" if (x, y) in alive else b"\x20\x10\x10\x00") * SIZE for x in range(columns))
        for line in range(SIZE):
            fb.row(y * SIZE + line, cells)
    neighbours = {}
    for x, y in alive:
        for dx, dy in ((-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)):
            cell = ((x + dx) % columns, (y + dy) % rows)
            neighbours[cell] = neighbours.get(cell, 0) + 1
    alive = {cell for cell, count in neighbours.items() if count == 3 or (count == 2 and cell in alive)}
    fb.wait()
