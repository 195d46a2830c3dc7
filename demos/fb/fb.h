/* The framebuffer device for the demos beside this file: opening it in a mode, its memory, its palette, its pages. */
#include <fcntl.h>
#include <linux/fb.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

static int fb_fd;
static int fb_w, fb_h, fb_line;     /* pixels, pixels, bytes */
static uint8_t *fb;                 /* the first page */
static struct fb_var_screeninfo fb_var;

/* Opens the device with so many bits a pixel (8, 16 or 32) and pages. */
static void fb_open(int bits, int pages)
{
    struct fb_fix_screeninfo fix;
    fb_fd = open("/dev/fb0", O_RDWR);
    if (fb_fd < 0 || ioctl(fb_fd, FBIOGET_VSCREENINFO, &fb_var)) {
        perror("/dev/fb0");
        exit(1);
    }
    fb_var.bits_per_pixel = bits;
    fb_var.yres_virtual = fb_var.yres * pages;
    if (ioctl(fb_fd, FBIOPUT_VSCREENINFO, &fb_var) || ioctl(fb_fd, FBIOGET_FSCREENINFO, &fix)) {
        perror("mode");
        exit(1);
    }
    fb_w = fb_var.xres, fb_h = fb_var.yres, fb_line = fix.line_length;
    fb = mmap(NULL, (size_t)fb_line * fb_h * pages, PROT_READ | PROT_WRITE, MAP_SHARED, fb_fd, 0);
    if (fb == MAP_FAILED) {
        perror("mmap");
        exit(1);
    }
}

/* Sets a palette entry, 8 bits a channel. */
static inline void fb_color(uint16_t index, int r, int g, int b)
{
    uint16_t red = r * 257, green = g * 257, blue = b * 257;
    struct fb_cmap map = {index, 1, &red, &green, &blue, NULL};
    ioctl(fb_fd, FBIOPUTCMAP, &map);
}

/* Waits for the next vertical blank. */
static inline void fb_wait(void)
{
    uint32_t screen = 0;
    ioctl(fb_fd, FBIO_WAITFORVSYNC, &screen);
}

/* Returns the page that is not visible; fb_flip shows it. */
static inline uint8_t *fb_back(void) { return fb + (fb_var.yoffset ? 0 : (size_t)fb_h * fb_line); }

static inline void fb_flip(void)
{
    fb_var.yoffset = fb_var.yoffset ? 0 : fb_h;
    ioctl(fb_fd, FBIOPAN_DISPLAY, &fb_var);
}

/* Returns the number of frames that the command line asks for; without one, so many that nobody waits for the end. */
static inline long frames(int count, char **words) { return count > 1 ? atol(words[1]) : 1L << 40; }
