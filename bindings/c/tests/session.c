/* A session whose line loses, delays and mixes up frames. */
#include <stdio.h>
#include <string.h>

#include "lafet.h"
#include "lafet_protocol.h"

#define MONITOR 1
#define OWN 129
#define TIMEOUT_MS 1000
#define TRIES 3

static lafet_session session;
static unsigned failed;

static void holds(bool it, const char *what) {
    if (it) return;
    fprintf(stderr, "does not hold: %s\n", what);
    failed++;
}

static void start(void) {
    lafet_session_init(&session, MONITOR, OWN, TIMEOUT_MS, TRIES);
}

static bool ask(uint8_t request, uint8_t subsystem, const uint8_t *data, uint8_t size) {
    const lafet_record record = {request, subsystem, 0, size, data};
    uint8_t payload[300];
    size_t put = 0;
    return lafet_record_put(payload, sizeof payload, &put, &record) && lafet_session_ask(&session, payload, put);
}

/* What goes out at a time: the id of its first request, or 0. */
static uint8_t goes_out(uint32_t now_ms) {
    uint8_t wire[LAFET_WIRE_MAX];
    size_t length = lafet_session_transmit(&session, now_ms, wire, sizeof wire);
    lafet_decoder decoder;
    lafet_frame frame;
    bool complete = false;
    lafet_decoder_init(&decoder);
    if (length == 0 || lafet_decoder_push(&decoder, wire, length, &frame, &complete) != length) return 0;
    return complete && frame.size > 0 ? frame.payload[0] : 0;
}

/* The outcome after a frame with this answer. */
static lafet_outcome hears(uint8_t request, uint8_t subsystem, uint8_t status, const uint8_t *data, uint8_t size) {
    const lafet_record record = {request, subsystem, status, size, data};
    uint8_t payload[300], wire[LAFET_WIRE_MAX];
    size_t put = 0;
    lafet_frame frame;
    if (!lafet_record_put(payload, sizeof payload, &put, &record)) return LAFET_IDLE;
    size_t length = lafet_frame_encode(OWN, MONITOR, payload, put, wire, sizeof wire);
    for (size_t taken = 0; taken < length;)
        taken += lafet_session_receive(&session, wire + taken, length - taken, &frame);
    return lafet_session_outcome(&session);
}

static void a_stop_takes_the_place_of_what_waits(void) {
    static const uint8_t goal[2] = {44, 1};
    start();
    holds(ask(LAFET_REQUEST_MOVE, LAFET_SUBSYSTEM_VERTICAL, goal, 2), "Move is asked");
    holds(goes_out(0) == LAFET_REQUEST_MOVE, "Move goes out");
    holds(!ask(LAFET_REQUEST_GET_STATUS, LAFET_SUBSYSTEM_VERTICAL, NULL, 0), "a read waits");
    holds(ask(LAFET_REQUEST_STOP, LAFET_SUBSYSTEM_ALL, NULL, 0), "Stop does not wait");
    holds(goes_out(1) == LAFET_REQUEST_STOP, "Stop goes out at once");
    holds(hears(LAFET_REQUEST_MOVE, LAFET_SUBSYSTEM_VERTICAL, LAFET_STATUS_ACCEPTED, NULL, 0) == LAFET_WAITING,
          "the answer to Move is not that to Stop");
    holds(!ask(LAFET_REQUEST_STOP, LAFET_SUBSYSTEM_VERTICAL, NULL, 0), "Stop does not replace Stop");
    holds(hears(LAFET_REQUEST_STOP, LAFET_SUBSYSTEM_VERTICAL, LAFET_STATUS_OK, NULL, 0) == LAFET_ANSWERED,
          "Stop is answered");
    holds(ask(LAFET_REQUEST_MOVE, LAFET_SUBSYSTEM_VERTICAL, goal, 2), "then Move is asked again");
    lafet_session_cancel(&session);
    holds(goes_out(2) == 0 && lafet_session_outcome(&session) == LAFET_IDLE, "it was given up");
    lafet_session_cancel(NULL);
}

