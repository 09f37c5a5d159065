//! `lafet coverage`: table, picture, JSON, and what is refused.

use crate::support::Run;

const EXAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/examples/coverage.toml");

#[test]
fn table_picture_and_json() {
    let svg = std::env::temp_dir().join(format!("lafet-coverage-{}.svg", std::process::id()));
    let run = Run::of(&["coverage", EXAMPLE, "--svg", svg.to_str().unwrap()]);
    assert_eq!(run.code, 0, "{run:?}");
    for words in ["Tank yard: 80 × 60 m", "from 270°, 8 m/s", "Weakest points", "North"] {
        assert!(run.out.contains(words), "{words}: {run:?}");
    }
    let picture = std::fs::read_to_string(&svg).unwrap();
    std::fs::remove_file(&svg).unwrap();
    assert!(picture.starts_with("<svg") && picture.trim_end().ends_with("</svg>"));
    assert!(picture.contains(">East</text>") && !picture.contains("NaN"));

    let json = &Run::of(&["--json", "coverage", EXAMPLE, "--grid"]).json()[0];
    assert_eq!((&json["cells"][0], json["winds"].as_array().unwrap().len()), (&80.into(), 5));
    let counts = json["grid"][4]["within_90"].as_array().unwrap();
    assert_eq!(counts.len(), 80 * 60);
    // The shares are those of the grid; 255 is where an obstacle is.
    let jets = |least: u64| {
        let of = |count: &&serde_json::Value| (least..255).contains(&count.as_u64().unwrap());
        counts.iter().filter(of).count() as f64 / json["protected"].as_f64().unwrap()
    };
    let two = json["winds"][4]["two"]["within_90"].as_f64().unwrap();
    assert!((jets(2) - two).abs() < 1e-9 && (0.1..1.0).contains(&two), "{two}");
    assert!(Run::of(&["--json", "coverage", EXAMPLE]).json()[0]["grid"].is_null());
}

#[test]
fn russian() {
    let run = Run::of(&["--lang", "ru", "coverage", EXAMPLE]);
    assert!(run.code == 0 && run.out.contains("Слабейшие точки"), "{run:?}");
    assert!(run.out.contains(",") && run.out.contains("штиль"), "{run:?}");
}

#[test]
fn what_is_refused() {
    let file = std::env::temp_dir().join(format!("lafet-coverage-{}.toml", std::process::id()));
    std::fs::write(
        &file,
        "[site]\ncorner = [0, 0]\nsize = [nan, 1]\n[[monitor]]\nat = [0, 0]\nheight = 2\n",
    )
    .unwrap();
    let run = Run::of(&["coverage", file.to_str().unwrap()]);
    std::fs::remove_file(&file).unwrap();
    assert!(run.code == 2 && run.err.contains(":3: site.size: 2 numbers"), "{run:?}");
    let run = Run::of(&["coverage", "/nowhere.toml"]);
    assert!(run.code == 2 && run.err.contains("/nowhere.toml"), "{run:?}");
}

#[test]
fn the_file_of_a_hub() {
    let file = std::env::temp_dir().join(format!("lafet-hub-{}.toml", std::process::id()));
    let text =
        "[[monitor]]\nid = \"M1\"\nurl = \"tcp://10.0.0.1?addr=1\"\nat = [0, 0]\nheight = 3\n";
    std::fs::write(&file, text).unwrap();
    let run = Run::of(&["coverage", file.to_str().unwrap()]);
    std::fs::remove_file(&file).unwrap();
    assert!(run.code == 0 && run.out.contains("40 × 40 m"), "{run:?}");
}
