//! Reasons of a refusal: the scenario of the document that the answer belongs to.

use lafet_proto::dictionary::{self, Text};
use lafet_proto::request::{Body, LimitsState};
use lafet_proto::{Request, RequestId, Status, SubsystemId};

/// Explanation of a refusal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reason {
    /// Section and scenario, as in docs/protocol.md: `§3.1/1`.
    pub scenario: &'static str,
    /// Cause of the refusal.
    pub why: Text,
    /// What to do.
    pub remedy: Text,
}

/// The reason for which `by` refused this request; its data can narrow it down.
pub fn reason_of(request: &Request<'_>, status: Status, by: SubsystemId) -> Reason {
    let found = match (&request.body, status) {
        (Body::SwitchLimits { new_state }, Status::INVALID_VALUE)
            if LimitsState::from_wire(*new_state).is_none() =>
        {
            because(
                "§2/4",
                ("There is no such state of limits.", "Такого состояния пределов нет."),
                ("Send 0 (off), 1 (on) or 2 (reject).", "Пошлите 0 (off), 1 (on) или 2 (reject)."),
            )
        }
        _ => None,
    };
    found.unwrap_or_else(|| reason(request.body.id(), request.to, status, by))
}

/// The reason for which `by` refused a request of this kind to `to`.
pub fn reason(request: RequestId, to: SubsystemId, status: Status, by: SubsystemId) -> Reason {
    let found = match status {
        Status::DENIED => denied(request, by),
        Status::MODULE_FAULT => module_fault(request),
        Status::BUSY => busy(request, by),
        Status::WRONG_REQUEST => wrong_request(request, to, by),
        Status::WRONG_DATA => wrong_data(request),
        Status::INVALID_ID => invalid_id(request),
        Status::INVALID_VALUE => invalid_value(request, to),
        _ => None,
    };
    found.unwrap_or_else(|| of_status(request, status))
}

const fn because(
    scenario: &'static str,
    why: (&'static str, &'static str),
    remedy: (&'static str, &'static str),
) -> Option<Reason> {
    Some(Reason { scenario, why: Text::new(why.0, why.1), remedy: Text::new(remedy.0, remedy.1) })
}

const DEPLOY_FIRST: (&str, &str) = (
    "Deploy it, and wait until GetStatus Deployer says Deployed.",
    "Разверните ствол и дождитесь Deployed в GetStatus Deployer.",
);
const STOP_DETECTOR: (&str, &str) = (
    "Wait until Searching and Justifying are gone, or send Stop Detector.",
    "Дождитесь снятия Searching и Justifying либо пошлите Stop Detector.",
);
const STOP_CONTROL: (&str, &str) = (
    "Wait until the program ends, or send Stop Control.",
    "Дождитесь конца программы либо пошлите Stop Control.",
);
const CLOSE_VALVE: (&str, &str) = (
    "Close the valve, and wait until it says Closed. If it says so already, read InputFaults of \
     General: with bit 0 water flows all the same; close the main by hand.",
    "Закройте затвор и дождитесь Closed. Если он уже Closed, прочитайте InputFaults подсистемы \
     General: бит 0 означает, что вода всё же течёт; перекройте магистраль вручную.",
);
const STOP_ALL: (&str, &str) = (
    "Send Stop to the subsystem that refuses, or Stop All, which is never denied.",
    "Пошлите Stop тому, кто отказал, либо Stop All: он не отклоняется никогда.",
);
const READ_FLAGS: (&str, &str) = (
    "Read the status of the subsystem: its flags name the fault.",
    "Прочитайте состояние подсистемы: её флаги называют неисправность.",
);

fn denied(request: RequestId, by: SubsystemId) -> Option<Reason> {
    match by {
        SubsystemId::GENERAL => because(
            "§3.18/2",
            (
                "The monitor is locked out: only reads and SetParam are done.",
                "Включена аварийная блокировка: исполняются только чтение и SetParam.",
            ),
            (
                "Find out who locked it out and why; then release it (Lockout off).",
                "Выясните, кто и зачем включил блокировку; затем снимите её (Lockout off).",
            ),
        ),
        SubsystemId::DEPLOYER => denied_by_deployer(request),
        SubsystemId::DETECTOR => denied_by_detector(request),
        SubsystemId::CONTROL => denied_by_control(request),
        id if id.is_valve() => denied_by_valve(request),
        _ => None,
    }
}

