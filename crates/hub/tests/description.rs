//! The API against its description, and the description against the document.

mod support;

use std::collections::BTreeSet;

use serde_json::{Value, json};
use support::Site;

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
    let text = include_str!("../../../docs/hub-api.md");
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

/// Every operation, with nobody logged in, with sound and with unsound values: the status is one of
/// those described, an error has its code and both texts.
#[tokio::test]
async fn every_answer_is_as_described() {
    let site = Site::with(1, |_| {}).await;
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
