//! The scenarios that come with lafet, embedded: they work without the repository.

use super::plan::Exercise;
use super::reader::Problem;

/// A scenario that comes with lafet.
#[derive(Clone, Copy, Debug)]
pub struct Shipped {
    /// Its name: that of its file without `.toml`.
    pub name: &'static str,
    /// The text of the file.
    pub text: &'static str,
}

macro_rules! shipped {
    ($($name:literal),+ $(,)?) => {
        /// All of them.
        pub const SHIPPED: &[Shipped] = &[$(Shipped {
            name: $name,
            text: include_str!(concat!("../../scenarios/", $name, ".toml")),
        }),+];
    };
}

shipped! {
    "tank-farm",
    "hangar",
    "turbine-hall",
    "winter-start",
    "two-fires",
    "jammed-drive",
    "lost-pressure",
    "radio-loss",
}

impl Shipped {
    /// The scenario with this name, with or without `.toml`.
    pub fn by_name(name: &str) -> Option<&'static Self> {
        let name = name.strip_suffix(".toml").unwrap_or(name);
        SHIPPED.iter().find(|shipped| shipped.name == name)
    }

    /// The scenario, read.
    pub fn exercise(&self) -> Result<Exercise, Problem> {
        Exercise::parse(&format!("{}.toml", self.name), self.text)
    }
}
