//! What the hub answers, as far as it is looked at. What is missing in an answer has its default; what was not
//! answered at all is `None`.

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer};
use serde_json::Value;

/// Everything that is read before anything is ordered.
#[derive(Clone, Debug, Default)]
pub struct Facts {
    /// `GET /api/hub`.
    pub hub: Option<About>,
    /// The date of the tester's computer when that was answered, ms since 1970; `None`: it is the same clock.
    pub date_ms: Option<u64>,
    /// `GET /health`.
    pub health: Option<Health>,
    /// `GET /api/hub/state`.
    pub state: Option<HubState>,
    /// `GET /api/monitors`.
    pub monitors: Option<BTreeMap<String, Monitor>>,
    /// Parameters as read from each monitor; `None`: it did not answer.
    pub params: BTreeMap<String, Option<Params>>,
    /// `GET /api/zones`.
    pub zones: Option<Zones>,
    /// `GET /api/zones/configured`.
    pub configured: Option<Configured>,
    /// `GET /api/installation`.
    pub installation: Option<Installation>,
    /// `GET /api/modbus`.
    pub buses: Option<Buses>,
    /// `GET /api/alarms`.
    pub alarms: Option<Vec<Alarm>>,
}

/// A null is as good as a field that is missing: the hub has nothing to say yet.
fn or_default<'de, D: Deserializer<'de>, T: Default + Deserialize<'de>>(
    from: D,
) -> Result<T, D::Error> {
    Ok(Option::<T>::deserialize(from)?.unwrap_or_default())
}

