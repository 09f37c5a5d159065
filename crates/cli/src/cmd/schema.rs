//! `lafet schema`: the protocol dictionary or the description of the hub's API, as JSON for other
//! tools.

use std::collections::BTreeMap;

use clap::Args;
use lafet_proto::dictionary::layouts::{self, Field, Layout};
use lafet_proto::dictionary::{Key, Origin, REQUESTS, STATUSES, SUBSYSTEMS};
use lafet_proto::flags::{ButtonState, FlagClass, FlagInfo, Severity, flags_of};
use lafet_proto::id::key;
use lafet_proto::param::{Access, Effect, Element, Param, Placement, Storage};
use lafet_proto::{RequestId, SubsystemId};
use lafet_texts::{Fixed, Lang};
use serde_json::{Map, Value, json};

use crate::failure::Outcome;
use crate::out::Out;

/// Arguments of `lafet schema`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet schema > lafet.json\n  \
                        lafet schema --pretty\n  \
                        lafet schema --hub > openapi.json")]
pub struct SchemaArgs {
    #[arg(long)]
    hub: bool,
    #[arg(long)]
    pretty: bool,
}

/// Runs `lafet schema`.
pub fn run(args: &SchemaArgs, out: &mut Out) -> Outcome {
    let schema = if args.hub { lafet_hub::description() } else { schema() };
    let pretty = args.pretty && !out.json();
    let text = if pretty { format!("{schema:#}") } else { schema.to_string() };
    out.show(text, || schema)
}

/// The whole dictionary as JSON.
pub fn schema() -> Value {
    json!({
        "protocol": {
            "name": "lafet",
            "version": env!("CARGO_PKG_VERSION"),
            "byte_order": "little-endian",
            "header": ["request_id", "device_id", "status", "data_size"],
            "keys": {
                "Open": key::OPEN,
                "Close": key::CLOSE,
                "CleanFlash": key::CLEAN_FLASH,
                "LockoutOn": key::ENABLE,
                "LockoutOff": key::DISABLE,
            },
            "link": {
                "payload_max": lafet_proto::link::PAYLOAD_MAX,
                "port_external_conn": lafet_proto::bus::PORT_EXTERNAL_CONN,
                "port_radio": lafet_proto::bus::PORT_RADIO,
                "baud_default": lafet_proto::bus::BAUD_DEFAULT,
            },
            "chain": SubsystemId::CHAIN.map(|id| id.to_string()),
        },
        "subsystems": subsystems(),
        "requests": requests(),
        "answers": answers(),
        "statuses": statuses(),
        "severities": Severity::ALL.map(|severity| text(severity.text())),
        "button_states": ButtonState::ALL.map(|state| {
            json!({ "name": format!("{state:?}"), "value": state as u8, "text": text(state.text()) })
        }),
        "flags": flags(),
        "params": params(),
    })
}

/// The words of a text in every language; empty where there is none.
fn text(key: impl Into<Option<Key>>) -> Value {
    let words = key.into().map_or(Fixed::same(""), lafet_texts::dictionary);
    let of = |lang: Lang| (lang.code().to_owned(), Value::from(words.str(lang)));
    Value::Object(Lang::ALL.into_iter().map(of).collect())
}

fn subsystems() -> Vec<Value> {
    let one = |info: &lafet_proto::dictionary::SubsystemInfo| {
        json!({
            "name": info.name,
            "id": info.id.0,
            "en": lafet_texts::dictionary(info.title).en,
            "ru": lafet_texts::dictionary(info.title).ru,
            "meaning": text(info.meaning),
            "flags": class_of(info.id).map(|class| class.name),
        })
    };
    SUBSYSTEMS.iter().map(one).collect()
}

/// Flag class of a subsystem; `None` for All and Motors, which have no state.
fn class_of(id: SubsystemId) -> Option<&'static FlagClass> {
    SubsystemId::TABLE.contains(&id).then(|| flags_of(id))
}

fn requests() -> Vec<Value> {
    let one = |info: &lafet_proto::dictionary::RequestInfo| {
        let origin = match info.origin {
            Origin::Read => "read",
            Origin::Observed => "observed",
            Origin::Ours => "ours",
        };
        json!({
            "name": info.name,
            "id": info.id.0,
            "section": info.section,
            "origin": origin,
            "addressees": info.addressees.iter().map(ToString::to_string).collect::<Vec<_>>(),
            "title": text(info.title),
            "meaning": text(info.meaning),
            "data": layouts::of_request(info.id).iter().map(layout).collect::<Vec<_>>(),
        })
    };
    REQUESTS.iter().map(one).collect()
}