static void only_what_may_be_repeated_is(void) {
    static const uint8_t goal[2] = {44, 1};
    start();
    holds(ask(LAFET_REQUEST_MOVE, LAFET_SUBSYSTEM_VERTICAL, goal, 2), "Move is asked");
    holds(goes_out(0) == LAFET_REQUEST_MOVE, "Move goes out");
    holds(goes_out(TIMEOUT_MS) == 0, "Move is not repeated");
    holds(lafet_session_outcome(&session) == LAFET_SILENCE, "its silence is reported");
    holds(ask(LAFET_REQUEST_STOP, LAFET_SUBSYSTEM_ALL, NULL, 0), "Stop is asked");
    for (uint32_t i = 0; i < TRIES; i++)
        holds(goes_out(10000 + i * TIMEOUT_MS) == LAFET_REQUEST_STOP, "Stop is repeated");
    holds(goes_out(10000 + TRIES * TIMEOUT_MS) == 0, "for a time");
    holds(lafet_session_outcome(&session) == LAFET_SILENCE, "then its silence is reported");
}

static void an_answer_belongs_to_its_request(void) {
    static const uint8_t min[2] = {1, 2}, max_value[6] = {1, 3, 7, 0, 0, 0}, min_value[6] = {1, 2, 7, 0, 0, 0};
    start();
    holds(ask(LAFET_REQUEST_GET_PARAM, LAFET_SUBSYSTEM_VERTICAL, min, 2), "a parameter is asked");
    holds(goes_out(0) == LAFET_REQUEST_GET_PARAM, "it goes out");
    holds(hears(LAFET_REQUEST_GET_PARAM, LAFET_SUBSYSTEM_VERTICAL, LAFET_STATUS_OK, max_value, 6) == LAFET_WAITING,
          "another parameter is no answer");
    holds(hears(LAFET_REQUEST_GET_PARAM, LAFET_SUBSYSTEM_HORIZONTAL, LAFET_STATUS_OK, min_value, 6) == LAFET_WAITING,
          "another drive does not answer");
    holds(hears(LAFET_REQUEST_GET_PARAM, LAFET_SUBSYSTEM_VERTICAL, LAFET_STATUS_OK, min_value, 6) == LAFET_ANSWERED,
          "the parameter is");
    holds(ask(LAFET_REQUEST_OPEN, LAFET_SUBSYSTEM_VALVE1, NULL, 0), "Open is asked");
    holds(goes_out(1) == LAFET_REQUEST_OPEN, "it goes out");
    holds(hears(LAFET_REQUEST_OPEN, LAFET_SUBSYSTEM_VALVE2, LAFET_STATUS_DENIED, NULL, 0) == LAFET_WAITING,
          "another valve does not refuse for it");
    holds(hears(LAFET_REQUEST_OPEN, LAFET_SUBSYSTEM_DEPLOYER, LAFET_STATUS_DENIED, NULL, 0) == LAFET_ANSWERED,
          "the Deployer refuses in its stead");
}

static void too_little_room_is_no_wait(void) {
    uint8_t wire[4];
    start();
    holds(ask(LAFET_REQUEST_STOP, LAFET_SUBSYSTEM_ALL, NULL, 0), "Stop is asked");
    holds(lafet_session_transmit(&session, 0, wire, sizeof wire) == 0, "it does not fit");
    holds(lafet_session_outcome(&session) == LAFET_SILENCE, "which is reported");
}

int main(void) {
    a_stop_takes_the_place_of_what_waits();
    only_what_may_be_repeated_is();
    an_answer_belongs_to_its_request();
    too_little_room_is_no_wait();
    printf("session: %u do not hold\n", failed);
    return failed == 0 ? 0 : 1;
}
