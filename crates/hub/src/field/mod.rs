//! Detectors, contacts, outputs and pumps on Modbus: each bus has a task that reads its devices and reports
//! them to the zone controller, detectors in the same way as reports over HTTP, and writes what it orders.
//!
//! ```text
//!  line ─▶ wire ─▶ maps ─▶ watch ─▶ zones
//!  bytes   frames  signal  may it   the machine
//!          values          count?
//!          write ◀─ drive ◀─ zones
//!          frames   what is  orders
//!                   due
//! ```
//!
//! What it cannot read right is a fault of the detector, never silence of a fire: see [`watch`]. What it
//! has not read back is not written: see [`drive`].

mod bus;
pub mod drive;
pub mod line;
pub mod maps;
mod plan;
pub mod point;
pub mod target;
pub mod view;
mod watch;
pub mod wire;
pub mod write;
mod writes;

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use crate::hub::{Caller, Hub};
use bus::Bus;
use drive::{Drives, Order};
use line::Line;
use maps::Map;
use point::Point;
use target::Target;
use view::ModbusView;
use wire::{Asks as _, Request, Table};

/// A bus of the configuration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BusConfig {
    /// Its name.
    pub name: String,
    /// Where it is.
    pub line: Line,
    /// Time between two reads of a device, ms.
    pub poll_ms: u64,
    /// An answer is waited for so long, ms.
    pub timeout_ms: u64,
    /// A detector counts as starting up for so long after it was not read, s.
    pub settle_s: u32,
    /// The detectors on it.
    pub sources: Vec<SourceConfig>,
    /// The outputs and pumps on it.
    pub outputs: Vec<OutputConfig>,
    /// What changes every second as long as the hub works, by the address of its device.
    pub heartbeats: Vec<(u8, Target)>,
}

/// An output or a pump on a bus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputConfig {
    /// Its id.
    pub id: String,
    /// What it drives.
    pub drives: Drives,
    /// Address of its device.
    pub unit: u8,
    /// What is written.
    pub target: Target,
    /// The bit that reports it on or open.
    pub on: Option<Point>,
    /// The bit that reports a fault.
    pub fault: Option<Point>,
    /// What is written can be read.
    pub read_back: bool,
}

impl OutputConfig {
    /// What is read of it.
    pub fn places(&self) -> Vec<(Table, u16)> {
        let target = self.read_back.then_some((self.target.table, self.target.address));
        let points = [self.on, self.fault].into_iter().flatten();
        target.into_iter().chain(points.map(|it| (it.table, it.address))).collect()
    }

    /// It reports itself to the zone controller.
    pub const fn reports(&self) -> bool {
        self.read_back || self.on.is_some()
    }
}

/// A detector or a contact on a bus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceConfig {
    /// Its id.
    pub id: String,
    /// What it is.
    pub sort: Sort,
    /// Address of its device.
    pub unit: u8,
    /// What its registers mean.
    pub map: Map,
    /// It is silent if nothing was heard for so long, s.
    pub silent_after_s: u32,
}

impl BusConfig {
    /// What one round of its devices takes at the least, with nothing but bytes and silence.
    pub fn round(&self) -> Duration {
        let requests = self.requests();
        let one = |it: &Request| self.line.takes(it.serial_len()) + 2 * self.line.silence();
        requests.iter().map(one).sum()
    }

    fn requests(&self) -> Vec<Request> {
        plan::requests(&self.needs()).into_values().flatten().collect()
    }

    fn needs(&self) -> BTreeSet<(u8, Table, u16)> {
        let of_source = |it: &SourceConfig| {
            let unit = it.unit;
            it.map.addresses().into_iter().map(move |(table, address)| (unit, table, address))
        };
        let of_output = |it: &OutputConfig| {
            let unit = it.unit;
            it.places().into_iter().map(move |(table, address)| (unit, table, address))
        };
        let sources = self.sources.iter().flat_map(of_source);
        sources.chain(self.outputs.iter().flat_map(of_output)).collect()
    }
}

/// What is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sort {
    /// A detector.
    Detector,
    /// A contact: pressed if it alarms.
    Contact,
}

/// The buses of a hub.
#[derive(Debug, Default)]
pub struct Field {
    buses: Vec<Arc<Bus>>,
}

impl Field {
    /// The buses of the configuration; nothing is read yet.
    pub fn new(configs: &[BusConfig]) -> Self {
        Self { buses: configs.iter().cloned().map(Bus::new).map(Arc::new).collect() }
    }

    /// Takes an order for an output or a pump.
    pub fn order(&self, id: &str, order: Order) {
        let _is_known = self.buses.iter().any(|bus| bus.order(id, order));
    }

    /// The bus on which a detector is.
    pub fn bus_of(&self, detector: &str) -> Option<&str> {
        let is_it = |it: &SourceConfig| it.sort == Sort::Detector && it.id == detector;
        let has = |bus: &&Arc<Bus>| bus.config.sources.iter().any(is_it);
        self.buses.iter().find(has).map(|bus| bus.config.name.as_str())
    }
}

/// Reads all buses until the hub ends.
pub fn start(hub: &Hub) {
    for bus in &hub.field().buses {
        let (own, bus) = (hub.clone(), bus.clone());
        drop(hub.again("a bus of detectors", move || bus::run(own.clone(), bus.clone())));
    }
}

impl Hub {
    /// The buses as they are.
    pub fn modbus_view(&self) -> ModbusView {
        let now = self.now();
        ModbusView { buses: self.field().buses.iter().map(|bus| bus.view(now)).collect() }
    }
}

impl Caller {
    /// A device on a bus, as its reports name it: `modbus panel unit 1`.
    fn modbus(bus: &str, unit: u8) -> Self {
        let mut caller = Self::hub();
        caller.principal.user = format!("modbus {bus} unit {unit}");
        caller
    }
}
