"""Snake: the arrows turn it; it grows with each apple, and begins again where it bites itself."""

import random

import fbptr

W, H, SIDE = 32, 24, 10
WAYS = {"up": (0, -1), "down": (0, 1), "left": (-1, 0), "right": (1, 0)}
START = [(8, 12), (7, 12), (6, 12)]
random.seed(1)
snake, way, turn, apple, time = START[:], (1, 0), (1, 0), (20, 12), 0.0


def step():
    global snake, way, turn, apple
    way = turn
    head = (snake[0][0] + way[0]) % W, (snake[0][1] + way[1]) % H
    if head in snake:
        snake, way, turn = START[:], (1, 0), (1, 0)
    elif head == apple:
        snake.insert(0, head)
        apple = random.randrange(W), random.randrange(H)
    else:
        snake = [head] + snake[:-1]


def draw(fb, input):
    global turn, time
    for key, to in WAYS.items():
        if input.was_pressed(key) and to != (-way[0], -way[1]):
            turn = to
    time += input.delta
    if time > 0.12:
        time = 0.0
        step()
    fb.clear("#141820")
    for i, (x, y) in enumerate([apple] + snake):
        colour = ("#dc3c32", "#b4f078")[i] if i < 2 else "#50b45a"
        fb.fillrect(x * SIDE + 1, y * SIDE + 1, SIDE - 2, SIDE - 2, colour)
    fb.print(4, 4, "silver", str(len(snake)))
    input.close |= input.is_down("escape")


fbptr.run(W * SIDE, H * SIDE, draw)
