//! Discovery of Home Assistant: a device for each monitor, as its documentation of MQTT discovery has it. There are
//! values, and buttons that stop and close; nothing that moves or opens.

use serde_json::{Map, Value, json};

use super::BrokerConfig;

/// A value of a monitor: key, name, unit, class, template.
type Sensor =
    (&'static str, &'static str, Option<&'static str>, Option<&'static str>, &'static str);

/// Home Assistant has no decimal places of its own for these, so they come rounded.
const SENSORS: [Sensor; 6] = [
    ("pressure", "Pressure", Some("kPa"), Some("pressure"), "pressure_mpa * 1000"),
    ("flow", "Flow", Some("L/min"), Some("volume_flow_rate"), "flow_lps * 60"),
    ("traverse", "Traverse", Some("°"), None, "traverse"),
    ("elevation", "Elevation", Some("°"), None, "elevation"),
    ("nozzle", "Nozzle", Some("mm"), Some("distance"), "nozzle"),
    ("mode", "Mode", None, None, "mode"),
];

/// Key, name, class.
const BINARY: [(&str, &str, Option<&str>); 3] = [
    ("fire", "Fire", Some("safety")),
    ("water", "Water", Some("running")),
    ("locked_out", "Locked out", Some("problem")),
];

/// Topic of the discovery of a monitor.
pub fn topic(config: &BrokerConfig, id: &str) -> Option<String> {
    let prefix = config.homeassistant.as_ref()?;
    Some(format!("{prefix}/device/{}/config", device(config, id)))
}

fn device(config: &BrokerConfig, id: &str) -> String {
    format!("{}_{id}", node(&config.prefix))
}

/// Topic and text of the discovery of a monitor.
pub fn of_monitor(config: &BrokerConfig, at: usize) -> Option<(String, Value)> {
    let id = config.monitors.get(at)?;
    let topic = topic(config, id)?;
    let device = device(config, id);
    let hub = json!({
        "topic": config.topic("hub"),
        "value_template": "{{ 'online' if value_json.online else 'offline' }}",
    });
    let parts = Parts { config, at, device: &device, hub };
    let mut components = Map::new();
    for of_kind in [parts.sensors(), parts.binaries(), parts.connection(), parts.buttons()] {
        components.extend(of_kind.into_iter().map(|(key, it)| (key.to_owned(), it)));
    }
    let text = json!({
        "device": {
            "identifiers": [device],
            "name": format!("{} {id}", config.prefix),
            "manufacturer": "lafet",
            "model": "Fire monitor",
        },
        "origin": { "name": "lafet", "sw_version": env!("CARGO_PKG_VERSION") },
        "components": components,
        "qos": 1,
    });
    Some((topic, text))
}

/// What the components of a monitor are made of.
struct Parts<'a> {
    config: &'a BrokerConfig,
    at: usize,
    device: &'a str,
    /// Where the hub says that it is there.
    hub: Value,
}

