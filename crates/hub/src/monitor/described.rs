//! The states of subsystems as the API describes them: a structure for each layout of the protocol's
//! dictionary (§3.3), so that it has the fields and flags that are sent.

use std::borrow::Cow;

use lafet_proto::dictionary::layouts::{self, Field, Kind, Layout};
use lafet_proto::flags::{self, ButtonState, FlagInfo};
use lafet_proto::{RequestId, SubsystemId};
use lafet_texts::{Lang, Text};
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, Ref, Schema, Type};
use utoipa::openapi::{KnownFormat, RefOr, SchemaFormat};
use utoipa::{PartialSchema, ToSchema};

use crate::words::Severity;

/// The description of [`Subsystems`](super::status::Subsystems).
pub(crate) struct States;

impl PartialSchema for States {
    fn schema() -> RefOr<Schema> {
        let all = described().fold(ObjectBuilder::new(), |all, (id, layout)| {
            all.property(id.name().unwrap_or_default(), Ref::from_schema_name(layout.name))
        });
        let text = "The states of the subsystems that a monitor has, by name.";
        all.description(Some(text)).into()
    }
}

impl ToSchema for States {
    fn name() -> Cow<'static, str> {
        "Subsystems".into()
    }

    fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
        schemas.push((Severity::name().into(), Severity::schema()));
        schemas.extend(described().map(|(id, layout)| (layout.name.into(), structure(id, layout))));
    }
}

/// The subsystems that have a state, and its layout.
fn described() -> impl Iterator<Item = (SubsystemId, &'static Layout)> {
    let layout = |id| layouts::of_answer(RequestId::GET_STATUS, id).first().map(|it| (id, it));
    SubsystemId::TABLE.into_iter().filter_map(layout)
}

/// A state, as [`Subsystem`](super::status::Subsystem) is written.
fn structure(id: SubsystemId, layout: &Layout) -> RefOr<Schema> {
    let names = flags::flags_of(id).flags.iter().flat_map(values);
    let flag = ObjectBuilder::new().schema_type(Type::String).enum_values(Some(names));
    let flags = ArrayBuilder::new().items(flag).description(Some("The flags that are set."));
    let bad = ObjectBuilder::new().additional_properties(Some(String::schema())).description(Some(
        "Fields whose values are not to be believed, and the flags that say so.",
    ));
    let common = ObjectBuilder::new()
        .property("bits", integer(Some(0), "The status word (§3.3)."))
        .required("bits")
        .property("flags", flags)
        .required("flags")
        .property("severity", Ref::from_schema_name(Severity::name()))
        .required("severity")
        .property("bad", bad);
    let fields = layout.fields.iter().filter(|field| field.kind != Kind::Flags);
    let all =
        fields.fold(common, |all, field| all.property(field.name, integer(None, &meaning(field))));
    let text =
        "What GetStatus reports of a subsystem. A recording lacks fields whose sensor was faulty.";
    all.description(Some(text)).into()
}

/// The names that [`flags::SetFlag`] can have: a button has one for each state but released.
fn values(info: &FlagInfo) -> Vec<String> {
    let states = ButtonState::ALL.into_iter().filter(|state| *state != ButtonState::Released);
    match info.button_state(0) {
        Some(_) => states.map(|state| format!("{}={state:?}", info.name)).collect(),
        None => vec![info.name.to_owned()],
    }
}

fn meaning(field: &Field) -> String {
    let text = field.text.of(Lang::En);
    match field.unit.symbol() {
        "" => format!("{text}."),
        unit => format!("{text}, {unit}."),
    }
}

fn integer(minimum: Option<u32>, description: &str) -> ObjectBuilder {
    ObjectBuilder::new()
        .schema_type(Type::Integer)
        .format(Some(SchemaFormat::KnownFormat(KnownFormat::Int64)))
        .minimum(minimum)
        .description(Some(description))
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};
    use std::sync::Arc;

    use lafet_client::AnswerBuf;
    use lafet_proto::Status as Code;
    use lafet_proto::record::Record;
    use serde_json::{Value, json};

    use super::*;
    use crate::monitor::status::{Subsystem, Subsystems, subsystems};

    /// The description, by names of structures.
    fn structures() -> BTreeMap<String, Value> {
        let mut all = vec![(States::name().into_owned(), States::schema())];
        States::schemas(&mut all);
        all.into_iter().map(|(name, schema)| (name, json!(schema))).collect()
    }

    fn told(from: SubsystemId, data: &[u8]) -> Arc<Subsystem> {
        let request = RequestId::GET_STATUS;
        let answer = AnswerBuf::new(&Record { request, device: from, status: Code::OK, data });
        subsystems([answer].iter(), &Subsystems::new())[from.name().unwrap()].clone()
    }

    fn keys(object: &Value) -> BTreeSet<&str> {
        object.as_object().unwrap().keys().map(String::as_str).filter(|key| *key != "bad").collect()
    }

    /// Every field and every flag that is sent is described, and no other.
    #[test]
    fn what_is_sent_is_what_is_described() {
        let structures = structures();
        let all = &structures["Subsystems"]["properties"];
        assert_eq!(keys(all).len(), SubsystemId::TABLE.len());
        for (id, layout) in described() {
            let name = all[id.name().unwrap()]["$ref"].as_str().unwrap();
            assert_eq!(name, format!("#/components/schemas/{}", layout.name));
            let described = &structures[layout.name]["properties"];
            let known = described["flags"]["items"]["enum"].as_array().unwrap();
            let mut seen = BTreeSet::new();
            for byte in [0x00, 0x55, 0xAA, 0xFF] {
                let state = json!(told(id, &vec![byte; layout.size()]));
                assert_eq!(keys(&state), keys(described), "{id}");
                let flags = state["flags"].as_array().unwrap();
                seen.extend(flags.iter().map(|flag| flag.as_str().unwrap().to_owned()));
            }
            let known: BTreeSet<_> =
                known.iter().map(|it| it.as_str().unwrap().to_owned()).collect();
            assert_eq!(seen, known, "{id}");
        }
    }

    /// The JSON that is sent, which programs of others read.
    #[test]
    fn the_json_of_a_state() {
        let sent = |id, data: &[u8]| serde_json::to_string(&told(id, data)).unwrap();
        assert_eq!(
            sent(SubsystemId::VERTICAL, &[0, 0, 0b1001, 0, 0x9C, 0xFF, 15, 9]),
            r#"{"bits":589824,"flags":["Move","PosEncoderFault"],"severity":"alarm","bad":{"position":"PosEncoderFault"},"current":15,"position":-100,"speed":9}"#
        );
        assert_eq!(
            sent(SubsystemId::BUTTONS, &[0, 0, 0b1001, 0]),
            r#"{"bits":589824,"flags":["LeftButtonState=Pressed","RightButtonState=Short"],"severity":"warning"}"#
        );
    }
}
