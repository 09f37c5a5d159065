//! What an entry of the audit log is about, typed: words are made where it is shown.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::mark::Loss;
use crate::access::Role;
use crate::text::Both;

/// Version of [`Act`] in the log: an entry of a later one is shown by its `what`.
const VERSION: u32 = 1;

/// An action in the audit log. Its JSON is part of the log's format.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Act {
    /// A request to a monitor; `what` of the entry is its whole text.
    Request {
        /// Name of the request, `Move`.
        request: String,
        /// Name of the addressee, `Vertical`.
        to: String,
    },
    /// A motion by hand; the outcome of the entry is how it ended.
    Jog {
        /// Name of the drive.
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
        /// Reason given with `force`.
        #[serde(skip_serializing_if = "Option::is_none")]
        reason: Option<String>,
    },
    /// A login.
    Login,
    /// A user has logged out.
    Logout,
    /// The first administrator is made with the link of the first start.
    SetUp {
        /// Name of the administrator.
        user: String,
    },
    /// A user has changed the own password.
    ChangeOwnPassword,
    /// A user was added.
    AddUser {
        /// Name of the user.
        user: String,
        /// Role of the user.
        role: Role,
    },
    /// A change of a user.
    ChangeUser {
        /// Name of the user.
        user: String,
        /// New role; none if only the password has changed.
        #[serde(skip_serializing_if = "Option::is_none")]
        role: Option<Role>,
        /// There is a new password.
        password: bool,
    },
    /// A user was removed.
    RemoveUser {
        /// Name of the user.
        user: String,
    },
    /// A token was made.
    AddToken {
        /// Name of the token.
        name: String,
        /// Role of the token.
        role: Role,
    },
    /// A token is taken back.
    RemoveToken {
        /// Number of the token.
        id: u64,
    },
    /// A session is ended by an administrator.
    EndSession {
        /// Id of the session.
        session: String,
    },
    /// An alarm was acknowledged.
    Acknowledge {
        /// Id of the alarm.
        alarm: String,
    },
    /// An alarm was shelved.
    Shelve {
        /// Id of the alarm.
        alarm: String,
        /// Duration, minutes.
        minutes: u64,
        /// Reason given.
        reason: String,
    },
    /// An alarm is taken off the shelf.
    Unshelve {
        /// Id of the alarm.
        alarm: String,
    },
    /// The audit log is exported.
    ExportAudit,
    /// A recording was started.
    StartRecording {
        /// Name of the recording.
        recording: String,
    },
    /// A recording was removed.
    RemoveRecording {
        /// Name of the recording.
        recording: String,
    },
    /// A recording was uploaded.
    UploadRecording {
        /// Name of the recording.
        recording: String,
    },
    /// An image of a monitor's software was uploaded.
    StoreImage {
        /// SHA-256 of its payload, hexadecimal.
        digest: String,
        /// Its version.
        version: String,
        /// The board that it is for.
        board: String,
    },
    /// An image was removed.
    RemoveImage {
        /// SHA-256 of its payload, hexadecimal.
        digest: String,
        /// Its version.
        version: String,
        /// The board that it is for.
        board: String,
    },
    /// An update of monitors was started.
    StartUpdate {
        /// The version of the images.
        version: String,
        /// SHA-256 of the payload of each image, hexadecimal.
        images: Vec<String>,
        /// Ids of the monitors, in their order.
        monitors: Vec<String>,
    },
    /// An update of monitors was stopped.
    StopUpdate,
    /// The update of a monitor has ended, as the outcome of the entry says.
    UpdateMonitor {
        /// The version of the images.
        version: String,
        /// The version before, where it is known.
        #[serde(skip_serializing_if = "Option::is_none")]
        from: Option<String>,
        /// The version that is confirmed.
        #[serde(skip_serializing_if = "Option::is_none")]
        to: Option<String>,
        /// Why it failed, or what was left to be done.
        #[serde(skip_serializing_if = "Option::is_none")]
        text: Option<Both>,
    },
    /// An update of monitors has ended.
    EndUpdate {
        /// Monitors that have the version.
        done: usize,
        /// Monitors that were to have it.
        monitors: usize,
        /// Why it ended before it was done.
        #[serde(skip_serializing_if = "Option::is_none")]
        text: Option<Both>,
    },
    /// A scenario of the simulation is loaded.
    SimScenario {
        /// Id of the scenario.
        scenario: String,
        /// Seed of the random numbers.
        #[serde(skip_serializing_if = "Option::is_none")]
        seed: Option<u64>,
    },
    /// Something is changed in the simulation.
    Sim {
        /// The action.
        act: crate::simulation::Act,
    },
    /// Something that the zone controller has decided.
    Zone {
        /// What has happened.
        entry: lafet_site::Entry,
        /// Why; empty where the entry says it.
        cause: Vec<lafet_site::Cause>,
    },
    /// An order of the zone controller to a monitor; the requests to the monitor follow it.
    ZoneOrder {
        /// The order.
        order: lafet_site::Order,
        /// Why, from the first cause to the last.
        cause: Vec<lafet_site::Cause>,
    },
    /// The hub has ended.
    End,
    /// The date has stepped.
    ClockStep {
        /// By how much, ms; negative: back.
        by_ms: i64,
    },
    /// A file of the state was lost or changed before this start.
    StateLost {
        /// The file, and what is wrong with it.
        #[serde(flatten)]
        loss: Loss,
    },
    /// The chain of the audit log is broken.
    ChainBroken {
        /// The first entry that is not right.
        n: u64,
    },
    /// Entries of the audit log were given up, as the disk took none for too long.
    EntriesLost {
        /// How many.
        entries: u64,
        /// Time of the first of them, ms since 1970.
        from_ms: u64,
        /// Time of the last of them, ms since 1970.
        to_ms: u64,
    },
}

