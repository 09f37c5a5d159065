//! Measured figures of a whole monitor: how well and how fast it finds fires, and puts them out.

use lafet_sim::event::What;
use lafet_sim::fault::{Fault, SingleFault};
use lafet_sim::fire::{Fire, FireSpec};
use lafet_sim::sim::Config;

use super::Table;
use super::bench::Bench;

const HEIGHT_M: f64 = 1.5;
/// Sector of the searches: ±45° wide, from 15° below to 5° above the horizon.
const SEEK: &str = "StartSeek Detector -2700 2700 -900 300";
const SEEDS: u64 = 5;

/// A search: what burns and what disturbs.
struct Case {
    name: &'static str,
    fires: &'static [&'static str],
    glares: &'static [&'static str],
    walls: &'static [&'static str],
    dirty: bool,
    analyse: bool,
}

const CLEAR: Case =
    Case { name: "", fires: &[], glares: &[], walls: &[], dirty: false, analyse: false };

const CASES: &[Case] = &[
    Case { name: "1.5 m at 25 m", fires: &["az=20,range=25,size=1.5"], ..CLEAR },
    Case {
        name: "1.5 m at 25 m, analysed",
        fires: &["az=20,range=25,size=1.5"],
        analyse: true,
        ..CLEAR
    },
    Case { name: "1 m at 50 m", fires: &["az=-30,range=50,size=1"], ..CLEAR },
    Case {
        name: "0.5 m at 50 m: below the threshold",
        fires: &["az=-30,range=50,size=0.5"],
        ..CLEAR
    },
    Case {
        name: "two, 8° apart",
        fires: &["az=10,range=25,size=1", "az=18,range=25,size=1"],
        ..CLEAR
    },
    Case {
        name: "two of 0.5 m at 25 m, 2° apart: 51′ between them",
        fires: &["az=10,range=25,size=0.5", "az=12,range=25,size=0.5"],
        ..CLEAR
    },
    Case {
        name: "the same 1.7° apart: 33′ between them",
        fires: &["az=10,range=25,size=0.5", "az=11.7,range=25,size=0.5"],
        ..CLEAR
    },
    Case {
        name: "the same 1.6° apart: 27′ between them, one hotbed",
        fires: &["az=10,range=25,size=0.5", "az=11.6,range=25,size=0.5"],
        ..CLEAR
    },
    Case {
        name: "two of 1 m at 25 m, 2° apart: they touch, one hotbed",
        fires: &["az=10,range=25,size=1", "az=12,range=25,size=1"],
        ..CLEAR
    },
    Case {
        name: "five: the four brightest",
        fires: &[
            "az=-40,range=20,size=1",
            "az=-20,range=22,size=1",
            "az=0,range=24,size=1",
            "az=20,range=26,size=1",
            "az=40,range=28,size=1",
        ],
        ..CLEAR
    },
    Case {
        name: "dirty lens, 1.5 m at 25 m",
        fires: &["az=20,range=25,size=1.5"],
        dirty: true,
        ..CLEAR
    },
    Case {
        name: "dirty lens, 1 m at 50 m: lost",
        fires: &["az=-30,range=50,size=1"],
        dirty: true,
        ..CLEAR
    },
    Case {
        name: "low sun: a false hotbed",
        fires: &["az=20,range=25,size=1.5"],
        glares: &["az=-35,el=4,size=0.5,brightness=3000"],
        ..CLEAR
    },
    Case {
        name: "hot machine: a false hotbed",
        fires: &["az=20,range=25,size=1.5"],
        glares: &["az=0,el=-2,size=3,brightness=300"],
        ..CLEAR
    },
    Case {
        name: "behind a wall: hidden",
        fires: &["az=20,range=25,size=1.5"],
        walls: &["from=10,to=30,range=15,height=2"],
        ..CLEAR
    },
];

/// What a search gave.
struct Outcome {
    found: usize,
    false_ones: usize,
    /// Largest distance of a found fire's middle from the true one, arc-minutes.
    off_arcmin: f64,
    took_s: f64,
}

fn parsed<T: core::str::FromStr>(texts: &[&str]) -> Vec<T> {
    texts.iter().filter_map(|text| text.parse().ok()).collect()
}

/// True direction of the middle of a fire, arc-minutes.
fn direction(spec: &FireSpec) -> (f64, f64) {
    let fire = Fire::new(*spec);
    let up = libm::atan2(fire.size_m / 2.0 - HEIGHT_M, spec.range_m);
    (spec.azimuth_deg * 60.0, up.to_degrees() * 60.0)
}

