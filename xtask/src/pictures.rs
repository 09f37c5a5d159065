//! The pictures of scenarios in docs/images, made by `lafet sim run`, and the moving picture of the
//! READMEs, made of moments of `lafet demo`.

use std::fmt::Write as _;
use std::process::ExitCode;

use crate::TaskResult;
use crate::run::{self, StepResult};

/// Picture, scenario, language.
const PICTURES: [(&str, &str, &str); 2] = [
    ("docs/images/tank-farm.svg", "tank-farm", "en"),
    ("docs/images/tank-farm.ru.svg", "tank-farm", "ru"),
];

/// Moving picture, language, what it shows.
const MOVING: [(&str, &str, &str); 2] = [
    ("docs/images/fire.svg", "en", "A simulated monitor searches, finds a fire, and puts it out"),
    ("docs/images/fire.ru.svg", "ru", "Имитируемый ствол ищет очаг, находит его и тушит"),
];
/// The demonstration that it shows.
const SEED: &str = "7";
/// Simulated seconds of its frames: denser where more changes.
const MOMENTS: [u32; 18] = [1, 4, 8, 12, 16, 20, 23, 26, 29, 33, 37, 41, 45, 50, 55, 61, 68, 76];
/// A frame is seen for this time, seconds; the last one longer.
const FRAME_S: f64 = 0.7;
const LAST_S: f64 = 2.5;

/// `cargo xtask pictures`: the moving picture of the READMEs. Its frames name the port of the run, so it is
/// not compared with a fresh one.
pub fn pictures(arguments: &[String]) -> TaskResult {
    crate::flag(arguments, None)?;
    for (path, lang, title) in MOVING {
        let mut frames = Vec::new();
        for at in MOMENTS {
            frames.push(moment(lang, at)?);
        }
        let picture = animated(&frames, title)?;
        std::fs::write(run::root().join(path), &picture).map_err(|e| format!("{path}: {e}"))?;
        println!("   {path}: {} frames, {} KiB", frames.len(), picture.len() / 1024);
    }
    Ok(ExitCode::SUCCESS)
}

/// One moment of the demonstration, as SVG.
fn moment(lang: &str, at: u32) -> Result<String, String> {
    let path = run::target().join(format!("fire-{lang}-{at}.svg"));
    let (file, at) = (path.to_string_lossy().into_owned(), at.to_string());
    let demo = ["demo", "--lang", lang, "--seed", SEED, "--speed", "0"];
    run::output(run::tested("lafet").args(demo).args(["--picture", &file, "--picture-at", &at]))?;
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{file}: {e}"))?;
    Ok(without_port(&text))
}

/// The port of the run is chance.
fn without_port(text: &str) -> String {
    let Some((before, after)) = text.split_once("127.0.0.1:") else { return text.to_owned() };
    let rest = after.trim_start_matches(|c: char| c.is_ascii_digit());
    let blanks = " ".repeat(5_usize.saturating_sub(after.len() - rest.len()));
    format!("{before}127.0.0.1:10485{blanks}{rest}")
}

/// The frames one after another, in one picture that needs no script. An element is in it once for each
/// row of frames that has it; where motion is not wanted, the last but one is seen.
fn animated(frames: &[String], title: &str) -> Result<String, String> {
    let first = frames.first().ok_or("no frames")?;
    let (head, _) = first.split_once('\n').ok_or("a frame without lines")?;
    let mut spans: Vec<(usize, usize, Vec<&str>)> = Vec::new();
    let mut seen: Vec<&str> = Vec::new();
    for line in frames.iter().flat_map(|frame| elements(frame)) {
        if seen.contains(&line) {
            continue;
        }
        seen.push(line);
        let has: Vec<bool> = frames.iter().map(|f| elements(f).any(|l| l == line)).collect();
        for (start, end) in runs(&has) {
            match spans.iter_mut().find(|(a, b, _)| (*a, *b) == (start, end)) {
                Some((_, _, lines)) => lines.push(line),
                None => spans.push((start, end, vec![line])),
            }
        }
    }
    // What is seen longest lies below: backgrounds before letters.
    spans.sort_by_key(|(start, end, _)| (usize::MAX - (end - start), *start));
    Ok(drawn(head, title, frames.len(), &spans))
}

/// The elements of a frame, a line each.
fn elements(frame: &str) -> impl Iterator<Item = &str> {
    frame.lines().skip(1).filter(|line| *line != "</svg>")
}

/// Rows of `true`: first and one past the last.
fn runs(has: &[bool]) -> Vec<(usize, usize)> {
    let mut found: Vec<(usize, usize)> = Vec::new();
    for (index, _) in has.iter().enumerate().filter(|(_, has)| **has) {
        match found.last_mut() {
            Some((_, end)) if *end == index => *end += 1,
            _ => found.push((index, index + 1)),
        }
    }
    found
}

