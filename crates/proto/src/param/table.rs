//! §P/1 The table of the parameters — ours (§3.4, §3.5): the vendor's list is not public.

use super::kinds;
use super::{Access, Effect, Element, ParamSpec, Placement, Storage, Unit};
use crate::dictionary::Text;
use crate::id::{ParamId, SubsystemId};

/// Rows of `Variant: SUBSYSTEM "Name", spec, text;` become the enum and its three tables.
macro_rules! params {
    ($($variant:ident: $subsystem:ident $name:literal, $spec:expr, $text:expr;)+) => {
        /// A parameter of a subsystem.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[repr(u8)]
        #[non_exhaustive]
        pub enum Param {
            $(
                #[doc = concat!("`", stringify!($subsystem), "` `", $name, "`")]
                $variant,
            )+
        }

        impl Param {
            /// Every parameter in the order of the table.
            pub const ALL: [Param; Param::COUNT] = [$(Param::$variant),+];
            /// How many parameters there are.
            pub const COUNT: usize = [$($name),+].len();

            /// Length, range, unit and handling.
            pub const fn spec(self) -> &'static ParamSpec {
                match self {
                    $(Param::$variant => &const {
                        ParamSpec {
                            subsystem: SubsystemId::$subsystem,
                            id: ParamId::of($name),
                            ..$spec
                        }
                    },)+
                }
            }

            /// What belongs to this parameter alone; the rest is shared by its kind.
            const fn own(self) -> &'static Own {
                const ALL: [Own; Param::COUNT] = [$(Own {
                    default: $spec.default,
                    id: ParamId::of($name),
                    subsystem: SubsystemId::$subsystem,
                    kind: kinds::place(&$spec, &SPECS),
                }),+];
                match ALL.split_at_checked(self as usize) {
                    Some((_, [own, ..])) => own,
                    _ => &OWN,
                }
            }

            /// The name whose hash is the id.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Param::$variant => $name,)+
                }
            }

            /// What the parameter is and does.
            pub const fn text(self) -> Text {
                match self {
                    $(Param::$variant => const { $text },)+
                }
            }
        }

        /// The specification of each row, from which the kinds are made.
        const SPECS: [ParamSpec; Param::COUNT] = [$($spec),+];
    };
}

/// What distinguishes a parameter from others of its kind.
struct Own {
    default: i32,
    id: ParamId,
    subsystem: SubsystemId,
    kind: u8,
}

/// Placeholder of a specification.
pub(super) const ANY: ParamSpec = one(Unit::None, 0, 0, 0);

/// Placeholder.
const OWN: Own = Own { default: 0, id: ParamId(0), subsystem: SubsystemId::GENERAL, kind: 0 };

impl Param {
    /// The specification shared by all parameters of this kind, which saves memory. Subsystem, id
    /// and default are not those of this parameter.
    pub const fn kind(self) -> &'static ParamSpec {
        const KINDS: [ParamSpec; kinds::count(&SPECS)] = kinds::all(&SPECS);
        match KINDS.split_at_checked(self.own().kind as usize) {
            Some((_, [kind, ..])) => kind,
            _ => &kinds::BLANK,
        }
    }

    /// The subsystem it belongs to.
    pub const fn subsystem(self) -> SubsystemId {
        self.own().subsystem
    }

    /// The 16-bit hash of its name.
    pub const fn id(self) -> ParamId {
        self.own().id
    }

    /// The value of every element until it is set.
    pub const fn default(self) -> i32 {
        self.own().default
    }
}

/// One stored value that takes effect at once; the methods below change single properties.
const fn one(unit: Unit, min: i32, max: i32, default: i32) -> ParamSpec {
    ParamSpec {
        subsystem: SubsystemId::GENERAL,
        id: ParamId(0),
        min_len: 1,
        max_len: 1,
        step_len: 1,
        unit,
        min,
        max,
        default,
        elements: &[],
        access: Access::ReadWrite,
        effect: Effect::AtOnce,
        storage: Storage::Stored,
        placement: Placement::Local,
        required: true,
    }
}

impl ParamSpec {
    const fn len(self, min_len: u8, max_len: u8, step_len: u8) -> Self {
        Self { min_len, max_len, step_len, ..self }
    }

