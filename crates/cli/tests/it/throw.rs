//! `lafet throw`: figures with their bands, a table, wind, and what is refused.

use serde_json::{Value, json};

use crate::support::Run;

const USUAL: &[&str] = &["throw", "--flow", "20", "--pressure", "0.8", "--elevation", "30"];

fn lines(arguments: &[&str]) -> (Value, Vec<Value>) {
    let run = Run::of(&[&["--json"], arguments].concat());
    assert_eq!(run.code, 0, "{run:?}");
    let whole = run.json().remove(0);
    let throws = whole["throws"].as_array().unwrap().clone();
    (whole, throws)
}

fn value(line: &Value, figure: &str) -> f64 {
    line[figure]["value"].as_f64().unwrap()
}

#[test]
fn middle_and_greatest_with_their_bands() {
    let run = Run::of(USUAL);
    assert_eq!(run.code, 0, "{run:?}");
    for words in
        ["Monitor: 20.0 l/s at 0.80 MPa, outlet 28.0 mm", "greatest, m", "still air", "simulator"]
    {
        assert!(run.out.contains(words), "{words}: {run:?}");
    }
    let (whole, throws) = lines(USUAL);
    assert_eq!((&whole["kind"], throws.len()), (&json!("monitor"), 1));
    // Makers state 42 m.
    assert!((value(&throws[0], "greatest_m") / 42.0 - 1.0).abs() < 0.1, "{throws:?}");
    for figure in ["middle_m", "greatest_m", "top_m", "flight_s"] {
        let of = |end: &str| throws[0][figure][end].as_f64().unwrap();
        assert!(
            0.0 < of("low") && of("low") < of("value") && of("value") < of("high"),
            "{throws:?}"
        );
    }
    // 2 MPa of a water cannon: 65 m.
    let cannon = ["throw", "--kind", "smooth", "--flow", "1200l/min", "--pressure", "20bar"];
    let (whole, throws) = lines(&[&cannon[..], &["--elevation", "30", "--height", "3.5"]].concat());
    assert!((value(&throws[0], "greatest_m") / 65.0 - 1.0).abs() < 0.1, "{throws:?}");
    assert_eq!((&whole["notes"], &throws[0]["simulator_middle_m"]), (&json!([]), &Value::Null));
}

#[test]
fn a_table_over_elevations_in_russian_too() {
    let table =
        ["throw", "--outlet", "28", "--pressure", "8bar", "--elevation", "10..75", "--step", "5"];
    let (_, throws) = lines(&table);
    let elevations: Vec<f64> =
        throws.iter().map(|line| line["elevation_deg"].as_f64().unwrap()).collect();
    assert_eq!((elevations.len(), elevations[0], elevations[13]), (14, 10.0, 75.0));
    let tops: Vec<f64> = throws.iter().map(|line| value(line, "top_m")).collect();
    assert!(tops.windows(2).all(|pair| pair[0] < pair[1]), "{tops:?}");
    let best = throws.iter().map(|line| value(line, "greatest_m")).fold(0.0, f64::max);
    assert!(best > value(&throws[0], "greatest_m") && best > value(&throws[13], "greatest_m"));
    let run = Run::of(&[&["--lang", "ru"], &table[..]].concat());
    assert!(run.out.contains("возвышение") && run.out.contains("28,0 мм"), "{run:?}");
}

#[test]
fn wind_shortens_and_carries_aside() {
    let with = |more: &[&str]| lines(&[USUAL, more].concat()).1.remove(0);
    let (calm, head) = (with(&[]), with(&["--wind", "5"]));
    assert!(value(&head, "middle_m") < value(&calm, "middle_m") - 2.0, "{head}");
    let right = with(&["--wind", "5", "--wind-from", "90"]);
    assert!(right["left_m"].as_f64().unwrap() > 1.0, "{right}");
    let run = Run::of(&[USUAL, &["--wind", "5", "--wind-from", "-90"]].concat());
    assert!(run.code == 0 && run.out.contains(" right"), "{run:?}");
}

#[test]
fn what_is_refused() {
    let with = |words: &str| {
        let words: Vec<&str> = words.split(' ').collect();
        let run = Run::of(&[&["throw"], &words[..]].concat());
        assert_eq!(run.code, 2, "{words:?}: {run:?}");
        run.err
    };
    assert!(with("--flow 20 --pressure 8 --elevation 30").contains("8bar"));
    assert!(
        with("--flow 900 --pressure 0.8 --elevation 30").contains("flow 900 l/s: the law holds")
    );
    assert!(with("--outlet 28 --pressure 0.8 --elevation 89").contains("elevation 89"));
    assert!(with("--flow 20 --pressure 0.8 --elevation 30..10").contains("10..75"));
    assert!(with("--flow 20 --pressure 0.8 --elevation 0..80 --step 0.01").contains("--step"));
    assert!(with("--flow 20 --pressure 0.8 --elevation 0..80 --step nan").contains("--step"));
    assert!(with("--flow 20 --pressure 0.8 --elevation 30 --wind inf").contains("wind inf"));
    assert!(with("--flow 20 --pressure 0.8 --elevation 30 --kind foam").contains("smooth"));
    with("--pressure 0.8 --elevation 30");
    with("--flow 20 --outlet 28 --pressure 0.8 --elevation 30");
}
