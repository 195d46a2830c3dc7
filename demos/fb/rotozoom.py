"""A rotozoomer: a texture turned and enlarged, by two additions a pixel."""

import math

from fb import Framebuffer, frames

fb = Framebuffer(bits=8)
texture = [[(x >> 3 ^ y >> 3) for x in range(64)] for y in range(64)]
for t in frames():
    zoom = 1.2 + math.sin(t / 40)
    du, dv = int(65536 * zoom * math.cos(t / 60)), int(65536 * zoom * math.sin(t / 60))
    for y in range(0, fb.height, 2):
        u, v = -fb.width // 2 * du - (y - fb.height // 2) * dv, -fb.width // 2 * dv + (y - fb.height // 2) * du
        row = bytearray()
        for _ in range(fb.width // 2):
            index = texture[v >> 16 & 63][u >> 16 & 63] & 15
            row += bytes((index, index))
            u += 2 * du
            v += 2 * dv
        fb.row(y, row)
        fb.row(y + 1 if y + 1 < fb.height else y, row)
    fb.wait()
