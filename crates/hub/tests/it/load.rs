//! The load of `cargo xtask hub-load`: every kind of message that a client can send has one, and it takes
//! nothing from the load itself.

#[path = "../../examples/hub_load/answers.rs"]
mod answers;
#[path = "../../examples/hub_load/bodies.rs"]
mod bodies;
#[path = "../../examples/hub_load/kinds.rs"]
#[expect(dead_code, reason = "the load sends them")]
mod kinds;
#[path = "../../examples/hub_load/tally.rs"]
#[expect(dead_code, reason = "the load counts with it")]
mod tally;

use kinds::Way;

#[test]
fn every_kind_of_message_has_a_load() {
    let kinds = kinds::all().unwrap_or_else(|lacking| panic!("{lacking}"));
    let has = |name: &str| kinds.iter().any(|kind| kind.name == name);
    assert!(has("POST /api/stop") && has("WebSocket stop") && has("half a body"));
    assert!(has("POST /api/tokens, refused"), "what is accepted and what is not");
}

/// A kind that removed the token of the floods made strangers of all clients of the kinds behind it.
#[test]
fn what_is_removed_was_made_for_it() {
    let kinds = kinds::all().unwrap_or_else(|lacking| panic!("{lacking}"));
    let removed: Vec<_> = kinds
        .iter()
        .filter_map(|kind| match &kind.way {
            Way::Http { method, path, .. } if method == "DELETE" => Some(path),
            _ => None,
        })
        .collect();
    assert!(removed.len() >= 4, "{removed:?}");
    assert!(removed.iter().all(|path| path.contains(bodies::NUMBER)), "{removed:?}");
}
