/* Pictures that are parts of the window: a part of a larger texture, enlarged and upside down, over a cleared window;
   pixels of floats and of one grey level; and what draws with OpenGL itself. */
#include <GL/glut.h>

void glCallList(GLuint list);

static unsigned char texels[16 * 16 * 4];

static void display(void)
{
    GLuint tex;
    glClearColor(0, 0, 1, 0);
    glClear(GL_COLOR_BUFFER_BIT);
    glGenTextures(1, &tex);
    glBindTexture(GL_TEXTURE_2D, tex);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, 32, 32, 0, GL_RGBA, GL_UNSIGNED_BYTE, 0);
    for (int i = 0; i < 256; i++)
        texels[4 * i] = 16 * (i % 16), texels[4 * i + 1] = 16 * (i / 16);
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, 16, 16, GL_RGBA, GL_UNSIGNED_BYTE, texels);
    /* Sixteen texels on 32 pixels, the first row at the top. */
    glEnable(GL_TEXTURE_2D);
    glBegin(GL_QUADS);
    glTexCoord2f(0, 0.5f);
    glVertex2i(4, 4);
    glTexCoord2f(0.5f, 0.5f);
    glVertex2i(36, 4);
    glTexCoord2f(0.5f, 0);
    glVertex2i(36, 36);
    glTexCoord2f(0, 0);
    glVertex2i(4, 36);
    glEnd();
    glDisable(GL_TEXTURE_2D);
    float colors[6] = {1, 0.5f, 0, 0, 2, -1};
    glRasterPos2i(40, 0);
    glPixelZoom(2, 3);
    glDrawPixels(2, 1, GL_RGB, GL_FLOAT, colors);
    glPixelZoom(1, 1);
    glWindowPos2i(50, 39);
    glDrawPixels(1, 1, GL_LUMINANCE, GL_UNSIGNED_BYTE, "\x64");
    glBegin(GL_TRIANGLES);
    glVertex2i(0, 0);
    glVertex2i(9, 0);
    glVertex2i(0, 9);
    glEnd();
    glCallList(1);
    glCallList(1);
    glFlush();
}

int main(int argc, char **argv)
{
    glutInit(&argc, argv);
    glutInitWindowSize(60, 40);
    glutCreateWindow("parts");
    gluOrtho2D(0, 60, 0, 40);
    glutDisplayFunc(display);
    glutMainLoop();
    return 0;
}
