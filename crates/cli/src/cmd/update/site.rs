//! The monitors of a hub's configuration, and what each lacks to be updated.
//!
//! A line is open for as long as it is used: Stop for another monitor of a serial line may need its port.

use std::fs::File;
use std::time::Duration;

use lafet_client::update::{Image, Note, Unready, UpdateError, choose};
use lafet_client::{Endpoint, Monitor, MonitorStatus};
use lafet_hub::Config;
use lafet_proto::flags::{ControlFlags, DetectorFlags, GeneralFlags};
use lafet_proto::update::Report;
use lafet_texts::{Text as _, cli as text};

use super::{dotted, failed, wordless};
use crate::cli::Global;
use crate::connect::{Connection, giving_way, line_of};
use crate::failure::Failure;
use crate::lang::current;
use crate::state;

/// A monitor of the configuration.
pub struct Station {
    /// Its id.
    pub id: String,
    /// Where it is.
    pub endpoint: Endpoint,
    /// The note of its word.
    pub note: Note,
    /// It is to be updated; another one serves a zone of one that is.
    chosen: bool,
}

/// What a monitor lacks to be updated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lack {
    /// In words, with what to do.
    pub text: String,
    /// An answer, and nothing else that is known.
    pub silent: bool,
}

impl Lack {
    const fn of(text: String) -> Self {
        Self { text, silent: false }
    }

    const fn silence(text: String) -> Self {
        Self { text, silent: true }
    }
}

/// A monitor that may be updated as far as it says of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ready {
    /// What it runs.
    pub version: [u16; 4],
    /// It is locked out.
    pub locked_out: bool,
    /// It runs the version of the images already, confirmed.
    pub same: bool,
}

/// What a monitor is, or all that it lacks.
pub type Looked = Result<Ready, Vec<Lack>>;

/// The status of a monitor, or why there is none.
type Status = Result<MonitorStatus, String>;

/// Those that are to be updated and those that serve a zone with one of them, in the order of the file.
pub struct Site {
    stations: Vec<Station>,
    /// Zones, each with the monitors that serve it.
    zones: Vec<(String, Vec<String>)>,
}

impl Site {
    /// The monitors with these ids, or all of them.
    pub fn of(config: &Config, only: &[String]) -> Result<Self, Failure> {
        let ids: Vec<&str> = config.monitors.iter().map(|it| it.id.as_str()).collect();
        if let Some(id) = only.iter().find(|id| !ids.contains(&id.as_str())) {
            let known = ids.join(", ");
            return Err(Failure::Usage(text::UpdateSiteUnknown { id, known }.of(current())));
        }
        let folder = state::notes("update")?;
        let chosen = |id: &String| only.is_empty() || only.contains(id);
        let zones = config.zones.iter().flat_map(|it| &it.site.zones);
        let zones: Vec<(String, Vec<String>)> =
            zones.map(|it| (it.id.clone(), it.monitors.clone())).collect();
        let serves =
            |id: &String| zones.iter().any(|(_, all)| all.contains(id) && all.iter().any(chosen));
        let of_interest = config.monitors.iter().filter(|it| chosen(&it.id) || serves(&it.id));
        let stations = of_interest
            .map(|it| Station {
                id: it.id.clone(),
                endpoint: it.endpoint.clone(),
                note: Note::new(&folder, &state::monitor(&it.endpoint)),
                chosen: chosen(&it.id),
            })
            .collect();
        Ok(Self { stations, zones })
    }

    /// Those that are to be updated.
    pub fn chosen(&self) -> impl Iterator<Item = &Station> {
        self.stations.iter().filter(|it| it.chosen)
    }

    /// Takes each that is to be updated for this command, as long as the files are open.
    pub fn occupy(&self) -> Result<Vec<File>, Failure> {
        let taken = text::UpdateRunsAlready.str(current());
        let occupy = |it: &Station| {
            let lock = it.note.file().with_extension("lock");
            state::occupy(&lock, taken).map_err(|failure| of_monitor(&it.id, failure))
        };
        self.chosen().map(occupy).collect()
    }

