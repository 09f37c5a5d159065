//! Each refusal has a reason in both languages, and the scenario that it cites exists.

use lafet_client::AnswerBuf;
use lafet_client::refusal::{Reason, reason, reason_of};
use lafet_device::Source;
use lafet_proto::flags::Button;
use lafet_proto::record::{Records, Writer};
use lafet_proto::request::Body;
use lafet_proto::{Request, RequestId, Status, SubsystemId, dictionary, text};
use lafet_sim::fault::{Fault, Post};
use lafet_sim::sim::{Config, Sim};
use lafet_texts::{Fixed, client as words};

/// Every request × status × refuser.
#[test]
fn every_refusal_has_its_scenario() {
    let spec = concat!(env!("CARGO_MANIFEST_DIR"), "/../conform/src/spec.txt");
    let spec = std::fs::read_to_string(spec).expect("the list of scenarios");
    let statuses = (2..=19).map(Status);
    for status in statuses {
        for request in dictionary::REQUESTS.iter().map(|info| info.id) {
            for to in SubsystemId::TABLE.into_iter().chain([SubsystemId::ALL]) {
                for by in SubsystemId::TABLE {
                    let Reason { scenario, why, remedy, .. } = reason(request, to, status, by);
                    let line = format!("{scenario}\t");
                    let known = spec.lines().any(|item| item.starts_with(&line));
                    assert!(known, "{scenario}: {request} {to} {status} {by}");
                    for text in [why, remedy] {
                        assert!(text.en.ends_with('.') && text.ru.ends_with('.'), "{text:?}");
                        assert!(text.ru.chars().any(|c| ('а'..='я').contains(&c)), "{text:?}");
                    }
                }
            }
        }
    }
}

/// A monitor in a state, on virtual time.
struct Bench(Sim);

impl Bench {
    fn new(config: Config) -> Self {
        let mut bench = Self(Sim::new(config));
        bench.run(500);
        bench
    }

    fn stowed() -> Self {
        Self::new(Config::default())
    }

    fn deployed() -> Self {
        let mut bench = Self::stowed();
        bench.done("Deploy Deployer");
        bench.run(20_000);
        bench
    }

    fn run(&mut self, ms: u64) {
        self.0.advance_ms(ms);
    }

    fn after(mut self, requests: &[&str]) -> Self {
        requests.iter().for_each(|request| self.done(request));
        self.run(100);
        self
    }

    fn with(mut self, faults: &[&str], ms: u64) -> Self {
        for name in faults {
            self.0.world_mut().inject(Fault::from_name(name).expect(name));
        }
        self.run(ms);
        self
    }

    fn answers(&mut self, request: &Request<'_>) -> Vec<AnswerBuf> {
        let mut buffer = [0; 260];
        let mut writer = Writer::new(&mut buffer);
        request.encode(&mut writer).unwrap();
        let bytes = self.0.request(Source::ExternalConn, writer.written());
        Records::new(&bytes).map(|record| AnswerBuf::new(&record.unwrap())).collect()
    }

    #[track_caller]
    fn done(&mut self, request: &str) {
        let mut buffer = [0; text::BUFFER_SIZE];
        let answers = self.answers(&text::parse(request, &mut buffer).expect(request));
        assert!(
            answers.iter().all(|answer| answer.status().is_success()),
            "{request}: {answers:?}"
        );
    }

    /// Who denies a request, and why by the flags that the monitor reports.
    fn denied(&mut self, request: &str) -> Result<(SubsystemId, Reason), String> {
        let mut buffer = [0; text::BUFFER_SIZE];
        let request = text::parse(request, &mut buffer).expect(request);
        let answers = self.answers(&request);
        let denied = match &answers[..] {
            [answer] if answer.status() == Status::DENIED => answer,
            others => return Err(format!("{request}: {others:?}")),
        };
        let states = self.answers(&Request::new(SubsystemId::ALL, Body::GetStatus));
        let flags = |id| {
            let state = states.iter().find(|state| state.from() == id)?;
            Some(u32::from_le_bytes(*state.data().first_chunk()?))
        };
        Ok((denied.from(), reason_of(&request, denied.status(), denied.from(), &flags)))
    }
}

