"""Pong for two: W and S, and the arrows up and down."""

import fbptr

W, H = 320, 240
ball, speed = [160.0, 120.0], [-140.0, 90.0]
paddles, score = [100.0, 100.0], [0, 0]


def draw(fb, input):
    for i, (up, down) in enumerate((("w", "s"), ("up", "down"))):
        way = input.is_down(down) - input.is_down(up)
        paddles[i] = min(max(paddles[i] + way * 180 * input.delta, 0), H - 40)
    for axis in 0, 1:
        ball[axis] += speed[axis] * input.delta
    if not 4 <= ball[1] <= H - 4:
        ball[1] = min(max(ball[1], 4), H - 4)
        speed[1] = -speed[1]
    side = speed[0] > 0
    is_near = ball[0] > W - 16 if side else ball[0] < 16
    if is_near and paddles[side] <= ball[1] < paddles[side] + 40:
        speed[:] = -1.05 * speed[0], speed[1] + 3 * (ball[1] - paddles[side] - 20)
    elif not 0 <= ball[0] <= W:
        score[not side] += 1
        ball[:], speed[:] = (160, 120), (-140 if side else 140, 90)
    fb.clear("#102018")
    for y in range(4, H, 16):
        fb.fillrect(159, y, 2, 8, "#5a6e64")
    fb.print(140, 8, "white", "%d : %d" % tuple(score))
    for x, y in zip((8, W - 16), paddles):
        fb.fillrect(x, y, 8, 40, "white")
    fb.fillcircle(*ball, 4.5, "gold")
    input.close |= input.is_down("escape")


fbptr.run(W, H, draw)
