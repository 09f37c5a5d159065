//! A request and its answers, as text and as JSON.

use lafet_client::Answers;
use lafet_proto::record::Writer;
use lafet_proto::text::{AnswerText, Exchange};
use lafet_proto::{Request, RequestId, SubsystemId};
use serde_json::{Value, json};

use crate::describe::hex;

/// One line per answer: `Vertical Move → Denied (Deployer)`.
pub fn text(to: SubsystemId, answers: &Answers) -> String {
    let lines = answers.iter().map(|answer| match answer.decode() {
        Ok(decoded) => Exchange { to, answer: decoded }.to_string(),
        Err(_) => AnswerText(answer.record()).to_string(),
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// What became of Stop All: its answers only where one of them is a refusal.
pub fn stop_all(answers: &Answers) -> String {
    match answers.refusal() {
        None => "Stop All → Ok".to_owned(),
        Some(_) => text(SubsystemId::ALL, answers),
    }
}

/// A request with its text, and its answers.
pub fn json(request: &Request<'_>, answers: &Answers) -> Value {
    let answers: Vec<Value> = answers
        .iter()
        .map(|answer| {
            json!({
                "from": answer.from().to_string(),
                "request": name(answer.request()),
                "status": answer.status().to_string(),
                "data": hex(answer.data()),
                "text": AnswerText(answer.record()).to_string(),
            })
        })
        .collect();
    json!({ "request": request.to_string(), "bytes": hex(&bytes(request)), "answers": answers })
}

/// A request encoded as a record.
pub fn bytes(request: &Request<'_>) -> Vec<u8> {
    let mut buffer = [0; lafet_proto::record::HEADER_SIZE + lafet_proto::record::DATA_MAX];
    let mut writer = Writer::new(&mut buffer);
    match request.encode(&mut writer) {
        Ok(()) => writer.written().to_vec(),
        Err(_) => Vec::new(),
    }
}

/// The name of a request, including those of the bus controller.
pub fn name(request: RequestId) -> String {
    lafet_proto::dictionary::request(request)
        .map_or_else(|| request.to_string(), |info| info.name.to_owned())
}
