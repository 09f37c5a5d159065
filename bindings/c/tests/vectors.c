/* The golden vectors, from C. Lines of standard input: `frame BODY WIRE` and `record BYTES`, all in
 * hexadecimal digits; `xtask bindings` makes them of conformance/vectors. */
#include <stdio.h>
#include <string.h>

#include "lafet.h"
#include "lafet_protocol.h"

static size_t unhex(const char *text, uint8_t *bytes, size_t room) {
    size_t count = 0;
    unsigned byte;
    for (; count < room && sscanf(text, "%2x", &byte) == 1; text += 2) bytes[count++] = (uint8_t)byte;
    return count;
}

static bool frame_holds(const char *body_text, const char *wire_text) {
    uint8_t body[1100], wire[1100], out[LAFET_WIRE_MAX];
    size_t size = unhex(body_text, body, sizeof body), length = unhex(wire_text, wire, sizeof wire);
    size_t made = lafet_frame_encode(body[0], body[1], body + 2, size - 2, out, sizeof out);
    if (made != length || memcmp(out, wire, length) != 0) return false;
    if (lafet_frame_encode(body[0], body[1], body + 2, size - 2, out, length - 1) != 0) return false;
    lafet_decoder decoder;
    lafet_frame frame;
    bool complete = false;
    lafet_decoder_init(&decoder);
    for (size_t i = 0; i < length; i++) {
        if (complete || lafet_decoder_push(&decoder, wire + i, 1, &frame, &complete) != 1) return false;
    }
    return complete && frame.dst == body[0] && frame.src == body[1] && frame.size == size - 2 &&
           memcmp(frame.payload, body + 2, frame.size) == 0;
}

static bool record_holds(const char *text) {
    uint8_t bytes[300], again[300];
    size_t size = unhex(text, bytes, sizeof bytes), left = size, put = 0;
    const uint8_t *rest = bytes;
    lafet_record record, none;
    if (!lafet_record_next(&rest, &left, &record) || left != 0) return false;
    if (lafet_record_next(&rest, &left, &none)) return false;
    if (!lafet_record_put(again, sizeof again, &put, &record)) return false;
    if (put != size || memcmp(again, bytes, size) != 0) return false;
    put = 0;
    if (lafet_record_put(again, size - 1, &put, &record) || put != 0) return false;
    /* One byte less is no record. */
    rest = bytes;
    left = size - 1;
    return !lafet_record_next(&rest, &left, &none) && left == size - 1;
}

static bool state_holds(void) {
    static const uint8_t bytes[] = {LAFET_REQUEST_GET_STATUS, LAFET_SUBSYSTEM_VERTICAL, LAFET_STATUS_OK, 8,
                                    0, 0, 0x41, 0, 0xB0, 4, 21, 9};
    const uint8_t *rest = bytes;
    size_t left = sizeof bytes;
    lafet_record record;
    lafet_state state;
    if (!lafet_record_next(&rest, &left, &record) || !lafet_state_read(&record, &state)) return false;
    if (state.flags != (LAFET_DRIVE_MOVE | LAFET_DRIVE_SPEED_WAY_FAULT)) return false;
    if (state.position != 1200 || state.current != 21 || state.speed != 9) return false;
    record.size = 7;
    return !lafet_state_read(&record, &state) && !lafet_answer_is_valid(&record) &&
           !lafet_state_read(NULL, &state);
}

int main(void) {
    static char line[8192];
    unsigned held = 0, failed = 0;
    while (fgets(line, sizeof line, stdin)) {
        const char *kind = strtok(line, " \n"), *first = strtok(NULL, " \n"), *second = strtok(NULL, " \n");
        bool holds = kind && first &&
                     (strcmp(kind, "frame") == 0 ? second && frame_holds(first, second) : record_holds(first));
        if (!holds) fprintf(stderr, "does not hold: %s %s\n", kind ? kind : "", first ? first : "");
        holds ? held++ : failed++;
    }
    if (!state_holds()) {
        fprintf(stderr, "the state of a drive does not hold\n");
        failed++;
    }
    printf("%u vectors hold, %u do not\n", held, failed);
    return failed == 0 && held > 0 ? 0 : 1;
}
