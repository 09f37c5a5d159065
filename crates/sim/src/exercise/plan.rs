//! What a scenario file says, understood.

use lafet_device::Source;
use lafet_proto::flags::Button;
use lafet_texts::Words;

use super::condition::SiteCondition;
use crate::fault::{Fault, Post};
use crate::site::{Site, SiteConfig, WindSpec};

/// A scenario: a site, what happens on it, what the operator does, what is expected.
#[derive(Clone, Debug)]
pub struct Exercise {
    /// The file, as problems name it.
    pub file: String,
    /// What it is called.
    pub title: Words,
    /// What it is about.
    pub about: Words,
    /// How long it takes, ms.
    pub duration_ms: u64,
    /// The site.
    pub site: SiteConfig,
    /// Part of the site that pictures show: x, y of two corners, m; without it everything.
    pub view: Option<[f64; 4]>,
    /// Under a roof: there is no wind to show.
    pub indoors: bool,
    /// The monitors, in the order of the site's.
    pub monitors: Vec<MonitorPlan>,
    /// The fires, in the order of the site's.
    pub fires: Vec<FirePlan>,
    /// Names of walls and tanks, in the order of the site's obstacles.
    pub obstacles: Vec<String>,
    /// Names of what shines without burning, in the order of the site's.
    pub glares: Vec<String>,
    /// Names of the supplies, in the order of the site's.
    pub supplies: Vec<String>,
    /// Where clients connect to all monitors at once, by their addresses.
    pub bus: Vec<String>,
    /// What happens to the site.
    pub events: Vec<EventPlan>,
    /// What the operator does.
    pub operator: Vec<OperatorLine>,
    /// Automatic controllers.
    pub controllers: Vec<ControllerPlan>,
    /// What is expected.
    pub expectations: Vec<Expectation>,
    /// Names of events, lines and controllers that others refer to.
    pub marks: Vec<String>,
}

impl Exercise {
    /// Builds the site. Everything random follows from the seed.
    pub fn build(&self, seed: u64) -> Site {
        Site::new(SiteConfig { seed, ..self.site.clone() })
    }
}

/// A monitor.
#[derive(Clone, Debug)]
pub struct MonitorPlan {
    /// Its name.
    pub name: String,
    /// Where clients connect to it alone.
    pub listen: Vec<String>,
}

/// A fire.
#[derive(Clone, Debug)]
pub struct FirePlan {
    /// Its name.
    pub name: String,
    /// When it is lit, ms; `None` is left to other fires.
    pub lit_ms: Option<u64>,
}

/// When something happens: as soon as all that is given is so, and the delay is over.
#[derive(Clone, Debug, Default)]
pub struct Trigger {
    /// Not before this time, ms.
    pub at_ms: Option<u64>,
    /// When this holds.
    pub when: Option<SiteCondition>,
    /// After this mark.
    pub after: Option<usize>,
    /// And then after this time, ms.
    pub delay_ms: u64,
}

/// Something that happens to the site.
#[derive(Clone, Debug)]
pub struct EventPlan {
    /// Line of the file.
    pub line: usize,
    /// Its mark.
    pub mark: Option<usize>,
    /// When.
    pub trigger: Trigger,
    /// What the report says of it.
    pub text: Option<Words>,
    /// What happens.
    pub actions: Vec<Action>,
}

/// What can happen to a site.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// A fault of a monitor's plant begins.
    Inject(usize, Fault),
    /// It ends; `None` ends all of the monitor's.
    Clear(usize, Option<Fault>),
    /// The wind changes.
    Wind(WindSpec),
    /// The air gets this warm, °C.
    Temperature(f64),
    /// A fire is lit.
    Ignite(usize),
    /// A link of a monitor changes.
    Link(usize, Source, Link),
    /// The power of a monitor is cut, or comes back.
    Power(usize, bool),
    /// A button is pressed or released.
    Press(usize, Post, Button, bool),
    /// The pump of a supply gives this share of its pressure.
    Supply(usize, f64),
}

/// The state of a link, as a client meets it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Link {
    /// Requests and answers get through.
    #[default]
    Up,
    /// Nothing gets through.
    Lost,
    /// Requests reach the monitor, its answers are lost.
    AnswersLost,
}

/// A line of the operator's part. The lines of a monitor are carried out one after the other.
#[derive(Clone, Debug)]
pub struct OperatorLine {
    /// Line of the file.
    pub line: usize,
    /// Its mark.
    pub mark: Option<usize>,
    /// To whom.
    pub monitor: usize,
    /// When, at the earliest after the line before.
    pub trigger: Trigger,
    /// Over which interface.
    pub over: Source,
    /// The request as text.
    pub request: String,
    /// Its records.
    pub payload: Vec<u8>,
    /// What has to be answered.
    pub answer: Option<String>,
    /// It is repeated after this time, ms, until it is answered.
    pub repeat_ms: Option<u64>,
}

/// A controller that seeks and extinguishes by itself.
#[derive(Clone, Debug)]
pub struct ControllerPlan {
    /// Line of the file.
    pub line: usize,
    /// Its mark: it has started.
    pub mark: Option<usize>,
    /// Its monitor.
    pub monitor: usize,
    /// When it begins.
    pub trigger: Trigger,
    /// Over which interface.
    pub over: Source,
    /// What it searches: azimuth and elevation, from and to, degrees.
    pub sector: [f64; 4],
    /// How long it extinguishes before it looks again, ms.
    pub quench_ms: u64,
    /// Distance to aim at, m; without one it is estimated from the foot of the flame.
    pub distance_m: Option<f64>,
    /// Which valve it opens.
    pub valve: &'static str,
    /// Width that is added to a hotbed on each side, degrees.
    pub margin_deg: f64,
    /// Known hot things that are no fire: azimuth and elevation, degrees.
    pub ignore: Vec<(f64, f64)>,
    /// Whether it wraps the barrel when nothing burns any more.
    pub wrap: bool,
}

/// A point in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moment {
    /// A time, ms.
    At(u64),
    /// A mark.
    Mark(usize),
}

/// Something that has to be so.
#[derive(Clone, Debug)]
pub struct Expectation {
    /// Line of the file.
    pub line: usize,
    /// What the report calls it.
    pub text: Words,
    /// What is looked at.
    pub that: SiteCondition,
    /// When it has to hold.
    pub rule: Rule,
}

/// When a condition has to hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// At some time between two moments; the second is so long after the first, or a moment.
    By {
        /// From here on.
        after: Option<Moment>,
        /// Within this time from there, ms.
        within_ms: Option<u64>,
        /// Not later than this.
        by: Option<Moment>,
    },
    /// At this moment.
    At(Moment),
    /// At the end.
    End,
    /// All the time between two moments.
    Always(Option<Moment>, Option<Moment>),
    /// At no time between two moments.
    Never(Option<Moment>, Option<Moment>),
}
