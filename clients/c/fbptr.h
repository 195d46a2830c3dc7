/* Draw on a running fbptr server from C (C99) and C++ (C++11), in one file without dependencies, on systems of POSIX.

     fbptr serve --shm /tmp/fb &
     fbptr fb;
     fbptr_map(&fb, "/tmp/fb");                   the memory: fb.FBptr[4 * (y * fb.width + x)] is red
     fbptr_connect(&fb, "127.0.0.1:1234");        or "unix:/tmp/fb.sock"; either may be left out
     fbptr_line(&fb, 0, 0, 99, 49, "red", "gold");
     fbptr_present(&fb);
     fbptr_close(&fb);

   Each verb of the protocol is a function of its name. Colours are texts of the command language ("rrggbb", "gg", a CSS
   name); a colour that may be left out may be NULL. `rest` is the rest of the words of a form, or NULL. Functions return 0,
   or -1 if there is no connection or it has ended. Queries write their answer as a text, without its line's end, and return
   its length, or -1 if it was refused. `refused` counts the commands that the server has refused, as far as their answers
   were read, and `why` is its line about the last one. Include this file first, or define _POSIX_C_SOURCE as 200112L. */
#ifndef FBPTR_CLIENT_H
#define FBPTR_CLIENT_H

#if !defined(_POSIX_C_SOURCE) && !defined(_GNU_SOURCE) && !defined(__APPLE__)
#define _POSIX_C_SOURCE 200112L
#endif

#include <fcntl.h>
#include <netdb.h>
#include <poll.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/types.h>
#include <sys/un.h>
#include <unistd.h>

#ifndef AI_NUMERICHOST
#error "include fbptr.h before other headers, or compile with -D_POSIX_C_SOURCE=200112L, or -std=gnu99"
#endif

#define FBPTR_HEADER 4096   /* bytes of the shared file before the pixels */
#define FBPTR_BUFFER 65536  /* bytes of commands that are sent together */
#define FBPTR_LINE 4096     /* longest line that is read */
#define FBPTR_EVENTS 64     /* events that wait while an answer is read */
#define FBPTR_EVENT 64      /* longest event */

typedef struct fbptr {
    unsigned char *FBptr; /* R, G, B, A of each pixel, row by row from the top; NULL before fbptr_map */
    int width, height;    /* of the window, in pixels */
    int stride;           /* bytes of a row */
    unsigned char *file;
    size_t file_bytes;
    int socket;
    size_t pending, unread, read_at;
    char commands[FBPTR_BUFFER], input[FBPTR_LINE];
    char events[FBPTR_EVENTS][FBPTR_EVENT];
    int event_count;
    int refused;
    char why[256];
    int is_mapped, is_connected;
} fbptr;

/* Maps the file of `fbptr serve --shm PATH`. Call it before fbptr_connect: it begins a client anew. */
static inline int fbptr_map(fbptr *fb, const char *path)
{
    uint32_t head[8];
    void *map;
    size_t bytes;
    int fd = open(path, O_RDWR);
    memset(fb, 0, sizeof *fb);
    if (fd < 0)
        return -1;
    if (read(fd, head, sizeof head) != (ssize_t)sizeof head || memcmp(head, "FBPTRSHM", 8) != 0 || head[2] != 1 ||
        head[3] != FBPTR_HEADER || head[7] != 1) {
        close(fd);
        return -1;
    }
    bytes = FBPTR_HEADER + (size_t)head[6] * head[5];
    map = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    close(fd);
    if (map == MAP_FAILED)
        return -1;
    fb->file = (unsigned char *)map;
    fb->file_bytes = bytes;
    fb->FBptr = fb->file + FBPTR_HEADER;
    fb->width = (int)head[4];
    fb->height = (int)head[5];
    fb->stride = (int)head[6];
    fb->is_mapped = 1;
    return 0;
}

/* Sends what waits to be sent. */
static inline int fbptr_flush(fbptr *fb)
{
    size_t at = 0;
    while (fb->is_connected && at < fb->pending) {
        ssize_t sent = send(fb->socket, fb->commands + at, fb->pending - at, MSG_NOSIGNAL);
        if (sent <= 0) {
            fb->is_connected = 0;
            break;
        }
        at += (size_t)sent;
    }
    fb->pending = 0;
    return fb->is_connected ? 0 : -1;
}

/* Adds bytes to the commands that wait to be sent. */
static inline int fbptr_put(fbptr *fb, const void *bytes, size_t count)
{
    const char *from = (const char *)bytes;
    while (fb->is_connected && count > 0) {
        size_t room = FBPTR_BUFFER - fb->pending, part = count < room ? count : room;
        memcpy(fb->commands + fb->pending, from, part);
        fb->pending += part;
        from += part;
        count -= part;
        if (fb->pending == FBPTR_BUFFER)
            fbptr_flush(fb);
    }
    return fb->is_connected ? 0 : -1;
}

static inline void fbptr_put_word(fbptr *fb, const char *word)
{
    if (word != NULL) {
        fbptr_put(fb, " ", 1);
        fbptr_put(fb, word, strlen(word));
    }
}

static inline void fbptr_put_int(fbptr *fb, int number)
{
    char text[16];
    snprintf(text, sizeof text, "%d", number);
    fbptr_put_word(fb, text);
}

/* A number that reads back as the same one, with a point whatever the locale is. */
static inline void fbptr_put_real(fbptr *fb, double number)
{
    char text[40], *comma;
    snprintf(text, sizeof text, "%.17g", number);
    comma = strchr(text, ',');
    if (comma != NULL)
        *comma = '.';
    fbptr_put_word(fb, text);
}

/* Ends a command, with the bytes that follow its line. */
static inline int fbptr_end(fbptr *fb, const void *payload, size_t bytes)
{
    if (payload != NULL) {
        char text[32];
        snprintf(text, sizeof text, " :%lu", (unsigned long)bytes);
        fbptr_put(fb, text, strlen(text));
    }
    fbptr_put(fb, "\n", 1);
    return payload != NULL ? fbptr_put(fb, payload, bytes) : fbptr_put(fb, "", 0);
}

