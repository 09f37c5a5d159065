//! The API against its description, and the description against the document.

use std::collections::BTreeSet;

use crate::support::Site;
use serde_json::{Value, json};

fn operations() -> Vec<(String, String, Value)> {
    let description = lafet_hub::description();
    let paths = description["paths"].as_object().unwrap().clone();
    let mut all = Vec::new();
    for (path, methods) in paths {
        for (method, operation) in methods.as_object().unwrap() {
            all.push((method.to_uppercase(), path.clone(), operation.clone()));
        }
    }
    all
}

/// `GET /api/…` in the document; the query is left out.
fn documented() -> BTreeSet<(String, String)> {
    let text = include_str!("../../../../docs/hub-api.md");
    let mut all = BTreeSet::new();
    for part in text.split('`').skip(1).step_by(2).flat_map(|part| part.split(", ")) {
        if let Some((method, path)) = part.split_once(' ')
            && ["GET", "POST", "PUT", "PATCH", "DELETE"].contains(&method)
            && path.starts_with('/')
        {
            let path = path.split(['?', '#', ' ']).next().unwrap_or_default();
            if !path.contains('…') {
                all.insert((method.to_owned(), path.to_owned()));
            }
        }
    }
    all
}

#[test]
fn the_document_has_what_the_description_has() {
    let described: BTreeSet<(String, String)> =
        operations().into_iter().map(|(method, path, _)| (method, path)).collect();
    let documented = documented();
    let lacking: Vec<_> = described.difference(&documented).collect();
    let invented: Vec<_> = documented.difference(&described).collect();
    assert!(
        lacking.is_empty() && invented.is_empty(),
        "lacking {lacking:?}, invented {invented:?}"
    );
}

/// Names are unique, parameters are where requests have them, answers have a shape.
#[test]
fn programs_can_be_made_from_the_description() {
    let mut names = BTreeSet::new();
    let mut bare = BTreeSet::new();
    for (method, path, operation) in operations() {
        let name = operation["operationId"].as_str().unwrap().to_owned();
        assert!(names.insert(name.clone()), "{name} twice");
        for parameter in operation["parameters"].as_array().into_iter().flatten() {
            let own = format!("{{{}}}", parameter["name"].as_str().unwrap());
            assert_eq!(parameter["in"] == "path", path.contains(&own), "{path} {own}");
        }
        for (status, answer) in operation["responses"].as_object().unwrap() {
            let schema = &answer["content"]["application/json"]["schema"];
            if schema == &json!({ "type": "object" }) {
                bare.insert(format!("{method} {path}"));
            }
            let failed = schema["$ref"] == "#/components/schemas/Failed";
            assert!(status.as_str() < "400" || failed || path == "/health", "{path} {status}");
        }
    }
    // The dictionary and this description; what the simulator reports is its own.
    let own = ["GET /api/dictionary", "GET /api/openapi.json"];
    let others = bare.iter().filter(|it| !it.contains("/api/sim") && !own.contains(&it.as_str()));
    assert_eq!(others.collect::<Vec<_>>(), Vec::<&String>::new());
}

/// Two structures of one name would be one in the description: the second is lost.
#[test]
fn structures_have_names_of_their_own() {
    let mut names = BTreeSet::new();
    let mut folders = vec![std::path::PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/src"))];
    while let Some(folder) = folders.pop() {
        for entry in folder.read_dir().unwrap().map(|entry| entry.unwrap().path()) {
            if entry.is_dir() {
                folders.push(entry);
                continue;
            }
            let text = std::fs::read_to_string(&entry).unwrap_or_default();
            for derived in text.split("#[derive(").skip(1) {
                let head = derived.split('{').next().unwrap_or_default();
                if !head.split(')').next().is_some_and(|it| it.contains("ToSchema")) {
                    continue;
                }
                let given = head.split("schema(as = ").nth(1).and_then(|it| it.split(')').next());
                let own = || head.split(['\n', ' ']).skip_while(|it| !KINDS.contains(it)).nth(1);
                let name = given.or_else(own).unwrap_or_default().trim_end_matches('(');
                assert!(names.insert(name.to_owned()), "{name} twice: {}", entry.display());
            }
        }
    }
    assert!(names.len() > 100, "{names:?}");
}

const KINDS: [&str; 2] = ["struct", "enum"];

/// Every operation, with no user logged in, with sound and with unsound values: the status is one of
/// those described, an error has its code and both texts.
#[tokio::test]
async fn every_answer_is_as_described() {
    // A connection for each of some thousand requests: an address may not have so many a second.
    let site = Site::with(1, |config| config.proxies = vec!["127.0.0.1".parse().unwrap()]).await;
    let token = site.token(lafet_hub::access::Role::Administrator);
    let bodies = [
        "",
        "{}",
        "[1]",
        "{\"ids\":[\"nothing\"]}",
        "\u{0}garbage",
        "{\"user\":\"x\",\"password\":\"y\"}",
        "{\"request\":\"GetStatus All\"}",
        "{\"drive\":\"Vertical\",\"toward\":\"max\"}",
        "{\"action\":\"release\"}",
        "{\"values\":[1]}",
        "{\"id\":\"x\",\"minutes\":1,\"reason\":\"y\"}",
    ];
    for (method, path, operation) in operations() {
        let described: Vec<u16> = operation["responses"]
            .as_object()
            .unwrap()
            .keys()
            .map(|it| it.parse().unwrap())
            .collect();
        for (monitor, subsystem) in [("M1", "Vertical"), ("M9", "Nobody"), ("%00", "%D0%B6")] {
            let path = path
                .replace("{user}", "nobody-here")
                .replace("/tokens/{id}", "/tokens/99")
                .replace("{id}", monitor)
                .replace("{subsystem}", subsystem)
                .replace("{name}", "Speed");
            for query in
                ["", "?monitor=M1&series=Vertical.position", "?monitor=&limit=x&from_ms=-1"]
            {
                for body in bodies {
                    if method == "GET" && !body.is_empty() {
                        continue;
                    }
                    for authorization in ["", &format!("Bearer {token}")] {
                        let headers = [("Authorization", authorization)];
                        let headers =
                            if authorization.is_empty() { &headers[..0] } else { &headers };
                        let place = format!("{path}{query}");
                        let reply = site.http(&method, &place, headers, body).await;
                        let slow = reply.status == 429;
                        let fine = slow || described.contains(&reply.status);
                        assert!(
                            fine,
                            "{method} {place} {body}: {reply:?}, described {described:?}"
                        );
                        if reply.status >= 400
                            && !path.ends_with("/ws")
                            && !path.ends_with("/health")
                        {
                            let error = &reply.body["error"];
                            let whole =
                                ["code", "en", "ru"].iter().all(|it| error[*it].is_string());
                            assert!(whole, "{method} {place} {body}: {reply:?}");
                        }
                    }
                }
            }
        }
    }
    assert_eq!(json!(site.get(&token, "/health").await.status), 200);
}
