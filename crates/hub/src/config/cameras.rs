//! Cameras: what a file may say of them.

use std::collections::BTreeSet;
use std::path::PathBuf;

use lafet_texts::{Text as _, hub as text};
use serde::Deserialize;
use toml::Spanned;

use super::check::{Check, is_name};
use super::file::{File, Name};
use super::mqtt::WrittenLogin;
use crate::cameras::{CAMERAS_MAX, CameraConfig, Mount};
use crate::text::Both;

/// Longest address of a camera.
const URL_MAX: usize = 512;
/// Longest user and password, bytes.
const LOGIN_MAX: usize = 256;

/// A camera as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    id: Spanned<String>,
    name: Option<Name>,
    url: Spanned<String>,
    user: Option<Spanned<String>>,
    password: Option<Spanned<String>>,
    password_file: Option<Spanned<PathBuf>>,
    #[serde(default)]
    monitors: Vec<Spanned<String>>,
    #[serde(default)]
    zones: Vec<Spanned<String>>,
    mount: Option<Spanned<Mount>>,
}

/// Why it is no address of a camera.
#[derive(Debug, PartialEq, Eq)]
enum NoUrl {
    /// It has a user in it.
    Login,
    /// It is encrypted, which is not supported.
    Tls,
    /// It is something else.
    Other,
}

/// `rtsp://HOST[:PORT][/PATH]`, without a user.
fn check_url(url: &str) -> Result<(), NoUrl> {
    let rest = match url.split_once("://") {
        Some(("rtsp", rest)) => rest,
        Some(("rtsps", _)) => return Err(NoUrl::Tls),
        _ => return Err(NoUrl::Other),
    };
    let place = rest.split(['/', '?', '#']).next().unwrap_or_default();
    if place.contains('@') {
        return Err(NoUrl::Login);
    }
    let (host, port) = match place.strip_prefix('[') {
        Some(rest) => {
            let (host, port) = rest.split_once(']').ok_or(NoUrl::Other)?;
            host.parse::<std::net::Ipv6Addr>().map_err(|_| NoUrl::Other)?;
            (host, if port.is_empty() { None } else { port.strip_prefix(':').or(Some("")) })
        }
        None => match place.split_once(':') {
            Some((host, port)) => (host, Some(port)),
            None => (place, None),
        },
    };
    let port_is_fine = port.is_none_or(|port| port.parse::<u16>().is_ok_and(|it| it != 0));
    let fine = |c: char| c.is_ascii_alphanumeric() || "-._:".contains(c);
    let host_is_fine = !host.is_empty() && host.chars().all(fine);
    let rest_is_fine = url.len() <= URL_MAX && url.chars().all(|c| c.is_ascii_graphic());
    match host_is_fine && port_is_fine && rest_is_fine {
        true => Ok(()),
        false => Err(NoUrl::Other),
    }
}

