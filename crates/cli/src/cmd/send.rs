//! `lafet send`: any requests, as text or in hexadecimal.

use std::io::{self, BufRead};

use clap::Args;
use lafet_client::Answers;
use lafet_proto::record::Records;
use lafet_proto::request::Body;
use lafet_proto::text::{BUFFER_SIZE, parse};
use lafet_proto::{Record, Request};
use lafet_texts::{Text as _, cli as text};

use crate::cli::Global;
use crate::connect::Connection;
use crate::exchange;
use crate::failure::{Failure, Outcome, refusal};
use crate::interrupt::Interrupt;
use crate::lang::current;
use crate::out::Out;
use crate::texts;
use crate::undo::{Because, Undo};

/// Arguments of `lafet send`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 send Move Vertical 1200\n  \
                        lafet -c tcp://127.0.0.1:10485 send \"Open Valve1\" \"GetStatus Valve1\"\n  \
                        lafet -c tcp://127.0.0.1:10485 send 9dc80002fe23\n  \
                        lafet -c tcp://127.0.0.1:10485 send - < requests.txt")]
pub struct SendArgs {
    #[arg(
        value_name = "REQUEST",
        required = true,
        trailing_var_arg = true,
        allow_hyphen_values = true
    )]
    requests: Vec<String>,
}

/// Runs `lafet send`: sends the requests and shows the answers.
pub async fn run(args: SendArgs, global: &Global, out: &mut Out) -> Outcome {
    let texts = texts(args.requests)?;
    let mut buffers = vec![[0; BUFFER_SIZE]; texts.len()];
    let mut raw = Vec::new();
    for text in &texts {
        raw.push(hexadecimal(text));
    }
    let mut requests = Vec::new();
    for ((text, raw), buffer) in texts.iter().zip(&raw).zip(&mut buffers) {
        match raw {
            Some(bytes) => requests.extend(records(text, bytes)?),
            None => requests.push(
                parse(text, buffer)
                    .map_err(|error| Failure::Usage(texts::parse_error(text, &error)))?,
            ),
        }
    }
    let connection = Connection::open_for(global, &requests).await?;
    let (mut refused, mut count) = (None, 0);
    for (request, result) in requests.iter().zip(exchanged(&requests, &connection, out).await?) {
        let answers = result?;
        out.show(exchange::text(request.to, &answers), || exchange::json(request, &answers))?;
        if let Some(answer) = answers.refusal() {
            count += 1;
            let error = refusal(request.body.id(), request.to, answer.status(), answer.from());
            if refused.is_none() {
                refused = Some((error, Box::new(connection.refused(request, answer).await)));
            }
        }
    }
    match refused {
        Some((first, asked)) => Err(Failure::Refused { first, asked, count }),
        None => Ok(()),
    }
}