/* Sends a line of the command language with the bytes that follow it, or NULL. */
static inline int fbptr_command(fbptr *fb, const char *line, const void *payload, size_t bytes)
{
    fbptr_put(fb, line, strlen(line));
    return fbptr_end(fb, payload, bytes);
}

/* Reads a byte; -1 at the connection's end. */
static inline int fbptr_byte(fbptr *fb)
{
    if (fb->read_at == fb->unread) {
        ssize_t count = fb->is_connected ? recv(fb->socket, fb->input, FBPTR_LINE, 0) : 0;
        if (count <= 0) {
            fb->is_connected = 0;
            return -1;
        }
        fb->read_at = 0;
        fb->unread = (size_t)count;
    }
    return (unsigned char)fb->input[fb->read_at++];
}

/* Reads a line, cut to the room for it. Returns its length, or -1. */
static inline int fbptr_read_line(fbptr *fb, char *line, size_t room)
{
    size_t len = 0;
    int byte;
    while ((byte = fbptr_byte(fb)) >= 0 && byte != '\n')
        if (len + 1 < room)
            line[len++] = (char)byte;
    if (room > 0)
        line[len] = 0;
    return byte < 0 ? -1 : (int)len;
}

/* Keeps an event or a line about a refused command. Returns whether the line is one of these. */
static inline int fbptr_keep(fbptr *fb, const char *line)
{
    int is_event = strncmp(line, "EVENT ", 6) == 0, is_error = strncmp(line, "ERR ", 4) == 0;
    if (is_event && fb->event_count < FBPTR_EVENTS)
        snprintf(fb->events[fb->event_count++], FBPTR_EVENT, "%.63s", line + 6);
    if (is_error) {
        fb->refused++;
        snprintf(fb->why, sizeof fb->why, "%.255s", line);
    }
    return is_event || is_error;
}

/* Reads the answer to the query of this verb, which was sent last. */
static inline int fbptr_answer(fbptr *fb, const char *verb, char *reply, size_t room)
{
    char line[FBPTR_LINE], about[40];
    snprintf(about, sizeof about, " %.32s:", verb);
    if (fbptr_flush(fb) < 0)
        return -1;
    for (;;) {
        int len = fbptr_read_line(fb, line, sizeof line);
        if (len < 0)
            return -1;
        if (!fbptr_keep(fb, line)) {
            snprintf(reply, room, "%s", line);
            return len;
        }
        /* The query itself was refused: ERR line byte CODE VERB: message. */
        if (line[0] == 'E' && line[1] == 'R' && strstr(line, about) != NULL)
            return -1;
    }
}

/* Reads the bytes that follow an answer `... :N`. Returns their number, of which at most `room` are kept. */
static inline long fbptr_answer_bytes(fbptr *fb, const char *verb, void *bytes, size_t room)
{
    char line[FBPTR_LINE], *colon;
    long count, i;
    if (fbptr_answer(fb, verb, line, sizeof line) < 0 || (colon = strrchr(line, ':')) == NULL)
        return -1;
    count = strtol(colon + 1, NULL, 10);
    for (i = 0; i < count; i++) {
        int byte = fbptr_byte(fb);
        if (byte < 0)
            return -1;
        if ((size_t)i < room)
            ((unsigned char *)bytes)[i] = (unsigned char)byte;
    }
    return count;
}

/* Connects to a server: "HOST:PORT", or "unix:PATH". A client without a map begins here: set it to {0} before. */
static inline int fbptr_connect(fbptr *fb, const char *address)
{
    char size[64];
    if (!fb->is_mapped)
        memset(fb, 0, sizeof *fb);
    fb->socket = -1;
    if (strncmp(address, "unix:", 5) == 0) {
        struct sockaddr_un place;
        memset(&place, 0, sizeof place);
        place.sun_family = AF_UNIX;
        if (strlen(address + 5) >= sizeof place.sun_path)
            return -1;
        strcpy(place.sun_path, address + 5);
        fb->socket = socket(AF_UNIX, SOCK_STREAM, 0);
        if (fb->socket < 0)
            return -1;
        if (connect(fb->socket, (struct sockaddr *)&place, sizeof place) != 0) {
            close(fb->socket);
            return -1;
        }
    } else {
        struct addrinfo hints, *found = NULL;
        char host[256];
        const char *port = strrchr(address, ':');
        if (port == NULL || (size_t)(port - address) >= sizeof host)
            return -1;
        memcpy(host, address, (size_t)(port - address));
        host[port - address] = 0;
        memset(&hints, 0, sizeof hints);
        hints.ai_socktype = SOCK_STREAM;
        if (getaddrinfo(host[0] ? host : "127.0.0.1", port + 1, &hints, &found) != 0)
            return -1;
        fb->socket = socket(found->ai_family, found->ai_socktype, found->ai_protocol);
        if (fb->socket < 0 || connect(fb->socket, found->ai_addr, found->ai_addrlen) != 0) {
            freeaddrinfo(found);
            if (fb->socket >= 0)
                close(fb->socket);
            return -1;
        }
        freeaddrinfo(found);
    }
    fb->is_connected = 1;
    fbptr_command(fb, "ERRORS report", NULL, 0);
    fbptr_command(fb, "SIZE", NULL, 0);
    if (fbptr_answer(fb, "SIZE", size, sizeof size) < 0 || sscanf(size, "SIZE %d %d", &fb->width, &fb->height) != 2)
        return -1;
    if (!fb->is_mapped)
        fb->stride = fb->width * 4;
    return 0;
}

/* Shows what was written to the memory, and sends what waits to be sent. */
static inline void fbptr_present(fbptr *fb)
{
    if (fb->is_mapped)
        __atomic_fetch_add((uint64_t *)(void *)(fb->file + 40), 1, __ATOMIC_RELEASE);
    if (fb->is_connected)
        fbptr_flush(fb);
}

/* PX x y colour: sets a pixel; the memory itself is faster where there is one. */
static inline int fbptr_px(fbptr *fb, int x, int y, const char *colour)
{
    fbptr_put(fb, "PX", 2);
    fbptr_put_int(fb, x);
    fbptr_put_int(fb, y);
    fbptr_put_word(fb, colour);
    return fbptr_end(fb, NULL, 0);
}

