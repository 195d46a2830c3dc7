// The style of a C++ framework: FBptr with five bytes a pixel, y down, all in headers and globals. The first argument
// says what is done: "draw", "behind N", "before", "wide", "pause" after N pixels, or "slow": cleared and drawn again, over and over. Then N, and the
// width and the height of the window.
#include <GL/glut.h>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <string>
#include <unistd.h>

static int width = 512, height = 512;
static unsigned char *FBptr;
static GLuint tex;
static std::string what;
static int count;

static void PutPixel(int x, int y, int r, int g, int b)
{
    unsigned char *pixel = FBptr + 4 * (x + width * y);
    pixel[0] = r;
    pixel[1] = g;
    pixel[2] = b;
    pixel[3] = 0;
}

static void MyGlDraw()
{
    if (what == "pause") {
        for (int i = 0; i < count; i++)
            PutPixel(i, i, 255, 200, 100);
        for (;;)
            pause();
    }
    if (what == "slow")
        std::memset(FBptr, 0, 4 * width * height);
    for (int y = 0; y < height; usleep(what == "slow" ? 500 : 0), y++)
        for (int x = 0; x < width; x++)
            PutPixel(x, y, x % 256, y % 256, (x + 2 * y) % 256);
    if (what == "behind")
        for (int i = 0; i < count; i++)
            PutPixel(i, height, 1, 2, 3);
    if (what == "before")
        PutPixel(-1, 0, 1, 2, 3);
    if (what == "wide")
        *(volatile long *)(FBptr + 4 * width * height + 8) = 1;
    what = what == "slow" ? what : "";
}

static void display()
{
    MyGlDraw();
    glBindTexture(GL_TEXTURE_2D, tex);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, FBptr);
    glEnable(GL_TEXTURE_2D);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glBegin(GL_TRIANGLES);
    glTexCoord2f(0, 1);
    glVertex3f(-1, -1, 0);
    glTexCoord2f(1, 0);
    glVertex3f(1, 1, 0);
    glTexCoord2f(0, 0);
    glVertex3f(-1, 1, 0);
    glTexCoord2f(0, 1);
    glVertex3f(-1, -1, 0);
    glTexCoord2f(1, 1);
    glVertex3f(1, -1, 0);
    glTexCoord2f(1, 0);
    glVertex3f(1, 1, 0);
    glEnd();
    glDisable(GL_TEXTURE_2D);
    glFlush();
    glutSwapBuffers();
    glutPostRedisplay();
}

int main(int argc, char **argv)
{
    what = argc > 1 ? argv[1] : "draw";
    count = argc > 2 ? std::atoi(argv[2]) : 0;
    if (argc > 4)
        width = std::atoi(argv[3]), height = std::atoi(argv[4]);
    glutInit(&argc, argv);
    glutInitDisplayMode(GLUT_RGBA | GLUT_DEPTH | GLUT_DOUBLE);
    glutInitWindowSize(width, height);
    glutInitWindowPosition(100, 100);
    glutCreateWindow("y down");
    glMatrixMode(GL_PROJECTION);
    glLoadIdentity();
    glOrtho(-1, 1, -1, 1, -1, 1);
    glMatrixMode(GL_MODELVIEW);
    glutDisplayFunc(display);
    FBptr = new unsigned char[width * height * 5];
    std::memset(FBptr, 0, width * height * 4);
    glGenTextures(1, &tex);
    glBindTexture(GL_TEXTURE_2D, tex);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glutMainLoop();
    return 0;
}
