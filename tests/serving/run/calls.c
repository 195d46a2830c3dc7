/* Calls of the framebuffer device, one line of output each: what the kernel's device answers. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <linux/fb.h>
#include <linux/kd.h>
#include <linux/vt.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

static const char *name(int error)
{
    switch (error) {
    case 0: return "ok";
    case EINVAL: return "EINVAL";
    case ENOSPC: return "ENOSPC";
    case EFBIG: return "EFBIG";
    case ENOMEM: return "ENOMEM";
    case EACCES: return "EACCES";
    case EFAULT: return "EFAULT";
    case ENOTTY: return "ENOTTY";
    case ENODEV: return "ENODEV";
    default: return strerror(error);
    }
}

static void say(const char *what, long result)
{
    printf("%s: %s\n", what, name(result == -1 ? errno : 0));
    fflush(stdout);
}

static void line_of(const char *path)
{
    char text[80] = "";
    FILE *file = fopen(path, "r");
    if (!file || !fgets(text, sizeof text, file))
        strcpy(text, "nothing\n");
    printf("%s: %s", path, text);
    if (file)
        fclose(file);
}

static void modes(int fd)
{
    struct fb_var_screeninfo v;
    struct fb_fix_screeninfo f;
    ioctl(fd, FBIOGET_VSCREENINFO, &v);
    v.bits_per_pixel = 16;
    v.activate = FB_ACTIVATE_TEST;
    say("test", ioctl(fd, FBIOPUT_VSCREENINFO, &v));
    ioctl(fd, FBIOGET_VSCREENINFO, &v);
    printf("still %u bits\n", v.bits_per_pixel);
    v.bits_per_pixel = 16;
    say("set", ioctl(fd, FBIOPUT_VSCREENINFO, &v));
    ioctl(fd, FBIOGET_FSCREENINFO, &f);
    printf("16 bits: red %u+%u green %u+%u blue %u+%u line %u\n", v.red.offset, v.red.length, v.green.offset,
           v.green.length, v.blue.offset, v.blue.length, f.line_length);
    v.xres++;
    say("too wide", ioctl(fd, FBIOPUT_VSCREENINFO, &v));
    v.xres--;
    v.yres_virtual = 100000;
    say("too high", ioctl(fd, FBIOPUT_VSCREENINFO, &v));
    v.bits_per_pixel = 32;
    v.yres_virtual = v.yres * 3;
    say("three screens", ioctl(fd, FBIOPUT_VSCREENINFO, &v));
    v.yoffset = 2 * v.yres;
    say("pan", ioctl(fd, FBIOPAN_DISPLAY, &v));
    v.yoffset++;
    say("pan too far", ioctl(fd, FBIOPAN_DISPLAY, &v));
    ioctl(fd, FBIOGET_VSCREENINFO, &v);
    printf("yoffset %u\n", v.yoffset);
    v.yoffset = 0;
    say("pan back", ioctl(fd, FBIOPAN_DISPLAY, &v));
}

static void palettes(int fd)
{
    unsigned short red[256], green[256], blue[256];
    struct fb_cmap map = {10, 2, red, green, blue, NULL};
    red[0] = 0x1234;
    red[1] = green[0] = green[1] = blue[0] = blue[1] = 0xffff;
    say("put palette", ioctl(fd, FBIOPUTCMAP, &map));
    memset(red, 0, sizeof red);
    say("get palette", ioctl(fd, FBIOGETCMAP, &map));
    printf("entry 10 is %x, 11 is %x\n", red[0], red[1]);
    map.start = 256;
    say("get beyond", ioctl(fd, FBIOGETCMAP, &map));
}

static void ends(int fd, unsigned len)
{
    char bytes[100] = {0};
    lseek(fd, len - 10, SEEK_SET);
    printf("write at the end: %zd\n", write(fd, bytes, 100));
    say("write behind it", write(fd, bytes, 1));
    printf("read behind it: %zd\n", read(fd, bytes, 1));
    say("pwrite far behind", pwrite(fd, bytes, 1, len + 1L));
    say("truncate", ftruncate(fd, 10));
    void *map = mmap(NULL, len, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    say("map all", (long)map);
    say("map more", (long)mmap(NULL, len + 1, PROT_READ, MAP_SHARED, fd, 4096));
    map = mremap(map, len, 8192, 0);
    say("remap", (long)map);
    memset(map, 1, 8192);
    say("unmap", munmap(map, 8192));
    say("pread", pread(fd, bytes, 1, 8191));
    printf("byte %d\n", bytes[0]);
    struct pollfd ready = {fd, POLLIN | POLLOUT, 0};
    printf("poll: %d\n", poll(&ready, 1, 0));
}

static void console(void)
{
    int tty = open("/dev/tty0", O_RDWR), mode = -1;
    struct vt_stat state;
    say("tty0", tty);
    say("KDSETMODE", ioctl(tty, KDSETMODE, KD_GRAPHICS));
    say("KDGETMODE", ioctl(tty, KDGETMODE, &mode));
    printf("mode %d, a terminal: %d\n", mode, isatty(tty));
    say("VT_GETSTATE", ioctl(tty, VT_GETSTATE, &state));
    printf("terminal %d\n", state.v_active);
    say("VT_WAITACTIVE", ioctl(tty, VT_WAITACTIVE, 1));
    say("unknown", ioctl(tty, 0x4bff, &mode));
    say("KDSETMODE of a file", ioctl(open("/dev/null", O_RDWR), KDSETMODE, KD_TEXT));
    int own = open("/dev/tty", O_RDWR);
    say("tty", own);
    say("KDGETMODE of tty", ioctl(own, KDGETMODE, &mode));
}

int main(int count, char **words)
{
    struct fb_var_screeninfo v;
    struct fb_fix_screeninfo f;
    struct stat s;
    if (count > 1) {
        /* Another program, with the descriptor of the first. */
        int fd = words[1][0] - '0';
        say("after exec", ioctl(fd, FBIOGET_VSCREENINFO, &v));
        return 0;
    }
    int fd = open("/dev/fb0", O_RDWR | O_CREAT | O_TRUNC, 0600);
    say("open", fd);
    say("open with O_EXCL", open("/dev/fb0", O_RDWR | O_CREAT | O_EXCL, 0600));
    ioctl(fd, FBIOGET_FSCREENINFO, &f);
    printf("%s: type %u visual %u length %u\n", f.id, f.type, f.visual, f.smem_len);
    fstat(fd, &s);
    printf("character device: %d %u:%u\n", S_ISCHR(s.st_mode), major(s.st_rdev), minor(s.st_rdev));
    say("stat", stat("/dev/fb0", &s));
    say("access", access("/dev/fb0", R_OK | W_OK));
    say("access to run", access("/dev/fb0", X_OK));
    printf("a terminal: %d\n", isatty(fd));
    say("vendor's request", ioctl(fd, 0x46ff, &v));
    say("vendor's request without an argument", ioctl(fd, 0x46ff, NULL));
    say("null", ioctl(fd, FBIOGET_VSCREENINFO, NULL));
    modes(fd);
    palettes(fd);
    ends(fd, f.smem_len);
    unsigned crtc = 0;
    struct fb_vblank before, after;
    ioctl(fd, FBIOGET_VBLANK, &before);
    say("wait", ioctl(fd, FBIO_WAITFORVSYNC, &crtc));
    ioctl(fd, FBIOGET_VBLANK, &after);
    printf("a blank later: %d\n", after.count != before.count);
    say("blank", ioctl(fd, FBIOBLANK, FB_BLANK_POWERDOWN));
    say("unblank", ioctl(fd, FBIOBLANK, FB_BLANK_UNBLANK));
    line_of("/sys/class/graphics/fb0/virtual_size");
    line_of("/sys/class/graphics/fb0/bits_per_pixel");
    line_of("/proc/fb");
    console();
    say("dup", ioctl(fcntl(dup(fd), F_DUPFD, 9), FBIOGET_VSCREENINFO, &v));
    say("openat", openat(AT_FDCWD, "/dev/fb0", O_RDONLY));
    say("by number", syscall(SYS_openat, AT_FDCWD, "/dev/fb0", O_RDONLY));
    say("another device", open("/dev/fb1", O_RDWR) == -1 ? 0 : -1);
    if (fork() == 0) {
        say("in a child", ioctl(fd, FBIOGET_VSCREENINFO, &v));
        char number[2] = {'0' + fd, 0};
        execl("/proc/self/exe", "calls", number, NULL);
    }
    wait(NULL);
    return 0;
}
