//! `lafet sim --replay SEED`: replays a monitor's life from the swarm, step by step.

use lafet_proto::flags::Button;
use lafet_proto::record::Records;
use lafet_proto::text::{AnswerText, RequestText};
use lafet_sim::attribution::{Output, cause};
use lafet_sim::event::What;
use lafet_sim::exercise::Words;
use lafet_sim::fault::Post;
use lafet_sim::sim::Config;
use lafet_sim::swarm::{Entry, LIFE_MS, Log, run};
use serde_json::{Value, json};

use crate::describe::hex;
use crate::failure::{Failure, Outcome};
use crate::lang::{of, pick};
use crate::out::Out;

/// Which part of a life to show.
pub struct Replay {
    /// Seed of the life in the swarm.
    pub seed: u64,
    /// Start of the part shown, seconds.
    pub from_s: f64,
    /// End of the part shown, seconds.
    pub to_s: f64,
}

/// Runs the life of the seed again and prints its events; fails if it ends in a failure.
pub fn replay(replay: &Replay, out: &mut Out) -> Outcome {
    let mut printer = Printer {
        from_ms: (replay.from_s * 1000.0) as u64,
        to_ms: (replay.to_s * 1000.0) as u64,
        out,
        ended: Ok(()),
    };
    let outcome = run(replay.seed, &mut printer);
    let Printer { out, ended, .. } = printer;
    ended?;
    let (changes, seconds) = (outcome.tally.changes, outcome.tally.virtual_ms as f64 / 1000.0);
    let failed = outcome.failure.is_some();
    out.show(
        pick(
            format!("{seconds:.2} s simulated, {changes} output changes"),
            format!("выполнено {seconds:.2} с, изменений выходов: {changes}"),
        ),
        || json!({ "t": seconds, "changes": changes, "failed": failed }),
    )?;
    match outcome.failure {
        None => Ok(()),
        Some(violation) => Err(Failure::Ended(pick(violation.text.en, violation.text.ru))),
    }
}

/// Longest time that `--to` accepts, s.
pub const LIFE_S: f64 = LIFE_MS as f64 / 1000.0 + 60.0;

struct Printer<'o> {
    from_ms: u64,
    to_ms: u64,
    out: &'o mut Out,
    ended: Outcome,
}

impl Log for Printer<'_> {
    fn note(&mut self, at_ms: u64, entry: &Entry<'_>) {
        let always = matches!(entry, Entry::Violation(_) | Entry::Begin { .. });
        let inside = (self.from_ms..=self.to_ms).contains(&at_ms);
        if self.ended.is_err() || !(inside || always) {
            return;
        }
        let told = self.tell(at_ms, entry);
        self.ended = told;
    }
}

impl Printer<'_> {
    fn tell(&mut self, at_ms: u64, entry: &Entry<'_>) -> Outcome {
        if self.out.json() {
            let mut json = entry_json(entry);
            json["t"] = json!(at_ms as f64 / 1000.0);
            return self.out.value(&json);
        }
        for line in lines(entry) {
            self.out.say(format!("{:>8.2}  {line}", at_ms as f64 / 1000.0))?;
        }
        Ok(())
    }
}

fn both(text: Words) -> String {
    pick(text.en, text.ru)
}

/// The lines for the user. Speed changes of a moving drive are left out.
fn lines(entry: &Entry<'_>) -> Vec<String> {
    match *entry {
        Entry::Begin { config } => vec![beginning(config)],
        Entry::Frame { source, payload, answer } => {
            let mut lines = vec![format!("→ {source:?}: {}", requests(payload).join(" ; "))];
            lines.extend(answers(answer).into_iter().map(|answer| format!("← {answer}")));
            lines
        }
        Entry::Garbage { len } => {
            vec![pick(format!("{len} bytes of noise"), format!("помехи: {len} байт"))]
        }
        Entry::Output { output, before, after, cause: why, anew } => {
            let steady = before != 0 && after != 0 && before.signum() == after.signum();
            if steady && !anew {
                return Vec::new();
            }
            let (from, to) = (words(output, before), words(output, after));
            vec![format!("= {} {from} → {to}: {}", output.name(), both(cause(why)))]
        }
        Entry::Fault { fault, on } => {
            let (what, name) = (
                if on {
                    pick("fault", "отказ")
                } else {
                    pick("repaired", "исправлен")
                },
                fault.name(),
            );
            vec![format!("! {what} {name}")]
        }
        Entry::Button { post, button, pressed } => {
            vec![format!("# {}", pushed(post, button, pressed))]
        }
        Entry::Event(what) => vec![format!("* {}", event(what))],
        Entry::Violation(violation) => {
            let mark = pick("VIOLATION", "НАРУШЕНИЕ");
            vec![format!("{mark}: {}", both(violation.text.clone()))]
        }
    }
}