/// How a motion by hand ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "how", rename_all = "snake_case")]
pub enum JogEnding {
    /// The motion was stopped.
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
        /// The error, in English.
        error: String,
        /// The same for people; entries of earlier versions have none.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        text: Option<Both>,
    },
    /// Another motion of the same hand took its place.
    Replaced,
    /// Another client moves the drive.
    TakenOver {
        /// The client that took over.
        by: String,
    },
    /// The drive goes on in spite of Stop.
    StillMoving {
        /// Where it was seen last, arc-minutes; the nozzle mm.
        position: i16,
    },
    /// The end is unknown.
    Unknown {
        /// The error, in English.
        error: String,
        /// The same for people; entries of earlier versions have none.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        text: Option<Both>,
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

    /// What is stored; `None`: it is of a later version, or none that this one knows.
    pub fn from_value(value: &Value) -> Option<Self> {
        let version = value.get("v").and_then(Value::as_u64)?;
        if version > u64::from(VERSION) {
            return None;
        }
        serde_json::from_value(value.clone()).ok()
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
        assert_eq!(Act::from_value(&value), Some(act));
    }

    /// The chain of a log has entries as they were written.
    #[test]
    fn an_end_is_said_in_every_language_and_one_of_an_earlier_version_in_one() {
        let text = Some(Both { en: "no answer".into(), ru: "нет ответа".into() });
        let end = JogEnding::Unknown { error: "no answer".into(), text };
        let stored = serde_json::to_value(&end).unwrap();
        let words = json!({ "en": "no answer", "ru": "нет ответа" });
        let expected = json!({ "how": "unknown", "error": "no answer", "text": words });
        assert_eq!(stored, expected);
        assert_eq!(serde_json::from_value::<JogEnding>(stored).unwrap(), end);
        let earlier = json!({ "how": "refused", "error": "no answer" });
        let read: JogEnding = serde_json::from_value(earlier.clone()).unwrap();
        assert_eq!(read, JogEnding::Refused { error: "no answer".into(), text: None });
        assert_eq!(serde_json::to_value(&read).unwrap(), earlier);
    }

    #[test]
    fn an_act_of_a_later_version_is_not_taken_for_one_of_this() {
        let login = json!({ "v": VERSION, "type": "login" });
        assert_eq!(Act::from_value(&login), Some(Act::Login));
        for odd in [
            json!({ "v": VERSION + 1, "type": "login" }),
            json!({ "v": VERSION, "type": "teleport" }),
            json!({ "type": "login" }),
            json!("login"),
        ] {
            assert_eq!(Act::from_value(&odd), None, "{odd}");
        }
    }
}
