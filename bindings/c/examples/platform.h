/* What an example needs of its machine. */
#ifndef PLATFORM_H
#define PLATFORM_H
#include <stddef.h>
#include <stdint.h>

/* Milliseconds since the start. */
uint32_t platform_now_ms(void);
/* Bytes that have come, at most `size`; waits for them a few milliseconds. -1: the line is gone. */
int platform_receive(uint8_t *bytes, size_t size);
/* Sends all bytes. */
void platform_send(const uint8_t *bytes, size_t size);
/* A line for people. */
void platform_say(const char *text, long number);
#endif
