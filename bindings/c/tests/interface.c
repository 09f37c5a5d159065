/* What lafet.h promises beyond the bytes: inputs that are kept, missing data, and which answers a session
 * believes. */
#include <stdio.h>
#include <string.h>

#include "lafet.h"
#include "lafet_protocol.h"

#define MONITOR 1
#define OWN 129
#define TIMEOUT_MS 100u

static unsigned failed;

static void check(bool holds, const char *what, int line) {
    if (holds) return;
    fprintf(stderr, "interface.c:%d: %s\n", line, what);
    failed++;
}
#define CHECK(holds) check(holds, #holds, __LINE__)

/* A board that writes only what has changed: everything at the first sample. */
struct board {
    int32_t position;
    unsigned samples;
    bool kept;
};

static void sense(void *context, lafet_inputs *inputs) {
    struct board *board = context;
    if (board->samples++ == 0) {
        board->kept = inputs->drives[1].position == 0 && !inputs->valves[0].close_switch &&
                      inputs->main_voltage_dv == 0 && inputs->buttons[1][7] == 0;
        inputs->drives[1].position = board->position;
        inputs->valves[0].close_switch = true;
        inputs->main_voltage_dv = 240;
        inputs->buttons[1][7] = 3;
        return;
    }
    board->kept = board->kept && inputs->drives[1].position == board->position &&
                  inputs->valves[0].close_switch && inputs->main_voltage_dv == 240 && inputs->buttons[1][7] == 3;
}

static intptr_t load(void *context, uint16_t key, uint8_t *buffer, size_t size) {
    (void)context, (void)key, (void)buffer, (void)size;
    return 0;
}

static void inputs_are_kept(void) {
    static lafet_device devices[2];
    static struct board boards[2] = {{.position = 300}, {.position = -4000}};
    lafet_hal hals[2];
    for (int i = 0; i < 2; i++) {
        hals[i] = (lafet_hal){.context = &boards[i], .read = sense, .load = load};
        CHECK(lafet_device_init(&devices[i], 0, LAFET_REMOTE, MONITOR, &hals[i]));
    }
    for (uint32_t now = 10; now <= 100; now += 10) {
        for (int i = 0; i < 2; i++) lafet_device_step(&devices[i], now, &hals[i]);
    }
    for (int i = 0; i < 2; i++) CHECK(boards[i].samples >= 10 && boards[i].kept);
    /* A restart begins without any. */
    boards[0].samples = 0;
    CHECK(lafet_device_init(&devices[0], 100, LAFET_REMOTE, MONITOR, &hals[0]));
    lafet_device_step(&devices[0], 110, &hals[0]);
    CHECK(boards[0].samples > 0 && boards[0].kept);
}

static lafet_session session;
static uint8_t out[LAFET_WIRE_MAX];

static bool ask(const void *payload, size_t size) { return lafet_session_ask(&session, payload, size); }

static size_t transmit(uint32_t now) { return lafet_session_transmit(&session, now, out, sizeof out); }

/* The records of the frame that was sent last. */
static bool was_sent(const void *payload, size_t size) {
    uint8_t wire[LAFET_WIRE_MAX];
    size_t length = lafet_frame_encode(MONITOR, OWN, payload, size, wire, sizeof wire);
    return length > 0 && memcmp(out, wire, length) == 0;
}

/* Receives a frame of the monitor; whether it is the answer. */
static bool is_answer(const void *payload, size_t size) {
    uint8_t wire[LAFET_WIRE_MAX];
    size_t length = lafet_frame_encode(OWN, MONITOR, payload, size, wire, sizeof wire);
    lafet_frame frame = {0};
    for (size_t taken = 0; taken < length;)
        taken += lafet_session_receive(&session, wire + taken, length - taken, &frame);
    if (lafet_session_outcome(&session) != LAFET_ANSWERED) return false;
    CHECK(frame.size == size && (size == 0 || memcmp(frame.payload, payload, size) == 0));
    return true;
}
#define ASK(...) ask((const uint8_t[]){__VA_ARGS__}, sizeof(const uint8_t[]){__VA_ARGS__})
#define WAS_SENT(...) was_sent((const uint8_t[]){__VA_ARGS__}, sizeof(const uint8_t[]){__VA_ARGS__})
#define IS_ANSWER(...) is_answer((const uint8_t[]){__VA_ARGS__}, sizeof(const uint8_t[]){__VA_ARGS__})

