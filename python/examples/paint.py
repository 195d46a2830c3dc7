"""A paint program: the left button draws, the wheel sets the width, 1 to 8 the colour, C clears."""

import fbptr

COLOURS = ["black", "#dc322f", "#ffa000", "#f0dc3c", "#3caa46", "#268bd2", "#8250c8", "white"]
colour, width, last = 5, 6.0, None


def draw(fb, input):
    global colour, width, last
    if input.frame == 0 or input.was_pressed("c"):
        fb.clear("#faf8f0")
    for key in range(8):
        if input.was_pressed(str(key + 1)):
            colour = key
    width = min(max(width + input.wheel[1], 1), 60)
    at, is_held = input.mouse, input.buttons[0]
    if is_held and at[1] < 340:
        fb.wideline(*(last or at), *at, width, COLOURS[colour])
    elif is_held:
        colour = min(max(at[0] // 60, 0), 7)
    last = at if is_held else None
    fb.fillrect(0, 340, 480, 20, "#c8c4bc")
    for i, name in enumerate(COLOURS):
        high = 20 if i == colour else 12
        fb.fillrect(i * 60 + 1, 360 - high, 58, high, name)
    input.close |= input.is_down("escape")


fbptr.run(480, 360, draw)
