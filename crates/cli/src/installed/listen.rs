//! The address that the hub listens on.

use std::io::{self, ErrorKind};
use std::net::{SocketAddr, TcpListener};

use lafet_client::os_text;
use lafet_texts::{Shown, Text as _, cli as text};

use super::Finding;
use crate::lang::current;

/// Whether the hub can have its address, or has it.
pub fn examine(listen: SocketAddr, running: bool) -> Option<Finding> {
    if running {
        let seen = text::InstallRunning { listen: Shown(listen) }.of(current());
        return Some(Finding::good("running", seen));
    }
    // The port is free again at once.
    TcpListener::bind(listen).err().map(|error| refused(listen, &error))
}

fn refused(address: SocketAddr, error: &io::Error) -> Finding {
    let listen = Shown(address);
    match error.kind() {
        ErrorKind::AddrInUse => Finding::fault(
            "listen-taken",
            text::InstallListenTaken { listen }.of(current()),
            text::InstallListenTakenRemedy.str(current()).into(),
        ),
        // The unit has the capability for ports under 1024, which this user may lack.
        ErrorKind::PermissionDenied => Finding::warning(
            "listen-denied",
            text::InstallListenDenied { listen }.of(current()),
            text::InstallListenDeniedRemedy.str(current()).into(),
        ),
        _ => Finding::fault(
            "listen-wrong",
            format!("{address}: {}", os_text(error, current())),
            text::InstallListenWrongRemedy.str(current()).into(),
        ),
    }
}

#[cfg(test)]
mod tests {
    use lafet_client::doctor::Severity;

    use super::*;

    /// Root, which runs tests, may have every port.
    #[test]
    fn a_port_that_only_the_unit_may_have_is_no_fault() {
        let listen = SocketAddr::from(([127, 0, 0, 1], 443));
        let finding = refused(listen, &ErrorKind::PermissionDenied.into());
        assert_eq!((finding.name, finding.severity), ("listen-denied", Severity::Warning));
        assert!(finding.seen.contains("127.0.0.1:443") && finding.remedy.is_some());
        assert_eq!(refused(listen, &ErrorKind::AddrInUse.into()).name, "listen-taken");
    }
}
