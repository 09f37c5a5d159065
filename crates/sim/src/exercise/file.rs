//! From the text of a scenario file to a plan: title, weather, site, monitors, fires.

use lafet_device::Source as Interface;
use lafet_device::composition::Composition;
use lafet_proto::record::{Records, Writer};
use lafet_proto::{Answer, Status, SubsystemId, text as wire};
use lafet_texts::{Shown, Text as _, Words, parse_error_text, sim as text};

use super::plan::{Exercise, FirePlan, MonitorPlan};
use super::reader::{Document, Problem, Table};
use super::{effect, scenes, steps};
use crate::fire::{Class, FireSpec};
use crate::flash::Flash;
use crate::foam::Foam;
use crate::sim::{Config, Sim};
use crate::site::{MonitorConfig, Pose, SiteConfig, SiteFire, SupplySpec, WindSpec};

/// Monitors and fires at most: a picture with more is not legible.
const MONITORS_MAX: usize = 16;
/// Fires at most.
pub const FIRES_MAX: usize = 32;

impl Exercise {
    /// Reads a scenario; `file` is what problems call it.
    pub fn parse(file: &str, text: &str) -> Result<Self, Problem> {
        let document = Document::parse(file, text)?;
        let root = document.root();
        let mut exercise = Self::empty(file);
        exercise.read_head(&root)?;
        exercise.read_weather(&root)?;
        scenes::read(&mut exercise, &root)?;
        for table in root.tables("supply")? {
            exercise.read_supply(table)?;
        }
        for table in root.tables("monitor")? {
            exercise.read_monitor(table)?;
        }
        effect::supplies(&exercise, &root)?;
        if exercise.monitors.is_empty() {
            let what = text::NeedsMonitor.words();
            return Err(root.wrong("monitor", what));
        }
        let foam = exercise.read_foam(&root)?;
        for table in root.tables("fire")? {
            exercise.read_fire(table, foam)?;
        }
        steps::read(&mut exercise, &root)?;
        root.finish()?;
        Ok(exercise)
    }

    fn empty(file: &str) -> Self {
        Self {
            file: file.to_owned(),
            title: Words::default(),
            about: Words::default(),
            duration_ms: 0,
            site: SiteConfig { ambient_c: 20.0, ..SiteConfig::default() },
            view: None,
            indoors: false,
            monitors: Vec::new(),
            fires: Vec::new(),
            obstacles: Vec::new(),
            glares: Vec::new(),
            supplies: Vec::new(),
            bus: Vec::new(),
            events: Vec::new(),
            operator: Vec::new(),
            controllers: Vec::new(),
            expectations: Vec::new(),
            marks: Vec::new(),
        }
    }

    fn read_head(&mut self, root: &Table<'_>) -> Result<(), Problem> {
        let needed = || root.wrong("scenario", text::NeedsScenario.words());
        let head = root.table_of("scenario")?.ok_or_else(needed)?;
        self.title = head.needed_both("title")?;
        self.about = head.needed_both("about")?;
        let duration = head.needed_text("duration")?;
        let wrong = || head.wrong("duration", super::reader::a_time(duration));
        self.duration_ms = head.time("duration")?.filter(|ms| *ms > 0).ok_or_else(wrong)?;
        self.site.seed = head.whole("seed", 0.0, 1e9)?.unwrap_or(7);
        self.view = head.numbers("view")?;
        self.bus = head.texts("bus")?.into_iter().map(str::to_owned).collect();
        head.finish()
    }

    fn read_weather(&mut self, root: &Table<'_>) -> Result<(), Problem> {
        let Some(weather) = root.table_of("weather")? else { return Ok(()) };
        self.site.ambient_c = weather.number("temperature", -60.0, 60.0)?.unwrap_or(20.0);
        self.indoors = weather.truth("indoors")?.unwrap_or(false);
        self.site.wind = steps::wind(&weather, WindSpec::default())?.unwrap_or_default();
        weather.finish()
    }

    fn read_supply(&mut self, table: Table<'_>) -> Result<(), Problem> {
        let name = fresh_name(&table, &self.supplies)?;
        let closed_mpa = table.needed("pressure", 0.05, 2.5)?;
        let flow_lps = table.needed("at_flow", 1.0, 1000.0)?;
        let pressure_mpa = table.needed("pressure_at_flow", 0.0, closed_mpa)?;
        self.supplies.push(name);
        self.site.supplies.push(SupplySpec { closed_mpa, flow_lps, pressure_mpa });
        table.finish()
    }

