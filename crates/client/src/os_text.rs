//! Errors of the operating system in the language of the user.

use std::fmt;
use std::io::{Error, ErrorKind};

use lafet_texts::{Argument, Fixed, Lang, Shown, Text, client as text};

use crate::port_error::PortError;

/// How the standard library begins what a resolver says; the words after it are the resolver's own.
const LOOKUP: &str = "failed to lookup address information";
/// The same of Windows: WSAHOST_NOT_FOUND.
const LOOKUP_CODE: i32 = 11_001;

/// The text of an error of the system, without a full stop at its end. Its own words are English; in
/// other languages the common errors are translated, and any other is quoted as a text of the system.
/// A name of a host that is not known is said in words of ours in every language.
pub fn os_text(error: &Error, lang: Lang) -> String {
    SystemError(error).of(lang)
}

/// An error of the system as an argument of a text.
#[derive(Clone, Copy, Debug)]
pub struct SystemError<'a>(pub &'a Error);

impl Argument for SystemError<'_> {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        let Self(error) = *self;
        if let Some(port) = PortError::of(error) {
            return out.write_str(port.localized(lang).trim_end_matches('.'));
        }
        if is_lookup(error) {
            return text::OsHostUnknown { error: Shown(error) }.write(lang, out);
        }
        if lang == Lang::En {
            return write!(out, "{error}");
        }
        let no_text = error.kind() == ErrorKind::InvalidData && error.to_string().contains("UTF-8");
        let known = if no_text { Some(text::OsNoUtf8.fixed()) } else { common(error.kind()) };
        let Some(what) = known else {
            return text::OsOther { error: Shown(error) }.write(lang, out);
        };
        match error.raw_os_error() {
            Some(number) => text::OsNumbered { what, number }.write(lang, out),
            None => what.write(lang, out),
        }
    }
}

impl Text for SystemError<'_> {}

/// Whether no address was found for the name of a host. The standard library has no kind for it.
fn is_lookup(error: &Error) -> bool {
    let of_windows = cfg!(windows) && error.raw_os_error() == Some(LOOKUP_CODE);
    of_windows || error.raw_os_error().is_none() && error.to_string().starts_with(LOOKUP)
}

const fn common(kind: ErrorKind) -> Option<Fixed> {
    Some(match kind {
        ErrorKind::NotFound => text::OsNotFound.fixed(),
        ErrorKind::PermissionDenied => text::OsNotPermitted.fixed(),
        ErrorKind::ConnectionRefused => text::OsRefused.fixed(),
        ErrorKind::ConnectionReset => text::OsReset.fixed(),
        ErrorKind::ConnectionAborted => text::OsAborted.fixed(),
        ErrorKind::NotConnected => text::OsNotConnected.fixed(),
        ErrorKind::HostUnreachable => text::OsHostUnreachable.fixed(),
        ErrorKind::NetworkUnreachable => text::OsNetworkUnreachable.fixed(),
        ErrorKind::NetworkDown => text::OsNetworkDown.fixed(),
        ErrorKind::AddrInUse => text::OsAddressInUse.fixed(),
        ErrorKind::AddrNotAvailable => text::OsAddressNotHere.fixed(),
        ErrorKind::BrokenPipe => text::OsBrokenPipe.fixed(),
        ErrorKind::AlreadyExists => text::OsExists.fixed(),
        ErrorKind::TimedOut => text::OsTimedOut.fixed(),
        ErrorKind::UnexpectedEof => text::OsUnexpectedEnd.fixed(),
        ErrorKind::FileTooLarge => text::OsTooLarge.fixed(),
        ErrorKind::QuotaExceeded => text::OsQuota.fixed(),
        ErrorKind::StorageFull => text::OsDiskFull.fixed(),
        ErrorKind::ReadOnlyFilesystem => text::OsReadOnly.fixed(),
        ErrorKind::IsADirectory => text::OsIsFolder.fixed(),
        ErrorKind::NotADirectory => text::OsNotFolder.fixed(),
        ErrorKind::ResourceBusy => text::OsBusy.fixed(),
        ErrorKind::InvalidInput => text::OsInvalid.fixed(),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A real one: no resolver knows a name under `.invalid` (RFC 6761).
    #[test]
    fn an_unknown_host_is_named_in_every_language() {
        use std::net::ToSocketAddrs;
        let error = ("host.invalid", 1).to_socket_addrs().unwrap_err();
        let (english, russian) = (os_text(&error, Lang::En), os_text(&error, Lang::Ru));
        assert!(english.starts_with("this name of a host is not known"), "{english}");
        assert!(russian.starts_with("имя узла не найдено"), "{russian}");
        for text in [english, russian] {
            assert!(text.contains(&error.to_string()), "{text}: {error}");
        }
    }

    #[test]
    fn usual_errors_speak_russian_and_the_others_are_introduced() {
        let of = |number| os_text(&Error::from_raw_os_error(number), Lang::Ru);
        assert_eq!(of(13), "нет прав доступа (ошибка системы 13)");
        assert_eq!(of(2), "нет такого файла, устройства или узла (ошибка системы 2)");
        let other = os_text(&Error::other("strange"), Lang::Ru);
        assert_eq!(other, "ошибка системы: strange");
        assert_eq!(os_text(&Error::other("strange"), Lang::En), "strange");
        let text = std::fs::read_to_string(std::env::current_exe().unwrap()).unwrap_err();
        assert_eq!(os_text(&text, Lang::Ru), "это не текст UTF-8");
        let missing = || Error::from(PortError::Missing { path: "/dev/nope".into() });
        assert!(os_text(&missing(), Lang::Ru).starts_with("Порта /dev/nope нет. "));
        assert!(os_text(&missing(), Lang::En).ends_with("that there are"));
        for number in [2, 13, 16, 27, 28, 98, 122, 104, 110, 111, 113] {
            assert!(!of(number).contains("os error"), "{}", of(number));
        }
    }
}
