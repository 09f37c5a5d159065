//! Errors of a URL, in English and Russian.

use std::fmt;

use crate::error::Lang;

/// Error of a monitor's URL.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum UrlError {
    /// Not a URL.
    Syntax {
        /// The URL as given.
        url: String,
        /// The error of the parser.
        reason: String,
    },
    /// A scheme other than tcp, udp, serial or sim.
    Scheme {
        /// The URL as given.
        url: String,
        /// The scheme of the URL.
        scheme: String,
    },
    /// No host or device to connect to.
    Nowhere {
        /// The URL as given.
        url: String,
        /// The scheme of the URL.
        scheme: &'static str,
    },
    /// A part that this scheme does not have: user, path, fragment…
    Part {
        /// The URL as given.
        url: String,
        /// The part of the URL.
        part: String,
    },
    /// An option that this scheme does not have.
    Option {
        /// The name of the option.
        key: String,
        /// The options of the scheme.
        known: &'static [&'static str],
    },
    /// An option given twice.
    Twice {
        /// The name of the option.
        key: String,
    },
    /// An invalid value of an option or the port.
    Value {
        /// The name of the option.
        key: String,
        /// The value as given.
        value: String,
        /// The valid values.
        allowed: &'static str,
    },
}

impl UrlError {
    /// The message in a language.
    pub fn localized(&self, lang: Lang) -> String {
        match lang {
            Lang::En => self.english(),
            Lang::Ru => self.russian(),
        }
    }

    fn english(&self) -> String {
        match self {
            Self::Syntax { url, reason } => {
                format!("`{url}` is not a URL: {reason}. Write it like {EXAMPLE}.")
            }
            Self::Scheme { url, scheme } => format!(
                "`{url}`: `{scheme}:` is no way to reach a monitor. Use tcp://, udp://, serial:// \
                 or sim:, like {EXAMPLE}."
            ),
            Self::Nowhere { url, scheme } => {
                format!("`{url}` does not say where to connect. Write it like {}.", example(scheme))
            }
            Self::Part { url, part } => {
                format!("`{url}`: `{part}` has no meaning here. Leave it out.")
            }
            Self::Option { key, known } => {
                format!("There is no option `{key}` here. Those there are: {}.", known.join(", "))
            }
            Self::Twice { key } => format!("The option `{key}` is given twice. Leave one."),
            Self::Value { key, value, allowed } => {
                format!("`{key}={value}`: {key} must be {allowed}.")
            }
        }
    }

    fn russian(&self) -> String {
        match self {
            Self::Syntax { url, reason } => {
                format!("`{url}` — не адрес URL ({reason}). Напишите, например, {EXAMPLE}.")
            }
            Self::Scheme { url, scheme } => format!(
                "`{url}`: по `{scheme}:` ствол недоступен. Используйте tcp://, udp://, serial:// \
                 или sim:, например {EXAMPLE}."
            ),
            Self::Nowhere { url, scheme } => {
                format!("`{url}`: не указано, куда подключаться. Пример: {}.", example(scheme))
            }
            Self::Part { url, part } => {
                format!("`{url}`: часть `{part}` здесь не имеет смысла. Уберите её.")
            }
            Self::Option { key, known } => {
                format!("Параметра `{key}` здесь нет. Возможные: {}.", known.join(", "))
            }
            Self::Twice { key } => format!("Параметр `{key}` указан дважды. Оставьте один."),
            Self::Value { key, value, allowed } => {
                format!("`{key}={value}`: допустимо {}.", allowed_ru(allowed))
            }
        }
    }
}

impl fmt::Display for UrlError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.english())
    }
}

impl std::error::Error for UrlError {}

const EXAMPLE: &str = "tcp://192.168.1.50:10485?addr=1";
pub const MONITOR_ADDRESSES: &str = "an address of a monitor, 1…127";
pub const SOURCE_ADDRESSES: &str = "the controller's address 128 or a console's, 129…254";
pub const BAUDS: &str = "a speed of the line, 300…4000000 (19200 is usual)";
pub const FRAMINGS: &str = "link or records";
pub const PORTS: &str = "a number, 1…65535";
pub const RS485: &str = "off, rts or rts-low";
pub const ECHOES: &str = "off, strip or verify";
pub const DELAYS: &str = "a time in milliseconds, 0…1000";
pub const CHECKS: &str = "crc16, auto or crc32c";
pub const ROLES: &str = "direct or active";
pub const CONSOLE_ADDRESSES: &str = "a console's address, 129…254, with role=active";
pub const LATES: &str = "a time in whole seconds, 0…60";
pub const SHARED: &str = "0 or 1";
pub const SWITCH: &str = "on or off";
pub const WITH_RS485: &str = "left out unless rs485=rts or rs485=rts-low is given";

fn allowed_ru(allowed: &'static str) -> &'static str {
    match allowed {
        MONITOR_ADDRESSES => "адрес ствола, 1…127",
        SOURCE_ADDRESSES => "адрес контроллера 128 или пульта, 129…254",
        BAUDS => "скорость линии, 300…4000000 (обычно 19200)",
        FRAMINGS => "link или records",
        PORTS => "число, 1…65535",
        RS485 => "off, rts или rts-low",
        ECHOES => "off, strip или verify",
        DELAYS => "время в миллисекундах, 0…1000",
        CHECKS => "crc16, auto или crc32c",
        ROLES => "direct или active",
        CONSOLE_ADDRESSES => "адрес пульта, 129…254, вместе с role=active",
        LATES => "время в целых секундах, 0…60",
        SHARED => "0 или 1",
        SWITCH => "on или off",
        WITH_RS485 => "только вместе с rs485=rts или rs485=rts-low",
        other => other,
    }
}

fn example(scheme: &str) -> &'static str {
    match scheme {
        "udp" => "udp://192.168.1.50:10485?addr=1",
        "serial" => "serial:///dev/ttyUSB0?baud=19200&addr=1",
        _ => EXAMPLE,
    }
}
