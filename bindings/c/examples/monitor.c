/* A monitor: lafet's device core, and the simplest hardware there is: drives that run as they are
 * asked to, valves that open and close in a second. */
#include <string.h>

#include "lafet.h"
#include "platform.h"

#define ADDRESS 1
#define STEP_MS 10u
#define VALUES 64
#define VALVE_MS 1000

/* The memory of a monitor: a few values, lost with the power. On a chip: its flash. */
static struct {
    uint16_t key;
    uint16_t size;
    uint8_t bytes[264];
} values[VALUES];

/* What there is to sense, and to drive. */
static struct {
    int32_t position_milli[4];
    int32_t valve_ms[2];
    lafet_outputs outputs;
} plant;

static void sense(void *context, lafet_inputs *inputs) {
    (void)context;
    for (int i = 0; i < 4; i++) {
        inputs->drives[i].position = plant.position_milli[i] / 1000;
        inputs->drives[i].speed_tenths = plant.outputs.speeds_tenths[i];
    }
    for (int i = 0; i < 2; i++) {
        inputs->valves[i].open_switch = plant.valve_ms[i] >= VALVE_MS;
        inputs->valves[i].close_switch = plant.valve_ms[i] <= 0;
    }
    for (int i = 0; i < 5; i++) inputs->temperatures_dc[i] = 200;
    inputs->humidity_percent = 40;
    inputs->main_voltage_dv = 240;
    inputs->pressure_ua = 12000;
    inputs->detector_ready = true;
}

static void run(void *context, const lafet_outputs *outputs) {
    (void)context;
    plant.outputs = *outputs;
    for (int i = 0; i < 4; i++) {
        /* 0.1 degrees a second are 6 arc-minutes a second. */
        int32_t unit = i == 2 ? 100 : 6000;
        plant.position_milli[i] += outputs->speeds_tenths[i] * unit / 1000 * (int32_t)STEP_MS;
    }
    for (int i = 0; i < 2; i++) {
        int32_t moved = plant.valve_ms[i] + outputs->valves[i] * (int32_t)STEP_MS;
        plant.valve_ms[i] = moved < 0 ? 0 : moved > VALVE_MS ? VALVE_MS : moved;
    }
}

static bool restart;

static void reset(void *context) {
    (void)context;
    restart = true;
}

static intptr_t load(void *context, uint16_t key, uint8_t *buffer, size_t size) {
    (void)context;
    for (int i = 0; i < VALUES; i++) {
        if (values[i].size > 0 && values[i].key == key) {
            if (values[i].size > size) return -1;
            memcpy(buffer, values[i].bytes, values[i].size);
            return values[i].size;
        }
    }
    return 0;
}

static bool store(void *context, uint16_t key, const uint8_t *value, size_t size) {
    (void)context;
    int place = -1;
    for (int i = VALUES - 1; i >= 0; i--) {
        if (values[i].size == 0 && place < 0) place = i;
        if (values[i].size > 0 && values[i].key == key) {
            place = i;
            break;
        }
    }
    if (place < 0 || size == 0 || size > sizeof values[place].bytes) return false;
    values[place].key = key;
    values[place].size = (uint16_t)size;
    memcpy(values[place].bytes, value, size);
    return true;
}

static bool erase(void *context) {
    (void)context;
    memset(values, 0, sizeof values);
    return true;
}

int main(void) {
    static const lafet_hal hal = {
        .read = sense, .write = run, .reset = reset, .load = load, .store = store, .erase = erase};
    static lafet_device device;
    static lafet_port port;
    static uint8_t out[LAFET_WIRE_MAX];
    uint32_t last = platform_now_ms();

    lafet_port_init(&port, false);
    if (!lafet_device_provision(&hal, LAFET_REMOTE, ADDRESS)) return 1;
    if (!lafet_device_init(&device, last, LAFET_REMOTE, ADDRESS, &hal)) return 1;
    for (;;) {
        uint8_t bytes[64];
        int got = platform_receive(bytes, sizeof bytes);
        uint32_t now = platform_now_ms();
        if (got < 0) return 0;
        for (size_t taken = 0; taken < (size_t)got;) {
            size_t answer = 0;
            taken += lafet_port_receive(&port, now, &device, bytes + taken, (size_t)got - taken, out,
                                        sizeof out, &answer);
            platform_send(out, answer);
        }
        for (; now - last >= STEP_MS; last += STEP_MS) lafet_device_step(&device, last + STEP_MS, &hal);
        if (restart) {
            restart = false;
            if (!lafet_device_init(&device, now, LAFET_REMOTE, ADDRESS, &hal)) return 1;
        }
    }
}
