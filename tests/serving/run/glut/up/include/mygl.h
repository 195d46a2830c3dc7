/* The style of a C framework: fb_ptr behind GetFBMemPtr, y up, one variable that two files define. */
#ifndef MYGL_H
#define MYGL_H
#define IMAGE_WIDTH 320
#define IMAGE_HEIGHT 240
int frames;
void InitMyGl(void);
unsigned char *GetFBMemPtr(void);
void MyGlDraw(void);
#endif
