"""A fountain of particles; the mouse moves its source while a button is held."""

import random

import fbptr

random.seed(7)
particles, source = [], (240, 300)


def draw(fb, input):
    global particles, source
    if input.buttons[0]:
        source = input.mouse
    for _ in range(12):
        particles.append([*source, random.uniform(-60, 60), random.uniform(-310, -220), 0.0])
    particles = [p for p in particles if p[4] < 2.5 and p[1] < 360]
    fb.clear("#080a16")
    for p in particles:
        p[4] += input.delta
        p[3] += 200 * input.delta
        p[0] += p[2] * input.delta
        p[1] += p[3] * input.delta
        heat = max(1 - p[4] / 2.5, 0)
        fb.fillcircle(p[0], p[1], 1 + 2 * heat, (int(80 + 175 * heat), int(120 + 110 * heat), 255))
    input.close |= input.is_down("escape")


fbptr.run(480, 360, draw)