    /// Looks at all: what each that is to be updated is, or all that it and its zones lack. Each line is opened once.
    pub async fn survey(&self, images: &[Image], global: &Global) -> Vec<(&Station, Looked)> {
        let mut seen: Vec<(&Station, Status, Looked)> = Vec::new();
        for station in &self.stations {
            if seen.iter().any(|(known, ..)| known.id == station.id) {
                continue;
            }
            let line = line_of(&station.endpoint);
            let on_it = |it: &&Station| {
                it.id == station.id || (line.is_some() && line_of(&it.endpoint) == line)
            };
            let on_it: Vec<&Station> = self.stations.iter().filter(on_it).collect();
            let look = async |line: &Connection| {
                let mut seen = Vec::new();
                for one in &on_it {
                    let status = one.status(line).await;
                    let looked = one.judged(&status, line, images).await;
                    seen.push((*one, status, looked));
                }
                seen
            };
            match station.visit(global, look).await {
                Ok(looked) => seen.extend(looked),
                Err(why) => seen.extend(
                    on_it
                        .iter()
                        .map(|one| (*one, Err(why.clone()), Err(vec![Lack::silence(why.clone())]))),
                ),
            }
        }
        let beside = |one: &Station| {
            let others = self.beside(one).into_iter().filter_map(|(zone, other)| {
                let (_, status, _) = seen.iter().find(|(known, ..)| known.id == other.id)?;
                lack_beside(zone, &other.id, status)
            });
            others.collect::<Vec<Lack>>()
        };
        let own = |one: &Station| seen.iter().find(|(known, ..)| known.id == one.id);
        let all = self.chosen().filter_map(|one| {
            let (_, _, looked) = own(one)?;
            Some((one, with(looked.clone(), beside(one))))
        });
        all.collect()
    }

    /// What the others lack that serve a zone with this one: each has to answer and not be locked out. `line` is that
    /// of this one.
    pub async fn lacks_beside(
        &self,
        one: &Station,
        line: &Connection,
        global: &Global,
    ) -> Vec<Lack> {
        let own = line_of(&one.endpoint);
        let mut lacks = Vec::new();
        for (zone, other) in self.beside(one) {
            let status = match own.is_some() && line_of(&other.endpoint) == own {
                true => other.status(line).await,
                false => {
                    let look = async |line: &Connection| other.status(line).await;
                    other.visit(global, look).await.and_then(|it| it)
                }
            };
            lacks.extend(lack_beside(zone, &other.id, &status));
        }
        lacks
    }

    /// What one is, or all that it and its zones lack.
    pub async fn look(
        &self,
        one: &Station,
        line: &Connection,
        images: &[Image],
        global: &Global,
    ) -> Looked {
        let own = one.look(line, images).await;
        if own.as_ref().is_ok_and(|ready| ready.same) {
            return own;
        }
        with(own, self.lacks_beside(one, line, global).await)
    }

    /// The others of its zones, each once.
    fn beside<'a>(&'a self, one: &Station) -> Vec<(&'a str, &'a Station)> {
        let mut all: Vec<(&str, &Station)> = Vec::new();
        for (zone, ids) in self.zones.iter().filter(|(_, ids)| ids.contains(&one.id)) {
            let others = self.stations.iter().filter(|it| it.id != one.id && ids.contains(&it.id));
            for other in others {
                if all.iter().all(|(_, known)| known.id != other.id) {
                    all.push((zone, other));
                }
            }
        }
        all
    }
}

/// With what its zones lack; nothing is asked of a monitor that is left as it is.
fn with(own: Looked, beside: Vec<Lack>) -> Looked {
    match own {
        Ok(ready) if ready.same || beside.is_empty() => Ok(ready),
        Ok(_) => Err(beside),
        Err(lacks) => Err(lacks.into_iter().chain(beside).collect()),
    }
}

impl Station {
    /// Opens its line.
    pub async fn open(&self, global: &Global) -> Result<Connection, Failure> {
        let connect = Some(self.endpoint.to_string());
        Connection::new(&Global { connect, open: None, ..global.clone() }).await
    }

