//! `lafet plan`: what it shows, refuses and prints, and that a hub reads what is printed.

use crate::support::Run;

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../drawing/tests/drawings");

fn drawing(name: &str) -> String {
    format!("{FOLDER}/{name}")
}

#[test]
fn a_drawing_is_shown_with_its_size_in_each_unit() {
    let run = Run::of(&["plan", "show", &drawing("01-mm.dxf")]);
    assert_eq!(run.code, 0, "{run:?}");
    for words in ["its unit is mm", "mm  101.", "`TANKS`: circles 5", "`WALLS`: circles 0, lines 4"]
    {
        assert!(run.out.contains(words), "{words}: {run:?}");
    }
    let run = Run::of(&["--lang", "ru", "plan", "show", &drawing("20-scan.png")]);
    assert!(run.code == 0 && run.out.contains("2200 × 2600 пикселей"), "{run:?}");
    let json = &Run::of(&["--json", "plan", "show", &drawing("03-inch.dxf")]).json()[0];
    assert_eq!((&json["proposed_unit"], &json["format"]), (&"in".into(), &"DXF".into()));
}

#[test]
fn nothing_is_imported_without_a_unit_or_against_the_drawing() {
    let file = drawing("01-mm.dxf");
    let run = Run::of(&["plan", "import", &file]);
    assert!(run.code == 2 && run.err.contains("never guessed"), "{run:?}");
    assert!(run.err.contains("mm  101."), "{run:?}");
    let run = Run::of(&["plan", "import", &file, "--unit", "cm"]);
    assert!(run.code == 2 && run.err.contains("its unit is mm; you state cm"), "{run:?}");
    let run = Run::of(&["plan", "import", &file, "--unit", "fathom"]);
    assert!(run.code == 2 && run.err.contains("wgs84, points"), "{run:?}");
    let run = Run::of(&["--lang", "ru", "plan", "import", &file, "--unit", "mm", "--point", "1;2"]);
    assert!(run.code == 2 && run.err.contains("ВОСТОК,СЕВЕР"), "{run:?}");
    let run = Run::of(&["plan", "show", "/nowhere.dxf"]);
    assert!(run.code == 2 && run.err.contains("/nowhere.dxf"), "{run:?}");
}

/// The tables are those of a hub: `lafet coverage` reads the whole file as the hub does.
#[test]
fn a_hub_reads_what_is_printed() {
    let file = drawing("08-mm-blocks.dxf");
    let words = ["plan", "import", &file, "--unit=mm", "--north=12", "--layer=TANKS=tank:9"];
    let layers = ["--layer=WALLS=wall:8", "--layer=MONITORS=monitor:3.5"];
    let run = Run::of(&[&words[..], &layers[..]].concat());
    assert_eq!(run.code, 0, "{run:?}");
    assert!(run.out.contains("NOT CHECKED") && run.out.contains("name = \"T-3\""), "{run:?}");
    let monitor =
        "[[monitor]]\nid = \"M1\"\nurl = \"tcp://10.0.0.1?addr=1\"\nat = [-4, 2.5]\nheight = 3.5\n";
    let hub = std::env::temp_dir().join(format!("lafet-plan-{}.toml", std::process::id()));
    std::fs::write(&hub, format!("{monitor}\n{}", run.out)).unwrap();
    let coverage = Run::of(&["--json", "coverage", hub.to_str().unwrap()]);
    std::fs::remove_file(&hub).unwrap();
    assert_eq!(coverage.code, 0, "{coverage:?}");
    let json = &Run::of(&[&["--json"], &words[..], &layers[..]].concat()).json()[0];
    assert_eq!(json["tanks"].as_array().unwrap().len(), 5);
    assert_eq!(json["monitors"][0]["name"], "M1");
}
