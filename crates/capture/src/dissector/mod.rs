//! A dissector for Wireshark and tshark in Lua, generated from the protocol dictionary.

use std::fmt::Write;

use lafet_proto::bus::{PORT_EXTERNAL_CONN, PORT_RADIO};
use lafet_proto::dictionary::layouts::{Field, Kind, Layout, of_answer, of_request};
use lafet_proto::dictionary::{Key, REQUESTS, STATUSES, SUBSYSTEMS};
use lafet_proto::flags::{ButtonState, FlagClass, FlagInfo, flags_of};
use lafet_proto::id::{Status, SubsystemId, key};
use lafet_proto::param::{Param, Unit};
use lafet_proto::{ParamId, RequestId};
use lafet_texts::{Text, capture as text};

/// Language of names and explanations; identifiers stay as on the wire.
pub use lafet_texts::Lang as Language;

/// The source of the dissector: save it where Wireshark looks for plugins, or pass it to `-X
/// lua_script:`.
pub fn lua(language: Language) -> String {
    let tables = Tables { language, text: String::new() };
    let mut text = String::from(
        "-- Dissector of the protocol of robotic fire monitors, made by `lafet dissector`.\n\
         -- Do not edit; generate it again.\n\n",
    );
    text += &tables.write();
    text.push('\n');
    text + include_str!("body.lua")
}

/// Texts of the dissector itself: their names in Lua.
const TEXTS: [(&str, &dyn Text); 22] = [
    ("protocol", &text::Protocol),
    ("protocol_records", &text::ProtocolRecords),
    ("tcp_ports", &text::TcpPorts),
    ("udp_ports", &text::UdpPorts),
    ("dst", &text::Dst),
    ("src", &text::Src),
    ("kind", &text::Kind),
    ("probe", &text::Probe),
    ("request", &text::Request),
    ("answer", &text::Answer),
    ("noise", &text::Noise),
    ("record", &text::Record),
    ("device", &text::Device),
    ("status", &text::Status),
    ("size", &text::Size),
    ("data", &text::Data),
    ("bad_crc", &text::BadCrc),
    ("bad_escape", &text::BadEscape),
    ("cut", &text::Cut),
    ("unescaped", &text::Unescaped),
    ("shape", &text::Shape),
    ("refused", &text::Refused),
];

struct Tables {
    language: Language,
    text: String,
}

impl Tables {
    fn write(mut self) -> String {
        self.texts();
        self.ids();
        self.flags();
        self.layouts();
        self.text
    }

