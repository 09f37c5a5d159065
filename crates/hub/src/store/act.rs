//! What an entry of the audit log is about, typed: words are made where it is shown.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::mark::Loss;
use crate::access::Role;

/// Version of [`Act`] in the log: an entry of a later one is shown by its `what`.
const VERSION: u32 = 1;

/// What was done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Act {
    /// A request to a monitor; `what` of the entry is its whole text.
    Request {
        /// Its name, `Move`.
        request: String,
        /// Its addressee, `Vertical`.
        to: String,
    },
    /// A motion by hand; the outcome of the entry is how it ended.
    Jog {
        /// The drive.
        drive: String,
        /// `max` or `min`.
        toward: String,
        /// What is known of its end.
        #[serde(skip_serializing_if = "Option::is_none")]
        end: Option<JogEnding>,
    },
    /// A change of control authority.
    Authority {
        /// `take`, `release`, `request`, `grant`, `deny`, `force`.
        action: String,
        /// Why.
        #[serde(skip_serializing_if = "Option::is_none")]
        reason: Option<String>,
    },
    /// A login.
    Login,
    /// A user has changed the own password.
    ChangeOwnPassword,
    /// A new user.
    AddUser {
        /// The name.
        user: String,
        /// The role.
        role: Role,
    },
    /// A change of a user.
    ChangeUser {
        /// The name.
        user: String,
        /// The new role.
        #[serde(skip_serializing_if = "Option::is_none")]
        role: Option<Role>,
        /// There is a new password.
        password: bool,
    },
    /// A user is removed.
    RemoveUser {
        /// The name.
        user: String,
    },
    /// A new token.
    AddToken {
        /// Its name.
        name: String,
        /// Its role.
        role: Role,
    },
    /// A token is taken back.
    RemoveToken {
        /// Its number.
        id: u64,
    },
    /// A session is ended by an administrator.
    EndSession {
        /// Its id.
        session: String,
    },
    /// An alarm is acknowledged.
    Acknowledge {
        /// Its id.
        alarm: String,
    },
    /// An alarm is shelved.
    Shelve {
        /// Its id.
        alarm: String,
        /// For this time.
        minutes: u64,
        /// Why.
        reason: String,
    },
    /// An alarm is taken off the shelf.
    Unshelve {
        /// Its id.
        alarm: String,
    },
    /// The audit log is exported.
    ExportAudit,
    /// A recording is started.
    StartRecording {
        /// Its name.
        recording: String,
    },
    /// A recording is removed.
    RemoveRecording {
        /// Its name.
        recording: String,
    },
    /// A recording is uploaded.
    UploadRecording {
        /// Its name.
        recording: String,
    },
    /// A scenario of the simulation is loaded.
    SimScenario {
        /// Its id.
        scenario: String,
        /// Its seed.
        #[serde(skip_serializing_if = "Option::is_none")]
        seed: Option<u64>,
    },
    /// Something is changed in the simulation.
    Sim {
        /// What.
        act: crate::simulation::Act,
    },
    /// The hub ends.
    End,
    /// The date has jumped.
    ClockStep {
        /// By how much, ms; negative: back.
        by_ms: i64,
    },
    /// A file of the state was lost or changed before this start.
    StateLost {
        /// Which, and how.
        #[serde(flatten)]
        loss: Loss,
    },
    /// The chain of the audit log is broken.
    ChainBroken {
        /// The first entry that is not right.
        n: u64,
    },
}

/// How a motion by hand ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "how", rename_all = "snake_case")]
pub enum JogEnding {
    /// It was stopped.
    Stopped {
        /// `released`, `lapsed`, `link_lost`, `refused`, `stop_asked`.
        reason: String,
        /// Where, arc-minutes; the nozzle mm.
        position: i16,
    },
    /// The drive stopped by itself.
    Standing {
        /// Where, arc-minutes; the nozzle mm.
        position: i16,
    },
    /// The monitor, or the line, refused it.
    Refused {
        /// In words, English.
        error: String,
    },
    /// Another motion of the same hand took its place.
    Replaced,
    /// Another client moves the drive.
    TakenOver {
        /// Who.
        by: String,
    },
    /// The drive goes on in spite of Stop.
    StillMoving {
        /// Where it was seen last, arc-minutes; the nozzle mm.
        position: i16,
    },
    /// It is not known.
    Unknown {
        /// In words, English.
        error: String,
    },
}

impl Act {
    /// As it is stored: with its version.
    pub fn to_value(&self) -> Value {
        let mut value = serde_json::to_value(self).unwrap_or_default();
        if let Value::Object(map) = &mut value {
            map.insert("v".into(), VERSION.into());
        }
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn an_act_is_stored_with_its_version_and_read_back() {
        let act = Act::Jog {
            drive: "Vertical".into(),
            toward: "max".into(),
            end: Some(JogEnding::TakenOver { by: "Buttons".into() }),
        };
        let value = act.to_value();
        let expected = json!({
            "v": 1, "type": "jog", "drive": "Vertical", "toward": "max",
            "end": { "how": "taken_over", "by": "Buttons" },
        });
        assert_eq!(value, expected);
        assert_eq!(serde_json::from_value::<Act>(value).unwrap(), act);
    }
}
