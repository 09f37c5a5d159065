//! §2 «Формат заголовка запроса/ответа»: the table of statuses.

use super::Text;
use crate::id::Status;

/// Description of a status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct StatusInfo {
    /// The status.
    pub status: Status,
    /// The document's name.
    pub name: &'static str,
    /// What the status means (§2).
    pub meaning: Text,
    /// What the sender of the request should do.
    pub remedy: Text,
}

macro_rules! statuses {
    ($($konst:ident $name:literal, $meaning_en:literal, $meaning_ru:literal,
       $remedy_en:literal, $remedy_ru:literal;)+) => {
        /// Every status of §2, in its order.
        pub static STATUSES: [StatusInfo; [$($name),+].len()] = [$(StatusInfo {
            status: Status::$konst,
            name: $name,
            meaning: Text::new($meaning_en, $meaning_ru),
            remedy: Text::new($remedy_en, $remedy_ru),
        }),+];
    };
}

statuses! {
    OK "Ok",
        "The request is done.",
        "Запрос исполнен полностью.",
        "Nothing.",
        "Ничего.";
    ACCEPTED "Accepted",
        "The request is taken and will be carried out; only a fault can stop it.",
        "Запрос принят к исполнению, помешать может только неисправность.",
        "Follow the progress with GetStatus.",
        "Следите за ходом по GetStatus.";
    NEED_CONFIRM "NeedConfirm",
        "The request must be confirmed: its key is missing or wrong.",
        "Для исполнения запроса необходимо прислать подтверждение: неверный ключ.",
        "Send the request with its key (§3.8, §3.9, §3.19).",
        "Отправьте запрос с его ключом (§3.8, §3.9, §3.19).";
    DENIED "Denied",
        "The state of the subsystem that answers forbids the request.",
        "Запрос отклонён из-за состояния ответившей подсистемы.",
        "See who answers: Deployer — deploy first; Detector — a search is going on; Control — a \
        program is running; a valve — close it; General — release the lockout.",
        "Смотрите, кто ответил: Deployer — разверните ствол; Detector — идёт поиск; Control — \
        выполняется программа; затвор — закройте его; General — снимите блокировку.";
    MODULE_NOT_EXIST "ModuleNotExist",
        "The addressee is not part of this monitor.",
        "Подсистема-получатель отсутствует в составе ствола.",
        "Check the addressee; GetStatus All and the parameter Chain show what the \
         monitor consists of.",
        "Проверьте получателя; состав ствола показывают GetStatus All и параметр Chain.";
    MODULE_FAULT "ModuleFault",
        "The addressee is faulty and cannot carry the request out.",
        "Подсистема-получатель неисправна и не может выполнить запрос.",
        "Read its status flags: they name the fault.",
        "Прочитайте её флаги состояния: они называют неисправность.";
    BUSY "Busy",
        "The addressee is busy.",
        "Подсистема-получатель занята.",
        "Repeat the request a little later.",
        "Повторите запрос через некоторое время.";
    WRONG_REQUEST "WrongRequest",
        "Unknown request, or not one for this addressee.",
        "Неверный идентификатор запроса (не поддерживаемый запрос).",
        "Check the pair of request and addressee against §3.",
        "Сверьте пару «запрос — получатель» с §3.";
    WRONG_DATA "WrongData",
        "The size of the request's data is wrong.",
        "Неверный объём данных запроса.",
        "Check data_size and, for SetParam, the number of values.",
        "Проверьте data_size, а для SetParam — количество значений.";
    NO_ROOM "NoRoom",
        "The answer did not fit the output buffer; later requests of the frame are not executed.",
        "В выходном буфере нет места для ответа; следующие запросы кадра не исполнены.",
        "Send the requests without an answer again, fewer in one frame.",
        "Повторите запросы, оставшиеся без ответа, меньшими порциями.";
    INVALID_ID "InvalidId",
        "The subsystem has no parameter with this identifier.",
        "У подсистемы нет параметра с таким идентификатором.",
        "Check the name: the identifier is its hash, letter by letter.",
        "Проверьте имя: идентификатор — это его хэш, буква в букву.";
    INVALID_VALUE "InvalidValue",
        "The value is out of range.",
        "Неверное значение параметра.",
        "Check range and unit (angles are in minutes).",
        "Проверьте диапазон и единицы (углы — в минутах).";
    ACCESS_DENIED "AccessDenied",
        "The parameter may not be accessed this way.",
        "Доступ к параметру запрещён.",
        "The parameter is read-only, or its limits must be off for it to be set.",
        "Параметр только для чтения, либо для записи нужно выключить пределы.";
    SYSTEM_FAULT "SystemFault",
        "The program met an error of its own; it should never happen.",
        "Системная ошибка программы; в реальной работе не должна возникать.",
        "Note the request and the state, read GetCrashData and report both.",
        "Запишите запрос и состояние, прочитайте GetCrashData и сообщите.";
    INCOMPLETE_CONFIG "IncompleteConfig",
        "The value is kept, but nothing is stored until every parameter of the subsystem is valid.",
        "Параметры не будут записаны в ЭНОЗУ, пока все параметры подсистемы не станут валидными.",
        "Set the other required parameters of the subsystem.",
        "Задайте остальные обязательные параметры подсистемы.";
    NOT_CACHED "NotCached",
        "Reading the parameter needs a remote unit that cannot be asked just now.",
        "Для чтения параметра нужно обращение к удалённому устройству, сейчас невозможное.",
        "Repeat the request a little later.",
        "Повторите запрос через некоторое время.";
    CACHED "Cached",
        "Writing the parameter needs a remote unit that cannot be asked just now.",
        "Для записи параметра нужно обращение к удалённому устройству, сейчас невозможное.",
        "Repeat the request a little later, and read the value back.",
        "Повторите запрос через некоторое время и прочитайте значение.";
    UNIMPLEMENTED "Unimplemented",
        "The subsystem does not implement the request; it should never happen.",
        "Запрос не реализован в подсистеме; в реальной работе не должно возникать.",
        "Report it with the version of the program.",
        "Сообщите об этом вместе с версией программы.";
    NOT_SUPPORTED "NotSupported",
        "This kind of subsystem does not support the request.",
        "Запрос не поддерживается заданной подсистемой.",
        "Nothing to be done: a drive with limit switches, say, has no limits to switch off.",
        "Ничего: например, у привода с датчиками конечных положений нет отключаемых пределов.";
}
