#include "mygl.h"
#include <Math.h>
#include <Windows.h>
#include <conio.h>
#include <stdlib.h>

unsigned char *fb_ptr = NULL;

void InitMyGl(void)
{
    fb_ptr = (unsigned char *)malloc(IMAGE_WIDTH * IMAGE_HEIGHT * 4);
    for (int i = 0; i < IMAGE_WIDTH * IMAGE_HEIGHT; i++) {
        fb_ptr[4 * i] = fb_ptr[4 * i + 1] = fb_ptr[4 * i + 2] = 0;
        fb_ptr[4 * i + 3] = 255;
    }
}

unsigned char *GetFBMemPtr(void) { return fb_ptr; }

/* A diagonal from the lower left, and a row at the bottom. */
void MyGlDraw(void)
{
    frames++;
    for (int i = 0; i < 200; i++)
        fb_ptr[4 * (i * IMAGE_WIDTH + i)] = (unsigned char)sqrt(255.0 * 255.0);
    for (int x = 0; x < IMAGE_WIDTH; x++)
        fb_ptr[4 * x + 1] = 128;
    Sleep(1);
}