/* Asks the server for events of its window: keys, the mouse. */
static inline int fbptr_listen(fbptr *fb)
{
    fbptr_command(fb, "EVENTS on", NULL, 0);
    return fbptr_flush(fb);
}

/* Reads the next event, as in "key down a" and "mouse 10 20 1", within so many milliseconds; -1 waits for one. Returns 1,
   0 if there is none, or -1 at the connection's end. */
static inline int fbptr_next_event(fbptr *fb, char *event, size_t room, int milliseconds)
{
    char line[FBPTR_LINE];
    for (;;) {
        struct pollfd ready;
        if (fb->event_count > 0) {
            snprintf(event, room, "%s", fb->events[0]);
            memmove(fb->events[0], fb->events[1], (size_t)--fb->event_count * FBPTR_EVENT);
            return 1;
        }
        ready.fd = fb->socket;
        ready.events = POLLIN;
        if (!fb->is_connected)
            return -1;
        if (fb->read_at == fb->unread && poll(&ready, 1, milliseconds) <= 0)
            return 0;
        if (fbptr_read_line(fb, line, sizeof line) < 0)
            return -1;
        fbptr_keep(fb, line);
    }
}

/* Ends the map and the connection. */
static inline void fbptr_close(fbptr *fb)
{
    if (fb->is_connected)
        fbptr_flush(fb);
    if (fb->is_connected)
        close(fb->socket);
    if (fb->is_mapped)
        munmap(fb->file, fb->file_bytes);
    memset(fb, 0, sizeof *fb);
}

/* Made from the verb table: BLESS=1 cargo test --test decoder c_client */

/* OFFSET x y: moves all later text PX of this connection; replaces the last */
static inline int fbptr_offset(fbptr *fb, int x, int y)
{
    fbptr_put(fb, "OFFSET", 6);
    fbptr_put_int(fb, x);
    fbptr_put_int(fb, y);
    return fbptr_end(fb, NULL, 0);
}

/* STATS: answers one line of key=value */
static inline int fbptr_stats(fbptr *fb, char *reply, size_t room)
{
    fbptr_put(fb, "STATS", 5);
    fbptr_end(fb, NULL, 0);
    return fbptr_answer(fb, "STATS", reply, room);
}

/* QUIT: ends the connection */
static inline int fbptr_quit(fbptr *fb)
{
    fbptr_put(fb, "QUIT", 4);
    return fbptr_end(fb, NULL, 0);
}

/* POKE offset hexbytes: writes bytes; offset = (width*y + x)*4, bytes R G B A */
static inline int fbptr_poke(fbptr *fb, int offset, const char *hexbytes)
{
    fbptr_put(fb, "POKE", 4);
    fbptr_put_int(fb, offset);
    fbptr_put_word(fb, hexbytes);
    return fbptr_end(fb, NULL, 0);
}

/* PEEK offset n: answers PEEK offset hexbytes */
static inline int fbptr_peek(fbptr *fb, int offset, int n, char *reply, size_t room)
{
    fbptr_put(fb, "PEEK", 4);
    fbptr_put_int(fb, offset);
    fbptr_put_int(fb, n);
    fbptr_end(fb, NULL, 0);
    return fbptr_answer(fb, "PEEK", reply, room);
}

/* BLIT x y w h :N: draws a rectangle of RGBA rows, N = w*h*4 bytes */
static inline int fbptr_blit(fbptr *fb, int x, int y, int w, int h, const void *rgba, size_t bytes)
{
    fbptr_put(fb, "BLIT", 4);
    fbptr_put_int(fb, x);
    fbptr_put_int(fb, y);
    fbptr_put_int(fb, w);
    fbptr_put_int(fb, h);
    return fbptr_end(fb, rgba, bytes);
}

/* READ x y w h: answers READ x y w h :N and the RGBA rows */
static inline long fbptr_read(fbptr *fb, int x, int y, int w, int h, void *to, size_t room)
{
    fbptr_put(fb, "READ", 4);
    fbptr_put_int(fb, x);
    fbptr_put_int(fb, y);
    fbptr_put_int(fb, w);
    fbptr_put_int(fb, h);
    fbptr_end(fb, NULL, 0);
    return fbptr_answer_bytes(fb, "READ", to, room);
}

/* COPY sx sy w h dx dy: copies a rectangle, as through a temporary copy */
static inline int fbptr_copy(fbptr *fb, int sx, int sy, int w, int h, int dx, int dy)
{
    fbptr_put(fb, "COPY", 4);
    fbptr_put_int(fb, sx);
    fbptr_put_int(fb, sy);
    fbptr_put_int(fb, w);
    fbptr_put_int(fb, h);
    fbptr_put_int(fb, dx);
    fbptr_put_int(fb, dy);
    return fbptr_end(fb, NULL, 0);
}

/* POINTS :N: draws packed pixels, 8 bytes each: x and y as u16 little-endian, r, g, b, a */
static inline int fbptr_points(fbptr *fb, const void *packed, size_t bytes)
{
    fbptr_put(fb, "POINTS", 6);
    return fbptr_end(fb, packed, bytes);
}

/* CRC [x y w h]: answers CRC xxxxxxxx, the CRC-32 of the RGBA bytes */
static inline int fbptr_crc(fbptr *fb, const char *rest, char *reply, size_t room)
{
    fbptr_put(fb, "CRC", 3);
    fbptr_put_word(fb, rest);
    fbptr_end(fb, NULL, 0);
    return fbptr_answer(fb, "CRC", reply, room);
}

/* CLEAR [colour]: fills the frame (default 000000ff) and clears the depth */
static inline int fbptr_clear(fbptr *fb, const char *colour)
{
    fbptr_put(fb, "CLEAR", 5);
    fbptr_put_word(fb, colour);
    return fbptr_end(fb, NULL, 0);
}

/* LINE x0 y0 x1 y1 c0 [c1]: draws a line, both ends lit; with c1 the colour runs from c0 to c1 */
static inline int fbptr_line(fbptr *fb, int x0, int y0, int x1, int y1, const char *c0, const char *c1)
{
    fbptr_put(fb, "LINE", 4);
    fbptr_put_int(fb, x0);
    fbptr_put_int(fb, y0);
    fbptr_put_int(fb, x1);
    fbptr_put_int(fb, y1);
    fbptr_put_word(fb, c0);
    fbptr_put_word(fb, c1);
    return fbptr_end(fb, NULL, 0);
}

