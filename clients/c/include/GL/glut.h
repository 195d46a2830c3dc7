/* GLUT as `fbptr run` serves it. As in other headers of GLUT, <stdlib.h> comes with it. */
#ifndef FBPTR_GLUT_H
#define FBPTR_GLUT_H

#include <GL/gl.h>
#include <GL/glu.h>
#include <stdlib.h>

#define GLUT_API_VERSION 4
#define GLUT_XLIB_IMPLEMENTATION 13
#define FREEGLUT 1
#define GLUTAPIENTRY

#define GLUT_RGB 0x0000
#define GLUT_RGBA 0x0000
#define GLUT_SINGLE 0x0000
#define GLUT_DOUBLE 0x0002
#define GLUT_ALPHA 0x0008
#define GLUT_DEPTH 0x0010
#define GLUT_STENCIL 0x0020
#define GLUT_MULTISAMPLE 0x0080

#define GLUT_LEFT_BUTTON 0
#define GLUT_MIDDLE_BUTTON 1
#define GLUT_RIGHT_BUTTON 2
#define GLUT_DOWN 0
#define GLUT_UP 1
#define GLUT_NOT_VISIBLE 0
#define GLUT_VISIBLE 1

#define GLUT_KEY_F1 1
#define GLUT_KEY_F2 2
#define GLUT_KEY_F3 3
#define GLUT_KEY_F4 4
#define GLUT_KEY_F5 5
#define GLUT_KEY_F6 6
#define GLUT_KEY_F7 7
#define GLUT_KEY_F8 8
#define GLUT_KEY_F9 9
#define GLUT_KEY_F10 10
#define GLUT_KEY_F11 11
#define GLUT_KEY_F12 12
#define GLUT_KEY_LEFT 100
#define GLUT_KEY_UP 101
#define GLUT_KEY_RIGHT 102
#define GLUT_KEY_DOWN 103
#define GLUT_KEY_PAGE_UP 104
#define GLUT_KEY_PAGE_DOWN 105
#define GLUT_KEY_HOME 106
#define GLUT_KEY_END 107
#define GLUT_KEY_INSERT 108

#define GLUT_ACTIVE_SHIFT 1
#define GLUT_ACTIVE_CTRL 2
#define GLUT_ACTIVE_ALT 4

#define GLUT_WINDOW_WIDTH 102
#define GLUT_WINDOW_HEIGHT 103
#define GLUT_SCREEN_WIDTH 200
#define GLUT_SCREEN_HEIGHT 201
#define GLUT_INIT_WINDOW_WIDTH 502
#define GLUT_INIT_WINDOW_HEIGHT 503
#define GLUT_ELAPSED_TIME 700

#define GLUT_CURSOR_LEFT_ARROW 1
#define GLUT_CURSOR_NONE 101
#define GLUT_ACTION_EXIT 0
#define GLUT_ACTION_GLUTMAINLOOP_RETURNS 1
#define GLUT_ACTION_CONTINUE_EXECUTION 2
#define GLUT_ACTION_ON_WINDOW_CLOSE 0x01F9
#define GLUT_KEY_REPEAT_OFF 0
#define GLUT_KEY_REPEAT_ON 1

#ifdef __cplusplus
extern "C" {
#endif

void glutInit(int *argc, char **argv);
void glutInitDisplayMode(unsigned int mode);
void glutInitWindowSize(int width, int height);
void glutInitWindowPosition(int x, int y);
int glutCreateWindow(const char *title);
void glutDestroyWindow(int window);
int glutGetWindow(void);
void glutMainLoop(void);
void glutMainLoopEvent(void);
void glutLeaveMainLoop(void);
void glutExit(void);
void glutPostRedisplay(void);
void glutSwapBuffers(void);

void glutDisplayFunc(void (*function)(void));
void glutIdleFunc(void (*function)(void));
void glutReshapeFunc(void (*function)(int width, int height));
void glutVisibilityFunc(void (*function)(int state));
void glutKeyboardFunc(void (*function)(unsigned char key, int x, int y));
void glutKeyboardUpFunc(void (*function)(unsigned char key, int x, int y));
void glutSpecialFunc(void (*function)(int key, int x, int y));
void glutSpecialUpFunc(void (*function)(int key, int x, int y));
void glutMouseFunc(void (*function)(int button, int state, int x, int y));
void glutMouseWheelFunc(void (*function)(int wheel, int direction, int x, int y));
void glutMotionFunc(void (*function)(int x, int y));
void glutPassiveMotionFunc(void (*function)(int x, int y));
void glutTimerFunc(unsigned int milliseconds, void (*function)(int value), int value);

int glutGet(GLenum what);
int glutGetModifiers(void);

/* Calls that change nothing. */
void glutSetWindowTitle(const char *title);
void glutPositionWindow(int x, int y);
void glutReshapeWindow(int width, int height);
void glutFullScreen(void);
void glutSetCursor(int cursor);
void glutSetOption(GLenum what, int value);
void glutIgnoreKeyRepeat(int is_ignored);
void glutSetKeyRepeat(int mode);

#ifdef __cplusplus
}
#endif

#endif