    fn read_monitor(&mut self, table: Table<'_>) -> Result<(), Problem> {
        let names: Vec<String> = self.monitors.iter().map(|it| it.name.clone()).collect();
        let name = fresh_name(&table, &names)?;
        if names.len() == MONITORS_MAX {
            let max = MONITORS_MAX;
            let what = text::MonitorsAtMost { most: max }.words();
            return Err(table.wrong("", what));
        }
        let [x, y] = table.needed_numbers("at")?;
        let heading_deg = table.number("heading", -360.0, 360.0)?.unwrap_or(0.0);
        let supply = table.one_of_names("supply", &self.supplies)?;
        let profiles = Composition::ALL.map(|profile| (profile.name, profile));
        let mut config = Config {
            composition: table.choice("profile", &profiles)?.unwrap_or(Composition::FULL),
            address: table.whole("address", 1.0, 127.0)?.unwrap_or(names.len() as u64 + 1) as u8,
            height_m: table.number("height", 0.2, 60.0)?.unwrap_or(1.5),
            nozzle_mm: table.number("nozzle", 10.0, 60.0)?.unwrap_or(28.0),
            ..Config::default()
        };
        if let Some([left, up]) = table.numbers("misalignment")? {
            if !config.composition.chain.contains(SubsystemId::DETECTOR) {
                return Err(table.wrong("misalignment", effect::without("Detector")));
            }
            config.misalignment = (left, up);
        }
        let twin = self.site.monitors.iter().position(|it| it.sim.address == config.address);
        if let Some(twin) = twin {
            let other = &self.monitors[twin].name;
            return Err(table.wrong("address", text::AddressTaken { monitor: other }.words()));
        }
        config.flash = Some(
            commissioned(&config, &table.texts("set")?).map_err(|what| table.wrong("set", what))?,
        );
        let listen = table.texts("listen")?.into_iter().map(str::to_owned).collect();
        self.monitors.push(MonitorPlan { name, listen });
        let pose = Pose { at: (x, y), heading_deg };
        self.site.monitors.push(MonitorConfig { pose, supply, sim: config });
        table.finish()
    }

    fn read_fire(&mut self, table: Table<'_>, foam: Foam) -> Result<(), Problem> {
        let names: Vec<String> = self.fires.iter().map(|fire| fire.name.clone()).collect();
        let name = fresh_name(&table, &names)?;
        if names.len() == FIRES_MAX {
            let max = FIRES_MAX;
            let what = text::FiresAtMost { most: max }.words();
            return Err(table.wrong("", what));
        }
        let on = table.one_of_names("on", &self.obstacles)?;
        let on_tank = on.and_then(|on| scenes::top_of(&self.site.obstacles[on]));
        if on.is_some() && on_tank.is_none() {
            return Err(table.wrong("on", text::OnlyTank.words()));
        }
        let at = match (table.numbers::<2>("at")?, on_tank) {
            (Some([x, y]), _) => (x, y),
            (None, Some((middle, _))) => middle,
            (None, None) => {
                let what = text::FireAtOrOn.words();
                return Err(table.wrong("at", what));
            }
        };
        let kind = table.choice("kind", &KINDS)?.unwrap_or(KINDS[0].1);
        let lit_ms = match table.text("lit")? {
            None => Some(0),
            Some("never") => None,
            Some(_) => table.time("lit")?,
        };
        let spec = FireSpec {
            size_m: table.needed("size", 0.2, 60.0)?,
            growth_mps: table.number("growth", 0.0, 1.0)?.unwrap_or(kind.growth_mps),
            reignites: table.truth("reignites")?.unwrap_or(kind.reignites),
            kw_m2: table.number("heat", 50.0, 5000.0)?.unwrap_or(kind.kw_m2),
            base_m: table
                .number("base", 0.0, 60.0)?
                .unwrap_or(on_tank.map_or(0.0, |(_, top_m)| top_m)),
            lit: lit_ms == Some(0),
            class: table.choice("class", &Class::ALL)?.unwrap_or(kind.class),
            foam,
            ..kind
        };
        effect::before_end(&table, "lit", lit_ms.unwrap_or(0), self.duration_ms)?;
        self.fires.push(FirePlan { name, lit_ms });
        self.site.fires.push(SiteFire { at, spec, on });
        table.finish()
    }

    /// What the foam of the site is like.
    fn read_foam(&self, root: &Table<'_>) -> Result<Foam, Problem> {
        let Some(table) = root.table_of("foam")? else { return Ok(Foam::default()) };
        let plain = Foam::default();
        let foam = Foam {
            expansion: table.number("expansion", 2.0, 20.0)?.unwrap_or(plain.expansion),
            quarter_s: table.time("drains")?.map_or(plain.quarter_s, |ms| ms as f64 / 1000.0),
        };
        if !(10.0..=3600.0).contains(&foam.quarter_s) {
            return Err(table.wrong("drains", text::DrainsBetween.words()));
        }
        table.finish()?;
        let has_foam = |it: &MonitorConfig| it.sim.composition.chain.contains(SubsystemId::VALVE2);
        if !self.site.monitors.iter().any(has_foam) {
            return Err(root.wrong("foam", effect::without("Valve2")));
        }
        Ok(foam)
    }
}

