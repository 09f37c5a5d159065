//! §3 Layout of the data of requests and answers, for tools that read bytes without this crate's
//! types, such as dissectors, recorders and bindings.

use super::Text;
use crate::id::{ParamId, RequestId, SubsystemId};
use crate::param::Unit;
use crate::status::{
    ButtonsStatus, ConnStatus, ControlStatus, DeployerStatus, DetectorStatus, DriveStatus,
    GeneralStatus, Hotbed, Limits, ThermoStatus, ValveStatus, fault,
};

/// Type of a field; all are little-endian.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Kind {
    /// Unsigned, 1 byte.
    U8,
    /// Signed, 1 byte.
    I8,
    /// Unsigned, 2 bytes.
    U16,
    /// Signed, 2 bytes.
    I16,
    /// Unsigned, 4 bytes.
    U32,
    /// Signed, 4 bytes.
    I32,
    /// The status word of the answering subsystem, 4 bytes: see [`crate::flags::flags_of`].
    Flags,
    /// Identifier of a parameter, 2 bytes.
    ParamId,
    /// Confirms a dangerous request, 2 bytes: see [`crate::id::key`].
    Key,
}

impl Kind {
    /// Bytes on the wire.
    pub const fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 | Self::ParamId | Self::Key => 2,
            Self::U32 | Self::I32 | Self::Flags => 4,
        }
    }

    fn read(self, bytes: &[u8]) -> Option<i64> {
        let word = bytes.get(..self.size())?;
        let unsigned = word.iter().rev().fold(0, |value, byte| value << 8 | i64::from(*byte));
        Some(match self {
            Self::I8 => i64::from(unsigned as i8),
            Self::I16 => i64::from(unsigned as i16),
            Self::I32 => i64::from(unsigned as i32),
            _ => unsigned,
        })
    }
}

/// A field of a structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Field {
    /// Name of the field.
    pub name: &'static str,
    /// Type of the field.
    pub kind: Kind,
    /// Unit of the value.
    pub unit: Unit,
    /// Meaning of the value.
    pub text: Text,
}

/// The structure of data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Layout {
    /// Name of the structure.
    pub name: &'static str,
    /// The fields in order.
    pub fields: &'static [Field],
    /// Fields that repeat until the data end.
    pub repeated: &'static [Field],
    /// Least and greatest number of repetitions.
    pub times: (usize, usize),
    /// First bytes of the data, which select this structure among those of equal size.
    pub prefix: &'static [u8],
}

impl Layout {
    /// A structure in which nothing repeats.
    pub const fn plain(name: &'static str, fields: &'static [Field]) -> Self {
        Self { name, fields, repeated: &[], times: (0, 0), prefix: &[] }
    }

    /// Bytes without the repeated fields.
    pub const fn size(&self) -> usize {
        size(self.fields)
    }

    /// Whether data can have this structure.
    pub fn fits(&self, data: &[u8]) -> bool {
        let Some(rest) = data.len().checked_sub(self.size()) else { return false };
        let (least, most) = self.times;
        let whole = match size(self.repeated) {
            0 => rest == 0,
            step => rest % step == 0 && (least..=most).contains(&(rest / step)),
        };
        whole && data.starts_with(self.prefix)
    }

    /// The fields of the data: offset, field, value.
    pub fn values<'d>(
        &self,
        data: &'d [u8],
    ) -> impl Iterator<Item = (usize, &'static Field, i64)> + use<'d> {
        let (fields, repeated) = (self.fields, self.repeated);
        // A repetition has at least one byte, so there are at most as many as bytes.
        let rounds = if repeated.is_empty() { 0 } else { data.len() };
        let all = fields.iter().chain((0..rounds).flat_map(move |_| repeated));
        let mut at = 0usize;
        all.map_while(move |field| {
            let (from, value) = (at, field.kind.read(data.get(at..)?)?);
            at = from.saturating_add(field.kind.size());
            Some((from, field, value))
        })
    }
}

const fn size(mut fields: &[Field]) -> usize {
    let mut size = 0;
    while let [first, rest @ ..] = fields {
        (size, fields) = (size + first.kind.size(), rest);
    }
    size
}

