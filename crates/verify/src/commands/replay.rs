//! Shows a monitor's life from the swarm, step by step: `cargo xtask replay`.

use std::io::{self, Write};

use clap::Args;
use lafet_proto::flags::Button;
use lafet_proto::record::Records;
use lafet_proto::text::{AnswerText, RequestText};
use lafet_sim::event::What;
use lafet_sim::fault::Post;
use lafet_sim::sim::Config;
use lafet_verify::attribution::cause;
use lafet_verify::swarm::{Entry, Log, run as live};

#[derive(Args)]
pub struct Options {
    /// Seed of the life
    seed: u64,
    /// Start of the part shown, seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0)]
    from: f64,
    /// End of the part shown, seconds (default: that of the life)
    #[arg(long, value_name = "SECONDS", default_value_t = f64::INFINITY, hide_default_value = true)]
    to: f64,
}

/// Prints the life; an error when it ends in a failure.
pub fn run(options: &Options) -> Result<(), String> {
    let mut printer = Printer {
        from_s: options.from,
        to_s: options.to,
        out: io::stdout().lock(),
        printed: Ok(()),
    };
    let outcome = live(options.seed, &mut printer);
    printer.printed.map_err(|error| format!("cannot print: {error}"))?;
    let (changes, seconds) = (outcome.tally.changes, outcome.tally.virtual_ms as f64 / 1000.0);
    println!("{seconds:.2} s simulated, {changes} output changes");
    outcome.failure.map_or(Ok(()), |violation| Err(violation.text))
}

struct Printer {
    from_s: f64,
    to_s: f64,
    out: io::StdoutLock<'static>,
    printed: io::Result<()>,
}

impl Log for Printer {
    fn note(&mut self, at_ms: u64, entry: &Entry<'_>) {
        let at_s = at_ms as f64 / 1000.0;
        let always = matches!(entry, Entry::Violation(_) | Entry::Begin { .. });
        if self.printed.is_err() || !(always || (self.from_s..=self.to_s).contains(&at_s)) {
            return;
        }
        self.printed =
            lines(entry).iter().try_for_each(|line| writeln!(self.out, "{at_s:>8.2}  {line}"));
    }
}

/// The lines of an entry. Speed changes of a moving drive are left out.
fn lines(entry: &Entry<'_>) -> Vec<String> {
    match *entry {
        Entry::Begin { config } => vec![beginning(config)],
        Entry::Frame { source, payload, answer } => {
            let mut lines = vec![format!("→ {source:?}: {}", requests(payload).join(" ; "))];
            lines.extend(answers(answer).map(|answer| format!("← {answer}")));
            lines
        }
        Entry::Garbage { len } => vec![format!("{len} bytes of noise")],
        Entry::Output { output, before, after, cause: why, anew } => {
            let steady = before != 0 && after != 0 && before.signum() == after.signum();
            if steady && !anew {
                return Vec::new();
            }
            let (from, to) = (output.words(before), output.words(after));
            vec![format!("= {} {from} → {to}: {}", output.name(), cause(why))]
        }
        Entry::Fault { fault, on } => {
            vec![format!("! {} {}", if on { "fault" } else { "repaired" }, fault.name())]
        }
        Entry::Button { post, button, pressed } => {
            vec![format!("# {}", pushed(post, button, pressed))]
        }
        Entry::Event(what) => vec![format!("* {}", event(what))],
        Entry::Violation(violation) => vec![format!("VIOLATION: {}", violation.text)],
    }
}

fn beginning(config: &Config) -> String {
    let Config { seed, composition, fires, ambient_c, wind, clock_ms, .. } = config;
    format!(
        "seed {seed}: profile {}, fires {}, air {ambient_c:.0} °C, wind {:.1} m/s, the monitor's \
         clock at {clock_ms} ms",
        composition.name,
        fires.len(),
        wind.0.hypot(wind.1)
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

fn answers(answer: &[u8]) -> impl Iterator<Item = String> {
    Records::new(answer).flatten().map(|record| AnswerText(record).to_string())
}

fn pushed(post: Post, button: Button, pressed: bool) -> String {
    let what = if pressed { "pressed" } else { "released" };
    format!("{} {} {what}", post.name(), lafet_texts::dictionary(button.text()).en)
}

fn event(what: What) -> String {
    let number = |index: usize| index + 1;
    match what {
        What::PoweredUp => "power on".into(),
        What::Reset => "program reset".into(),
        What::Crashed => "program crashed".into(),
        What::FireLit(i) => format!("fire {} burns", number(i)),
        What::FireHit(i) => format!("water on fire {}", number(i)),
        What::FireOut(i) => format!("fire {} is out", number(i)),
        What::FireReignited(i) => format!("fire {} has flared up again", number(i)),
        What::JetOn => "water at the nozzle".into(),
        What::JetOff => "no more water".into(),
        What::FoldedBarrelFlooded => "water in the stowed barrel".into(),
    }
}
