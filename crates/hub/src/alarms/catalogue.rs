//! What each alarm says. What it is, why, and what to do come from the dictionary of flags; what it
//! leads to is added here.

use lafet_proto::SubsystemId;
use lafet_proto::flags::{FlagInfo, Severity};

use super::alarm::Priority;
use crate::text::{Both, both};

/// The texts of an alarm.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texts {
    /// How urgent the response is.
    pub priority: Priority,
    /// The condition, in words.
    pub what: Both,
    /// What usually leads to it.
    pub cause: Both,
    /// What follows if there is no response.
    pub consequence: Both,
    /// What the operator does.
    pub remedy: Both,
}

/// The texts of a flag of a subsystem.
pub fn of_flag(id: SubsystemId, flag: &FlagInfo) -> Texts {
    let (en, ru) = consequence(id, flag.name);
    Texts {
        priority: match flag.severity {
            // Not a fault of the monitor, but what it is there for.
            _ if id == SubsystemId::DETECTOR && flag.name == "Found" => Priority::Fire,
            Severity::Alarm => Priority::High,
            _ => Priority::Medium,
        },
        what: flag.meaning.into(),
        cause: flag.cause.into(),
        consequence: both(en, ru),
        remedy: flag.remedy.into(),
    }
}

/// There is no connection to a monitor.
pub fn link_down() -> Texts {
    Texts {
        priority: Priority::High,
        what: both("There is no connection to the monitor.", "Нет соединения со стволом."),
        cause: both(
            "The cable, the network or a serial server has failed, or the monitor has no power.",
            "Отказ кабеля, сети или преобразователя интерфейса либо ствол обесточен.",
        ),
        consequence: both(
            "It cannot be commanded or stopped from here; what it was doing goes on by itself.",
            "Отсюда им нельзя управлять и нельзя его остановить; начатое продолжается само.",
        ),
        remedy: both(
            "Use the button post at the monitor; check power, cable and address.",
            "Используйте кнопочный пост у ствола; проверьте питание, кабель и адрес.",
        ),
    }
}

/// The monitor does not answer.
pub fn stale() -> Texts {
    Texts {
        what: both("The monitor does not answer.", "Ствол не отвечает."),
        cause: both(
            "The link is up, but the monitor is off, restarts, has another address or speed, or \
             answers are lost.",
            "Линия есть, но ствол выключен, перезапускается, имеет другой адрес или скорость либо \
             ответы теряются.",
        ),
        ..link_down()
    }
}

/// Nothing ends a motion by hand in time when the hub or the connection fails.
pub fn unheld() -> Texts {
    Texts {
        priority: Priority::Medium,
        what: both(
            "A motion by hand may go on for more than 0.5 s if the hub or the connection fails.",
            "При отказе сервера объекта или связи ручное перемещение может продолжаться дольше 0,5 с.",
        ),
        cause: both(
            "The monitor has no parameter MoveHold: its drive stops after about 2 s. Or the line is slow \
             (round trip of 180 ms and more): the drive stops after three round trips or so.",
            "У ствола нет параметра MoveHold: привод остановится примерно через 2 с. Либо линия медленная \
             (ответ через 180 мс и более): привод остановится примерно через три таких времени.",
        ),
        consequence: both(
            "People near the barrel while it is moved by hand are in danger for longer.",
            "Тот, кто стоит у ствола при ручном перемещении, дольше находится в опасности.",
        ),
        remedy: both(
            "While it is moved by hand, keep the hardware emergency stop within reach. Install firmware with \
             MoveHold, or make the line faster; shelve the alarm where neither is possible.",
            "При ручном перемещении держите аппаратный аварийный останов под рукой. Установите прошивку с \
             MoveHold или ускорьте линию; где нельзя ни того ни другого, отложите тревогу.",
        ),
    }
}

