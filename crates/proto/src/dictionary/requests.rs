//! §3 «Перечень поддерживаемых запросов»: the table of requests, and the bus controller's services.

use super::Text;
use crate::id::{RequestId, SubsystemId};

/// Source of what is known about a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Origin {
    /// Follows from the document.
    Read,
    /// Seen in a public bus adapter for the same family of devices.
    Observed,
    /// Named by the document, but its data are our own design.
    Ours,
}

/// Description of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct RequestInfo {
    /// Its identifier.
    pub id: RequestId,
    /// The document's name.
    pub name: &'static str,
    /// The document's section that describes it.
    pub section: &'static str,
    /// Source of the description.
    pub origin: Origin,
    /// Possible addressees; empty when every subsystem is one.
    pub addressees: &'static [SubsystemId],
    /// A short title.
    pub title: Text,
    /// What the request does.
    pub meaning: Text,
}

macro_rules! requests {
    ($($konst:ident $name:literal $section:literal $origin:ident [$($to:ident)*],
       $title_en:literal, $title_ru:literal, $meaning_en:literal, $meaning_ru:literal;)+) => {
        /// Every request of §3, in the order of its sections, then the bus controller's services.
        pub static REQUESTS: [RequestInfo; [$($name),+].len()] = [$(RequestInfo {
            id: RequestId::$konst,
            name: $name,
            section: $section,
            origin: Origin::$origin,
            addressees: &[$(SubsystemId::$to),*],
            title: Text::new($title_en, $title_ru),
            meaning: Text::new($meaning_en, $meaning_ru),
        }),+];
    };
}