    const fn after_restart(self) -> Self {
        Self { effect: Effect::Restart, ..self }
    }

    const fn optional(self) -> Self {
        Self { required: false, ..self }
    }

    const fn on_unit(self) -> Self {
        Self { placement: Placement::Unit, ..self }
    }

    const fn passing(self) -> Self {
        Self { storage: Storage::Volatile, required: false, ..self }
    }

    const fn measured(self) -> Self {
        Self { access: Access::ReadOnly, storage: Storage::Volatile, required: false, ..self }
    }
}

/// A position of a drive: what the int16 of Move and DriveStatus can say (§3.1, §3.3).
const fn position(unit: Unit, default: i32) -> ParamSpec {
    one(unit, -32_767, 32_767, default).on_unit()
}

/// §D/7 Where an end switch is.
const fn home(unit: Unit) -> ParamSpec {
    one(unit, -32_767, 32_767, 0).optional()
}

/// A speed or a current: one byte in DriveStatus (§3.3).
const fn byte(unit: Unit, min: i32, default: i32) -> ParamSpec {
    one(unit, min, 255, default).on_unit()
}

const fn acceleration(unit: Unit, default: i32) -> ParamSpec {
    one(unit, 1, 1000, default).on_unit()
}

const fn min_speed(unit: Unit) -> ParamSpec {
    one(unit, 0, 30, 0).optional()
}

const fn choice(max: i32, default: i32) -> ParamSpec {
    one(Unit::Choice, 0, max, default)
}

const fn element(unit: Unit, min: i32, max: i32) -> Element {
    Element { unit, min, max }
}

/// §3.14: the seven numbers of StartQuench full, in its order.
const PROGRAM: ParamSpec = ParamSpec {
    elements: &[
        element(Unit::Arcmin, -32_767, 32_767),
        element(Unit::Arcmin, -32_767, 32_767),
        element(Unit::Millimetre, -32_767, 32_767),
        element(Unit::Arcmin, 0, 32_767),
        element(Unit::Arcmin, 0, 32_767),
        element(Unit::Degree, 0, 127),
        element(Unit::Metre, 0, 127),
    ],
    ..one(Unit::None, -32_767, 32_767, 0).len(7, 7, 1).optional()
};

/// §3.15: up to fifteen points of four numbers.
const TRAJECTORY: ParamSpec = ParamSpec {
    elements: &[
        element(Unit::Arcmin, -32_767, 32_767),
        element(Unit::Arcmin, -32_767, 32_767),
        element(Unit::Metre, 0, 255),
        element(Unit::DeciSecond, 0, 255),
    ],
    ..one(Unit::None, -32_767, 32_767, 0).len(0, 60, 4).optional()
};

const DRIVE_TYPE: ParamSpec = choice(2, 0).after_restart();
const MOVE_HOLD: ParamSpec = one(Unit::Millisecond, 0, 10_000, 0).passing();
const STOP_LAG: ParamSpec = one(Unit::Millisecond, 0, 500, 0).optional();
const HOMING: ParamSpec = choice(2, 0).after_restart().optional();
const VALVE_TYPE: ParamSpec = choice(1, 0).after_restart();
const VALVE_TRAVEL: ParamSpec = one(Unit::Millisecond, 500, 120_000, 12_000).on_unit();
const TIMEOUT: ParamSpec = one(Unit::Millisecond, 500, 60_000, 3000);
const JUSTIFY: ParamSpec = one(Unit::Arcmin, -600, 600, 0);

const fn heat(default: i32) -> ParamSpec {
    one(Unit::DeciCelsius, -400, 600, default)
}

const fn text(en: &'static str, ru: &'static str) -> Text {
    Text::new(en, ru)
}

