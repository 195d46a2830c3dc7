/* The program of every tutorial about the Linux framebuffer: open, ask, map, draw. */
#include <fcntl.h>
#include <linux/fb.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

int main(void)
{
    int fbfd = open("/dev/fb0", O_RDWR);
    if (fbfd == -1) {
        perror("Error: cannot open framebuffer device");
        return 1;
    }
    struct fb_fix_screeninfo finfo;
    struct fb_var_screeninfo vinfo;
    if (ioctl(fbfd, FBIOGET_FSCREENINFO, &finfo) == -1 || ioctl(fbfd, FBIOGET_VSCREENINFO, &vinfo) == -1) {
        perror("Error reading screen information");
        return 2;
    }
    printf("%ux%u, %ubpp\n", vinfo.xres, vinfo.yres, vinfo.bits_per_pixel);
    long screensize = vinfo.xres * vinfo.yres * vinfo.bits_per_pixel / 8;
    char *fbp = mmap(0, screensize, PROT_READ | PROT_WRITE, MAP_SHARED, fbfd, 0);
    if (fbp == MAP_FAILED) {
        perror("Error: failed to map framebuffer device to memory");
        return 3;
    }
    for (unsigned y = 10; y < 30; y++)
        for (unsigned x = 10; x < 40; x++) {
            long location = (x + vinfo.xoffset) * (vinfo.bits_per_pixel / 8) + (y + vinfo.yoffset) * finfo.line_length;
            *(fbp + location) = 100;                  /* some blue */
            *(fbp + location + 1) = 15 + x;           /* a little green */
            *(fbp + location + 2) = 200 - y;          /* a lot of red */
            *(fbp + location + 3) = 0;                /* no transparency */
        }
    munmap(fbp, screensize);
    close(fbfd);
    return 7;
}
