"""Plasma: sums of waves through a palette, written into the bytes of the memory."""

from math import pi, sin

import fbptr

W, H = 160, 120


def wave(x):
    return int((sin(x) * 0.5 + 0.5) * 255)


angles = [i / 256 * 2 * pi for i in range(256)]
palette = [bytes([wave(a), wave(a + 2.1), wave(a + 4.2), 255]) for a in angles]
table = [int(sin(a) * 64) for a in angles]
time = 0.0


def draw(fb, input):
    global time
    time += input.delta * 60
    t = int(time)
    across = [table[(2 * x + 2 * t) % 256] + t for x in range(W)]
    for y in range(H):
        down = table[(4 * y + t) % 256] + table[(2 * y + 3 * t) % 256]
        row = [palette[(a + down + table[(2 * x + 2 * y + t) % 256]) % 256] for x, a in enumerate(across)]
        fb[y * W * 4 : (y + 1) * W * 4] = b"".join(row)
    input.close |= input.is_down("escape")


fbptr.run(W, H, draw)
