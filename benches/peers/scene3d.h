/* W1 to W5 as every C peer in three dimensions draws them: matrices by OpenGL's conventions, the layers of W3. */
#ifndef PEERS_SCENE3D_H
#define PEERS_SCENE3D_H

#include "common.h"

/* Column by column: entry (row r, column c) is m[4 c + r]. */
typedef struct {
    float m[16];
} Matrix;

static inline Matrix product(Matrix a, Matrix b) {
    Matrix out;
    for (int c = 0; c < 4; c++)
        for (int r = 0; r < 4; r++) {
            double sum = 0;
            for (int k = 0; k < 4; k++) sum += (double)a.m[4 * k + r] * b.m[4 * c + k];
            out.m[4 * c + r] = (float)sum;
        }
    return out;
}

static inline Matrix model_matrix(void) {
    float c1 = cosf(0.3f), s1 = sinf(0.3f), c2 = cosf(0.4f), s2 = sinf(0.4f);
    Matrix about_x = {{1, 0, 0, 0, 0, c1, s1, 0, 0, -s1, c1, 0, 0, 0, 0, 1}};
    Matrix about_y = {{c2, 0, -s2, 0, 0, 1, 0, 0, s2, 0, c2, 0, 0, 0, 0, 1}};
    return product(about_x, about_y);
}

/* The eye at (0, 0, 5.2) looking along -z; 60 degrees on the height, near 1, far 10. */
static inline Matrix camera_matrix(void) {
    float near = 1, far = 10, cot = (float)(1 / tan(M_PI / 6));
    Matrix view = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -5.2f, 1}};
    Matrix projection = {{cot * HEIGHT / WIDTH, 0, 0, 0, 0, cot, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0,
                          2 * far * near / (near - far), 0}};
    return product(projection, view);
}

/* Quads over the whole frame, far to near; the colour takes the normal's place. */
static inline Mesh layer_mesh(void) {
    Mesh mesh = {LAYERS * 4, LAYERS * 2, NULL, NULL};
    mesh.vertices = must(calloc(LAYERS * 4, 32), "memory");
    mesh.indices = must(malloc(LAYERS * 2 * 12), "memory");
    static const float corners[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    static const uint32_t order[6] = {0, 1, 2, 0, 2, 3};
    for (int i = 0; i < LAYERS; i++) {
        for (int k = 0; k < 4; k++) {
            float *v = mesh.vertices + (i * 4 + k) * 8;
            v[0] = corners[k][0];
            v[1] = corners[k][1];
            v[2] = 0.95f - 0.09f * (float)i;
            v[3] = (float)(i * 37 % 256) / 255;
            v[4] = (float)((i * 91 + 40) % 256) / 255;
            v[5] = (float)((i * 151 + 90) % 256) / 255;
        }
        for (int k = 0; k < 6; k++) mesh.indices[i * 6 + k] = (uint32_t)i * 4 + order[k];
    }
    return mesh;
}

#endif
