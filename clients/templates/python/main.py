import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../python"))
from fbptr import SharedMemory


def put_pixel(x, y, color):
    """Sets the pixel at column x and row y, counted from the upper left, to 0xRRGGBB."""
    if 0 <= x < fb.width and 0 <= y < fb.height:
        at = (y * fb.width + x) * 4
        fb.bytes[at : at + 4] = bytes((color >> 16 & 255, color >> 8 & 255, color & 255, 255))


def draw_line(x0, y0, x1, y1, color):
    """Draws a line, both ends lit (Bresenham)."""
    dx, dy = abs(x1 - x0), -abs(y1 - y0)
    sx, sy = (1 if x0 < x1 else -1), (1 if y0 < y1 else -1)
    error = dx + dy
    while True:
        put_pixel(x0, y0, color)
        if (x0, y0) == (x1, y1):
            return
        twice = 2 * error
        if twice >= dy:
            error, x0 = error + dy, x0 + sx
        if twice <= dx:
            error, y0 = error + dx, y0 + sy


def draw_triangle(x0, y0, x1, y1, x2, y2, color):
    """Draws a triangle's three lines."""
    draw_line(x0, y0, x1, y1, color)
    draw_line(x1, y1, x2, y2, color)
    draw_line(x2, y2, x0, y0, color)


def draw_mesh(vertices, faces, color):
    """Draws the triangles of a mesh: x to the right, y up; 3 units are as high as the window."""
    for face in faces:
        at = []
        for x, y, _ in (vertices[k] for k in face):
            at.append(int(fb.width // 2 + x * fb.height / 3))
            at.append(int(fb.height // 2 - y * fb.height / 3))
        draw_triangle(*at, color)


OCTAHEDRON = [(1, 0.25, 0), (-1, -0.25, 0), (0.125, 1, 0), (-0.125, -1, 0), (0.5, -0.375, 1), (-0.5, 0.375, -1)]
FACES = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]

with SharedMemory(sys.argv[1] if len(sys.argv) > 1 else "/tmp/fb") as fb:
    put_pixel(5, 5, 0xFFFFFF)
    draw_line(0, 0, fb.width - 1, fb.height - 1, 0x404040)
    draw_triangle(20, 100, 120, 60, 80, 180, 0xFF8000)
    draw_mesh(OCTAHEDRON, FACES, 0x40C0FF)
    fb.ring()