fn denied_by_deployer(request: RequestId) -> Option<Reason> {
    let scenario = match request {
        RequestId::STOP => {
            return because(
                "§3.2/2",
                (
                    "The barrel is being deployed or wrapped: only Stop Deployer or Stop All ends \
                     that.",
                    "Идёт развёртывание или сворачивание: его прекращает только Stop Deployer или \
                     Stop All.",
                ),
                STOP_ALL,
            );
        }
        RequestId::MOVE => "§3.1/1",
        RequestId::OPEN => "§3.8/1",
        RequestId::START_JUSTIFY => "§3.13/2",
        _ => "§1/2",
    };
    because(
        scenario,
        (
            "The barrel is not deployed: it is stowed, moving, or between the positions.",
            "Ствол не развёрнут: он свёрнут, движется или стоит между положениями.",
        ),
        DEPLOY_FIRST,
    )
}

fn denied_by_detector(request: RequestId) -> Option<Reason> {
    let scenario = match request {
        RequestId::START_SEEK => {
            return because(
                "§3.16/4",
                (
                    "A program of extinguishing or a justification is running, or limits are off.",
                    "Выполняется программа тушения или юстировка либо выключены пределы.",
                ),
                (
                    "Send Stop Control or Stop Detector; switch the limits on.",
                    "Пошлите Stop Control или Stop Detector; включите пределы.",
                ),
            );
        }
        RequestId::STOP => {
            return because(
                "§3.2/3",
                (
                    "A search is running: only Stop Detector or Stop All ends it.",
                    "Идёт поиск очага: его прекращает только Stop Detector или Stop All.",
                ),
                STOP_ALL,
            );
        }
        RequestId::MOVE => "§3.1/2",
        RequestId::OPEN => "§3.8/2",
        RequestId::CLOSE => "§3.9/1",
        RequestId::WRAP => "§3.11/7",
        RequestId::START_JUSTIFY => "§3.13/2",
        RequestId::START_QUENCH => "§3.14/6",
        RequestId::START_TRAJECTORY => "§3.15/4",
        _ => "§1/2",
    };
    because(
        scenario,
        ("A search for fire or a justification is running.", "Идёт поиск очага или юстировка."),
        STOP_DETECTOR,
    )
}

fn denied_by_control(request: RequestId) -> Option<Reason> {
    let scenario = match request {
        RequestId::START_QUENCH | RequestId::START_TRAJECTORY => {
            return because(
                "§3.17/1",
                (
                    "Limits are off: a program could run the barrel anywhere.",
                    "Пределы выключены: программа могла бы увести ствол куда угодно.",
                ),
                ("Switch the limits on.", "Включите пределы."),
            );
        }
        RequestId::STOP => {
            return because(
                "§3.2/4",
                (
                    "A program of extinguishing is running: only Stop Control or Stop All ends it.",
                    "Выполняется программа тушения: её прекращает только Stop Control или Stop All.",
                ),
                STOP_ALL,
            );
        }
        RequestId::MOVE => "§3.1/9",
        RequestId::START_JUSTIFY => "§3.13/2",
        _ => "§1/2",
    };
    because(
        scenario,
        ("A program of extinguishing is running.", "Выполняется программа тушения."),
        STOP_CONTROL,
    )
}