/// The audit log cannot be stored.
pub fn audit() -> Texts {
    Texts {
        priority: Priority::Medium,
        what: both("The audit log is not being stored.", "Журнал аудита не сохраняется."),
        cause: both(
            "The disk is full, read-only or has failed.",
            "Диск заполнен, доступен только для чтения или отказал.",
        ),
        consequence: both(
            "Commands go on; their entries wait in memory and are lost if the hub ends.",
            "Команды исполняются; записи ждут в памяти и пропадут при завершении программы.",
        ),
        remedy: both(
            "Make room on the disk or repair it; the entries are then stored by themselves.",
            "Освободите место или исправьте диск; записи сохранятся сами.",
        ),
    }
}

/// An entry of the audit log is not the one that was written.
pub fn chain() -> Texts {
    Texts {
        priority: Priority::Medium,
        what: both("The audit log was changed.", "Журнал аудита изменён."),
        cause: both(
            "audit.db was edited, or the disk has corrupted it.",
            "Файл audit.db правили, либо его повредил диск.",
        ),
        consequence: both(
            "Control is not affected. Entries from the one that is named in the event log on prove nothing.",
            "На управление не влияет. Записи, начиная с указанной в журнале событий, ничего не доказывают.",
        ),
        remedy: both(
            "Keep a copy of the folder for the investigation; then restore audit.db, or put it aside and \
             start with --accept-lost audit.",
            "Сохраните копию папки для расследования; затем восстановите audit.db либо уберите его и \
             запустите с --accept-lost audit.",
        ),
    }
}

/// Files of the state were lost before this start.
pub fn state() -> Texts {
    Texts {
        priority: Priority::Medium,
        what: both("Files of the state were lost.", "Потеряны файлы состояния."),
        cause: both(
            "Files in the hub's folder were removed, replaced or cut; the event log names them.",
            "Файлы в папке сервера объекта удалены, заменены или укорочены; какие — в журнале событий.",
        ),
        consequence: both(
            "Control is not affected. What was in them is missing.",
            "На управление не влияет. Того, что в них было, больше нет.",
        ),
        remedy: both(
            "Find out who or what did it, restore a copy if there is one; then acknowledge.",
            "Выясните причину, восстановите копию, если она есть; затем подтвердите.",
        ),
    }
}

/// Many logins have failed.
pub fn logins() -> Texts {
    Texts {
        priority: Priority::Medium,
        what: both("Passwords are being guessed.", "Идёт подбор паролей."),
        cause: both(
            "Many logins have failed in the last minutes; the audit log has their users and addresses.",
            "За последние минуты много неудачных входов; пользователи и адреса — в журнале аудита.",
        ),
        consequence: both(
            "A login from a new place has to wait. Places from which a user has logged in before do not.",
            "Вход с нового места ждёт. С мест, откуда пользователь уже входил, — не ждёт.",
        ),
        remedy: both(
            "Find the addresses in the audit log and cut them off from the network of the hub.",
            "Найдите адреса в журнале аудита и отключите их от сети сервера объекта.",
        ),
    }
}

/// What was revoked is not on the disk.
pub fn revocations() -> Texts {
    Texts {
        priority: Priority::Medium,
        what: both(
            "Ended sessions and removed users are not stored.",
            "Завершённые сеансы и удаления пользователей не сохранены.",
        ),
        cause: both(
            "The disk is full, read-only or has failed.",
            "Диск заполнен, доступен только для чтения или отказал.",
        ),
        consequence: both(
            "They are in effect. If the hub restarts before the disk takes them, they may be undone.",
            "Они действуют. Если сервер объекта перезапустится раньше, чем диск их примет, они могут пропасть.",
        ),
        remedy: both(
            "Make room on the disk or repair it before the hub is restarted.",
            "Освободите место или исправьте диск до перезапуска сервера объекта.",
        ),
    }
}

