/* Flips pages and waits for vertical blanks while a timer sends a signal every 200 microseconds. */
#include <errno.h>
#include <fcntl.h>
#include <linux/fb.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/time.h>

static volatile sig_atomic_t signals;

static void count(int number) { signals += number == SIGALRM; }

static unsigned blanks(int fd)
{
    struct fb_vblank v = {0};
    ioctl(fd, FBIOGET_VBLANK, &v);
    return v.count;
}

int main(void)
{
    struct sigaction action = {.sa_handler = count};
    struct itimerval often = {{0, 200}, {0, 200}};
    struct fb_var_screeninfo v;
    int fd = open("/dev/fb0", O_RDWR), screen = 0, failed = 0, early = 0;
    if (fd < 0 || ioctl(fd, FBIOGET_VSCREENINFO, &v))
        return 1;
    v.yres_virtual = 2 * v.yres;
    if (ioctl(fd, FBIOPUT_VSCREENINFO, &v))
        return 2;
    sigaction(SIGALRM, &action, NULL);
    setitimer(ITIMER_REAL, &often, NULL);
    /* 10 blanks a second: each wait meets hundreds of signals. */
    for (int i = 0; i < 6; i++) {
        unsigned before = blanks(fd);
        failed += ioctl(fd, FBIO_WAITFORVSYNC, &screen) != 0;
        early += blanks(fd) == before;
    }
    /* Each blank takes over one page. */
    unsigned before = blanks(fd);
    for (int i = 0; i < 6; i++) {
        v.yoffset = v.yoffset ? 0 : v.yres;
        failed += ioctl(fd, FBIOPAN_DISPLAY, &v) != 0;
    }
    early += blanks(fd) - before < 5;
    setitimer(ITIMER_REAL, &(struct itimerval){{0, 0}, {0, 0}}, NULL);
    printf("failed %d early %d, many signals: %d\n", failed, early, signals > 1000);
    return 0;
}
