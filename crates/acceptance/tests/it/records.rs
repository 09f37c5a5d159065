//! The record against its schema, and the page.

use lafet_acceptance::calendar::Kept;
use lafet_acceptance::record::{Occasion, Record, sha256};
use lafet_acceptance::sign::Key;
use lafet_acceptance::{Stage, check, html};
use lafet_texts::Lang;
use serde_json::Value;

use crate::bench::{PLAN, Running, Site};

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_record_keeps_to_its_schema_and_its_page_needs_nothing_else() {
    let mut site = Site::good();
    site.plan = site.plan.replace("name = \"Hall\"", "name = \"Hall <1> & \\\"2\\\"\"");
    let running = Running::start(site).await;
    let outcome = running.test(&[Stage::Read]).await;
    let occasion = Occasion {
        hub: "http://h".into(),
        began_ms: 1_763_712_000_000,
        by: "I. <Tester>".into(),
        plan: PLAN.into(),
        version: "0.1.0".into(),
    };
    let name = running.world.site.planned().name;
    let record = Record::new(&name, &occasion, &[Stage::Read], outcome);
    let json = record.json();
    let value: Value = serde_json::from_slice(&json).unwrap();
    let schema: Value =
        serde_json::from_str(include_str!("../../../../docs/schema/site-test-1.json")).unwrap();
    let validator = jsonschema::validator_for(&schema).unwrap();
    let wrong: Vec<String> = validator.iter_errors(&value).map(|it| it.to_string()).collect();
    assert_eq!(wrong, Vec::<String>::new());
    let tried: Vec<&str> = value["results"]
        .as_array()
        .unwrap()
        .iter()
        .map(|it| it["check"].as_str().unwrap())
        .collect();
    assert!(check::ALL.iter().all(|it| tried.contains(&it.id)), "each check has a result");
    let key = Key::read(&"1f".repeat(32)).unwrap();
    let signed = key.sign(&json);
    let kept = Kept::read(&json).unwrap();
    assert_eq!((kept.site.as_str(), kept.is_whole()), (name.as_str(), true));
    assert_eq!(
        kept.count(None, "fail"),
        usize::try_from(value["counts"]["fail"].as_u64().unwrap()).unwrap()
    );
    for lang in Lang::ALL {
        let page = html::html(&record, Some(&signed), lang);
        assert!(page.contains(&sha256(&json)), "the digest of the JSON");
        assert!(page.contains(&signed.public) && page.contains(&signed.signature));
        assert!(
            page.contains("Hall &lt;1&gt; &amp; &quot;2&quot;")
                && page.contains("I. &lt;Tester&gt;")
        );
        assert!(page.contains("<section lang=\"en\"") && page.contains("<section lang=\"ru\""));
        for asset in ["http://www", "https://", "src=", "href=", "url(", "<script"] {
            assert!(!page.contains(asset), "{asset}");
        }
    }
}

/// The page has every check as it is, in both languages, and its plan is one.
#[test]
fn the_pages_have_every_check_and_a_plan_that_can_be_read() {
    let pages = [
        (Lang::En, include_str!("../../../../docs/site-test.md")),
        (Lang::Ru, include_str!("../../../../docs/site-test.ru.md")),
    ];
    for (lang, page) in pages {
        for it in check::ALL {
            let row = format!("| `{}` | {} | {} |", it.id, it.stage.name(), it.title.str(lang));
            assert!(page.contains(&row), "{row}");
        }
        let plan = page.split("```toml\n").nth(1).and_then(|it| it.split("```").next()).unwrap();
        let plan: lafet_acceptance::Plan = toml::from_str(plan).unwrap();
        assert_eq!(plan.check(), Vec::new());
        assert!(plan.zones[0].delay_s == Some(10) && plan.keep_outs.len() == 1);
    }
}

/// What is wrong with a plan is said at once, with its name.
#[test]
fn a_plan_that_contradicts_itself_is_refused() {
    for (from, to, en) in [
        ("target = \"north door\"", "target = \"south door\"", "target “south door”"),
        ("monitors = [\"M1\", \"M2\"]", "monitors = [\"M1\", \"M3\"]", "monitor “M3”"),
        ("id = \"heat\"", "id = \"flame-east\"", "there twice: “flame-east”"),
        ("at = [0.0, 25.0, 2.0]", "at = [0.0, nan, 2.0]", "NaN for “north door”"),
        ("heading = 0.0", "heading = 1e9", "1000000000 for “M1”"),
        ("at = [-30.0, 0.0, 6.0]", "at = [-30.0, 0.0, -1e9]", "-1000000000 for “flame-west”"),
        ("zone = \"hall\"", "zone = \"\"", "zone “”"),
        ("delay_s = 2", "delay_s = 4000000000", "4000000000 for “hall”"),
        ("height = 2.0", "height = 2.0\nrest_datm = [40.0, 5.0]", "5 for “M1”"),
        ("nozzle = 60", "nozzle = 60\nvalve = \"All\"", "valve “All”"),
        ("id = \"M1\"", "id = \"M\\u001b1\"", "twice: “M"),
    ] {
        assert!(PLAN.contains(from), "{from}");
        let plan: lafet_acceptance::Plan = toml::from_str(&PLAN.replacen(from, to, 1)).unwrap();
        let wrong = plan.check();
        assert!(wrong.iter().any(|it| it.en.contains(en)), "{to}: {wrong:?}");
        assert!(wrong.iter().all(|it| it.ru != it.en));
    }
    assert!(toml::from_str::<lafet_acceptance::Plan>("nmae = \"x\"").is_err());
}
