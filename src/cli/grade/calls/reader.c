
/* Reads figures from the file that FBPTR_FIGURES names, and calls the program's functions; by fbptr grade --calls. */
#ifndef FBPTR_FIGURES_ARE_READ
#define FBPTR_FIGURES_ARE_READ
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
static int fbptr_whole(double fbptr_v) {
    int fbptr_n = (int)(fbptr_v + 0.5);
    return fbptr_n > fbptr_v + 0.5 ? fbptr_n - 1 : fbptr_n;
}
/* Notes that the first call has begun or is over. */
static void fbptr_mark(const char *fbptr_word) {
    const char *fbptr_name = getenv("FBPTR_MARKS");
    FILE *fbptr_marks = fbptr_name ? fopen(fbptr_name, "a") : 0;
    if (fbptr_marks) {
        fprintf(fbptr_marks, "%s\n", fbptr_word);
        fclose(fbptr_marks);
    }
}
