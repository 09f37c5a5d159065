/* The line is standard input and output: a pipe, a pseudo-terminal, socat. */
#define _POSIX_C_SOURCE 200809L
#include "platform.h"

#include <poll.h>
#include <stdio.h>
#include <time.h>
#include <unistd.h>

uint32_t platform_now_ms(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (uint32_t)(time.tv_sec * 1000 + time.tv_nsec / 1000000);
}

int platform_receive(uint8_t *bytes, size_t size) {
    struct pollfd line = {.fd = STDIN_FILENO, .events = POLLIN};
    if (poll(&line, 1, 5) <= 0) return 0;
    ssize_t got = read(STDIN_FILENO, bytes, size);
    return got > 0 ? (int)got : -1;
}

void platform_send(const uint8_t *bytes, size_t size) {
    while (size > 0) {
        ssize_t sent = write(STDOUT_FILENO, bytes, size);
        if (sent <= 0) return;
        bytes += sent;
        size -= (size_t)sent;
    }
}

void platform_say(const char *text, long number) { fprintf(stderr, "%s %ld\n", text, number); }