requests! {
    MOVE "Move" "3.1" Read [VERTICAL HORIZONTAL NOZZLE DEPLOYER],
        "Move a drive",
        "Переместить привод",
        "The drive goes to a position, or to its limit if that is nearer.",
        "Привод движется в заданную точку либо до предела, если он ближе.";
    STOP "Stop" "3.2" Read
        [ALL VALVE1 VALVE2 VERTICAL HORIZONTAL NOZZLE DEPLOYER DETECTOR CONTROL],
        "Stop",
        "Остановить",
        "The subsystem breaks off what it does; All stops everything that moves.",
        "Подсистема прекращает операцию; All останавливает всё, что движется.";
    GET_STATUS "GetStatus" "3.3" Read [],
        "Read the state",
        "Запросить состояние",
        "Flags and measured values of the subsystem.",
        "Флаги и измеренные величины подсистемы.";
    GET_PARAM "GetParam" "3.4" Read [],
        "Read a parameter",
        "Прочитать параметр",
        "The current value of a parameter.",
        "Текущее значение параметра.";
    SET_PARAM "SetParam" "3.5" Read [],
        "Set a parameter",
        "Установить параметр",
        "Checks the value and queues it for the non-volatile memory.",
        "Проверяет значение и ставит его в очередь на запись в ЭНОЗУ.";
    SETUP_CORRECTION_TABLE "SetupCorrectionTable" "3.6" Ours [CONTROL],
        "Store the correction table",
        "Записать таблицу поправок",
        "Corrections of the elevation by pressure, one for each 0.1 atm.",
        "Поправки угла подъёма от давления, по одной на каждые 0,1 атм.";
    RETRIEVE_LIMITS "RetrieveLimits" "3.7" Read
        [ALL MOTORS VERTICAL HORIZONTAL NOZZLE DEPLOYER],
        "Read the limits",
        "Запросить пределы",
        "The limits of travel of a drive.",
        "Пределы перемещения привода.";
    OPEN "Open" "3.8" Read [VALVE1 VALVE2],
        "Open a valve",
        "Открыть затвор",
        "Opens the valve; the key confirms.",
        "Открывает затвор; ключ служит подтверждением.";
    CLOSE "Close" "3.9" Read [VALVE1 VALVE2],
        "Close a valve",
        "Закрыть затвор",
        "Closes the valve; the key confirms.",
        "Закрывает затвор; ключ служит подтверждением.";
    DEPLOY "Deploy" "3.10" Read [DEPLOYER],
        "Deploy",
        "Развернуть",
        "Brings the monitor to the working position.",
        "Переводит ствол в рабочее положение.";
    WRAP "Wrap" "3.11" Read [DEPLOYER],
        "Stow",
        "Свернуть",
        "Brings the monitor to the standby position.",
        "Переводит ствол в дежурное положение.";
    RESTART "Restart" "3.12" Read [ALL],
        "Restart",
        "Перезапустить",
        "Ends all operations, answers, and starts the program again.",
        "Завершает все операции, отвечает и запускает программу заново.";
    START_JUSTIFY "StartJustify" "3.13" Read [DETECTOR],
        "Align barrel and detector",
        "Юстировка ствола и датчика",
        "Measures the angle between the barrel and the detector.",
        "Измеряет угол между стволом и датчиком.";
    START_QUENCH "StartQuench" "3.14" Read [CONTROL],
        "Start extinguishing",
        "Начать тушение",
        "The jet scans a sector; the valves are left as they are.",
        "Струя орошает заданную область; состояние затворов не меняется.";
    START_TRAJECTORY "StartTrajectory" "3.15" Ours [CONTROL],
        "Extinguish along trajectories",
        "Тушение по траекториям",
        "The jet follows points given in the request or stored trajectories.",
        "Струя идёт по точкам из запроса или по записанным траекториям.";
    START_SEEK "StartSeek" "3.16" Read [DETECTOR],
        "Search for fire",
        "Поиск очага",
        "The detector searches a sector for fire spots.",
        "Датчик ищет очаги загорания в заданном секторе.";
    SWITCH_LIMITS "SwitchLimits" "3.17" Read
        [ALL MOTORS VERTICAL HORIZONTAL NOZZLE DEPLOYER],
        "Switch the limits",
        "Контроль пределов",
        "Switches the control of the limits off or on, or rejects their change.",
        "Выключает или включает контроль пределов либо отменяет их изменение.";
    LOCKOUT "Lockout" "3.18" Read [ALL],
        "Emergency lockout",
        "Аварийная блокировка",
        "Stops everything and closes the valves until it is released.",
        "Останавливает всё и закрывает затворы до снятия блокировки.";
    CLEAN_FLASH "CleanFlash" "3.19" Read [GENERAL],
        "Erase the memory",
        "Очистить ЭНОЗУ",
        "Erases all parameters and resets the main unit; the key confirms.",
        "Стирает все параметры и сбрасывает главный модуль; ключ служит подтверждением.";
    GET_CRASH_DATA "GetCrashData" "3.20" Read [GENERAL ALL],
        "Read crash data",
        "Данные об отказе",
        "Registers saved at the last hardware fault.",
        "Регистры, сохранённые при последнем аппаратном отказе.";
    GET_HOTBED "GetHotbed" "3.21" Read [DETECTOR],
        "Read the fire spots",
        "Запросить очаги загорания",
        "The fire spots found by the last search, as in GetParam Hotbeds.",
        "Очаги загорания, найденные последним поиском, как в GetParam Hotbeds.";
    ACCESS_GRANTED "AccessGranted" "bus" Observed [GENERAL],
        "Access to the bus",
        "Доступ к магистрали",
        "The bus controller lets an active device send one frame.",
        "Контроллер магистрали разрешает активному устройству отправить один кадр.";
    GET_NETWORK_STATUS "GetNetworkStatus" "bus" Observed [GENERAL],
        "Devices on the bus",
        "Устройства на магистрали",
        "The addresses that answer on the bus.",
        "Адреса, отвечающие на магистрали.";
    GET_LOG "GetLog" "bus" Observed [GENERAL],
        "Log of the bus",
        "Журнал магистрали",
        "Lines of the controller's log of control requests.",
        "Строки журнала запросов управления, который ведёт контроллер.";
}
