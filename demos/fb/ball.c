/* A bouncing ball by page flip: each frame is drawn whole on the hidden page. */
#include "fb.h"

int main(int count, char **words)
{
    fb_open(32, 2);
    double radius = fb_h / 6.0, x = radius, y = radius, dx = fb_w / 150.0, dy = 0;
    for (long t = 0, end = frames(count, words); t < end; t++) {
        uint8_t *page = fb_back();
        for (int row = 0; row < fb_h; row++)
            for (int column = 0; column < fb_w; column++) {
                double u = (column - x) / radius, v = (row - y) / radius, inside = 1 - u * u - v * v;
                uint32_t *pixel = (uint32_t *)(page + row * fb_line) + column;
                if (inside > 0) {
                    int light = 80 + 175 * sqrt(inside), patch = (int)(8 + 4 * asin(u) + t / 9.0) + (int)(8 + 4 * asin(v));
                    *pixel = patch % 2 ? light << 16 : light * 0x10101;
                } else
                    *pixel = column % 32 && row % 32 ? 0x303040 : 0x8040a0;
            }
        fb_flip();
        x += dx, y += dy, dy += fb_h / 3000.0;
        if (x < radius || x > fb_w - radius)
            dx = -dx, x += dx;
        if (y > fb_h - radius)
            y = fb_h - radius, dy = -fb_h / 38.0;
    }
}
