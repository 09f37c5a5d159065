//! §3.3.8 «Флаги состояния Deployer»: bits 28–31.

use super::s3_03_04_drives as drives;
use super::structure;
use crate::flags::flag_class;
use crate::flags::words::{Words, words};

structure! {
    /// State of Deployer (§3.3, §3.3.8), 8 bytes.
    DeployerStatus [flags: DeployerFlags] {
        position i16 Arcmin "Position" "Положение";
        current u8 DeciAmpere "Motor current" "Ток двигателя";
        speed u8 DegreePerSecond "Speed that is set" "Заданная скорость";
    }
}

flag_class! {
    /// §3.3.8 Deployer: bits 16–27 are those of the drives.
    DeployerFlags "3.3.8";
    MOVE = 16 "Move" Info drives::MOVE;
    POSITION_WAY_FAULT = 17 "PositionWayFault" Alarm drives::POSITION_WAY_FAULT;
    AMPERAGE_OVERLOAD = 18 "AmperageOverload" Warning drives::AMPERAGE_OVERLOAD;
    POS_ENCODER_FAULT = 19 "PosEncoderFault" Alarm drives::POS_ENCODER_FAULT;
    SPEED_ENCODER_FAULT = 20 "SpeedEncoderFault" Alarm drives::SPEED_ENCODER_FAULT;
    MOTOR_BROKEN = 21 "MotorBroken" Alarm drives::MOTOR_BROKEN;
    SPEED_WAY_FAULT = 22 "SpeedWayFault" Alarm drives::SPEED_WAY_FAULT;
    LIMITLESS = 23 "Limitless" Warning drives::LIMITLESS;
    MIN_LIMIT_REACHED = 24 "MinLimitReached" Info drives::MIN_LIMIT_REACHED;
    MAX_LIMIT_REACHED = 25 "MaxLimitReached" Info drives::MAX_LIMIT_REACHED;
    ABSOLUTE_MIN_LIMIT_REACHED = 26 "AbsoluteMinLimitReached" Notice
        drives::ABSOLUTE_MIN_LIMIT_REACHED;
    ABSOLUTE_MAX_LIMIT_REACHED = 27 "AbsoluteMaxLimitReached" Notice
        drives::ABSOLUTE_MAX_LIMIT_REACHED;
    DEPLOYED = 28 "Deployed" Info DEPLOYED;
    DEPLOYING = 29 "Deploying" Info DEPLOYING;
    WRAPPED = 30 "Wrapped" Info WRAPPED;
    WRAPPING = 31 "Wrapping" Info WRAPPING;
}

const DEPLOYED: Words = words(
    ["The monitor is in the working position.", "Ствол в рабочем положении."],
    [
        "It has been deployed, by Deploy, StartSeek or StartQuench.",
        "Развёрнут по Deploy, StartSeek \
    или StartQuench.",
    ],
    [
        "Nothing; it may be aimed and the valves may be opened.",
        "Ничего; можно наводить и открывать \
    затворы.",
    ],
);
const DEPLOYING: Words = words(
    [
        "The monitor is being deployed to the working position.",
        "Ствол разворачивается в рабочее \
    положение.",
    ],
    [
        "Deploy, StartSeek or StartQuench in the standby position.",
        "Deploy, StartSeek или \
    StartQuench в дежурном положении.",
    ],
    [
        "Keep clear of the barrel; Move and Open are denied until it ends; Stop Deployer breaks it \
        off.",
        "Не приближайтесь к стволу; до завершения Move и Open отклоняются; прервать можно Stop \
        Deployer.",
    ],
);
const WRAPPED: Words = words(
    ["The monitor is in the standby position.", "Ствол в дежурном положении."],
    [
        "It has been stowed, or was never deployed since power-up.",
        "Свёрнут либо не разворачивался \
    с момента включения.",
    ],
    [
        "Nothing; send Deploy before Move or Open. StartSeek and StartQuench deploy by themselves.",
        "Ничего; перед Move или Open отправьте Deploy. StartSeek и StartQuench разворачивают сами.",
    ],
);
const WRAPPING: Words = words(
    [
        "The monitor is being stowed to the standby position.",
        "Ствол сворачивается в дежурное \
    положение.",
    ],
    ["Wrap was accepted.", "Принят запрос Wrap."],
    [
        "Keep clear of the barrel; Move and Open are denied until it ends; Stop Deployer breaks it \
        off.",
        "Не приближайтесь к стволу; до завершения Move и Open отклоняются; прервать можно Stop \
        Deployer.",
    ],
);
