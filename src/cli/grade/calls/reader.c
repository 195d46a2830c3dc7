
/* Reads figures from standard input, and calls the program's functions; by fbptr grade --calls. */
#include <stdio.h>
#include <string.h>
static int fbptr_whole(double v) { int whole = (int)(v + 0.5); return whole > v + 0.5 ? whole - 1 : whole; }
