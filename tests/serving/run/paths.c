/* Ways to the device's places: detours, links, folders, descriptors, streams; one line of output each. */
#define _GNU_SOURCE
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/fb.h>
#include <linux/openat2.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/sysmacros.h>
#include <unistd.h>

static int is_fb(int fd)
{
    struct fb_var_screeninfo v;
    int answer = fd >= 0 && ioctl(fd, FBIOGET_VSCREENINFO, &v) == 0;
    if (fd > 2)
        close(fd);
    return answer;
}

static void way(const char *name, int fd) { printf("%s: %s\n", name, is_fb(fd) ? "the device" : strerror(errno)); }

static void numbers(const char *path)
{
    struct stat s = {0};
    struct statx x = {0};
    int result = stat(path, &s), other = statx(AT_FDCWD, path, 0, STATX_ALL, &x);
    printf("%s: %d %o %u:%u, statx %d %u:%u\n", path, result, s.st_mode & S_IFMT, major(s.st_rdev), minor(s.st_rdev),
           other, x.stx_rdev_major, x.stx_rdev_minor);
}

static void opened(const char *folder)
{
    way("//dev/fb0", open("//dev/fb0", O_RDWR));
    way("/dev/../dev/./fb0", open("/dev/../dev/./fb0", O_RDWR));
    way("/dev/fb/0", open("/dev/fb/0", O_RDWR));
    int dev = open("/dev", O_RDONLY | O_DIRECTORY);
    way("openat", openat(dev, "fb0", O_RDWR));
    way("openat upwards", openat(dev, "../dev/fb0", O_RDWR));
    way("faccessat", faccessat(dev, "fb0", R_OK, 0) ? -1 : open("/dev/fb0", O_RDWR));
    close(dev);
    chdir("/dev");
    way("from /dev", open("fb0", O_RDWR));
    way("from /dev, ./", open("./fb0", O_RDWR));
    chdir("/");
    way("from /", open("dev/fb0", O_RDWR));
    chdir(folder);
    way("another fb0", open("fb0", O_RDWR));
    symlink("/dev/fb0", "link");
    symlink("link", "second");
    symlink("/dev", "devices");
    way("a link", open("link", O_RDWR));
    way("a link to a link", open("second", O_RDWR));
    way("a link to /dev", open("devices/fb0", O_RDWR));
    way("a link, not followed", open("link", O_RDWR | O_NOFOLLOW));
    int fd = open("/dev/fb0", O_RDWR);
    char path[64];
    sprintf(path, "/proc/self/fd/%d", fd);
    way("/proc/self/fd", open(path, O_RDWR | O_TRUNC | O_APPEND));
    sprintf(path, "/dev/fd/%d", fd);
    way("/dev/fd", open(path, O_RDWR));
    struct stat s;
    int status = stat(path, &s);
    printf("stat of /dev/fd: %d %d\n", status, S_ISCHR(s.st_mode));
    dup2(fd, 0);
    way("/dev/stdin", open("/dev/stdin", O_RDWR));
    char real[4096];
    printf("realpath: %s\n", realpath("devices/fb0", real));
    printf("realpath: %s\n", realpath("second", real));
    int result = lstat("link", &s);
    printf("lstat of a link: %d %d\n", result, S_ISLNK(s.st_mode));
    close(fd);
}

