/* What the C peers share: the exported scene, the clock, the row of JSON and the picture.
 *
 * The scene comes from `fbptr bench --export DIR`: meshes as u32 vertex count, u32 triangle count, 8 f32 a vertex
 * (position, normal, texture coordinate), 3 u32 a triangle, little-endian; the texture as 1024 x 1024 RGBA bytes, row 0
 * at t = 0. Environment: PEERS_SCENE (that folder), PEERS_SHOTS (where pictures go), PEERS_ONLY (W1,W6: what to run),
 * PEERS_FRAMES (frames to time), PEERS_CFG (the row's "cfg"). */
#ifndef PEERS_COMMON_H
#define PEERS_COMMON_H

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { WIDTH = 1920, HEIGHT = 1080, LAYERS = 20, TEXTURE_SIDE = 1024 };
enum { LONG_LINES = 1000000, SHORT_LINES = 5000000 };

typedef struct {
    uint32_t vertex_count, triangle_count;
    float *vertices;
    uint32_t *indices;
} Mesh;

typedef struct {
    int16_t x0, y0, x1, y1;
    uint8_t color[4];
} PackedLine;

static inline const char *setting(const char *name, const char *otherwise) {
    const char *value = getenv(name);
    return value && *value ? value : otherwise;
}

static inline void *must(void *p, const char *what) {
    if (!p) {
        fprintf(stderr, "cannot have %s\n", what);
        exit(1);
    }
    return p;
}

static inline void read_all(FILE *file, void *to, size_t size, const char *what) {
    if (fread(to, 1, size, file) != size) {
        fprintf(stderr, "%s is cut short\n", what);
        exit(1);
    }
}

static inline FILE *open_scene_file(const char *name) {
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", setting("PEERS_SCENE", "."), name);
    return must(fopen(path, "rb"), path);
}

static inline Mesh load_mesh(const char *name) {
    FILE *file = open_scene_file(name);
    uint32_t counts[2];
    read_all(file, counts, sizeof counts, name);
    Mesh mesh = {counts[0], counts[1], NULL, NULL};
    mesh.vertices = must(malloc((size_t)mesh.vertex_count * 32), "memory");
    mesh.indices = must(malloc((size_t)mesh.triangle_count * 12), "memory");
    read_all(file, mesh.vertices, (size_t)mesh.vertex_count * 32, name);
    read_all(file, mesh.indices, (size_t)mesh.triangle_count * 12, name);
    fclose(file);
    return mesh;
}

static inline uint8_t *load_texture(void) {
    size_t size = (size_t)TEXTURE_SIDE * TEXTURE_SIDE * 4;
    FILE *file = open_scene_file("texture.rgba");
    uint8_t *texels = must(malloc(size), "memory");
    read_all(file, texels, size, "texture.rgba");
    fclose(file);
    return texels;
}

static uint32_t random_state;

static inline uint32_t next_random(void) {
    random_state ^= random_state << 13;
    random_state ^= random_state >> 17;
    random_state ^= random_state << 5;
    return random_state;
}

static inline int16_t held(int v, int limit) {
    return (int16_t)(v < 0 ? 0 : v >= limit ? limit - 1 : v);
}

/* The same lines and colours as fbptr's own W6. */
static inline PackedLine *make_lines(int count, int is_short) {
    PackedLine *lines = must(malloc((size_t)count * sizeof *lines), "memory");
    random_state = 0x12345678u;
    for (int i = 0; i < count; i++) {
        uint32_t a = next_random(), b = next_random(), mixed = (uint32_t)i * 2654435761u;
        PackedLine *line = &lines[i];
        line->x0 = (int16_t)(((a & 0xffff) * WIDTH) >> 16);
        line->y0 = (int16_t)(((a >> 16) * HEIGHT) >> 16);
        if (is_short) {
            line->x1 = held(line->x0 + (int)(b % 23) - 11, WIDTH);
            line->y1 = held(line->y0 + (int)((b >> 16) % 23) - 11, HEIGHT);
        } else {
            line->x1 = (int16_t)(((b & 0xffff) * WIDTH) >> 16);
            line->y1 = (int16_t)(((b >> 16) * HEIGHT) >> 16);
        }
        line->color[0] = (uint8_t)mixed;
        line->color[1] = (uint8_t)(mixed >> 8);
        line->color[2] = (uint8_t)(mixed >> 16);
        line->color[3] = 255;
    }
    return lines;
}

