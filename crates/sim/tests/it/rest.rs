//! Passing over rest is the same as stepping through it: monitors with the same seed, the same
//! requests, faults and buttons, one stepped plainly, the others passing over whatever rests, in one
//! go or step by step. All that can be seen of them is the same, byte for byte.

use lafet_device::Source;
use lafet_device::composition::Composition;
use lafet_proto::flags::Button;
use lafet_proto::record::Writer;
use lafet_proto::text;
use lafet_sim::fault::{Fault, Post};
use lafet_sim::rng::Rng;
use lafet_sim::sim::{Config, Sim};

const SEEDS: u64 = 24;
const ACTIONS: u32 = 25;

const REQUESTS: [&str; 26] = [
    "Deploy",
    "Deploy",
    "Wrap",
    "Move Vertical 900",
    "Move Horizontal -21600",
    "Move Nozzle 20",
    "Open Valve1",
    "Open Valve2",
    "Close Valve1",
    "Close Valve1",
    "Close Valve2",
    "Stop All",
    "StartSeek -600 600 -100 300",
    "StartQuench centre=600,-100 nozzle=60 sector=240,60 step=1 distance=25",
    "Stop Control",
    "StartJustify",
    "SwitchLimits Motors off",
    "SwitchLimits Motors on",
    "SetParam Vertical Speed 5",
    "GetParam Vertical Speed",
    "GetParam Valve1 TravelTime",
    "SetParam Climatics HeatOn 150",
    "SetParam General MoveTimeout 500",
    "Lockout on",
    "Lockout off",
    "Restart",
];

pub fn payload(request: &str) -> Vec<u8> {
    let (mut buffer, mut record) = ([0; text::BUFFER_SIZE], [0; 260]);
    let mut writer = Writer::new(&mut record);
    let request = text::parse(request, &mut buffer).expect("a request");
    request.encode(&mut writer).expect("room");
    writer.written().to_vec()
}

/// Does one thing to a monitor; returns what it answers.
pub fn act(sim: &mut Sim, rng: &mut Rng, faults: &[Fault]) -> Vec<u8> {
    match rng.bits() % 20 {
        0 => sim.power_cycle(),
        1 | 2 => {
            let fault = faults[rng.bits() as usize % faults.len()];
            sim.world_mut().inject(fault);
        }
        3 | 4 => sim.world_mut().clear_all(),
        5 | 6 => {
            let button = Button::ALL[rng.bits() as usize % 8];
            let pressed = rng.chance(0.3);
            sim.world_mut().press(Post::ALL[rng.bits() as usize % 2], button, pressed);
        }
        7 => sim.world_mut().climate.ambient_c = rng.unit() * 80.0 - 40.0,
        8 => {
            let fire = "az=10,range=25,size=1".parse().expect("a fire");
            sim.world_mut().light(fire);
        }
        9 => sim.world_mut().sweep(),
        _ => {
            let request = REQUESTS[rng.bits() as usize % REQUESTS.len()];
            return sim.request(Source::ExternalConn, &payload(request));
        }
    }
    Vec::new()
}

/// Everything that can be seen of a monitor and its world.
pub fn shown(sim: &mut Sim) -> String {
    let answers = sim.request(Source::Radio, &payload("GetStatus All"));
    let line = sim.trace_line();
    let world = sim.world_mut();
    let events = world.take_events();
    // The last digit of every number, and the state of all that is random.
    format!(
        "{answers:02x?}\n{line}\n{events:?}\n{:?}\n{:?}\n{:?}\n{:?}\n{:?}\n{:?}\n{:?}",
        world.inputs(),
        world.outputs(),
        world.drives,
        world.valves,
        world.water,
        world.climate,
        world.rng()
    )
}

/// Monitors with the same seed: one that makes every step, one that counts them while it rests, one
/// that is looked at in the midst of rest, one that passes over rest.
struct Four {
    stepped: Sim,
    counting: Sim,
    watched: Sim,
    passing: Sim,
}

impl Four {
    fn new(seed: u64) -> Self {
        let composition = Composition::ALL[(seed % 5) as usize];
        // Soon the clock wraps.
        let clock_ms = if seed.is_multiple_of(2) { 0 } else { u32::MAX - 90_000 };
        let gusts = if seed % 8 == 7 { 0.3 } else { 0.0 };
        let config = Config { seed, composition, clock_ms, gusts, ..Config::default() };
        let counting = Sim::new(config.clone());
        // Who keeps a trace makes every step.
        let stepped = Sim::new(Config { trace: true, ..config });
        Self { stepped, watched: counting.clone(), passing: counting.clone(), counting }
    }

