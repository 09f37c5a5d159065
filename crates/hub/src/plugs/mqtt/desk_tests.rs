//! Each rule of the desk, with what breaks it.

use std::time::Duration;

use serde_json::{Value, json};

use super::desk::{Act, Around, Desk, Heard, KNOWN_MAX, Now, Reply, TICKET_LASTS, Terms};
use super::message::{self, Asked, shown};
use crate::plugs::orders::{Command, What};
use crate::plugs::refusal::{Failed, Refusal};
use crate::plugs::sight::Holder;

pub const TERMS: Terms = Terms { alive: Duration::from_secs(3), closes: true, operates: true };

/// A desk of two monitors with its clock, its random numbers, and who holds.
pub struct Bench {
    pub desk: Desk,
    pub now: Now,
    pub holders: [Holder; 2],
    pub ticket: Option<u64>,
    next: u64,
    ids: u64,
}

impl Bench {
    pub fn new(terms: Terms) -> Self {
        Self::of_seed(terms, 100)
    }

    /// With other random numbers.
    pub fn of_seed(terms: Terms, mut next: u64) -> Self {
        let desk = Desk::new(terms, 2, Now::ZERO, &mut Self::random(&mut next));
        let mut bench =
            Self { desk, now: Now::ZERO, holders: [Holder::Mine; 2], ticket: None, next, ids: 0 };
        bench.pass(0);
        bench
    }

    fn random(next: &mut u64) -> impl FnMut() -> Option<u64> {
        // SplitMix64: no number is near the one before it.
        move || {
            *next = next.wrapping_add(0x9E37_79B9_7F4A_7C15);
            let mut mixed = *next;
            mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            Some(mixed ^ (mixed >> 31))
        }
    }

    /// Time passes; the ticket is the latest one.
    pub fn pass(&mut self, ms: u64) -> Vec<Act> {
        self.now += Duration::from_millis(ms);
        let acts = self.desk.tick(self.now, &mut Self::random(&mut self.next));
        self.look(&acts);
        acts
    }

    fn look(&mut self, acts: &[Act]) {
        for act in acts {
            if let Act::Ticket(ticket) = act {
                self.ticket = Some(*ticket);
            }
        }
    }

    pub fn hear(&mut self, monitor: Option<usize>, retained: bool, payload: &[u8]) -> Vec<Act> {
        let mut acts = self.ask(monitor, retained, message::read(payload));
        acts.extend(self.desk.carried(payload, &mut Self::random(&mut self.next)));
        acts
    }

    pub fn ask(&mut self, monitor: Option<usize>, retained: bool, asked: Asked) -> Vec<Act> {
        let holders = self.holders;
        let holder = |at: usize| holders[at];
        let random = &mut Self::random(&mut self.next);
        let mut around = Around { now: self.now, holder: &holder, random };
        self.desk.command(&mut around, Heard { monitor, retained }, asked)
    }

    pub fn alive(&mut self, ticket: u64) -> Vec<Act> {
        let holders = self.holders;
        let holder = |at: usize| holders[at];
        let random = &mut Self::random(&mut self.next);
        let mut around = Around { now: self.now, holder: &holder, random };
        let payload = json!({ "ticket": shown(ticket) }).to_string();
        self.desk.alive(&mut around, message::read_alive(payload.as_bytes())).1
    }

    /// A command with a new id and the present ticket.
    pub fn text(&mut self, command: &str, more: Value) -> String {
        self.ids += 1;
        let mut text = json!({ "id": self.ids.to_string(), "command": command });
        text["ticket"] = json!(self.ticket.map(shown));
        for (key, value) in more.as_object().into_iter().flatten() {
            text[key] = value.clone();
        }
        text.to_string()
    }

    pub fn send(&mut self, command: &str, more: Value) -> Vec<Act> {
        let text = self.text(command, more);
        self.hear(Some(0), false, text.as_bytes())
    }

    pub fn key(&self, at: usize) -> Value {
        json!(self.desk.key(at).map(shown))
    }

    pub fn open(&mut self) -> Vec<Act> {
        let key = self.key(0);
        self.send("open", json!({ "valve": 1, "key": key }))
    }

