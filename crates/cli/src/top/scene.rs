//! The data shown by the dashboard.

use std::time::Duration;

use lafet_client::{AnswerBuf, LinkStatistics, Stats};
use lafet_proto::answer::Reply;
use lafet_proto::flags::{
    ConnFlags, ControlFlags, DeployerFlags, DetectorFlags, DriveFlags, GeneralFlags, Severity,
    flags_of,
};
use lafet_proto::status::{Hotbed, Limits};
use lafet_proto::{Answer, SubsystemId, dictionary};
use lafet_texts::cli as text;

use crate::describe::flag_line;
use crate::lang::current;

/// Everything on the screen.
#[derive(Debug, Default)]
pub struct Scene {
    /// The monitors, in the order of the command line.
    pub monitors: Vec<Seen>,
    /// Index of the selected monitor, to which Stop goes.
    pub selected: usize,
    /// Page shown.
    pub page: Page,
    /// Lines scrolled past the top.
    pub scroll: u16,
    /// Whether the keys are explained.
    pub help: bool,
    /// Outcome of the last key press.
    pub notice: Option<String>,
}

/// A page of the dashboard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Page {
    /// All monitors.
    #[default]
    List,
    /// The selected monitor.
    Detail,
    /// Its link.
    Link,
}

/// State of the connection.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Connected {
    /// Not connected yet.
    #[default]
    Soon,
    /// Connected.
    Up,
    /// Not connected; the text says why.
    Down(String),
}

/// Known state of a monitor.
#[derive(Debug, Default)]
pub struct Seen {
    /// Short name: `10.0.0.5:10485/1`.
    pub name: String,
    /// URL of the monitor.
    pub url: String,
    /// State of the connection.
    pub connected: Connected,
    /// The latest state, one answer per subsystem.
    pub answers: Vec<AnswerBuf>,
    /// Age of the state.
    pub age: Duration,
    /// Whether later polls have failed.
    pub stale: bool,
    /// Why they failed.
    pub error: Option<String>,
    /// Limits of the drives.
    pub limits: Vec<(SubsystemId, Limits)>,
    /// Fire spots found by the last search.
    pub hotbeds: Vec<Hotbed>,
    /// Statistics of the link.
    pub figures: Option<LinkStatistics>,
    /// Statistics of the exchange with this monitor alone.
    pub own: Stats,
    /// Round trips of the last seconds, µs; 0 where none was measured.
    pub round_trips: Vec<u64>,
}

/// Flags that do not count as problems: the end switch at which a deployed or stowed barrel rests
/// (§3.3.8), and an interface over which no client currently controls (§3.3.9).
fn usual(who: SubsystemId, bits: u32) -> u32 {
    let flags = DeployerFlags::from_bits_retain(bits);
    match who {
        SubsystemId::DEPLOYER if flags.contains(DeployerFlags::DEPLOYED) => {
            DeployerFlags::ABSOLUTE_MAX_LIMIT_REACHED.bits()
        }
        SubsystemId::DEPLOYER if flags.contains(DeployerFlags::WRAPPED) => {
            DeployerFlags::ABSOLUTE_MIN_LIMIT_REACHED.bits()
        }
        SubsystemId::EXTERNAL_CONN | SubsystemId::RADIO => ConnFlags::CONN_LOST.bits(),
        _ => 0,
    }
}

impl Scene {
    /// The selected monitor.
    pub fn current(&self) -> Option<&Seen> {
        self.monitors.get(self.selected)
    }
}

