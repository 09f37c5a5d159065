/* A controller: turns the barrel to 5 degrees of elevation and waits until it is there. */
#include "lafet.h"
#include "lafet_protocol.h"
#include "platform.h"

#define MONITOR 1
#define OWN 129
#define GOAL_ARCMIN 300
#define NEAR_ARCMIN 6
#define GIVE_UP_MS 20000u

static lafet_session session;

/* Asks and waits: the first record of the answer, or false. */
static bool ask(const lafet_record *request, lafet_record *answer) {
    static uint8_t line[LAFET_WIRE_MAX], bytes[64];
    uint8_t payload[16];
    size_t size = 0;
    if (!lafet_record_put(payload, sizeof payload, &size, request)) return false;
    if (!lafet_session_ask(&session, payload, size)) return false;
    for (;;) {
        size_t sending = lafet_session_transmit(&session, platform_now_ms(), line, sizeof line);
        platform_send(line, sending);
        int got = platform_receive(bytes, sizeof bytes);
        if (got < 0) return false;
        for (size_t taken = 0; taken < (size_t)got;) {
            lafet_frame frame;
            taken += lafet_session_receive(&session, bytes + taken, (size_t)got - taken, &frame);
            lafet_outcome outcome = lafet_session_outcome(&session);
            if (outcome == LAFET_ANSWERED)
                return lafet_record_next(&frame.payload, &frame.size, answer);
            if (outcome == LAFET_SILENCE) return false;
        }
        if (got == 0 && lafet_session_outcome(&session) == LAFET_SILENCE) return false;
    }
}

/* Says why it ends, and does not leave the barrel moving. */
static int give_up(const char *text, long number) {
    const lafet_record stop = {LAFET_REQUEST_STOP, LAFET_SUBSYSTEM_VERTICAL, 0, 0, NULL};
    lafet_record answer;
    platform_say(text, number);
    if (!ask(&stop, &answer) || answer.status > LAFET_STATUS_ACCEPTED) platform_say("Stop is not confirmed", 0);
    return 1;
}

int main(void) {
    static const uint8_t goal[2] = {GOAL_ARCMIN & 0xFF, GOAL_ARCMIN >> 8};
    const lafet_record move = {LAFET_REQUEST_MOVE, LAFET_SUBSYSTEM_VERTICAL, 0, 2, goal};
    const lafet_record look = {LAFET_REQUEST_GET_STATUS, LAFET_SUBSYSTEM_VERTICAL, 0, 0, NULL};
    lafet_record answer = {0};
    uint32_t start = platform_now_ms();

    lafet_session_init(&session, MONITOR, OWN, 1000, 3);
    if (!ask(&move, &answer)) return give_up("Move is not confirmed", 0);
    if (answer.status > LAFET_STATUS_ACCEPTED) return give_up("Move was refused:", answer.status);
    while (platform_now_ms() - start < GIVE_UP_MS) {
        lafet_state state;
        if (!ask(&look, &answer) || !lafet_state_read(&answer, &state))
            return give_up("no state, status", answer.status);
        if (state.position > GOAL_ARCMIN - NEAR_ARCMIN && state.position < GOAL_ARCMIN + NEAR_ARCMIN &&
            state.speed == 0) {
            platform_say("there, arc-minutes:", state.position);
            return 0;
        }
    }
    return give_up("not there after milliseconds:", GIVE_UP_MS);
}