    fn advance_ms(&mut self, ms: u64, rng: &mut Rng, what: &str) {
        self.stepped.advance_ms(ms);
        self.passing.pass_ms(ms);
        self.counting.advance_ms(ms);
        let mut left = ms;
        while left > 0 {
            let part = left.min(10 * (1 + rng.bits() % 300));
            self.watched.advance_ms(part);
            left -= part;
            self.look_and_ask(rng);
        }
        let shows = shown(&mut self.stepped);
        for sim in [&mut self.counting, &mut self.watched, &mut self.passing] {
            assert_eq!(shown(sim), shows, "{what}");
            assert!(self.stepped.device().is_same_state(sim.device()), "{what}: the program");
            assert_eq!(sim.now_ms(), self.stepped.now_ms(), "{what}");
        }
        // The very same program: what is counted is made up for to the last step.
        assert_eq!(self.counting.device(), self.stepped.device(), "{what}: to the bit");
    }

    /// Looking changes nothing, nor does a question.
    fn look_and_ask(&mut self, rng: &mut Rng) {
        let watched = &mut self.watched;
        let (world, now_ms) = (watched.world(), watched.now_ms());
        assert_eq!(world.now_ms(), now_ms);
        // Who asks while the flash is busy waits.
        if rng.chance(0.5) && !world.stays_stalled() {
            let before = watched.device().clone();
            assert!(!watched.request(Source::Radio, &payload("GetStatus All")).is_empty());
            assert_eq!(*watched.device(), before);
        }
    }

    fn act(&mut self, rng: &mut Rng, faults: &[Fault], what: &str) {
        let after = &mut rng.clone();
        let answer = act(&mut self.stepped, after, faults);
        for sim in [&mut self.counting, &mut self.watched, &mut self.passing] {
            assert_eq!(act(sim, &mut rng.clone(), faults), answer, "{what}");
            let memory = self.stepped.world().flash.to_bytes();
            assert!(sim.world().flash.to_bytes() == memory, "{what}: the memory");
        }
        *rng = after.clone();
    }
}

#[test]
fn the_same_as_step_by_step() {
    let faults: Vec<Fault> = Fault::all().collect();
    let (mut counted, mut passed_over) = (0, 0);
    for seed in 0..SEEDS {
        let mut four = Four::new(seed);
        let (mut rng, mut looks) = (Rng::new(seed), Rng::new(!seed));
        for action in 0..ACTIONS {
            let ms = 10 * [1, 13, 400, 2_000, 12_345][rng.bits() as usize % 5];
            let what = format!("seed {seed}, action {action}, after {ms} ms");
            four.advance_ms(ms, &mut looks, &what);
            four.act(&mut rng, &faults, &what);
        }
        counted += four.counting.passed_over_ms();
        passed_over += four.passing.passed_over_ms();
    }
    println!("{counted} ms counted, {passed_over} ms passed over");
    assert!(counted > 1_000_000 && passed_over > 1_000_000, "{counted} {passed_over} ms");
}

/// What thousands of monitors cost is the memory that their steps walk: each takes a line of the
/// cache, and of an hour at rest next to nothing is stepped through, asked five times a second or not,
/// stowed or deployed.
#[test]
fn rest_costs_next_to_nothing() {
    const HOUR_MS: u64 = 3_600_000;
    assert!(size_of::<Sim>() <= 64, "{} bytes", size_of::<Sim>());
    for first in ["GetStatus All", "Deploy"] {
        let mut left_alone = Sim::new(Config::default());
        left_alone.advance_ms(1_000);
        assert!(!left_alone.request(Source::Radio, &payload(first)).is_empty());
        left_alone.advance_ms(600_000);
        let mut asked = left_alone.clone();
        let before_ms = left_alone.passed_over_ms();
        left_alone.advance_ms(HOUR_MS);
        for _ in 0..HOUR_MS / 200 {
            asked.advance_ms(200);
            assert!(!asked.request(Source::Radio, &payload("GetStatus All")).is_empty());
        }
        for sim in [left_alone, asked] {
            let stepped_ms = HOUR_MS - (sim.passed_over_ms() - before_ms);
            assert!(stepped_ms < HOUR_MS / 100, "{first}: {stepped_ms} ms");
        }
    }
}

/// A monitor that moves makes every step, and one that is asked to move wakes up at once.
#[test]
fn what_moves_is_stepped_through() {
    let mut sim = Sim::new(Config::default());
    sim.advance_ms(60_000);
    let before_ms = sim.passed_over_ms();
    assert!(before_ms > 30_000, "{before_ms} ms");
    assert!(!sim.request(Source::ExternalConn, &payload("Deploy")).is_empty());
    sim.advance_ms(20);
    assert!(!sim.world().outputs().is_still());
    sim.advance_ms(2_000);
    assert!(sim.passed_over_ms() - before_ms <= 10_000, "counted until it was asked");
    let moving_ms = sim.passed_over_ms();
    sim.advance_ms(2_000);
    assert_eq!(sim.passed_over_ms(), moving_ms);
}