impl Check<'_> {
    /// The cameras.
    pub fn cameras(&mut self, read: &File) -> Vec<CameraConfig> {
        let mut ids = BTreeSet::new();
        let mut cameras = Vec::new();
        for written in &read.camera {
            if cameras.len() >= CAMERAS_MAX {
                let at = written.span().start;
                self.say(at, text::CheckCameras.words(), text::CheckCamerasRemedy.words());
                break;
            }
            cameras.push(self.camera(read, written.get_ref(), &mut ids));
        }
        cameras
    }

    fn camera<'a>(
        &mut self,
        read: &File,
        written: &'a Camera,
        ids: &mut BTreeSet<&'a str>,
    ) -> CameraConfig {
        let (id, at) = (written.id.get_ref(), written.id.span().start);
        if !is_name(id) {
            let what = text::CheckCameraId { id }.words();
            self.say(at, what, text::CheckMonitorIdRemedy.words());
        } else if !ids.insert(id) {
            let what = text::CheckMonitorTwice { id }.words();
            self.say(at, what, text::CheckCameraTwiceRemedy.words());
        }
        self.camera_url(&written.url);
        let login = self.login(&WrittenLogin {
            user: written.user.as_ref(),
            password: written.password.as_ref(),
            file: written.password_file.as_ref(),
        });
        for text in [&written.user, &written.password].into_iter().flatten() {
            if text.get_ref().len() > LOGIN_MAX {
                let at = text.span().start;
                self.say(at, text::CheckCameraLong.words(), text::CheckCameraLongRemedy.words());
            }
        }
        self.looked_at(read, written);
        let name = match &written.name {
            None => Both::same(id),
            Some(Name::One(name)) => Both::same(name),
            Some(Name::Two(name)) => name.clone(),
        };
        let ids = |all: &[Spanned<String>]| all.iter().map(|it| it.get_ref().clone()).collect();
        CameraConfig {
            id: id.clone(),
            name,
            url: written.url.get_ref().clone(),
            login,
            monitors: ids(&written.monitors),
            zones: ids(&written.zones),
            mount: written.mount.as_ref().map_or_else(Mount::default, |it| *it.get_ref()),
        }
    }

    /// What is said of an address repeats none: there may be a password in it.
    fn camera_url(&mut self, url: &Spanned<String>) {
        let (what, remedy) = match check_url(url.get_ref()) {
            Ok(()) => return,
            Err(NoUrl::Login) => {
                (text::CheckCameraUser.words(), text::CheckCameraUserRemedy.words())
            }
            Err(NoUrl::Tls) => (text::CheckCameraTls.words(), text::CheckCameraTlsRemedy.words()),
            Err(NoUrl::Other) => (text::CheckCameraUrl.words(), text::CheckCameraUrlRemedy.words()),
        };
        self.say(url.span().start, what, remedy);
    }

    /// The monitors and zones of a camera: they exist, and there are some.
    fn looked_at(&mut self, read: &File, written: &Camera) {
        let at = written.id.span().start;
        let monitors: Vec<&String> =
            read.monitor.iter().map(|it| it.get_ref().id.get_ref()).collect();
        let zones: Vec<&String> = read.zone.iter().map(|it| &it.get_ref().id).collect();
        let whole = [("monitor", monitors.len()), ("zone", zones.len())];
        let [monitors_whole, zones_whole] = whole.map(|(table, read)| !self.lacks(table, read));
        let mut seen = BTreeSet::new();
        for id in &written.monitors {
            let (id, at) = (id.get_ref(), id.span().start);
            if !monitors.contains(&id) && monitors_whole {
                let what = text::CheckServerMonitor { id }.words();
                self.say(at, what, text::CheckServerMonitorRemedy.words());
            } else if !seen.insert(("monitor", id)) {
                let what = text::CheckBusTwice { name: id }.words();
                self.say(at, what, text::CheckServerMonitorRemedy.words());
            }
        }
        for id in &written.zones {
            let (id, at) = (id.get_ref(), id.span().start);
            if !zones.contains(&id) && zones_whole {
                let what = text::CheckCameraZone { id }.words();
                self.say(at, what, text::CheckCameraZoneRemedy.words());
            } else if !seen.insert(("zone", id)) {
                let what = text::CheckBusTwice { name: id }.words();
                self.say(at, what, text::CheckCameraZoneRemedy.words());
            }
        }
        if written.monitors.is_empty() && written.zones.is_empty() {
            self.say(at, text::CheckCameraNothing.words(), text::CheckCameraNothingRemedy.words());
        }
        let mount = written.mount.as_ref();
        if let Some(mount) = mount.filter(|it| *it.get_ref() == Mount::Barrel)
            && written.monitors.len() != 1
        {
            let what = text::CheckCameraBarrel.words();
            self.say(mount.span().start, what, text::CheckCameraBarrelRemedy.words());
        }
    }
}

#[cfg(test)]
#[path = "cameras_tests.rs"]
mod tests;