static void by_number(void)
{
    way("syscall open", syscall(SYS_openat, AT_FDCWD, "//dev/fb0", O_RDWR, 0));
    struct open_how how = {.flags = O_RDWR};
    way("syscall openat2", syscall(SYS_openat2, AT_FDCWD, "/dev/fb0", &how, sizeof how));
    struct stat s;
    long result = syscall(SYS_newfstatat, AT_FDCWD, "/dev/fb0", &s, 0);
    printf("syscall fstatat: %ld %d\n", result, S_ISCHR(s.st_mode));
    int fd = open("/dev/fb0", O_RDWR);
    struct fb_fix_screeninfo f;
    ioctl(fd, FBIOGET_FSCREENINFO, &f);
    long map = syscall(SYS_mmap, NULL, f.smem_len, PROT_READ, MAP_SHARED, fd, 4096);
    printf("syscall mmap beyond: %s\n", map == -1 ? strerror(errno) : "a map");
    char *page = mmap(NULL, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    void *grown = mremap(page, 4096, 8192, MREMAP_MAYMOVE);
    printf("mremap, larger: %s\n", grown == MAP_FAILED ? strerror(errno) : "a map");
    page = mmap(NULL, 8192, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    printf("mremap, smaller: %s\n", mremap(page, 8192, 4096, 0) == MAP_FAILED ? strerror(errno) : "a map");
    page = mmap(NULL, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    printf("mremap of another: %s\n", mremap(page, 4096, 8192, MREMAP_MAYMOVE) == MAP_FAILED ? "none" : "a map");
    printf("lseek from the end: %ld\n", (long)lseek(fd, 0, SEEK_END));
    close(fd);
}

static void streams(void)
{
    const char *modes[] = {"r", "r+", "w", "a", "a+"};
    for (int i = 0; i < 5; i++) {
        char byte = 0;
        FILE *file = fopen("/dev/fb0", modes[i]);
        int put = file ? fputc('A' + i, file) : -2;
        put = put >= 0 && fflush(file) == 0 ? 1 : 0;
        int fd = open("/dev/fb0", O_RDONLY);
        printf("fopen %s: written %d, first byte %c\n", modes[i], put, pread(fd, &byte, 1, 0) == 1 && byte ? byte : '-');
        close(fd);
        if (file)
            fclose(file);
    }
    FILE *file = fopen("/dev/null", "r");
    int before = fileno(file);
    file = freopen("/dev/fb0", "r+", file);
    printf("freopen: %d, the same number: %d\n", file && fgetc(file) == 'E', file && fileno(file) == before);
    fclose(file);
    freopen("/dev/fb0", "w", stderr);
    fputs("stderr", stderr);
    fflush(stderr);
    char text[7] = "";
    int fd = open("/dev/fb0", O_RDONLY);
    read(fd, text, 6);
    printf("freopen of stderr: %s\n", text);
    printf("freopen of a folder: %d\n", freopen("/dev/input", "w", stdin) == NULL);
}

static int any(const struct dirent *entry) { return entry->d_name[0] != '.'; }

static void list(const char *path)
{
    struct dirent **names;
    int count = scandir(path, &names, any, alphasort);
    printf("%s:", path);
    for (int i = 0; i < count; i++) {
        int is_file = !strncmp(path, "/dev", 5) || !strcmp(path, "/sys/class");
        if (!is_file || !strcmp(names[i]->d_name, "fb0") || !strcmp(names[i]->d_name, "graphics"))
            printf(" %s", names[i]->d_name);
    }
    printf("\n");
}

static void folders(void)
{
    list("/sys/class/graphics/fb0");
    list("/sys/class/graphics/");
    list("/sys/class");
    list("/dev/input");
    list("/dev");
    int count = 0, again = 0;
    DIR *dir = opendir("/sys/class/graphics/fb0");
    while (readdir(dir))
        count++;
    rewinddir(dir);
    while (readdir(dir))
        again++;
    char text[32] = "";
    int fd = openat(dirfd(dir), "virtual_size", O_RDONLY);
    read(fd, text, sizeof text - 1);
    printf("entries %d %d, from the folder: %s", count, again, text);
    struct stat by_path, by_fd;
    stat("/sys/class/graphics/fb0", &by_path);
    fstat(dirfd(dir), &by_fd);
    printf("a folder: %d, the same: %d\n", S_ISDIR(by_path.st_mode), by_path.st_ino == by_fd.st_ino && by_path.st_dev == by_fd.st_dev);
    closedir(dir);
    char path[4096];
    printf("chdir: %d", chdir("/sys/class/graphics/fb0"));
    printf(" %s", getcwd(path, sizeof path));
    printf(" %d\n", access("stride", R_OK) == 0 && access("stride", W_OK) == -1 && access("pan", W_OK) == 0);
}

int main(int count, char **words)
{
    opened(words[count - 1]);
    by_number();
    streams();
    folders();
    const char *paths[] = {"/dev/fb0", "/dev/tty0", "/dev/tty1", "/dev/tty12", "/dev/console", "/dev/input/event0",
                           "/dev/input/event1", "/dev/input/mice", "/sys/class/graphics/fb0/pan"};
    for (int i = 0; i < 9; i++)
        numbers(paths[i]);
    return 0;
}