/* TRI x0 y0 x1 y1 x2 y2 c0 [c1 c2]: draws a triangle's three lines */
static inline int fbptr_tri(fbptr *fb, int x0, int y0, int x1, int y1, int x2, int y2, const char *c0, const char *c1, const char *c2)
{
    fbptr_put(fb, "TRI", 3);
    fbptr_put_int(fb, x0);
    fbptr_put_int(fb, y0);
    fbptr_put_int(fb, x1);
    fbptr_put_int(fb, y1);
    fbptr_put_int(fb, x2);
    fbptr_put_int(fb, y2);
    fbptr_put_word(fb, c0);
    fbptr_put_word(fb, c1);
    fbptr_put_word(fb, c2);
    return fbptr_end(fb, NULL, 0);
}

/* FILL x0 y0 x1 y1 x2 y2 c0 [c1 c2]: fills a triangle, colours interpolated; reals */
static inline int fbptr_fill(fbptr *fb, double x0, double y0, double x1, double y1, double x2, double y2, const char *c0, const char *c1, const char *c2)
{
    fbptr_put(fb, "FILL", 4);
    fbptr_put_real(fb, x0);
    fbptr_put_real(fb, y0);
    fbptr_put_real(fb, x1);
    fbptr_put_real(fb, y1);
    fbptr_put_real(fb, x2);
    fbptr_put_real(fb, y2);
    fbptr_put_word(fb, c0);
    fbptr_put_word(fb, c1);
    fbptr_put_word(fb, c2);
    return fbptr_end(fb, NULL, 0);
}

/* RECT x y w h c: draws the border of a rectangle */
static inline int fbptr_rect(fbptr *fb, int x, int y, int w, int h, const char *c)
{
    fbptr_put(fb, "RECT", 4);
    fbptr_put_int(fb, x);
    fbptr_put_int(fb, y);
    fbptr_put_int(fb, w);
    fbptr_put_int(fb, h);
    fbptr_put_word(fb, c);
    return fbptr_end(fb, NULL, 0);
}

/* FILLRECT x y w h c: fills the pixels with centres in [x,x+w) x [y,y+h); reals */
static inline int fbptr_fillrect(fbptr *fb, double x, double y, double w, double h, const char *c)
{
    fbptr_put(fb, "FILLRECT", 8);
    fbptr_put_real(fb, x);
    fbptr_put_real(fb, y);
    fbptr_put_real(fb, w);
    fbptr_put_real(fb, h);
    fbptr_put_word(fb, c);
    return fbptr_end(fb, NULL, 0);
}

/* CIRCLE cx cy r c: draws a circle about a pixel */
static inline int fbptr_circle(fbptr *fb, int cx, int cy, int r, const char *c)
{
    fbptr_put(fb, "CIRCLE", 6);
    fbptr_put_int(fb, cx);
    fbptr_put_int(fb, cy);
    fbptr_put_int(fb, r);
    fbptr_put_word(fb, c);
    return fbptr_end(fb, NULL, 0);
}

/* FILLCIRCLE cx cy r c: fills the pixel centres nearer than r to a point; reals */
static inline int fbptr_fillcircle(fbptr *fb, double cx, double cy, double r, const char *c)
{
    fbptr_put(fb, "FILLCIRCLE", 10);
    fbptr_put_real(fb, cx);
    fbptr_put_real(fb, cy);
    fbptr_put_real(fb, r);
    fbptr_put_word(fb, c);
    return fbptr_end(fb, NULL, 0);
}

/* POLY c x0 y0 [x1 y1 ...]: draws a closed outline */
static inline int fbptr_poly(fbptr *fb, const char *c, const char *rest)
{
    fbptr_put(fb, "POLY", 4);
    fbptr_put_word(fb, c);
    fbptr_put_word(fb, rest);
    return fbptr_end(fb, NULL, 0);
}

/* FILLPOLY c x0 y0 [x1 y1 ...]: fills a polygon, even-odd; reals */
static inline int fbptr_fillpoly(fbptr *fb, const char *c, const char *rest)
{
    fbptr_put(fb, "FILLPOLY", 8);
    fbptr_put_word(fb, c);
    fbptr_put_word(fb, rest);
    return fbptr_end(fb, NULL, 0);
}

/* TEXT x y c :N: writes N bytes of UTF-8 in 8x8 letters from the upper left corner (x,y) */
static inline int fbptr_text(fbptr *fb, int x, int y, const char *c, const void *utf8, size_t bytes)
{
    fbptr_put(fb, "TEXT", 4);
    fbptr_put_int(fb, x);
    fbptr_put_int(fb, y);
    fbptr_put_word(fb, c);
    return fbptr_end(fb, utf8, bytes);
}

/* PRINT x y c text ...: writes the rest of the line as TEXT does; no :N is read in it */
static inline int fbptr_print(fbptr *fb, int x, int y, const char *c, const char *text)
{
    fbptr_put(fb, "PRINT", 5);
    fbptr_put_int(fb, x);
    fbptr_put_int(fb, y);
    fbptr_put_word(fb, c);
    fbptr_put_word(fb, text);
    return fbptr_end(fb, NULL, 0);
}

/* WIDELINE x0 y0 x1 y1 w c: draws a line w wide with round ends: the pixel centres nearer than w/2; reals */
static inline int fbptr_wideline(fbptr *fb, double x0, double y0, double x1, double y1, double w, const char *c)
{
    fbptr_put(fb, "WIDELINE", 8);
    fbptr_put_real(fb, x0);
    fbptr_put_real(fb, y0);
    fbptr_put_real(fb, x1);
    fbptr_put_real(fb, y1);
    fbptr_put_real(fb, w);
    fbptr_put_word(fb, c);
    return fbptr_end(fb, NULL, 0);
}

