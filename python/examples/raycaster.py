"""A maze seen from inside: a ray a column, walls as high as they are near. The arrows walk and turn."""

from math import atan, cos, sin

import fbptr

MAP = """
############
#....#.....#
#.##.#.###.#
#.#......#.#
#.#.####.#.#
#...#..#...#
###.#..#.###
#..........#
#.##.##.##.#
############
""".split()
x, y, angle = 1.5, 1.5, 0.6


def is_wall(x, y):
    return MAP[int(y)][int(x)] == "#"


def draw(fb, input):
    global x, y, angle
    angle += 2.2 * input.delta * (input.is_down("right") - input.is_down("left"))
    step = 2 * input.delta * (input.is_down("up") - input.is_down("down"))
    if not is_wall(x + step * cos(angle), y):
        x += step * cos(angle)
    if not is_wall(x, y + step * sin(angle)):
        y += step * sin(angle)
    fb.fillrect(0, 0, 320, 100, "#3c4664")
    fb.fillrect(0, 100, 320, 100, "#463c32")
    for column in range(0, 320, 2):
        ray = angle + atan((column - 159) / 280)
        dx, dy, away = cos(ray), sin(ray), 0.0
        while not is_wall(x + away * dx, y + away * dy):
            away += 0.02
        high = min(200 / (away * cos(ray - angle)), 200)
        light = int(200 / (1 + 0.25 * away))
        fb.fillrect(column, 100 - high / 2, 2, high, (light, light * 4 // 5, light // 2))
    input.close |= input.is_down("escape")


fbptr.run(320, 200, draw)
