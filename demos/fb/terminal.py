"""A terminal: what is typed on the console appears in letters of 3x5 dots; backspace takes a letter away."""

import os
import select
import tty

from fb import Framebuffer, frames

# Five rows of three dots a letter, as octal digits from the top; others are a box.
LETTERS = {
    "a": "25755", "b": "65656", "c": "34443", "d": "65556", "e": "74647", "f": "74644", "g": "34553", "h": "55755",
    "i": "72227", "j": "11152", "k": "55655", "l": "44447", "m": "57755", "n": "65555", "o": "25552", "p": "65644",
    "q": "25563", "r": "65655", "s": "34216", "t": "72222", "u": "55557", "v": "55552", "w": "55775", "x": "55255",
    "y": "55222", "z": "71247", "0": "75557", "1": "26227", "2": "61247", "3": "61216", "4": "55711", "5": "74616",
    "6": "34757", "7": "71122", "8": "75757", "9": "75716", " ": "00000", ".": "00002", ",": "00024", "-": "00700",
    "!": "22202", "?": "61202", ">": "42124", "_": "00007",
}  # fmt: skip

fb = Framebuffer()
size = max(1, fb.width // 160)
columns, rows = fb.width // (4 * size), fb.height // (7 * size)
console = os.open("/dev/tty", os.O_RDWR)
tty.setraw(console)
text = "> "
for _ in frames():
    if select.select([console], [], [], 0)[0]:
        for byte in os.read(console, 100):
            text = text[:-1] if byte == 127 else text + ("\n> " if byte == 13 else chr(byte))
    lines = [line[i : i + columns] for line in (text + "_").split("\n") for i in range(0, max(1, len(line)), columns)]
    for y, line in enumerate(lines[-rows:]):
        for dots in range(7):
            row = bytearray()
            for letter in line.lower().ljust(columns):
                bits = int(LETTERS.get(letter, "77777")[dots - 1]) if 1 <= dots <= 5 else 0
                for bit in (4, 2, 1, 0):
                    row += (b"\x40\xff\x80\x00" if bits & bit else b"\x10\x18\x10\x00") * size
            for line_y in range(size):
                fb.row((y * 7 + dots) * size + line_y, row)
    fb.wait()
