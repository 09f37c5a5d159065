/* A Cortex-M3 without an operating system: UART0 and SysTick of an LM3S6965. Start-up code and the
 * linker's script are the board's. */
#include "platform.h"

#define UART_DR (*(volatile uint32_t *)0x4000C000)
#define UART_FR (*(volatile uint32_t *)0x4000C018)
#define UART_EMPTY 0x10u
#define UART_FULL 0x20u

static volatile uint32_t now_ms;

/* Called by SysTick, a thousand times a second. */
void SysTick_Handler(void) { now_ms++; }

uint32_t platform_now_ms(void) { return now_ms; }

int platform_receive(uint8_t *bytes, size_t size) {
    size_t got = 0;
    while (got < size && !(UART_FR & UART_EMPTY)) bytes[got++] = (uint8_t)UART_DR;
    return (int)got;
}

void platform_send(const uint8_t *bytes, size_t size) {
    for (size_t i = 0; i < size; i++) {
        while (UART_FR & UART_FULL) {
        }
        UART_DR = bytes[i];
    }
}

void platform_say(const char *text, long number) {
    (void)text;
    (void)number;
}