/// Names of the first fields; empty after the last.
pub(crate) const fn names<const N: usize>(mut fields: &[Field]) -> [&'static str; N] {
    let mut names = [""; N];
    let mut places: &mut [&'static str] = &mut names;
    while let ([first, rest @ ..], [place, others @ ..]) = (fields, places) {
        *place = first.name;
        (fields, places) = (rest, others);
    }
    names
}

/// Structures that the data of a request can have: the first that fits applies.
pub const fn of_request(request: RequestId) -> &'static [Layout] {
    match request {
        RequestId::MOVE => &[MOVE],
        RequestId::GET_PARAM => &[PARAM_ID],
        RequestId::SET_PARAM => &[PARAM],
        RequestId::SETUP_CORRECTION_TABLE => &[CORRECTIONS],
        RequestId::OPEN | RequestId::CLOSE | RequestId::LOCKOUT | RequestId::CLEAN_FLASH => &[KEY],
        RequestId::START_QUENCH => &[QUENCH_PROGRAM, QUENCH_FULL, QUENCH_CORRECTED],
        RequestId::START_TRAJECTORY => &[TRAJECTORY_POINTS, TRAJECTORY_STORED],
        RequestId::START_SEEK => &[SEEK],
        RequestId::SWITCH_LIMITS => &[SWITCH_LIMITS],
        RequestId::GET_LOG => &[LOG_RANGE],
        _ => &[EMPTY],
    }
}

/// Structures that the data of an answer can have, unless they are empty: the first that fits
/// applies.
pub const fn of_answer(request: RequestId, from: SubsystemId) -> &'static [Layout] {
    match request {
        RequestId::GET_STATUS => of_status(from),
        RequestId::GET_PARAM | RequestId::SET_PARAM | RequestId::GET_HOTBED => &[HOTBEDS, PARAM],
        RequestId::RETRIEVE_LIMITS => &[Limits::LAYOUT],
        RequestId::GET_CRASH_DATA => &[fault::CORTEX_M3, fault::ARM7TDMI],
        RequestId::GET_NETWORK_STATUS => &[NETWORK],
        RequestId::GET_LOG => &[LOG],
        _ => &[],
    }
}

const fn of_status(from: SubsystemId) -> &'static [Layout] {
    match from {
        SubsystemId::GENERAL => &[GeneralStatus::LAYOUT],
        SubsystemId::CLIMATICS => &[ThermoStatus::LAYOUT],
        SubsystemId::VERTICAL | SubsystemId::HORIZONTAL => &[DriveStatus::LAYOUT],
        SubsystemId::NOZZLE => &[NOZZLE_STATUS],
        SubsystemId::DEPLOYER => &[DeployerStatus::LAYOUT],
        SubsystemId::VALVE1 | SubsystemId::VALVE2 => &[ValveStatus::LAYOUT],
        SubsystemId::CONTROL => &[ControlStatus::LAYOUT],
        SubsystemId::DETECTOR => &[DetectorStatus::LAYOUT],
        SubsystemId::EXTERNAL_CONN | SubsystemId::RADIO => &[ConnStatus::LAYOUT],
        SubsystemId::BUTTONS | SubsystemId::EXT_BUTTONS => &[ButtonsStatus::LAYOUT],
        _ => &[],
    }
}

macro_rules! fields {
    ($($field:ident $kind:ident $unit:ident $en:literal $ru:literal;)*) => {
        &[$($crate::dictionary::layouts::Field {
            name: stringify!($field),
            kind: $crate::dictionary::layouts::Kind::$kind,
            unit: $crate::param::Unit::$unit,
            text: $crate::dictionary::Text::new($en, $ru),
        }),*]
    };
}

pub(crate) use fields;

const EMPTY: Layout = Layout::plain("Empty", &[]);

const MOVE: Layout = Layout::plain(
    "Move",
    fields! { destination I16 None "Destination, arc-minutes (nozzle: mm)" "Цель, угл. мин (насадок: мм)"; },
);
const PARAM_ID: Layout =
    Layout::plain("ParamId", fields! { id ParamId None "Parameter" "Параметр"; });
const KEY: Layout =
    Layout::plain("Key", fields! { key Key Bits "Key that confirms" "Ключ подтверждения"; });
const SWITCH_LIMITS: Layout = Layout::plain(
    "SwitchLimits",
    fields! { new_state U16 Choice "0 off, 1 on, 2 reject" "0 выключить, 1 включить, 2 отменить"; },
);
const LOG_RANGE: Layout = Layout::plain(
    "LogRange",
    fields! {
        first U16 None "First line" "Первая строка";
        count U16 None "Number of lines" "Число строк";
    },
);
const PARAM: Layout = Layout {
    name: "Param",
    fields: PARAM_ID.fields,
    repeated: fields! { value I32 None "Value" "Значение"; },
    times: (0, usize::MAX),
    prefix: &[],
};
const CORRECTION: &[Field] =
    fields! { correction I8 Degree "Correction of the elevation" "Поправка угла подъёма"; };
