/* Starts itself again and again with less and less of an environment; the last one draws on the device. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

int main(int count, char **words)
{
    const char *step = count > 1 ? words[1] : "0";
    char *none[] = {NULL}, *other[] = {"LD_PRELOAD=", "A=b", NULL}, *next[] = {words[0], (char *[]){"1", "2", "3", "4", "5", "6", "7", "8", "9"}[*step - '0'], NULL};
    switch (*step) {
    case '0':
        execve("/proc/self/exe", next, none);
        return 10;
    case '1':
        environ = none;
        execvp("/proc/self/exe", next);
        return 11;
    case '2':
        clearenv();
        execl("/proc/self/exe", words[0], "3", NULL);
        return 12;
    case '3':
        fexecve(open("/proc/self/exe", O_RDONLY), next, other);
        return 13;
    case '4': {
        pid_t pid;
        int status;
        if (posix_spawn(&pid, "/proc/self/exe", NULL, NULL, next, none) || waitpid(pid, &status, 0) != pid)
            return 14;
        return WIFEXITED(status) ? WEXITSTATUS(status) : 15;
    }
    case '5':
        execle("/proc/self/exe", words[0], "6", "more", "words", "than", "registers", "hold", "7", "8", "9", "10", NULL, none);
        return 18;
    case '6':
        if (count != 11 || strcmp(words[2], "more") || strcmp(words[10], "10"))
            return 19;
        environ = (char *[]){"PATH=/bin:/usr/bin", NULL};
        execlp("env", "env", words[0], "7", NULL);
        return 20;
    case '7': {
        char command[4200];
        unsetenv("LD_PRELOAD");
        unsetenv("FBPTR_RUN");
        snprintf(command, sizeof command, "exec '%s' 8", words[0]);
        int status = system(command);
        return WIFEXITED(status) ? WEXITSTATUS(status) : 21;
    }
    default: {
        int fd = open("/dev/fb0", O_RDWR);
        if (fd < 0 || write(fd, "\1\2\3", 3) != 3)
            return 16;
        return getenv("A") ? 17 : 0;
    }
    }
}
