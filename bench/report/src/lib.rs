//! What a benchmark prints: sections of text, each with a name, that `cargo xtask bench` puts between
//! the marks of docs/performance.md, or into a picture where the name ends in `.svg`.

mod plot;

pub use plot::{Bars, Lines};

/// Begins a section.
pub fn section(name: &str, text: &str) {
    println!("== {name}\n{}", text.trim_end());
}

/// A table of Markdown.
pub struct Table {
    text: String,
}

impl Table {
    /// With these columns.
    pub fn new<T: AsRef<str>>(columns: &[T]) -> Self {
        let mut table = Self { text: String::new() };
        table.row(columns);
        table.row(
            &columns
                .iter()
                .enumerate()
                .map(|(i, _)| if i == 0 { "---" } else { "---:" })
                .collect::<Vec<_>>(),
        );
        table
    }

    /// Appends a row.
    pub fn row<T: AsRef<str>>(&mut self, cells: &[T]) {
        let cells: Vec<&str> = cells.iter().map(AsRef::as_ref).collect();
        self.text += &format!("| {} |\n", cells.join(" | "));
    }

    /// The table's text.
    pub fn text(&self) -> &str {
        &self.text
    }
}

/// Figures against their goals.
pub struct Goals {
    table: Table,
}

impl Default for Goals {
    fn default() -> Self {
        Self { table: Table::new(&["goal", "at", "measured", ""]) }
    }
}

impl Goals {
    /// At most so much.
    pub fn at_most(&mut self, what: &str, goal: f64, got: f64, unit: &str) {
        self.put(what, &format!("≤ {}", number(goal)), got, unit, got <= goal);
    }

    /// At least so much.
    pub fn at_least(&mut self, what: &str, goal: f64, got: f64, unit: &str) {
        self.put(what, &format!("≥ {}", number(goal)), got, unit, got >= goal);
    }

    fn put(&mut self, what: &str, goal: &str, got: f64, unit: &str, met: bool) {
        let word = if met { "met" } else { "**missed**" };
        let row = [what, &format!("{goal} {unit}"), &format!("{} {unit}", number(got)), word];
        self.table.row(&row.map(str::trim_end));
    }

    /// The table's text.
    pub fn text(&self) -> &str {
        self.table.text()
    }
}

/// A figure with as many digits as say something, and thousands apart.
pub fn number(value: f64) -> String {
    let digits = match value.abs() {
        0.0 => 0,
        v if v < 0.1 => 3,
        v if v < 10.0 && v.fract() != 0.0 => 2,
        v if v < 100.0 && v.fract() != 0.0 => 1,
        _ => 0,
    };
    let text = format!("{value:.digits$}");
    let (whole, rest) = text.split_once('.').map_or((text.as_str(), ""), |(w, r)| (w, r));
    let (sign, whole) = whole.strip_prefix('-').map_or(("", whole), |whole| ("-", whole));
    let mut grouped = String::new();
    for (index, digit) in whole.chars().enumerate() {
        if index > 0 && (whole.len() - index) % 3 == 0 {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    if rest.is_empty() { format!("{sign}{grouped}") } else { format!("{sign}{grouped}.{rest}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_easily() {
        let shown = [0.0, 0.034, 0.5, 3.0, 3.14159, 42.37, 1234.5, 1_000_000.0, -12_345.0];
        let want = ["0", "0.034", "0.50", "3", "3.14", "42.4", "1,234", "1,000,000", "-12,345"];
        assert_eq!(shown.map(number), want);
    }

    #[test]
    fn a_goal_is_met_or_missed() {
        let mut goals = Goals::default();
        goals.at_most("decode", 60.0, 55.0, "instructions");
        goals.at_least("share", 0.93, 0.5, "");
        assert!(goals.text().contains("| decode | ≤ 60 instructions | 55 instructions | met |"));
        assert!(goals.text().contains("| share | ≥ 0.93 | 0.50 | **missed** |"));
    }
}