    /// Answers that it is done.
    fn done(&mut self, acts: &[Act]) -> Vec<Act> {
        self.desk.answered(number(acts).expect("it is asked for"), Ok(()))
    }
}

pub fn what(acts: &[Act]) -> Option<What> {
    acts.iter().find_map(|act| match act {
        Act::Do { what, .. } => Some(*what),
        _ => None,
    })
}

pub fn number(acts: &[Act]) -> Option<u32> {
    acts.iter().find_map(|act| match act {
        Act::Do { number, .. } => Some(*number),
        _ => None,
    })
}

fn reply(act: &Act) -> Option<&Reply> {
    match act {
        Act::Say(reply) => Some(reply),
        _ => None,
    }
}

fn replies(acts: &[Act]) -> Vec<&Reply> {
    acts.iter().filter_map(reply).collect()
}

fn refusal(acts: &[Act]) -> Option<Refusal> {
    match replies(acts)[..] {
        [reply] => reply.result.err().map(|it| it.why),
        _ => None,
    }
}

#[test]
fn what_moves_needs_ticket_role_and_authority() {
    let mut bench = Bench::new(TERMS);
    let goto = json!({ "traverse": 10 });
    let acts = bench.send("goto", goto.clone());
    assert_eq!(what(&acts), Some(What::GoTo([Some(600), None, None])));
    assert_eq!(replies(&acts).len(), 0, "its result comes later");
    let done = bench.done(&acts);
    let [reply] = replies(&done)[..] else { panic!("{done:?}") };
    assert_eq!((reply.result, reply.id.as_deref(), reply.monitor), (Ok(()), Some("1"), Some(0)));
    for (holder, why) in [(Holder::Free, Refusal::NotTaken), (Holder::Other, Refusal::Held)] {
        bench.holders[0] = holder;
        for (command, more) in [("goto", goto.clone()), ("deploy", json!({})), ("stow", json!({}))]
        {
            let acts = bench.send(command, more);
            assert_eq!((what(&acts), refusal(&acts)), (None, Some(why)), "{command}");
        }
        let acts = bench.open();
        assert_eq!((what(&acts), refusal(&acts)), (None, Some(why)));
        // To take it is asked of the hub.
        let acts = bench.send("take", json!({}));
        assert_eq!(what(&acts), Some(What::Authority(Command::Take)));
        bench.done(&acts);
    }
    bench.holders[0] = Holder::Mine;
    for ticket in [Value::Null, json!(shown(7)), json!("7"), json!(shown(0))] {
        let acts = bench.send("goto", json!({ "traverse": 10, "ticket": ticket }));
        assert_eq!((what(&acts), refusal(&acts)), (None, Some(Refusal::Ticket)), "{ticket}");
    }
    let mut observer = Bench::new(Terms { operates: false, ..TERMS });
    for command in ["take", "release", "ask", "deploy", "stow"] {
        let acts = observer.send(command, json!({}));
        assert_eq!((what(&acts), refusal(&acts)), (None, Some(Refusal::Role)), "{command}");
    }
    let acts = observer.open();
    assert_eq!((what(&acts), refusal(&acts)), (None, Some(Refusal::Role)));
}

/// Of any clock but the hub's own nothing is assumed: a ticket is new or old by when the hub has published it.
#[test]
fn a_ticket_lasts_three_seconds_whatever_the_clocks_of_clients_say() {
    let mut bench = Bench::new(TERMS);
    let ticket = bench.ticket.map(shown);
    for (ms, taken) in [(1000, true), (1999, true), (1, false), (60_000, false)] {
        bench.pass(ms);
        let acts = bench.send("take", json!({ "ticket": ticket }));
        assert_eq!(what(&acts).is_some(), taken, "after {:?}", bench.now);
        if taken {
            bench.done(&acts);
        } else {
            assert_eq!(refusal(&acts), Some(Refusal::Ticket));
        }
    }
    assert_eq!(TICKET_LASTS.as_secs(), 3);
}

#[test]
fn a_ticket_of_another_session_is_none() {
    let mut first = Bench::new(TERMS);
    let old = first.text("take", json!({}));
    let mut second = Bench::of_seed(TERMS, 200);
    second.pass(3000);
    second.pass(1000);
    let acts = second.hear(Some(0), false, old.as_bytes());
    assert_eq!((what(&acts), refusal(&acts)), (None, Some(Refusal::Ticket)));
    assert!(what(&first.hear(Some(0), false, old.as_bytes())).is_some(), "in its own it is");
}