    /// Opens its line for a look, which gives way to what is urgent.
    pub async fn visit<T>(
        &self,
        global: &Global,
        look: impl AsyncFn(&Connection) -> T,
    ) -> Result<T, String> {
        let (url, wait) = (self.endpoint.to_string(), Duration::from_secs_f64(global.timeout));
        let look = || async { Ok::<T, Failure>(look(&self.open(global).await?).await) };
        let looked = giving_way(&url, &self.endpoint, wait, look).await;
        looked.and_then(|it| it).map_err(|failure| failure.message())
    }

    /// Its own connection on a line that is open.
    pub fn on(&self, line: &Connection) -> Result<Connection, String> {
        let client = line.client.at(self.endpoint.addresses().monitor);
        let client = client.map_err(|error| error.localized(current()))?;
        Ok(Connection { monitor: Monitor::new(client.clone()), client })
    }

    /// Its status.
    pub async fn status(&self, line: &Connection) -> Status {
        let status = self.on(line)?.monitor.status_all().await;
        status.map_err(|error| error.localized(current()))
    }

    /// How its software is.
    pub async fn software(&self, line: &Connection) -> Result<Report, Lack> {
        let connection = self.on(line).map_err(Lack::silence)?;
        connection.monitor.software().await.map_err(|error| {
            let failure = failed(UpdateError::from(error));
            Lack { text: failure.message(), silent: failure.exit_code() == 3 }
        })
    }

    /// What it is, or what it lacks by itself.
    pub async fn look(&self, line: &Connection, images: &[Image]) -> Looked {
        let status = self.status(line).await;
        self.judged(&status, line, images).await
    }

    async fn judged(&self, status: &Status, line: &Connection, images: &[Image]) -> Looked {
        let status = status.as_ref().map_err(|why| vec![Lack::silence(why.clone())])?;
        let report = self.software(line).await.map_err(|lack| vec![lack])?;
        let nothing_confirms = choose(&report, images, &self.note.read()).err();
        let nothing_confirms = nothing_confirms.map(|why| wordless(why, &self.note));
        judge(status, &report, images, nothing_confirms)
            .map_err(|lacks| lacks.into_iter().map(Lack::of).collect())
    }
}

/// A failure of one of several monitors.
pub fn of_monitor(id: &str, failure: Failure) -> Failure {
    let text = format!("{id}: {}", failure.message());
    match failure.exit_code() {
        1 => Failure::Ended(text),
        2 => Failure::Usage(text),
        3 => Failure::Silent(text),
        _ => failure,
    }
}

/// Whether it is locked out; `None` if General does not say it.
pub fn is_locked_out(status: &MonitorStatus) -> Option<bool> {
    status.general.map(|general| general.flags.contains(GeneralFlags::LOCKED_OUT))
}

/// Judges a monitor by its status and its report: what it is, or all that it lacks. `nothing_confirms`: why what it
/// has committed or on trial is not confirmed from here.
fn judge(
    status: &MonitorStatus,
    report: &Report,
    images: &[Image],
    nothing_confirms: Option<String>,
) -> Result<Ready, Vec<String>> {
    let version = report.version;
    let same = !report.trial && images.iter().any(|image| image.version() == version);
    let Some(locked_out) = is_locked_out(status) else {
        return Err(vec![text::UpdateSiteNoGeneral.str(current()).into()]);
    };
    let ready = Ready { version, locked_out, same };
    if same {
        return Ok(ready);
    }
    let unready = Unready::seen(status).into_iter().filter(|it| *it != Unready::NotLockedOut);
    let mut lacks: Vec<String> = unready.map(|it| it.of(current())).collect();
    let program = ControlFlags::QUENCH | ControlFlags::TRAJECTORY;
    if status.control.is_some_and(|it| it.flags.intersects(program)) {
        lacks.push(text::UpdateSiteProgram.str(current()).into());
    }
    let search = DetectorFlags::SEARCHING | DetectorFlags::JUSTIFYING;
    if status.detector.is_some_and(|it| it.flags.intersects(search)) {
        lacks.push(text::UpdateSiteSearch.str(current()).into());
    }
    let slot = if report.slot == 1 { 2 } else { 1 };
    if !report.trial && !images.iter().any(|it| it.slot().is_none_or(|own| own == slot)) {
        lacks.push(UpdateError::NoImage { slot }.localized(current()));
    }
    if images.iter().all(|image| image.version() < version) {
        lacks.push(text::UpdateSiteNewer { version: dotted(version) }.of(current()));
    }
    lacks.extend(nothing_confirms);
    if lacks.is_empty() { Ok(ready) } else { Err(lacks) }
}