    fn say(&self, text: Key) -> &'static str {
        lafet_texts::dictionary(text).str(self.language)
    }

    fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    fn texts(&mut self) {
        self.line("local T = {");
        for (key, text) in TEXTS {
            let text = quoted(&text.of(self.language));
            self.line(&format!("  {key} = {text},"));
        }
        self.line("}");
    }

    /// A Lua table from numbers to names.
    fn names<'a>(&mut self, name: &str, of: impl Iterator<Item = (u32, &'a str)>) {
        let pairs: Vec<String> =
            of.map(|(value, name)| format!("[{value:#x}] = {}", quoted(name))).collect();
        self.line(&format!("local {name} = {{ {} }}", pairs.join(", ")));
    }

    fn ids(&mut self) {
        let ports = quoted(&format!("{PORT_EXTERNAL_CONN}-{PORT_RADIO}"));
        self.line(&format!("local PORTS = {ports}"));
        self.names("SUBSYSTEMS", SUBSYSTEMS.iter().map(|info| (info.id.0.into(), info.name)));
        self.names("REQUESTS", REQUESTS.iter().map(|info| (info.id.0.into(), info.name)));
        self.names("STATUSES", STATUSES.iter().map(|info| (info.status.0.into(), info.name)));
        let refusals = STATUSES.iter().filter(|info| !info.status.is_success());
        let refusals = refusals.filter(|info| !is_progress(info.status));
        self.names("REFUSALS", refusals.map(|info| (info.status.0.into(), info.name)));
        self.names("PARAMS", params());
        let keys = [
            (key::OPEN, "Open"),
            (key::CLOSE, "Close"),
            (key::CLEAN_FLASH, "CleanFlash"),
            (key::ENABLE, "Enable"),
            (key::DISABLE, "Disable"),
        ];
        self.names("KEYS", keys.into_iter().map(|(value, name)| (value.into(), name)));
        let states = ButtonState::ALL.map(|state| (state as u32, self.say(state.text())));
        self.names("BUTTON_STATES", states.into_iter());
        self.line(&format!("local GET_STATUS = {:#x}", RequestId::GET_STATUS.0));
        self.line(&format!("local ACCESS_GRANTED = {:#x}", RequestId::ACCESS_GRANTED.0));
    }

    fn flags(&mut self) {
        let classes = SubsystemId::TABLE.iter().map(|id| (u32::from(id.0), flags_of(*id).name));
        self.names("CLASSES", classes);
        self.line("local FLAGS = {");
        let mut done: Vec<&str> = Vec::new();
        for class in SubsystemId::TABLE.iter().map(|id| flags_of(*id)) {
            if !done.contains(&class.name) {
                done.push(class.name);
                self.class(class);
            }
        }
        self.line("}");
    }

    fn class(&mut self, class: &FlagClass) {
        self.line(&format!("  {} = {{ abbr = {},", class.name, quoted(&snake(class.name))));
        for flag in class.flags {
            let FlagInfo { name, width, meaning, .. } = flag;
            let (abbr, mask) = (snake(name), flag.mask());
            let text = quoted(self.say(*meaning));
            self.line(&format!(
                "    {{ name = \"{name}\", abbr = \"{abbr}\", width = {width}, mask = {mask:#x}, \
                 text = {text} }},"
            ));
        }
        self.line("  },");
    }

    fn layouts(&mut self) {
        let mut all: Vec<&'static Layout> = Vec::new();
        let data = REQUESTS.iter().map(|info| (info.id, of_request(info.id)));
        let answers = REQUESTS
            .iter()
            .filter(|info| info.id != RequestId::GET_STATUS)
            .map(|info| (info.id, of_answer(info.id, SubsystemId::GENERAL)));
        let states =
            SubsystemId::TABLE.iter().map(|id| (*id, of_answer(RequestId::GET_STATUS, *id)));
        let mut lists = Vec::new();
        for (table, number, layouts) in (data.map(|(id, layouts)| ("DATA", id.0, layouts)))
            .chain(answers.map(|(id, layouts)| ("ANSWERS", id.0, layouts)))
            .chain(states.map(|(id, layouts)| ("STATES", id.0, layouts)))
        {
            for layout in layouts {
                if !all.iter().any(|known| known.name == layout.name) {
                    all.push(layout);
                }
            }
            lists.push((table, number, layouts));
        }
        self.line("local LAYOUTS = {");
        for layout in all {
            self.layout(layout);
        }
        self.line("}");
        for name in ["DATA", "ANSWERS", "STATES"] {
            self.line(&format!("local {name} = {{"));
            for (_, number, layouts) in
                lists.iter().filter(|(table, _, layouts)| *table == name && !layouts.is_empty())
            {
                let names: Vec<String> = layouts.iter().map(|layout| quoted(layout.name)).collect();
                self.line(&format!("  [{number:#x}] = {{ {} }},", names.join(", ")));
            }
            self.line("}");
        }
    }

    fn layout(&mut self, layout: &Layout) {
        let prefix: String = layout.prefix.iter().map(|byte| format!("\\x{byte:02x}")).collect();
        let (least, most) = layout.times;
        let most = most.min(usize::from(u16::MAX));
        let name = layout.name;
        let abbr = quoted(&snake(name));
        self.line(&format!(
            "  {name} = {{ name = \"{name}\", abbr = {abbr}, prefix = \"{prefix}\","
        ));
        self.line(&format!("    least = {least}, most = {most},"));
        for (name, fields) in [("fields", layout.fields), ("repeated", layout.repeated)] {
            self.line(&format!("    {name} = {{"));
            for field in fields {
                self.field(field);
            }
            self.line("    },");
        }
        self.line("  },");
    }

    fn field(&mut self, field: &Field) {
        let Field { name, kind, unit, text, .. } = field;
        let mut line = format!("      {{ name = \"{name}\", kind = \"{kind:?}\"");
        let text = quoted(self.say(*text));
        let shown = unit.name().map_or("", |unit| self.say(unit));
        // Writing to a String cannot fail.
        let _ = write!(line, ", text = {text}");
        if *unit == Unit::Bits && !matches!(kind, Kind::Flags | Kind::Key) {
            line += ", bits = true";
        }
        if !shown.is_empty() {
            let _ = write!(line, ", unit = {}", quoted(shown));
        }
        self.line(&format!("{line} }},"));
    }
}

/// Whether a status is neither success nor a refusal: the value will follow.
const fn is_progress(status: Status) -> bool {
    matches!(status, Status::NOT_CACHED | Status::CACHED)
}

/// Identifiers of parameters, each once: subsystems share names and with them identifiers.
fn params() -> impl Iterator<Item = (u32, &'static str)> {
    let mut all: Vec<(u32, &'static str)> =
        Param::ALL.into_iter().map(|param| (param.spec().id.0.into(), param.name())).collect();
    all.push((ParamId::HOTBEDS.0.into(), "Hotbeds"));
    all.sort_unstable();
    all.dedup();
    all.into_iter()
}

/// `DriveStatus` to `drive_status`, the form of Wireshark's field names.
fn snake(name: &str) -> String {
    let mut snake = String::new();
    for (i, letter) in name.chars().enumerate() {
        if letter.is_ascii_uppercase() && i > 0 {
            snake.push('_');
        }
        snake.push(letter.to_ascii_lowercase());
    }
    snake
}

/// A Lua string literal.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}