fn denied_by_valve(request: RequestId) -> Option<Reason> {
    let (scenario, why) = match request {
        RequestId::WRAP => (
            "§3.11/6",
            (
                "The valve is not closed, or water flows: in a folding barrel it destroys it.",
                "Затвор не закрыт либо вода течёт: сворачиваемый ствол она разрушит.",
            ),
        ),
        RequestId::START_SEEK => (
            "§3.16/8",
            (
                "The valve is not closed, or water flows: the detector would look into it.",
                "Затвор не закрыт либо вода течёт: датчик смотрел бы в воду.",
            ),
        ),
        RequestId::MOVE => (
            "§3.1/9",
            (
                "The valve is not closed, or water flows: the barrel must not fold under it.",
                "Затвор не закрыт либо вода течёт: под водой ствол складывать нельзя.",
            ),
        ),
        _ => (
            "§1/2",
            ("The valve is not closed, or water flows.", "Затвор не закрыт либо вода течёт."),
        ),
    };
    because(scenario, why, CLOSE_VALVE)
}

fn module_fault(request: RequestId) -> Option<Reason> {
    let scenario = match request {
        RequestId::MOVE => "§3.1/4",
        RequestId::STOP => "§3.2/5",
        RequestId::OPEN => "§3.8/3",
        RequestId::CLOSE => "§3.9/2",
        RequestId::DEPLOY => "§3.10/3",
        RequestId::WRAP => "§3.11/3",
        RequestId::START_SEEK | RequestId::START_JUSTIFY => "§3.3.7/1",
        _ => return None,
    };
    because(
        scenario,
        (
            "The subsystem is faulty, or has stopped this way because of its current.",
            "Подсистема неисправна либо остановлена в эту сторону по току.",
        ),
        READ_FLAGS,
    )
}

fn busy(request: RequestId, by: SubsystemId) -> Option<Reason> {
    let (scenario, why) = match (request, by) {
        (RequestId::SWITCH_LIMITS, _) if by.is_drive() => (
            "§3.17/2",
            (
                "The remote unit has not received the new limits yet.",
                "Удалённый блок ещё не получил новые пределы.",
            ),
        ),
        (RequestId::SET_PARAM, by) if by.is_drive() => (
            "§3.17/5",
            (
                "The drive moves: a limit or the zero point is taken only at rest.",
                "Привод движется: предел и ноль берутся там, где он стоит.",
            ),
        ),
        (_, SubsystemId::GENERAL) => (
            "§3.12/2",
            (
                "The monitor is restarting: it answers reads only.",
                "Ствол перезапускается: он отвечает только на чтение.",
            ),
        ),
        _ => return None,
    };
    because(scenario, why, ("Repeat the request in a second.", "Повторите запрос через секунду."))
}

fn wrong_request(request: RequestId, to: SubsystemId, by: SubsystemId) -> Option<Reason> {
    if request == RequestId::RESTART {
        return because(
            "§3.12/3",
            (
                "Restart is accepted for All only: a subsystem alone cannot be restarted.",
                "Restart принимается только для All: одну подсистему перезапустить нельзя.",
            ),
            ("Send Restart All.", "Пошлите Restart All."),
        );
    }
    if to == SubsystemId::ALL || to == SubsystemId::MOTORS {
        return because(
            "§1/7",
            (
                "No subsystem takes this request from a broadcast.",
                "Ни одна подсистема не принимает этот запрос широковещательно.",
            ),
            ("Name the subsystem you mean.", "Укажите нужную подсистему."),
        );
    }
    let known = dictionary::request(request).is_some();
    if by == SubsystemId::GENERAL && (to != SubsystemId::GENERAL || !known) {
        return because(
            "§1/4",
            ("The monitor does not support this request.", "Ствол вообще не знает такого запроса."),
            (
                "Its program may be older than the request: see what it supports.",
                "Возможно, его программа старше этого запроса: выясните, что она умеет.",
            ),
        );
    }
    let scenario = match request {
        RequestId::MOVE => "§3.1/5",
        RequestId::STOP => "§3.2/6",
        RequestId::OPEN => "§3.8/4",
        RequestId::CLOSE => "§3.9/3",
        RequestId::DEPLOY => "§3.10/4",
        RequestId::WRAP => "§3.11/4",
        _ => "§1/12",
    };
    because(
        scenario,
        (
            "This request is not provided for this subsystem.",
            "Для этой подсистемы такой запрос не предусмотрен.",
        ),
        (
            "Send it to an addressee of its section in the protocol.",
            "Пошлите его адресату, названному в его разделе протокола.",
        ),
    )
}

