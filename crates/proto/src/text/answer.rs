//! Text form of answers.

use super::{Hex, RequestText, find_param, write_list, write_param, write_request};
use crate::answer::{Answer, Reply};
use crate::bus::{Log, LogLine, NetworkStatus};
use crate::flags;
use crate::id::{ParamId, SubsystemId};
use crate::param::Unit;
use crate::record::Record;
use crate::request::Request;
use crate::status::{FaultArch, FaultInfo, GeneralStatus, Hotbed, ThermoStatus};
use crate::{DecodeError, Ints};
use core::fmt::{self, Display};

/// An answer and the subsystem that was addressed: `Vertical Move → Denied (Deployer)`.
#[derive(Clone, Copy, Debug)]
pub struct Exchange<'a> {
    /// The addressee of the request.
    pub to: SubsystemId,
    /// The answer to the request.
    pub answer: Answer<'a>,
}

impl<'a> Exchange<'a> {
    /// Combines an answer with the addressee of its request.
    pub const fn new(request: &Request<'_>, answer: Answer<'a>) -> Self {
        Self { to: request.to, answer }
    }
}

impl Display for Exchange<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Answer { from, request, status, data } = self.answer;
        // Each of several addressees answers with its own name.
        let many = matches!(self.to, SubsystemId::ALL | SubsystemId::MOTORS);
        let to = if many { from } else { self.to };
        write!(f, "{to} ")?;
        write_request(f, request)?;
        write!(f, " → {status}")?;
        if to != from {
            write!(f, " ({from})")?;
        }
        match data {
            Reply::None => Ok(()),
            data => {
                f.write_str(": ")?;
                write_data(f, from, &data)
            }
        }
    }
}

impl Display for Answer<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Exchange { to: self.from, answer: *self }.fmt(f)
    }
}

/// An answer's record as text; one with invalid data is shown raw, with the reason.
#[derive(Clone, Copy, Debug)]
pub struct AnswerText<'a>(pub Record<'a>);

impl Display for AnswerText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Record { request, device, status, data } = self.0;
        match Answer::decode(&self.0) {
            Ok(answer) => answer.fmt(f),
            Err(error) => {
                let raw = Answer { from: device, request, status, data: Reply::Raw(data) };
                write!(f, "{raw} # {error}")
            }
        }
    }
}

fn write_data(f: &mut fmt::Formatter<'_>, from: SubsystemId, data: &Reply<'_>) -> fmt::Result {
    match *data {
        Reply::None => Ok(()),
        Reply::General(status) => write_general(f, &status),
        Reply::Thermo(status) => write_thermo(f, &status),
        Reply::Drive(s) => write_drive(f, from, s.position, s.current, s.speed, s.flags.bits()),
        Reply::Deployer(s) => {
            write_drive(f, SubsystemId::DEPLOYER, s.position, s.current, s.speed, s.flags.bits())
        }
        Reply::Valve(s) => write_flags(f, SubsystemId::VALVE1, s.flags.bits()),
        Reply::Control(s) => write_flags(f, SubsystemId::CONTROL, s.flags.bits()),
        Reply::Detector(s) => write_flags(f, SubsystemId::DETECTOR, s.flags.bits()),
        Reply::Conn(s) => write_flags(f, SubsystemId::RADIO, s.flags.bits()),
        Reply::Buttons(s) => write_flags(f, SubsystemId::BUTTONS, s.flags.bits()),
        Reply::Param { id: ParamId::HOTBEDS, values } => write_hotbeds(f, values),
        Reply::Param { id, values } => write_values(f, from, id, values),
        Reply::Limits(limits) => {
            let unit = position_unit(from);
            write!(f, "{}…{}", unit.show(limits.min), unit.show(limits.max))
        }
        Reply::Fault(info) => write_fault(f, &info),
        Reply::Network(status) => write_network(f, &status),
        Reply::Log(log) => write_log(f, &log),
        Reply::Raw(bytes) => Hex(bytes).fmt(f),
    }
}

/// A value with its unit, tenths as a decimal fraction: `8.0 A`, `1200'`, `60 mm`.
#[derive(Clone, Copy, Debug)]
pub struct Measured {
    /// The value in the unit of the protocol.
    pub value: i32,
    /// Unit of the value.
    pub unit: Unit,
}

impl Unit {
    /// Formats a value of this unit.
    pub const fn show(self, value: i32) -> Measured {
        Measured { value, unit: self }
    }
}

impl Display for Measured {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let tenths = match self.unit {
            Unit::None | Unit::Choice => return write!(f, "{}", self.value),
            Unit::Bits => return write!(f, "{:#x}", self.value),
            Unit::Arcmin | Unit::Degree => {
                return write!(f, "{}{}", self.value, self.unit.symbol());
            }
            Unit::DeciAmpere => "A",
            Unit::DeciCelsius => "°C",
            Unit::DeciAtmosphere => "atm",
            Unit::DeciSecond => "s",
            Unit::DeciMillimetre => "mm",
            _ => return write!(f, "{} {}", self.value, self.unit.symbol()),
        };
        let sign = if self.value < 0 { "-" } else { "" };
        let size = self.value.unsigned_abs();
        write!(f, "{sign}{}.{} {tenths}", size / 10, size % 10)
    }
}

