/* What programs of GLUT include of GLEW: OpenGL's header, and a beginning that succeeds. */
#ifndef FBPTR_GLEW_H
#define FBPTR_GLEW_H

#include <GL/gl.h>

#define GLEW_OK 0

static inline GLenum glewInit(void) { return GLEW_OK; }

#endif
