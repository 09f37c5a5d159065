//! The playground as its page uses it: commands and answers.

mod bytes;
mod hostile;
mod replay;
mod walk;

use lafet_play::{Playground, call};
use serde_json::{Value, json};

/// The answer to a command; panics on an error.
pub fn ok(playground: &mut Playground, command: Value) -> Value {
    let mut answer = ask(playground, command);
    assert!(answer.get("error").is_none(), "{answer}");
    answer["ok"].take()
}

/// The English text of the error.
pub fn error(playground: &mut Playground, command: Value) -> String {
    let answer = ask(playground, command);
    assert!(!answer["error"]["ru"].as_str().unwrap().is_empty());
    answer["error"]["en"].as_str().unwrap().to_owned()
}

fn ask(playground: &mut Playground, command: Value) -> Value {
    serde_json::from_slice(&call(playground, command.to_string().as_bytes())).unwrap()
}

/// Sends requests over the wired interface; the entry.
pub fn send(playground: &mut Playground, text: &str) -> Value {
    let input = json!({ "bytes": false, "text": text });
    let act = json!({ "kind": "send", "link": "wired", "input": input });
    let mut view = ok(playground, json!({ "op": "act", "act": act }));
    view["entries"][0].take()
}

/// So many seconds later.
pub fn later(playground: &mut Playground, seconds: u32) -> Value {
    for _ in 0..seconds {
        playground.advance(1_000);
    }
    ok(playground, json!({ "op": "advance", "ms": 0, "since": 0 }))
}
