//! §3.3.5 «Флаги состояния Valve1, Valve2».

use super::structure;
use crate::flags::flag_class;
use crate::flags::words::{Words, words};

structure! {
    /// State of Valve1 or Valve2 (§3.3, §3.3.5), 4 bytes.
    ValveStatus [flags: ValveFlags] {}
}

flag_class! {
    /// §3.3.5 Valve1, Valve2.
    ValveFlags "3.3.5";
    OPENING = 16 "Opening" Info OPENING;
    CLOSING = 17 "Closing" Info CLOSING;
    AMPERAGE_OVERLOAD = 18 "AmperageOverload" Alarm AMPERAGE_OVERLOAD;
    BLOCKED = 19 "Blocked" Warning BLOCKED;
    OPEN_SENSOR_FAULT = 20 "OpenSensorFault" Warning OPEN_SENSOR_FAULT;
    CLOSE_SENSOR_FAULT = 21 "CloseSensorFault" Warning CLOSE_SENSOR_FAULT;
    OPEN = 22 "Open" Info OPEN;
    CLOSED = 23 "Closed" Info CLOSED;
}

const OPENING: Words = words(
    ["The valve is opening.", "Затвор открывается."],
    ["Open, or the button of the post.", "Запрос Open или кнопка поста."],
    [
        "Nothing; if it lasts longer than TravelTime, the valve is stuck or its sensor is faulty.",
        "Ничего; если дольше TravelTime — затвор заклинил или неисправен его датчик.",
    ],
);
const CLOSING: Words = words(
    ["The valve is closing.", "Затвор закрывается."],
    [
        "Close, Lockout, a reset, or the button of the post.",
        "Запрос Close, Lockout, сброс или \
    кнопка поста.",
    ],
    [
        "Nothing; if it lasts longer than TravelTime, the valve is stuck or its sensor is faulty.",
        "Ничего; если дольше TravelTime — затвор заклинил или неисправен его датчик.",
    ],
);
const AMPERAGE_OVERLOAD: Words = words(
    [
        "The valve's motor drew too much current and was stopped.",
        "Перегрузка двигателя затвора по \
    току.",
    ],
    [
        "A stone or ice in the seat, deposits after a long standstill, pressure above the valve's \
        rating, or MaxCurrent set too low.",
        "Камень или лёд в седле, отложения после долгого простоя, давление выше допустимого для \
        затвора либо занижен MaxCurrent.",
    ],
    [
        "Drive the valve the other way and again; then shut the water off, turn it by the \
        handwheel and clean the seat.",
        "Подайте команду в обратную сторону и повторите; затем перекройте воду, проверните \
        маховиком и очистите седло.",
    ],
);
const BLOCKED: Words = words(
    ["The hardware interlock of the valve is on.", "Включена аппаратная блокировка затвора."],
    [
        "The local/remote switch of the valve's unit is on local, the handwheel is engaged, or an \
        interlock contact is open.",
        "Переключатель блока затвора в местном режиме, введён маховик либо разомкнут контакт \
        блокировки.",
    ],
    [
        "Set the switch to remote, release the handwheel, check the interlock circuit; a person \
        may be working on the valve.",
        "Переведите в дистанционный режим, выведите маховик, проверьте цепь блокировки; возможно, \
        с затвором работают люди.",
    ],
);
const OPEN_SENSOR_FAULT: Words = words(
    ["The sensor of the open position is faulty.", "Неисправность датчика положения «Открыто»."],
    [
        "It did not close within TravelTime, or it and the other end's sensor are closed together: \
        shifted cam, broken wire, water in the box.",
        "Не сработал за TravelTime или замкнут одновременно с противоположным: смещён кулачок, \
        обрыв провода, вода в коробке.",
    ],
    [
        "Look at the pointer on the valve: if it is open, adjust or replace the sensor; if not, \
        free the valve.",
        "Посмотрите на указатель затвора: если он открыт, отрегулируйте или замените датчик; если \
        нет — освободите затвор.",
    ],
);
const CLOSE_SENSOR_FAULT: Words = words(
    ["The sensor of the closed position is faulty.", "Неисправность датчика положения «Закрыто»."],
    [
        "It did not close within TravelTime, or it and the other end's sensor are closed together: \
        shifted cam, broken wire, water in the box.",
        "Не сработал за TravelTime или замкнут одновременно с противоположным: смещён кулачок, \
        обрыв провода, вода в коробке.",
    ],
    [
        "Look whether water flows: if not, adjust or replace the sensor; if it does, the valve is \
        not tight, close the line by hand.",
        "Посмотрите, идёт ли вода: если нет, отрегулируйте или замените датчик; если идёт — затвор \
        не закрыт, перекройте линию вручную.",
    ],
);
const OPEN: Words = words(
    ["The valve is open: the agent may flow.", "Затвор открыт: подаётся огнетушащее вещество."],
    ["It was opened.", "Затвор был открыт."],
    [
        "Nothing; Wrap is denied until it is closed. No flow means no pressure: check the pump and \
        the main valve.",
        "Ничего; до закрытия Wrap отклоняется. Нет расхода — нет давления: проверьте насос и \
        задвижку.",
    ],
);
const CLOSED: Words = words(
    ["The valve is closed.", "Затвор закрыт."],
    [
        "It was closed, or the monitor has just been switched on.",
        "Затвор был закрыт либо ствол \
    только что включён.",
    ],
    [
        "Nothing; neither this flag nor Open means that it is in between.",
        "Ничего; если нет ни \
    этого флага, ни Open — затвор в промежуточном положении.",
    ],
);