/// Sends the requests. On an interrupt or a lost answer, undoes what may have been started.
async fn exchanged(
    requests: &[Request<'_>],
    connection: &Connection,
    out: &mut Out,
) -> Result<Vec<Result<Answers, lafet_client::Error>>, Failure> {
    let mut interrupt = Interrupt::catch()?;
    let undo = |which: &dyn Fn(usize) -> bool| {
        let started = requests.iter().enumerate().filter(|(index, _)| which(*index));
        started.filter_map(|(_, request)| Undo::of(request)).reduce(Undo::and)
    };
    let (undo, because) = tokio::select! {
        results = connection.client.batch(requests) => {
            let unknown = |index: usize| {
                let error = results.get(index)?.as_ref().err()?;
                Some(Undo::of(requests.get(index)?)?.is_needed_after(error))
            };
            let undo = undo(&|index| unknown(index).unwrap_or(false));
            let first = results.iter().find_map(|result| result.as_ref().err());
            match (undo, first) {
                (Some(undo), Some(error)) => (undo, Because::Lost(error.clone())),
                _ => return Ok(results),
            }
        }
        () = interrupt.wait() => match undo(&|_| true) {
            Some(undo) => (undo, Because::Interrupted),
            None => return Err(Failure::Interrupted),
        },
    };
    Err(undo.carry_out(connection, out, &mut interrupt, because).await)
}

/// The requests that the arguments spell: a single one if all of them parse as one, else one each.
fn texts(arguments: Vec<String>) -> Result<Vec<String>, Failure> {
    if arguments == ["-"] {
        let lines: Vec<String> = io::stdin().lock().lines().collect::<Result<_, _>>()?;
        let wanted = |line: &String| {
            let text = line.split('#').next().unwrap_or_default();
            !text.trim().is_empty()
        };
        return Ok(lines.into_iter().filter(wanted).collect());
    }
    let joined = arguments.join(" ");
    let alone = arguments.len() == 1 || arguments.iter().any(|one| one.contains(' '));
    let together = !alone
        && (parse(&joined, &mut [0; BUFFER_SIZE]).is_ok()
            || hexadecimal(&joined).is_some()
            || arguments.iter().any(|one| !stands_alone(one)));
    Ok(if together { vec![joined] } else { arguments })
}

fn stands_alone(text: &str) -> bool {
    hexadecimal(text).is_some() || parse(text, &mut [0; BUFFER_SIZE]).is_ok()
}

/// The bytes of a text that is entirely hexadecimal and at least as long as a record header.
fn hexadecimal(text: &str) -> Option<Vec<u8>> {
    let digits: String = text.split_whitespace().collect();
    let (pairs, []) = digits.as_bytes().as_chunks::<2>() else { return None };
    let byte = |pair: &[u8; 2]| {
        let digits = std::str::from_utf8(pair).ok()?;
        u8::from_str_radix(digits, 16).ok()
    };
    let whole = digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    (whole && pairs.len() >= 4).then(|| pairs.iter().filter_map(byte).collect())
}

/// The requests in these bytes; invalid ones are sent as they are.
fn records<'a>(text: &str, bytes: &'a [u8]) -> Result<Vec<Request<'a>>, Failure> {
    let request = |record: Record<'a>| {
        let Record { request, device, data, .. } = record;
        Request::decode(&record).unwrap_or(Request::new(device, Body::Unknown { request, data }))
    };
    let records: Result<Vec<Record<'a>>, _> = Records::new(bytes).collect();
    let records = records.map_err(|error| {
        let reason = texts::decode_error(&error);
        Failure::Usage(text::NotRecords { text, reason }.of(current()))
    })?;
    Ok(records.into_iter().map(request).collect())
}

#[cfg(test)]
mod tests {
    use std::sync::LazyLock;

    use super::*;

    fn spelt(arguments: &[&str]) -> Vec<String> {
        texts(arguments.iter().map(|one| (*one).to_owned()).collect()).unwrap()
    }

    #[test]
    fn arguments_are_one_request_or_several() {
        assert_eq!(spelt(&["Move", "Vertical", "-900"]), ["Move Vertical -900"]);
        assert_eq!(spelt(&["Move Vertical 1", "Stop All"]), ["Move Vertical 1", "Stop All"]);
        assert_eq!(spelt(&["Deploy", "Wrap"]), ["Deploy", "Wrap"]);
        assert_eq!(spelt(&["9d", "c8", "00", "02", "fe", "23"]), ["9d c8 00 02 fe 23"]);
        assert_eq!(spelt(&["9dc80002fe23", "465d0000"]).len(), 1);
        assert_eq!(spelt(&["Opn", "Valve1"]), ["Opn Valve1"]);
    }

    #[test]
    fn records_in_hexadecimal() {
        let bytes = hexadecimal("9dc8 0002 fe23 465d 0000").unwrap();
        let requests = records("", &bytes).unwrap();
        let texts: Vec<String> = requests.iter().map(ToString::to_string).collect();
        assert_eq!(texts, ["GetParam Detector Hotbeds", "Stop All"]);
        assert_eq!(hexadecimal("Stop All"), None);
        assert_eq!(hexadecimal("9dc"), None);
        assert!(records("", &hexadecimal("9dc80003fe23").unwrap()).is_err());
        let odd = hexadecimal("4d0d000101").unwrap();
        let odd = records("", &odd).unwrap();
        assert!(matches!(odd[..], [Request { body: Body::Unknown { .. }, .. }]));
    }

