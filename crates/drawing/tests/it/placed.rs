//! Units, known points, heights, names: what a person states, and what is refused.

use lafet_drawing::placing::{Known, Placed, place};
use lafet_drawing::site::{Plan, site};
use lafet_drawing::{Drawing, Limits, Problem, Stated, Unit, pieces, read, report, written};
use lafet_texts::Lang;

/// A drawing of 42 × 18.5 units: a tank, a wall around it, a monitor, a text.
fn dxf(insunits: &str, scale: f64) -> Drawing {
    let n = |it: f64| it * scale;
    let header = format!("0\nSECTION\n2\nHEADER\n{insunits}0\nENDSEC\n");
    let tank = format!("0\nCIRCLE\n8\nTANKS\n10\n{}\n20\n{}\n40\n{}\n", n(10.0), n(9.0), n(4.0));
    let wall = format!(
        "0\nLWPOLYLINE\n8\nWALLS\n70\n1\n39\n{}\n10\n0\n20\n0\n10\n{}\n20\n0\n10\n{}\n20\n{}\n10\n0\n20\n{}\n",
        n(3.0),
        n(42.0),
        n(42.0),
        n(18.5),
        n(18.5)
    );
    let text = format!("0\nTEXT\n8\nNAMES\n10\n{}\n20\n{}\n1\nT-7\n", n(9.5), n(9.0));
    let body = format!("{tank}{wall}{text}0\nHATCH\n8\nNAMES\n0\nPOINT\n8\nMON\n10\n1\n20\n1\n");
    let file = format!("{header}0\nSECTION\n2\nENTITIES\n{body}0\nENDSEC\n0\nEOF\n");
    read(file.as_bytes(), &Limits::default()).unwrap()
}

const MM: &str = "9\n$INSUNITS\n70\n4\n";

fn known(unit: &str) -> Known {
    Known::of(Stated::by_name(unit).unwrap())
}

fn planned(placed: &Placed, layers: &[&str]) -> Result<Plan, Problem> {
    let layers: Vec<_> = layers.iter().map(|it| written::layer(it).unwrap()).collect();
    site(placed, &layers, &[], None)
}

fn said(result: Result<impl std::fmt::Debug, Problem>) -> String {
    let problem = result.unwrap_err();
    assert!(problem.what.ru != problem.what.en && problem.remedy.ru != problem.remedy.en);
    problem.to_string()
}

#[test]
fn a_unit_that_differs_from_the_drawing_needs_a_known_distance() {
    let drawing = dxf(MM, 1000.0);
    assert_eq!(drawing.proposed, Some(Unit::Millimetre));
    let placed = place(drawing.clone(), &known("mm")).unwrap();
    assert!((placed.size[0] - 42.0).abs() < 1e-9 && (placed.size[1] - 18.5).abs() < 1e-9);
    for other in Unit::ALL.into_iter().filter(|it| *it != Unit::Millimetre) {
        assert!(said(place(drawing.clone(), &known(other.name()))).contains("--distance"));
    }
    let distance = written::distance("0,0,42000,0=420").unwrap();
    let decided = |unit: &str| {
        let stated = Known { distances: vec![distance], ..known(unit) };
        place(drawing.clone(), &stated)
    };
    assert!((decided("cm").unwrap().size[0] - 420.0).abs() < 1e-9);
    assert!(said(decided("mm")).contains("--unit cm"), "the header is right, but the site decides");
    assert!(said(decided("in")).contains("--unit cm"));
}

#[test]
fn without_a_unit_in_the_drawing_the_stated_one_counts_and_is_not_checked() {
    let drawing = dxf("", 1000.0);
    let placed = place(drawing.clone(), &known("mm")).unwrap();
    assert_eq!(placed.checked, None);
    let layers = ["tanks=tank:6", "WALLS=wall"];
    let plan = planned(&placed, &layers).unwrap();
    let chosen = layers.map(|it| written::layer(it).unwrap());
    let summary = report::summary(&placed, &known("mm"), &chosen, &plan, Lang::En).join("\n");
    assert!(summary.contains("42.0 m × 18.5 m") && summary.contains("NOT CHECKED"), "{summary}");
    assert!(summary.contains("HATCH 1") && summary.contains("not used: MON."), "{summary}");
    let summary = report::summary(&placed, &known("mm"), &chosen, &plan, Lang::Ru).join("\n");
    assert!(summary.contains("42,0 м × 18,5 м") && summary.contains("НЕ ПРОВЕРЕНО"), "{summary}");
    // Far too large, or far too small, is refused all the same.
    let km = place(drawing.clone(), &known("km")).unwrap();
    assert!(said(planned(&km, &["WALLS=wall:3"])).contains("42000"));
    assert!(said(place(dxf("", 10.0), &known("mm"))).contains("0.420 m × 0.185 m"));
    let overview = report::overview(&drawing, Lang::En);
    assert!(overview.contains("mm  42.0 m × 18.5 m"), "{overview}");
    assert!(overview.contains("`TANKS`: circles 1, lines 0, points 0"), "{overview}");
}