fn search(case: &Case, seed: u64) -> Option<Outcome> {
    let fires: Vec<FireSpec> = parsed(case.fires);
    let (glares, walls) = (parsed(case.glares), parsed(case.walls));
    let config = Config { seed, fires: fires.clone(), glares, walls, ..Config::default() };
    let mut bench = Bench::deployed(config);
    if case.dirty {
        bench.0.world_mut().inject(Fault::Single(SingleFault::DirtyLens));
    }
    bench.send(&format!("{SEEK}{}", if case.analyse { " analyse" } else { "" }));
    let started = bench.until("Detector flags has Searching", 1_000)?;
    let took = bench.until("Detector flags lacks Searching", 600_000)?;
    let hotbeds = bench.hotbeds();
    let truths: Vec<(f64, f64)> = fires.iter().map(direction).collect();
    let (mut found, mut off_arcmin) = (0, 0.0_f64);
    for hotbed in &hotbeds {
        let middle = |a: i32, b: i32| f64::from(a + b) / 2.0;
        let at = (middle(hotbed.x1, hotbed.x2), middle(hotbed.y1, hotbed.y2));
        let off = |truth: &(f64, f64)| libm::hypot(at.0 - truth.0, at.1 - truth.1);
        let nearest = truths.iter().map(off).fold(f64::INFINITY, f64::min);
        // Farther off than 3° it is something else.
        if nearest < 180.0 {
            found += 1;
            off_arcmin = off_arcmin.max(nearest);
        }
    }
    let took_s = (started + took) as f64 / 1000.0;
    Some(Outcome { found, false_ones: hotbeds.len() - found, off_arcmin, took_s })
}

/// Searches of a sector of 90° × 20°.
pub fn table() -> String {
    let mut table = Table::new(&[
        "what burns",
        "fires",
        "hotbeds at fires",
        "false hotbeds",
        "middle off by at most",
        "search, s",
    ]);
    for case in CASES {
        let outcomes: Vec<Outcome> = (1..=SEEDS).filter_map(|seed| search(case, seed)).collect();
        let range = |of: fn(&Outcome) -> usize| {
            let least = outcomes.iter().map(of).min().unwrap_or(0);
            let most = outcomes.iter().map(of).max().unwrap_or(0);
            if least == most { format!("{least}") } else { format!("{least}–{most}") }
        };
        let most =
            |of: fn(&Outcome) -> f64| outcomes.iter().map(of).fold(0.0, |a: f64, b| a.max(b));
        let none = outcomes.iter().all(|outcome| outcome.found == 0);
        table.row(&[
            case.name.to_owned(),
            format!("{}", case.fires.len()),
            range(|outcome| outcome.found),
            range(|outcome| outcome.false_ones),
            if none { "—".to_owned() } else { format!("{:.0}′", most(|o| o.off_arcmin)) },
            format!("{:.1}", most(|outcome| outcome.took_s)),
        ]);
    }
    table.0
}

/// Time of a search by its sector, from 10° below the horizon, of a deployed monitor and of a
/// wrapped one.
pub fn sectors() -> String {
    let mut table = Table::new(&[
        "sector, °",
        "deployed: search, s",
        "wrapped: deploying and search, s",
        "found",
    ]);
    for (wide, high) in [(40, 10), (90, 20), (180, 20), (180, 40)] {
        let (side, top) = (30 * wide, 60 * high - 600);
        let seek = format!("StartSeek Detector -{side} {side} -600 {top}");
        let fire: Vec<FireSpec> = parsed(&["az=15,range=25,size=1.5"]);
        let took = |deployed: bool| {
            let config = Config { fires: fire.clone(), ..Config::default() };
            let mut bench =
                if deployed { Bench::deployed(config) } else { Bench::powered_up(config) };
            bench.send(&seek);
            let started = bench.until("Detector flags has Searching", 1_000)?;
            let took = bench.until("Detector flags lacks Searching", 600_000)?;
            Some(((started + took) as f64 / 1000.0, bench.hotbeds().len()))
        };
        let (deployed, wrapped) = (took(true), took(false));
        let seconds =
            |took: Option<(f64, usize)>| took.map_or("—".to_owned(), |(s, _)| format!("{s:.1}"));
        table.row(&[
            format!("{wide} × {high}"),
            seconds(deployed),
            seconds(wrapped),
            deployed.map_or("—".to_owned(), |(_, found)| format!("{found} of 1")),
        ]);
    }
    table.0
}

/// What an extinguishing took.
struct Extinguished {
    searched_s: f64,
    jet_s: f64,
    out_s: f64,
    litres: f64,
}

