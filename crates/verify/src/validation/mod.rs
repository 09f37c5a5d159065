//! Validation: the models beside what is published, and the monitor's aim beside the models.
//!
//! Each function makes one table of docs/physics.md, in Markdown; [`page`] makes all of them. They
//! are computed, not kept: `cargo xtask physics --check` fails when the page says something else.

mod aim;
mod bench;
mod breakup;
mod effective;
mod foam;
mod gusts;
mod measured;
mod notes;
mod plant;
mod reach;
mod search;
mod throws;

/// A table by the name that marks it in docs/physics.md.
pub type Named = (&'static str, String);

/// Every table, in the order of the page.
pub fn page() -> Vec<Named> {
    vec![
        ("flow", throws::flow()),
        ("breakup", breakup::table()),
        ("throws", throws::throws()),
        ("reach", reach::rows()),
        ("reach-measured", reach::nozzles()),
        ("reach-cross", reach::cross()),
        ("reach-summary", reach::summary()),
        ("effective", effective::table()),
        ("ranges", throws::ranges()),
        ("spray", throws::spray()),
        ("torch", throws::torch()),
        ("aim", aim::still()),
        ("aim-sprays", aim::sprays()),
        ("aim-running", aim::running()),
        ("solutions", aim::solutions()),
        ("correction", aim::correction()),
        ("calibration", aim::calibration()),
        ("notes", notes::table()),
        ("wind", aim::wind()),
        ("gusts", gusts::factors()),
        ("gusts-aim", gusts::aim()),
        ("filling", plant::filling()),
        ("closing", plant::closing()),
        ("extinction", plant::extinction()),
        ("foam", foam::rates()),
        ("foam-blanket", foam::blankets()),
        ("foam-water", foam::water()),
        ("spread", plant::spread()),
        ("neighbour", foam::neighbour()),
        ("search", search::table()),
        ("sectors", search::sectors()),
        ("extinguishing", search::extinguishing()),
    ]
}

/// A table in Markdown.
struct Table(String);

impl Table {
    fn new(titles: &[&str]) -> Self {
        let rule: Vec<&str> = titles.iter().map(|_| "---").collect();
        Self(format!("| {} |\n| {} |\n", titles.join(" | "), rule.join(" | ")))
    }

    fn row(&mut self, cells: &[String]) {
        self.0 += &format!("| {} |\n", cells.join(" | "));
    }
}

/// Signed per cent.
fn percent(model: f64, measured: f64) -> String {
    format!("{:+.1} %", (model / measured - 1.0) * 100.0)
}
