//! The pictures of scenarios in docs/images, made by `lafet sim run`.

use crate::run::{self, StepResult};

/// Picture, scenario, language.
const PICTURES: [(&str, &str, &str); 2] = [
    ("docs/images/tank-farm.svg", "tank-farm", "en"),
    ("docs/images/tank-farm.ru.svg", "tank-farm", "ru"),
];

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
