//! Instructions of each case, counted by valgrind's callgrind in one run of this program.

use std::collections::BTreeMap;
use std::process::Command;

/// How often each case is run: what happens once must not show.
const TIMES: &str = "64";

/// Instructions a run, by the function's name. What a case calls is counted with it.
pub fn instructions() -> Result<BTreeMap<String, f64>, String> {
    let program = std::env::current_exe().map_err(|e| e.to_string())?;
    let file = program.with_extension("callgrind");
    let mut command = Command::new("valgrind");
    command.args(["--tool=callgrind", "--error-exitcode=1"]);
    command.arg(format!("--callgrind-out-file={}", file.display()));
    let output = command.arg(&program).args(["count", TIMES]).output();
    let output = output.map_err(|e| format!("valgrind is missing ({e})"))?;
    if !output.status.success() {
        return Err(format!("valgrind: {}", String::from_utf8_lossy(&output.stderr)));
    }
    let text = std::fs::read_to_string(&file).map_err(|e| format!("{}: {e}", file.display()))?;
    Ok(inclusive(&text))
}

/// What all calls of each function have cost, by the number of calls.
fn inclusive(profile: &str) -> BTreeMap<String, f64> {
    let mut names: BTreeMap<&str, &str> = BTreeMap::new();
    let mut costs: BTreeMap<&str, (f64, f64)> = BTreeMap::new();
    let mut callee = "";
    let mut calls = None;
    for line in profile.lines() {
        if let Some(times) = calls.take() {
            let cost = line.split_whitespace().nth(1).and_then(|word| word.parse::<f64>().ok());
            let entry = costs.entry(callee).or_default();
            *entry = (entry.0 + times, entry.1 + cost.unwrap_or(0.0));
        } else if let Some(name) = line.strip_prefix("cfn=") {
            callee = resolve(&mut names, name);
        } else if let Some(name) = line.strip_prefix("fn=") {
            resolve(&mut names, name);
        } else if let Some(rest) = line.strip_prefix("calls=") {
            calls = rest.split_whitespace().next().and_then(|word| word.parse::<f64>().ok());
        }
    }
    costs.into_iter().map(|(name, (times, cost))| (name.to_owned(), cost / times)).collect()
}

/// `(7) name` names number 7, `(7)` means it.
fn resolve<'a>(names: &mut BTreeMap<&'a str, &'a str>, text: &'a str) -> &'a str {
    match text.split_once(' ') {
        Some((number, name)) => {
            names.insert(number, name);
            name
        }
        None => names.get(text).copied().unwrap_or(text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calls_from_everywhere_are_added_up() {
        let profile = "fn=(1) main\n0 5\ncfn=(2) a::b\ncalls=10 3\n0 200\n\nfn=(2)\n3 20\n\n\
                       fn=(3) other\n0 1\ncfn=(2)\ncalls=10 3\n0 220\n";
        assert_eq!(inclusive(profile).get("a::b"), Some(&21.0));
    }
}