const CORRECTIONS: Layout = Layout {
    name: "Corrections",
    fields: fields! { first U8 DeciAtmosphere "Pressure of the first correction" "Давление первой поправки"; },
    repeated: CORRECTION,
    times: (1, usize::MAX),
    prefix: &[],
};
const QUENCH_PROGRAM: Layout = Layout::plain(
    "QuenchProgram",
    fields! {
        program I16 None "Stored program, 0–7" "Хранимая программа, 0–7";
        centre_h I16 Arcmin "Centre, horizontal" "Центр по горизонтали";
        centre_v I16 Arcmin "Centre, vertical" "Центр по вертикали";
        nozzle I16 Millimetre "Nozzle position" "Положение насадка";
    },
);
const QUENCH_FULL: Layout = Layout::plain(
    "QuenchFull",
    fields! {
        centre_h I16 Arcmin "Centre, horizontal" "Центр по горизонтали";
        centre_v I16 Arcmin "Centre, vertical" "Центр по вертикали";
        nozzle I16 Millimetre "Nozzle position" "Положение насадка";
        width I16 Arcmin "Width of the sector" "Ширина сектора";
        height I16 Arcmin "Height of the sector" "Высота сектора";
        step I8 Degree "Step between lines" "Шаг между строками";
        distance I8 Metre "Distance to the fire" "Расстояние до очага";
    },
);
const QUENCH_CORRECTED: Layout = Layout {
    name: "QuenchCorrected",
    fields: QUENCH_FULL.fields.split_at(6).0,
    repeated: CORRECTION,
    times: (2, usize::MAX),
    prefix: &[],
};
const TRAJECTORY: &[Field] = fields! {
    mode U8 Choice "0 points, 1 stored trajectories" "0 точки, 1 хранимые траектории";
    flags U8 Bits "Bit 0 ballistics, bit 1 repeat" "Бит 0 баллистика, бит 1 повтор";
    count U8 None "How many" "Количество";
};
const TRAJECTORY_POINTS: Layout = Layout {
    name: "TrajectoryPoints",
    fields: TRAJECTORY,
    repeated: fields! {
        horizontal I16 Arcmin "Line of sight, horizontal" "Линия визирования по горизонтали";
        vertical I16 Arcmin "Line of sight, vertical" "Линия визирования по вертикали";
        distance U8 Metre "Distance" "Расстояние";
        dwell U8 DeciSecond "Time to stay" "Время задержки";
    },
    times: (1, usize::MAX),
    prefix: &[0],
};
const TRAJECTORY_STORED: Layout = Layout {
    name: "TrajectoryStored",
    fields: TRAJECTORY,
    repeated: fields! { trajectory U8 None "Stored trajectory, 0–7" "Хранимая траектория, 0–7"; },
    times: (1, usize::MAX),
    prefix: &[1],
};
const SEEK: Layout = Layout::plain(
    "Seek",
    fields! {
        start_h I16 Arcmin "One end, horizontal" "Один край по горизонтали";
        end_h I16 Arcmin "Other end, horizontal" "Другой край по горизонтали";
        start_v I16 Arcmin "One end, vertical" "Один край по вертикали";
        end_v I16 Arcmin "Other end, vertical" "Другой край по вертикали";
        analyse I16 Choice "1 measure each fire spot in a second pass" "1 измерить каждый очаг загорания вторым проходом";
    },
);

/// The fields of a drive in the units of the nozzle.
const NOZZLE: [Field; 4] = match DriveStatus::LAYOUT.fields {
    [flags, position, current, speed] => [
        *flags,
        Field { unit: Unit::Millimetre, ..*position },
        *current,
        Field { unit: Unit::MillimetrePerSecond, ..*speed },
    ],
    _ => panic!("the state of a drive has four fields"),
};
const NOZZLE_STATUS: Layout = Layout::plain("NozzleStatus", &NOZZLE);
const HOTBEDS: Layout = Layout {
    name: "Hotbeds",
    fields: PARAM_ID.fields,
    repeated: Hotbed::LAYOUT.fields,
    times: (0, Hotbed::MAX),
    prefix: &ParamId::HOTBEDS.0.to_le_bytes(),
};
const NETWORK: Layout = Layout {
    name: "NetworkStatus",
    fields: &[],
    repeated: fields! { present U8 Bits "Eight addresses, a bit each" "Восемь адресов, по биту"; },
    times: (32, 32),
    prefix: &[],
};
const LOG: Layout = Layout {
    name: "Log",
    fields: LOG_RANGE.fields,
    repeated: fields! { line U8 Bits "Byte of a line" "Байт строки"; },
    times: (0, usize::MAX),
    prefix: &[],
};
