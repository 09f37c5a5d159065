//! §3.3 «GetStatus», §3.7, §3.20, §3.21: the structures that answers carry.
//!
//! All are packed and little-endian; each has `SIZE`, `LAYOUT`, `from_bytes` and `to_bytes`.

#[macro_use]
mod structure;
pub(crate) mod fault;

pub use fault::{FaultArch, FaultInfo};

use crate::Ints;
use crate::dictionary::Text;
use crate::dictionary::layouts::{Field, Kind, Layout};
use crate::flags::{
    ButtonsFlags, ClimaticsFlags, ConnFlags, ControlFlags, DeployerFlags, DetectorFlags,
    DriveFlags, GeneralFlags, ValveFlags,
};
use crate::param::Unit;

structure! {
    /// State of the monitor as a whole (§3.3, §3.3.2), 10 bytes.
    GeneralStatus [flags: GeneralFlags] {
        main_voltage u16 Volt "Supply voltage" "Напряжение питания";
        pressure u16 DeciAtmosphere "Pressure of water or foam" "Давление воды или пены";
        flowrate u16 LitrePerSecond "Flow" "Расход";
    }
}

structure! {
    /// Climate inside the monitor (§3.3, §3.3.3), 16 bytes.
    ThermoStatus [flags: ClimaticsFlags] {
        horizontal i16 DeciCelsius "Temperature of the traverse drive" "Температура привода горизонтального перемещения";
        vertical i16 DeciCelsius "Temperature of the elevation drive" "Температура привода вертикального перемещения";
        nozzle i16 DeciCelsius "Temperature of the nozzle drive" "Температура привода насадка";
        deployer i16 DeciCelsius "Temperature of the deployment drive" "Температура привода развёртывания";
        housing i16 DeciCelsius "Temperature of the housing" "Температура корпуса";
        humidity u16 Percent "Humidity in the housing" "Влажность в корпусе";
    }
}

// The document calls the current "temperature" and comments it as the current.
structure! {
    /// State of Vertical, Horizontal or Nozzle (§3.3, §3.3.4), 8 bytes. The units are those of an axis;
    /// the nozzle has mm and mm/s.
    DriveStatus [flags: DriveFlags] {
        position i16 Arcmin "Position" "Положение";
        current u8 DeciAmpere "Motor current" "Ток двигателя";
        speed u8 DegreePerSecond "Speed that is set" "Заданная скорость";
    }
}

structure! {
    /// State of Deployer (§3.3, §3.3.8), 8 bytes.
    DeployerStatus [flags: DeployerFlags] {
        position i16 Arcmin "Position" "Положение";
        current u8 DeciAmpere "Motor current" "Ток двигателя";
        speed u8 DegreePerSecond "Speed that is set" "Заданная скорость";
    }
}

structure! {
    /// State of Valve1 or Valve2 (§3.3, §3.3.5), 4 bytes.
    ValveStatus [flags: ValveFlags] {}
}

structure! {
    /// State of Control (§3.3, §3.3.6), 4 bytes.
    ControlStatus [flags: ControlFlags] {}
}

structure! {
    /// State of Detector (§3.3, §3.3.7), 4 bytes.
    DetectorStatus [flags: DetectorFlags] {}
}

structure! {
    /// State of ExternalConn or Radio (§3.3, §3.3.9), 4 bytes.
    ConnStatus [flags: ConnFlags] {}
}

structure! {
    /// State of Buttons or ExtButtons (§3.3, §3.3.10), 4 bytes.
    ButtonsStatus [flags: ButtonsFlags] {}
}

structure! {
    /// Limits of motion (§3.7), 8 bytes, in the unit of the drive: arc-minutes or mm.
    Limits {
        min i32 None "Lower, right or wider limit" "Нижний, правый предел или предел «шире»";
        max i32 None "Upper, left or narrower limit" "Верхний, левый предел или предел «уже»";
    }
}

structure! {
    /// A fire that the detector has found (§3.21), 20 bytes.
    #[derive(Default)]
    Hotbed {
        x1 i32 Arcmin "Left edge" "Левый край";
        x2 i32 Arcmin "Right edge" "Правый край";
        y1 i32 Arcmin "Lower edge" "Нижний край";
        y2 i32 Arcmin "Upper edge" "Верхний край";
        brightness i32 None "Brightness" "Яркость";
    }
}

impl Hotbed {
    /// Most hotbeds in one answer.
    pub const MAX: usize = 4;

    /// The hotbeds in the values of the parameter Hotbeds, five values each.
    pub fn of_values(values: Ints<'_>) -> impl Iterator<Item = Self> + use<'_> {
        let mut values = values.iter();
        core::iter::from_fn(move || {
            let mut next = || values.next();
            Some(Self::from_values([next()?, next()?, next()?, next()?, next()?]))
        })
    }

    /// The values of the parameter Hotbeds for this hotbed.
    pub const fn to_values(self) -> [i32; 5] {
        [self.x1, self.x2, self.y1, self.y2, self.brightness]
    }

    /// A hotbed from values of the parameter Hotbeds.
    pub const fn from_values([x1, x2, y1, y2, brightness]: [i32; 5]) -> Self {
        Self { x1, x2, y1, y2, brightness }
    }
}