fn beginning(config: &Config) -> String {
    let Config { seed, composition, fires, ambient_c, wind, clock_ms, .. } = config;
    let (name, fires) = (composition.name, fires.len());
    let wind = wind.0.hypot(wind.1);
    pick(
        format!(
            "seed {seed}: profile {name}, fires {fires}, air {ambient_c:.0} °C, wind {wind:.1} m/s, \
             the monitor's clock at {clock_ms} ms"
        ),
        format!(
            "зерно {seed}: состав {name}, очагов {fires}, воздух {ambient_c:.0} °C, ветер \
             {wind:.1} м/с, часы ствола {clock_ms} мс"
        ),
    )
}

fn requests(payload: &[u8]) -> Vec<String> {
    Records::new(payload)
        .map(|record| match record {
            Ok(record) => RequestText(record).to_string(),
            Err(error) => format!("# {error}"),
        })
        .collect()
}

fn answers(answer: &[u8]) -> Vec<String> {
    Records::new(answer).flatten().map(|record| AnswerText(record).to_string()).collect()
}

/// A value of an output, in the user's language.
fn words(output: Output, value: i16) -> String {
    let english = output.words(value);
    match english.as_str() {
        "opening" => pick(english, "открытие".into()),
        "closing" => pick(english, "закрытие".into()),
        "on" => pick(english, "вкл".into()),
        "off" => pick(english, "выкл".into()),
        _ => english,
    }
}

fn pushed(post: Post, button: Button, pressed: bool) -> String {
    let (post, button) = (post.name(), of(&button.text()));
    let what = if pressed {
        pick("pressed", "нажата")
    } else {
        pick("released", "отпущена")
    };
    format!("{post} {button} {what}")
}

fn event(what: What) -> String {
    let number = |index: usize| (index + 1).to_string();
    match what {
        What::PoweredUp => pick("power on", "питание подано").into(),
        What::Reset => pick("program reset", "программа сброшена").into(),
        What::Crashed => pick("program crashed", "аварийный сброс программы").into(),
        What::FireLit(i) => {
            pick(format!("fire {} burns", number(i)), format!("очаг {} горит", number(i)))
        }
        What::FireHit(i) => {
            pick(format!("water on fire {}", number(i)), format!("вода на очаге {}", number(i)))
        }
        What::FireOut(i) => {
            pick(format!("fire {} is out", number(i)), format!("очаг {} потушен", number(i)))
        }
        What::FireReignited(i) => pick(
            format!("fire {} has flared up again", number(i)),
            format!("очаг {} разгорелся снова", number(i)),
        ),
        What::JetOn => pick("water at the nozzle", "вода на стволе").into(),
        What::JetOff => pick("no more water", "воды нет").into(),
        What::FoldedBarrelFlooded => {
            pick("water in the folded barrel", "вода в свёрнутом стволе").into()
        }
    }
}

fn entry_json(entry: &Entry<'_>) -> Value {
    match *entry {
        Entry::Begin { config } => json!({
            "begin": config.seed,
            "profile": config.composition.name,
            "fires": config.fires.len(),
            "clock_ms": config.clock_ms,
        }),
        Entry::Frame { source, payload, answer } => json!({
            "source": format!("{source:?}"),
            "requests": requests(payload),
            "answers": answers(answer),
            "payload": hex(payload),
        }),
        Entry::Garbage { len } => json!({ "garbage_bytes": len }),
        Entry::Output { output, before, after, cause: why, .. } => json!({
            "output": output.name(),
            "before": before,
            "after": after,
            "cause": cause(why).en,
        }),
        Entry::Fault { fault, on } => json!({ "fault": fault.name(), "on": on }),
        Entry::Button { post, button, pressed } => json!({
            "post": post.name(),
            "button": button.text().en,
            "pressed": pressed,
        }),
        Entry::Event(what) => json!({ "event": format!("{what:?}") }),
        Entry::Violation(violation) => json!({
            "violation": violation.text.en,
            "unexplained": violation.unexplained,
        }),
    }
}
