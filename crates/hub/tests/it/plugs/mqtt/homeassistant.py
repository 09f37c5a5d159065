"""Whether a discovery message is one for Home Assistant: the keys of its documentation of MQTT, checked by voluptuous,
and its templates, rendered by Jinja, which are what it uses itself. Reads the message and states, a line each."""

import json
import sys

import jinja2
import voluptuous as vol

AVAILABILITY = {
    vol.Optional("availability"): [
        {
            vol.Required("topic"): str,
            vol.Optional("value_template"): str,
            vol.Optional("payload_available"): str,
            vol.Optional("payload_not_available"): str,
        }
    ],
    vol.Optional("availability_mode"): vol.In(["all", "any", "latest"]),
}
ENTITY = AVAILABILITY | {vol.Required("unique_id"): str, vol.Required("name"): str}
UNITS = {"pressure": ["Pa", "kPa", "bar", "psi"], "volume_flow_rate": ["L/min", "L/s", "m³/h"], "distance": ["mm", "m"]}


def unit_of_class(sensor):
    units = UNITS.get(sensor.get("device_class"))
    if units and sensor.get("unit_of_measurement") not in units:
        raise vol.Invalid("a unit that is not one of its class")
    return sensor


PLATFORMS = {
    "sensor": vol.All(
        vol.Schema(
            ENTITY
            | {
                vol.Required("platform"): "sensor",
                vol.Required("state_topic"): str,
                vol.Required("value_template"): str,
                vol.Optional("unit_of_measurement"): str,
                vol.Optional("device_class"): vol.In(list(UNITS)),
                vol.Optional("state_class"): vol.In(["measurement", "total", "total_increasing"]),
            }
        ),
        unit_of_class,
    ),
    "binary_sensor": vol.Schema(
        ENTITY
        | {
            vol.Required("platform"): "binary_sensor",
            vol.Required("state_topic"): str,
            vol.Optional("value_template"): str,
            vol.Optional("payload_on"): str,
            vol.Optional("payload_off"): str,
            vol.Optional("device_class"): vol.In(["connectivity", "problem", "running", "safety", "smoke"]),
        }
    ),
    "button": vol.Schema(
        ENTITY
        | {
            vol.Required("platform"): "button",
            vol.Required("command_topic"): str,
            vol.Optional("payload_press"): str,
            vol.Optional("retain"): bool,
        }
    ),
}
DEVICE = vol.Schema(
    AVAILABILITY
    | {
        vol.Required("device"): {
            vol.Required("identifiers"): [str],
            vol.Optional("name"): str,
            vol.Optional("manufacturer"): str,
            vol.Optional("model"): str,
        },
        vol.Required("origin"): {vol.Required("name"): str, vol.Optional("sw_version"): str},
        vol.Required("components"): {str: dict},
        vol.Optional("qos"): vol.In([0, 1, 2]),
    }
)

TEMPLATES = jinja2.Environment(undefined=jinja2.StrictUndefined)
message, *states = [json.loads(line) for line in sys.stdin]
DEVICE(message)
for key, component in message["components"].items():
    PLATFORMS[component["platform"]](component)
    print("component", key, component["platform"])
for state in states:
    for key, component in message["components"].items():
        if component.get("state_topic", "").endswith("/state"):
            value = TEMPLATES.from_string(component["value_template"]).render(value_json=state)
            print("value", state["quality"], key, value)
for online in [True, False]:
    template = message["components"]["stop"]["availability"][0]["value_template"]
    print("hub", TEMPLATES.from_string(template).render(value_json={"online": online}))