const QUENCH: &str = "StartQuench Control centre=0,600 nozzle=24 sector=300,300 step=1 distance=25";
const TRAJECTORY: &str = "StartTrajectory Control point=0,600,25,50";
const SEEK: &str = "StartSeek Detector -600 600 0 600";
const JUSTIFY: &str = "StartJustify Detector";
const MOVE: &str = "Move Vertical 600";
const OPEN: &str = "Open Valve1";
const WRAP: &str = "Wrap Deployer";
const MOVE_DEPLOYER: &str = "Move Deployer 0";

/// A state, what is denied in it, by which subsystem, and why.
type Row = (Bench, &'static [&'static str], SubsystemId, Fixed);

fn of_general_and_deployer() -> Vec<Row> {
    let general = SubsystemId::GENERAL;
    let deployer = SubsystemId::DEPLOYER;
    let begin = &[
        MOVE,
        OPEN,
        "Deploy Deployer",
        WRAP,
        JUSTIFY,
        QUENCH,
        TRAJECTORY,
        SEEK,
        "CleanFlash General",
    ];
    let locked = || Bench::deployed().after(&["Lockout All on"]);
    let above = Bench::deployed().after(&["SetParam General MainVoltageMax 28"]);
    vec![
        (locked(), &[MOVE, "Stop All", "Close Valve1"], general, words::LockedOut.fixed()),
        (locked().with(&["voltage-low"], 500), &[MOVE], general, words::LockedOut.fixed()),
        (Bench::deployed().with(&["voltage-low"], 500), begin, general, words::SupplyWeak.fixed()),
        (above.with(&["voltage-high"], 500), begin, general, words::SupplyWeak.fixed()),
        (Bench::stowed(), &[MOVE, OPEN, JUSTIFY], deployer, words::NotDeployed.fixed()),
        (Bench::stowed(), &[MOVE_DEPLOYER], deployer, words::DeployerNotFree.fixed()),
        (
            Bench::stowed().after(&["Deploy Deployer"]),
            &["Stop Vertical", "Stop Detector"],
            deployer,
            words::DeployerMoves.fixed(),
        ),
    ]
}

fn of_programs() -> Vec<Row> {
    let detector = SubsystemId::DETECTOR;
    let control = SubsystemId::CONTROL;
    let during = |request| Bench::deployed().after(&[request]);
    let limitless = || Bench::deployed().after(&["SwitchLimits Vertical off"]);
    vec![
        (
            during(SEEK),
            &[MOVE, OPEN, "Close Valve1", WRAP, JUSTIFY, QUENCH, TRAJECTORY],
            detector,
            words::SearchGoesOn.fixed(),
        ),
        (during(SEEK), &["Stop Vertical"], detector, words::SearchRuns.fixed()),
        (
            during(JUSTIFY),
            &[MOVE, OPEN, WRAP, SEEK, QUENCH, TRAJECTORY],
            detector,
            words::AlignmentGoesOn.fixed(),
        ),
        (during(JUSTIFY), &["Stop Vertical"], detector, words::AlignmentRuns.fixed()),
        (during(QUENCH), &[SEEK], detector, words::ProgramRuns.fixed()),
        (during(QUENCH), &[JUSTIFY, MOVE_DEPLOYER], control, words::ProgramRuns.fixed()),
        (during(QUENCH), &["Stop Vertical"], control, words::ProgramOnlyStopped.fixed()),
        (limitless(), &[QUENCH, TRAJECTORY], control, words::ProgramWithoutLimits.fixed()),
        (limitless(), &[SEEK, JUSTIFY], detector, words::ProgramWithoutLimits.fixed()),
    ]
}

