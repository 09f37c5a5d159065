//! Commands and answers as JSON: the whole interface of the page.

use lafet_texts::{Shown, Text as _, Words, play as text};
use serde::Serialize;

use crate::playground::Playground;
use crate::session::Setup;
use crate::view::{Command, Description};

/// Bytes of a command at most.
pub const COMMAND_MAX: usize = 32_768;

/// Answers a command: `{"ok": …}`, or `{"error": {"en": …, "ru": …}}`.
pub fn call(playground: &mut Playground, command: &[u8]) -> Vec<u8> {
    match execute(playground, command) {
        Ok(answer) => answer,
        Err(error) => json(&serde_json::json!({ "error": error })),
    }
}

fn execute(playground: &mut Playground, command: &[u8]) -> Result<Vec<u8>, Words> {
    if command.len() > COMMAND_MAX {
        return Err(text::CommandTooLong { most: COMMAND_MAX }.words());
    }
    let command: Command = serde_json::from_slice(command)
        .map_err(|error| text::CommandWrong { error: Shown(error) }.words())?;
    Ok(match command {
        Command::Describe {} => ok(&Description::new()),
        Command::Start { seed, profile, wind } => {
            *playground = Playground::new(Setup::new(seed, &profile, wind)?);
            ok(&playground.view(0))
        }
        Command::Open { fragment } => {
            *playground = Playground::open(&fragment)?;
            ok(&playground.view(0))
        }
        Command::Advance { ms, since } => {
            playground.advance(ms);
            ok(&playground.view(since))
        }
        Command::Read { input } => ok(&playground.read(&input)?),
        Command::Act { act } => {
            let first = playground.act(&act)?;
            ok(&playground.view(first))
        }
        Command::Share {} => ok(&playground.session().fragment()),
    })
}

fn ok<T: Serialize>(answer: &T) -> Vec<u8> {
    #[derive(Serialize)]
    struct Fine<'a, T> {
        ok: &'a T,
    }
    json(&Fine { ok: answer })
}

/// Structures of this crate have no keys or values that JSON lacks.
fn json<T: Serialize>(value: &T) -> Vec<u8> {
    serde_json::to_vec(value).unwrap_or_default()
}
