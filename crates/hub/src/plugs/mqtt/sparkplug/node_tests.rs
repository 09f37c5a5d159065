//! The node against a host that knows the specification alone: whatever is lost, repeated and reordered on the way, at
//! the end the host shows what is so.

use std::collections::VecDeque;
use std::time::Duration;

use prost::Message as _;

use super::NodeConfig;
use super::commands::{self, Write};
use super::host::{Host, Wire};
use super::metrics::{DEVICE, Quality};
use super::node::{Node, REBIRTHS, STALE_LASTS};
use super::payload::{Metric, Payload, Value};
use crate::plugs::mqtt::attack::Dice;
use crate::plugs::mqtt::desk::{Act, Now};
use crate::plugs::mqtt::desk_tests::{Bench, TERMS};
use crate::plugs::mqtt::message::shown;
use crate::plugs::mqtt::outbox::Letter;
use crate::plugs::mqtt::state::State;
use crate::plugs::sight::fixture::status;
use crate::plugs::sight::{Control, Known, Tally};

/// Runs; `LAFET_REORDERINGS` for the long one.
const RUNS: u64 = 10_000;
const LONG_RUNS: u64 = 100_000;
const INTERVAL: Duration = Duration::from_secs(1);

fn config(host: bool) -> NodeConfig {
    NodeConfig {
        group: "site".into(),
        node: "hub".into(),
        host: host.then(|| "scada".into()),
        history: 1000,
        history_age: Duration::from_secs(3600),
    }
}

fn good() -> State {
    let (age, status) = (Some(Duration::ZERO), status());
    let (control, alarms) = (Control::default(), Tally::default());
    State::new(&Known { status: &status, age, up: true, ready: true, control, alarms })
}

fn write(name: &str, value: Value) -> Vec<u8> {
    let metric = Metric { name: Some(name.to_owned()), value: Some(value), ..Metric::default() };
    Payload { timestamp: Some(1), metrics: vec![metric], seq: None }.encode_to_vec()
}

fn host_says(online: bool, timestamp: u64) -> Vec<u8> {
    serde_json::json!({ "online": online, "timestamp": timestamp }).to_string().into_bytes()
}

/// A node with two monitors, its desk, a broker and a host.
struct World {
    node: Node,
    bench: Bench,
    host: Host,
    states: [State; 2],
    now: Now,
    is_connected: bool,
    /// On its way to the broker, with where the questions are; and to the host.
    to_broker: VecDeque<Option<Letter>>,
    to_host: VecDeque<Letter>,
    will: Option<Letter>,
    /// Deaths that the broker publishes late.
    deaths: Vec<Letter>,
    /// Commands of this connection, and results that the broker has of it.
    asked: usize,
    answered: usize,
    waits: Vec<(Now, u32)>,
    asked_for_births: Now,
    primary: bool,
}

impl World {
    fn new(seed: u64, primary: bool) -> Self {
        Self {
            node: Node::new(&config(primary), &["M1".into(), "M2".into()], INTERVAL),
            bench: Bench::of_seed(TERMS, seed),
            host: Host::strict(),
            states: [good(), good()],
            now: Duration::from_secs(10),
            is_connected: false,
            to_broker: VecDeque::new(),
            to_host: VecDeque::new(),
            will: None,
            deaths: Vec::new(),
            asked: 0,
            answered: 0,
            waits: Vec::new(),
            asked_for_births: Duration::ZERO,
            primary,
        }
    }

    fn now_ms(&self) -> u64 {
        1_700_000_000_000 + self.now.as_millis() as u64
    }

    fn connect(&mut self, seed: u64) {
        self.will = Some(self.node.connect(self.now_ms()));
        self.node.reached();
        (self.is_connected, self.asked, self.answered) = (true, 0, 0);
        self.bench = Bench::of_seed(TERMS, seed);
        self.waits.clear();
        self.node.begin(self.now);
        if self.primary {
            assert!(self.node.waits() && self.node.next(self.now, self.now_ms()).is_none());
            assert!(!self.node.host(self.now, &host_says(true, 5)));
            assert!(!self.node.host(self.now, &host_says(false, 4)), "one that comes late");
        }
    }

