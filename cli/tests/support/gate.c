/*
 * A slow disk: preloaded, it lets a write to a file NAME wait as long as the file GATE/NAME says in milliseconds, or, where
 * that is empty, while it is there. It makes GATE/NAME.waits when a write has begun to wait. GATE is the directory named by
 * LINEWRIGHT_GATE.
 */
#define _GNU_SOURCE
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

static void wait_at_gate(int file)
{
    const char *gate = getenv("LINEWRIGHT_GATE");
    char link[64], path[512], closed[1024], waits[1100];
    const struct timespec moment = { 0, 5 * 1000 * 1000 };

    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    ssize_t length = gate ? readlink(link, path, sizeof path - 1) : -1;
    if (length <= 0)
        return;
    path[length] = 0;
    const char *name = strrchr(path, '/');
    snprintf(closed, sizeof closed, "%s%s", gate, name ? name : "/");
    if (access(closed, F_OK) != 0)
        return;
    snprintf(waits, sizeof waits, "%s.waits", closed);
    int mark = open(waits, O_CREAT | O_WRONLY | O_CLOEXEC, 0600);
    if (mark >= 0)
        close(mark);
    long milliseconds = 0;
    FILE *says = fopen(closed, "re");
    int timed = says && fscanf(says, "%ld", &milliseconds) == 1;
    if (says)
        fclose(says);
    if (timed) {
        const struct timespec delay = { milliseconds / 1000, milliseconds % 1000 * 1000 * 1000 };
        nanosleep(&delay, NULL);
        return;
    }
    while (access(closed, F_OK) == 0)
        nanosleep(&moment, NULL);
}

/* Of the database; sockets and the like have no path. */
ssize_t write(int file, const void *bytes, size_t count)
{
    char link[64], path[2];

    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    if (readlink(link, path, 1) == 1 && path[0] == '/')
        wait_at_gate(file);
    return syscall(SYS_write, file, bytes, count);
}

ssize_t pwrite64(int file, const void *bytes, size_t count, off64_t offset)
{
    wait_at_gate(file);
    return syscall(SYS_pwrite64, file, bytes, count, offset);
}
