//! Every kind of message that a client can send has a load of `cargo xtask hub-load`.

#[path = "../../examples/hub_load/kinds.rs"]
#[expect(dead_code, reason = "the load sends them")]
mod load;

#[test]
fn every_kind_of_message_has_a_load() {
    let kinds = load::all().unwrap_or_else(|lacking| panic!("{lacking}"));
    let has = |name: &str| kinds.iter().any(|kind| kind.name == name);
    assert!(has("POST /api/stop") && has("WebSocket stop") && has("half a body"));
}
