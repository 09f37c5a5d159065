//! §1 «Общие сведения»: the table of subsystems.

use super::Text;
use crate::id::SubsystemId;

/// Description of a subsystem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct SubsystemInfo {
    /// Its identifier.
    pub id: SubsystemId,
    /// The document's name.
    pub name: &'static str,
    /// A short title.
    pub title: Text,
    /// What the subsystem is responsible for.
    pub meaning: Text,
}

macro_rules! subsystems {
    ($($konst:ident $name:literal, $title_en:literal, $title_ru:literal,
       $meaning_en:literal, $meaning_ru:literal;)+) => {
        /// Every subsystem of §1, in its order, All and Motors first.
        pub static SUBSYSTEMS: [SubsystemInfo; [$($name),+].len()] = [$(SubsystemInfo {
            id: SubsystemId::$konst,
            name: $name,
            title: Text::new($title_en, $title_ru),
            meaning: Text::new($meaning_en, $meaning_ru),
        }),+];
    };
}

subsystems! {
    ALL "All",
        "All subsystems",
        "Все подсистемы",
        "Addresses every subsystem that can handle the request.",
        "Обозначает все подсистемы, которые могут обработать запрос.";
    MOTORS "Motors",
        "All drives",
        "Все приводы",
        "Addresses every drive that can handle the request.",
        "Обозначает все подсистемы-приводы, которые могут обработать запрос.";
    GENERAL "General",
        "Main subsystem",
        "Главная подсистема",
        "Configuration, supply voltage, pressure; answers where no addressee can.",
        "Конфигурация, напряжение питания, давление; отвечает там, где отвечать больше некому.";
    CLIMATICS "Climatics",
        "Climate",
        "Климат",
        "Measures temperatures and humidity of the nodes and keeps them warm.",
        "Измеряет температуру и влажность узлов и поддерживает их на заданном уровне.";
    VERTICAL "Vertical",
        "Elevation drive",
        "Привод вертикального перемещения",
        "Raises and lowers the barrel; positive is up.",
        "Поднимает и опускает ствол; положительное направление — вверх.";
    HORIZONTAL "Horizontal",
        "Traverse drive",
        "Привод горизонтального перемещения",
        "Turns the barrel; positive is left.",
        "Поворачивает ствол; положительное направление — влево.";
    NOZZLE "Nozzle",
        "Nozzle drive",
        "Привод насадка",
        "Changes the jet from wide spray to narrow; positive is narrower.",
        "Меняет струю от широкой до узкой; положительное направление — уже.";
    VALVE1 "Valve1",
        "Valve 1 (water)",
        "Затвор 1 (вода)",
        "Lets water through to the barrel.",
        "Подаёт воду в ствол.";
    VALVE2 "Valve2",
        "Valve 2 (foam)",
        "Затвор 2 (пена)",
        "Lets foam through to the barrel.",
        "Подаёт пену в ствол.";
    CONTROL "Control",
        "Coordinated control",
        "Согласованное управление",
        "Moves the drives together by a program of extinguishing.",
        "Отвечает за работу приводов по программам тушения.";
    DETECTOR "Detector",
        "Fire detector",
        "Датчик очага загорания",
        "Searches for fire spots with the detector on the barrel.",
        "Управляет датчиком обнаружения и поиском очага загорания.";
    DEPLOYER "Deployer",
        "Deployment",
        "Развёртывание",
        "Brings the monitor from standby to the working position and back.",
        "Переводит ствол из дежурного положения в рабочее и обратно.";
    EXTERNAL_CONN "ExternalConn",
        "Wired interface",
        "Проводной интерфейс",
        "External interface, by wire.",
        "Внешний интерфейс связи, проводной.";
    RADIO "Radio",
        "Radio interface",
        "Радиоинтерфейс",
        "External interface, by radio.",
        "Внешний интерфейс связи, радио.";
    BUTTONS "Buttons",
        "Button post",
        "Кнопочный пост",
        "Button post at the monitor.",
        "Кнопочный пост управления.";
    EXT_BUTTONS "ExtButtons",
        "Remote button post",
        "Удалённый кнопочный пост",
        "Button post at a distance.",
        "Удалённый кнопочный пост управления.";
}
