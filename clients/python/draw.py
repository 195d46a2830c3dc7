"""A small drawing program, with the window of `fbptr serve` as its canvas.

Mouse and keys arrive as the server's EVENTS.

    fbptr serve &                              # opens a window
    python3 clients/python/draw.py             # ADDRESS, and --print to see the events

Hold the left button and move to draw. 1 to 9 choose a colour, the wheel sets the width, c clears.
Closing the window ends the program.
"""

import sys

from fbptr import Client

COLOURS = ["white", "ff4040", "ffb020", "ffff40", "40ff40", "40ffff", "6080ff", "ff60ff", "808080"]
PAPER = "101820"


def stroke(fb, start, end, colour, width):
    """Draws a line of `width` pixels, as parallel lines beside the one between the points."""
    is_flat = abs(end[0] - start[0]) >= abs(end[1] - start[1])
    for i in range(-(width // 2), (width + 1) // 2):
        dx, dy = (0, i) if is_flat else (i, 0)
        fb.line(start[0] + dx, start[1] + dy, end[0] + dx, end[1] + dy, colour)


def main(address="127.0.0.1:1234", prints=False):
    def say(text):
        if prints:
            print(text, flush=True)

    with Client(address) as fb:
        fb.clear(PAPER)
        fb.listen()
        fb.sync()
        say("ready")
        colour, width, last = COLOURS[0], 1, None
        while True:
            event = fb.next_event()
            if event is None:
                return
            say(" ".join(event))
            kind, words = event[0], event[1:]
            if kind == "mouse":
                at, held = (int(words[0]), int(words[1])), int(words[2])
                if held & 1:
                    stroke(fb, last or at, at, colour, width)
                last = at if held & 1 else None
            elif kind == "wheel":
                width = max(1, min(32, width + int(words[1])))
            elif kind == "key" and words[0] == "down":
                if words[1] in list("123456789"):
                    colour = COLOURS[int(words[1]) - 1]
                elif words[1] == "c":
                    fb.clear(PAPER)
            elif kind == "close":
                return


if __name__ == "__main__":
    arguments = [a for a in sys.argv[1:] if a != "--print"]
    main(*arguments[:1], prints="--print" in sys.argv)
