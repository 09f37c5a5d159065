//! Serial ports of this computer and their properties.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::{fs, io};

use crate::shared::lock;
use crate::transport::port::{Holder, PortError, holders, may_open};
use crate::url::Endpoint;
use crate::usb::Usb;

/// A serial port.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Port {
    /// Path of the device, for use in a URL.
    pub path: PathBuf,
    /// A path that does not depend on the USB socket (`/dev/serial/by-id`).
    pub stable_path: Option<PathBuf>,
    /// Name of the kernel driver.
    pub driver: Option<String>,
    /// The USB adapter, if the port is one.
    pub usb: Option<Usb>,
    /// Whether this user may open it.
    pub permitted: bool,
    /// Programs that have it open, as far as this user may see them.
    pub in_use: Vec<Holder>,
}

/// The adapters behind the ports that were opened: a port that is opened again must lead to the same
/// line.
#[derive(Debug, Default)]
pub(crate) struct Adapters(Mutex<BTreeMap<PathBuf, Usb>>);

impl Adapters {
    /// Remembers the adapter of a port that is open already.
    pub fn of(endpoint: &Endpoint) -> Self {
        let adapters = Self::default();
        // Nothing was remembered before that could differ.
        let _ = adapters.check(endpoint);
        adapters
    }

    /// Remembers the adapter of a port that was opened for the first time.
    ///
    /// # Errors
    ///
    /// [`PortError::OtherAdapter`] if there was another one before.
    pub fn check(&self, endpoint: &Endpoint) -> io::Result<()> {
        let Endpoint::Serial { path, .. } = endpoint else { return Ok(()) };
        self.compare(path, adapter(Path::new(CLASS), path))
    }

    fn compare(&self, path: &Path, now: Option<Usb>) -> io::Result<()> {
        let mut known = lock(&self.0);
        match (known.get(path), now) {
            (Some(was), Some(now)) if is_same(was, &now) => Ok(()),
            (Some(was), now) => {
                let (was, now) = (Box::new(was.clone()), now.map(Box::new));
                Err(PortError::OtherAdapter { path: path.into(), was, now }.into())
            }
            (None, Some(now)) => {
                known.insert(path.into(), now);
                Ok(())
            }
            // Not an adapter, or the system does not show it.
            (None, None) => Ok(()),
        }
    }
}

/// Whether it is the same adapter, as far as the system shows: those without a serial number are alike.
fn is_same(one: &Usb, other: &Usb) -> bool {
    let of = |it: &Usb| (it.vendor_id.clone(), it.product_id.clone(), it.serial.clone());
    of(one) == of(other)
}

/// The adapter of a port, which may be named by a link.
fn adapter(class: &Path, path: &Path) -> Option<Usb> {
    let path = fs::canonicalize(path).ok()?;
    usb(&fs::canonicalize(class.join(path.file_name()?).join("device")).ok()?)
}

/// The kernel's list of ports.
const CLASS: &str = "/sys/class/tty";
/// Levels of sysfs between a port and its USB device.
const LEVELS_MAX: usize = 8;

/// The serial ports of this computer, ordered by name, without pseudo-terminals.
pub fn ports() -> Vec<Port> {
    #[cfg(target_os = "linux")]
    let mut ports = found(Path::new(CLASS), Path::new("/dev"));
    #[cfg(not(target_os = "linux"))]
    let mut ports: Vec<Port> = serial2_tokio::SerialPort::available_ports()
        .unwrap_or_default()
        .into_iter()
        .map(|path| Port { path, ..Port::default() })
        .collect();
    for port in &mut ports {
        port.permitted = may_open(&port.path);
        port.in_use = holders(&port.path);
    }
    ports
}

/// The ports in these folders of the kernel.
#[cfg_attr(not(target_os = "linux"), allow(dead_code, reason = "there is no sysfs"))]
fn found(class: &Path, dev: &Path) -> Vec<Port> {
    let stable = stable_names(&dev.join("serial/by-id"));
    let entries = fs::read_dir(class).into_iter().flatten().flatten();
    let mut ports: Vec<Port> = entries
        .filter_map(|entry| {
            let (name, place) = (entry.file_name(), entry.path());
            // An entry without a device is a terminal of the kernel.
            let device = fs::canonicalize(place.join("device")).ok()?;
            // The kernel's table of legacy ports has entries without hardware: their type is 0.
            if read(&place, "type").as_deref() == Some("0") {
                return None;
            }
            let path = dev.join(&name);
            let driver = fs::canonicalize(device.join("driver")).ok();
            let driver = driver.and_then(|path| Some(path.file_name()?.to_str()?.to_owned()));
            let target = fs::canonicalize(&path).unwrap_or_else(|_| path.clone());
            let stable_path = stable.iter().find(|(_, to)| *to == target).map(|(at, _)| at.clone());
            Some(Port { path, stable_path, driver, usb: usb(&device), ..Port::default() })
        })
        .collect();
    ports.sort_by(|a, b| a.path.cmp(&b.path));
    ports
}

