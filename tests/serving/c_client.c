/* Draws by verbs and by the memory, and prints what comes back. Compiled as C99 and as C++11, with all warnings. */
#include "fbptr.h"

int main(int argc, char **argv)
{
    fbptr fb;
    char text[256];
    unsigned char rgba[4 * 6];
    long bytes;
    if (argc < 3 || fbptr_map(&fb, argv[1]) != 0 || fbptr_connect(&fb, argv[2]) != 0)
        return 1;
    printf("%dx%d stride %d\n", fb.width, fb.height, fb.stride);
    fbptr_clear(&fb, "102030");
    fbptr_line(&fb, 0, 0, 2, 0, "red", NULL);
    fbptr_fillcircle(&fb, 20, 10, 2.5, "lime");
    fbptr_px(&fb, 1, 1, "01020304");
    fbptr_blit(&fb, 3, 1, 1, 1, "\x09\x08\x07\xff", 4);
    fbptr_print(&fb, 30, 10, "white", "a b");
    bytes = fbptr_read(&fb, 0, 0, 3, 2, rgba, sizeof rgba);
    printf("%ld bytes, %d %d %d, %d\n", bytes, rgba[0], rgba[1], rgba[2], rgba[4 * 4 + 2]);
    /* What the server has drawn is in the memory before its reply. */
    printf("FBptr %d %d %d\n", fb.FBptr[0], fb.FBptr[4 * (10 * fb.width + 20) + 1], fb.FBptr[fb.stride + 12]);
    printf("%d ", fbptr_peek(&fb, 0, 4, text, sizeof text));
    printf("%s\n", text);
    /* What is written here is the server's with the doorbell. */
    fb.FBptr[fb.stride * 5 + 4 * 7] = 200;
    fbptr_present(&fb);
    do
        fbptr_peek(&fb, fb.stride * 5 + 4 * 7, 1, text, sizeof text);
    while (strstr(text, " c8") == NULL);
    /* A refused command is counted, and the queries behind it have their own answers. */
    fbptr_canvas(&fb, "c", 0, 5);
    printf("%d ", fbptr_crc(&fb, NULL, text, sizeof text));
    printf("%.4s %d\n", text, fb.refused);
    printf("%d ", fbptr_crc(&fb, "1 2", text, sizeof text));
    printf("%d\n", fb.refused);
    printf("%d ", fbptr_next_event(&fb, text, sizeof text, 0) == 1);
    fbptr_close(&fb);
    printf("%d\n", fb.FBptr == NULL);
    return 0;
}
