/* One function is written elsewhere, in a part that is not compiled; the others are whole. */
#include <GL/glut.h>
#include <stdlib.h>
enum { WIDTH = 64, HEIGHT = 48 };
unsigned char *FBptr;
typedef struct { int x, y; } Ponto;
typedef struct { unsigned char r, g, b, a; } Cor;
void PutPixel(Ponto p, Cor c) {
    unsigned char *at = FBptr + (p.y * WIDTH + p.x) * 4;
    at[0] = c.r, at[1] = c.g, at[2] = c.b, at[3] = c.a;
}
#ifdef LINES
void DrawLine(Ponto p, Ponto q, Cor c) {}
#endif
/* Corners are whole numbers, and a row begins and ends at the ideal edges. */
void FillTriangle(int x0, int y0, int x1, int y1, int x2, int y2, Cor *cor) {
    int x, y, i, p[3][2] = { { x0, y0 }, { x1, y1 }, { x2, y2 } };
    for (y = 0; y < HEIGHT; y++)
        for (x = 0; x < WIDTH; x++) {
            int inside = 0;
            for (i = 0; i < 3; i++) {
                int *a = p[i], *b = p[(i + 1) % 3];
                /* The centre of the pixel, doubled. */
                inside += (b[0] - a[0]) * (2 * y + 1 - 2 * a[1]) > (b[1] - a[1]) * (2 * x + 1 - 2 * a[0]) ? 1 : -1;
            }
            if (inside == 3 || inside == -3) {
                Ponto at = { x, y };
                PutPixel(at, *cor);
            }
        }
}
void MyGlDraw(void) {}
void display(void) {
    MyGlDraw();
    glDrawPixels(WIDTH, HEIGHT, GL_RGBA, GL_UNSIGNED_BYTE, FBptr);
    glutSwapBuffers();
}
int main(int argc, char **argv) {
    glutInit(&argc, argv);
    glutInitDisplayMode(GLUT_RGBA | GLUT_DOUBLE);
    glutInitWindowSize(WIDTH, HEIGHT);
    glutCreateWindow("broken");
    glRasterPos2f(-1.0f, 1.0f);
    glPixelZoom(1.0f, -1.0f);
    FBptr = (unsigned char *)calloc(WIDTH * HEIGHT, 5);
    glutDisplayFunc(display);
    glutMainLoop();
    return 0;
}