const MIN_LIMIT_TEXT: Text = text(
    "Lower or right limit of travel (wider for the nozzle); Move stops here while limits are on.",
    "Нижний или правый предел хода (шире для насадка); при включённых пределах Move \
    останавливается здесь.",
);
const MAX_LIMIT_TEXT: Text = text(
    "Upper or left limit of travel (narrower for the nozzle); Move stops here while limits are on.",
    "Верхний или левый предел хода (уже для насадка); при включённых пределах Move останавливается \
    здесь.",
);
const ZERO_POINT_TEXT: Text = text(
    "Reading of the position sensor that counts as zero; while limits are off it takes the \
    present position only.",
    "Показание датчика положения, принятое за ноль; при выключенных пределах принимает только \
    текущее положение.",
);
const SPEED_TEXT: Text = text(
    "Speed of the drive in a move; a lower one aims finer and spares the gear.",
    "Скорость привода при движении; меньшая даёт более точную наводку и бережёт редуктор.",
);
const ACCELERATION_TEXT: Text = text(
    "How fast the drive gains and loses speed; lower it if the barrel swings when it stops.",
    "Темп разгона и торможения привода; уменьшите, если ствол раскачивается при остановке.",
);
const MAX_CURRENT_TEXT: Text = text(
    "Current at which the drive stops and reports AmperageOverload.",
    "Ток, при котором привод останавливается и сообщает AmperageOverload.",
);
const SLOW_CURRENT_TEXT: Text = text(
    "Current above which the drive slows down and reports SpeedSlowAmp; 0 switches this off.",
    "Ток, выше которого привод снижает скорость и сообщает SpeedSlowAmp; 0 — функция выключена.",
);
const DRIVE_TYPE_TEXT: Text = text(
    "How the drive is controlled: 0 with an encoder, 1 by a remote unit, 2 with limit switches.",
    "Способ управления приводом: 0 — с энкодером, 1 — удалённым блоком, 2 — с датчиками конечных \
    положений.",
);
const MOVE_HOLD_TEXT: Text = text(
    "Set before Move in the same frame: the drive stops after this time unless it is set again; 0 at \
    rest, never stored.",
    "Задаётся перед Move в том же кадре: привод останавливается по истечении этого времени, если \
    параметр не задан снова; в покое 0, не сохраняется.",
);
const STOP_LAG_TEXT: Text = text(
    "How late the speed of the drive follows its command (time constant): the drive is switched off so much \
    earlier that it runs out to its target.",
    "Запаздывание скорости привода относительно команды (постоянная времени): привод отключается \
    настолько раньше, чтобы выбегом прийти в заданное положение.",
);
const MIN_SPEED_TEXT: Text = text(
    "Commanded speed below which the drive does not turn (friction, dead band of the power stage).",
    "Заданная скорость, ниже которой привод не движется (трение, зона нечувствительности силовой части).",
);
const STOP_LAG_SEEN_TEXT: Text = text(
    "StopLag as measured at the last stop from 2 °/s (2 mm/s) or more; 0 before one.",
    "StopLag по последней остановке со скорости от 2 °/с (2 мм/с); до неё 0.",
);
const MIN_SPEED_SEEN_TEXT: Text = text(
    "MinSpeed as measured in the last move that came to its target.",
    "MinSpeed по последнему перемещению, дошедшему до цели.",
);
const HOMING_TEXT: Text = text(
    "Where the position comes from after a start: 0 from an absolute sensor; 1 from the end switch at the \
    lower or right end (wider for the nozzle), 2 from the one at the other end: until it has been moved there, \
    slowly, its position is not known and Limitless is set.",
    "Откуда известно положение после пуска: 0 — от абсолютного датчика; 1 — от концевого выключателя внизу или \
    справа (шире для насадка), 2 — от противоположного: пока привод не подведён к нему (на малой скорости), \
    положение неизвестно и выставлен Limitless.",
);
const HOME_POSITION_TEXT: Text = text(
    "What an absolute position sensor would read where the end switch of Homing closes.",
    "Показание, которое дал бы абсолютный датчик положения в точке срабатывания выключателя, заданного Homing.",
);
const VALVE_TRAVEL_TEXT: Text = text(
    "Longest time of a full opening or closing; a valve that takes longer is reported as faulty.",
    "Наибольшее время полного открытия или закрытия; затвор, не уложившийся в него, считается \
    неисправным.",
);
const VALVE_TYPE_TEXT: Text = text(
    "How the valve is controlled: 0 locally, 1 by a remote unit.",
    "Способ управления затвором: 0 — непосредственно, 1 — удалённым блоком.",
);
const VALVE_CURRENT_TEXT: Text = text(
    "Current at which the valve's motor stops and AmperageOverload is reported.",
    "Ток, при котором двигатель затвора останавливается и выставляется AmperageOverload.",
);
const PROGRAM_TEXT: Text = text(
    "Stored extinguishing program: centre h, centre v, nozzle, width, height, scan step, distance.",
    "Записанная программа тушения: центр по горизонтали и вертикали, насадок, ширина, высота, шаг, \
    дальность.",
);
const TRAJECTORY_TEXT: Text = text(
    "Stored trajectory: up to 15 points of horizontal, vertical, distance and dwell; may be empty.",
    "Записанная траектория: до 15 точек (горизонталь, вертикаль, дальность, выдержка); может быть \
    пустой.",
);
const TIMEOUT_TEXT: Text = text(
    "Time without control requests on this interface after which ConnLost is set.",
    "Время без запросов управления по этому интерфейсу, после которого выставляется ConnLost.",
);

