/* Draws a pixel, and then writes behind the end of the map. */
#include <fcntl.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/ioctl.h>
#include <linux/fb.h>

int main(void)
{
    int fd = open("/dev/fb0", O_RDWR);
    struct fb_fix_screeninfo f;
    if (fd < 0 || ioctl(fd, FBIOGET_FSCREENINFO, &f))
        return 1;
    char *fb = mmap(NULL, 2 * f.smem_len, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    fb = mmap(fb, f.smem_len, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_FIXED, fd, 0);
    if (fb == MAP_FAILED)
        return 2;
    memset(fb, 77, 4);
    for (volatile char *at = fb;; at += 4096)
        *at = 77;
}