/* Records: requests, and answers with a status. */
#define MOVE LAFET_REQUEST_MOVE, LAFET_SUBSYSTEM_VERTICAL, 0, 2, 0x2C, 1
#define LOOK LAFET_REQUEST_GET_STATUS, LAFET_SUBSYSTEM_VERTICAL, 0, 0
#define STOP LAFET_REQUEST_STOP, LAFET_SUBSYSTEM_ALL, 0, 0
#define STOP_VERTICAL LAFET_REQUEST_STOP, LAFET_SUBSYSTEM_VERTICAL, 0, 0
#define CLOSE LAFET_REQUEST_CLOSE, LAFET_SUBSYSTEM_VALVE1, 0, 2, 0x56, 0x74
#define LOCKOUT(low, high) LAFET_REQUEST_LOCKOUT, LAFET_SUBSYSTEM_ALL, 0, 2, low, high
#define ANSWER(request, from, status) LAFET_REQUEST_##request, LAFET_SUBSYSTEM_##from, LAFET_STATUS_##status, 0
#define STATE LAFET_REQUEST_GET_STATUS, LAFET_SUBSYSTEM_VERTICAL, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0

static void begin(uint32_t timeout_ms, uint8_t tries) {
    lafet_session_init(&session, MONITOR, OWN, timeout_ms, tries);
}

static void the_session_believes_what_can_be_an_answer(void) {
    begin(TIMEOUT_MS, 3);
    CHECK(ASK(MOVE) && !IS_ANSWER(ANSWER(MOVE, VERTICAL, ACCEPTED)));
    CHECK(transmit(0) > 0 && WAS_SENT(MOVE));
    CHECK(!IS_ANSWER(ANSWER(MOVE, HORIZONTAL, ACCEPTED)));
    CHECK(!IS_ANSWER(ANSWER(MOVE, GENERAL, OK)));
    CHECK(!IS_ANSWER(ANSWER(MOVE, HORIZONTAL, DENIED)));
    CHECK(!IS_ANSWER(ANSWER(MOVE, VERTICAL, OK), ANSWER(MOVE, VERTICAL, OK)));
    CHECK(!IS_ANSWER(ANSWER(STOP, VERTICAL, OK)));
    CHECK(!is_answer(NULL, 0));
    CHECK(IS_ANSWER(ANSWER(MOVE, DEPLOYER, DENIED)));
    CHECK(ASK(MOVE, LOOK) && transmit(10) > 0);
    CHECK(!IS_ANSWER(ANSWER(MOVE, VERTICAL, OK)) && !IS_ANSWER(STATE, ANSWER(MOVE, VERTICAL, OK)));
    CHECK(IS_ANSWER(ANSWER(MOVE, VERTICAL, OK), STATE));
    CHECK(ASK(STOP, LOOK) && transmit(20) > 0);
    CHECK(!IS_ANSWER(STATE) && !IS_ANSWER(ANSWER(STOP, ALL, OK), STATE));
    CHECK(!IS_ANSWER(ANSWER(STOP, NOZZLE, OK), ANSWER(STOP, NOZZLE, OK), STATE));
    CHECK(IS_ANSWER(ANSWER(STOP, CONTROL, OK), ANSWER(STOP, NOZZLE, OK), STATE));
    /* The room for answers has ended behind the first. */
    CHECK(ASK(LOOK, MOVE) && transmit(30) > 0);
    CHECK(IS_ANSWER(STATE, ANSWER(MOVE, GENERAL, NO_ROOM)));
    CHECK(ASK(LAFET_REQUEST_GET_PARAM, LAFET_SUBSYSTEM_DETECTOR, 0, 2, 0xFE, 0x23) && transmit(40) > 0);
    CHECK(!IS_ANSWER(LAFET_REQUEST_GET_PARAM, LAFET_SUBSYSTEM_DETECTOR, 0, 6, 0xFE, 0x24, 0, 0, 0, 0));
    CHECK(!IS_ANSWER(ANSWER(GET_PARAM, DETECTOR, OK)));
    CHECK(IS_ANSWER(LAFET_REQUEST_GET_PARAM, LAFET_SUBSYSTEM_DETECTOR, 0, 2, 0xFE, 0x23));
    CHECK(ask(NULL, 0) && transmit(50) > 0 && !IS_ANSWER(STATE) && is_answer(NULL, 0));
    CHECK(!ASK(LAFET_REQUEST_MOVE, LAFET_SUBSYSTEM_VERTICAL, 0, 2, 1));
}