    /// The connection ends; the broker publishes the death unless it has ended itself.
    fn cut(&mut self, keep: usize, broker_too: bool) {
        self.to_broker.truncate(keep);
        self.arrive(usize::MAX);
        self.to_broker.clear();
        self.is_connected = false;
        self.node.lost();
        match self.will.take() {
            Some(will) if !broker_too => self.deaths.push(will),
            _ => {
                self.to_host.clear();
                self.deaths.clear();
                self.host.lost();
            }
        }
    }

    fn pass(&mut self, ms: u64) {
        self.now += Duration::from_millis(ms);
        let acts = self.bench.pass(ms);
        self.take(acts);
        let (now, due) = (self.now, std::mem::take(&mut self.waits));
        for (at, number) in due {
            if at <= now {
                let acts = self.bench.desk.answered(number, Ok(()));
                self.take(acts);
            } else {
                self.waits.push((at, number));
            }
        }
        for state in &mut self.states {
            state.at_ms = Some(1_700_000_000_000 + now.as_millis() as u64);
        }
        self.node.look(now, self.now_ms(), &self.states);
    }

    fn take(&mut self, acts: Vec<Act>) {
        let now_ms = self.now_ms();
        for act in acts {
            match act {
                Act::Ticket(ticket) => self.node.set_ticket(now_ms, shown(ticket)),
                Act::Key(at) => {
                    self.node.set_key(at, now_ms, self.bench.desk.key(at).map(shown));
                }
                Act::Say(_) if !self.is_connected => {}
                Act::Say(reply) => {
                    assert!(self.node.say(reply.monitor, String::new(), reply));
                }
                // Some are never answered: their time runs out.
                Act::Do { number, .. } if !number.is_multiple_of(3) => {
                    self.waits.push((self.now + Duration::from_millis(300), number));
                }
                _ => {}
            }
        }
    }

    fn command(&mut self, device: Option<usize>, payload: &[u8]) {
        for write in commands::read(device, payload) {
            match write {
                Write::Rebirth => self.node.rebirth(self.now),
                Write::Alive(_) => {}
                Write::Asked { asked, .. } => {
                    self.asked += 1;
                    let acts = self.bench.ask(device, false, asked);
                    self.take(acts);
                }
            }
        }
    }

    /// The node sends, so much at most.
    fn send(&mut self, most: usize) {
        for _ in 0..most {
            let Some(letter) = self.node.next(self.now, self.now_ms()) else { break };
            self.to_broker.push_back(Some(letter));
        }
        if self.node.fence() {
            self.to_broker.push_back(None);
        }
    }

    /// The broker takes.
    fn arrive(&mut self, most: usize) {
        for _ in 0..most {
            match self.to_broker.pop_front() {
                None => break,
                Some(None) => self.node.confirmed(),
                Some(Some(letter)) => {
                    // A result has its number, which is of 64 bits.
                    let payload = Payload::decode(&letter.payload[..]).unwrap();
                    let is_result = letter.topic.contains("DATA/")
                        && payload.metrics.len() >= 10
                        && payload.metrics.iter().any(|it| {
                            let row = it.alias.unwrap_or_default() % 100;
                            matches!(it.value, Some(Value::Long(_))) && row > 10
                        });
                    self.answered += usize::from(is_result);
                    self.to_host.push_back(letter);
                }
            }
        }
    }

    /// The host hears, in order.
    fn hear(&mut self) {
        while let Some(letter) = self.to_host.pop_front() {
            self.host.hear(&letter.topic, &letter.payload);
        }
        for death in std::mem::take(&mut self.deaths) {
            self.host.hear(&death.topic, &death.payload);
        }
    }