macro_rules! answers {
    ($($(#[$of:meta])* $name:ident { $($(#[$field_of:meta])* $field:ident: $type:ty,)* })*) => {
        $(
            $(#[$of])*
            #[derive(Clone, Debug, Default, PartialEq, Deserialize)]
            #[serde(default)]
            pub struct $name {
                $($(#[$field_of])* #[serde(deserialize_with = "or_default")] pub $field: $type,)*
            }
        )*
    };
}

answers! {
    /// The hub.
    About {
        /// Its version.
        version: String,
        /// Monitors are simulated.
        simulation: bool,
        /// It is a demonstration.
        demo: bool,
        /// Clients log in.
        login: bool,
        /// Its date, ms since 1970.
        now_ms: u64,
        /// It has run for so long, ms; 0: it does not say.
        up_ms: u64,
        /// The map.
        site: Option<Map>,
    }
    /// The map of the site.
    Map {
        /// Monitors by id.
        monitors: BTreeMap<String, Place>,
        /// Sectors kept clear of water.
        keep_outs: Vec<KeepOut>,
    }
    /// Where a monitor is.
    Place {
        /// East and north, m.
        at: [f64; 2],
        /// Bearing of its zero, degrees.
        heading: f64,
        /// Height of the nozzle, m.
        height: f64,
    }
    /// A sector.
    KeepOut {
        /// Its name.
        name: String,
        /// The monitor; none: all.
        monitor: Option<String>,
        /// From and to, degrees.
        bearings: [f64; 2],
        /// From and to, degrees.
        elevations: [f64; 2],
    }
    /// How the storage is.
    Health {
        /// `ok`, `failing`.
        storage: String,
        /// The same of the history.
        history: String,
        /// The audit log.
        audit_chain: Chain,
        /// Files of the state that were lost.
        state_lost: Vec<Value>,
    }
    /// The chain of the audit log.
    Chain {
        /// `checking`, `ok`, `broken`.
        state: String,
        /// Entries that were compared.
        verified: u64,
    }
    /// `GET /api/hub/state`.
    HubState {
        /// The audit log.
        audit: Audit,
        /// The disk.
        disk: Disk,
    }
    /// The audit log.
    Audit {
        /// Entries.
        entries: u64,
        /// Lost entries.
        lost: u64,
        /// It cannot be written.
        failing: bool,
    }
    /// The disk of the hub.
    Disk {
        /// Free, bytes; none: everything is in memory.
        free_bytes: Option<u64>,
        /// In all, bytes.
        total_bytes: Option<u64>,
    }
    /// A monitor.
    Monitor {
        /// Its state.
        status: Status,
        /// Its link.
        link: Link,
        /// Who holds it.
        authority: Authority,
        /// Whether it can work.
        readiness: Readiness,
        /// Limits of its drives.
        limits: Option<BTreeMap<String, Limits>>,
        /// A program that it executes.
        program: Option<Value>,
        /// Urgent requests of all clients so far.
        urgent: Option<Urgent>,
    }
    /// Urgent requests for a monitor.
    Urgent {
        /// Stop.
        stop: u64,
        /// Close.
        close: u64,
        /// Lockout.
        lockout: u64,
    }
    /// The state of a monitor.
    Status {
        /// Nothing was heard for a while.
        stale: bool,
        /// By subsystem.
        subsystems: BTreeMap<String, Subsystem>,
    }
    /// A subsystem.
    Subsystem {
        /// Its flags.
        flags: Vec<String>,
        /// Position, arc-minutes or mm.
        position: Option<f64>,
        /// Pressure, 0.1 atm.
        pressure: Option<f64>,
        /// Flow, l/s.
        flowrate: Option<f64>,
        /// Values that do not count.
        bad: BTreeMap<String, String>,
    }
    /// The link of a monitor.
    Link {
        /// `up`, `down`.
        state: String,
        /// Requests without an answer since the start, of a thousand.
        loss_permille: f64,
        /// Requests that were sent.
        sent: u64,
    }
    /// Who holds a monitor.
    Authority {
        /// `free`, `held`, `lost`.
        state: String,
        /// Who.
        holder: Option<Holder>,
    }
    /// Who holds a monitor.
    Holder {
        /// The user.
        user: String,
    }
    /// Whether a monitor can work.
    Readiness {
        /// It can.
        ready: bool,
        /// Everything that speaks against it.
        reasons: Vec<Reason>,
    }
    /// What speaks against it.
    Reason {
        /// `flag`, `link`, `stale`, `wrapped`.
        code: String,
        /// The subsystem.
        subsystem: Option<String>,
        /// The flag.
        flag: Option<String>,
    }
    /// Limits of a drive.
    Limits {
        /// Least position.
        min: f64,
        /// Greatest position.
        max: f64,
    }
    /// Parameters of a monitor.
    Params {
        /// By subsystem and name.
        values: BTreeMap<String, BTreeMap<String, Param>>,
    }
    /// A parameter.
    Param {
        /// Its values; none: it could not be read.
        values: Option<Vec<i64>>,
    }
    /// The zones.
    Zones {
        /// As the zone controller has them.
        state: ZonesState,
        /// The latest report of each detector.
        reported: BTreeMap<String, Reported>,
    }
    /// What a detector has reported.
    Reported {
        /// Bearing of what it sees, degrees clockwise from north.
        bearing_deg: Option<f64>,
    }
    /// The state of the zones.
    ZonesState {
        /// Since the start of the hub, ms.
        at_ms: u64,
        /// Lockout is on.
        lockout: bool,
        /// What sounds.
        tone: String,
        /// Zones.
        zones: Vec<Zone>,
        /// Detectors.
        detectors: Vec<Detector>,
        /// Monitors.
        monitors: Vec<ZoneMonitor>,
        /// Pumps.
        pumps: Vec<Pump>,
        /// Outputs.
        outputs: Vec<Output>,
        /// Troubles.
        troubles: Vec<Trouble>,
        /// What is disabled.
        disablements: Vec<Value>,
    }
    /// A zone.
    Zone {
        /// Its id.
        zone: String,
        /// What it does: a word, or a word with its details.
        phase: Value,
        /// Its mode.
        mode: String,
        /// It returns to automatic after so long, ms.
        returns_in_ms: Option<u64>,
        /// Detectors that vote.
        votes: Vec<String>,
        /// Detectors in alarm.
        alarms: Vec<String>,
        /// Detectors without a vote.
        unable: Vec<Voteless>,
        /// Monitors that are engaged.
        monitors: Vec<String>,
    }
    /// A detector without a vote.
    Voteless {
        /// Its id.
        detector: String,
        /// Why.
        why: Value,
    }
    /// A detector.
    Detector {
        /// Its id.
        detector: String,
        /// What it sees; none: it was not heard.
        signal: Option<String>,
        /// Why it has no vote.
        unable: Option<Value>,
        /// Its alarm was there at the start.
        stale: bool,
    }
    /// A monitor of the zones.
    ZoneMonitor {
        /// Its id.
        monitor: String,
        /// The zone that it works for.
        engaged_for: Option<String>,
        /// Close is repeated until it is reported closed.
        closing: bool,
        /// Why it is not used.
        withheld: Option<String>,
    }
    /// A pump.
    Pump {
        /// Its id.
        pump: String,
        /// As commanded.
        on: Option<bool>,
        /// Its pressure is there.
        pressure: Option<bool>,
        /// It has failed.
        failed: bool,
        /// It reports that it runs.
        runs: Option<bool>,
    }
    /// An output.
    Output {
        /// Its id.
        output: String,
        /// As commanded.
        on: Option<bool>,
        /// As reported.
        reported: Option<bool>,
    }
    /// A trouble.
    Trouble {
        /// Which.
        trouble: String,
        /// Of what.
        subject: String,
        /// It is there; else it waits for a reset.
        active: bool,
    }
    /// What belongs to each zone.
    Configured {
        /// Zones.
        zones: Vec<ConfiguredZone>,
        /// What each detector senses.
        detectors: BTreeMap<String, String>,
    }
    /// A zone as it is configured.
    ConfiguredZone {
        /// Its id.
        zone: String,
        /// Its detectors.
        detectors: Vec<String>,
        /// Its monitors.
        monitors: Vec<String>,
        /// `2oo3`.
        votes: String,
        /// Kinds among the votes.
        kinds: u16,
        /// Coincidence, s.
        coincidence_s: u32,
        /// Delay, s.
        delay_s: u32,
        /// All holds together, s.
        hold_max_s: Option<u32>,
        /// Greatest duration of water, s.
        water_max_s: u32,
        /// Return to automatic, s.
        return_after_s: Option<u32>,
    }
    /// `GET /api/installation`.
    Installation {
        /// Zones.
        zones: Vec<InstalledZone>,
        /// Aims.
        aims: Vec<InstalledAim>,
        /// Detectors.
        detectors: Vec<InstalledDetector>,
        /// Contacts.
        inputs: Vec<InstalledInput>,
        /// Outputs.
        outputs: Vec<InstalledOutput>,
        /// Pumps.
        pumps: Vec<InstalledPump>,
        /// Pumps run on for so long, s.
        run_on_s: u32,
    }
    /// A zone.
    InstalledZone {
        /// Its id.
        zone: String,
        /// Votes with failed detectors.
        when_failed: Vec<String>,
        /// Monitors at once.
        jets: Option<u16>,
        /// Output of its valve.
        valve: Option<String>,
        /// Output of its test outlet.
        test_outlet: Option<String>,
        /// Its water needs the pumps.
        pumps: bool,
    }
    /// An aim.
    InstalledAim {
        /// The zone.
        zone: String,
        /// The monitor.
        monitor: String,
        /// Stored program.
        program: i16,
        /// Centre, arc-minutes.
        horizontal: i16,
        /// Centre, arc-minutes.
        vertical: i16,
        /// Nozzle, mm.
        nozzle: i16,
        /// Valve of the water.
        valve: String,
    }
    /// A detector.
    InstalledDetector {
        /// Its id.
        detector: String,
        /// Silent after, s.
        silent_after_s: u32,
        /// Its place.
        at: Option<[f64; 3]>,
    }
    /// A contact.
    InstalledInput {
        /// Its id.
        input: String,
        /// What it is for.
        kind: String,
        /// Its zones.
        zones: Vec<String>,
    }
    /// An output.
    InstalledOutput {
        /// Its id.
        output: String,
        /// What it drives.
        kind: String,
        /// Its zone.
        zone: Option<String>,
    }
    /// A pump.
    InstalledPump {
        /// Its id.
        pump: String,
        /// It starts so long after the one before, s.
        start_delay_s: u32,
        /// Contact of its pressure.
        pressure: Option<String>,
        /// Without pressure for so long it has failed, s.
        start_timeout_s: u32,
        /// It starts in place of another.
        standby: bool,
    }
    /// `GET /api/modbus`.
    Buses {
        /// The buses.
        buses: Vec<Bus>,
    }
    /// A bus.
    Bus {
        /// Its name.
        name: String,
        /// The line is open.
        connected: bool,
        /// Detectors.
        detectors: Vec<Source>,
        /// Contacts.
        inputs: Vec<Source>,
        /// Outputs and pumps.
        outputs: Vec<Driven>,
    }
    /// What is read on a bus.
    Source {
        /// Its id.
        id: String,
        /// `good`, else how it is not read.
        reading: String,
    }
    /// What is written on a bus.
    Driven {
        /// Its id.
        id: String,
        /// What is wrong with it.
        trouble: Option<String>,
        /// What its feedback says.
        feedback: Option<bool>,
        /// What was read back.
        read_back: Option<bool>,
    }
    /// An alarm.
    Alarm {
        /// Its id.
        id: String,
        /// `fire`, `high`, `medium`, `low`.
        priority: String,
        /// It is there.
        active: bool,
    }
}

impl Monitor {
    /// Position of a drive, if it counts.
    pub fn position(&self, drive: &str) -> Option<f64> {
        let it = self.status.subsystems.get(drive)?;
        it.position.filter(|_| !it.bad.contains_key("position") && !self.status.stale)
    }

    /// A flag of a subsystem.
    pub fn has(&self, subsystem: &str, flag: &str) -> bool {
        let it = self.status.subsystems.get(subsystem);
        it.is_some_and(|it| it.flags.iter().any(|name| name == flag))
    }

    /// The valves that it has.
    fn valves(&self) -> impl Iterator<Item = &'static str> {
        ["Valve1", "Valve2"].into_iter().filter(|it| self.status.subsystems.contains_key(*it))
    }

    /// Its valves that it does not report closed for certain.
    pub fn not_closed(&self) -> Vec<&str> {
        self.valves().filter(|it| !self.has(it, "Closed")).collect()
    }

    /// It reports that water flows.
    pub fn flows(&self) -> bool {
        self.general("flowrate").is_some_and(|it| it > 0.0)
    }

    /// It is locked out.
    pub fn is_locked_out(&self) -> bool {
        self.has("General", "LockedOut")
    }

    /// It answers, and its state is fresh.
    pub fn is_heard(&self) -> bool {
        self.link.state == "up" && !self.status.stale && !self.status.subsystems.is_empty()
    }

    /// It says of each of its valves that it is closed, in a state that is fresh, by a switch without a fault.
    pub fn is_shut(&self) -> bool {
        let mut there = self.valves().peekable();
        !self.status.stale
            && there.peek().is_some()
            && there.all(|it| self.has(it, "Closed") && !self.has(it, "CloseSensorFault"))
    }

    /// A value of its general state, if it counts.
    pub fn general(&self, name: &str) -> Option<f64> {
        let it = self.status.subsystems.get("General")?;
        let value = if name == "pressure" { it.pressure } else { it.flowrate };
        value.filter(|_| !it.bad.contains_key(name) && !self.status.stale)
    }
}

impl Zone {
    /// The word of its phase.
    pub fn phase(&self) -> &str {
        match &self.phase {
            Value::String(word) => word,
            Value::Object(details) => details.keys().next().map_or("", String::as_str),
            _ => "",
        }
    }

    /// Something is under way in it.
    pub fn is_active(&self) -> bool {
        !matches!(self.phase(), "quiet" | "ended")
    }
}

impl Zones {
    /// A zone.
    pub fn zone(&self, id: &str) -> Option<&Zone> {
        self.state.zones.iter().find(|it| it.zone == id)
    }

    /// An output.
    pub fn output(&self, id: &str) -> Option<&Output> {
        self.state.outputs.iter().find(|it| it.output == id)
    }

    /// Detectors in alarm.
    pub fn alarms(&self) -> Vec<&str> {
        let all = self.state.detectors.iter();
        all.filter(|it| it.signal.as_deref() == Some("alarm"))
            .map(|it| it.detector.as_str())
            .collect()
    }
}