fn stable_names(folder: &Path) -> Vec<(PathBuf, PathBuf)> {
    let links = fs::read_dir(folder).into_iter().flatten().flatten().map(|link| link.path());
    links.filter_map(|link| Some((link.clone(), fs::canonicalize(&link).ok()?))).collect()
}

fn usb(device: &Path) -> Option<Usb> {
    let device = device.ancestors().take(LEVELS_MAX).find(|at| at.join("idVendor").exists())?;
    Some(Usb {
        vendor_id: read(device, "idVendor")?,
        product_id: read(device, "idProduct")?,
        vendor: read(device, "manufacturer"),
        product: read(device, "product"),
        serial: read(device, "serial"),
    })
}

fn read(folder: &Path, name: &str) -> Option<String> {
    let text = fs::read_to_string(folder.join(name)).ok()?;
    Some(text.trim().to_owned()).filter(|text| !text.is_empty())
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    /// A kernel's folders with an adapter on USB, an old port without hardware, and a console.
    #[test]
    fn adapters_are_found_and_named() {
        let root = std::env::temp_dir().join(format!("lafet-ports-{}", std::process::id()));
        let (class, dev) = (root.join("class"), root.join("dev"));
        let usb = root.join("devices/usb1/1-1");
        let port = usb.join("1-1:1.0/ttyUSB0");
        for folder in [&class.join("ttyUSB0"), &class.join("ttyS1"), &class.join("tty0"), &port] {
            fs::create_dir_all(folder).unwrap();
        }
        fs::create_dir_all(dev.join("serial/by-id")).unwrap();
        fs::create_dir_all(root.join("drivers/ftdi_sio")).unwrap();
        symlink(&port, class.join("ttyUSB0/device")).unwrap();
        symlink(root.join("drivers/ftdi_sio"), port.join("driver")).unwrap();
        symlink(&usb, class.join("ttyS1/device")).unwrap();
        fs::write(class.join("ttyS1/type"), "0\n").unwrap();
        fs::write(dev.join("ttyUSB0"), "").unwrap();
        symlink(dev.join("ttyUSB0"), dev.join("serial/by-id/usb-FTDI-if00")).unwrap();
        for (name, text) in [("idVendor", "0403"), ("idProduct", "6001"), ("serial", "A1")] {
            fs::write(usb.join(name), format!("{text}\n")).unwrap();
        }
        let ports = found(&class, &dev);
        let by_id = adapter(&class, &dev.join("serial/by-id/usb-FTDI-if00"));
        fs::remove_dir_all(&root).unwrap();
        let [port] = &ports[..] else { panic!("{ports:?}") };
        assert_eq!(port.path, dev.join("ttyUSB0"));
        assert_eq!(port.stable_path, Some(dev.join("serial/by-id/usb-FTDI-if00")));
        assert_eq!(port.driver.as_deref(), Some("ftdi_sio"));
        let usb = port.usb.as_ref().expect("it is on USB");
        assert_eq!((&usb.vendor_id[..], &usb.product_id[..]), ("0403", "6001"));
        assert_eq!((usb.serial.as_deref(), usb.vendor.as_deref()), (Some("A1"), None));
        assert_eq!(by_id.as_ref(), Some(usb));
    }

    /// A port that comes back is the same line only with the same adapter.
    #[test]
    fn another_adapter_is_no_substitute() {
        let adapter = |serial: &str| Usb {
            vendor_id: "0403".into(),
            product_id: "6001".into(),
            serial: Some(serial.into()),
            ..Usb::default()
        };
        let (known, path) = (Adapters::default(), Path::new("/dev/ttyUSB0"));
        known.compare(path, Some(adapter("A1"))).unwrap();
        known.compare(path, Some(adapter("A1"))).unwrap();
        known.compare(Path::new("/dev/ttyUSB1"), Some(adapter("B2"))).unwrap();
        let error = known.compare(path, Some(adapter("B2"))).unwrap_err();
        let text = PortError::of(&error).unwrap().localized(crate::Lang::En);
        assert!(text.contains("0403:6001 B2 in place of 0403:6001 A1"), "{text}");
        known.compare(path, None).unwrap_err();
        known.compare(path, Some(adapter("A1"))).unwrap();
        // A pseudo-terminal has none.
        known.compare(Path::new("/dev/pts/0"), None).unwrap();
        known.compare(Path::new("/dev/pts/0"), None).unwrap();
    }
}
