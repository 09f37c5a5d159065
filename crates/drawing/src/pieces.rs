//! The pieces of hub.toml.

use std::fmt::Write as _;

use lafet_texts::{Lang, Text as _, drawing as text};

use crate::site::{Plan, Spot, Tank, Wall};

/// The plan as tables of hub.toml. Places of monitors and detectors are comments: their tables have more than
/// a drawing knows.
pub fn toml(plan: &Plan, lang: Lang) -> String {
    let mut out = String::new();
    plan.tanks.iter().for_each(|it| tank(&mut out, it));
    plan.walls.iter().for_each(|it| wall(&mut out, it));
    for (spots, table) in [(&plan.monitors, "monitor"), (&plan.detectors, "detector")] {
        if !spots.is_empty() {
            let note = text::PiecesSpots { table }.of(lang);
            _ = writeln!(out, "# {note}");
        }
        spots.iter().for_each(|it| spot(&mut out, it, table));
    }
    out
}

fn tank(out: &mut String, it: &Tank) {
    let (name, at) = (quoted(&it.name), pair(it.at));
    let (diameter, height) = (number(it.diameter), number(it.height));
    _ = writeln!(
        out,
        "[[tank]]\nname = {name}\nat = {at}\ndiameter = {diameter}\nheight = {height}\n"
    );
}

fn wall(out: &mut String, it: &Wall) {
    let (name, from, to) = (quoted(&it.name), pair(it.from), pair(it.to));
    let height = number(it.height);
    _ = writeln!(out, "[[wall]]\nname = {name}\nfrom = {from}\nto = {to}\nheight = {height}\n");
}

fn spot(out: &mut String, it: &Spot, table: &str) {
    let [east, north] = it.at.map(number);
    _ = writeln!(out, "# {}", it.name);
    _ = match (table, it.height.map(number)) {
        ("detector", Some(up)) => writeln!(out, "# at = [{east}, {north}, {up}]\n"),
        (_, Some(height)) => writeln!(out, "# at = [{east}, {north}]\n# height = {height}\n"),
        (_, None) => writeln!(out, "# at = [{east}, {north}]\n"),
    };
}

/// A text as TOML has it.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' | '\\' => out.extend(['\\', letter]),
            letter if letter.is_control() => {}
            letter => out.push(letter),
        }
    }
    out.push('"');
    out
}

fn pair(at: [f64; 2]) -> String {
    let [east, north] = at.map(number);
    format!("[{east}, {north}]")
}

/// Metres, to the millimetre.
fn number(metres: f64) -> String {
    let rounded = (metres * 1000.0).round() / 1000.0;
    // No "-0.0", and a point in each: the hub reads fractions.
    format!("{:?}", rounded + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_names_are_those_of_toml() {
        assert_eq!([12.0, -0.0001, 41.99960001, -7.5].map(number), ["12.0", "0.0", "42.0", "-7.5"]);
        assert_eq!(quoted("a\"b\\c\u{7}"), r#""a\"b\\c""#);
    }
}
