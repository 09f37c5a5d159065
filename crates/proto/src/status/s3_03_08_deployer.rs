//! §3.3.8 «Флаги состояния Deployer»: bits 28–31.

use super::structure;
use crate::flags::flag_class;

structure! {
    /// State of Deployer (§3.3, §3.3.8), 8 bytes.
    DeployerStatus [flags: DeployerFlags] {
        /// Position.
        position i16 Arcmin;
        /// Motor current.
        current u8 DeciAmpere;
        /// Speed that is set.
        speed u8 DegreePerSecond;
    }
}

flag_class! {
    /// §3.3.8 Deployer: bits 16–27 are those of the drives.
    DeployerFlags "3.3.8";
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
    DEPLOYED = 28 "Deployed" Info Deployer;
    DEPLOYING = 29 "Deploying" Info Deployer;
    WRAPPED = 30 "Wrapped" Info Deployer;
    WRAPPING = 31 "Wrapping" Info Deployer;
}