#[test]
fn known_points_turn_and_check() {
    let drawing = dxf(MM, 1000.0);
    let with = |unit: &str, points: &[&str]| {
        let points = points.iter().map(|it| written::point(it).unwrap()).collect();
        place(drawing.clone(), &Known { points, ..known(unit) })
    };
    // Turned by 90° to the left, and moved.
    let placed = with("mm", &["0,0=5,5", "42000,0=5,47.02"]).unwrap();
    let [east, north] = placed.placing.place([42000.0, 18500.0]);
    assert!((east + 13.5).abs() < 0.02 && (north - 47.0).abs() < 0.02, "{east} {north}");
    let checked = placed.checked.unwrap();
    assert!((checked.worst_m - 0.01).abs() < 1e-6, "{checked:?}");
    assert!((checked.ratio.unwrap() - 42.02 / 42.0).abs() < 1e-9);
    assert!((placed.placing.north_deg() - 90.0).abs() < 1e-9);
    assert!(said(with("mm", &["0,0=0,0", "42000,0=420,0"])).contains("--unit cm"));
    assert!(said(with("mm", &["0,0=0,0"])).contains("direction"));
    assert!(said(with("mm", &["0,0=0,0", "100,0=0.1,0"])).contains("10 %"));
    assert!(said(with("points", &[])).contains("--point"));
    // Mirrored: no turn fits three points.
    let mirrored = ["0,0=0,0", "42000,0=42,0", "0,18500=0,-18.5"];
    assert!(said(with("mm", &mirrored)).contains('%'));
    let north = Known { north_deg: Some(3.0), ..known("mm") };
    let pair = written::point("0,0=0,0").unwrap();
    let both = Known { points: vec![pair, pair], ..north };
    assert!(said(place(drawing.clone(), &both)).contains("--north"));
    assert!(said(place(drawing.clone(), &known("wgs84"))).contains("GeoJSON"));
}

#[test]
fn heights_are_those_of_the_drawing_or_stated_or_asked() {
    let placed = place(dxf(MM, 1000.0), &known("mm")).unwrap();
    assert!(said(planned(&placed, &["TANKS=tank"])).contains("TANKS=tank:12"));
    let plan = planned(&placed, &["TANKS=tank:6", "WALLS=wall"]).unwrap();
    assert_eq!((plan.tanks[0].height, plan.tanks[0].name.as_str()), (6.0, "T-7"));
    assert!(plan.walls.iter().all(|it| (it.height - 3.0).abs() < 1e-9) && plan.walls.len() == 4);
    let plan = planned(&placed, &["WALLS=wall:5"]).unwrap();
    assert!(plan.walls.iter().all(|it| it.height == 5.0));
    assert!(said(planned(&placed, &["TANKS=tank:0"])).contains("0.000 m high"));
    assert!(said(planned(&placed, &["LAKE=tank:3"])).contains("TANKS, WALLS, NAMES, MON"));
    assert_eq!(planned(&placed, &["WALLS=tank:5"]).unwrap().left_out[0].count, 1);
    let plan = planned(&placed, &["MON=monitor", "TANKS=monitor:2"]).unwrap();
    let heights: Vec<_> = plan.monitors.iter().map(|it| it.height).collect();
    assert_eq!(heights, [None, Some(2.0)]);
}

/// What is printed is what a hub reads; its own tests of the same tables are in the program.
#[test]
fn pieces_are_toml() {
    #[derive(serde::Deserialize)]
    struct Hub {
        tank: Vec<toml::Table>,
        wall: Vec<toml::Table>,
    }
    let placed = place(dxf(MM, 1000.0), &known("mm")).unwrap();
    let layers = ["TANKS=tank:6", "WALLS=wall", "MON=monitor:2"];
    let text = pieces::toml(&planned(&placed, &layers).unwrap(), Lang::Ru);
    let hub: Hub = toml::from_str(&text).unwrap();
    assert_eq!((hub.tank.len(), hub.wall.len()), (1, 4));
    assert_eq!(hub.tank[0]["at"].as_array().unwrap()[0].as_float(), Some(10.0));
    assert_eq!(hub.tank[0]["diameter"].as_float(), Some(8.0));
    assert!(text.contains("# at = [0.001, 0.001]\n# height = 2.0"), "{text}");
}
