// Notations of points and colours: rows first, packed colours, namespaces, private fields, colours
// from 0 to 1 in arrays, points that hold colours beside colours of their own.
#include <GL/glut.h>
#include <cmath>
#include <cstdlib>
#include "fill.h"
const int WIDTH = 64, HEIGHT = 48;
unsigned char *FBptr;

typedef struct cor Cor;
struct cor {
    float r = 0, g{0}, b;
    float a = { 1 };
};
class Ponto {
    int px, py;
    Ponto() {}
public:
    explicit Ponto(int x, int y) : px{x}, py{y} {}
    int coluna() const { return px; }
    int linha() const { return py; }
};
struct Vertice {
    int coord[2];
    Cor cor;
};
#if 0
void PutPixel(int x, int y, int r, int g, int b) {}
void MyGlDraw(void) {}
#else
namespace tela {
namespace memoria {
// The bytes of the colour are those of the memory.
void PutPixel(int linha, int coluna, unsigned int cor) {
    *(unsigned int *)(FBptr + (linha * WIDTH + coluna) * 4) = cor;
}
}
unsigned empacota(Cor c) {
    unsigned rgba = 0;
    const float parts[4] = { c.r, c.g, c.b, c.a };
    for (int i = 0; i < 4; i++) rgba |= (unsigned)std::floor(parts[i] * 255.0f + 0.5f) << 8 * i;
    return rgba;
}
void DrawLine(const Ponto &de, const Ponto &ate, Cor cores[]) {
    int dx = ate.coluna() - de.coluna(), dy = ate.linha() - de.linha();
    int n = std::abs(dx) > std::abs(dy) ? std::abs(dx) : std::abs(dy);
    for (int k = 0; k <= n; k++) {
        float t = n ? (float)k / n : 0;
        Cor c;
        c.r = cores[0].r + (cores[1].r - cores[0].r) * t;
        c.g = cores[0].g + (cores[1].g - cores[0].g) * t;
        c.b = cores[0].b + (cores[1].b - cores[0].b) * t;
        int x = (int)std::floor(de.coluna() + (double)dx * k / (n ? n : 1) + 0.5);
        int y = (int)std::floor(de.linha() + (double)dy * k / (n ? n : 1) + 0.5);
        memoria::PutPixel(y, x, empacota(c));
    }
}
}
#endif
// The colours of the points are not drawn.
void DrawTriangle(Vertice a, Vertice b, Vertice c, Cor ca, Cor cb, Cor cc) {
    const Vertice *v[] = { &a, &b, &c };
    const Cor colors[] = { ca, cb, cc }, held[] = { a.cor, b.cor, c.cor };
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        Cor ends[2] = { colors[i], colors[j] };
        if (held[i].r != colors[i].r || held[i].b != colors[i].b) continue;
        tela::DrawLine(Ponto(v[i]->coord[0], v[i]->coord[1]), Ponto(v[j]->coord[0], v[j]->coord[1]), ends);
    }
}
void MyGlDraw(void) {}
void display(void) {
    MyGlDraw();
    preenche();
    glDrawPixels(WIDTH, HEIGHT, GL_RGBA, GL_UNSIGNED_BYTE, FBptr);
    glutSwapBuffers();
}
int main(int argc, char **argv) {
    glutInit(&argc, argv);
    glutInitDisplayMode(GLUT_RGBA | GLUT_DOUBLE);
    glutInitWindowSize(WIDTH, HEIGHT);
    glutCreateWindow("notations");
    glRasterPos2f(-1.0f, 1.0f);
    glPixelZoom(1.0f, -1.0f);
    FBptr = (unsigned char *)calloc(WIDTH * HEIGHT, 5);
    glutDisplayFunc(display);
    glutMainLoop();
}
