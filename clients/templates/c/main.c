#include "fbptr.h"

static fbptr fb;

/* Sets the pixel at column x and row y, counted from the upper left, to 0xRRGGBB; outside of the window nothing. */
void put_pixel(int x, int y, unsigned color)
{
    unsigned char *pixel;
    if (x < 0 || y < 0 || x >= fb.width || y >= fb.height)
        return;
    pixel = fb.FBptr + fb.stride * y + 4 * x;
    pixel[0] = color >> 16 & 255;
    pixel[1] = color >> 8 & 255;
    pixel[2] = color & 255;
    pixel[3] = 255;
}

/* Draws a line, both ends lit (Bresenham). */
void draw_line(int x0, int y0, int x1, int y1, unsigned color)
{
    int dx = abs(x1 - x0), dy = -abs(y1 - y0), sx = x0 < x1 ? 1 : -1, sy = y0 < y1 ? 1 : -1, error = dx + dy;
    for (;;) {
        int twice = 2 * error;
        put_pixel(x0, y0, color);
        if (x0 == x1 && y0 == y1)
            return;
        if (twice >= dy)
            error += dy, x0 += sx;
        if (twice <= dx)
            error += dx, y0 += sy;
    }
}

/* Draws a triangle's three lines. */
void draw_triangle(int x0, int y0, int x1, int y1, int x2, int y2, unsigned color)
{
    draw_line(x0, y0, x1, y1, color);
    draw_line(x1, y1, x2, y2, color);
    draw_line(x2, y2, x0, y0, color);
}

/* Draws the triangles of a mesh: x to the right, y up, z is left out; 3 units are as high as the window. */
void draw_mesh(const double vertices[][3], const int faces[][3], int face_count, unsigned color)
{
    int i, k, at[3][2];
    for (i = 0; i < face_count; i++) {
        for (k = 0; k < 3; k++) {
            const double *vertex = vertices[faces[i][k]];
            at[k][0] = (int)(fb.width / 2 + vertex[0] * fb.height / 3);
            at[k][1] = (int)(fb.height / 2 - vertex[1] * fb.height / 3);
        }
        draw_triangle(at[0][0], at[0][1], at[1][0], at[1][1], at[2][0], at[2][1], color);
    }
}

int main(int argc, char **argv)
{
    static const double octahedron[][3] = {
        {1, 0.25, 0}, {-1, -0.25, 0}, {0.125, 1, 0}, {-0.125, -1, 0}, {0.5, -0.375, 1}, {-0.5, 0.375, -1},
    };
    static const int faces[][3] = {
        {0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5},
    };
    const char *path = argc > 1 ? argv[1] : "/tmp/fb";
    if (fbptr_map(&fb, path) != 0) {
        fprintf(stderr, "%s: no shared file of fbptr; start: fbptr serve --shm %s\n", path, path);
        return 1;
    }
    put_pixel(5, 5, 0xffffff);
    draw_line(0, 0, fb.width - 1, fb.height - 1, 0x404040);
    draw_triangle(20, 100, 120, 60, 80, 180, 0xff8000);
    draw_mesh(octahedron, faces, 8, 0x40c0ff);
    fbptr_present(&fb);
    fbptr_close(&fb);
    return 0;
}