/// The disk, or PostgreSQL, does not take the history.
pub fn history() -> Texts {
    Texts {
        priority: Priority::Low,
        what: both("The history is not being stored.", "История не сохраняется."),
        cause: both(
            "The disk is full or faulty; or PostgreSQL, if it is used, does not answer or refuses the hub.",
            "Диск заполнен или неисправен; либо PostgreSQL, если он используется, не отвечает или не \
             принимает центр управления.",
        ),
        consequence: both(
            "Control is not affected. Values of this time are missing; PostgreSQL's wait in memory until \
             there are too many.",
            "На управление не влияет. Значений за это время не будет; для PostgreSQL они ждут в памяти, \
             пока их не слишком много.",
        ),
        remedy: both(
            "Make room on the disk, or correct the server or url in [history].",
            "Освободите место либо исправьте сервер или url раздела [history].",
        ),
    }
}

const DRIVE: (&str, &str) = (
    "The axis cannot be trusted: it stops and may refuse to move, so the jet cannot be aimed.",
    "Оси нельзя доверять: она останавливается и может не двигаться, струю не навести.",
);
const DEPLOYER: (&str, &str) = (
    "The barrel may stay folded: then it can neither aim nor give water.",
    "Ствол может остаться свёрнутым: тогда нельзя ни наводить, ни подавать воду.",
);
const HEATING: (&str, &str) = (
    "In frost the unit may freeze and no longer move.",
    "На морозе узел может замёрзнуть и перестать двигаться.",
);
const REMOTE: (&str, &str) = (
    "Parameters on the remote unit may not be what they are shown to be.",
    "Параметры удалённого устройства могут отличаться от показанных.",
);
const BUTTON: (&str, &str) = (
    "This button of the post does nothing; the others go on working.",
    "Эта кнопка поста не действует; остальные работают.",
);

/// What a flag leads to, in English and Russian.
type Consequence = (&'static str, &'static str);

/// What a flag leads to; empty for one that only informs.
pub fn consequence(id: SubsystemId, flag: &str) -> Consequence {
    of_unit(flag)
        .or_else(|| of_monitor(flag))
        .or_else(|| of_motion(id, flag))
        .or_else(|| of_program(flag))
        .or_else(|| flag.ends_with("ButtonState").then_some(BUTTON))
        .unwrap_or_default()
}

/// Flags of the parameters, the supply and the electronics of any subsystem.
fn of_unit(flag: &str) -> Option<Consequence> {
    Some(match flag {
        "ConfigFault" => (
            "The subsystem works with default values: limits and zero point may be wrong.",
            "Подсистема работает с исходными значениями: пределы и нулевая точка могут быть неверны.",
        ),
        "ConfigInvalid" => (
            "The subsystem may refuse to work until its parameters are complete.",
            "Подсистема может не работать, пока параметры не заданы полностью.",
        ),
        "ConfigWriteFault" => (
            "What was set is lost when the power goes.",
            "Заданное пропадёт при отключении питания.",
        ),
        "ConnLost" => (
            "The monitor cannot command this unit: it stays as it is.",
            "Ствол не может управлять этим устройством: оно остаётся как есть.",
        ),
        "BadPower" => (
            "Drives and valves may be slow, stop, or not work at all.",
            "Приводы и затворы могут замедлиться, остановиться или не работать.",
        ),
        "RemotePaIncomplete" | "RemotePaBadId" | "RemotePaBadVal" | "RemotePaError" => REMOTE,
        "InternalFault" => (
            "What the subsystem was doing has ended; extinguishing may have stopped.",
            "Работа подсистемы прервана; тушение могло остановиться.",
        ),
        "WdtFault" => (
            "The unit was reset: what it was doing has ended.",
            "Устройство было перезапущено: его работа прервана.",
        ),
        "ProtocolFault" => {
            ("Some commands do not reach the unit.", "Часть команд не доходит до устройства.")
        }
        _ => return None,
    })
}