fn position_unit(subsystem: SubsystemId) -> Unit {
    if subsystem == SubsystemId::NOZZLE { Unit::Millimetre } else { Unit::Arcmin }
}

fn speed_unit(subsystem: SubsystemId) -> Unit {
    if subsystem == SubsystemId::NOZZLE { Unit::MillimetrePerSecond } else { Unit::DegreePerSecond }
}

/// `[Move, MaxLimitReached]`; bits without a name in hexadecimal.
fn write_flags(f: &mut fmt::Formatter<'_>, subsystem: SubsystemId, bits: u32) -> fmt::Result {
    let class = flags::flags_of(subsystem);
    f.write_str("[")?;
    write_list(f, ", ", class.set(bits))?;
    let unnamed = class.unnamed(bits);
    if unnamed != 0 {
        let separator = if unnamed == bits { "" } else { ", " };
        write!(f, "{separator}{unnamed:#x}")?;
    }
    f.write_str("]")
}

fn write_drive(
    f: &mut fmt::Formatter<'_>,
    subsystem: SubsystemId,
    position: i16,
    current: u8,
    speed: u8,
    bits: u32,
) -> fmt::Result {
    let position = position_unit(subsystem).show(i32::from(position));
    let current = Unit::DeciAmpere.show(i32::from(current));
    let speed = speed_unit(subsystem).show(i32::from(speed));
    write!(f, "position {position} current {current} speed {speed} ")?;
    write_flags(f, subsystem, bits)
}

fn write_general(f: &mut fmt::Formatter<'_>, status: &GeneralStatus) -> fmt::Result {
    let GeneralStatus { flags, main_voltage, pressure, flowrate } = status;
    let pressure = Unit::DeciAtmosphere.show(i32::from(*pressure));
    write!(f, "voltage {main_voltage} V pressure {pressure} flow {flowrate} l/s ")?;
    write_flags(f, SubsystemId::GENERAL, flags.bits())
}

fn write_thermo(f: &mut fmt::Formatter<'_>, status: &ThermoStatus) -> fmt::Result {
    for (name, value) in [
        ("horizontal", status.horizontal),
        ("vertical", status.vertical),
        ("nozzle", status.nozzle),
        ("deployer", status.deployer),
        ("housing", status.housing),
    ] {
        write!(f, "{name} {} ", Unit::DeciCelsius.show(i32::from(value)))?;
    }
    write!(f, "humidity {} % ", status.humidity)?;
    write_flags(f, SubsystemId::CLIMATICS, status.flags.bits())
}

fn write_values(
    f: &mut fmt::Formatter<'_>,
    from: SubsystemId,
    id: ParamId,
    values: Ints<'_>,
) -> fmt::Result {
    write_param(f, from, id)?;
    let spec = find_param(from, id).map(|param| param.spec());
    values.iter().enumerate().try_for_each(|(index, value)| {
        let unit = spec.map_or(Unit::None, |spec| spec.element(index).unit);
        write!(f, " {}", unit.show(value))
    })
}

/// Writes fire spots, §3.21.
fn write_hotbeds(f: &mut fmt::Formatter<'_>, values: Ints<'_>) -> fmt::Result {
    write!(f, "Hotbeds {}", values.len() / 5)?;
    for Hotbed { x1, x2, y1, y2, brightness } in Hotbed::of_values(values) {
        write!(f, " [h {x1}'…{x2}' v {y1}'…{y2}' brightness {brightness}]")?;
    }
    Ok(())
}

/// Writes crash data, §3.20.
fn write_fault(f: &mut fmt::Formatter<'_>, info: &FaultInfo) -> fmt::Result {
    if *info == FaultInfo::NONE {
        return f.write_str("no fault recorded");
    }
    let (common, arm7) = (FaultInfo::NAMES, FaultInfo::NAMES_ARM7TDMI);
    let (cortex, own): (_, &[&str]) = match info.arch {
        FaultArch::CortexM3(_) => (20, &[]),
        FaultArch::Arm7Tdmi(_) => (10, &arm7),
    };
    let names = common.iter().take(cortex).chain(own);
    for (index, (name, word)) in names.zip(info.to_words()).enumerate() {
        let separator = if index == 0 { "" } else { " " };
        write!(f, "{separator}{name} {word:#010x}")?;
    }
    Ok(())
}

fn write_network(f: &mut fmt::Formatter<'_>, status: &NetworkStatus) -> fmt::Result {
    f.write_str("addresses [")?;
    write_list(f, ", ", status.iter())?;
    f.write_str("]")
}

fn write_log(f: &mut fmt::Formatter<'_>, log: &Log<'_>) -> fmt::Result {
    write!(f, "first={} count={}", log.first, log.count)?;
    log.iter().try_for_each(|line| write_line(f, line))
}

fn write_line(f: &mut fmt::Formatter<'_>, line: Result<LogLine<'_>, DecodeError>) -> fmt::Result {
    match line {
        Ok(LogLine { time_s, dst, src, record }) => {
            write!(f, " [{time_s} {src} → {dst}: {}]", RequestText(record))
        }
        Err(error) => write!(f, " # {error}"),
    }
}