/// Layouts of answer data: of GetStatus by subsystem, of other requests by request.
fn answers() -> Value {
    let all = |layouts: &[Layout]| Value::from(layouts.iter().map(layout).collect::<Vec<_>>());
    let states = SubsystemId::TABLE
        .iter()
        .map(|id| (id.to_string(), all(layouts::of_answer(RequestId::GET_STATUS, *id))));
    let others =
        REQUESTS.iter().filter(|info| info.id != RequestId::GET_STATUS).filter_map(|info| {
            let layouts = layouts::of_answer(info.id, SubsystemId::GENERAL);
            (!layouts.is_empty()).then(|| (info.name.to_owned(), all(layouts)))
        });
    let states: Map<_, _> = states.collect();
    let mut answers: Map<_, _> = others.collect();
    answers.insert("GetStatus".into(), states.into());
    answers.into()
}

fn layout(layout: &Layout) -> Value {
    let field = |field: &Field| {
        json!({
            "name": field.name,
            "type": format!("{:?}", field.kind),
            "unit": text(field.unit.name()),
            "text": text(field.text),
        })
    };
    let (least, most) = layout.times;
    json!({
        "name": layout.name,
        "fields": layout.fields.iter().map(field).collect::<Vec<_>>(),
        "repeated": layout.repeated.iter().map(field).collect::<Vec<_>>(),
        "least": least,
        "most": (most < usize::MAX).then_some(most),
        "prefix": layout.prefix,
    })
}

fn statuses() -> Vec<Value> {
    let one = |info: &lafet_proto::dictionary::StatusInfo| {
        json!({
            "name": info.name,
            "value": info.status.0,
            "success": info.status.is_success(),
            "meaning": text(info.meaning),
            "remedy": text(info.remedy),
        })
    };
    STATUSES.iter().map(one).collect()
}

/// The flags of each class, by class name; `flags` of a subsystem names its class.
fn flags() -> Value {
    let classes: BTreeMap<&str, &FlagClass> = SubsystemId::TABLE
        .iter()
        .map(|id| flags_of(*id))
        .map(|class| (class.name, class))
        .collect();
    let one = |info: &FlagInfo| {
        json!({
            "name": info.name,
            "bit": info.shift,
            "shift": info.shift,
            "width": info.width,
            "severity": lafet_texts::dictionary(info.severity.text()).en,
            "meaning": text(info.meaning),
            "cause": text(info.cause),
            "remedy": text(info.remedy),
        })
    };
    let list = |class: &FlagClass| Value::Array(class.flags.iter().map(one).collect());
    let all = classes.into_iter().map(|(name, class)| (name.to_owned(), list(class)));
    Value::Object(all.collect::<Map<_, _>>())
}

fn params() -> Vec<Value> {
    let element =
        |one: &Element| json!({ "unit": text(one.unit.name()), "min": one.min, "max": one.max });
    let one = |param: Param| {
        let spec = param.spec();
        json!({
            "subsystem": spec.subsystem.to_string(),
            "name": param.name(),
            "id": spec.id.0,
            "unit": text(spec.unit.name()),
            "quantity": format!("{:?}", spec.unit),
            "min": spec.min,
            "max": spec.max,
            "default": spec.default,
            "len": { "min": spec.min_len, "max": spec.max_len, "step": spec.step_len },
            "elements": spec.elements.iter().map(element).collect::<Vec<_>>(),
            "access": match spec.access {
                Access::ReadOnly => "read-only",
                Access::ReadWrite => "read-write",
            },
            "effect": match spec.effect {
                Effect::AtOnce => "at-once",
                Effect::Restart => "after-restart",
            },
            "storage": match spec.storage {
                Storage::Volatile => "volatile",
                Storage::Stored => "stored",
            },
            "placement": match spec.placement {
                Placement::Local => "local",
                Placement::Unit => "unit",
            },
            "required": spec.required,
            "text": text(param.text()),
        })
    };
    Param::ALL.into_iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_dictionary_is_whole() {
        let schema = schema();
        let len = |name: &str| schema[name].as_array().map_or(0, Vec::len);
        assert_eq!(len("subsystems"), 16);
        assert_eq!(len("requests"), 24);
        assert_eq!(len("statuses"), 19);
        assert_eq!(len("params"), Param::COUNT);
        assert_eq!(schema["answers"]["GetStatus"].as_object().unwrap().len(), 14);
        assert_eq!(schema["answers"]["GetStatus"]["Vertical"][0]["fields"][1]["name"], "position");
        assert_eq!(schema["requests"][0]["data"][0]["fields"][0]["type"], "I16");
        for subsystem in schema["subsystems"].as_array().unwrap() {
            if let Some(class) = subsystem["flags"].as_str() {
                assert!(schema["flags"][class].is_array(), "{class}");
            }
        }
        let locked = &schema["flags"]["GeneralFlags"][18];
        assert_eq!((&locked["name"], &locked["bit"]), (&json!("LockedOut"), &json!(18)));
        assert!(locked["meaning"]["ru"].is_string());
    }
}
