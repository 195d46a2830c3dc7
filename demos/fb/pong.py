"""Pong for one: the arrow keys up and down move the left paddle (evdev), the right one follows the ball."""

import os
import struct

from fb import Framebuffer, frames

fb = Framebuffer()
keyboard = os.open("/dev/input/event0", os.O_RDONLY | os.O_NONBLOCK)
size, paddle = max(2, fb.height // 30), fb.height // 5
x, y, dx, dy = fb.width // 2, fb.height // 2, -max(1, fb.width // 100), max(1, fb.height // 90)
mine = theirs = (fb.height - paddle) // 2
held = 0
for _ in frames():
    try:
        events = os.read(keyboard, 24 * 64)
    except BlockingIOError:
        events = b""
    for at in range(0, len(events), 24):
        kind, code, value = struct.unpack_from("HHi", events, at + 16)
        if kind == 1 and code in (103, 108):
            held = 0 if value == 0 else (-1 if code == 103 else 1)
    mine = min(max(mine + held * size, 0), fb.height - paddle)
    theirs = min(max(y - paddle // 2, 0), fb.height - paddle)
    x, y = x + dx, y + dy
    if not 0 <= y < fb.height - size:
        dy, y = -dy, min(max(y, 0), fb.height - size - 1)
    if x >= fb.width - 3 * size or (x <= 2 * size and mine - size <= y <= mine + paddle):
        dx = -dx
    elif x < 0:
        x, dx = fb.width // 2, -dx
    for line in range(fb.height):
        row = bytearray(4 * fb.width)
        for left, top, height in ((size, mine, paddle), (fb.width - 2 * size, theirs, paddle), (x, y, size)):
            if top <= line < top + height and left >= 0:
                row[4 * left : 4 * (left + size)] = b"\xff" * (4 * size)
        fb.row(line, row[: 4 * fb.width])
    fb.wait()