#[test]
fn stop_close_and_lockout_are_taken_from_all_always_and_each_time() {
    let mut bench = Bench::new(Terms { operates: false, ..TERMS });
    bench.holders = [Holder::Other; 2];
    for (text, asked) in [
        (r#"{"command":"stop"}"#, What::Stop),
        (r#"{"id":"1","command":"stop"}"#, What::Stop),
        (r#"{"id":"1","command":"close"}"#, What::Close(0)),
        (r#"{"id":"1","command":"close","valve":2}"#, What::Close(2)),
        (r#"{"id":"1","command":"lockout"}"#, What::Lockout),
    ] {
        for monitor in [Some(0), Some(1), None] {
            for retained in [false, true] {
                for _ in 0..3 {
                    let acts = bench.hear(monitor, retained, text.as_bytes());
                    assert_eq!(what(&acts), Some(asked), "{text}");
                    let done = bench.done(&acts);
                    let [reply] = replies(&done)[..] else { panic!("{done:?}") };
                    assert!(reply.result.is_ok() && !reply.repeated);
                    assert_eq!((reply.monitor, reply.retained), (monitor, retained));
                }
            }
        }
    }
}

#[test]
fn stop_is_taken_while_everything_else_is_full() {
    let mut bench = Bench::new(TERMS);
    let mut refused = 0;
    for _ in 0..1000 {
        let acts = bench.send("goto", json!({ "traverse": 10, "timeout_ms": 60000 }));
        refused += u32::from(refusal(&acts).is_some());
    }
    assert_eq!(refused, 999, "one waits, the others are refused, each with its result");
    for sent in 0..200 {
        let acts = bench.send("stop", json!({ "timeout_ms": 60000 }));
        assert_eq!(what(&acts), Some(What::Stop), "{sent}");
        // Beyond what can be waited for, a Stop is carried out, and its result says that much.
        assert_eq!(refusal(&acts), (sent >= 64).then_some(Refusal::Late), "{sent}");
    }
}

#[test]
fn commands_beyond_the_limit_are_answered_and_not_looked_at() {
    let mut bench = Bench::new(TERMS);
    let mut too_fast = 0;
    for _ in 0..200 {
        let acts = bench.send("take", json!({}));
        match refusal(&acts) {
            Some(Refusal::TooFast) => too_fast += 1,
            Some(other) => panic!("{other:?}"),
            None => drop(bench.done(&acts)),
        }
    }
    assert_eq!(too_fast, 150);
    bench.pass(1000);
    assert!(what(&bench.send("take", json!({}))).is_some(), "a second later it is taken");
}

/// A command that was asked for before Stop must not be sent after it.
#[test]
fn stop_makes_void_what_is_not_sent_yet_at_its_monitor() {
    let mut bench = Bench::new(TERMS);
    bench.send("goto", json!({ "traverse": 10 }));
    let before = [0, 1].map(|at| bench.desk.generation(at));
    assert!(before[0].is_some());
    bench.send("stop", json!({}));
    let after = [0, 1].map(|at| bench.desk.generation(at));
    assert!(before[0] != after[0] && before[1] == after[1]);
    bench.hear(None, false, br#"{"command":"stop"}"#);
    assert!(after[1] != bench.desk.generation(1), "of all");
}

#[test]
fn retained_messages_command_nothing_else() {
    let mut bench = Bench::new(TERMS);
    let key = bench.key(0);
    for (command, more) in [
        ("take", json!({})),
        ("goto", json!({ "traverse": 1 })),
        ("open", json!({ "valve": 1, "key": key })),
    ] {
        let text = bench.text(command, more);
        let acts = bench.hear(Some(0), true, text.as_bytes());
        assert_eq!((what(&acts), refusal(&acts)), (None, Some(Refusal::Retained)), "{command}");
        assert!(replies(&acts)[0].retained);
        let noted = acts.iter().any(|it| matches!(it, Act::Refused { monitor: 0, valve: 1, .. }));
        assert_eq!(noted, command == "open");
    }
    assert_ne!(bench.key(0), key, "what was refused never opens later");
}

#[test]
fn an_id_that_comes_again_is_answered_with_its_first_result() {
    let mut bench = Bench::new(TERMS);
    let text = bench.text("goto", json!({ "traverse": 10 }));
    let acts = bench.hear(Some(0), false, text.as_bytes());
    // Twice more while it is under way: three came, three results.
    for _ in 0..2 {
        assert_eq!(bench.hear(Some(0), false, text.as_bytes()), []);
    }
    let failed = Failed { why: Refusal::Refused, status: 7 };
    let said = bench.desk.answered(number(&acts).unwrap(), Err(failed));
    let repeated: Vec<bool> = replies(&said).iter().map(|it| it.repeated).collect();
    assert_eq!(repeated, [false, true, true]);
    // And later, with another ticket as well.
    bench.pass(1000);
    let ticket = bench.ticket.map(shown);
    let again = json!({ "id": "1", "command": "goto", "traverse": 10, "ticket": ticket });
    for text in [text, again.to_string()] {
        let acts = bench.hear(Some(0), false, text.as_bytes());
        let [reply] = replies(&acts)[..] else { panic!("{acts:?}") };
        assert_eq!((reply.result, reply.repeated, acts.len()), (Err(failed), true, 1));
    }
    // Another command, and the same at another monitor, are not the same.
    for (monitor, more) in [(0, json!({ "traverse": 11 })), (1, json!({ "traverse": 10 }))] {
        let mut text: Value = serde_json::from_str(&bench.text("goto", more)).unwrap();
        text["id"] = json!("1");
        let acts = bench.hear(Some(monitor), false, text.to_string().as_bytes());
        assert_eq!((what(&acts), refusal(&acts)), (None, Some(Refusal::Sequence)));
    }
}

/// A command whose id is forgotten has no ticket any more: it cannot be done twice.
#[test]
fn ids_are_remembered_for_longer_than_a_ticket_lasts() {
    let mut bench = Bench::new(TERMS);
    let text = bench.text("deploy", json!({}));
    let acts = bench.hear(Some(0), false, text.as_bytes());
    bench.done(&acts);
    let mut looked_at = 0;
    let began = bench.now;
    while bench.now < began + TICKET_LASTS {
        let acts = bench.send("release", json!({}));
        if let Some(number) = number(&acts) {
            bench.desk.answered(number, Ok(()));
            looked_at += 1;
        }
        let acts = bench.hear(Some(0), false, text.as_bytes());
        assert_eq!(what(&acts), None, "it is not done again");
        bench.pass(4);
    }
    assert!(looked_at < KNOWN_MAX && looked_at > 50, "{looked_at}");
    for _ in 0..KNOWN_MAX {
        bench.pass(100);
        bench.send("release", json!({}));
    }
    let acts = bench.hear(Some(0), false, text.as_bytes());
    assert_eq!(refusal(&acts), Some(Refusal::Ticket), "it is forgotten, and too old");
}

#[test]
fn an_opening_needs_its_key_which_is_tried_once() {
    let mut bench = Bench::new(TERMS);
    let first = bench.key(0);
    let acts = bench.open();
    assert_eq!(what(&acts), Some(What::Open(1)));
    assert!(acts.contains(&Act::Key(0)), "the new one is published");
    bench.done(&acts);
    let second = bench.key(0);
    assert_ne!(first, second);
    // The old one, that of another monitor, none: each a try, after which the key is another one.
    for wrong in [first, bench.key(1), Value::Null, json!("x")] {
        let before = bench.key(0);
        let acts = bench.send("open", json!({ "valve": 1, "key": wrong }));
        assert_eq!((what(&acts), refusal(&acts)), (None, Some(Refusal::Key)));
        let id = Some(bench.ids.to_string());
        let noted = Act::Refused { monitor: 0, valve: 1, why: Refusal::Key, id };
        assert!(acts.contains(&noted) && acts.contains(&Act::Key(0)), "{acts:?}");
        assert_ne!(bench.key(0), before);
    }
    let before = [bench.key(0), bench.key(1)];
    bench.pass(3000);
    assert!(before[0] != bench.key(0) && before[1] != bench.key(1), "after silence too");
}

#[test]
fn without_random_numbers_nothing_opens_or_moves() {
    let mut none = || None;
    let mut desk = Desk::new(TERMS, 1, Now::ZERO, &mut none);
    assert_eq!(desk.tick(Now::ZERO, &mut none), []);
    for ticket in [Value::Null, json!(shown(0)), json!("")] {
        for command in ["open", "take", "deploy"] {
            let valve = (command == "open").then_some(1);
            let text = json!({ "id": format!("{command}{ticket}"), "command": command,
                "ticket": ticket, "key": ticket, "valve": valve });
            let holder = |_: usize| Holder::Mine;
            let mut around = Around { now: Now::ZERO, holder: &holder, random: &mut none };
            let text = text.to_string();
            let heard = Heard { monitor: Some(0), retained: false };
            let acts = desk.command(&mut around, heard, message::read(text.as_bytes()));
            assert_eq!((what(&acts), refusal(&acts)), (None, Some(Refusal::Ticket)), "{text}");
        }
    }
    let holder = |_: usize| Holder::Mine;
    let mut around = Around { now: Now::ZERO, holder: &holder, random: &mut none };
    let heard = Heard { monitor: None, retained: false };
    let stop = message::read(br#"{"command":"stop"}"#);
    assert_eq!(what(&desk.command(&mut around, heard, stop)), Some(What::Stop));
}

#[test]
fn clients_that_are_silent_lose_what_they_hold() {
    let mut bench = Bench::new(TERMS);
    let acts = bench.send("goto", json!({ "traverse": 10, "nozzle": 5 }));
    assert!(acts.contains(&Act::Back));
    bench.done(&acts);
    let acts = bench.open();
    bench.done(&acts);
    bench.pass(2000);
    let ticket = bench.ticket.unwrap();
    assert!(!bench.alive(ticket).contains(&Act::Back), "it was there");
    assert!(!bench.pass(2999).contains(&Act::Lost));
    let lost = bench.pass(1);
    for act in [
        Act::Halt { monitor: 0, axis: 0 },
        Act::Halt { monitor: 0, axis: 2 },
        Act::Shut { monitor: 0, valve: 1 },
        Act::Lost,
        Act::Key(0),
        Act::Key(1),
    ] {
        assert!(lost.contains(&act), "{act:?}: {lost:?}");
    }
    assert_eq!(bench.desk.generation(0), None, "nothing more is sent");
    assert!(lost.iter().position(|it| *it == Act::Lost) > lost.iter().position(is_shut));
    let ticket = bench.ticket.unwrap();
    assert!(bench.alive(ticket).contains(&Act::Back));
    assert!(!bench.pass(3000).iter().any(is_shut), "once");
    let mut open = Bench::new(Terms { closes: false, ..TERMS });
    let acts = open.open();
    open.done(&acts);
    assert!(!open.pass(3000).iter().any(is_shut), "by the configuration it stays open");
}

fn is_shut(act: &Act) -> bool {
    matches!(act, Act::Shut { .. })
}

/// A broker that repeats or keeps back messages keeps no client alive that is gone.
#[test]
fn an_old_sign_of_life_is_none() {
    let mut bench = Bench::new(TERMS);
    let old = bench.ticket.unwrap();
    bench.alive(old);
    let mut lost = None;
    for ms in (0..20_000).step_by(100) {
        if bench.pass(100).contains(&Act::Lost) {
            lost = Some(ms + 100);
            break;
        }
        bench.alive(old);
    }
    // The life of a ticket, and the time without one.
    assert!(lost.is_some_and(|it| it <= 6000), "{lost:?}");
    assert_eq!(bench.alive(old), []);
}

#[test]
fn what_may_be_open_is_closed_and_what_was_open_stays_known() {
    for (why, shut) in [
        (Refusal::NoAnswer, true),
        (Refusal::Unknown, true),
        (Refusal::Refused, false),
        (Refusal::KeepOut, false),
        (Refusal::Void, false),
    ] {
        let mut bench = Bench::new(TERMS);
        let acts = bench.open();
        bench.desk.answered(number(&acts).unwrap(), Err(Failed::from(why)));
        assert_eq!(bench.pass(3000).iter().any(is_shut), shut, "{why:?}");
        // A second opening that is refused does not make the first one undone.
        let mut bench = Bench::new(TERMS);
        for result in [Ok(()), Err(Failed::from(why))] {
            let acts = bench.open();
            bench.desk.answered(number(&acts).unwrap(), result);
        }
        assert!(bench.pass(3000).iter().any(is_shut), "{why:?}");
    }
    let mut bench = Bench::new(TERMS);
    let acts = bench.open();
    bench.done(&acts);
    let acts = bench.send("close", json!({ "valve": 2 }));
    bench.done(&acts);
    let acts = bench.send("close", json!({}));
    bench.desk.answered(number(&acts).unwrap(), Err(Failed::from(Refusal::NoAnswer)));
    assert!(bench.pass(3000).iter().any(is_shut), "the other valve, and one that did not close");
    let acts = bench.open();
    bench.done(&acts);
    let acts = bench.send("close", json!({}));
    bench.done(&acts);
    assert!(!bench.pass(3000).iter().any(is_shut), "it is closed");
}

#[test]
fn a_result_comes_in_time_and_once() {
    let mut bench = Bench::new(TERMS);
    let acts = bench.send("take", json!({}));
    assert_eq!(refusal(&bench.pass(999)), None);
    assert_eq!(refusal(&bench.pass(1)), Some(Refusal::Late));
    assert_eq!(bench.desk.answered(number(&acts).unwrap(), Ok(())), [], "it was answered");
    let acts = bench.send("take", json!({ "timeout_ms": 60000 }));
    for _ in 0..59 {
        assert_eq!(refusal(&bench.pass(1000)), None);
    }
    assert_eq!(refusal(&bench.pass(1000)), Some(Refusal::Late), "{acts:?}");
}

#[test]
fn one_command_of_a_monitor_at_a_time() {
    let mut bench = Bench::new(TERMS);
    let first = bench.send("deploy", json!({}));
    let acts = bench.send("stow", json!({}));
    assert_eq!((what(&acts), refusal(&acts)), (None, Some(Refusal::Busy)));
    let other = bench.text("stow", json!({}));
    assert_eq!(what(&bench.hear(Some(1), false, other.as_bytes())), Some(What::Stow));
    assert!(what(&bench.send("release", json!({}))).is_some(), "who goes need not wait");
    bench.done(&first);
    bench.pass(1000);
    assert!(what(&bench.send("stow", json!({}))).is_some());
}

#[test]
fn for_all_monitors_there_are_stop_close_and_lockout_alone() {
    let mut bench = Bench::new(TERMS);
    let key = bench.key(0);
    for (command, more) in [
        ("take", json!({})),
        ("goto", json!({ "traverse": 1 })),
        ("open", json!({ "valve": 1, "key": key })),
    ] {
        let text = bench.text(command, more);
        let acts = bench.hear(None, false, text.as_bytes());
        assert_eq!((what(&acts), refusal(&acts)), (None, Some(Refusal::Command)), "{command}");
    }
    assert_ne!(bench.key(0), key);
}

/// What is in the way of an opening.
type Before = fn(&mut Bench);

/// Whatever an opening was refused for: what it asked for does not come about by the same key, with another id, a new
/// ticket, at the right monitor and when nothing is in its way any more.
#[test]
fn an_opening_that_was_refused_never_opens() {
    let flood = |bench: &mut Bench| (0..60).for_each(|_| drop(bench.send("x", json!({}))));
    let busy = |bench: &mut Bench| drop(bench.send("deploy", json!({})));
    let held = |bench: &mut Bench| bench.holders[0] = Holder::Other;
    let none = |_: &mut Bench| {};
    let cases: [(Before, Option<usize>, bool, Value, Refusal); 8] = [
        (none, Some(0), true, json!({}), Refusal::Retained),
        (none, None, false, json!({}), Refusal::Command),
        (none, Some(1), false, json!({}), Refusal::Key),
        (none, Some(0), false, json!({ "ticket": shown(7) }), Refusal::Ticket),
        (none, Some(0), false, json!({ "valve": 3 }), Refusal::Argument),
        (held, Some(0), false, json!({}), Refusal::Held),
        (busy, Some(0), false, json!({}), Refusal::Busy),
        (flood, Some(0), false, json!({}), Refusal::TooFast),
    ];
    for (before, monitor, retained, more, why) in cases {
        let mut bench = Bench::new(TERMS);
        before(&mut bench);
        refused_for_good(&mut bench, monitor, retained, &more, why);
    }
    // The id was used before: for something else.
    let mut bench = Bench::new(TERMS);
    let acts = bench.send("deploy", json!({}));
    bench.done(&acts);
    refused_for_good(&mut bench, Some(0), false, &json!({ "id": "1" }), Refusal::Sequence);
}

fn refused_for_good(
    bench: &mut Bench,
    monitor: Option<usize>,
    retained: bool,
    more: &Value,
    why: Refusal,
) {
    let key = bench.key(0);
    let mut opening = json!({ "valve": 1, "key": key });
    for (name, value) in more.as_object().into_iter().flatten() {
        opening[name] = value.clone();
    }
    let text = bench.text("open", opening);
    let acts = bench.hear(monitor, retained, text.as_bytes());
    assert_eq!((what(&acts), refusal(&acts)), (None, Some(why)));
    assert!(acts.contains(&Act::Key(0)), "{why:?}: the new one is published");
    bench.holders[0] = Holder::Mine;
    bench.pass(2000);
    let acts = bench.send("open", json!({ "valve": 1, "key": key }));
    assert_eq!((what(&acts), refusal(&acts)), (None, Some(Refusal::Key)), "{why:?}");
    assert_eq!(what(&bench.open()), Some(What::Open(1)), "{why:?}: and by the rules it opens");
}

/// Assumed: who forwards the messages spoils an opening, and publishes it later as it should be.
#[test]
fn an_opening_that_cannot_be_read_never_opens() {
    let utf_16 =
        |text: &str| -> Vec<u8> { text.encode_utf16().flat_map(u16::to_le_bytes).collect() };
    let without_id = |text: &str| text.replacen("\"id\"", "\"Id\"", 1).into_bytes();
    let spoiled: [fn(&str) -> Vec<u8>; 9] = [
        |it| it.replacen('}', "", 1).into_bytes(),
        |it| it.replacen(':', "=", 1).into_bytes(),
        |it| it.replacen("\"valve\":1", "\"valve\":\"1\"", 1).into_bytes(),
        |it| it.replacen("\"open\"", "\"Open\"", 1).into_bytes(),
        |it| it.replacen("\"open\"", "[\"open\"]", 1).into_bytes(),
        |it| format!("[{it}]").into_bytes(),
        |it| format!("{it}{}", " ".repeat(message::PAYLOAD_MAX)).into_bytes(),
        |it| [&[0xEF, 0xBB, 0xBF], it.as_bytes()].concat(),
        |it| it.bytes().map(|it| it | 0x80).collect(),
    ];
    let spoiled = spoiled.iter().map(|it| it as &dyn Fn(&str) -> Vec<u8>);
    for (case, spoil) in spoiled.chain([&utf_16 as _, &without_id as _]).enumerate() {
        for monitor in [Some(0), None] {
            let mut bench = Bench::new(TERMS);
            let key = bench.key(0);
            let text = bench.text("open", json!({ "valve": 1, "key": key }));
            let acts = bench.hear(monitor, false, &spoil(&text));
            assert_eq!(what(&acts), None, "{case}");
            assert!(acts.contains(&Act::Key(0)), "{case}: the new one is published");
            let acts = bench.send("open", json!({ "valve": 1, "key": key }));
            assert_eq!((what(&acts), refusal(&acts)), (None, Some(Refusal::Key)), "{case}");
            assert_eq!(what(&bench.open()), Some(What::Open(1)), "{case}: by the rules it opens");
        }
    }
}

/// On the topic of another monitor, of none, or of signs of life, where nothing opens.
#[test]
fn a_key_whose_text_was_heard_elsewhere_is_used_up() {
    let mut bench = Bench::new(TERMS);
    let carried = |bench: &mut Bench, payload: &str| {
        let next = &mut Bench::random(&mut bench.next);
        bench.desk.carried(payload.as_bytes(), next)
    };
    let key = |bench: &Bench| bench.key(1).as_str().unwrap().to_owned();
    let forms: [fn(&str) -> String; 3] =
        [|key| format!("0123{key}x"), |key| key.to_uppercase(), |key| format!("{key}00")];
    for form in forms {
        let text = form(&key(&bench));
        assert_eq!(carried(&mut bench, &text), [Act::Key(1)], "{text}");
        assert_eq!(carried(&mut bench, &text), [], "{text}: once");
    }
    let key = key(&bench);
    for other in [&key[1..], &format!("{} {}", &key[..8], &key[8..]), "", "0000000000000000"] {
        assert_eq!(carried(&mut bench, other), [], "{other}");
    }
    // What can be read and opens nothing leaves the keys alone, done or refused.
    let before = [0, 1].map(|at| bench.key(at));
    for (command, more) in [
        ("take", json!({})),
        ("goto", json!({ "traverse": 400 })),
        ("goto", json!({ "traverse": 4, "ticket": shown(7) })),
        ("stop", json!({})),
    ] {
        let acts = bench.send(command, more);
        if what(&acts).is_some() {
            bench.done(&acts);
        }
        assert_eq!([0, 1].map(|at| bench.key(at)), before, "{command}");
    }
}

/// Whatever comes: one result for each message, and no panic.
#[test]
fn every_message_has_one_result() {
    let texts: [&[u8]; 8] = [
        b"",
        b"{",
        b"\xFF\xFE",
        br#"{"id":"1","command":"jog"}"#,
        br#"{"id":7,"command":"take"}"#,
        br#"{"id":"2","command":"open","valve":1,"key":"0000000000000001"}"#,
        br#"["1","open"]"#,
        br#"{"id":"3","command":"close","valve":3}"#,
    ];
    for monitor in [None, Some(0), Some(1)] {
        let mut bench = Bench::new(TERMS);
        for text in texts {
            let acts = bench.hear(monitor, false, text);
            assert_eq!((replies(&acts).len(), what(&acts)), (1, None), "{text:?}");
        }
    }
}

/// With its ticket a command says since when it may be under way.
#[test]
fn a_command_is_not_older_than_its_ticket() {
    let mut bench = Bench::new(TERMS);
    bench.pass(1000);
    let published = bench.now;
    let ticket = bench.ticket.unwrap();
    bench.alive(ticket);
    bench.pass(900);
    let since = |acts: &[Act]| {
        acts.iter().find_map(|act| match act {
            Act::Do { since, .. } => Some(*since),
            _ => None,
        })
    };
    let acts = bench.open();
    assert_eq!(since(&acts), Some(Some(published)));
    bench.done(&acts);
    let acts = bench.send("stop", json!({}));
    assert_eq!(since(&acts), Some(None), "a Stop is never too old");
    let acts = bench.pass(0);
    assert!(acts.iter().any(|it| matches!(it, Act::Ticket(_))), "the next command needs a new one");
    let flood = (0..100).filter(|_| {
        bench.send("stop", json!({}));
        bench.pass(0).iter().any(|it| matches!(it, Act::Ticket(_)))
    });
    assert_eq!(flood.count(), 0, "no more than ten a second");
}

/// A Stop or Close whose result comes late was sent before what is asked for meanwhile.
#[test]
fn the_late_result_of_a_stop_or_close_forgets_nothing_newer() {
    let mut bench = Bench::new(TERMS);
    let stop = bench.send("stop", json!({ "timeout_ms": 60000 }));
    let close = bench.send("close", json!({ "timeout_ms": 60000 }));
    let acts = bench.send("goto", json!({ "traverse": 10 }));
    bench.done(&acts);
    let acts = bench.open();
    bench.done(&acts);
    bench.done(&stop);
    bench.done(&close);
    let lost = bench.pass(3000);
    for act in [Act::Halt { monitor: 0, axis: 0 }, Act::Shut { monitor: 0, valve: 1 }] {
        assert!(lost.contains(&act), "{act:?}: {lost:?}");
    }
    // And an opening that is reported refused after the valve was closed is not open again.
    let acts = bench.open();
    bench.done(&acts);
    let second = bench.open();
    let close = bench.send("close", json!({}));
    bench.done(&close);
    bench.desk.answered(number(&second).unwrap(), Err(Failed::from(Refusal::Void)));
    assert!(!bench.pass(3000).iter().any(is_shut));
}
