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
   its length, or -1 if the command was refused: then the answer is the server's line about it. Include this file first,
   or define _POSIX_C_SOURCE as 200112L. */
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

/* Reads the answer to the command that was sent last; events that come before it are kept. */
static inline int fbptr_answer(fbptr *fb, char *reply, size_t room)
{
    char line[FBPTR_LINE];
    if (fbptr_flush(fb) < 0)
        return -1;
    for (;;) {
        int len = fbptr_read_line(fb, line, sizeof line);
        if (len < 0)
            return -1;
        if (strncmp(line, "EVENT ", 6) == 0) {
            if (fb->event_count < FBPTR_EVENTS)
                snprintf(fb->events[fb->event_count++], FBPTR_EVENT, "%.63s", line + 6);
            continue;
        }
        snprintf(reply, room, "%s", line);
        return strncmp(line, "ERR ", 4) == 0 ? -1 : len;
    }
}

/* Reads the bytes that follow an answer `... :N`. Returns their number, of which at most `room` are kept. */
static inline long fbptr_answer_bytes(fbptr *fb, void *bytes, size_t room)
{
    char line[FBPTR_LINE], *colon;
    long count, i;
    if (fbptr_answer(fb, line, sizeof line) < 0 || (colon = strrchr(line, ':')) == NULL)
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
        if (fb->socket < 0 || connect(fb->socket, (struct sockaddr *)&place, sizeof place) != 0)
            return -1;
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
            return -1;
        }
        freeaddrinfo(found);
    }
    fb->is_connected = 1;
    fbptr_command(fb, "ERRORS report", NULL, 0);
    fbptr_command(fb, "SIZE", NULL, 0);
    if (fbptr_answer(fb, size, sizeof size) < 0 || sscanf(size, "SIZE %d %d", &fb->width, &fb->height) != 2)
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
        if (strncmp(line, "EVENT ", 6) == 0) {
            snprintf(event, room, "%s", line + 6);
            return 1;
        }
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
/* The end of what is made from the verb table */

#endif
