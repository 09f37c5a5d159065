//! §3.3.4 «Флаги состояния Vertical, Horizontal, Nozzle»; bits 16–27 are the Deployer's too.

use super::structure;
use crate::flags::flag_class;
use crate::flags::words::{Words, words};

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

flag_class! {
    /// §3.3.4 Vertical, Horizontal, Nozzle.
    DriveFlags "3.3.4";
    MOVE = 16 "Move" Info MOVE;
    POSITION_WAY_FAULT = 17 "PositionWayFault" Alarm POSITION_WAY_FAULT;
    AMPERAGE_OVERLOAD = 18 "AmperageOverload" Warning AMPERAGE_OVERLOAD;
    POS_ENCODER_FAULT = 19 "PosEncoderFault" Alarm POS_ENCODER_FAULT;
    SPEED_ENCODER_FAULT = 20 "SpeedEncoderFault" Alarm SPEED_ENCODER_FAULT;
    MOTOR_BROKEN = 21 "MotorBroken" Alarm MOTOR_BROKEN;
    SPEED_WAY_FAULT = 22 "SpeedWayFault" Alarm SPEED_WAY_FAULT;
    LIMITLESS = 23 "Limitless" Warning LIMITLESS;
    MIN_LIMIT_REACHED = 24 "MinLimitReached" Info MIN_LIMIT_REACHED;
    MAX_LIMIT_REACHED = 25 "MaxLimitReached" Info MAX_LIMIT_REACHED;
    ABSOLUTE_MIN_LIMIT_REACHED = 26 "AbsoluteMinLimitReached" Notice
        ABSOLUTE_MIN_LIMIT_REACHED;
    ABSOLUTE_MAX_LIMIT_REACHED = 27 "AbsoluteMaxLimitReached" Notice
        ABSOLUTE_MAX_LIMIT_REACHED;
    SPEED_SLOW_AMP = 28 "SpeedSlowAmp" Notice SPEED_SLOW_AMP;
    TRV_ENGAGE = 29 "TRVEngage" Info TRV_ENGAGE;
}