/* ELLIPSE cx cy rx ry c: draws the rim of what FILLELLIPSE fills; reals */
static inline int fbptr_ellipse(fbptr *fb, double cx, double cy, double rx, double ry, const char *c)
{
    fbptr_put(fb, "ELLIPSE", 7);
    fbptr_put_real(fb, cx);
    fbptr_put_real(fb, cy);
    fbptr_put_real(fb, rx);
    fbptr_put_real(fb, ry);
    fbptr_put_word(fb, c);
    return fbptr_end(fb, NULL, 0);
}

/* FILLELLIPSE cx cy rx ry c: fills the pixel centres inside an ellipse; reals */
static inline int fbptr_fillellipse(fbptr *fb, double cx, double cy, double rx, double ry, const char *c)
{
    fbptr_put(fb, "FILLELLIPSE", 11);
    fbptr_put_real(fb, cx);
    fbptr_put_real(fb, cy);
    fbptr_put_real(fb, rx);
    fbptr_put_real(fb, ry);
    fbptr_put_word(fb, c);
    return fbptr_end(fb, NULL, 0);
}

/* ARC cx cy inner outer start end c: fills the part of a ring between two angles, clockwise from the right; reals */
static inline int fbptr_arc(fbptr *fb, double cx, double cy, double inner, double outer, double start, double end, const char *c)
{
    fbptr_put(fb, "ARC", 3);
    fbptr_put_real(fb, cx);
    fbptr_put_real(fb, cy);
    fbptr_put_real(fb, inner);
    fbptr_put_real(fb, outer);
    fbptr_put_real(fb, start);
    fbptr_put_real(fb, end);
    fbptr_put_word(fb, c);
    return fbptr_end(fb, NULL, 0);
}

/* BEZIER x0 y0 x1 y1 x2 y2 x3 y3 w c: draws a cubic Bezier curve w wide with round ends; reals */
static inline int fbptr_bezier(fbptr *fb, double x0, double y0, double x1, double y1, double x2, double y2, double x3, double y3, double w, const char *c)
{
    fbptr_put(fb, "BEZIER", 6);
    fbptr_put_real(fb, x0);
    fbptr_put_real(fb, y0);
    fbptr_put_real(fb, x1);
    fbptr_put_real(fb, y1);
    fbptr_put_real(fb, x2);
    fbptr_put_real(fb, y2);
    fbptr_put_real(fb, x3);
    fbptr_put_real(fb, y3);
    fbptr_put_real(fb, w);
    fbptr_put_word(fb, c);
    return fbptr_end(fb, NULL, 0);
}

/* LINEAA x0 y0 x1 y1 c: draws an anti-aliased line by exact coverage; reals */
static inline int fbptr_lineaa(fbptr *fb, double x0, double y0, double x1, double y1, const char *c)
{
    fbptr_put(fb, "LINEAA", 6);
    fbptr_put_real(fb, x0);
    fbptr_put_real(fb, y0);
    fbptr_put_real(fb, x1);
    fbptr_put_real(fb, y1);
    fbptr_put_word(fb, c);
    return fbptr_end(fb, NULL, 0);
}

/* BLEND replace|over: stores colours as they are, or composes them source-over */
static inline int fbptr_blend(fbptr *fb, const char *mode)
{
    fbptr_put(fb, "BLEND", 5);
    fbptr_put_word(fb, mode);
    return fbptr_end(fb, NULL, 0);
}

/* CLIP x y w h: lets later drawing of this connection touch a rectangle alone; CLIP OFF: lets it touch everything */
static inline int fbptr_clip(fbptr *fb, const char *rest)
{
    fbptr_put(fb, "CLIP", 4);
    fbptr_put_word(fb, rest);
    return fbptr_end(fb, NULL, 0);
}

/* CANVAS name w h: makes a transparent off-screen frame, with a depth of its own */
static inline int fbptr_canvas(fbptr *fb, const char *name, int w, int h)
{
    fbptr_put(fb, "CANVAS", 6);
    fbptr_put_word(fb, name);
    fbptr_put_int(fb, w);
    fbptr_put_int(fb, h);
    return fbptr_end(fb, NULL, 0);
}

/* TARGET name|FRAME: draws and reads later on a canvas, or on the frame again */
static inline int fbptr_target(fbptr *fb, const char *name)
{
    fbptr_put(fb, "TARGET", 6);
    fbptr_put_word(fb, name);
    return fbptr_end(fb, NULL, 0);
}

/* STAMP name x y [c]: puts a canvas with its upper left corner at (x,y), but for its pixels of colour c */
static inline int fbptr_stamp(fbptr *fb, const char *name, int x, int y, const char *c)
{
    fbptr_put(fb, "STAMP", 5);
    fbptr_put_word(fb, name);
    fbptr_put_int(fb, x);
    fbptr_put_int(fb, y);
    fbptr_put_word(fb, c);
    return fbptr_end(fb, NULL, 0);
}

/* TEXTSIZE 1|2|3|4|5|6|7|8: makes the letters of TEXT and PRINT so many times as large */
static inline int fbptr_textsize(fbptr *fb, const char *size)
{
    fbptr_put(fb, "TEXTSIZE", 8);
    fbptr_put_word(fb, size);
    return fbptr_end(fb, NULL, 0);
}

/* IMAGE x y :N: puts a PNG or JPEG picture with its upper left corner at (x,y) */
static inline int fbptr_image(fbptr *fb, int x, int y, const void *file, size_t bytes)
{
    fbptr_put(fb, "IMAGE", 5);
    fbptr_put_int(fb, x);
    fbptr_put_int(fb, y);
    return fbptr_end(fb, file, bytes);
}

/* MESH name OBJ :N: makes a mesh from the N bytes of an OBJ file; MESH name BOX [x y z]: makes a box (2 2 2); MESH
   name SPHERE [r]: makes a sphere (1); MESH name CONE [r h]: makes a cone (1 2); MESH name CYLINDER [r h]: makes a
   cylinder (1 2); MESH name TEAPOT [level]: makes Newell's teapot, each patch cut level x level; MESH name KNOT nu
   nv: makes a torus knot of nu x nv quads */
static inline int fbptr_mesh(fbptr *fb, const char *name, const char *rest, const void *payload, size_t bytes)
{
    fbptr_put(fb, "MESH", 4);
    fbptr_put_word(fb, name);
    fbptr_put_word(fb, rest);
    return fbptr_end(fb, payload, bytes);
}

