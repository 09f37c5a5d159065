//! §3.3.7 «Флаги состояния Detector».

use super::structure;
use crate::flags::flag_class;
use crate::flags::words::{Words, words};

structure! {
    /// State of Detector (§3.3, §3.3.7), 4 bytes.
    DetectorStatus [flags: DetectorFlags] {}
}

flag_class! {
    /// §3.3.7 Detector.
    DetectorFlags "3.3.7";
    SEARCHING = 16 "Searching" Info SEARCHING;
    FOUND = 17 "Found" Alarm FOUND;
    DEVICE_FAULT = 18 "DeviceFault" Alarm DEVICE_FAULT;
    CANCELED = 19 "Canceled" Notice CANCELED;
    BAD_SECTOR = 20 "BadSector" Warning BAD_SECTOR;
    JUSTIFYING = 21 "Justifying" Info JUSTIFYING;
    JUSTIFIED = 22 "Justified" Info JUSTIFIED;
    DIRTY_LENS = 23 "DirtyLens" Warning DIRTY_LENS;
}

const SEARCHING: Words = words(
    ["A search for fire spots is going on.", "Идёт поиск очага загорания."],
    ["StartSeek was accepted.", "Принят запрос StartSeek."],
    [
        "Nothing; Move and Open are denied until it ends; Stop Detector breaks it off.",
        "Ничего; до завершения Move и Open отклоняются; прервать можно Stop Detector.",
    ],
);
const FOUND: Words = words(
    ["One or more fire spots are found.", "Обнаружен один или несколько очагов загорания."],
    [
        "A fire; or the sun, welding, an open furnace or hot machinery brighter than Threshold.",
        "Загорание; либо солнце, сварка, открытая печь или горячее оборудование ярче Threshold.",
    ],
    [
        "Read Hotbeds, confirm by camera or eye, start extinguishing at the centre of the \
        brightest one.",
        "Прочитайте Hotbeds, подтвердите камерой или глазами, начинайте тушение с центра самого \
        яркого.",
    ],
);
const DEVICE_FAULT: Words = words(
    ["The fire detector is faulty.", "Неисправен датчик обнаружения очага загорания."],
    [
        "No answer from the detector, its self-test failed, or alignment could not find its \
        mark.",
        "Датчик не отвечает, не прошёл самопроверку либо при юстировке не найдена метка.",
    ],
    [
        "Check the detector's cable and supply, clean the window, align again; the monitor \
        cannot find fires by itself meanwhile.",
        "Проверьте кабель и питание датчика, протрите стекло, повторите юстировку; до ремонта \
        ствол не находит очаги сам.",
    ],
);
const CANCELED: Words = words(
    ["The search was cancelled.", "Поиск очага загорания отменён."],
    [
        "Stop Detector, Stop All, Lockout, or a drive that failed on the way.",
        "Stop Detector, Stop All, Lockout либо отказ привода в процессе.",
    ],
    [
        "If it was not stopped by a user, look at the flags of the drives; the fire spots found \
        so far may be incomplete.",
        "Если никто не останавливал, посмотрите флаги приводов; список найденных очагов может быть \
        неполным.",
    ],
);
const BAD_SECTOR: Words = words(
    ["The sector of the search is wrong.", "Неверный сектор поиска очага загорания."],
    [
        "StartSeek gave a sector outside the limits of Horizontal or Vertical.",
        "В StartSeek задан сектор вне пределов Horizontal или Vertical.",
    ],
    [
        "Compare the sector with RetrieveLimits; angles are in minutes, not degrees.",
        "Сравните сектор с RetrieveLimits; углы задаются в минутах, а не в градусах.",
    ],
);
const JUSTIFYING: Words = words(
    [
        "Barrel and detector are being aligned.",
        "Осуществляется юстировка системы ствол — \
    датчик.",
    ],
    ["StartJustify was accepted.", "Принят запрос StartJustify."],
    [
        "Keep the reference source still and in view until it ends; Stop Detector breaks it off.",
        "До завершения держите опорный источник неподвижно и в поле зрения; прервать можно Stop \
        Detector.",
    ],
);
const JUSTIFIED: Words = words(
    [
        "The alignment of barrel and detector ended well.",
        "Юстировка системы ствол — датчик успешно завершена.",
    ],
    ["StartJustify came to its end.", "StartJustify выполнен до конца."],
    [
        "Nothing; the result is in JustifyHorizontal and JustifyVertical.",
        "Ничего; результат — в JustifyHorizontal и JustifyVertical.",
    ],
);
const DIRTY_LENS: Words = words(
    ["The detector's window is dirty.", "Загрязнено стекло датчика."],
    [
        "Dust, soot, foam, oil mist, ice or paint on the window; the detector sees less than it \
        should.",
        "Пыль, копоть, пена, масляный туман, лёд или краска на стекле; датчик видит хуже, чем \
        должен.",
    ],
    [
        "Clean the window with a soft cloth and alcohol; check that the blow-off, if any, works.",
        "Протрите стекло мягкой тканью со спиртом; проверьте обдув, если он есть.",
    ],
);