pub(crate) const MOVE: Words = words(
    ["The drive is moving.", "Привод в движении."],
    [
        "Move, a button, a program of extinguishing, a search or the deployment drives it.",
        "Его ведут Move, кнопка, программа тушения, поиск или развёртывание.",
    ],
    ["Nothing; Stop ends it.", "Ничего; остановить можно запросом Stop."],
);
pub(crate) const POSITION_WAY_FAULT: Words = words(
    [
        "The position sensor is connected the wrong way round.",
        "Неверное подключение датчика \
    положения.",
    ],
    [
        "The position changes against the direction of the motor: phases of the encoder or wires \
        of the motor swapped after a repair.",
        "Положение меняется против направления двигателя: после ремонта перепутаны фазы энкодера \
        или провода двигателя.",
    ],
    [
        "Swap the encoder's phases A and B (or the motor's wires), then set the zero point and \
        the limits again.",
        "Поменяйте местами фазы A и B энкодера (или провода двигателя), затем заново задайте \
        нулевую точку и пределы.",
    ],
);
pub(crate) const AMPERAGE_OVERLOAD: Words = words(
    [
        "The drive drew too much current and was stopped; the flag goes 3 s after the stop.",
        "Перегрузка по току, привод остановлен; флаг снимается через 3 секунды после остановки.",
    ],
    [
        "The barrel rests on an obstacle or a stop, ice or dried grease in the gear, a bearing has \
        seized, a hose pulls, or MaxCurrent is set too low.",
        "Ствол упёрся в препятствие или упор, лёд или загустевшая смазка в редукторе, заклинил \
        подшипник, тянет рукав либо занижен MaxCurrent.",
    ],
    [
        "Drive away from the obstacle, turn the node by hand with the power off, and compare the \
        current with that of a sound drive before MaxCurrent is raised.",
        "Отведите от препятствия, проверните узел вручную без питания и сравните ток с исправным \
        приводом, прежде чем повышать MaxCurrent.",
    ],
);
pub(crate) const POS_ENCODER_FAULT: Words = words(
    ["The position sensor is faulty.", "Неисправность датчика положения."],
    [
        "The motor runs and the position does not change: sensor unplugged, broken cable, coupling \
        slipped, or a gear that no longer drives the barrel.",
        "Двигатель вращается, а положение не меняется: датчик отключён, обрыв кабеля, \
        проскальзывает муфта либо редуктор не ведёт ствол.",
    ],
    [
        "Turn the node by hand and watch the position; check plug, cable and coupling, and check \
        the zero point after the repair.",
        "Поверните узел вручную и следите за положением; проверьте разъём, кабель и муфту, после \
        ремонта проверьте нулевую точку.",
    ],
);
pub(crate) const SPEED_ENCODER_FAULT: Words = words(
    ["The speed sensor is faulty.", "Неисправность датчика скорости."],
    [
        "No pulses from the motor's sensor while it runs: broken wire, wet plug, failed sensor, or \
        a stalled motor.",
        "При вращении нет импульсов датчика двигателя: обрыв провода, влага в разъёме, отказ \
        датчика либо двигатель не вращается.",
    ],
    [
        "Look at the current: with current and no motion the motor is jammed, without current \
        check the motor, else check the sensor's plug and supply.",
        "Посмотрите на ток: ток есть, движения нет — заклинило; тока нет — проверьте двигатель; \
        иначе проверьте разъём и питание датчика.",
    ],
);
pub(crate) const MOTOR_BROKEN: Words = words(
    ["The circuit of the motor is faulty.", "Неисправность цепи двигателя."],
    [
        "Voltage is applied and no current flows: broken cable, worn brushes, a burnt winding, a \
        blown fuse or driver.",
        "Напряжение подано, тока нет: обрыв кабеля, износ щёток, перегорела обмотка, \
        предохранитель или драйвер.",
    ],
    [
        "Measure the resistance of the motor at the board's terminals and at the motor; what \
        differs is the cable; aim by hand where there is a handwheel.",
        "Измерьте сопротивление двигателя на клеммах платы и на самом двигателе: разница — в \
        кабеле; при наличии маховика наводите вручную.",
    ],
);
pub(crate) const SPEED_WAY_FAULT: Words = words(
    [
        "The speed sensor is connected the wrong way round.",
        "Неверное подключение датчика \
    скорости.",
    ],
    [
        "The sensor shows a speed against the direction of the motor: its phases or the motor's \
        wires are swapped.",
        "Датчик показывает скорость против направления двигателя: перепутаны его фазы или провода \
        двигателя.",
    ],
    [
        "Swap the phases of the speed sensor, and check that Move to a greater position goes up or \
        left.",
        "Поменяйте фазы датчика скорости и проверьте, что Move в большее положение ведёт вверх или \
        влево.",
    ],
);
pub(crate) const LIMITLESS: Words = words(
    [
        "The control of the limits of travel is off.",
        "Включён режим без контроля пределов перемещений.",
    ],
    [
        "SwitchLimits off was sent, to set the zero point or the limits.",
        "Отправлен SwitchLimits с выключением пределов для установки нуля или пределов.",
    ],
    [
        "Watch cables, hoses and people: nothing but the current stops the drive; end with \
        SwitchLimits on, or reject.",
        "Следите за кабелями, рукавами и людьми: привод остановит только ток; завершите \
        SwitchLimits с включением или отменой.",
    ],
);
pub(crate) const MIN_LIMIT_REACHED: Words = words(
    [
        "The lower or right limit is reached (for the nozzle, the wide one).",
        "Достигнут нижний или правый предел (для насадка — предел «шире»).",
    ],
    ["The drive was sent there.", "Привод направлен в эту точку."],
    [
        "Nothing; if the limit is too near, change MinLimit.",
        "Ничего; если предел слишком близко, измените MinLimit.",
    ],
);
pub(crate) const MAX_LIMIT_REACHED: Words = words(
    [
        "The upper or left limit is reached (for the nozzle, the narrow one).",
        "Достигнут верхний или левый предел (для насадка — предел «уже»).",
    ],
    ["The drive was sent there.", "Привод направлен в эту точку."],
    [
        "Nothing; if the limit is too near, change MaxLimit.",
        "Ничего; если предел слишком близко, измените MaxLimit.",
    ],
);
const ABSOLUTE_CAUSE: [&str; 2] = [
    "The drive is at its mechanical end: limits were off, the limit is set beyond the \
        switch, or the zero point has moved.",
    "Привод у механического упора: пределы были выключены, предел задан дальше датчика либо \
        сместилась нулевая точка.",
];
const ABSOLUTE_REMEDY: [&str; 2] = [
    "Drive back; if the position does not match the barrel, set the zero point again; if the \
        switch stays closed, check it.",
    "Отведите привод; если положение не соответствует месту, задайте нулевую точку заново; \
        если датчик остаётся замкнут, проверьте его.",
];
pub(crate) const ABSOLUTE_MIN_LIMIT_REACHED: Words = words(
    [
        "The limit switch at the lower or right end is closed.",
        "Достигнуто ограничение датчика конечного положения (низ или право).",
    ],
    ABSOLUTE_CAUSE,
    ABSOLUTE_REMEDY,
);
pub(crate) const ABSOLUTE_MAX_LIMIT_REACHED: Words = words(
    [
        "The limit switch at the upper or left end is closed.",
        "Достигнуто ограничение датчика конечного положения (верх или лево).",
    ],
    ABSOLUTE_CAUSE,
    ABSOLUTE_REMEDY,
);
pub(crate) const SPEED_SLOW_AMP: Words = words(
    [
        "The drive goes slower because its current is high.",
        "Действует режим снижения скорости привода при перегрузке.",
    ],
    [
        "The reaction of the jet, wind, cold grease or the beginning of a jam; the current is \
        above SlowCurrent.",
        "Реакция струи, ветер, загустевшая смазка или начало заклинивания; ток выше SlowCurrent.",
    ],
    [
        "Usually nothing; if it is so without water and in warmth too, grease or repair the gear.",
        "Обычно ничего; если так и без воды, и в тепле — смажьте или отремонтируйте редуктор.",
    ],
);
pub(crate) const TRV_ENGAGE: Words = words(
    [
        "The nozzle of the mini-robot works as a TRV (finely sprayed water).",
        "Мини-робот: включён режим ТРВ насадка (тонкораспылённая вода).",
    ],
    [
        "The nozzle is at or below TrvPosition.",
        "Насадок находится в положении TrvPosition или ниже.",
    ],
    [
        "Nothing; for a solid jet move the nozzle narrower.",
        "Ничего; для сплошной струи переведите насадок «уже».",
    ],
);
