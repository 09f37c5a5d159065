//! How many detectors of how many: `2oo3`.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// `MooN`: so many votes of so many detectors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Votes {
    /// Votes that are needed.
    pub need: u16,
    /// Detectors that can vote.
    pub of: u16,
}

impl fmt::Display for Votes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}oo{}", self.need, self.of)
    }
}

impl From<Votes> for String {
    fn from(votes: Votes) -> Self {
        votes.to_string()
    }
}

impl FromStr for Votes {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once("oo");
        let parts = parts.and_then(|(need, of)| Some((need.parse().ok()?, of.parse().ok()?)));
        let (need, of) = parts
            .ok_or_else(|| format!("`{text}` is no vote: write 2oo3 for two of three detectors"))?;
        Ok(Self { need, of })
    }
}

impl TryFrom<String> for Votes {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

/// What the vote becomes with a failed detector: other votes, or an alarm without release.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Reduced {
    /// These votes of the detectors that are left.
    Votes(Votes),
    /// An alarm that releases nothing.
    Alarm,
}

impl From<Reduced> for String {
    fn from(reduced: Reduced) -> Self {
        match reduced {
            Reduced::Votes(votes) => votes.to_string(),
            Reduced::Alarm => "alarm".to_owned(),
        }
    }
}

impl TryFrom<String> for Reduced {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        if text == "alarm" { Ok(Self::Alarm) } else { text.parse().map(Self::Votes) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn votes_are_written_as_they_are_read() {
        for text in ["1oo1", "2oo3", "10oo12"] {
            assert_eq!(text.parse::<Votes>().unwrap().to_string(), text);
        }
        for text in ["", "2", "2o3", "oo", "2oo", "-1oo2", "2oo70000"] {
            assert!(text.parse::<Votes>().unwrap_err().contains("2oo3"), "{text}");
        }
        assert_eq!(Reduced::try_from("alarm".to_owned()), Ok(Reduced::Alarm));
        assert_eq!(String::from(Reduced::Votes(Votes { need: 1, of: 2 })), "1oo2");
    }
}