/* TEX name :N: makes a texture from the N bytes of a PNG or JPEG file */
static inline int fbptr_tex(fbptr *fb, const char *name, const void *file, size_t bytes)
{
    fbptr_put(fb, "TEX", 3);
    fbptr_put_word(fb, name);
    return fbptr_end(fb, file, bytes);
}

/* SCENE X3D :N: replaces camera, lights and objects by those of an X3D file */
static inline int fbptr_scene(fbptr *fb, const void *x3d, size_t bytes)
{
    fbptr_put(fb, "SCENE", 5);
    fbptr_put_word(fb, "X3D");
    return fbptr_end(fb, x3d, bytes);
}

/* EYE name :N: makes an N-dimensional scene from JSON */
static inline int fbptr_eye(fbptr *fb, const char *name, const void *json, size_t bytes)
{
    fbptr_put(fb, "EYE", 3);
    fbptr_put_word(fb, name);
    return fbptr_end(fb, json, bytes);
}

/* FREE name: forgets a mesh, texture, scene or canvas */
static inline int fbptr_free(fbptr *fb, const char *name)
{
    fbptr_put(fb, "FREE", 4);
    fbptr_put_word(fb, name);
    return fbptr_end(fb, NULL, 0);
}

/* LOAD MESH|TEX name path: loads a file of the server's own folder; LOAD SCENE path: loads an X3D file of the
   server's own folder */
static inline int fbptr_load(fbptr *fb, const char *kind, const char *rest)
{
    fbptr_put(fb, "LOAD", 4);
    fbptr_put_word(fb, kind);
    fbptr_put_word(fb, rest);
    return fbptr_end(fb, NULL, 0);
}

/* LOOKAT ex ey ez rx ry rz ux uy uz: puts the eye at e, looking at r, u up */
static inline int fbptr_lookat(fbptr *fb, double ex, double ey, double ez, double rx, double ry, double rz, double ux, double uy, double uz)
{
    fbptr_put(fb, "LOOKAT", 6);
    fbptr_put_real(fb, ex);
    fbptr_put_real(fb, ey);
    fbptr_put_real(fb, ez);
    fbptr_put_real(fb, rx);
    fbptr_put_real(fb, ry);
    fbptr_put_real(fb, rz);
    fbptr_put_real(fb, ux);
    fbptr_put_real(fb, uy);
    fbptr_put_real(fb, uz);
    return fbptr_end(fb, NULL, 0);
}

/* PERSPECTIVE fov near far [FOVMIN]: sees in perspective; the angle is vertical, or on the smaller side */
static inline int fbptr_perspective(fbptr *fb, double fov, double near, double far, int on_smaller_side)
{
    fbptr_put(fb, "PERSPECTIVE", 11);
    fbptr_put_real(fb, fov);
    fbptr_put_real(fb, near);
    fbptr_put_real(fb, far);
    fbptr_put_word(fb, on_smaller_side ? "FOVMIN" : NULL);
    return fbptr_end(fb, NULL, 0);
}

/* PLANE d near far: sees in perspective on a view plane at distance d */
static inline int fbptr_plane(fbptr *fb, double d, double near, double far)
{
    fbptr_put(fb, "PLANE", 5);
    fbptr_put_real(fb, d);
    fbptr_put_real(fb, near);
    fbptr_put_real(fb, far);
    return fbptr_end(fb, NULL, 0);
}

/* FRUSTUM l r b t near far: sees in perspective through a window at the near plane */
static inline int fbptr_frustum(fbptr *fb, double l, double r, double b, double t, double near, double far)
{
    fbptr_put(fb, "FRUSTUM", 7);
    fbptr_put_real(fb, l);
    fbptr_put_real(fb, r);
    fbptr_put_real(fb, b);
    fbptr_put_real(fb, t);
    fbptr_put_real(fb, near);
    fbptr_put_real(fb, far);
    return fbptr_end(fb, NULL, 0);
}

/* ORTHO l r b t near far: sees in parallel */
static inline int fbptr_ortho(fbptr *fb, double l, double r, double b, double t, double near, double far)
{
    fbptr_put(fb, "ORTHO", 5);
    fbptr_put_real(fb, l);
    fbptr_put_real(fb, r);
    fbptr_put_real(fb, b);
    fbptr_put_real(fb, t);
    fbptr_put_real(fb, near);
    fbptr_put_real(fb, far);
    return fbptr_end(fb, NULL, 0);
}

/* OBLIQUE cavalier|cabinet angle l r b t near far: sees in oblique parallel */
static inline int fbptr_oblique(fbptr *fb, const char *mode, double angle, double l, double r, double b, double t, double near, double far)
{
    fbptr_put(fb, "OBLIQUE", 7);
    fbptr_put_word(fb, mode);
    fbptr_put_real(fb, angle);
    fbptr_put_real(fb, l);
    fbptr_put_real(fb, r);
    fbptr_put_real(fb, b);
    fbptr_put_real(fb, t);
    fbptr_put_real(fb, near);
    fbptr_put_real(fb, far);
    return fbptr_end(fb, NULL, 0);
}

/* ISOMETRIC l r b t near far: sees isometrically */
static inline int fbptr_isometric(fbptr *fb, double l, double r, double b, double t, double near, double far)
{
    fbptr_put(fb, "ISOMETRIC", 9);
    fbptr_put_real(fb, l);
    fbptr_put_real(fb, r);
    fbptr_put_real(fb, b);
    fbptr_put_real(fb, t);
    fbptr_put_real(fb, near);
    fbptr_put_real(fb, far);
    return fbptr_end(fb, NULL, 0);
}

/* PSEUDOISO l r b t near far: sees pseudo-isometrically */
static inline int fbptr_pseudoiso(fbptr *fb, double l, double r, double b, double t, double near, double far)
{
    fbptr_put(fb, "PSEUDOISO", 9);
    fbptr_put_real(fb, l);
    fbptr_put_real(fb, r);
    fbptr_put_real(fb, b);
    fbptr_put_real(fb, t);
    fbptr_put_real(fb, near);
    fbptr_put_real(fb, far);
    return fbptr_end(fb, NULL, 0);
}