fn drawn(head: &str, title: &str, count: usize, spans: &[(usize, usize, Vec<&str>)]) -> String {
    let whole = (count - 1) as f64 * FRAME_S + LAST_S;
    let percent = |frame: usize| match frame == count {
        true => 100.0,
        false => frame as f64 * FRAME_S / whole * 100.0,
    };
    let still = count.saturating_sub(4);
    let (mut style, mut body) = (String::new(), String::new());
    for (number, (start, end, lines)) in spans.iter().enumerate() {
        let (from, to) = (percent(*start), percent(*end));
        if (*start, *end) == (0, count) {
            let _ = writeln!(body, "<g>\n{}\n</g>", lines.join("\n"));
            continue;
        }
        let off = if *end == count { String::new() } else { format!("{to:.2}%{{opacity:0}}") };
        let before = if *start == 0 { "" } else { "0%{opacity:0}" };
        let _ = writeln!(style, "@keyframes k{number}{{{before}{from:.2}%{{opacity:1}}{off}}}");
        let shown = if (*start..*end).contains(&still) { "" } else { " class=\"h\"" };
        let _ = writeln!(
            body,
            "<g{shown} style=\"animation:k{number} {whole:.1}s step-end infinite\">\n{}\n</g>",
            lines.join("\n")
        );
    }
    let quiet =
        "@media(prefers-reduced-motion:reduce){g{animation:none!important}.h{display:none}}";
    format!(
        "{}\n<title>{title}</title>\n<style>\n{style}{quiet}\n</style>\n{body}</svg>\n",
        head.replacen("<svg ", "<svg role=\"img\" ", 1)
    )
}

/// Generates the pictures.
pub fn write() -> StepResult {
    for (path, scenario, lang) in PICTURES {
        let picture = draw(scenario, lang)?;
        let state = if run::read(path).is_ok_and(|old| old == picture) {
            "was up to date"
        } else {
            std::fs::write(run::root().join(path), picture).map_err(|e| format!("{path}: {e}"))?;
            "written"
        };
        println!("   {path}: {state}");
    }
    Ok(())
}

/// Fails on a picture that differs from what `lafet sim run` draws.
pub fn check() -> StepResult {
    let mut old = Vec::new();
    for (path, scenario, lang) in PICTURES {
        if run::read(path)? != draw(scenario, lang)? {
            old.push(format!("{path}: run `cargo xtask docs`"));
        }
    }
    run::verdict("pictures that are out of date", &old)
}

fn draw(scenario: &str, lang: &str) -> Result<String, String> {
    let path = run::root().join("target").join(format!("{scenario}.{lang}.svg"));
    let file = path.to_string_lossy();
    std::fs::create_dir_all(run::root().join("target")).map_err(|e| format!("target: {e}"))?;
    let words = ["sim", "run", scenario, "--lang", lang, "--svg", &file];
    run::output(run::tested("lafet").args(words))?;
    std::fs::read_to_string(&path).map_err(|e| format!("{file}: {e}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(lines: &[&str]) -> String {
        format!("<svg viewBox=\"0 0 1 1\">\n{}\n</svg>\n", lines.join("\n"))
    }

    #[test]
    fn an_element_is_written_once_for_each_row_of_frames() {
        let frames = [frame(&["<a/>", "<b/>"]), frame(&["<a/>"]), frame(&["<a/>", "<b/>", "<c/>"])];
        let picture = animated(&frames, "what").unwrap();
        assert_eq!(picture.matches("<a/>").count(), 1);
        assert_eq!(picture.matches("<b/>").count(), 2);
        assert_eq!(picture.matches("<c/>").count(), 1);
        // Elements of the same frames share one.
        assert_eq!(picture.matches("@keyframes").count(), 2);
        assert!(picture.contains("<title>what</title>") && picture.ends_with("</svg>\n"));
        assert!(animated(&[], "what").is_err());
    }

    #[test]
    fn rows_are_found() {
        assert_eq!(runs(&[true, true, false, true]), [(0, 2), (3, 4)]);
        assert_eq!(runs(&[false, false]), []);
    }

    #[test]
    fn the_port_of_a_run_is_not_shown() {
        assert_eq!(without_port("at 127.0.0.1:45363  seed"), "at 127.0.0.1:10485  seed");
        assert_eq!(without_port("at 127.0.0.1:80 x"), "at 127.0.0.1:10485    x");
        assert_eq!(without_port("nowhere"), "nowhere");
    }
}
