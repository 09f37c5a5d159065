//! Events that must be seen: a monitor that does nothing keeps every law.

/// An event, or a disturbance in the middle of an activity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Witness(u8);

/// Defines the events.
macro_rules! events {
    ($($event:ident $text:literal;)*) => {
        /// Something that begins or ends.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u8)]
        pub enum Event { $(#[doc = $text] $event,)* }

        impl Event {
            const TEXTS: &[&str] = &[$($text,)*];
        }
    };
}

events! {
    Deployed "deployed";
    Wrapped "wrapped again";
    DeployedForProgram "deployed by a program";
    DeployedForSearch "deployed by a search";
    WaterOn "water on";
    FoamOn "foam on";
    WaterOff "water off again";
    Aimed "aimed by Move";
    AimedByButton "aimed by a button";
    OpenedByButton "opened by a button";
    QuenchRuns "a sector program sweeps";
    TrajectoryFinished "a trajectory runs to its end";
    Paused "a program is paused by Move";
    Resumed "a paused program continues";
    DirectAim "without pressure the jet is narrowed";
    Found "a search finds a hotbed";
    NothingFound "a search finds nothing";
    Justified "detector and barrel are aligned";
    LimitsOff "limits off";
    BeyondLimits "a drive goes beyond its limits while they are off";
    LimitsOn "limits on again";
    LimitTaken "the present position is set as a limit";
    Released "the lockout is released";
    Restarted "a restart is carried out";
    RecoveredDeployed "deployed after a fault was fixed";
    RecoveredAimed "aimed after a fault was fixed";
    RecoveredWater "water on after a fault was fixed";
    ToldFault "a fault is reported";
}

/// An activity of the monitor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Activity {
    /// Deploying by command.
    Deploying,
    /// Stowing.
    Wrapping,
    /// A drive moves by Move.
    Moving,
    /// A valve opens.
    Opening,
    /// Water flows.
    Water,
    /// A program waits for the deployment.
    Waiting,
    /// A program sweeps the sector.
    Program,
    /// A program is paused.
    Paused,
    /// A search.
    Searching,
    /// An alignment.
    Justifying,
    /// Limits are off.
    Limitless,
}

impl Activity {
    /// All activities.
    pub const ALL: [Self; 11] = [
        Self::Deploying,
        Self::Wrapping,
        Self::Moving,
        Self::Opening,
        Self::Water,
        Self::Waiting,
        Self::Program,
        Self::Paused,
        Self::Searching,
        Self::Justifying,
        Self::Limitless,
    ];
}

/// A disturbance of an activity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Disturbance {
    /// Lockout on.
    Lockout,
    /// Stop All.
    Stop,
    /// A fault occurs.
    Fault,
    /// The power fails.
    PowerLoss,
    /// Restart.
    Restart,
}

const EVENTS: usize = Event::TEXTS.len();
const ACTIVITIES: usize = Activity::ALL.len();
/// Number of witnesses.
pub const COUNT: usize = EVENTS + 5 * ACTIVITIES;

/// Texts of a disturbance in the middle of each activity.
macro_rules! while_in {
    ($disturbance:literal) => {
        [
            concat!($disturbance, " while deploying"),
            concat!($disturbance, " while wrapping"),
            concat!($disturbance, " while moving"),
            concat!($disturbance, " while opening"),
            concat!($disturbance, " with water on"),
            concat!($disturbance, " while a program waits for the deployment"),
            concat!($disturbance, " while a program runs"),
            concat!($disturbance, " while a program is paused"),
            concat!($disturbance, " while searching"),
            concat!($disturbance, " while aligning"),
            concat!($disturbance, " with limits off"),
        ]
    };
}

const DISTURBED: [[&str; ACTIVITIES]; 5] = [
    while_in!("lockout"),
    while_in!("Stop All"),
    while_in!("a fault"),
    while_in!("power loss"),
    while_in!("restart"),
];

impl Witness {
    /// An event.
    pub const fn event(event: Event) -> Self {
        Self(event as u8)
    }

    /// A disturbance in the middle of an activity.
    pub const fn disturbed(disturbance: Disturbance, activity: Activity) -> Self {
        Self(EVENTS as u8 + disturbance as u8 * ACTIVITIES as u8 + activity as u8)
    }

    /// Number of the witness, below [`COUNT`].
    pub const fn index(self) -> usize {
        self.0 as usize
    }

    /// What is seen, as text.
    pub fn text(self) -> &'static str {
        match self.index().checked_sub(EVENTS) {
            None => Event::TEXTS[self.index()],
            Some(place) => DISTURBED[place / ACTIVITIES][place % ACTIVITIES],
        }
    }
}

/// The set of witnesses that have just been seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Happened(u128);

impl Happened {
    /// Adds the event if the condition holds.
    pub fn note(&mut self, event: Event, so: bool) {
        if so {
            self.add(Witness::event(event));
        }
    }

    /// Adds the witness.
    pub fn add(&mut self, witness: Witness) {
        self.0 |= 1 << witness.index();
    }

    /// Whether the witness with this number is in the set.
    pub const fn contains(self, index: usize) -> bool {
        self.0 >> index & 1 == 1
    }

    /// Texts of the witnesses.
    pub fn texts(self) -> impl Iterator<Item = &'static str> {
        let all = (0..COUNT).filter(move |index| self.contains(*index));
        all.map(|index| Witness(index as u8).text())
    }
}

const _: () = assert!(COUNT <= 128);
