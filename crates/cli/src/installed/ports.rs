//! The serial ports in the configuration.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use lafet_client::Endpoint;
use lafet_client::transport::port::{Holder, PortError, holders};
use lafet_hub::Config;
use lafet_texts::{Text as _, cli as text};

use super::Finding;
use super::people::{READ, User, WRITE, group, group_of};
use crate::lang::current;

/// The group that may use serial ports, on Debian and most others.
const GROUP: &str = "dialout";
/// The hub itself, as the system names it.
const PROGRAM: &str = "lafet";

/// Whether each port is there, free and open to the hub's user.
pub fn examine(config: &Config, user: &User, running: bool) -> Vec<Finding> {
    let paths = paths(config);
    let mut findings: Vec<Finding> =
        paths.iter().filter_map(|path| of_port(path, user, running)).collect();
    let outside = !user.is_root() && group(GROUP).is_some_and(|it| !user.is_in(it));
    if !paths.is_empty() && outside {
        let seen = text::InstallGroup { user: &user.name, group: GROUP }.of(current());
        findings.push(Finding::fault("group", seen, join(user, GROUP)));
    }
    if !paths.is_empty() && findings.is_empty() {
        let count = paths.len();
        findings.push(Finding::good("ports", text::InstallPorts { count }.of(current())));
    }
    findings
}

fn paths(config: &Config) -> BTreeSet<PathBuf> {
    let monitors = config.monitors.iter().filter_map(|it| match &it.endpoint {
        Endpoint::Serial { path, .. } => Some(path.clone()),
        _ => None,
    });
    let buses = config.modbus.iter().filter_map(|it| it.line.device().cloned());
    monitors.chain(buses).collect()
}

fn of_port(path: &Path, user: &User, running: bool) -> Option<Finding> {
    let ports = text::InstallPortsRemedy.str(current()).to_owned();
    let shown = path.display().to_string();
    let error = match std::fs::metadata(path) {
        Err(_) => PortError::Missing { path: path.to_owned() },
        Ok(found) if !is_device(&found) => PortError::NotSerial { path: path.to_owned() },
        Ok(_) => return of_device(path, &shown, user, running),
    };
    Some(Finding::fault("port-missing", error.localized(current()), ports))
}

fn of_device(path: &Path, shown: &str, user: &User, running: bool) -> Option<Finding> {
    if !user.may(path, READ | WRITE) {
        let group = group_of(path).map(|(_, name)| name).unwrap_or_default();
        let seen = text::InstallPortDenied { user: &user.name, port: shown, group: &group };
        return Some(Finding::fault("port-denied", seen.of(current()), join(user, &group)));
    }
    let mut others = holders(path).into_iter();
    let by = others.find(|it: &Holder| !(running && it.program == PROGRAM))?;
    let (program, pid) = (&by.program, by.pid);
    let seen = text::InstallPortBusy { port: shown, program, pid }.of(current());
    Some(Finding::fault("port-busy", seen, text::InstallPortBusyRemedy.str(current()).into()))
}

fn join(user: &User, group: &str) -> String {
    text::InstallGroupRemedy { user: &user.name, group }.of(current())
}

#[cfg(unix)]
fn is_device(found: &std::fs::Metadata) -> bool {
    std::os::unix::fs::FileTypeExt::is_char_device(&found.file_type())
}

#[cfg(not(unix))]
fn is_device(_: &std::fs::Metadata) -> bool {
    true
}
