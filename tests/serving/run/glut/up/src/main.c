#include "mygl.h"
#include <GL/freeglut.h>

static GLuint tex;

static void Display(void)
{
    MyGlDraw();
    glBindTexture(GL_TEXTURE_2D, tex);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, IMAGE_WIDTH, IMAGE_HEIGHT, 0, GL_RGBA, GL_UNSIGNED_BYTE, GetFBMemPtr());
    glEnable(GL_TEXTURE_2D);
    glBegin(GL_QUADS);
    glTexCoord2f(0, 0);
    glVertex2i(0, 0);
    glTexCoord2f(1, 0);
    glVertex2i(IMAGE_WIDTH, 0);
    glTexCoord2f(1, 1);
    glVertex2i(IMAGE_WIDTH, IMAGE_HEIGHT);
    glTexCoord2f(0, 1);
    glVertex2i(0, IMAGE_HEIGHT);
    glEnd();
    glutSwapBuffers();
}

int main(int argc, char **argv)
{
    InitMyGl();
    glutInit(&argc, argv);
    glutInitWindowSize(IMAGE_WIDTH, IMAGE_HEIGHT);
    glutCreateWindow("y up");
    gluOrtho2D(0, IMAGE_WIDTH, 0, IMAGE_HEIGHT);
    glGenTextures(1, &tex);
    glBindTexture(GL_TEXTURE_2D, tex);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glutDisplayFunc(Display);
    glutIdleFunc(Display);
    glutMainLoop();
    return frames;
}