    /// The page that describes the grammar.
    static PAGE: LazyLock<String> = LazyLock::new(|| {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/send.md");
        std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{path}: {error}"))
    });

    /// Lines of the named block of the page that describes the grammar.
    fn block(name: &str) -> impl Iterator<Item = &'static str> {
        let start = format!("```{name}\n");
        let (_, rest) = PAGE.split_once(start.as_str()).expect("the page has the block");
        rest.split_once("\n```").expect("it ends").0.lines()
    }

    /// Whether `lafet send` takes these arguments, those with blanks in quotes.
    fn is_read(arguments: &str) -> bool {
        let split = |(index, part): (usize, &str)| match index % 2 {
            0 => part.split_whitespace().map(str::to_owned).collect(),
            _ => vec![part.to_owned()],
        };
        let arguments: Vec<String> = arguments.split('"').enumerate().flat_map(split).collect();
        texts(arguments).unwrap().iter().all(|text| match hexadecimal(text) {
            Some(bytes) => records(text, &bytes).is_ok_and(|records| !records.is_empty()),
            None => parse(text, &mut [0; BUFFER_SIZE]).is_ok(),
        })
    }

    /// The table names every rule of the grammar, and no other.
    #[test]
    fn each_rule_of_the_grammar_is_kept_and_can_be_broken() {
        let rule = |line: &'static str| {
            let (name, _) = line.split_once('=')?;
            let name = name.trim_end();
            let named = !name.is_empty() && name.bytes().all(|byte| byte.is_ascii_lowercase());
            named.then_some(name)
        };
        let mut rules: Vec<&str> = block("ebnf").filter_map(rule).collect();
        let mut shown = Vec::new();
        let (_, table) = PAGE.split_once("| rule |").expect("the page has the table");
        for row in table.lines().skip(2).take_while(|line| line.starts_with('|')) {
            let cells: Vec<&str> = row.split('`').skip(1).step_by(2).collect();
            let [name, good, bad] = cells[..] else { panic!("{row}") };
            assert!(is_read(good), "{good}");
            assert!(!is_read(bad), "{bad}");
            shown.push(name);
        }
        shown.dedup();
        rules.sort_unstable();
        shown.sort_unstable();
        assert_eq!(shown, rules);
    }

    #[test]
    fn the_examples_of_the_page_are_read_and_the_others_are_not() {
        let mut count = 0;
        for text in block("send") {
            if let Some(bytes) = hexadecimal(text) {
                assert!(!records(text, &bytes).unwrap().is_empty(), "{text}");
            } else {
                let (mut first, mut again) = ([0; BUFFER_SIZE], [0; BUFFER_SIZE]);
                let request = parse(text, &mut first).unwrap_or_else(|e| panic!("{text}: {e}"));
                let told = request.to_string();
                let second = parse(&told, &mut again).unwrap_or_else(|e| panic!("{told}: {e}"));
                assert_eq!(exchange::bytes(&request), exchange::bytes(&second), "{text}");
            }
            count += 1;
        }
        // Every request of the protocol has an example.
        for info in &lafet_proto::dictionary::REQUESTS {
            let has = |line: &str| line.to_lowercase().starts_with(&info.name.to_lowercase());
            let service = ["AccessGranted", "GetNetworkStatus", "GetHotbed"].contains(&info.name);
            assert!(service || block("send").any(has), "{}", info.name);
        }
        for text in block("refused") {
            let read = match hexadecimal(text) {
                Some(bytes) => records(text, &bytes).is_ok(),
                None => parse(text, &mut [0; BUFFER_SIZE]).is_ok(),
            };
            assert!(!read, "{text}");
            count += 1;
        }
        assert!(count >= 50, "{count}");
    }
}
