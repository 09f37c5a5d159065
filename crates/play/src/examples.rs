//! Sessions for a first visit.

use lafet_sim::fault::Fault;

use crate::playground::payload_of;
use crate::session::{Action, Session};
use crate::view::Link;

/// A session for a first visit.
pub struct Example {
    /// Its name; its title is in the page's texts.
    pub key: &'static str,
    steps: &'static [(u32, Step)],
    /// Duration, s.
    seconds: u32,
}

enum Step {
    Wired(&'static str),
    Radio(&'static str),
    Break(&'static str),
    Light(i16, u8),
}

use Step::{Break, Light, Radio, Wired};

/// The examples in their order; times in seconds.
pub const EXAMPLES: [Example; 5] = [
    Example {
        key: "state",
        steps: &[(1, Wired("GetStatus Deployer; GetStatus Vertical"))],
        seconds: 2,
    },
    Example {
        key: "aim",
        steps: &[
            (1, Light(20, 25)),
            (1, Wired("Deploy")),
            (13, Wired("Move Horizontal 1200; Move Vertical 300")),
            (18, Wired("Open Valve1")),
            (26, Wired("GetStatus All")),
        ],
        seconds: 40,
    },
    Example {
        key: "refused",
        steps: &[
            (1, Wired("Close Valve1")),
            (2, Wired("Move Vertical 600")),
            (3, Wired("Open Valve1")),
        ],
        seconds: 4,
    },
    Example {
        key: "race",
        steps: &[
            (1, Wired("Deploy")),
            (13, Wired("Move Horizontal 1200")),
            (13, Radio("Move Horizontal -1200")),
            (15, Wired("StartSeek -600 600 -300 300")),
            (15, Radio("Move Horizontal 0")),
        ],
        seconds: 20,
    },
    Example {
        key: "switch",
        steps: &[
            (1, Wired("Deploy")),
            (13, Break("vertical-max-switch")),
            (14, Wired("Move Vertical 1800")),
            (16, Wired("GetStatus Vertical")),
            (17, Wired("Move Vertical -300")),
        ],
        seconds: 20,
    },
];

impl Example {
    /// As a session.
    pub fn session(&self) -> Session {
        let mut session = Session::default();
        for (second, step) in self.steps {
            let action = match step {
                Wired(text) => payload_of(text).ok().map(|it| Action::Send(Link::Wired, it)),
                Radio(text) => payload_of(text).ok().map(|it| Action::Send(Link::Radio, it)),
                Break(name) => Fault::from_name(name).map(Action::Break),
                Light(azimuth, range) => Some(Action::Light(*azimuth, *range, false)),
            };
            if let Some(action) = action {
                // They are in order, and a test counts them.
                let pushed = session.push(second * 100, action);
                debug_assert_eq!(pushed, Ok(()));
            }
        }
        session.steps = self.seconds * 100;
        session
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_step_is_an_action_and_fits_a_link() {
        for example in &EXAMPLES {
            let session = example.session();
            assert_eq!(session.actions.len(), example.steps.len(), "{}", example.key);
            assert_eq!(Session::from_fragment(&session.fragment()), Ok(session));
        }
    }
}
