//! What hosts write to the metrics of commands.

use super::metrics::REBIRTH;
use super::node::row_of;
use super::payload::{self, Metric, Value};
use crate::plugs::mqtt::message::{self, Asked};
use crate::plugs::orders::Command;
use crate::plugs::refusal::Refusal;

/// Writes of one message that are looked at, and the others have one result; Stop, Close and Lockout are among any number.
const WRITES_MAX: usize = 16;

/// A write.
#[derive(Clone, Debug, PartialEq)]
pub enum Write {
    /// All births are to come again.
    Rebirth,
    /// A sign of life: a ticket, if it can be read.
    Alive(Option<u64>),
    /// A command.
    Asked {
        /// What is asked for.
        asked: Asked,
        /// It is said to be from before.
        is_old: bool,
    },
}

/// The writes of a message to the node, or to a device by its place.
pub fn read(device: Option<usize>, bytes: &[u8]) -> Vec<Write> {
    let wrong = || Write::Asked { asked: Asked::wrong(None, None, Refusal::Form), is_old: false };
    let metrics = payload::read(bytes).map(|it| it.metrics).unwrap_or_default();
    if metrics.is_empty() {
        return vec![wrong()];
    }
    let (mut writes, mut urgent, mut others) = (Vec::new(), Vec::new(), false);
    for (number, metric) in metrics.iter().enumerate() {
        let is_old = metric.is_historical == Some(true);
        let name = row_of(device, metric);
        let write = match (name, name.and_then(urgent_of)) {
            (_, Some(command)) => match is_set(metric) {
                Some(true) if !urgent.contains(&command) => {
                    urgent.push(command);
                    writes.push(Write::Asked { asked: Asked::urgent(command), is_old });
                    None
                }
                Some(_) => None,
                None => Some(wrong()),
            },
            (Some(REBIRTH), None) => match is_set(metric) {
                Some(is_set) => (is_set && !is_old).then_some(Write::Rebirth),
                None => Some(wrong()),
            },
            (Some("Alive"), None) => {
                let ticket = text(metric).and_then(message::number).filter(|_| !is_old);
                Some(Write::Alive(ticket))
            }
            (Some("Command/Text"), None) => match text(metric) {
                Some(text) => Some(Write::Asked { asked: message::read(text.as_bytes()), is_old }),
                None => Some(wrong()),
            },
            _ => Some(wrong()),
        };
        match write {
            Some(write) if number < WRITES_MAX => writes.push(write),
            Some(_) => others = true,
            None => {}
        }
    }
    writes.extend(others.then(wrong));
    writes
}

/// Which of the commands that are always taken it is.
fn urgent_of(name: &str) -> Option<Command> {
    match name {
        "Command/Stop" => Some(Command::Stop),
        "Command/Close" => Some(Command::Close),
        "Command/Lockout" => Some(Command::Lockout),
        _ => None,
    }
}

/// Whether it is set; hosts write true, or a number. `None`: it is neither.
fn is_set(metric: &Metric) -> Option<bool> {
    match metric.value {
        Some(Value::Boolean(set)) => Some(set),
        Some(Value::Int(number)) => Some(number != 0),
        Some(Value::Long(number)) => Some(number != 0),
        Some(Value::Float(number)) => Some(number != 0.0),
        Some(Value::Double(number)) => Some(number != 0.0),
        Some(Value::Text(_)) | None => None,
    }
}

