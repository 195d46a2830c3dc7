/* What programs written for another system include, and the little of it that they use. */
#ifndef FBPTR_WINDOWS_H
#define FBPTR_WINDOWS_H

#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

typedef int BOOL;
typedef unsigned char BYTE;
typedef unsigned short WORD;
typedef unsigned int DWORD;
typedef unsigned int UINT;
typedef float FLOAT;

#ifndef TRUE
#define TRUE 1
#define FALSE 0
#endif

#define WINAPI
#define CALLBACK
#define APIENTRY

#define Sleep(milliseconds) usleep((milliseconds) * 1000u)
#define _stricmp strcasecmp

#endif
