//! How far a jet throws, as `lafet-ballistics` computes it, and what is said of it.

pub use lafet_ballistics::throw::*;
use lafet_texts::{Text, Words, sim as text};

/// Why there is no throw, in words.
pub fn refused(refusal: &Refusal) -> Words {
    let Refusal::Outside { what, value, range } = *refusal else {
        return text::SmoothBoreHasNoSpray.words();
    };
    let (what, unit): (&dyn Text, &dyn Text) = match what {
        Value::Pressure => (&text::Pressure, &text::UnitMpa),
        Value::Outlet => (&text::Outlet, &text::UnitMm),
        Value::Flow => (&text::Flow, &text::UnitLps),
        Value::Nozzle => (&text::NozzlePosition, &text::UnitMm),
        Value::Elevation => (&text::Elevation, &text::UnitDegree),
        Value::Height => (&text::Height, &text::UnitM),
        Value::Wind => (&text::Wind, &text::UnitMps),
        Value::WindDirection => (&text::WindDirection, &text::UnitDegree),
    };
    // Limits of the flow are computed: a hundredth is enough to show.
    let [least, most] = range.map(|limit| (limit * 100.0).round() / 100.0);
    text::OutsideLaw { what, value, unit, least, most }.words()
}

/// What no row covers, in words.
pub fn noted(note: Note) -> Words {
    match note {
        Note::Pressure => text::NotePressure.words(),
        Note::Elevation => text::NoteElevation.words(),
        Note::Monitor => text::NoteMonitor.words(),
        Note::Spray => text::NoteSpray.words(),
        Note::Wind => text::NoteWind.words(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nozzle::NOZZLE_TRAVEL_MM;

    #[test]
    fn what_the_law_does_not_hold_for_is_refused() {
        let good = Shot {
            kind: Kind::Monitor,
            size: Size::Flow(20.0),
            pressure_mpa: 0.8,
            nozzle_mm: NOZZLE_TRAVEL_MM,
            elevation_deg: 30.0,
            height_m: 1.5,
            wind_mps: 0.0,
            wind_from_deg: 0.0,
        };
        for (bad, en, ru) in [
            (
                Shot { pressure_mpa: 8.0, ..good },
                "pressure 8 MPa: the law holds from 0.2 to 2",
                "давление 8",
            ),
            (
                Shot { size: Size::Flow(1.0), ..good },
                "flow 1 l/s: the law holds from 3.67 to 163",
                "расход 1",
            ),
            (Shot { size: Size::Outlet(200.0), ..good }, "outlet 200 mm", "отверстие 200"),
            (Shot { nozzle_mm: 61.0, ..good }, "nozzle 61 mm", "насадка 61"),
            (Shot { elevation_deg: f64::NAN, ..good }, "elevation NaN", "возвышение"),
            (Shot { height_m: -1.0, ..good }, "height -1 m", "высота"),
            (Shot { wind_mps: 40.0, ..good }, "wind 40 m/s", "ветер"),
            (Shot { wind_from_deg: 999.0, ..good }, "wind direction", "направление"),
            (Shot { kind: Kind::Smooth, nozzle_mm: 30.0, ..good }, "no spray", "гладкий"),
        ] {
            let refusal = refused(&bad.throw().unwrap_err());
            assert!(refusal.en.contains(en) && refusal.ru.contains(ru), "{refusal:?}");
        }
    }
}
