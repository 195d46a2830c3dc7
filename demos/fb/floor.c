/* A Mode-7 floor: a plane in perspective, one row of constant depth after the other, in 16 bits. */
#include "fb.h"

int main(int count, char **words)
{
    fb_open(16, 2);
    for (long t = 0, end = frames(count, words); t < end; t++) {
        uint8_t *page = fb_back();
        double angle = t / 90.0, c = cos(angle), s = sin(angle), horizon = fb_h / 3.0;
        for (int y = 0; y < fb_h; y++) {
            uint16_t *row = (uint16_t *)(page + y * fb_line);
            if (y <= horizon) {
                for (int x = 0; x < fb_w; x++)
                    row[x] = (int)(y * 20 / horizon) << 5 | 31;
                continue;
            }
            double depth = fb_h * 0.4 / (y - horizon), light = fmin(1, 1.2 / depth);
            for (int x = 0; x < fb_w; x++) {
                double side = depth * (x - fb_w / 2) / (fb_w / 2);
                int u = floor(8 * (c * depth - s * side) + 2.5), v = floor(8 * (s * depth + c * side) + t / 10.0);
                int red = 31 * light * ((u ^ v) & 1), green = 63 * light * ((u >> 2 ^ v >> 2) & 1);
                row[x] = red << 11 | green << 5 | (int)(10 * light);
            }
        }
        fb_flip();
    }
}