    /// The host hears what has come, by chance twice, later, or not at all.
    fn hear_by_chance(&mut self, dice: &mut Dice) {
        while let Some(letter) = self.to_host.pop_front() {
            match dice.below(40) {
                0 => continue,
                1 => self.host.hear(&letter.topic, &letter.payload),
                2 if !self.to_host.is_empty() => {
                    self.to_host.insert(1, letter);
                    continue;
                }
                3 if !self.deaths.is_empty() => {
                    let death = self.deaths.swap_remove(0);
                    self.host.hear(&death.topic, &death.payload);
                }
                _ => {}
            }
            self.host.hear(&letter.topic, &letter.payload);
        }
    }

    fn ask_for_births(&mut self) {
        let due = self.asked_for_births + Duration::from_secs(1);
        if self.is_connected && (self.host.wants_births || !self.host.online) && self.now >= due {
            self.asked_for_births = self.now;
            self.command(None, &write("Node Control/Rebirth", Value::Boolean(true)));
        }
    }

    /// Everything arrives; time for what is said seldom.
    fn settle(&mut self) {
        for _ in 0..16 {
            self.pass(500);
            self.ask_for_births();
            self.send(usize::MAX);
            self.arrive(usize::MAX);
            self.hear();
        }
    }

    /// What the host shows is what is so.
    fn judge(&self, seed: u64) {
        assert!(self.host.online && !self.host.wants_births, "{seed}");
        for (id, state) in ["M1", "M2"].into_iter().zip(&self.states) {
            let device = self.host.devices.get(id);
            let is_online = device.is_some_and(|it| it.online);
            assert_eq!(is_online, state.quality == "good", "{seed}: {id}");
            let Some(device) = device.filter(|_| is_online) else { continue };
            for row in DEVICE.iter().filter(|it| it.is_state()) {
                let Some(own) = device.metrics.get(row.name) else {
                    assert!(row.name.starts_with("Valve 2/"), "{seed}: {}", row.name);
                    continue;
                };
                let cell = row.cell(state).unwrap();
                assert_eq!(own.value, cell.value.map(wire), "{seed}: {id} {}", row.name);
                assert_eq!(own.quality, Some(cell.quality as u64), "{seed}: {id} {}", row.name);
            }
        }
    }
}

fn wire(value: Value) -> Wire {
    match value {
        Value::Int(number) => Wire::Number(number.into()),
        Value::Long(number) => Wire::Number(number),
        Value::Double(number) => Wire::Double(number),
        Value::Boolean(set) => Wire::Number(set.into()),
        Value::Text(text) => Wire::Bytes(text.into_bytes()),
        Value::Float(number) => Wire::Double(number.into()),
    }
}

fn change(world: &mut World, dice: &mut Dice) {
    let state = &mut world.states[dice.below(2) as usize];
    match dice.below(6) {
        0 => state.traverse = Some(dice.below(720) as f64 - 360.0),
        1 => state.nozzle = Some(dice.below(1000) as i64),
        2 => state.water = !state.water,
        3 => state.pressure_mpa = (dice.below(2) == 0).then_some(0.5),
        4 => state.quality = ["good", "good", "stale", "down"][dice.below(4) as usize],
        _ => state.fire = Some(dice.below(2) == 0),
    }
}

