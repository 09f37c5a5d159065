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
