"""Text mode: 80x25 characters of code page 437 in sixteen colours, drawn by this project's own font."""

import os

from fb import Framebuffer, frames

# The picture characters of the codes below 32, which Python's codec has no pictures for, and of 127.
LOW = " ☺☻♥♦♣♠•◘○◙♂♀♪♫☼►◄↕‼¶§▬↨↑↓→←∟↔▲▼"
PAGE = LOW + bytes(range(32, 127)).decode() + "⌂" + bytes(range(128, 256)).decode("cp437")
NAMES = ["black", "blue", "green", "cyan", "red", "magenta", "brown", "light grey", "dark grey", "light blue"]
NAMES += ["light green", "light cyan", "light red", "light magenta", "yellow", "white"]


def glyphs():
    """Reads the font's pictures: bands of eight characters, eight rows each."""
    folder = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../crates/core/src/draw2d")
    with open(os.path.join(folder, "cp437.txt"), encoding="utf-8") as file:
        beyond = file.read()
    with open(os.path.join(folder, "font8x8.txt"), encoding="utf-8") as file:
        latin = file.read()
    names = [c for line in beyond.split("\n") if line.startswith("Band") for c in line.split(": ")[1].split()]
    names = [chr(c) for c in (*range(32, 128), *range(160, 256))] + names
    rows = [line.split() for text in (latin, beyond) for line in text.split("\n") if line[:1] in (".", "#") and line]
    return {c: [rows[i // 8 * 8 + y][i % 8] for y in range(8)] for i, c in enumerate(names)}


def put(cells, x, y, text, ink=7, paper=0):
    """Writes characters with their colours into the text memory."""
    for i, c in enumerate(text):
        cells[y][x + i] = (c, ink, paper)


cells = [[(" ", 7, 1)] * 80 for _ in range(25)]
put(cells, 0, 0, " 80x25 characters of code page 437, in sixteen colours".ljust(80), 0, 3)
put(cells, 1, 2, "╔" + " all 256 characters ".center(38, "═") + "╗", 14, 1)
for y in range(16):
    row = " ".join(PAGE[16 * y : 16 * y + 16])
    put(cells, 1, 3 + y, "║ %02X │ %s ║" % (16 * y, row), 14, 1)
    put(cells, 8, 3 + y, row, 15, 1)
    put(cells, 47, 3 + y, "│ " + " " * 26 + " │", 11, 1)
    put(cells, 49, 3 + y, "%2d %-14s" % (y, NAMES[y]), 7, 1)
    put(cells, 67, 3 + y, "░░▒▒▓▓██", y, 0)
put(cells, 1, 19, "╚" + "═" * 4 + "╧" + "═" * 33 + "╝", 14, 1)
put(cells, 47, 2, "┌" + " colours and shades ".center(28, "─") + "┐", 11, 1)
put(cells, 47, 19, "└" + "─" * 28 + "┘", 11, 1)
put(cells, 1, 21, "├── 320x200 ──┬── 640x350 ──┼══ 720x400 ══╪═■  α ß Γ π Σ σ µ τ Φ Θ Ω δ ∞", 10, 1)
put(cells, 0, 24, " F1 Help  F8 Look of a tube  Esc Quit".ljust(80), 0, 7)
font, fb = glyphs(), Framebuffer(8)
columns, rows = min(80, fb.width // 8), min(25, fb.height // 8)
repeat = max(1, fb.height // (8 * rows))
for t in frames():
    put(cells, 1, 23, "C:\\>" + "type anything"[: t // 8 % 20] + "█ "[t // 16 % 2] + " ", 15, 1)
    for y in range(rows * 8) if t == 0 else range(23 * 8, min(24, rows) * 8):
        line = bytes(i if dot == "#" else p for c, i, p in cells[y // 8][:columns] for dot in font.get(c, font["\x7f"])[y % 8])
        for copy in range(repeat):
            fb.row(y * repeat + copy, line)
    fb.wait()
