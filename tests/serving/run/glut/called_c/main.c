/* The style of a framework in C: numbers alone, and lines in one colour that none may choose. */
#include <GL/glut.h>
#include <stdlib.h>
#define WIDTH 64
#define HEIGHT 48
typedef unsigned char octet;
typedef struct point { int x, y; } Point;
octet *fb_ptr;
void putPixel(struct point *p, octet r, octet g, octet b, octet a) {
    octet *at = fb_ptr + (p->y * WIDTH + p->x) * 4;
    at[0] = r, at[1] = g, at[2] = b, at[3] = a;
}
void drawLine(int, int, int, int);
void drawLine(int a, int b, int c, int d) {
    Point p;
    for (p.x = a, p.y = b; p.x <= c; p.x++) putPixel(&p, 0, 200, 0, 255);
}
void MyGlDraw(void) {
    drawLine(1, 1, 60, 1);
}
void display(void) {
    MyGlDraw();
    glDrawPixels(WIDTH, HEIGHT, GL_RGBA, GL_UNSIGNED_BYTE, fb_ptr);
    glutSwapBuffers();
}
int main(int argc, char **argv) {
    glutInit(&argc, argv);
    glutInitWindowSize(WIDTH, HEIGHT);
    glutCreateWindow("called_c");
    glRasterPos2f(-1.0f, 1.0f);
    glPixelZoom(1.0f, -1.0f);
    fb_ptr = calloc(WIDTH * HEIGHT, 5);
    glutDisplayFunc(display);
    glutMainLoop();
    return 0;
}
