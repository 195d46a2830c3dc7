/* Characters of the terminal, by the names of another system. */
#ifndef FBPTR_CONIO_H
#define FBPTR_CONIO_H

#include <stdio.h>

static inline int getch(void) { return getchar(); }
static inline int getche(void) { return getchar(); }
static inline int kbhit(void) { return 0; }

#endif
