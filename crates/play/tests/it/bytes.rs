//! The bytes are those of the golden vectors, and each of them has its name.

use lafet_play::Playground;
use serde_json::{Value, json};

use crate::ok;

fn vectors(file: &str) -> Value {
    let path = format!("{}/../../conformance/vectors/{file}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn read(bytes: bool, text: &str) -> Value {
    let input = json!({ "bytes": bytes, "text": text });
    ok(&mut Playground::default(), json!({ "op": "read", "input": input }))
}

/// Parts follow each other without a gap, from the first byte to the last.
fn covers(anatomy: &Value, case: &str) {
    let mut at = 0;
    for part in anatomy["parts"].as_array().unwrap() {
        assert_eq!(part["at"], at, "{case}: {part}");
        at += part["len"].as_u64().unwrap();
        assert!(
            !part["name"].as_str().unwrap().is_empty() && part["meaning"]["ru"] != "",
            "{case}: {part}"
        );
    }
    assert_eq!(at as usize, anatomy["bytes"].as_array().unwrap().len(), "{case}");
}

fn hex(anatomy: &Value) -> String {
    let bytes = anatomy["bytes"].as_array().unwrap().iter();
    bytes.map(|byte| format!("{:02x}", byte.as_u64().unwrap())).collect::<Vec<_>>().join(" ")
}

/// The text of each golden request becomes its golden bytes, and every field of it has a name.
#[test]
fn texts_become_the_golden_bytes() {
    let all = vectors("requests");
    let (mut count, mut moves) = (0, 0);
    for vector in all["requests"].as_array().unwrap() {
        let (Some(text), Some(bytes)) = (vector["text"].as_str(), vector["bytes"].as_str()) else {
            continue;
        };
        let shown = read(false, text);
        covers(&shown, text);
        let by_bytes = read(true, bytes);
        assert_eq!(shown, by_bytes, "{text}");
        let plain = hex(&shown);
        // A byte that is escaped on the wire is not in the vector like this.
        if !plain.contains("db") {
            assert!(plain.contains(bytes), "{text}: {plain} has not {bytes}");
        }
        count += 1;
        if let Some(destination) = vector["fields"]["destination"].as_i64() {
            let parts = shown["parts"].as_array().unwrap();
            let part = parts.iter().find(|it| it["name"] == "destination").unwrap();
            let value = part["value"]["en"].as_str().unwrap().replace('−', "-");
            assert!(value.starts_with(&destination.to_string()), "{text}: {value}");
            moves += 1;
        }
    }
    assert!(count > 40 && moves > 3, "{count} vectors, {moves} of Move");
}

/// Frames of every kind, escaped bytes and the longer checksum among them.
#[test]
fn golden_frames_are_covered() {
    let all = vectors("link");
    let mut escaped = 0;
    for frame in all["frames"].as_array().unwrap() {
        let wire = frame["wire"].as_str().unwrap();
        let shown = read(true, wire);
        covers(&shown, wire);
        assert_eq!(hex(&shown), wire.to_lowercase());
        escaped += usize::from(shown["parts"].to_string().contains("sent as two"));
    }
    assert!(escaped > 0, "no frame has an escaped byte");
}