fn of_water_and_hands() -> Vec<Row> {
    let valve1 = SubsystemId::VALVE1;
    let mut open = Bench::deployed().after(&[OPEN]);
    open.run(15_000);
    let again = || Bench(open.0.clone());
    let stuck = Bench::deployed().with(&["valve1-close-stuck"], 100);
    let stuck = stuck.with(&["valve1-open-relay"], 20_000);
    let flows = &[WRAP, SEEK, MOVE_DEPLOYER];
    let mut held = Bench::deployed();
    held.0.world_mut().press(Post::Buttons, Button::Up, true);
    held.run(200);
    let mut held_apart = Bench::deployed();
    held_apart.0.world_mut().press(Post::ExtButtons, Button::Up, true);
    held_apart.run(200);
    vec![
        (again(), &[WRAP, MOVE_DEPLOYER], valve1, words::OpenUnderFolding.fixed()),
        (again(), &[SEEK], valve1, words::OpenBeforeDetector.fixed()),
        (stuck, flows, SubsystemId::VALVE2, words::FlowsThoughClosed.fixed()),
        (
            Bench::deployed().with(&["valve1-blocked"], 200),
            &[OPEN],
            valve1,
            words::ValveBlocked.fixed(),
        ),
        (held, &[MOVE, WRAP], SubsystemId::BUTTONS, words::ButtonHeld.fixed()),
        (held_apart, &[MOVE, WRAP], SubsystemId::EXT_BUTTONS, words::ButtonHeld.fixed()),
    ]
}

/// A monitor without valves whose meter shows a flow, and one whose drives do not know where they are.
fn of_positions_and_flow() -> Vec<Row> {
    let without = [SubsystemId::VALVE1, SubsystemId::VALVE2];
    let mut config = Config::default();
    config.composition.chain = config.composition.chain.without(&without);
    let mut dry = Bench::new(config).after(&["Deploy Deployer"]);
    dry.run(20_000);
    let flows = dry.with(&["flow-drift"], 30_000);
    let relative = Config { relative: [true; 4], ..Config::default() };
    let mut unknown = Bench::new(relative).after(&[
        "SetParam Vertical Homing 1",
        "SetParam Horizontal Homing 1",
        "Restart All",
    ]);
    unknown.run(2_000);
    let mut unknown = unknown.after(&["Deploy Deployer"]);
    unknown.run(20_000);
    let again = || Bench(unknown.0.clone());
    let deployer = SubsystemId::DEPLOYER;
    let vertical = SubsystemId::VERTICAL;
    vec![
        (flows, &[WRAP, SEEK, MOVE_DEPLOYER], deployer, words::WaterWithoutValve.fixed()),
        (again(), &[WRAP], deployer, words::BarrelNotHomed.fixed()),
        (again(), &["SwitchLimits Vertical on"], vertical, words::NotHomed.fixed()),
        (
            again().after(&["SwitchLimits Vertical off"]),
            &["SetParam Vertical MinLimit 0", "SetParam Vertical ZeroPoint 0"],
            vertical,
            words::NotHomed.fixed(),
        ),
    ]
}

/// Whatever the device denies, the flags of the same moment name the very reason.
#[test]
fn the_flags_name_the_very_reason() {
    let mut wrong = Vec::new();
    let rows =
        [of_general_and_deployer(), of_programs(), of_water_and_hands(), of_positions_and_flow()];
    for (bench, requests, by, why) in rows.into_iter().flatten() {
        for request in requests {
            match Bench(bench.0.clone()).denied(request) {
                Ok((refuser, reason)) if refuser == by && reason.why == why => {}
                other => wrong.push(format!("{request}, {by}: {}: {other:?}", why.en)),
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// An answer alone does not tell a lockout from a weak supply, or a search from limits that are off: both
/// are named.
#[test]
fn without_flags_no_reason_is_left_out() {
    let of = |request, to, by| reason(request, to, Status::DENIED, by).why.en;
    let (general, detector) = (SubsystemId::GENERAL, SubsystemId::DETECTOR);
    let either = [
        (of(RequestId::MOVE, SubsystemId::VERTICAL, general), ["locked out", "supply"]),
        (of(RequestId::START_JUSTIFY, detector, detector), ["search", "limits"]),
        (of(RequestId::STOP, SubsystemId::VERTICAL, detector), ["search", "alignment"]),
        (of(RequestId::WRAP, SubsystemId::DEPLOYER, SubsystemId::DEPLOYER), ["homed", "water"]),
    ];
    for (why, words) in either {
        assert!(words.iter().all(|word| why.contains(word)), "{words:?}: {why}");
    }
}