/// Flags of the monitor as a whole and of its heating.
fn of_monitor(flag: &str) -> Option<Consequence> {
    Some(match flag {
        "PressureSensorBreak" | "PressureSensorShort" => (
            "The pressure is not known; programs aim without ballistics, the jet may fall short.",
            "Давление неизвестно; программы наводят без баллистики, возможен недолёт струи.",
        ),
        "LockedOut" => (
            "All motion is stopped and the valves are closed; every command is refused.",
            "Всё остановлено, затворы закрыты; команды отклоняются.",
        ),
        "HorizontalFault" | "VerticalFault" | "NozzleFault" | "DeployerFault" | "BoxFault" => {
            HEATING
        }
        "HorizontalSensorFault"
        | "VerticalSensorFault"
        | "NozzleSensorFault"
        | "DeployerSensorFault"
        | "BoxSensorFault"
        | "HumiditySensorFault" => (
            "Heating of this part is not controlled: in frost it may freeze.",
            "Обогрев этого узла не регулируется: на морозе он может замёрзнуть.",
        ),
        _ => return None,
    })
}

/// Flags of drives and valves.
fn of_motion(id: SubsystemId, flag: &str) -> Option<Consequence> {
    let deployer = id == SubsystemId::DEPLOYER;
    Some(match flag {
        "AmperageOverload" if id.is_valve() => (
            "The valve has stopped midway: it may be partly open.",
            "Затвор остановился в пути: он может быть открыт не полностью или не закрыт.",
        ),
        "AmperageOverload" if !deployer => (
            "The drive has stopped and refuses this direction until the flag goes.",
            "Привод остановлен и не движется в эту сторону, пока флаг не снят.",
        ),
        "Limitless" => (
            "Nothing keeps the barrel from running against its stops.",
            "Ничто не удерживает ствол от удара об упоры.",
        ),
        "AmperageOverload" | "PositionWayFault" | "PosEncoderFault" | "SpeedEncoderFault"
        | "MotorBroken" | "SpeedWayFault" => {
            if deployer {
                DEPLOYER
            } else {
                DRIVE
            }
        }
        "Blocked" => ("The valve does not open on command.", "Затвор не открывается по команде."),
        "OpenSensorFault" | "CloseSensorFault" => (
            "It is not known whether the valve is open or closed.",
            "Неизвестно, открыт затвор или закрыт.",
        ),
        _ => return None,
    })
}

/// Flags of programs and of the search.
fn of_program(flag: &str) -> Option<Consequence> {
    Some(match flag {
        "OutsideLimits" => {
            ("Part of the fire is not reached by the jet.", "Часть очага не орошается.")
        }
        "ModeFault" => ("The program does not run.", "Программа не выполняется."),
        "TrajectoryPressureFault"
        | "TrajectoryRangeFault"
        | "TrajectoryAngleFault"
        | "TrajectoryCRCFault" => (
            "The barrel aims straight at the target: far away the jet falls short.",
            "Ствол наводится прямо на цель: на большой дальности струя не долетает.",
        ),
        "Found" => ("Something burns in the searched sector.", "В секторе поиска есть горение."),
        "DeviceFault" => (
            "The monitor does not find fires: an operator has to look and aim by hand.",
            "Ствол не находит очаги: наблюдать и наводить нужно вручную.",
        ),
        "BadSector" => ("The search does not run.", "Поиск не выполняется."),
        "DirtyLens" => (
            "Small or distant fires may be overlooked.",
            "Небольшие или далёкие очаги могут быть не замечены.",
        ),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use lafet_proto::flags::flags_of;

    #[test]
    fn every_flag_that_warns_says_what_it_leads_to_in_both_languages() {
        let cyrillic = |text: &str| text.chars().any(|c| ('а'..='я').contains(&c));
        let mut count = 0;
        for id in SubsystemId::TABLE {
            let flags = flags_of(id).flags.iter();
            for flag in flags.filter(|flag| flag.severity >= Severity::Warning) {
                let texts = of_flag(id, flag);
                for text in [texts.what, texts.cause, texts.consequence, texts.remedy] {
                    let fine = text.en.ends_with('.') && text.ru.ends_with('.');
                    assert!(
                        fine && !cyrillic(&text.en) && cyrillic(&text.ru),
                        "{id} {}: {text:?}",
                        flag.name
                    );
                }
                count += 1;
            }
        }
        assert!(count > 150, "{count}");
    }
}
