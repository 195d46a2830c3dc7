/* glDrawPixels of a memory of three bytes a pixel, which is no allocation unless there is an argument: then its first
   row alone is drawn, and changed after it was shown. And all callbacks, which say their arguments. */
#include <GL/glut.h>
#include <stdio.h>

#define WIDTH 120
#define HEIGHT 80
static unsigned char storage[WIDTH * HEIGHT * 3], *image = storage;

static void display(void)
{
    if (image != storage) {
        for (int x = 0; x < WIDTH; x++)
            image[3 * x + 1] = x;
        glRasterPos2i(-1, -1);
        glDrawPixels(WIDTH, HEIGHT, GL_RGB, GL_UNSIGNED_BYTE, image);
        for (int x = 0; x < WIDTH; x++)
            image[3 * x] = 9;
        return;
    }
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            unsigned char *pixel = image + 3 * (y * WIDTH + x);
            pixel[0] = 2 * x, pixel[1] = 3 * y, pixel[2] = 7;
        }
    glClear(GL_COLOR_BUFFER_BIT);
    glRasterPos2i(-1, -1);
    glDrawPixels(WIDTH, HEIGHT, GL_RGB, GL_UNSIGNED_BYTE, image);
    glutSwapBuffers();
}

static void reshape(int width, int height) { printf("reshape %d %d\n", width, height); }
static void keyboard(unsigned char key, int x, int y)
{
    printf("key %d %d %d\n", key, x, y);
    if (key == 27)
        exit(3);
}
static void keyboard_up(unsigned char key, int x, int y) { printf("key up %d\n", key); }
static void special(int key, int x, int y) { printf("special %d with %d\n", key, glutGetModifiers()); }
static void mouse(int button, int state, int x, int y) { printf("mouse %d %d %d %d\n", button, state, x, y); }
static void motion(int x, int y) { printf("motion %d %d\n", x, y); }
static void passive(int x, int y) { printf("passive %d %d\n", x, y); }
static void timer(int value) { printf("timer %d %d\n", value, glutGet(GLUT_ELAPSED_TIME) >= 50); }

int main(int argc, char **argv)
{
    glutInit(&argc, argv);
    glutInitWindowSize(WIDTH, HEIGHT);
    glutCreateWindow("pixels");
    if (argc > 1)
        image = calloc(WIDTH * HEIGHT, 3);
    glutDisplayFunc(display);
    glutReshapeFunc(reshape);
    glutKeyboardFunc(keyboard);
    glutKeyboardUpFunc(keyboard_up);
    glutSpecialFunc(special);
    glutMouseFunc(mouse);
    glutMotionFunc(motion);
    glutPassiveMotionFunc(passive);
    glutTimerFunc(50, timer, 7);
    glutMainLoop();
    return 0;
}
