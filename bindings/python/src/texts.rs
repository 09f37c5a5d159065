//! What this part says itself: the texts are with those of the package, in `lafet/_texts.py`.

use std::fmt::Display;

use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The text of a key in the language that was chosen.
pub fn say(key: &str, values: &[(&str, &dyn Display)]) -> String {
    let said = Python::attach(|py| -> PyResult<String> {
        let named = PyDict::new(py);
        for (name, value) in values {
            named.set_item(name, value.to_string())?;
        }
        py.import("lafet._texts")?.call_method("say", (key,), Some(&named))?.extract()
    });
    // The key shows what is wrong, too.
    said.unwrap_or_else(|error| format!("{key}: {error}"))
}