type Components = Vec<(&'static str, Value)>;

impl Parts<'_> {
    fn topic(&self, part: &str) -> String {
        self.config.topic_of(Some(self.at), part)
    }

    fn id(&self, key: &str) -> String {
        format!("{}_{key}", self.device)
    }

    /// What shows the state: there is one while the monitor is heard.
    fn shown(&self, platform: &str, (key, name): (&str, &str), template: &str) -> Value {
        json!({
            "platform": platform,
            "name": name,
            "unique_id": self.id(key),
            "state_topic": self.topic("state"),
            "value_template": template,
            "availability": [self.hub, { "topic": self.topic("available") }],
            "availability_mode": "all",
        })
    }

    fn sensors(&self) -> Components {
        let one = |(key, name, unit, class, value): &(&'static str, &str, _, _, &str)| {
            let source = value.split(' ').next().unwrap_or_default();
            let number: Option<&str> = *unit;
            let shown = match number {
                Some(_) => format!("({value}) | round(2)"),
                None => source.to_owned(),
            };
            let shown = shown.replace(source, &format!("value_json.{source}"));
            let template =
                format!("{{{{ {shown} if value_json.{source} is not none else None }}}}");
            let mut component = self.shown("sensor", (key, name), &template);
            put(&mut component, "unit_of_measurement", number);
            put(&mut component, "device_class", *class);
            put(&mut component, "state_class", number.map(|_| "measurement"));
            (*key, component)
        };
        SENSORS.iter().map(one).collect()
    }

    fn binaries(&self) -> Components {
        let one = |(key, name, class): (&'static str, &str, Option<&str>)| {
            let value = format!("value_json.{key}");
            let template =
                format!("{{{{ 'None' if {value} is none else 'ON' if {value} else 'OFF' }}}}");
            let mut component = self.shown("binary_sensor", (key, name), &template);
            put(&mut component, "device_class", class);
            (key, component)
        };
        BINARY.into_iter().map(one).collect()
    }

    fn connection(&self) -> Components {
        let component = json!({
            "platform": "binary_sensor",
            "name": "Connection",
            "unique_id": self.id("connection"),
            "state_topic": self.topic("available"),
            "payload_on": "online",
            "payload_off": "offline",
            "device_class": "connectivity",
            "availability": [self.hub],
            "availability_mode": "all",
        });
        vec![("connection", component)]
    }

    /// Also of a monitor that is not heard: the hub sends them as soon as it can.
    fn buttons(&self) -> Components {
        let one = |(key, name, press): (&'static str, &str, &str)| {
            let component = json!({
                "platform": "button",
                "name": name,
                "unique_id": self.id(key),
                "command_topic": self.topic("command"),
                "payload_press": press,
                "retain": false,
                "availability": [self.hub],
                "availability_mode": "all",
            });
            (key, component)
        };
        let stop = ("stop", "Stop", r#"{"command":"stop"}"#);
        [stop, ("close", "Close", r#"{"command":"close"}"#)].into_iter().map(one).collect()
    }
}

/// Where Home Assistant says that it has started.
pub fn birth(config: &BrokerConfig) -> Option<String> {
    config.homeassistant.as_ref().map(|prefix| format!("{prefix}/status"))
}

/// A name of Home Assistant: letters, digits, _ and -.
fn node(prefix: &str) -> String {
    let fine = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
    prefix.chars().map(fine).collect()
}

fn put(component: &mut Value, key: &str, value: Option<&str>) {
    if let (Some(value), Some(fields)) = (value, component.as_object_mut()) {
        fields.insert(key.to_owned(), json!(value));
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::Config;

    fn discovery() -> (String, Value) {
        let text = "[[monitor]]\nid = \"M1\"\nurl = \"tcp://h?addr=1\"\n[[mqtt]]\nname = \"site\"\n\
                    url = \"mqtt://127.0.0.1\"\nprefix = \"plant/fire\"\nrole = \"operator\"\n\
                    homeassistant = \"homeassistant\"\n";
        let read = Config::parse(
            "hub.toml",
            text,
            std::path::Path::new("/"),
            &crate::Overrides::default(),
        );
        of_monitor(&read.unwrap().mqtt[0], 0).unwrap()
    }

    #[test]
    fn a_device_has_values_and_two_buttons() {
        let (topic, text) = discovery();
        assert_eq!(topic, "homeassistant/device/plant_fire_M1/config");
        let components = text["components"].as_object().unwrap();
        let of = |platform: &str| -> BTreeSet<String> {
            let own = components.iter().filter(|it| it.1["platform"] == platform);
            own.map(|it| it.0.clone()).collect()
        };
        assert_eq!(of("button"), ["close", "stop"].map(str::to_owned).into());
        assert_eq!(of("sensor").len() + of("binary_sensor").len() + 2, components.len());
        let press = |key: &str| components[key]["payload_press"].as_str().unwrap().to_owned();
        for key in ["stop", "close"] {
            let asked = super::super::message::read(press(key).as_bytes());
            assert!(asked.command.is_some_and(|it| it.is_urgent() && it.name() == key));
            assert!(asked.what.is_ok());
        }
        let pressure = components["pressure"]["value_template"].as_str().unwrap();
        assert_eq!(
            pressure,
            "{{ (value_json.pressure_mpa * 1000) | round(2) if value_json.pressure_mpa is not none \
             else None }}"
        );
    }

    /// The only texts that Home Assistant can send are those of the buttons.
    #[test]
    fn nothing_that_moves_or_opens_is_offered() {
        let (_, text) = discovery();
        for (key, component) in text["components"].as_object().unwrap() {
            let commands = component.get("command_topic").is_some();
            assert_eq!(commands, component["platform"] == "button", "{key}");
        }
        let written = text.to_string();
        for word in ["open\\\"", "goto", "take", "deploy", "lockout\\\"", "key\\\"", "ticket"] {
            assert!(!written.contains(word), "{word}");
        }
    }
}
