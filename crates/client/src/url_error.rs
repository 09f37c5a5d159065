//! Errors of a URL.

use std::fmt;

use lafet_texts::{Argument, Fixed, Lang, Text, client as text};

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
        allowed: Fixed,
    },
}

impl UrlError {
    /// The message in a language.
    pub fn localized(&self, lang: Lang) -> String {
        self.of(lang)
    }
}

impl Argument for UrlError {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        match self {
            Self::Syntax { url, reason } => {
                let reason = said(reason, lang);
                text::UrlSyntax { url, reason, example: EXAMPLE }.write(lang, out)
            }
            Self::Scheme { url, scheme } => {
                text::UrlScheme { url, scheme, example: EXAMPLE }.write(lang, out)
            }
            Self::Nowhere { url, scheme } => {
                text::UrlNowhere { url, example: example(scheme) }.write(lang, out)
            }
            Self::Part { url, part } => text::UrlPart { url, part }.write(lang, out),
            Self::Option { key, known } => {
                text::UrlOption { key, known: known.join(", ") }.write(lang, out)
            }
            Self::Twice { key } => text::UrlTwice { key }.write(lang, out),
            Self::Value { key, value, allowed } => {
                text::UrlValue { key, value, allowed }.write(lang, out)
            }
        }
    }
}

impl Text for UrlError {}

impl fmt::Display for UrlError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(Lang::En, f)
    }
}

impl std::error::Error for UrlError {}

/// What the parser of URLs says, whose own words are English.
fn said(reason: &str, lang: Lang) -> &str {
    if lang == Lang::En {
        return reason;
    }
    match reason {
        "empty host" => text::UrlNoHost.str(lang),
        "invalid international domain name" | "invalid domain character" => {
            text::UrlHostSign.str(lang)
        }
        "invalid IPv4 address" => text::UrlIpv4.str(lang),
        "invalid IPv6 address" => text::UrlIpv6.str(lang),
        "relative URL without a base" => text::UrlNoScheme.str(lang),
        other => other,
    }
}

const EXAMPLE: &str = "tcp://192.168.1.50:10485?addr=1";

fn example(scheme: &str) -> &'static str {
    match scheme {
        "udp" => "udp://192.168.1.50:10485?addr=1",
        "serial" => "serial:///dev/ttyUSB0?baud=19200&addr=1",
        _ => EXAMPLE,
    }
}
