//! Any bytes as a site's drawing: refused in words of both languages, or a drawing that is within its bounds
//! and can be placed, shown and written as TOML.

use lafet_drawing::placing::{Known, place};
use lafet_drawing::site::{Chosen, Role, site};
use lafet_drawing::{Drawing, Geometry, Limits, Problem, Stated, pieces, read, report};
use lafet_texts::Lang;

/// Small, so that no input is slow.
const LIMITS: Limits =
    Limits { bytes: super::INPUT_MAX, shapes: 500, points: 5000, layers: 20, labels: 50 };

pub fn run(input: &[u8]) -> u64 {
    match read(input, &LIMITS) {
        Ok(drawing) => {
            let points = drawing.shapes.iter().map(|it| points(&it.geometry)).sum::<usize>();
            assert!(drawing.shapes.len() <= LIMITS.shapes && points <= LIMITS.points);
            assert!(drawing.layers.len() <= LIMITS.layers && drawing.labels.len() <= LIMITS.labels);
            assert!(!report::overview(&drawing, Lang::Ru).is_empty());
            used(&drawing);
            (points + drawing.layers.len() + 1) as u64
        }
        Err(problem) => said(&problem),
    }
}

fn points(geometry: &Geometry) -> usize {
    match geometry {
        Geometry::Path { points, .. } => points.len(),
        Geometry::Point(_) | Geometry::Circle { .. } => 1,
    }
}

/// Every layer in every role.
fn used(drawing: &Drawing) {
    let stated = if drawing.pixels.is_some() { Stated::Points } else { stated() };
    let known = Known::of(stated);
    let placed = match place(drawing.clone(), &known) {
        Ok(placed) => placed,
        Err(problem) => {
            said(&problem);
            return;
        }
    };
    for role in Role::ALL {
        let layers = drawing.layers.iter().map(|it| it.name.clone());
        let chosen: Vec<Chosen> =
            layers.map(|layer| Chosen { layer, role, height_m: Some(3.0) }).collect();
        match site(&placed, &chosen, &[], None) {
            Ok(plan) => {
                assert!(!pieces::toml(&plan, Lang::En).contains("NaN"));
                assert!(!report::summary(&placed, &known, &chosen, &plan, Lang::Ru).is_empty());
            }
            Err(problem) => _ = said(&problem),
        }
    }
}

fn stated() -> Stated {
    Stated::by_name("m").expect("a unit")
}

fn said(problem: &Problem) -> u64 {
    let words = [problem.localized(Lang::En), problem.localized(Lang::Ru)];
    assert!(words.iter().all(|it| !it.is_empty() && it.len() < 4000), "{words:?}");
    words[0].len() as u64
}
