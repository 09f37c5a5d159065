//! docs/conform.md and docs/conform.ru.md have the figures of the tester.

use lafet_conform::spec::{items, unseen};
use lafet_conform::{Level, tests};

fn page(name: &str) -> String {
    let path = format!("{}/../../docs/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

#[test]
fn the_page_has_the_figures() {
    let (all, unseen) = (items().len(), unseen().len());
    let upto = |level| tests().filter(|(_, _, needs)| *needs <= level).count();
    for (name, sentence) in [
        (
            "conform.md",
            format!("Of the {all} items {} are tested; the other {unseen} ", all - unseen),
        ),
        (
            "conform.ru.md",
            format!("Из {all} пунктов проверяются {}; остальные {unseen} ", all - unseen),
        ),
    ] {
        let page = page(name);
        assert!(page.contains(&sentence), "{name}: {sentence}");
        for level in Level::ALL {
            let row = format!("| `--{}`", level.name());
            let row = page.lines().find(|line| line.starts_with(&row)).expect("a row");
            assert!(row.ends_with(&format!("| {} |", upto(level))), "{} {row}", upto(level));
        }
    }
}
