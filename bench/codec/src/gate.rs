//! The gate: instructions must not drift away from those that are written down.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::process::Command;

/// Relative drift that is still the same.
const TOLERANCE: f64 = 0.03;

/// Writes the counts down, with the compiler that made the program.
pub fn write(path: &Path, counts: &BTreeMap<&str, f64>) -> Result<(), String> {
    let mut text = format!("compiler\t{}\n", compiler()?);
    for (name, count) in counts {
        let _ = writeln!(text, "{name}\t{count:.1}");
    }
    std::fs::write(path, text).map_err(|e| format!("{}: {e}", path.display()))
}

/// Compares; another compiler makes other code, which proves nothing.
pub fn check(path: &Path, counts: &BTreeMap<&str, f64>) -> Result<String, String> {
    let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let (first, rest) = text.split_once('\n').unwrap_or((&text, ""));
    let (made, have) = (first.trim_start_matches("compiler\t"), compiler()?);
    if made != have {
        return Ok(format!("not compared: counted with {made}, this is {have}"));
    }
    compare(rest, counts)
}

fn compare(written: &str, counts: &BTreeMap<&str, f64>) -> Result<String, String> {
    let mut drifts = Vec::new();
    let mut left: Vec<&str> = counts.keys().copied().collect();
    for (name, count) in written.lines().filter_map(|line| line.split_once('\t')) {
        let was: f64 = count.parse().map_err(|e| format!("{name}: {e}"))?;
        left.retain(|known| *known != name);
        match counts.get(name) {
            None => drifts.push(format!("{name} is no longer measured")),
            Some(now) if (now - was).abs() > was * TOLERANCE => {
                drifts.push(format!("{name}: {was} instructions, now {now:.1}"));
            }
            Some(_) => {}
        }
    }
    drifts.extend(left.iter().map(|name| format!("{name} is not written down")));
    if drifts.is_empty() {
        return Ok(format!("{} counts within ±{} %", counts.len(), TOLERANCE * 100.0));
    }
    let drifts = drifts.join("\n  ");
    Err(format!("instructions have drifted:\n  {drifts}\nMeant so? cargo xtask bench --only codec"))
}

fn compiler() -> Result<String, String> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output =
        Command::new(rustc).arg("--version").output().map_err(|e| format!("rustc: {e}"))?;
    let text = String::from_utf8_lossy(&output.stdout);
    let words: Vec<&str> = text.split_whitespace().take(2).collect();
    Ok(format!("{} for {}", words.join(" "), std::env::consts::ARCH))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_drifts_is_named() {
        let counts = BTreeMap::from([("a", 100.0), ("b", 104.0)]);
        assert!(compare("a\t102\nb\t104\n", &counts).is_ok());
        let error = compare("a\t100\nb\t100\n", &counts).unwrap_err();
        assert!(error.contains("b: 100 instructions, now 104.0") && !error.contains("a:"));
        assert!(compare("a\t100\n", &counts).unwrap_err().contains("b is not written down"));
        let error = compare("a\t100\nb\t104\nc\t1\n", &counts).unwrap_err();
        assert!(error.contains("c is no longer measured"));
    }
}