static inline double clock_ms(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return t.tv_sec * 1e3 + t.tv_nsec * 1e-6;
}

static inline double now_ms(void) {
    return clock_ms(CLOCK_MONOTONIC);
}

static inline int by_size(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Whether PEERS_ONLY names the workload by its number, as W4. */
static inline int is_wanted(const char *group) {
    char all[256], one[16];
    snprintf(all, sizeof all, ",%s,", setting("PEERS_ONLY", "W1,W2,W3,W4,W5,W6,W7"));
    snprintf(one, sizeof one, ",%s,", group);
    return strstr(all, one) != NULL;
}

/* As fbptr times: five frames to warm up where they are short, then PEERS_FRAMES of them or 6 seconds. "cpu_ms" is the
 * processor time of a frame, on all threads: the mean of the timed frames. */
static inline void measure(const char *peer, const char *workload, void (*frame)(void *), void *job) {
    enum { MOST = 1000 };
    static double times[MOST];
    int most = atoi(setting("PEERS_FRAMES", "40")), count = 0;
    if (most < 1 || most > MOST) most = MOST;
    double start = now_ms(), start_cpu = clock_ms(CLOCK_PROCESS_CPUTIME_ID);
    frame(job);
    double first = now_ms() - start;
    if (first < 300)
        for (int i = 0; i < 5; i++) frame(job);
    /* What takes this long is not run again. */
    if (first > 3000) times[count++] = first;
    if (first <= 3000) start_cpu = clock_ms(CLOCK_PROCESS_CPUTIME_ID);
    start = now_ms();
    while (first <= 3000 && count < most && (count < 3 || now_ms() - start < 6000)) {
        double begin = now_ms();
        frame(job);
        times[count++] = now_ms() - begin;
    }
    double cpu = (clock_ms(CLOCK_PROCESS_CPUTIME_ID) - start_cpu) / count;
    qsort(times, count, sizeof *times, by_size);
    printf("{\"peer\":\"%s\",\"cfg\":\"%s\",\"wl\":\"%s\",\"med_ms\":%.3f,\"min_ms\":%.3f,\"cpu_ms\":%.3f,\"n\":%d}\n",
           peer, setting("PEERS_CFG", "1T"), workload, times[count / 2], times[0], cpu, count);
    fflush(stdout);
}

/* The picture of a workload; `red` and `blue` are their places in a pixel of 4 bytes. */
static inline void save_picture(const char *peer, const char *workload, const uint8_t *pixels, int red, int blue,
                         int bottom_up) {
    const char *folder = getenv("PEERS_SHOTS");
    if (!folder) return;
    char path[1024];
    snprintf(path, sizeof path, "%s/%s_%s_%s.ppm", folder, peer, setting("PEERS_CFG", "1T"), workload);
    FILE *file = must(fopen(path, "wb"), path);
    fprintf(file, "P6\n%d %d\n255\n", WIDTH, HEIGHT);
    static uint8_t row[WIDTH * 3];
    for (int y = 0; y < HEIGHT; y++) {
        const uint8_t *from = pixels + (size_t)(bottom_up ? HEIGHT - 1 - y : y) * WIDTH * 4;
        for (int x = 0; x < WIDTH; x++) {
            row[3 * x] = from[4 * x + red];
            row[3 * x + 1] = from[4 * x + 1];
            row[3 * x + 2] = from[4 * x + blue];
        }
        fwrite(row, 1, sizeof row, file);
    }
    fclose(file);
}

#endif
