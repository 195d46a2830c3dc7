/* The numbers and names of the console's devices, by path and by descriptor. Made for this project. */
#include <stdio.h>
#include <fcntl.h>
#include <unistd.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
int main(){const char*p[]={"/dev/tty","/dev/tty0","/dev/tty1","/dev/console"};for(int i=0;i<4;i++){int f=open(p[i],O_RDWR);struct stat s,t;fstat(f,&s);stat(p[i],&t);printf("%s: open %d fstat %d:%d stat %d:%d ttyname %s\n",p[i],f,major(s.st_rdev),minor(s.st_rdev),major(t.st_rdev),minor(t.st_rdev),ttyname(f));}}