/* WINDOW vrp(3) p(3) vup(3) cu cv su sv dp near far: sees by the viewing transformation */
static inline int fbptr_window(fbptr *fb, double vrp, double p, double vup, double cu, double cv, double su, double sv, double dp, double near, double far)
{
    fbptr_put(fb, "WINDOW", 6);
    fbptr_put_real(fb, vrp);
    fbptr_put_real(fb, p);
    fbptr_put_real(fb, vup);
    fbptr_put_real(fb, cu);
    fbptr_put_real(fb, cv);
    fbptr_put_real(fb, su);
    fbptr_put_real(fb, sv);
    fbptr_put_real(fb, dp);
    fbptr_put_real(fb, near);
    fbptr_put_real(fb, far);
    return fbptr_end(fb, NULL, 0);
}

/* VIEWPORT x y w h [centres|corners]: puts the picture into a part of the frame */
static inline int fbptr_viewport(fbptr *fb, int x, int y, int w, int h, const char *rest)
{
    fbptr_put(fb, "VIEWPORT", 8);
    fbptr_put_int(fb, x);
    fbptr_put_int(fb, y);
    fbptr_put_int(fb, w);
    fbptr_put_int(fb, h);
    fbptr_put_word(fb, rest);
    return fbptr_end(fb, NULL, 0);
}

/* IDENTITY: resets the model matrix */
static inline int fbptr_identity(fbptr *fb)
{
    fbptr_put(fb, "IDENTITY", 8);
    return fbptr_end(fb, NULL, 0);
}

/* PUSH: keeps the model matrix */
static inline int fbptr_push(fbptr *fb)
{
    fbptr_put(fb, "PUSH", 4);
    return fbptr_end(fb, NULL, 0);
}

/* POP: brings back the model matrix kept last */
static inline int fbptr_pop(fbptr *fb)
{
    fbptr_put(fb, "POP", 3);
    return fbptr_end(fb, NULL, 0);
}

/* TRANSLATE x y z: multiplies the model matrix on the right, as the next four do */
static inline int fbptr_translate(fbptr *fb, double x, double y, double z)
{
    fbptr_put(fb, "TRANSLATE", 9);
    fbptr_put_real(fb, x);
    fbptr_put_real(fb, y);
    fbptr_put_real(fb, z);
    return fbptr_end(fb, NULL, 0);
}

/* ROTATE ax ay az angle: turns about an axis; in radians, or as 45deg */
static inline int fbptr_rotate(fbptr *fb, double ax, double ay, double az, double angle)
{
    fbptr_put(fb, "ROTATE", 6);
    fbptr_put_real(fb, ax);
    fbptr_put_real(fb, ay);
    fbptr_put_real(fb, az);
    fbptr_put_real(fb, angle);
    return fbptr_end(fb, NULL, 0);
}

/* SCALE x y z: scales along the axes */
static inline int fbptr_scale(fbptr *fb, double x, double y, double z)
{
    fbptr_put(fb, "SCALE", 5);
    fbptr_put_real(fb, x);
    fbptr_put_real(fb, y);
    fbptr_put_real(fb, z);
    return fbptr_end(fb, NULL, 0);
}

/* SHEAR xy xz yx yz zx zy: shears: x' = x + xy*y + xz*z and so on */
static inline int fbptr_shear(fbptr *fb, double xy, double xz, double yx, double yz, double zx, double zy)
{
    fbptr_put(fb, "SHEAR", 5);
    fbptr_put_real(fb, xy);
    fbptr_put_real(fb, xz);
    fbptr_put_real(fb, yx);
    fbptr_put_real(fb, yz);
    fbptr_put_real(fb, zx);
    fbptr_put_real(fb, zy);
    return fbptr_end(fb, NULL, 0);
}

/* MATRIX m00..m33: sixteen numbers, row by row */
static inline int fbptr_matrix(fbptr *fb, const char *rest)
{
    fbptr_put(fb, "MATRIX", 6);
    fbptr_put_word(fb, rest);
    return fbptr_end(fb, NULL, 0);
}

/* AMBIENT r g b: sets the ambient light; colours of light are 0..1 and above; AMBIENT name: the same by a CSS name
   or #rrggbb; so may any r g b of LIGHT and MATERIAL be given */
static inline int fbptr_ambient(fbptr *fb, const char *rest)
{
    fbptr_put(fb, "AMBIENT", 7);
    fbptr_put_word(fb, rest);
    return fbptr_end(fb, NULL, 0);
}

/* LIGHT i POINT x y z r g b [c l q]: puts a light at a point, fading by 1/(c + l d + q d^2); LIGHT i DIR dx dy dz r
   g b: lets light fall in a direction; LIGHT i SPOT x y z dx dy dz angle exponent r g b [c l q]: puts a spot light;
   LIGHT i OFF: takes a light away */
static inline int fbptr_light(fbptr *fb, int index, const char *rest)
{
    fbptr_put(fb, "LIGHT", 5);
    fbptr_put_int(fb, index);
    fbptr_put_word(fb, rest);
    return fbptr_end(fb, NULL, 0);
}

/* MATERIAL ka(3) kd(3) ks(3) n [emissive(3) [transparency]]: says how surfaces answer light; MATERIAL ka kd ks n
   [emissive [transparency]]: the same with names of colours */
static inline int fbptr_material(fbptr *fb, const char *rest)
{
    fbptr_put(fb, "MATERIAL", 8);
    fbptr_put_word(fb, rest);
    return fbptr_end(fb, NULL, 0);
}

/* TEXTURE name|OFF [nearest|bilinear|mipmap|trilinear] [repeat|clamp]: lays a texture on what is drawn next */
static inline int fbptr_texture(fbptr *fb, const char *name, const char *rest)
{
    fbptr_put(fb, "TEXTURE", 7);
    fbptr_put_word(fb, name);
    fbptr_put_word(fb, rest);
    return fbptr_end(fb, NULL, 0);
}

/* SHADE wire|flat|gouraud|phong: chooses how faces are coloured */
static inline int fbptr_shade(fbptr *fb, const char *mode)
{
    fbptr_put(fb, "SHADE", 5);
    fbptr_put_word(fb, mode);
    return fbptr_end(fb, NULL, 0);
}