static void a_late_answer_is_not_that_of_the_next(void) {
    begin(TIMEOUT_MS, 1);
    CHECK(ASK(LOOK) && transmit(0) > 0 && transmit(99) == 0 && transmit(100) == 0);
    CHECK(lafet_session_outcome(&session) == LAFET_SILENCE);
    CHECK(ASK(LOOK) && transmit(101) == 0 && !IS_ANSWER(STATE));
    CHECK(transmit(199) == 0 && transmit(200) > 0 && IS_ANSWER(STATE));
    /* One that was sent twice may be answered twice. */
    begin(TIMEOUT_MS, 3);
    CHECK(ASK(LOOK) && transmit(0) > 0 && transmit(100) > 0 && IS_ANSWER(STATE));
    CHECK(ASK(LOOK) && transmit(110) == 0 && !IS_ANSWER(STATE) && transmit(200) > 0 && IS_ANSWER(STATE));
    /* Another kind does not wait; nor does the same after weeks. */
    CHECK(ASK(MOVE) && transmit(210) > 0 && transmit(310) > 0 && transmit(410) > 0 && transmit(510) == 0);
    CHECK(lafet_session_outcome(&session) == LAFET_SILENCE);
    CHECK(ASK(LOOK) && transmit(511) > 0 && IS_ANSWER(STATE));
    CHECK(ASK(MOVE) && transmit(511u + 0x80000000u) > 0 && IS_ANSWER(ANSWER(MOVE, VERTICAL, OK)));
}

static void a_stop_does_not_wait(void) {
    begin(TIMEOUT_MS, 3);
    CHECK(ASK(MOVE) && transmit(0) > 0 && transmit(1) == 0);
    CHECK(!ASK(LOOK) && !ASK(LOCKOUT(0x53, 0x73)) && !ASK(STOP, LOOK));
    CHECK(ASK(STOP_VERTICAL) && transmit(1) > 0 && WAS_SENT(STOP_VERTICAL));
    CHECK(!IS_ANSWER(ANSWER(MOVE, VERTICAL, OK)) && IS_ANSWER(ANSWER(STOP, VERTICAL, OK)));
    CHECK(transmit(200) == 0);
    /* Two that are urgent become one; what is asked already is not sent more often. */
    CHECK(ASK(CLOSE) && transmit(300) > 0 && ASK(LOCKOUT(0xFA, 0x2F)) && transmit(301) > 0);
    CHECK(WAS_SENT(CLOSE, LOCKOUT(0xFA, 0x2F)));
    CHECK(ASK(CLOSE) && transmit(302) == 0 && transmit(401) > 0 && WAS_SENT(CLOSE, LOCKOUT(0xFA, 0x2F)));
    CHECK(!IS_ANSWER(ANSWER(CLOSE, VALVE1, OK)));
    CHECK(IS_ANSWER(ANSWER(CLOSE, VALVE1, OK), ANSWER(LOCKOUT, GENERAL, OK)));
    /* While a late answer may come it is sent, and believed only when it was sent after that. */
    begin(TIMEOUT_MS, 1);
    CHECK(ASK(STOP_VERTICAL) && transmit(0) > 0 && transmit(100) == 0);
    CHECK(lafet_session_outcome(&session) == LAFET_SILENCE);
    CHECK(ASK(STOP_VERTICAL) && transmit(110) > 0 && WAS_SENT(STOP_VERTICAL));
    CHECK(!IS_ANSWER(ANSWER(STOP, VERTICAL, OK)) && transmit(199) == 0);
    CHECK(transmit(200) > 0 && IS_ANSWER(ANSWER(STOP, VERTICAL, OK)));
}