impl Seen {
    /// The state of a subsystem, if it reported one.
    pub fn of(&self, who: SubsystemId) -> Option<Answer<'_>> {
        let answer = self.answers.iter().find(|answer| answer.from() == who)?;
        if answer.status().is_success() { answer.decode().ok() } else { None }
    }

    /// The status word of a subsystem; 0 if it does not exist.
    pub fn flags(&self, who: SubsystemId) -> u32 {
        self.of(who).and_then(|answer| answer.data.flags_bits()).unwrap_or(0)
    }

    /// Whether a flag marks a value as invalid.
    pub fn is_bad(&self, who: SubsystemId, field: &str) -> bool {
        dictionary::invalid(who, self.flags(who)).any(|(bad, _)| bad == field)
    }

    /// Position, current and speed of a drive, as on the wire.
    pub fn drive(&self, who: SubsystemId) -> Option<(i32, u8, u8)> {
        match self.of(who)?.data {
            Reply::Drive(s) => Some((s.position.into(), s.current, s.speed)),
            Reply::Deployer(s) => Some((s.position.into(), s.current, s.speed)),
            _ => None,
        }
    }

    /// Whether any of its state is known.
    pub fn is_known(&self) -> bool {
        !self.answers.is_empty()
    }

    /// What the monitor does, in one word.
    pub fn condition(&self) -> &'static str {
        if !self.is_known() {
            return match (&self.connected, &self.error) {
                (Connected::Down(_), _) => text::SceneNoLink.str(current()),
                (_, Some(_)) => text::SceneNoAnswer.str(current()),
                _ => text::LinkConnecting.str(current()),
            };
        }
        let deployer = DeployerFlags::from_bits_retain(self.flags(SubsystemId::DEPLOYER));
        let detector = DetectorFlags::from_bits_retain(self.flags(SubsystemId::DETECTOR));
        let control = ControlFlags::from_bits_retain(self.flags(SubsystemId::CONTROL));
        let general = GeneralFlags::from_bits_retain(self.flags(SubsystemId::GENERAL));
        let moves = [SubsystemId::HORIZONTAL, SubsystemId::VERTICAL, SubsystemId::NOZZLE]
            .iter()
            .any(|who| self.flags(*who) & DriveFlags::MOVE.bits() != 0);
        match () {
            () if general.contains(GeneralFlags::LOCKED_OUT) => text::SceneLockedOut.str(current()),
            () if deployer.contains(DeployerFlags::DEPLOYING) => {
                text::SceneDeploying.str(current())
            }
            () if deployer.contains(DeployerFlags::WRAPPING) => text::DemoStowing.str(current()),
            () if control.contains(ControlFlags::PAUSED) => text::ScenePaused.str(current()),
            () if control.contains(ControlFlags::QUENCH) => text::DemoQuench.str(current()),
            () if control.contains(ControlFlags::TRAJECTORY) => text::TheTrajectory.str(current()),
            () if detector.contains(DetectorFlags::SEARCHING) => text::SceneSeek.str(current()),
            () if detector.contains(DetectorFlags::JUSTIFYING) => {
                text::SceneAligning.str(current())
            }
            () if moves => text::SceneMoving.str(current()),
            () if deployer.contains(DeployerFlags::WRAPPED) => text::SceneStowed.str(current()),
            () if deployer.contains(DeployerFlags::DEPLOYED) => text::SceneDeployed.str(current()),
            () if self.of(SubsystemId::DEPLOYER).is_some() => text::SceneInBetween.str(current()),
            () => text::SceneReady.str(current()),
        }
    }

    /// Severity of the worst flag.
    pub fn severity(&self) -> Severity {
        let of = |answer: &AnswerBuf| match answer.decode() {
            _ if !answer.status().is_success() => Severity::Warning,
            Ok(decoded) => {
                let bits = decoded.data.flags_bits().unwrap_or(0);
                flags_of(answer.from()).severity(bits & !usual(answer.from(), bits))
            }
            Err(_) => Severity::Warning,
        };
        let unknown = if self.is_known() { Severity::Info } else { Severity::Alarm };
        self.answers.iter().map(of).max().unwrap_or(unknown)
    }

    /// Flags by name, the worst first: `Detector Found`.
    pub fn flag_names(&self) -> Vec<(Severity, String)> {
        self.each_flag(Severity::Info, |who, flag| format!("{who} {flag}"))
    }

    /// Problems as text, the worst first, with what to do.
    pub fn faults(&self) -> Vec<(Severity, String)> {
        self.each_flag(Severity::Notice, |who, flag| format!("{who} {}", flag_line(flag)))
    }

    fn each_flag(
        &self,
        least: Severity,
        tell: impl Fn(SubsystemId, lafet_proto::flags::SetFlag) -> String,
    ) -> Vec<(Severity, String)> {
        let mut all = Vec::new();
        for answer in &self.answers {
            let who = answer.from();
            let Ok(decoded) = answer.decode() else { continue };
            if !answer.status().is_success() {
                all.push((Severity::Warning, format!("{who} → {}", answer.status())));
                continue;
            }
            let bits = decoded.data.flags_bits().unwrap_or(0);
            // The list of all flags omits nothing; the list of faults omits the usual ones.
            let usual = if least == Severity::Info { 0 } else { usual(who, bits) };
            let set = flags_of(who).set(bits & !usual);
            let set = set.filter(|flag| flag.severity() >= least);
            all.extend(set.map(|flag| (flag.severity(), tell(who, flag))));
        }
        all.sort_by_key(|(severity, _)| std::cmp::Reverse(*severity));
        all
    }
}
