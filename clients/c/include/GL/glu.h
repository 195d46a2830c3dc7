/* GLU as `fbptr run` serves it. */
#ifndef FBPTR_GLU_H
#define FBPTR_GLU_H

#include <GL/gl.h>

#ifdef __cplusplus
extern "C" {
#endif

void gluOrtho2D(GLdouble left, GLdouble right, GLdouble bottom, GLdouble top);
GLint gluBuild2DMipmaps(GLenum target, GLint internal, GLsizei width, GLsizei height, GLenum format, GLenum type,
                        const void *pixels);
const GLubyte *gluErrorString(GLenum error);

#ifdef __cplusplus
}
#endif

#endif