fn text(metric: &Metric) -> Option<&str> {
    match &metric.value {
        Some(Value::Text(text)) => Some(text),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use prost::Message as _;

    use super::super::metrics::{DEVICE, STRIDE};
    use super::super::payload::Payload;
    use super::*;
    use crate::plugs::orders::What;

    fn named(name: &str, value: Value) -> Metric {
        Metric { name: Some(name.to_owned()), value: Some(value), ..Metric::default() }
    }

    fn bytes(metrics: Vec<Metric>) -> Vec<u8> {
        Payload { metrics, ..Payload::default() }.encode_to_vec()
    }

    fn whats(writes: &[Write]) -> Vec<Result<What, Refusal>> {
        let what = |it: &Write| match it {
            Write::Asked { asked, .. } => Some(asked.what),
            _ => None,
        };
        writes.iter().filter_map(what).collect()
    }

    #[test]
    fn stop_close_and_lockout_are_one_write_each_among_any_number() {
        let mut metrics = vec![named("nothing", Value::Int(1)); 60];
        metrics.extend((0..20).map(|_| named("Command/Stop", Value::Boolean(true))));
        metrics.push(named("Command/Close", Value::Int(1)));
        metrics.push(named("Command/Lockout", Value::Long(1)));
        for device in [None, Some(0), Some(usize::MAX)] {
            let all = whats(&read(device, &bytes(metrics.clone())));
            let good: Vec<What> = all.iter().filter_map(|it| it.ok()).collect();
            assert_eq!(good, [What::Stop, What::Close(0), What::Lockout], "{device:?}");
            assert_eq!(all.len(), WRITES_MAX + 3 + 1, "and one for the others");
        }
        for (value, result) in [
            (Some(Value::Float(1.0)), Ok(What::Stop)),
            (Some(Value::Double(-1.0)), Ok(What::Stop)),
            (Some(Value::Text("true".into())), Err(Refusal::Form)),
            (None, Err(Refusal::Form)),
        ] {
            let name = Some("Command/Stop".to_owned());
            let stop = vec![Metric { name, value: value.clone(), ..Metric::default() }];
            assert_eq!(whats(&read(Some(0), &bytes(stop))), [result], "{value:?}");
        }
        let reset = vec![named("Command/Stop", Value::Boolean(false))];
        assert_eq!(read(Some(0), &bytes(reset)), [], "a host that takes its button back");
    }

    #[test]
    fn a_metric_is_known_by_its_name_or_by_its_alias_in_its_device() {
        let stop = DEVICE.iter().position(|it| it.name == "Command/Stop").unwrap() as u64;
        let by_alias = |alias: u64| {
            let value = Some(Value::Boolean(true));
            bytes(vec![Metric { alias: Some(alias), value, ..Metric::default() }])
        };
        let of_second = by_alias(2 * STRIDE + stop);
        assert_eq!(whats(&read(Some(1), &of_second)), [Ok(What::Stop)]);
        for device in [None, Some(0), Some(usize::MAX)] {
            assert_eq!(whats(&read(device, &of_second)), [Err(Refusal::Form)], "{device:?}");
        }
        assert_eq!(whats(&read(Some(0), &by_alias(u64::MAX))), [Err(Refusal::Form)]);
    }

    #[test]
    fn what_cannot_be_written_is_refused_and_never_lost() {
        let long = "x".repeat(payload::PAYLOAD_MAX);
        for wrong in [
            Vec::new(),
            vec![0xFF; 40],
            bytes(vec![named("Pressure", Value::Double(1.0))]),
            bytes(vec![named("Command/Text", Value::Int(1))]),
            bytes(vec![named("Command/Text", Value::Text("open".into()))]),
            bytes(vec![named("Command/Text", Value::Text(long))]),
            bytes(vec![named(REBIRTH, Value::Boolean(true))]),
            bytes(vec![named("Alive", Value::Text("00000000000000ff".into()))]),
        ] {
            let writes = read(Some(0), &wrong);
            assert_eq!(whats(&writes), [Err(Refusal::Form)], "{wrong:?}");
        }
    }

    #[test]
    fn the_node_takes_signs_of_life_and_asks_for_births() {
        let both = bytes(vec![
            named("Alive", Value::Text("00000000000000ff".into())),
            named(REBIRTH, Value::Boolean(true)),
        ]);
        assert_eq!(read(None, &both), [Write::Alive(Some(255)), Write::Rebirth]);
        let old = Metric {
            is_historical: Some(true),
            ..named("Alive", Value::Text("00000000000000ff".into()))
        };
        assert_eq!(read(None, &bytes(vec![old])), [Write::Alive(None)]);
    }
}
