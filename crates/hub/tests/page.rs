//! What the console's types say of the audit log is made from the description of the API.

use std::collections::BTreeSet;

use serde_json::Value;

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../console/src/hub/acts.ts");
const HEAD: &str = "\
// What entries of the audit log are about. Made from the description of the API:
// LAFET_WRITE=1 cargo test -p lafet-hub --test page
";

/// A schema as a type of TypeScript; the schemas it names go into `named`.
fn typed(schema: &Value, named: &mut Vec<String>) -> String {
    let mut joined = |all: &str, between: &str| {
        // What may be absent is described as null, and left out where it is written.
        let parts = schema[all].as_array()?.iter().filter(|part| part["type"] != "null");
        let parts = parts.map(|part| typed(part, named));
        let parts: Vec<String> = parts.collect();
        let whole = parts.join(between);
        Some(if parts.len() > 1 { format!("({whole})") } else { whole })
    };
    if let Some(parts) = joined("oneOf", " | ").or_else(|| joined("allOf", " & ")) {
        return parts;
    }
    if let Some(values) = schema["enum"].as_array() {
        return values.iter().map(Value::to_string).collect::<Vec<_>>().join(" | ");
    }
    if let Some(path) = schema["$ref"].as_str() {
        let name = path.rsplit('/').next().unwrap_or_default();
        named.push(name.to_owned());
        return name.to_owned();
    }
    match schema["type"].as_str() {
        Some("object") => object(schema, named),
        Some("array") => format!("{}[]", typed(&schema["items"], named)),
        Some("integer" | "number") => "number".into(),
        Some(plain @ ("string" | "boolean")) => plain.into(),
        _ => match &schema["type"][0] {
            Value::String(one) => typed(&serde_json::json!({ "type": one }), named),
            _ => panic!("no type is known for {schema}"),
        },
    }
}

fn object(schema: &Value, named: &mut Vec<String>) -> String {
    let required = schema["required"].as_array().cloned().unwrap_or_default();
    let fields = schema["properties"].as_object().cloned().unwrap_or_default();
    let field = |(name, of): (&String, &Value)| {
        let mark = if required.contains(&name.as_str().into()) { "" } else { "?" };
        format!("{name}{mark}: {}", typed(of, named))
    };
    format!("{{ {} }}", fields.iter().map(field).collect::<Vec<_>>().join("; "))
}

fn acts() -> String {
    let description = lafet_hub::description();
    let mut wanted = vec!["Act".to_owned()];
    let mut done = BTreeSet::new();
    let mut text = HEAD.to_owned();
    while let Some(name) = wanted.pop() {
        if !done.insert(name.clone()) {
            continue;
        }
        let schema = &description["components"]["schemas"][&name];
        let written = typed(schema, &mut wanted);
        let written =
            written.strip_prefix('(').and_then(|it| it.strip_suffix(')')).unwrap_or(&written);
        let lines = written.replace(" | {", "\n  | {");
        text += &format!("\nexport type {name} = {lines};\n");
    }
    text
}

#[test]
fn the_page_knows_every_kind_of_act() {
    let fresh = acts();
    if std::env::var_os("LAFET_WRITE").is_some() {
        std::fs::write(FILE, &fresh).unwrap();
    }
    let file = std::fs::read_to_string(FILE).unwrap_or_default();
    assert!(file == fresh, "{FILE} is out of date; its first lines say how it is made");
}
