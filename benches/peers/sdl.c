/* W6 on SDL2's software renderer, into a surface of 32 bits: cc -O2 -o sdl sdl.c $(pkg-config --cflags --libs sdl2) */
#include "common.h"
#include <SDL.h>

static const char *const PEER = "SDL2";

static SDL_Renderer *renderer;

typedef struct {
    const PackedLine *lines;
    int count;
} Job;

static void frame(void *arg) {
    const Job *job = arg;
    SDL_SetRenderDrawColor(renderer, 26, 26, 38, 255);
    SDL_RenderClear(renderer);
    for (int i = 0; i < job->count; i++) {
        const PackedLine *line = &job->lines[i];
        SDL_SetRenderDrawColor(renderer, line->color[0], line->color[1], line->color[2], 255);
        SDL_RenderDrawLine(renderer, line->x0, line->y0, line->x1, line->y1);
    }
    SDL_RenderFlush(renderer);
}

int main(void) {
    SDL_Surface *surface = SDL_CreateRGBSurfaceWithFormat(0, WIDTH, HEIGHT, 32, SDL_PIXELFORMAT_ARGB8888);
    renderer = must(SDL_CreateSoftwareRenderer(must(surface, "a surface")), "a renderer");
    static const char *const names[2] = {"W6_lines_long", "W6_lines_short"};
    static const int counts[2] = {LONG_LINES, SHORT_LINES};
    for (int i = 0; i < 2 && is_wanted("W6"); i++) {
        Job job = {make_lines(counts[i], i), counts[i]};
        measure(PEER, names[i], frame, &job);
        save_picture(PEER, names[i], surface->pixels, 2, 0, 0);
    }
    return 0;
}
