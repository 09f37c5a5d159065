//! `lafet ports`: the serial ports of this computer.

use clap::Args;
use lafet_client::Usb;
use lafet_client::ports::{Port, ports};
use lafet_texts::cli as text;
use serde::Serialize;

use crate::failure::Outcome;
use crate::lang::current;
use crate::out::{Out, columns};

/// Arguments of `lafet ports`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet ports\n  lafet ports --json")]
pub struct PortsArgs {}

/// A port as JSON.
#[derive(Serialize)]
struct Entry<'a> {
    path: String,
    url: String,
    stable_path: Option<String>,
    driver: Option<&'a str>,
    usb: Option<Adapter<'a>>,
    permitted: bool,
    in_use: Vec<Program<'a>>,
}

#[derive(Serialize)]
struct Adapter<'a> {
    vendor_id: &'a str,
    product_id: &'a str,
    vendor: Option<&'a str>,
    product: Option<&'a str>,
    serial: Option<&'a str>,
}

#[derive(Serialize)]
struct Program<'a> {
    pid: u32,
    program: &'a str,
}

/// Runs `lafet ports`.
pub fn run(_: &PortsArgs, out: &mut Out) -> Outcome {
    let ports = ports();
    if out.json() {
        return ports.iter().try_for_each(|port| {
            let value = serde_json::to_value(entry(port)).map_err(std::io::Error::from)?;
            out.value(&value)
        });
    }
    if ports.is_empty() {
        return out.say(text::NoSerialPort.str(current()));
    }
    let rows: Vec<Vec<String>> = ports.iter().map(row).collect();
    out.say(columns(&rows))
}

fn entry(port: &Port) -> Entry<'_> {
    let path = |path: &std::path::Path| path.display().to_string();
    let programs = port.in_use.iter();
    Entry {
        path: path(&port.path),
        url: url(port),
        stable_path: port.stable_path.as_deref().map(path),
        driver: port.driver.as_deref(),
        usb: port.usb.as_ref().map(|usb| Adapter {
            vendor_id: &usb.vendor_id,
            product_id: &usb.product_id,
            vendor: usb.vendor.as_deref(),
            product: usb.product.as_deref(),
            serial: usb.serial.as_deref(),
        }),
        permitted: port.permitted,
        in_use: programs.map(|by| Program { pid: by.pid, program: &by.program }).collect(),
    }
}

/// The URL for `-c`, with the port's persistent name if it has one.
fn url(port: &Port) -> String {
    format!("serial://{}", port.stable_path.as_ref().unwrap_or(&port.path).display())
}

fn row(port: &Port) -> Vec<String> {
    let users: Vec<String> = port.in_use.iter().map(ToString::to_string).collect();
    let state = match (&users[..], port.permitted) {
        ([], true) => text::PortFree.str(current()).to_owned(),
        ([], false) => text::PortNoPermission.str(current()).to_owned(),
        (users, _) => {
            format!("{} {}", text::PortInUseBy.str(current()), users.join(", "))
        }
    };
    let kind = port.usb.as_ref().map_or_else(|| port.driver.clone().unwrap_or_default(), named);
    let stable = port.stable_path.as_ref().map(|path| path.display().to_string());
    vec![port.path.display().to_string(), state, kind, stable.unwrap_or_default()]
}

fn named(usb: &Usb) -> String {
    let words = [&usb.vendor, &usb.product, &usb.serial];
    let words: Vec<&str> = words.into_iter().flatten().map(String::as_str).collect();
    match &words[..] {
        [] => format!("USB {}:{}", usb.vendor_id, usb.product_id),
        words => words.join(" "),
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use lafet_client::transport::port::Holder;
    use serde_json::{Value, json};

    use super::*;

    fn port() -> Port {
        let mut port = Port::default();
        port.path = PathBuf::from("/dev/ttyUSB0");
        port.stable_path = Some(PathBuf::from("/dev/serial/by-id/usb-1"));
        port.driver = Some("ftdi_sio".into());
        port.permitted = true;
        port
    }

    /// A row says whether the port may be opened, and by whom it is used.
    #[test]
    fn a_row_says_who_has_the_port() {
        let free = row(&port());
        assert_eq!(free, ["/dev/ttyUSB0", "free", "ftdi_sio", "/dev/serial/by-id/usb-1"]);
        let mut denied = port();
        denied.permitted = false;
        assert_eq!(row(&denied)[1], text::PortNoPermission.str(current()));
        denied.in_use = vec![Holder { pid: 42, program: "minicom".into() }];
        assert!(row(&denied)[1].contains("minicom (42)"), "{:?}", row(&denied));
    }

    /// An entry has what the schema describes, and no more.
    #[test]
    fn an_entry_is_as_described() {
        let mut used = port();
        used.in_use = vec![Holder { pid: 42, program: "minicom".into() }];
        used.usb = Some(Usb::default());
        let entry = serde_json::to_value(entry(&used)).unwrap();
        assert_eq!(entry["url"], "serial:///dev/serial/by-id/usb-1");
        assert_eq!(entry["in_use"], json!([{ "pid": 42, "program": "minicom" }]));
        assert_eq!(entry["permitted"], true);
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/schema/cli-1.json");
        let schema: Value = serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap();
        let described =
            |value: &Value| value.as_object().unwrap().keys().cloned().collect::<Vec<_>>();
        let shape = &schema["$defs"]["port"]["properties"];
        assert_eq!(described(&entry), described(shape));
        let usb = &shape["usb"]["anyOf"][1]["properties"];
        assert_eq!(described(&entry["usb"]), described(usb));
    }
}
