//! `lafet send`: any requests, as text or in hexadecimal.

use std::io::{self, BufRead};

use clap::Args;
use lafet_client::Answers;
use lafet_proto::record::Records;
use lafet_proto::request::Body;
use lafet_proto::text::{BUFFER_SIZE, parse};
use lafet_proto::{Record, Request};

use crate::cli::Global;
use crate::connect::Connection;
use crate::exchange;
use crate::failure::{Failure, Outcome, refusal};
use crate::lang::pick;
use crate::out::Out;
use crate::texts;

/// `lafet send`
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 send Move Vertical 1200\n  \
                        lafet -c tcp://127.0.0.1:10485 send \"Open Valve1\" \"GetStatus Valve1\"\n  \
                        lafet -c tcp://127.0.0.1:10485 send 9dc80002fe23\n  \
                        lafet -c tcp://127.0.0.1:10485 send - < requests.txt")]
pub struct SendArgs {
    /// Requests as text, each in quotes, or one without; or records in hexadecimal; - reads lines
    /// from standard input. Several go out in one frame
    #[arg(
        value_name = "REQUEST",
        required = true,
        trailing_var_arg = true,
        allow_hyphen_values = true
    )]
    requests: Vec<String>,
}

/// Sends them and shows the answers.
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
    let connection = Connection::open(global).await?;
    let results = connection.client.batch(&requests).await;
    let (mut refused, mut count) = (None, 0);
    for (request, result) in requests.iter().zip(results) {
        let answers = result?;
        out.show(exchange::text(request.to, &answers), || exchange::json(request, &answers))?;
        if let Some(error) = first_refusal(request, &answers) {
            count += 1;
            refused.get_or_insert(error);
        }
    }
    match refused {
        Some(first) => Err(Failure::Refused { first, count }),
        None => Ok(()),
    }
}

fn first_refusal(request: &Request<'_>, answers: &Answers) -> Option<lafet_client::Error> {
    let answer = answers.refusal()?;
    Some(refusal(request.body.id(), request.to, answer.status(), answer.from()))
}

/// The requests that the arguments spell: all of them one, if that makes sense, else one each.
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

/// The bytes of a text that is nothing but hexadecimal, at least a record's header long.
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

/// The requests that these bytes are; those that make no sense go out as they are.
fn records<'a>(text: &str, bytes: &'a [u8]) -> Result<Vec<Request<'a>>, Failure> {
    let request = |record: Record<'a>| {
        let Record { request, device, data, .. } = record;
        Request::decode(&record).unwrap_or(Request::new(device, Body::Unknown { request, data }))
    };
    let records: Result<Vec<Record<'a>>, _> = Records::new(bytes).collect();
    let records = records.map_err(|error| {
        let reason = texts::decode_error(&error);
        Failure::Usage(pick(
            format!("`{text}` is no sequence of records: {reason}"),
            format!("`{text}` — не последовательность записей: {reason}"),
        ))
    })?;
    Ok(records.into_iter().map(request).collect())
}

#[cfg(test)]
mod tests {
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
}