fn wrong_data(request: RequestId) -> Option<Reason> {
    let (scenario, why) = match request {
        RequestId::SET_PARAM => (
            "§3.5/4",
            (
                "The parameter has another number of values.",
                "У параметра другое количество значений.",
            ),
        ),
        RequestId::SETUP_CORRECTION_TABLE => {
            ("§3.6/2", ("The table has no entries.", "В таблице нет ни одного значения."))
        }
        RequestId::START_QUENCH => (
            "§3.14/4",
            (
                "The data are neither of the three forms of StartQuench.",
                "Данные не подходят ни под один из трёх вариантов StartQuench.",
            ),
        ),
        RequestId::START_TRAJECTORY => (
            "§3.15/3",
            (
                "The number of points does not fit the size of the data.",
                "Число точек не соответствует объёму данных.",
            ),
        ),
        _ => return None,
    };
    because(scenario, why, ("Correct the number of values.", "Исправьте количество значений."))
}

fn invalid_id(request: RequestId) -> Option<Reason> {
    if request == RequestId::START_TRAJECTORY {
        return because(
            "§3.15/2",
            ("The stored trajectory is empty.", "Записанная траектория пуста."),
            ("Store it first, or take another.", "Сначала запишите её либо возьмите другую."),
        );
    }
    let scenario = if request == RequestId::SET_PARAM { "§3.5/2" } else { "§3.4/1" };
    because(
        scenario,
        (
            "The subsystem has no parameter with this name.",
            "У подсистемы нет параметра с таким именем.",
        ),
        (
            "Check the name letter by letter; another version may have other parameters.",
            "Проверьте имя буква в букву; у другой версии могут быть другие параметры.",
        ),
    )
}

fn invalid_value(request: RequestId, to: SubsystemId) -> Option<Reason> {
    match request {
        RequestId::SET_PARAM => invalid_param(to),
        RequestId::START_SEEK => because(
            "§3.16/2",
            (
                "The sector is not wholly inside the limits (BadSector), or analyse is not 0 or 1.",
                "Сектор не целиком внутри пределов (BadSector) либо analyse не 0 и не 1.",
            ),
            (
                "Take a sector inside the limits of Horizontal and Vertical.",
                "Задайте сектор внутри пределов Horizontal и Vertical.",
            ),
        ),
        RequestId::START_QUENCH => because(
            "§3.14/8",
            (
                "The sector is wholly outside the limits, or a number of it is out of range.",
                "Сектор целиком вне пределов либо одно из его чисел недопустимо.",
            ),
            (
                "Take a sector that touches the limits of Horizontal and Vertical.",
                "Задайте сектор, хотя бы частью лежащий внутри пределов.",
            ),
        ),
        RequestId::START_TRAJECTORY => because(
            "§3.15/3",
            (
                "A point, a flag or a number of a trajectory is out of range.",
                "Точка, признак или номер траектории вне допустимого.",
            ),
            ("Stored trajectories are 0 to 7.", "Номера записанных траекторий — от 0 до 7."),
        ),
        RequestId::SWITCH_LIMITS => because(
            "§3.17/6",
            (
                "With the limits taken, the lower one would not be below the upper one.",
                "С принятыми пределами нижний оказался бы не ниже верхнего.",
            ),
            (
                "Take the other limit again, or drop both (SwitchLimits reject).",
                "Примите другой предел заново либо отбросьте оба (SwitchLimits reject).",
            ),
        ),
        RequestId::SETUP_CORRECTION_TABLE => because(
            "§3.6/2",
            ("The table has 256 entries, no more.", "В таблице 256 значений, не больше."),
            ("Begin earlier or send fewer.", "Начните раньше либо пошлите меньше."),
        ),
        RequestId::LOCKOUT => because(
            "§3.18/5",
            ("The key is neither of the two of Lockout.", "Ключ не из двух ключей Lockout."),
            ("Send 0x2FFA (on) or 0x7353 (off).", "Пошлите 0x2FFA (включить) или 0x7353 (снять)."),
        ),
        _ => None,
    }
}

