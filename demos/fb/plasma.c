/* Plasma: drawn once in 8 bits; only the palette moves. */
#include "fb.h"

int main(int count, char **words)
{
    fb_open(8, 1);
    for (int y = 0; y < fb_h; y++)
        for (int x = 0; x < fb_w; x++) {
            double v = sin(x / 17.0) + sin(y / 11.0) + sin((x + y) / 23.0) + sin(hypot(x - fb_w / 2, y - fb_h / 2) / 9.0);
            fb[y * fb_line + x] = (int)(v * 32 + 128);
        }
    for (long t = 0, end = frames(count, words); t < end; t++) {
        uint16_t map[3][256];
        for (int i = 0; i < 256; i++)
            for (int c = 0; c < 3; c++)
                map[c][i] = 32767 + 32767 * sin((i + t) * 6.28318 / 256 * (c + 1) + c);
        struct fb_cmap all = {0, 256, map[0], map[1], map[2], NULL};
        ioctl(fb_fd, FBIOPUTCMAP, &all);
        fb_wait();
    }
}
