//! §3.3.2 «Флаги состояния General».

use super::structure;
use crate::flags::flag_class;

structure! {
    /// State of the monitor as a whole (§3.3, §3.3.2), 10 bytes.
    GeneralStatus [flags: GeneralFlags] {
        /// Supply voltage.
        main_voltage u16 Volt;
        /// Pressure of water or foam.
        pressure u16 DeciAtmosphere;
        /// Flow.
        flowrate u16 LitrePerSecond;
    }
}

flag_class! {
    /// §3.3.2 General.
    GeneralFlags "3.3.2";
    PRESSURE_SENSOR_BREAK = 16 "PressureSensorBreak" Warning General;
    PRESSURE_SENSOR_SHORT = 17 "PressureSensorShort" Warning General;
    LOCKED_OUT = 18 "LockedOut" Warning General;
}
