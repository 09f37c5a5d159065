//! §3.3.5 «Флаги состояния Valve1, Valve2».

use super::structure;
use crate::flags::flag_class;

structure! {
    /// State of Valve1 or Valve2 (§3.3, §3.3.5), 4 bytes.
    ValveStatus [flags: ValveFlags] {}
}

flag_class! {
    /// §3.3.5 Valve1, Valve2.
    ValveFlags "3.3.5";
    OPENING = 16 "Opening" Info Valve;
    CLOSING = 17 "Closing" Info Valve;
    AMPERAGE_OVERLOAD = 18 "AmperageOverload" Alarm Valve;
    BLOCKED = 19 "Blocked" Warning Valve;
    OPEN_SENSOR_FAULT = 20 "OpenSensorFault" Warning Valve;
    CLOSE_SENSOR_FAULT = 21 "CloseSensorFault" Warning Valve;
    OPEN = 22 "Open" Info Valve;
    CLOSED = 23 "Closed" Info Valve;
}
