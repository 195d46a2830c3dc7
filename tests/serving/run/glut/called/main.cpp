#include <GL/glut.h>
#include "mygl.h"
// void MyGlDraw(void) { is not here }
void MyGlDraw(void) {
    Tint tint;
    tint.red = tint.green = tint.blue = 255;
    PutPixel(Dot(30, 30, &tint));
}
void display(void) {
    MyGlDraw();
    glDrawPixels(WIDTH, HEIGHT, GL_RGBA, GL_UNSIGNED_BYTE, FBptr);
    glutSwapBuffers();
    glutPostRedisplay();
}
int main(int argc, char **argv) {
    glutInit(&argc, argv);
    glutInitDisplayMode(GLUT_RGBA | GLUT_DOUBLE);
    glutInitWindowSize(WIDTH, HEIGHT);
    glutCreateWindow("called");
    // The upper row is the first.
    glRasterPos2f(-1.0f, 1.0f);
    glPixelZoom(1.0f, -1.0f);
    FBptr = (unsigned char *)calloc(WIDTH * HEIGHT, 5);
    glutDisplayFunc(display);
    glutMainLoop();
}