const CHECK_TEXT: Text = text(
    "Link frames that are taken on this interface: 0 every good frame, 1 only those with a CRC-32C \
    (a client that does not have it gets no answers any more).",
    "Кадры, которые принимаются по этому интерфейсу: 0 — все верные, 1 — только с CRC-32C (клиент \
    без неё больше не получает ответов).",
);

use Unit::{
    Arcmin, Bits, Centimetre, DeciAmpere, DeciAtmosphere, DeciDegreePerSecond, DeciMillimetre,
    DeciMillimetrePerSecond, DegreePerSecond, DegreePerSecond2, Millimetre, MillimetrePerSecond,
    MillimetrePerSecond2, Millisecond, Second, Volt,
};

params! {
    GeneralAddress: GENERAL "Address", one(Unit::None, 1, 127, 1).after_restart(), text(
        "Address of the monitor on the control bus.",
        "Адрес ствола на магистрали управления.");
    GeneralChain: GENERAL "Chain", one(Bits, 0, 0x3FFF, 0x3FFF).after_restart(), text(
        "Subsystems that the monitor has: a bit each in the order of the table in §1, from General \
        = bit 0 to ExtButtons = bit 13.",
        "Подсистемы в составе ствола: по биту на каждую в порядке таблицы §1, от General = бит 0 \
        до ExtButtons = бит 13.");
    GeneralFaultInfo: GENERAL "FaultInfo",
        one(Bits, i32::MIN, i32::MAX, 0).len(20, 20, 1).measured(), text(
        "Registers saved at the last hardware fault, the same as GetCrashData gives.",
        "Регистры, сохранённые при последнем аппаратном отказе; то же, что выдаёт GetCrashData.");
    GeneralInputFaults: GENERAL "InputFaults", one(Bits, 0, i32::MAX, 0).measured(), text(
        "What the inputs contradict, a bit each: 0 water flows though every valve is closed; 1 a \
        valve is open without flow and pressure; 2 the detector is saturated; 3 a valve was \
        closed because nobody has confirmed its water; 4 to 7 Vertical, Horizontal, Nozzle, Deployer has \
        turned though it was not fed; 8 to 10 the position of Vertical, Horizontal, Nozzle is not known until it is homed; \
        12 to 15 the same four drives could not come to rest at their last target.",
        "Чему противоречат показания датчиков, по битам: 0 — вода идёт при закрытых затворах; 1 — \
        затвор открыт, а расхода и давления нет; 2 — извещатель засвечен; 3 — затвор \
        закрыт: подачу воды никто не подтвердил; 4–7 — привод Vertical, Horizontal, Nozzle, \
        Deployer двигался без команды; 8–10 — положение Vertical, Horizontal, Nozzle неизвестно до поиска конца; \
        12–15 — те же четыре привода не смогли остановиться в последнем заданном положении.");
    GeneralMainVoltageMin: GENERAL "MainVoltageMin", one(Volt, 0, 1000, 18), text(
        "Supply voltage below which BadPower is set.",
        "Напряжение питания, ниже которого выставляется BadPower.");
    GeneralMainVoltageMax: GENERAL "MainVoltageMax", one(Volt, 0, 1000, 32), text(
        "Supply voltage above which BadPower is set.",
        "Напряжение питания, выше которого выставляется BadPower.");
    GeneralPressureRange: GENERAL "PressureRange", one(DeciAtmosphere, 1, 1000, 160), text(
        "Pressure that the 4–20 mA sensor shows at 20 mA: the upper end of its scale.",
        "Давление, соответствующее 20 мА датчика 4–20 мА: верхняя граница его шкалы.");
    GeneralResetValves: GENERAL "ResetValves", choice(1, 0), text(
        "What a reset during extinguishing does to the valves: 0 closes them, 1 leaves them as \
        they are.",
        "Что происходит с затворами при сбросе во время тушения: 0 — закрываются, 1 — остаются как \
        были.");
    GeneralWaterTimeout: GENERAL "WaterTimeout", one(Second, 0, 86_400, 0).optional(), text(
        "A valve that is not closed is closed when nobody has confirmed for this time that its water is wanted: by \
        Open, StartQuench, StartTrajectory, or by setting this parameter; 0 never closes it.",
        "Незакрытый затвор закрывается, если за это время никто не подтвердил, что вода нужна: запросом Open, \
        StartQuench, StartTrajectory или установкой этого параметра; 0 — не закрывается.");
    GeneralMoveTimeout: GENERAL "MoveTimeout", one(Millisecond, 0, 60_000, 0), text(
        "A drive stops when Move is not repeated within this time; 0 switches this off.",
        "Привод останавливается, если Move не повторён за это время; 0 — функция выключена.");

    ClimaticsHeatOn: CLIMATICS "HeatOn", heat(50), text(
        "Temperature below which a node is heated.",
        "Температура, ниже которой включается подогрев узла.");
    ClimaticsHeatOff: CLIMATICS "HeatOff", heat(80), text(
        "Temperature above which the heating of a node is switched off; keep it above HeatOn.",
        "Температура, выше которой подогрев узла выключается; держите её выше HeatOn.");

    VerticalMinLimit: VERTICAL "MinLimit", position(Arcmin, -900), MIN_LIMIT_TEXT;
    VerticalMaxLimit: VERTICAL "MaxLimit", position(Arcmin, 4500), MAX_LIMIT_TEXT;
    VerticalZeroPoint: VERTICAL "ZeroPoint", position(Arcmin, 0), ZERO_POINT_TEXT;
    VerticalSpeed: VERTICAL "Speed", byte(DegreePerSecond, 1, 12), SPEED_TEXT;
    VerticalAcceleration: VERTICAL "Acceleration", acceleration(DegreePerSecond2, 24),
        ACCELERATION_TEXT;
    VerticalMaxCurrent: VERTICAL "MaxCurrent", byte(DeciAmpere, 1, 80), MAX_CURRENT_TEXT;
    VerticalSlowCurrent: VERTICAL "SlowCurrent", byte(DeciAmpere, 0, 60), SLOW_CURRENT_TEXT;
    VerticalDriveType: VERTICAL "DriveType", DRIVE_TYPE, DRIVE_TYPE_TEXT;
    VerticalMoveHold: VERTICAL "MoveHold", MOVE_HOLD, MOVE_HOLD_TEXT;
    VerticalStopLag: VERTICAL "StopLag", STOP_LAG, STOP_LAG_TEXT;
    VerticalMinSpeed: VERTICAL "MinSpeed", min_speed(DeciDegreePerSecond), MIN_SPEED_TEXT;
    VerticalStopLagSeen: VERTICAL "StopLagSeen", STOP_LAG.measured(), STOP_LAG_SEEN_TEXT;
    VerticalMinSpeedSeen: VERTICAL "MinSpeedSeen", min_speed(DeciDegreePerSecond).measured(), MIN_SPEED_SEEN_TEXT;
    VerticalHoming: VERTICAL "Homing", HOMING, HOMING_TEXT;
    VerticalHomePosition: VERTICAL "HomePosition", home(Arcmin), HOME_POSITION_TEXT;

    HorizontalMinLimit: HORIZONTAL "MinLimit", position(Arcmin, -10_800), MIN_LIMIT_TEXT;
    HorizontalMaxLimit: HORIZONTAL "MaxLimit", position(Arcmin, 10_800), MAX_LIMIT_TEXT;
    HorizontalZeroPoint: HORIZONTAL "ZeroPoint", position(Arcmin, 0), ZERO_POINT_TEXT;
    HorizontalSpeed: HORIZONTAL "Speed", byte(DegreePerSecond, 1, 20), SPEED_TEXT;
    HorizontalAcceleration: HORIZONTAL "Acceleration", acceleration(DegreePerSecond2, 30),
        ACCELERATION_TEXT;
    HorizontalMaxCurrent: HORIZONTAL "MaxCurrent", byte(DeciAmpere, 1, 80), MAX_CURRENT_TEXT;
    HorizontalSlowCurrent: HORIZONTAL "SlowCurrent", byte(DeciAmpere, 0, 60), SLOW_CURRENT_TEXT;
    HorizontalDriveType: HORIZONTAL "DriveType", DRIVE_TYPE, DRIVE_TYPE_TEXT;
    HorizontalMoveHold: HORIZONTAL "MoveHold", MOVE_HOLD, MOVE_HOLD_TEXT;
    HorizontalStopLag: HORIZONTAL "StopLag", STOP_LAG, STOP_LAG_TEXT;
    HorizontalMinSpeed: HORIZONTAL "MinSpeed", min_speed(DeciDegreePerSecond), MIN_SPEED_TEXT;
    HorizontalStopLagSeen: HORIZONTAL "StopLagSeen", STOP_LAG.measured(), STOP_LAG_SEEN_TEXT;
    HorizontalMinSpeedSeen: HORIZONTAL "MinSpeedSeen", min_speed(DeciDegreePerSecond).measured(), MIN_SPEED_SEEN_TEXT;
    HorizontalHoming: HORIZONTAL "Homing", HOMING, HOMING_TEXT;
    HorizontalHomePosition: HORIZONTAL "HomePosition", home(Arcmin), HOME_POSITION_TEXT;

    NozzleMinLimit: NOZZLE "MinLimit", position(Millimetre, 0), MIN_LIMIT_TEXT;
    NozzleMaxLimit: NOZZLE "MaxLimit", position(Millimetre, 60), MAX_LIMIT_TEXT;
    NozzleZeroPoint: NOZZLE "ZeroPoint", position(Millimetre, 0), ZERO_POINT_TEXT;
    NozzleSpeed: NOZZLE "Speed", byte(MillimetrePerSecond, 1, 10), SPEED_TEXT;
    NozzleAcceleration: NOZZLE "Acceleration", acceleration(MillimetrePerSecond2, 40),
        ACCELERATION_TEXT;
    NozzleMaxCurrent: NOZZLE "MaxCurrent", byte(DeciAmpere, 1, 80), MAX_CURRENT_TEXT;
    NozzleSlowCurrent: NOZZLE "SlowCurrent", byte(DeciAmpere, 0, 60), SLOW_CURRENT_TEXT;
    NozzleDriveType: NOZZLE "DriveType", DRIVE_TYPE, DRIVE_TYPE_TEXT;
    NozzleMoveHold: NOZZLE "MoveHold", MOVE_HOLD, MOVE_HOLD_TEXT;
    NozzleStopLag: NOZZLE "StopLag", STOP_LAG, STOP_LAG_TEXT;
    NozzleMinSpeed: NOZZLE "MinSpeed", min_speed(DeciMillimetrePerSecond), MIN_SPEED_TEXT;
    NozzleStopLagSeen: NOZZLE "StopLagSeen", STOP_LAG.measured(), STOP_LAG_SEEN_TEXT;
    NozzleMinSpeedSeen: NOZZLE "MinSpeedSeen", min_speed(DeciMillimetrePerSecond).measured(), MIN_SPEED_SEEN_TEXT;
    NozzleHoming: NOZZLE "Homing", HOMING, HOMING_TEXT;
    NozzleHomePosition: NOZZLE "HomePosition", home(Millimetre), HOME_POSITION_TEXT;
    NozzleTrvPosition: NOZZLE "TrvPosition", one(Millimetre, -1, 100, -1).on_unit(), text(
        "Position at and below which the nozzle of a mini-robot works as a TRV and TRVEngage is \
        set; -1 when it has none.",
        "Положение, начиная с которого вниз насадок мини-робота работает в режиме ТРВ (флаг \
        TRVEngage); -1 — режима нет.");

    DeployerMinLimit: DEPLOYER "MinLimit", position(Arcmin, 0), MIN_LIMIT_TEXT;
    DeployerMaxLimit: DEPLOYER "MaxLimit", position(Arcmin, 5400), MAX_LIMIT_TEXT;
    DeployerZeroPoint: DEPLOYER "ZeroPoint", position(Arcmin, 0), ZERO_POINT_TEXT;
    DeployerSpeed: DEPLOYER "Speed", byte(DegreePerSecond, 1, 15), SPEED_TEXT;
    DeployerAcceleration: DEPLOYER "Acceleration", acceleration(DegreePerSecond2, 30),
        ACCELERATION_TEXT;
    DeployerMaxCurrent: DEPLOYER "MaxCurrent", byte(DeciAmpere, 1, 80), MAX_CURRENT_TEXT;
    DeployerSlowCurrent: DEPLOYER "SlowCurrent", byte(DeciAmpere, 0, 60), SLOW_CURRENT_TEXT;
    DeployerDriveType: DEPLOYER "DriveType", DRIVE_TYPE, DRIVE_TYPE_TEXT;
    DeployerMoveHold: DEPLOYER "MoveHold", MOVE_HOLD, MOVE_HOLD_TEXT;
    DeployerStopLag: DEPLOYER "StopLag", STOP_LAG, STOP_LAG_TEXT;
    DeployerMinSpeed: DEPLOYER "MinSpeed", min_speed(DeciDegreePerSecond), MIN_SPEED_TEXT;
    DeployerStopLagSeen: DEPLOYER "StopLagSeen", STOP_LAG.measured(), STOP_LAG_SEEN_TEXT;
    DeployerMinSpeedSeen: DEPLOYER "MinSpeedSeen", min_speed(DeciDegreePerSecond).measured(), MIN_SPEED_SEEN_TEXT;
    DeployerTravelTime: DEPLOYER "TravelTime",
        one(Millisecond, 1000, 120_000, 20_000).on_unit(), text(
        "Longest time of a full deployment or stowing; one that takes longer is reported as a \
        fault.",
        "Наибольшее время полного развёртывания или свёртывания; превышение считается \
        неисправностью.");

    Valve1TravelTime: VALVE1 "TravelTime", VALVE_TRAVEL, VALVE_TRAVEL_TEXT;
    Valve1ValveType: VALVE1 "ValveType", VALVE_TYPE, VALVE_TYPE_TEXT;
    Valve1MaxCurrent: VALVE1 "MaxCurrent", byte(DeciAmpere, 1, 60), VALVE_CURRENT_TEXT;
    Valve2TravelTime: VALVE2 "TravelTime", VALVE_TRAVEL, VALVE_TRAVEL_TEXT;
    Valve2ValveType: VALVE2 "ValveType", VALVE_TYPE, VALVE_TYPE_TEXT;
    Valve2MaxCurrent: VALVE2 "MaxCurrent", byte(DeciAmpere, 1, 60), VALVE_CURRENT_TEXT;

    ControlProgram0: CONTROL "Program0", PROGRAM, PROGRAM_TEXT;
    ControlProgram1: CONTROL "Program1", PROGRAM, PROGRAM_TEXT;
    ControlProgram2: CONTROL "Program2", PROGRAM, PROGRAM_TEXT;
    ControlProgram3: CONTROL "Program3", PROGRAM, PROGRAM_TEXT;
    ControlProgram4: CONTROL "Program4", PROGRAM, PROGRAM_TEXT;
    ControlProgram5: CONTROL "Program5", PROGRAM, PROGRAM_TEXT;
    ControlProgram6: CONTROL "Program6", PROGRAM, PROGRAM_TEXT;
    ControlProgram7: CONTROL "Program7", PROGRAM, PROGRAM_TEXT;
    ControlTrajectory0: CONTROL "Trajectory0", TRAJECTORY, TRAJECTORY_TEXT;
    ControlTrajectory1: CONTROL "Trajectory1", TRAJECTORY, TRAJECTORY_TEXT;
    ControlTrajectory2: CONTROL "Trajectory2", TRAJECTORY, TRAJECTORY_TEXT;
    ControlTrajectory3: CONTROL "Trajectory3", TRAJECTORY, TRAJECTORY_TEXT;
    ControlTrajectory4: CONTROL "Trajectory4", TRAJECTORY, TRAJECTORY_TEXT;
    ControlTrajectory5: CONTROL "Trajectory5", TRAJECTORY, TRAJECTORY_TEXT;
    ControlTrajectory6: CONTROL "Trajectory6", TRAJECTORY, TRAJECTORY_TEXT;
    ControlTrajectory7: CONTROL "Trajectory7", TRAJECTORY, TRAJECTORY_TEXT;
    ControlBallistics: CONTROL "Ballistics", choice(1, 1), text(
        "Whether the elevation is corrected for the fall of the jet: 0 aims straight, 1 corrects.",
        "Поправка угла возвышения на падение струи: 0 — прямая наводка, 1 — с поправкой.");
    ControlNozzleDiameter: CONTROL "NozzleDiameter", one(DeciMillimetre, 10, 2000, 280), text(
        "Diameter of the nozzle's outlet; the ballistics take from it how soon the jet breaks up.",
        "Диаметр выходного отверстия насадка; по нему баллистика считает, где распадается струя.");
    ControlHeight: CONTROL "Height", one(Centimetre, -10_000, 10_000, 150), text(
        "Height of the nozzle above the ground that is extinguished; negative when it is below.",
        "Высота насадка над уровнем тушения; отрицательная, если ствол стоит ниже.");

    DetectorHotbeds: DETECTOR "Hotbeds",
        one(Unit::None, i32::MIN, i32::MAX, 0).len(0, 20, 5).measured(), text(
        "Fire spots found by the last search, brightest first: left, right, low, high (') and \
        brightness of up to four.",
        "Очаги загорания, найденные последним поиском, ярчайший первым: лево, право, низ, верх (') и \
        яркость, не более четырёх.");
    DetectorJustifyHorizontal: DETECTOR "JustifyHorizontal", JUSTIFY, text(
        "Angle between the axis of the detector and the barrel, horizontally; StartJustify \
        measures it.",
        "Угол между осью датчика и ствола по горизонтали; измеряется юстировкой StartJustify.");
    DetectorJustifyVertical: DETECTOR "JustifyVertical", JUSTIFY, text(
        "Angle between the axis of the detector and the barrel, vertically; StartJustify measures \
        it.",
        "Угол между осью датчика и ствола по вертикали; измеряется юстировкой StartJustify.");
    DetectorScanStep: DETECTOR "ScanStep", one(Arcmin, 30, 3600, 600), text(
        "Vertical step between the lines of a search; keep it below FieldOfView, or strips stay \
        unseen.",
        "Шаг по вертикали между строками поиска; держите его меньше FieldOfView, иначе останутся \
        пропуски.");
    DetectorFieldOfView: DETECTOR "FieldOfView", one(Arcmin, 60, 5400, 900), text(
        "Angle that the detector sees at once.",
        "Угол, который датчик видит одновременно.");
    DetectorThreshold: DETECTOR "Threshold", one(Unit::None, 1, 100_000, 50), text(
        "Brightness from which a spot counts as a fire spot; raise it against sun and hot machinery.",
        "Яркость, начиная с которой пятно считается очагом; повысьте при засветке солнцем или \
        горячим оборудованием.");

    ExternalConnTimeout: EXTERNAL_CONN "Timeout", TIMEOUT, TIMEOUT_TEXT;
    ExternalConnCheck: EXTERNAL_CONN "Check", choice(1, 0).optional(), CHECK_TEXT;
    RadioTimeout: RADIO "Timeout", TIMEOUT, TIMEOUT_TEXT;
    RadioCheck: RADIO "Check", choice(1, 0).optional(), CHECK_TEXT;
}