/// The kinds of fire, the first where a file names none. A pile keeps embers; a pool of light fuel
/// needs foam; a spray of heavy oil is fed, burns hotter and flares up again. Figures ours.
const KINDS: [(&str, FireSpec); 3] = [
    ("pile", FireSpec { growth_mps: 0.005, reignites: true, ..PLAIN }),
    ("pool", FireSpec { kw_m2: 1000.0, class: Class::Hydrocarbon, ..PLAIN }),
    ("spray", FireSpec { kw_m2: 1500.0, critical: 0.12, reignites: true, ..PLAIN }),
];
/// A fire of a kind.
pub fn kind_of_fire(kind: &str) -> Option<FireSpec> {
    KINDS.iter().find(|(name, _)| *name == kind).map(|(_, spec)| *spec)
}

const PLAIN: FireSpec = FireSpec {
    azimuth_deg: 0.0,
    range_m: 0.0,
    size_m: 1.0,
    growth_mps: 0.0,
    reignites: false,
    lit: true,
    base_m: 0.0,
    kw_m2: 500.0,
    critical: crate::fire::CRITICAL_DENSITY,
    class: Class::Solid,
    foam: Foam::FILM,
};

/// A name that no other has, without blanks: conditions use it.
pub fn fresh_name(table: &Table<'_>, others: &[String]) -> Result<String, Problem> {
    let name = table.needed_text("name")?;
    if name.is_empty() || name.contains(char::is_whitespace) {
        let what = text::NameWithoutBlanks.words();
        return Err(table.wrong("name", what));
    }
    if others.iter().any(|other| other == name) {
        let what = text::NameExists { name }.words();
        return Err(table.wrong("name", what));
    }
    Ok(name.to_owned())
}

/// The memory of a monitor that was commissioned for its place: height, nozzle, and what the file
/// sets, all by real requests.
fn commissioned(config: &Config, set: &[&str]) -> Result<Flash, Words> {
    let mut sim = Sim::new(config.clone());
    sim.advance_ms(1_000);
    let height_cm = libm::round(config.height_m * 100.0);
    let nozzle_dmm = libm::round(config.nozzle_mm * 10.0);
    let own =
        [format!("Control Height {height_cm}"), format!("Control NozzleDiameter {nozzle_dmm}")];
    let set = set.iter().flat_map(|lines| lines.split(';')).map(str::trim);
    for line in own.iter().map(String::as_str).chain(set) {
        set_param(&mut sim, line)?;
    }
    sim.advance_ms(1_000);
    Ok(sim.world().flash.clone())
}

fn set_param(sim: &mut Sim, line: &str) -> Result<(), Words> {
    let payload = payload(&format!("SetParam {line}"))?;
    let mut status = None;
    // A remote unit answers Cached until it has been asked.
    for _ in 0..20 {
        let answers = sim.request(Interface::ExternalConn, &payload);
        let first = Records::new(&answers).flatten().next();
        status = first.and_then(|record| Answer::decode(&record).ok()).map(|answer| answer.status);
        sim.advance_ms(300);
        match status {
            Some(status) if status.is_success() => return Ok(()),
            Some(Status::CACHED | Status::BUSY) => {}
            _ => break,
        }
    }
    let status = status.map_or_else(|| "-".to_owned(), |status| status.to_string());
    Err(text::SetRefused { line, status }.words())
}

/// The records of requests written as text, with `;` between them.
pub fn payload(requests: &str) -> Result<Vec<u8>, Words> {
    let mut bytes = Vec::new();
    for request in requests.split(';') {
        let (mut buffer, mut record) = ([0; wire::BUFFER_SIZE], [0; 260]);
        let wrong = |error: Words| text::NoRequest { request, error }.words();
        let trimmed = request.trim();
        let not_read = |error| wrong(Words::each(|lang| parse_error_text(trimmed, &error, lang)));
        let parsed = wire::parse(trimmed, &mut buffer).map_err(not_read)?;
        let mut writer = Writer::new(&mut record);
        parsed.encode(&mut writer).map_err(|error| wrong(Shown(error).words()))?;
        bytes.extend_from_slice(writer.written());
    }
    Ok(bytes)
}