/* CULL back|front|none: chooses the faces to leave out */
static inline int fbptr_cull(fbptr *fb, const char *mode)
{
    fbptr_put(fb, "CULL", 4);
    fbptr_put_word(fb, mode);
    return fbptr_end(fb, NULL, 0);
}

/* HIDE zbuffer|painter|none: chooses how hidden surfaces are found */
static inline int fbptr_hide(fbptr *fb, const char *mode)
{
    fbptr_put(fb, "HIDE", 4);
    fbptr_put_word(fb, mode);
    return fbptr_end(fb, NULL, 0);
}

/* DEPTH u16|u24|u32|f32|reversed: chooses how depth is stored, and clears it */
static inline int fbptr_depth(fbptr *fb, const char *mode)
{
    fbptr_put(fb, "DEPTH", 5);
    fbptr_put_word(fb, mode);
    return fbptr_end(fb, NULL, 0);
}

/* INTERP perspective|affine: chooses how values run across a face */
static inline int fbptr_interp(fbptr *fb, const char *mode)
{
    fbptr_put(fb, "INTERP", 6);
    fbptr_put_word(fb, mode);
    return fbptr_end(fb, NULL, 0);
}

/* DRAW name: draws a mesh */
static inline int fbptr_draw(fbptr *fb, const char *name)
{
    fbptr_put(fb, "DRAW", 4);
    fbptr_put_word(fb, name);
    return fbptr_end(fb, NULL, 0);
}

/* DRAWSCENE [time] [SORTED]: draws the scene at a time, transparent faces in order or sorted */
static inline int fbptr_drawscene(fbptr *fb, const char *rest)
{
    fbptr_put(fb, "DRAWSCENE", 9);
    fbptr_put_word(fb, rest);
    return fbptr_end(fb, NULL, 0);
}

/* DRAWEYE name x y w h: draws an N-dimensional scene into a rectangle */
static inline int fbptr_draweye(fbptr *fb, const char *name, int x, int y, int w, int h)
{
    fbptr_put(fb, "DRAWEYE", 7);
    fbptr_put_word(fb, name);
    fbptr_put_int(fb, x);
    fbptr_put_int(fb, y);
    fbptr_put_int(fb, w);
    fbptr_put_int(fb, h);
    return fbptr_end(fb, NULL, 0);
}

/* QUALITY exact: draws exactly; QUALITY max-error e [shift]: draws more cheaply within e steps of colour and a shift
   in pixels */
static inline int fbptr_quality(fbptr *fb, const char *rest)
{
    fbptr_put(fb, "QUALITY", 7);
    fbptr_put_word(fb, rest);
    return fbptr_end(fb, NULL, 0);
}

/* DEPTHAT x y: answers DEPTHAT x y z, 0 near and 1 far */
static inline int fbptr_depthat(fbptr *fb, int x, int y, char *reply, size_t room)
{
    fbptr_put(fb, "DEPTHAT", 7);
    fbptr_put_int(fb, x);
    fbptr_put_int(fb, y);
    fbptr_end(fb, NULL, 0);
    return fbptr_answer(fb, "DEPTHAT", reply, room);
}

/* PICK x y: answers PICK x y name|none triangle */
static inline int fbptr_pick(fbptr *fb, int x, int y, char *reply, size_t room)
{
    fbptr_put(fb, "PICK", 4);
    fbptr_put_int(fb, x);
    fbptr_put_int(fb, y);
    fbptr_end(fb, NULL, 0);
    return fbptr_answer(fb, "PICK", reply, room);
}

/* SYNC tag: answers SYNC tag when all before it is done */
static inline int fbptr_sync(fbptr *fb, const char *tag, char *reply, size_t room)
{
    fbptr_put(fb, "SYNC", 4);
    fbptr_put_word(fb, tag);
    fbptr_end(fb, NULL, 0);
    return fbptr_answer(fb, "SYNC", reply, room);
}

/* HELLO: answers HELLO fbptr 1 width height stride rgba */
static inline int fbptr_hello(fbptr *fb, char *reply, size_t room)
{
    fbptr_put(fb, "HELLO", 5);
    fbptr_end(fb, NULL, 0);
    return fbptr_answer(fb, "HELLO", reply, room);
}

/* VERSION: answers VERSION and the program's version */
static inline int fbptr_version(fbptr *fb, char *reply, size_t room)
{
    fbptr_put(fb, "VERSION", 7);
    fbptr_end(fb, NULL, 0);
    return fbptr_answer(fb, "VERSION", reply, room);
}

/* TITLE text ...: names the window by the rest of the line; no :N is read in it */
static inline int fbptr_title(fbptr *fb, const char *text)
{
    fbptr_put(fb, "TITLE", 5);
    fbptr_put_word(fb, text);
    return fbptr_end(fb, NULL, 0);
}

/* WAIT seconds: pauses this connection alone, at most 60 s; not where no window is */
static inline int fbptr_wait(fbptr *fb, double seconds)
{
    fbptr_put(fb, "WAIT", 4);
    fbptr_put_real(fb, seconds);
    return fbptr_end(fb, NULL, 0);
}

/* AUTO on|off: shows the memory as it changes, or only at PRESENT */
static inline int fbptr_auto(fbptr *fb, const char *mode)
{
    fbptr_put(fb, "AUTO", 4);
    fbptr_put_word(fb, mode);
    return fbptr_end(fb, NULL, 0);
}

/* EVENTS on|off: asks for EVENT lines: keys, text, mouse, resize, close */
static inline int fbptr_events(fbptr *fb, const char *mode)
{
    fbptr_put(fb, "EVENTS", 6);
    fbptr_put_word(fb, mode);
    return fbptr_end(fb, NULL, 0);
}

/* ERRORS count|report|close: settles whether errors are counted, reported, or end the connection */
static inline int fbptr_errors(fbptr *fb, const char *mode)
{
    fbptr_put(fb, "ERRORS", 6);
    fbptr_put_word(fb, mode);
    return fbptr_end(fb, NULL, 0);
}

/* The end of what is made from the verb table */

#endif