/// What another monitor of a zone lacks, so that this one may be out of service.
fn lack_beside(zone: &str, id: &str, status: &Status) -> Option<Lack> {
    let general = text::UpdateSiteNoGeneral.str(current());
    let known = status.as_ref().map_err(String::as_str);
    match known.and_then(|status| is_locked_out(status).ok_or(general)) {
        Ok(false) => None,
        Ok(true) => Some(Lack::of(text::UpdateSiteBesideLocked { zone, id }.of(current()))),
        Err(error) => {
            Some(Lack::silence(text::UpdateSiteBesideSilent { zone, id, error }.of(current())))
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use lafet_hub::Overrides;
    use lafet_proto::status::{ControlStatus, DetectorStatus, GeneralStatus};
    use lafet_update::{BoardName, Hash, Header, Layouts, SigningKey, Slot, Version};

    use super::*;

    fn image(version: [u16; 4], place: Option<Slot>) -> Image {
        let header = Header {
            size: 0,
            version: Version(version),
            board: BoardName::new("bench").unwrap(),
            place,
            key: 0,
            revokes: 0,
            layouts: Layouts { oldest: 1, newest: 1 },
            hash: Hash::default(),
        };
        let payload = [7; 16];
        let signed = SigningKey::new(0, [5; 32]).sign(&header, &payload).unwrap();
        Image::read(&[&signed[..], &payload].concat()).unwrap()
    }

    fn status(flags: GeneralFlags) -> MonitorStatus {
        let mut status = MonitorStatus::default();
        status.general = Some(GeneralStatus { flags, main_voltage: 240, pressure: 0, flowrate: 0 });
        status
    }

    fn report(version: [u16; 4]) -> Report {
        Report { slot: 1, version, ..Report::default() }
    }

    const OLD: [u16; 4] = [1, 0, 0, 0];
    const NEW: [u16; 4] = [1, 1, 0, 0];

    /// Each of these alone is named.
    #[test]
    fn what_a_monitor_lacks() {
        let either = [image(NEW, None)];
        let free = status(GeneralFlags::empty());
        let good = judge(&free, &report(OLD), &either, None).unwrap();
        assert_eq!(good, Ready { version: OLD, locked_out: false, same: false });
        let locked = judge(&status(GeneralFlags::LOCKED_OUT), &report(OLD), &either, None);
        assert!(locked.unwrap().locked_out);
        let lacks = |status: &MonitorStatus, images: &[Image], running| {
            let lacks = judge(status, &report(running), images, None).unwrap_err();
            assert_eq!(lacks.len(), 1, "{lacks:?}");
            lacks[0].clone()
        };
        let mut program = free.clone();
        program.control = Some(ControlStatus { flags: ControlFlags::TRAJECTORY });
        assert!(lacks(&program, &either, OLD).contains("lafet stop control"));
        let mut search = free.clone();
        search.detector = Some(DetectorStatus { flags: DetectorFlags::JUSTIFYING });
        assert!(lacks(&search, &either, OLD).contains("lafet stop detector"));
        assert!(lacks(&status(GeneralFlags::BAD_POWER), &either, OLD).contains("BadPower"));
        assert!(lacks(&MonitorStatus::default(), &either, OLD).contains("General"));
        assert!(lacks(&free, &either, [1, 2, 0, 0]).contains("newer"));
        assert!(lacks(&free, &[image(NEW, Some(Slot::A))], OLD).contains("slot B"));
        let nothing_confirms = Some("no word".to_owned());
        let wordless = judge(&free, &report(OLD), &either, nothing_confirms.clone());
        assert_eq!(wordless.unwrap_err(), ["no word"]);
        // What it runs already needs nothing; on trial, it does.
        let same = judge(&program, &report(NEW), &either, nothing_confirms).unwrap();
        assert!(same.same);
        let trial = Report { trial: true, ..report(NEW) };
        assert!(!judge(&free, &trial, &either, None).unwrap().same);
        assert!(judge(&program, &trial, &either, None).is_err());
    }

    #[test]
    fn what_another_one_of_a_zone_lacks() {
        let lack = |status: Result<MonitorStatus, String>| lack_beside("hall", "M2", &status);
        assert_eq!(lack(Ok(status(GeneralFlags::BAD_POWER))), None);
        let locked = lack(Ok(status(GeneralFlags::LOCKED_OUT))).unwrap();
        assert!(locked.text.contains("hall") && !locked.silent, "{locked:?}");
        for silent in [Err("No answer.".to_owned()), Ok(MonitorStatus::default())] {
            let silent = lack(silent).unwrap();
            assert!(silent.text.contains("M2") && silent.silent, "{silent:?}");
        }
    }

    /// The others of all its zones, each once, chosen or not; no others.
    #[test]
    fn who_serves_the_same_zones() {
        let mut text = String::new();
        for number in 1..=5 {
            text += &format!("[[monitor]]\nid = \"M{number}\"\nurl = \"tcp://h?addr={number}\"\n");
        }
        for (zone, monitors) in [("a", [1, 2, 3]), ("b", [3, 4, 1])] {
            for monitor in monitors {
                text += &format!(
                    "[[aim]]\nzone = \"{zone}\"\nmonitor = \"M{monitor}\"\nhorizontal = 0\n\
                     vertical = 0\nnozzle = 60\n"
                );
            }
            let ids = monitors.map(|monitor| format!("\"M{monitor}\"")).join(", ");
            text += &format!(
                "[[zone]]\nid = \"{zone}\"\nvotes = \"2oo2\"\nwater_max_s = 60\nmonitors = [{ids}]\n"
            );
        }
        for kind in ["flame", "heat"] {
            text += &format!(
                "[[detector]]\nid = \"{kind}\"\nkind = \"{kind}\"\nzones = [\"a\", \"b\"]\n\
                 silent_after_s = 60\n"
            );
        }
        let config = Config::parse("f", &text, Path::new("/"), &Overrides::default()).unwrap();
        let site = |only: &[&str]| {
            let only: Vec<String> = only.iter().map(|id| (*id).to_owned()).collect();
            Site::of(&config, &only)
        };
        let ids = |stations: Vec<&Station>| {
            stations.into_iter().map(|it| it.id.clone()).collect::<Vec<_>>().join(" ")
        };
        for (only, chosen, all) in [
            (&[][..], "M1 M2 M3 M4 M5", "M1 M2 M3 M4 M5"),
            (&["M5"], "M5", "M5"),
            (&["M2"], "M2", "M1 M2 M3"),
            (&["M4", "M2"], "M2 M4", "M1 M2 M3 M4"),
        ] {
            let site = site(only).unwrap();
            assert_eq!(ids(site.chosen().collect()), chosen, "{only:?}");
            assert_eq!(ids(site.stations.iter().collect()), all, "{only:?}");
        }
        let site_of_all = site(&[]).unwrap();
        for (one, others) in
            [("M1", "M2 M3 M4"), ("M2", "M1 M3"), ("M3", "M1 M2 M4"), ("M4", "M1 M3"), ("M5", "")]
        {
            let one = site_of_all.stations.iter().find(|it| it.id == one).unwrap();
            let beside = site_of_all.beside(one).into_iter().map(|(_, it)| it).collect();
            assert_eq!(ids(beside), others, "{}", one.id);
        }
        assert!(matches!(site(&["M9"]), Err(Failure::Usage(text)) if text.contains("M1, M2")));
    }
}
