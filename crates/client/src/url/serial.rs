//! Properties of a serial line: speed, direction of an RS-485 transceiver, echo.

use std::fmt;
use std::time::Duration;

use lafet_proto::bus;
use lafet_texts::{Fixed, client as text};

use super::{Echo, Options, UrlError};

/// The options of `serial:` URLs.
pub const OPTIONS: [&str; 14] = [
    "addr",
    "src",
    "baud",
    "rs485",
    "rts_before",
    "rts_after",
    "terminate",
    "echo",
    "turnaround",
    "check",
    "role",
    "late",
    "shared",
    "insist",
];

/// The greatest delay, ms; greater values are rejected as errors of the user.
const DELAY_MS_MAX: u64 = 1000;

/// A serial line, 8N1 (observed).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SerialLine {
    /// Speed of the line, baud, `baud=`.
    pub baud: u32,
    /// Switching of an RS-485 transceiver's direction by the kernel, `rs485=`. Adapters that switch
    /// by themselves, as most on USB do, need none.
    pub rs485: Option<Rs485>,
    /// Handling of sent bytes that come back, `echo=`.
    pub echo: Echo,
    /// Pause between the last received byte and a frame, `turnaround=` ms: the other side needs it
    /// to release the line.
    pub turnaround: Duration,
    /// Whether other programs may open the port too, if they also share it, `shared=1`.
    pub shared: bool,
    /// Whether requests are sent beside bytes that are no frames, and beside a bus controller,
    /// `insist=1`.
    pub insist: bool,
}

impl Default for SerialLine {
    fn default() -> Self {
        Self {
            baud: bus::BAUD_DEFAULT,
            rs485: None,
            echo: Echo::Off,
            turnaround: Duration::from_millis(1),
            shared: false,
            insist: false,
        }
    }
}

/// How the kernel switches a transceiver (Linux, if the port's driver supports it).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rs485 {
    /// RTS is low instead of high while bytes are sent: `rs485=rts-low`.
    pub low: bool,
    /// Delay between switching and the first byte, `rts_before=` ms.
    pub before: Duration,
    /// Delay between the last byte and switching back, `rts_after=` ms.
    pub after: Duration,
    /// Switches on the terminating resistor, if the port has one, `terminate=on`.
    pub terminate: bool,
}

impl SerialLine {
    pub(super) fn read(options: &mut Options) -> Result<Self, UrlError> {
        let default = Self::default();
        let baud =
            options.number("baud", default.baud, 300..=4_000_000, text::AllowedBaud.fixed())?;
        let rs485 = Rs485::read(options)?;
        let echo =
            options.one_of("echo", Echo::NAMES, text::AllowedEcho.fixed())?.unwrap_or_default();
        let turnaround = options.delay("turnaround")?.unwrap_or(default.turnaround);
        let shared = options.yes("shared")?.unwrap_or(default.shared);
        let insist = options.yes("insist")?.unwrap_or(default.insist);
        Ok(Self { baud, rs485, echo, turnaround, shared, insist })
    }

    /// Writes the options that differ from the defaults, except the speed.
    pub(super) fn write(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(Rs485 { low, before, after, terminate }) = self.rs485 {
            write!(f, "&rs485={}", if low { "rts-low" } else { "rts" })?;
            for (key, delay) in [("rts_before", before), ("rts_after", after)] {
                if !delay.is_zero() {
                    write!(f, "&{key}={}", delay.as_millis())?;
                }
            }
            f.write_str(if terminate { "&terminate=on" } else { "" })?;
        }
        if self.echo != Echo::Off {
            let name = Echo::NAMES.iter().find(|(_, echo)| *echo == self.echo);
            write!(f, "&echo={}", name.map_or("off", |(name, _)| name))?;
        }
        if self.turnaround != Self::default().turnaround {
            write!(f, "&turnaround={}", self.turnaround.as_millis())?;
        }
        f.write_str(if self.shared { "&shared=1" } else { "" })?;
        f.write_str(if self.insist { "&insist=1" } else { "" })
    }
}

impl Rs485 {
    fn read(options: &mut Options) -> Result<Option<Self>, UrlError> {
        let modes = &[("off", None), ("rts", Some(false)), ("rts-low", Some(true))];
        let Some(low) = options.one_of("rs485", modes, text::AllowedRs485.fixed())?.flatten()
        else {
            let stray = ["rts_before", "rts_after", "terminate"];
            let stray = stray.into_iter().find_map(|key| Some((key, options.take(key)?)));
            return match stray {
                None => Ok(None),
                Some((key, value)) => Err(UrlError::Value {
                    key: key.into(),
                    value,
                    allowed: text::AllowedWithRs485.fixed(),
                }),
            };
        };
        let switch = &[("on", true), ("off", false)];
        Ok(Some(Self {
            low,
            before: options.delay("rts_before")?.unwrap_or_default(),
            after: options.delay("rts_after")?.unwrap_or_default(),
            terminate: options
                .one_of("terminate", switch, text::AllowedSwitch.fixed())?
                .unwrap_or(false),
        }))
    }
}

impl Echo {
    const NAMES: &[(&str, Self)] =
        &[("off", Self::Off), ("strip", Self::Strip), ("verify", Self::Verify)];
}

impl Options {
    pub(super) fn one_of<T: Copy>(
        &mut self,
        key: &str,
        names: &[(&str, T)],
        allowed: Fixed,
    ) -> Result<Option<T>, UrlError> {
        let Some(value) = self.take(key) else { return Ok(None) };
        match names.iter().find(|(name, _)| *name == value) {
            Some((_, one)) => Ok(Some(*one)),
            None => Err(UrlError::Value { key: key.into(), value, allowed }),
        }
    }

    fn yes(&mut self, key: &str) -> Result<Option<bool>, UrlError> {
        self.one_of(key, &[("1", true), ("0", false)], text::AllowedYes.fixed())
    }

    fn delay(&mut self, key: &str) -> Result<Option<Duration>, UrlError> {
        let Some(value) = self.take(key) else { return Ok(None) };
        match value.parse() {
            Ok(ms @ 0..=DELAY_MS_MAX) => Ok(Some(Duration::from_millis(ms))),
            _ => {
                Err(UrlError::Value { key: key.into(), value, allowed: text::AllowedDelay.fixed() })
            }
        }
    }
}
