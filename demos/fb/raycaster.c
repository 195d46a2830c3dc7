/* A raycaster: one ray a column through a map of walls; it walks along the free row of its rooms and turns. */
#include "fb.h"

static const char *map[8] = {"########", "#...#..#", "#......#", "##....##", "#......#", "#..#...#", "#......#", "########"};

int main(int count, char **words)
{
    fb_open(32, 2);
    for (long t = 0, end = frames(count, words); t < end; t++) {
        uint8_t *page = fb_back();
        double px = 4 + 1.5 * cos(t / 70.0), py = 4.5 + 0.3 * sin(t / 50.0), heading = t / 100.0;
        for (int x = 0; x < fb_w; x++) {
            double view = (x - fb_w / 2.0) / fb_w * 1.2, dx = cos(heading) - sin(heading) * view;
            double dy = sin(heading) + cos(heading) * view, step_x = fabs(1 / dx), step_y = fabs(1 / dy);
            int cx = px, cy = py, side = 0;
            double to_x = (dx < 0 ? px - cx : cx + 1 - px) * step_x, to_y = (dy < 0 ? py - cy : cy + 1 - py) * step_y;
            while (map[cy][cx] == '.')
                if (to_x < to_y)
                    to_x += step_x, cx += dx < 0 ? -1 : 1, side = 0;
                else
                    to_y += step_y, cy += dy < 0 ? -1 : 1, side = 1;
            double distance = side ? to_y - step_y : to_x - step_x;
            int half = fb_h / (2 * distance + 0.001), light = 220 / (1 + distance * 0.3);
            uint32_t wall = side ? light << 16 | light / 2 << 8 : (light * 3 / 4) << 16 | (light / 3) << 8;
            for (int y = 0; y < fb_h; y++) {
                int off = y - fb_h / 2;
                uint32_t *pixel = (uint32_t *)(page + y * fb_line) + x;
                *pixel = off >= half ? 0x404040 : off < -half ? 0x203060 : wall;
            }
        }
        fb_flip();
    }
}