/// The reason for an invalid value of a parameter.
fn invalid_param(of: SubsystemId) -> Option<Reason> {
    if !of.is_drive() {
        return because(
            "§3.5/3",
            ("The value is out of the parameter's range.", "Значение вне диапазона параметра."),
            ("See the range of the parameter.", "Посмотрите диапазон параметра."),
        );
    }
    because(
        "§3.17/5",
        (
            "The value is out of range; or limits are off, and then a limit or the zero point takes \
             the present position only.",
            "Значение вне диапазона; либо пределы выключены, и тогда предел и ноль принимают только \
             текущее положение.",
        ),
        (
            "See the range of the parameter; switch the limits on, or teach the limit.",
            "Посмотрите диапазон параметра; включите пределы либо задайте предел по текущему \
             положению.",
        ),
    )
}

/// The reason that follows from the status alone.
fn of_status(request: RequestId, status: Status) -> Reason {
    let scenario = match (status, request) {
        (Status::NEED_CONFIRM, RequestId::OPEN) => "§3.8/6",
        (Status::NEED_CONFIRM, RequestId::CLOSE) => "§3.9/5",
        (Status::NEED_CONFIRM, RequestId::CLEAN_FLASH) => "§3.19/2",
        (Status::MODULE_NOT_EXIST, _) => "§1/3",
        (Status::WRONG_DATA, _) => "§2/3",
        (Status::INVALID_VALUE, _) => "§2/4",
        (Status::NO_ROOM, _) => "§1/9",
        (Status::ACCESS_DENIED, _) => "§3.5/5",
        (Status::INCOMPLETE_CONFIG, RequestId::GET_PARAM) => "§3.4/3",
        (Status::INCOMPLETE_CONFIG, _) => "§3.5/6",
        (Status::NOT_CACHED, _) => "§3.4/2",
        (Status::CACHED, _) => "§3.5/7",
        (Status::NOT_SUPPORTED, _) => "§3.17/4",
        (Status::DENIED, _) => "§1/2",
        _ => "§2/5",
    };
    let unknown = || Reason {
        scenario,
        why: Text::new("The protocol has no such status.", "Протокол не знает такого статуса."),
        remedy: Text::new("Report it.", "Сообщите о нём."),
    };
    dictionary::status(status).map_or_else(unknown, |info| Reason {
        scenario,
        why: info.meaning,
        remedy: info.remedy,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenarios_are_those_of_the_request() {
        let of = |request, to, status, by| reason(request, to, status, by).scenario;
        let (vertical, deployer) = (SubsystemId::VERTICAL, SubsystemId::DEPLOYER);
        assert_eq!(of(RequestId::MOVE, vertical, Status::DENIED, deployer), "§3.1/1");
        assert_eq!(of(RequestId::STOP, vertical, Status::DENIED, SubsystemId::CONTROL), "§3.2/4");
        let general = SubsystemId::GENERAL;
        assert_eq!(of(RequestId::MOVE, vertical, Status::DENIED, general), "§3.18/2");
        assert_eq!(of(RequestId::MOVE, vertical, Status::BUSY, general), "§3.12/2");
        assert_eq!(of(RequestId::WRAP, deployer, Status::DENIED, SubsystemId::VALVE1), "§3.11/6");
        assert_eq!(of(RequestId::MOVE, SubsystemId::ALL, Status::WRONG_REQUEST, general), "§1/7");
        let unknown = RequestId(0x99);
        assert_eq!(of(unknown, general, Status::WRONG_REQUEST, general), "§1/4");
        assert_eq!(of(RequestId::MOVE, general, Status::WRONG_REQUEST, general), "§3.1/5");
    }

    #[test]
    fn an_unknown_state_of_limits_is_not_crossing_limits() {
        let refused = |new_state| {
            let request = Request::new(SubsystemId::VERTICAL, Body::SwitchLimits { new_state });
            reason_of(&request, Status::INVALID_VALUE, SubsystemId::VERTICAL).scenario
        };
        assert_eq!((refused(1), refused(5)), ("§3.17/6", "§2/4"));
    }
}
