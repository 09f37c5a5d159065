/* libmodbus: a server of 16 registers for many connections, and a client that asks for four. */
#include <errno.h>
#include <modbus.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/select.h>
#include <time.h>
#include <unistd.h>

static int serve(int port) {
    modbus_t *modbus = modbus_new_tcp("127.0.0.1", port);
    modbus_mapping_t *registers = modbus_mapping_new(0, 0, 16, 0);
    int listener = modbus_tcp_listen(modbus, 64);
    int last = listener;
    fd_set all;
    if (listener < 0) return 1;
    FD_ZERO(&all);
    FD_SET(listener, &all);
    for (;;) {
        fd_set ready = all;
        if (select(last + 1, &ready, NULL, NULL, NULL) < 0) return 1;
        for (int fd = 0; fd <= last; fd++) {
            if (!FD_ISSET(fd, &ready)) continue;
            if (fd == listener) {
                int on = 1, connection = modbus_tcp_accept(modbus, &listener);
                if (connection < 0) return 1;
                setsockopt(connection, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
                FD_SET(connection, &all);
                if (connection > last) last = connection;
                continue;
            }
            uint8_t query[MODBUS_TCP_MAX_ADU_LENGTH];
            modbus_set_socket(modbus, fd);
            int length = modbus_receive(modbus, query);
            if (length > 0) {
                modbus_reply(modbus, query, length, registers);
            } else if (length < 0) {
                close(fd);
                FD_CLR(fd, &all);
            }
        }
    }
}

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return time.tv_sec + time.tv_nsec * 1e-9;
}

static int by_size(const void *a, const void *b) {
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static int ask(int port, double seconds) {
    modbus_t *modbus = modbus_new_tcp("127.0.0.1", port);
    size_t room = 4u << 20, count = 0;
    float *took = malloc(room * sizeof *took);
    uint16_t registers[4];
    if (!took || modbus_connect(modbus) < 0) return 1;
    double start = now(), before = start;
    clock_t busy = clock();
    while (before - start < seconds && count < room) {
        if (modbus_read_registers(modbus, 0, 4, registers) != 4) return 1;
        double after = now();
        took[count++] = (float)(after - before);
        before = after;
    }
    busy = clock() - busy;
    qsort(took, count, sizeof *took, by_size);
    printf("%zu %.2f %.6f\n", count, took[count * 99 / 100] * 1e6, (double)busy / CLOCKS_PER_SEC);
    return 0;
}

int main(int count, char **words) {
    if (count == 3 && !strcmp(words[1], "serve")) return serve(atoi(words[2]));
    if (count == 4 && !strcmp(words[1], "ask")) return ask(atoi(words[2]), atof(words[3]));
    return 2;
}
