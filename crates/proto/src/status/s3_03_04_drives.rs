//! §3.3.4 «Флаги состояния Vertical, Horizontal, Nozzle»; bits 16–27 are the Deployer's too.

use super::structure;
use crate::flags::flag_class;

// The document calls the current "temperature" and comments it as the current.
structure! {
    /// State of Vertical, Horizontal or Nozzle (§3.3, §3.3.4), 8 bytes. The units are those of an axis;
    /// the nozzle has mm and mm/s.
    DriveStatus [flags: DriveFlags] {
        /// Position.
        position i16 Arcmin;
        /// Motor current.
        current u8 DeciAmpere;
        /// Speed that is set.
        speed u8 DegreePerSecond;
    }
}

flag_class! {
    /// §3.3.4 Vertical, Horizontal, Nozzle.
    DriveFlags "3.3.4";
    MOVE = 16 "Move" Info Drive;
    POSITION_WAY_FAULT = 17 "PositionWayFault" Alarm Drive;
    AMPERAGE_OVERLOAD = 18 "AmperageOverload" Warning Drive;
    POS_ENCODER_FAULT = 19 "PosEncoderFault" Alarm Drive;
    SPEED_ENCODER_FAULT = 20 "SpeedEncoderFault" Alarm Drive;
    MOTOR_BROKEN = 21 "MotorBroken" Alarm Drive;
    SPEED_WAY_FAULT = 22 "SpeedWayFault" Alarm Drive;
    LIMITLESS = 23 "Limitless" Warning Drive;
    MIN_LIMIT_REACHED = 24 "MinLimitReached" Info Drive;
    MAX_LIMIT_REACHED = 25 "MaxLimitReached" Info Drive;
    ABSOLUTE_MIN_LIMIT_REACHED = 26 "AbsoluteMinLimitReached" Notice Drive;
    ABSOLUTE_MAX_LIMIT_REACHED = 27 "AbsoluteMaxLimitReached" Notice Drive;
    SPEED_SLOW_AMP = 28 "SpeedSlowAmp" Notice Drive;
    TRV_ENGAGE = 29 "TRVEngage" Info Drive;
}
