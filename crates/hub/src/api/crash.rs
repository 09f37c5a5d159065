//! Crash data in words (§3.20).

use lafet_proto::crash::FaultBit;
use lafet_proto::status::{FaultArch, FaultInfo};
use serde_json::{Value, json};

use crate::text::Both;

/// Crash data as JSON: the words, the bits that are set, what the processor was at.
pub fn json(info: &FaultInfo) -> Value {
    let filled = *info != FaultInfo::NONE;
    let words: Vec<_> = info.registers().collect();
    let bits: Vec<Value> = info.bits().map(bit).collect();
    let unknown = info.unknown_bits().into_iter().filter(|(_, bits)| *bits != 0);
    let unknown: Vec<Value> =
        unknown.map(|(register, bits)| json!({ "register": register, "bits": bits })).collect();
    let cortex = matches!(info.arch, FaultArch::CortexM3(_));
    let notes: Vec<Value> = words
        .iter()
        .filter_map(|(name, _)| {
            Some(json!({ "register": name, "text": Both::from(info.note(name)?) }))
        })
        .collect();
    let context = info.context();
    let summary = info.summary().map(Both::from);
    let running =
        filled.then(|| json!({ "what": Both::from(context.text()), "number": context.number() }));
    json!({
        "filled": filled, "processor": if cortex { "Cortex-M3" } else { "ARM7TDMI" },
        "words": words, "bits": bits, "unknown": unknown, "notes": notes,
        "running": running, "summary": summary,
    })
}

fn bit(bit: &FaultBit) -> Value {
    json!({
        "register": bit.register, "bit": bit.bit, "name": bit.name,
        "meaning": Both::from(bit.meaning), "remedy": Both::from(bit.remedy),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn registers_are_told_bit_by_bit_in_both_languages() {
        let mut words = [0x0800_1234; 20];
        (words[14], words[17], words[19]) = (1 << 30, 1 << 9 | 1 << 15, 0x0100_001B);
        let json = super::json(&FaultInfo::from_words(words));
        let names: Vec<&str> = json["bits"]
            .as_array()
            .unwrap()
            .iter()
            .map(|it| it["name"].as_str().unwrap())
            .collect();
        assert_eq!(names, ["FORCED", "PRECISERR", "BFARVALID"]);
        assert!(json["bits"][1]["meaning"]["ru"].as_str().unwrap().len() > 10, "{json}");
        assert_eq!((&json["filled"], &json["running"]["number"]), (&json!(true), &json!(11)));
        let notes = json["notes"].to_string();
        assert!(notes.contains("mmfar") && !notes.contains("bfar"), "{notes}");
        assert_eq!(json["summary"], Value::Null);
        let none = super::json(&FaultInfo::NONE);
        assert_eq!((&none["filled"], &none["running"]), (&json!(false), &Value::Null));
    }
}