fn command(world: &mut World, dice: &mut Dice) {
    let device = [None, Some(0), Some(1)][dice.below(3) as usize];
    let ticket = world.bench.ticket.map(shown).unwrap_or_default();
    let number = dice.below(1 << 40);
    let text = match dice.below(4) {
        0 => return world.command(device, &write("Command/Stop", Value::Boolean(true))),
        1 => "nonsense".to_owned(),
        2 => format!(r#"{{"id":"{number}","command":"take","ticket":"{ticket}"}}"#),
        _ => format!(r#"{{"id":"{number}","command":"goto","ticket":"{ticket}","nozzle":5}}"#),
    };
    world.command(device, &write("Command/Text", Value::Text(text)));
}

fn run(seed: u64) -> (usize, usize) {
    let mut dice = Dice(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    let mut world = World::new(seed, seed.is_multiple_of(2));
    world.host.strict = false;
    world.connect(seed);
    for _ in 0..24 {
        match dice.below(10) {
            0 if world.is_connected => {
                let keep = dice.below(world.to_broker.len() as u64 + 1) as usize;
                world.cut(keep, dice.below(2) == 0);
            }
            1 | 2 if !world.is_connected => world.connect(dice.below(u64::MAX)),
            3..5 => change(&mut world, &mut dice),
            5 if world.is_connected => command(&mut world, &mut dice),
            _ => world.pass(50 + dice.below(1500)),
        }
        world.ask_for_births();
        if world.is_connected {
            world.send(dice.below(12) as usize);
            world.arrive(dice.below(16) as usize);
        }
        world.hear_by_chance(&mut dice);
    }
    if !world.is_connected {
        world.connect(seed);
    }
    for _ in 0..3 {
        command(&mut world, &mut dice);
    }
    world.settle();
    world.judge(seed);
    assert_eq!(world.asked, world.answered, "{seed}: each command has its result");
    (world.host.births, world.asked)
}

fn reorderings(usual: u64) {
    let runs = std::env::var("LAFET_REORDERINGS").ok().and_then(|it| it.parse().ok());
    let runs = runs.unwrap_or(usual);
    let (mut births, mut asked) = (0, 0);
    for seed in 1..=runs {
        let counts = run(seed);
        births += counts.0;
        asked += counts.1;
    }
    println!("{runs} runs: {births} births of the node, {asked} commands");
    assert!(births as u64 > runs && asked as u64 >= 3 * runs);
}

#[test]
fn whatever_is_lost_repeated_and_reordered_the_host_shows_what_is_so() {
    reorderings(RUNS);
}

#[test]
#[ignore = "a long run"]
fn whatever_is_lost_repeated_and_reordered_in_a_long_run() {
    reorderings(LONG_RUNS);
}

#[test]
fn a_command_without_an_answer_has_its_result_within_a_second() {
    let mut world = World::new(1, false);
    world.connect(1);
    world.settle();
    // The third of a desk is the one that is never answered here.
    for _ in 0..3 {
        world.command(Some(0), &write("Command/Stop", Value::Boolean(true)));
    }
    world.pass(400);
    world.send(100);
    world.arrive(100);
    assert_eq!(world.answered, 2);
    world.pass(600);
    world.send(100);
    world.arrive(100);
    world.hear();
    assert_eq!(world.answered, 3);
    let result = &world.host.devices["M1"].metrics;
    assert_eq!(result["Result/Refusal"].value, Some(Wire::Number(20)), "no result in time");
    assert_eq!(result["Result/Ok"].value, Some(Wire::Number(0)));
    assert!(result["Result/Text"].value.as_ref().unwrap().text().len() > 10);
}

#[test]
fn births_come_seldom_however_often_they_are_asked_for() {
    let mut world = World::new(1, false);
    world.connect(1);
    world.settle();
    let before = world.host.births;
    for _ in 0..1000 {
        world.command(None, &write("Node Control/Rebirth", Value::Boolean(true)));
        world.pass(60);
        world.send(100);
        world.arrive(1000);
        world.hear();
    }
    let births = world.host.births - before;
    let most = REBIRTHS.0 as usize + (60.0 * REBIRTHS.1) as usize;
    assert!((most - 2..=most).contains(&births), "{births} in a minute");
    // The last one is not forgotten.
    world.command(None, &write("Node Control/Rebirth", Value::Boolean(true)));
    let before = world.host.births;
    world.settle();
    assert_eq!(world.host.births, before + 1);
    world.judge(1);
    // Nor does it wait for longer because connections have ended before births that were asked for.
    for seed in 2..8 {
        world.cut(0, false);
        world.connect(seed);
        for _ in 0..10 {
            world.command(None, &write("Node Control/Rebirth", Value::Boolean(true)));
            world.pass(60);
            world.send(100);
            world.arrive(1000);
            world.hear();
        }
    }
    let before = world.host.births;
    world.command(None, &write("Node Control/Rebirth", Value::Boolean(true)));
    world.pass(5000);
    world.send(100);
    world.arrive(1000);
    world.hear();
    assert_eq!(world.host.births, before + 1);
}

/// A host that is away hears later what it has missed, each value with its time.
#[test]
fn what_the_host_has_missed_comes_later_with_its_time() {
    let mut world = World::new(1, true);
    world.connect(1);
    world.settle();
    assert!(world.host.past.is_empty(), "{:?}", world.host.past);
    // What was sent and not confirmed comes again.
    world.states[0].nozzle = Some(11);
    world.pass(1000);
    world.send(100);
    world.cut(0, false);
    let mut expected = vec![(world.now_ms(), 11)];
    for nozzle in [22, 33] {
        world.states[0].nozzle = Some(nozzle);
        world.pass(1000);
        expected.push((world.now_ms(), nozzle));
    }
    world.connect(2);
    world.settle();
    let nozzles: Vec<(u64, i64)> = world
        .host
        .past
        .iter()
        .filter(|it| (it.0.as_str(), it.1.as_str()) == ("M1", "Nozzle"))
        .map(|it| match it.3 {
            Some(Wire::Number(number)) => (it.2, number.cast_signed()),
            _ => panic!("{it:?}"),
        })
        .collect();
    assert_eq!(nozzles, expected);
    world.judge(1);
    let past = world.host.past.len();
    world.settle();
    assert_eq!(world.host.past.len(), past, "once");
}

#[test]
fn what_is_dropped_is_counted_and_shown() {
    let mut world = World::new(1, false);
    for nozzle in 0..1600 {
        world.states[0].nozzle = Some(nozzle);
        world.pass(1000);
    }
    let dropped = world.node.dropped();
    assert!(dropped >= 500, "{dropped}");
    world.connect(1);
    world.settle();
    let shown = world.host.node["History/Dropped"].value.clone();
    assert_eq!(shown, Some(Wire::Number(dropped)));
    assert_eq!(world.host.past.len(), 1000);
    assert_eq!(world.host.node["History/Waiting"].value, Some(Wire::Number(0)));
    world.judge(1);
}

#[test]
fn a_host_that_goes_ends_the_connection_and_an_old_message_of_it_does_not() {
    let mut world = World::new(1, true);
    world.connect(1);
    world.settle();
    for wrong in [&b""[..], b"OFFLINE", b"{}", br#"{"online":"no","timestamp":9}"#] {
        assert!(!world.node.host(world.now, wrong));
    }
    assert!(!world.node.host(world.now, &host_says(false, 4)));
    assert!(world.node.host(world.now, &host_says(false, 5)));
    let death = world.node.death(world.now_ms());
    assert!(death.confirmed && !death.retained);
    world.host.hear(&death.topic, &death.payload);
    assert!(!world.host.online);
    // What the broker keeps of the host may come before its answer.
    world.node.lost();
    world.node.connect(world.now_ms());
    assert!(!world.node.host(world.now, &host_says(true, 1)));
    world.node.begin(world.now);
    assert!(!world.node.waits() && world.node.next(world.now, world.now_ms()).is_some());
}

/// A host whose clock was set back is not believed, as the format has it, before the next connection.
#[test]
fn a_host_whose_clock_goes_back_is_waited_for() {
    let mut world = World::new(1, false);
    world.node = Node::new(&config(true), &["M1".into(), "M2".into()], INTERVAL);
    world.connect(1);
    assert!(!world.node.host(world.now, &host_says(false, 1000)));
    assert!(!world.node.host(world.now, &host_says(true, 999)));
    assert!(world.node.waits());
    world.node.lost();
    world.node.connect(world.now_ms());
    world.node.begin(world.now);
    assert!(!world.node.host(world.now, &host_says(true, 999)));
    assert!(!world.node.waits());
}

/// The number of a connection is the next one only if a broker may have heard of the last.
#[test]
fn attempts_that_reach_no_broker_do_not_count() {
    let mut node = Node::new(&config(false), &["M1".into()], INTERVAL);
    let number = |death: &Letter| {
        let payload = Payload::decode(&death.payload[..]).unwrap();
        assert_eq!((payload.seq, payload.metrics.len()), (None, 1));
        payload.metrics[0].value.clone()
    };
    for expected in [0, 0, 0] {
        assert_eq!(number(&node.connect(1)), Some(Value::Long(expected)));
        node.lost();
    }
    node.reached();
    for expected in [1, 1] {
        assert_eq!(number(&node.connect(1)), Some(Value::Long(expected)));
        assert_eq!(number(&node.death(2)), Some(Value::Long(expected)));
    }
}

/// A broker that never confirms anything costs no more than so much, and its connection ends.
#[test]
fn a_broker_that_confirms_nothing_is_given_up() {
    let mut world = World::new(1, false);
    world.connect(1);
    let asked = (0..10).take_while(|_| world.node.fence()).count();
    assert!((1..10).contains(&asked), "{asked}");
    world.node.confirmed();
    assert!(world.node.fence(), "there is room for another");
    world.node.lost();
    assert!(world.node.fence());
    // Data wait for a confirmation, and it is asked for before they do.
    let mut world = World::new(1, false);
    world.connect(1);
    world.settle();
    let (mut asked, mut sent) = (None, 0);
    for number in 0..10_000 {
        world.states[0].nozzle = Some(number % 1000);
        world.pass(1000);
        let next = || world.node.next(world.now, world.now_ms());
        let said = std::iter::from_fn(next).filter(|it| it.topic.contains("/DDATA/")).count();
        if said == 0 {
            break;
        }
        sent += said;
        asked = asked.or_else(|| world.node.is_full().then_some(sent));
    }
    assert!(asked.is_some_and(|it| (2000..3000).contains(&it)), "{asked:?}");
    assert!((4000..5000).contains(&sent), "{sent}");
}

#[test]
fn the_number_of_the_connection_and_the_sequence_wrap_at_256() {
    let mut world = World::new(1, false);
    for number in 0..600_u64 {
        world.connect(number + 1);
        world.pass(1000);
        world.send(100);
        world.arrive(100);
        world.hear();
        assert_eq!(world.host.node["bdSeq"].value, Some(Wire::Number(number % 256)));
        world.cut(0, false);
        world.hear();
        assert!(!world.host.online, "{number}");
    }
    world.connect(1);
    world.settle();
    let births = world.host.births;
    for nozzle in 0..600 {
        world.states[0].nozzle = Some(nozzle);
        world.pass(1000);
        world.send(100);
        world.arrive(100);
        world.hear();
    }
    assert_eq!(world.host.births, births, "nothing was missing");
    world.judge(1);
}

/// A monitor that is not heard is stale at once, and lost three seconds later; without a connection at once.
#[test]
fn a_monitor_that_is_not_heard_is_stale_and_then_lost() {
    let mut world = World::new(1, false);
    world.connect(1);
    world.settle();
    let step = |world: &mut World, ms: u64| {
        world.pass(ms);
        world.send(100);
        world.arrive(100);
        world.hear();
        let device = &world.host.devices["M1"];
        (device.online, device.metrics["Nozzle"].value.clone(), device.metrics["Nozzle"].quality)
    };
    let stale = Some(Quality::Stale as u64);
    world.states[0].quality = "stale";
    assert_eq!(step(&mut world, 100), (true, None, stale));
    assert_eq!(step(&mut world, STALE_LASTS.as_millis() as u64 - 1), (true, None, stale));
    assert!(!step(&mut world, 1).0);
    assert!(world.host.devices["M2"].online, "the other one is there");
    world.states[0].quality = "good";
    assert_eq!(step(&mut world, 100), (true, Some(Wire::Number(60)), Some(192)));
    world.states[0].quality = "down";
    assert!(!step(&mut world, 100).0);
    // Its commands are answered all the same: by the node.
    world.command(Some(0), &write("Command/Stop", Value::Boolean(true)));
    step(&mut world, 400);
    assert_eq!(world.host.node["Result/Command"].value, Some(Wire::Bytes(b"stop".to_vec())));
}
