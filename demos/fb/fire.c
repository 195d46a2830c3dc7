/* Fire: each cell is the mean of those below it, a little cooler; 8 bits and a palette from black to white. */
#include "fb.h"

int main(int count, char **words)
{
    fb_open(8, 1);
    uint32_t random = 1;
    uint8_t *heat = calloc(fb_w, fb_h + 2);
    for (int i = 0; i < 256; i++)
        fb_color(i, i < 85 ? i * 3 : 255, i < 85 ? 0 : i < 170 ? (i - 85) * 3 : 255, i < 170 ? 0 : (i - 170) * 3);
    for (long t = 0, end = frames(count, words); t < end; t++) {
        for (int x = 0; x < 2 * fb_w; x++) {
            random = random * 1664525 + 1013904223;
            heat[fb_h * fb_w + x] = random >> 31 ? 255 : 60;
        }
        for (int i = 0; i < fb_w * fb_h; i++) {
            int left = i + fb_w - 1, mean = (heat[left] + heat[left + 1] + heat[left + 2] + heat[i + 2 * fb_w]) / 4;
            heat[i] = mean > 0 ? mean - (mean > 1) : 0;
        }
        for (int y = 0; y < fb_h; y++)
            memcpy(fb + y * fb_line, heat + y * fb_w, fb_w);
        fb_wait();
    }
}