static void a_wait_has_an_end(void) {
    begin(TIMEOUT_MS, 2);
    CHECK(ASK(MOVE));
    for (uint32_t now = 0; now < 200; now += 10) CHECK(lafet_session_transmit(&session, now, out, 3) == 0);
    CHECK(lafet_session_outcome(&session) == LAFET_WAITING);
    CHECK(lafet_session_transmit(&session, 200, out, 3) == 0);
    CHECK(lafet_session_outcome(&session) == LAFET_SILENCE);
    /* Nothing was sent, so nothing can be late. */
    CHECK(ASK(MOVE) && transmit(201) > 0);
    begin(UINT32_MAX, 2);
    CHECK(ASK(MOVE) && transmit(0) > 0 && transmit(1) == 0 && transmit(LAFET_TIMEOUT_MAX_MS - 1) == 0);
    CHECK(transmit(LAFET_TIMEOUT_MAX_MS) > 0);
    begin(0, 0);
    CHECK(ASK(STOP) && transmit(0) > 0 && transmit(0) == 0 && transmit(1) == 0);
    CHECK(lafet_session_outcome(&session) == LAFET_SILENCE);
}

static void missing_data_are_not_empty(void) {
    uint8_t bytes[16] = {STOP};
    size_t size = 4;
    const uint8_t *none = NULL;
    lafet_record record = {LAFET_REQUEST_MOVE, LAFET_SUBSYSTEM_VERTICAL, 0, 2, NULL};
    lafet_state state;
    lafet_frame frame;
    lafet_decoder decoder;
    bool complete = false;
    begin(TIMEOUT_MS, 1);
    CHECK(!lafet_session_ask(&session, NULL, 4) && transmit(0) == 0);
    CHECK(lafet_session_outcome(&session) == LAFET_IDLE);
    CHECK(lafet_session_receive(&session, NULL, 4, &frame) == 0);
    CHECK(lafet_frame_encode(MONITOR, OWN, NULL, 4, out, sizeof out) == 0);
    CHECK(lafet_frame_encode(MONITOR, OWN, bytes, 4, NULL, sizeof out) == 0);
    CHECK(lafet_frame_encode(MONITOR, OWN, NULL, 0, out, sizeof out) > 0);
    CHECK(lafet_frame_encode(MONITOR, OWN, bytes, SIZE_MAX, out, sizeof out) == 0);
    lafet_decoder_init(&decoder);
    CHECK(lafet_decoder_push(&decoder, NULL, 4, &frame, &complete) == 0 && !complete);
    CHECK(!lafet_record_next(&none, &size, &record) && size == 4 && record.size == 2);
    CHECK(!lafet_record_put(bytes, sizeof bytes, &size, &record) && size == 4);
    CHECK(!lafet_answer_is_valid(&record));
    record.request = LAFET_REQUEST_GET_STATUS;
    record.size = 8;
    CHECK(!lafet_state_read(&record, &state));
    static lafet_device device;
    static struct board board;
    static lafet_port port;
    const lafet_hal hal = {.context = &board, .read = sense, .load = load};
    size_t answer = 7;
    CHECK(lafet_device_init(&device, 0, LAFET_REMOTE, MONITOR, &hal));
    CHECK(lafet_device_handle(&device, 0, NULL, 4, out, sizeof out) == 0);
    CHECK(lafet_device_handle(&device, 0, bytes, 4, NULL, sizeof out) == 0);
    CHECK(lafet_device_handle(&device, 0, bytes, 4, out, sizeof out) > 0);
    lafet_port_init(&port, false);
    CHECK(lafet_port_receive(&port, 0, &device, NULL, 4, out, sizeof out, &answer) == 0 && answer == 7);
}

int main(void) {
    inputs_are_kept();
    the_session_believes_what_can_be_an_answer();
    a_late_answer_is_not_that_of_the_next();
    a_stop_does_not_wait();
    a_wait_has_an_end();
    missing_data_are_not_empty();
    printf("what the interface promises: %u checks do not hold\n", failed);
    return failed == 0 ? 0 : 1;
}
