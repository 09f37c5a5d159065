//! §3.3.1 «Общие флаги состояния»: bits 0–15, the same for every subsystem.

use crate::flags::flag_class;
use crate::flags::words::{Words, words};

flag_class! {
    /// §3.3.1 What the status words of all subsystems have in common.
    CommonFlags "3.3.1";
}

pub(crate) const CONFIG_FAULT: Words = words(
    [
        "The configuration could not be read from the non-volatile memory.",
        "Конфигурация не прочитана из ЭНОЗУ.",
    ],
    [
        "The memory is damaged or worn out, or power failed while it was written; the subsystem \
        runs on defaults, so limits and currents may not suit this monitor.",
        "ЭНОЗУ повреждено или выработало ресурс, либо питание пропало во время записи; подсистема \
        работает со значениями по умолчанию, пределы и токи могут не подходить этому стволу.",
    ],
    [
        "Write the parameters again and send Restart; if the flag returns, clean the flash, and \
        then replace the control board.",
        "Запишите параметры заново и выполните Restart; если флаг вернётся, очистите ЭНОЗУ, затем \
        замените плату управления.",
    ],
);
pub(crate) const CONFIG_INVALID: Words = words(
    [
        "Some parameters of the configuration have values that are not allowed.",
        "Некоторые параметры конфигурации имеют недопустимые значения.",
    ],
    [
        "The parameters were never set (a new board, or after CleanFlash), or come from another \
        version of the program.",
        "Параметры не заданы (новая плата или после CleanFlash) либо записаны другой версией \
        программы.",
    ],
    [
        "Set every required parameter of the subsystem, then Restart; SetParam answers \
        IncompleteConfig until the set is complete.",
        "Задайте все обязательные параметры подсистемы, затем Restart; до заполнения набора \
        SetParam отвечает IncompleteConfig.",
    ],
);
pub(crate) const CONFIG_WRITE_FAULT: Words = words(
    ["Writing to the store of parameters failed.", "Ошибка записи в хранилище параметров."],
    [
        "The flash is worn out or its supply sagged while it was written; the new value is lost at \
        the next reset.",
        "ЭНОЗУ выработало ресурс или его питание просело во время записи; новое значение пропадёт \
        при сбросе.",
    ],
    [
        "Check the supply voltage and write the parameter again; if it fails again, replace the \
        control board.",
        "Проверьте напряжение питания и повторите запись; при повторной ошибке замените плату \
        управления.",
    ],
);
pub(crate) const CONN_LOST: Words = words(
    [
        "The connection to the unit that carries out the requests is lost.",
        "Потеряна связь с исполнительным устройством.",
    ],
    [
        "Cable of the internal bus broken or wet, terminator missing, the unit without power, or \
        its address changed.",
        "Обрыв или намокание кабеля внутренней магистрали, нет терминатора, блок обесточен или \
        изменён его адрес.",
    ],
    [
        "Check the unit's supply and the bus cable up to its glands; swap the unit with a sound \
        one to distinguish it from the line.",
        "Проверьте питание блока и кабель магистрали вплоть до вводов; поменяйте блок на \
        исправный, чтобы отличить его отказ от отказа линии.",
    ],
);
pub(crate) const BAD_POWER: Words = words(
    [
        "The supply voltage is outside the permitted range.",
        "Напряжение питания вне допустимого диапазона.",
    ],
    [
        "A weak supply or a long thin cable that sags when the drives start, a discharged battery, \
        or a charger set too high.",
        "Слабый источник или длинный тонкий кабель с просадкой при пуске приводов, разряженная \
        батарея либо завышенное напряжение зарядного устройства.",
    ],
    [
        "Compare main_voltage of General with a meter at the terminals, at rest and in motion; \
        check MainVoltageMin and MainVoltageMax.",
        "Сравните main_voltage подсистемы General с показаниями прибора на клеммах в покое и при \
        движении; проверьте MainVoltageMin и MainVoltageMax.",
    ],
);
pub(crate) const REMOTE_PA_INCOMPLETE: Words = words(
    [
        "Access to the remote unit's parameters: the data came incomplete.",
        "Обращение к параметрам удалённого устройства: неполные данные.",
    ],
    [
        "Losses on the internal bus, or a unit whose program is of another version and sends fewer \
        values.",
        "Потери на внутренней магистрали либо другая версия программы блока с меньшим числом \
        значений.",
    ],
    [
        "Repeat the request; if it stays, check the bus cable and compare the versions of the \
        programs.",
        "Повторите запрос; если повторяется, проверьте кабель магистрали и сравните версии \
        программ.",
    ],
);
pub(crate) const REMOTE_PA_BAD_ID: Words = words(
    [
        "Access to the remote unit's parameters: the unit does not know the identifier.",
        "Обращение к параметрам удалённого устройства: неверный идентификатор.",
    ],
    [
        "The remote unit is of another type or has an older program than the control system \
        expects.",
        "Удалённый блок другого типа или с более старой программой, чем ожидает система \
        управления.",
    ],
    [
        "Check which unit is fitted against DriveType or ValveType; update its program.",
        "Сверьте установленный блок с DriveType или ValveType; обновите его программу.",
    ],
);
pub(crate) const REMOTE_PA_BAD_VAL: Words = words(
    [
        "Access to the remote unit's parameters: the unit refused the value.",
        "Обращение к параметрам удалённого устройства: неверное значение.",
    ],
    [
        "The value suits the control system but not this unit, for example a speed above what its \
        motor can do.",
        "Значение допустимо для системы управления, но не для этого блока, например скорость выше \
        возможной для его двигателя.",
    ],
    [
        "Read the parameter back, and set a value inside the unit's own range.",
        "Прочитайте параметр и задайте значение в собственном диапазоне блока.",
    ],
);
pub(crate) const REMOTE_PA_ERROR: Words = words(
    [
        "Access to the remote unit's parameters: internal error of the unit.",
        "Обращение к параметрам удалённого устройства: внутренняя ошибка.",
    ],
    [
        "The remote unit could not read or write its own memory.",
        "Удалённый блок не смог прочитать или записать собственную память.",
    ],
    [
        "Switch the unit off and on and repeat; if it stays, replace the unit.",
        "Выключите и включите блок и повторите; если ошибка остаётся, замените блок.",
    ],
);
pub(crate) const RESTARTING: Words = words(
    ["The subsystem waits for the restart.", "Подсистема ожидает перезапуска."],
    ["Restart was accepted.", "Принят запрос Restart."],
    [
        "Wait a few seconds and ask again; if it never ends, switch the power off and on.",
        "Подождите несколько секунд и повторите опрос; если состояние не проходит, снимите и \
        подайте питание.",
    ],
);
pub(crate) const INTERNAL_FAULT: Words = words(
    ["The subsystem cannot control its device.", "Ошибка управления устройством."],
    [
        "A driver, relay or input of the board does not obey; for Control, a drive failed during \
        extinguishing.",
        "Не подчиняется драйвер, реле или вход платы; для Control — отказ привода во время \
        тушения.",
    ],
    [
        "Look at the other flags of this subsystem and of the drives, read GetCrashData, restart; \
        then replace the board.",
        "Посмотрите остальные флаги подсистемы и приводов, прочитайте GetCrashData, перезапустите; \
        затем замените плату.",
    ],
);
pub(crate) const WDT_FAULT: Words = words(
    [
        "The remote unit was reset by its watchdog.",
        "Был нештатный сброс программы удалённого устройства по сторожевому таймеру.",
    ],
    [
        "Interference from motors or radio, a sagging supply of the unit, or a fault of its \
        program.",
        "Помехи от двигателей или радиостанции, просадка питания блока либо сбой его программы.",
    ],
    [
        "Check earthing and shields of the cable; note what moved at that moment and report it \
        with the program's version.",
        "Проверьте заземление и экраны кабеля; запишите, что двигалось в этот момент, и сообщите \
        вместе с версией программы.",
    ],
);
pub(crate) const PROTOCOL_FAULT: Words = words(
    ["The exchange with the unit breaks its protocol.", "Ошибка протокола связи с устройством."],
    [
        "Noise on the internal bus, two units with one address, or a unit of another version.",
        "Помехи на внутренней магистрали, два блока с одним адресом или блок другой версии.",
    ],
    [
        "Disconnect the units one by one; check the terminators and the version of the unit's \
        program.",
        "Отключайте блоки по одному; проверьте терминаторы и версию программы блока.",
    ],
);
pub(crate) const DISABLED: Words = words(
    [
        "The subsystem is deactivated and does not hinder the others.",
        "Подсистема деактивирована и не влияет на работу остальных.",
    ],
    [
        "It was switched off by configuration or service, or its equipment is not fitted.",
        "Отключена конфигурацией или при обслуживании, либо её оборудование не установлено.",
    ],
    [
        "Nothing, if intended; else include it by the parameter Chain and restart.",
        "Ничего, если так задумано; иначе включите её параметром Chain и перезапустите.",
    ],
);
pub(crate) const TERMINATED: Words = words(
    ["The subsystem has ended its work.", "Подсистема завершила свою работу."],
    [
        "All operations were closed before a restart or an update of the program.",
        "Операции завершены перед перезапуском или обновлением программы.",
    ],
    [
        "Wait for the restart; if it does not come, switch the power off and on.",
        "Дождитесь перезапуска; если его нет, снимите и подайте питание.",
    ],
);
pub(crate) const RESERVED: Words = words(
    ["Reserved by the document.", "Зарезервировано документом."],
    [
        "A program newer than the document, or corrupted data.",
        "Программа новее документа либо искажённые данные.",
    ],
    [
        "Note the program's version; it has no known meaning.",
        "Запишите версию программы; известного значения флаг не имеет.",
    ],
);
