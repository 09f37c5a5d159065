//! Errors of the operating system in the language of the user.

use std::io::{Error, ErrorKind};

use crate::error::Lang;

/// The text of an error of the system. In Russian the common ones are translated; any other is
/// quoted as a text of the system.
pub fn os_text(error: &Error, lang: Lang) -> String {
    if lang == Lang::En {
        return error.to_string();
    }
    let text = match error.kind() {
        ErrorKind::NotFound => "нет такого файла, устройства или узла",
        ErrorKind::PermissionDenied => "нет прав доступа",
        ErrorKind::ConnectionRefused => "в соединении отказано",
        ErrorKind::ConnectionReset => "соединение сброшено другой стороной",
        ErrorKind::ConnectionAborted => "соединение прервано",
        ErrorKind::NotConnected => "нет соединения",
        ErrorKind::HostUnreachable => "узел недостижим",
        ErrorKind::NetworkUnreachable => "сеть недостижима",
        ErrorKind::NetworkDown => "сеть отключена",
        ErrorKind::AddrInUse => "адрес уже занят",
        ErrorKind::AddrNotAvailable => "такого адреса на этом компьютере нет",
        ErrorKind::BrokenPipe => "другая сторона закрыла соединение",
        ErrorKind::AlreadyExists => "уже существует",
        ErrorKind::TimedOut => "время ожидания вышло",
        ErrorKind::UnexpectedEof => "данные кончились раньше, чем ожидалось",
        ErrorKind::StorageFull => "на диске нет места",
        ErrorKind::ReadOnlyFilesystem => "файловая система только для чтения",
        ErrorKind::IsADirectory => "это папка, а не файл",
        ErrorKind::NotADirectory => "это не папка",
        ErrorKind::ResourceBusy => "устройство занято",
        ErrorKind::InvalidInput => "недопустимое значение",
        _ => return format!("ошибка системы: {error}"),
    };
    match error.raw_os_error() {
        Some(number) => format!("{text} (ошибка системы {number})"),
        None => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usual_errors_speak_russian_and_the_others_are_introduced() {
        let of = |number| os_text(&Error::from_raw_os_error(number), Lang::Ru);
        assert_eq!(of(13), "нет прав доступа (ошибка системы 13)");
        assert_eq!(of(2), "нет такого файла, устройства или узла (ошибка системы 2)");
        let other = os_text(&Error::other("strange"), Lang::Ru);
        assert_eq!(other, "ошибка системы: strange");
        assert_eq!(os_text(&Error::other("strange"), Lang::En), "strange");
        for number in [2, 13, 16, 28, 98, 104, 110, 111, 113] {
            assert!(!of(number).contains("os error"), "{}", of(number));
        }
    }
}
