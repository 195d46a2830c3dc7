"""A starfield: points that come nearer, brighter as they do."""

import random

from fb import Framebuffer, frames

fb = Framebuffer()
draw = random.Random(1)
stars = [[draw.uniform(-1, 1), draw.uniform(-1, 1), draw.uniform(0.05, 1)] for _ in range(200)]
lit = []
for _ in frames():
    for at in lit:
        fb.bytes[at : at + 4] = bytes(4)
    lit.clear()
    for star in stars:
        star[2] -= 0.01
        x = int(fb.width / 2 * (1 + star[0] / star[2]))
        y = int(fb.height / 2 * (1 + star[1] / star[2]))
        if star[2] <= 0.01 or not (0 <= x < fb.width and 0 <= y < fb.height):
            star[:] = [draw.uniform(-1, 1), draw.uniform(-1, 1), 1]
            continue
        light = int(255 * (1 - star[2]))
        lit.append(y * fb.line + 4 * x)
        fb.bytes[lit[-1] : lit[-1] + 4] = bytes((light, light, light, 0))
    fb.wait()
