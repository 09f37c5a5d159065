//! §3.3.2 «Флаги состояния General».

use super::structure;
use crate::flags::flag_class;
use crate::flags::words::{Words, words};

structure! {
    /// State of the monitor as a whole (§3.3, §3.3.2), 10 bytes.
    GeneralStatus [flags: GeneralFlags] {
        main_voltage u16 Volt "Supply voltage" "Напряжение питания";
        pressure u16 DeciAtmosphere "Pressure of water or foam" "Давление воды или пены";
        flowrate u16 LitrePerSecond "Flow" "Расход";
    }
}

flag_class! {
    /// §3.3.2 General.
    GeneralFlags "3.3.2";
    PRESSURE_SENSOR_BREAK = 16 "PressureSensorBreak" Warning PRESSURE_SENSOR_BREAK;
    PRESSURE_SENSOR_SHORT = 17 "PressureSensorShort" Warning PRESSURE_SENSOR_SHORT;
    LOCKED_OUT = 18 "LockedOut" Warning LOCKED_OUT;
}

const PRESSURE_SENSOR_BREAK: Words = words(
    ["The circuit of the pressure sensor is open.", "Обрыв цепи датчика давления."],
    [
        "Less than 4 mA flow: a broken or loose wire, a corroded connector, a dead sensor, or none \
        fitted.",
        "Ток меньше 4 мА: обрыв или плохой контакт провода, окисленный разъём, отказ датчика либо \
        датчик не установлен.",
    ],
    [
        "Measure the loop current and its 24 V at the sensor; the pressure is unknown meanwhile, \
        so ballistics aim straight.",
        "Измерьте ток петли и 24 В на датчике; пока давление неизвестно, баллистика наводит прямо.",
    ],
);
const PRESSURE_SENSOR_SHORT: Words = words(
    ["The circuit of the pressure sensor is shorted.", "Короткое замыкание цепи датчика давления."],
    [
        "More than 20 mA flow: water in the connector, a pinched cable, or a failed sensor.",
        "Ток больше 20 мА: вода в разъёме, пережатый кабель либо отказ датчика.",
    ],
    [
        "Unplug the sensor: if the flag turns into PressureSensorBreak, replace the sensor, else \
        look for the short in the cable.",
        "Отключите датчик: если флаг сменится на PressureSensorBreak, замените датчик, иначе ищите \
        замыкание в кабеле.",
    ],
);
const LOCKED_OUT: Words = words(
    [
        "The emergency lockout is on: nothing moves and control requests are answered Denied.",
        "Включена аварийная блокировка: движения нет, на команды управления выдаётся Denied.",
    ],
    [
        "A client sent Lockout with the key Enable; it survives restart and loss of power.",
        "Кто-то отправил Lockout с ключом Enable; блокировка переживает перезапуск и отключение \
        питания.",
    ],
    [
        "Find out who locked it and why, make sure that no person is at the barrel, then send \
        Lockout with the key Disable.",
        "Выясните, кто и почему включил блокировку, убедитесь, что у ствола никого нет, затем \
        отправьте Lockout с ключом Disable.",
    ],
);