/// Finds a fire, aims at its hotbed, sweeps it until it is out.
fn extinguish(fire: &str, (wind, gusts): ((f64, f64), f64), seed: u64) -> Option<Extinguished> {
    let spec: FireSpec = fire.parse().ok()?;
    let mut bench =
        Bench::deployed(Config { seed, fires: vec![spec], wind, gusts, ..Config::default() });
    let start = bench.0.now_ms();
    bench.send(SEEK);
    bench.until("Detector flags has Searching", 1_000)?;
    bench.until("Detector flags lacks Searching", 600_000)?;
    let searched = bench.0.now_ms();
    let hotbed = *bench.hotbeds().first()?;
    let (h, v) = ((hotbed.x1 + hotbed.x2) / 2, (hotbed.y1 + hotbed.y2) / 2);
    let width = (hotbed.x1 - hotbed.x2).abs() / 2;
    bench.send(&format!(
        "StartQuench Control centre={h},{v} nozzle=60 sector={width},0 step=1 distance={:.0}",
        spec.range_m
    ));
    bench.send("Open Valve1");
    bench.0.world_mut().take_events();
    let (mut litres, mut jet_ms) = (0.0, None);
    for _ in 0..60_000 {
        bench.0.tick();
        litres += bench.0.world().water.jet_lps() / 100.0;
        let events = bench.0.world_mut().take_events();
        if events.iter().any(|event| event.what == What::JetOn) {
            jet_ms = jet_ms.or(Some(bench.0.now_ms()));
        }
        if events.iter().any(|event| matches!(event.what, What::FireOut(_))) {
            let now = bench.0.now_ms();
            let seconds = |ms: u64| ms as f64 / 1000.0;
            return Some(Extinguished {
                searched_s: seconds(searched - start),
                jet_s: seconds(jet_ms? - start),
                out_s: seconds(now - start),
                litres,
            });
        }
    }
    None
}

/// Range of a figure over several runs.
fn spread(values: &[f64]) -> String {
    let (least, most) = values
        .iter()
        .fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), value| (a.min(*value), b.max(*value)));
    let (least, most) = (format!("{least:.0}"), format!("{most:.0}"));
    if least == most { least } else { format!("{least}–{most}") }
}

/// From the start of the search until the fire is out, in still air, in wind and in gusts.
pub fn extinguishing() -> String {
    let mut table = Table::new(&[
        "fire",
        "wind, m/s: forward, left",
        "I",
        "search ends, s",
        "jet complete, s",
        "out, s",
        "water used, l",
    ]);
    let fires = ["az=20,range=20,size=1.5", "az=20,range=30,size=1.5", "az=-10,range=38,size=1.5"];
    for fire in fires {
        for blows in [
            ((0.0, 0.0), 0.0),
            ((-5.0, 0.0), 0.0),
            ((-5.0, 0.0), 0.3),
            ((0.0, 5.0), 0.0),
            ((0.0, 5.0), 0.3),
        ] {
            let seeds = if blows.1 > 0.0 { SEEDS } else { 1 };
            let runs: Vec<Extinguished> =
                (1..=seeds).filter_map(|seed| extinguish(fire, blows, seed)).collect();
            let over =
                |of: fn(&Extinguished) -> f64| spread(&runs.iter().map(of).collect::<Vec<_>>());
            let cells = match runs.len() as u64 == seeds {
                true => [
                    format!("{:.1}", runs[0].searched_s),
                    over(|run| run.jet_s),
                    over(|run| run.out_s),
                    over(|run| run.litres),
                ],
                false => ["—", "—", "not always in 10 min", "—"].map(str::to_owned),
            };
            let ((forward, left), intensity) = blows;
            let head =
                [fire.to_owned(), format!("{forward:.0}, {left:.0}"), format!("{intensity}")];
            table.row(&head.into_iter().chain(cells).collect::<Vec<_>>());
        }
    }
    table.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What docs/physics.md promises of a search.
    #[test]
    fn finds_what_can_be_seen() {
        let outcome = |name: &str| {
            let case = CASES.iter().find(|case| case.name == name).unwrap();
            search(case, 3).unwrap()
        };
        let plain = outcome("1.5 m at 25 m");
        assert!(plain.found == 1 && plain.false_ones == 0 && plain.off_arcmin < 30.0);
        assert_eq!(outcome("dirty lens, 1 m at 50 m: lost").found, 0);
        assert_eq!(outcome("behind a wall: hidden").found, 0);
        let sun = outcome("low sun: a false hotbed");
        assert_eq!((sun.found, sun.false_ones), (1, 1));
    }

    #[test]
    fn puts_a_fire_out() {
        let done = extinguish("az=20,range=20,size=1.5", ((0.0, 0.0), 0.0), 1).unwrap();
        assert!(done.out_s < 180.0 && done.litres < 3_000.0, "{} {}", done.out_s, done.litres);
    }
}
