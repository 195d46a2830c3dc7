/* Flips between two pages of one colour each, without a wait but that of the flip itself. */
#include <fcntl.h>
#include <linux/fb.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>

int main(int count, char **words)
{
    int fd = open("/dev/fb0", O_RDWR), flips = count > 1 ? atoi(words[1]) : 10000;
    struct fb_var_screeninfo v;
    if (fd < 0 || ioctl(fd, FBIOGET_VSCREENINFO, &v))
        return 1;
    v.yres_virtual = 2 * v.yres;
    if (ioctl(fd, FBIOPUT_VSCREENINFO, &v))
        return 2;
    size_t page = (size_t)v.xres * v.yres * 4;
    char *fb = mmap(NULL, 2 * page, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    if (fb == MAP_FAILED)
        return 3;
    for (int i = 0; i < flips; i++) {
        v.yoffset = v.yoffset ? 0 : v.yres;
        memset(fb + (v.yoffset ? page : 0), i % 251, page);
        if (ioctl(fd, FBIOPAN_DISPLAY, &v))
            return 4;
    }
    return 0;
}
