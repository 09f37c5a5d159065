//! Updates as clients see them.

use lafet_client::update::{Dotted, Stage, hex};
use lafet_proto::update::ImageHeader;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::text::Both;

/// The images that the hub stores, and the run that updates monitors.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Updates {
    /// In the order in which they came.
    pub images: Vec<StoredImage>,
    /// The one that runs, or the last one since the start of the hub.
    #[schema(required)]
    pub run: Option<UpdateRun>,
}

/// A stored image.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct StoredImage {
    /// SHA-256 of its payload, 64 hexadecimal digits: its name here.
    pub digest: String,
    /// Its version, `1.2.0.0`.
    pub version: String,
    /// The board that it is for.
    pub board: String,
    /// The slot that it is linked for; null: either.
    #[schema(required)]
    pub slot: Option<SlotWord>,
    /// Number of the key that it is signed with, 0 to 15.
    pub key: u8,
    /// Size of its payload, bytes.
    pub size: u32,
    /// User who uploaded it.
    pub by: String,
    /// When it was uploaded, ms since 1970.
    pub at_ms: u64,
}

impl StoredImage {
    /// What the header of an image says, which this user has uploaded.
    pub fn of(says: &ImageHeader, by: String, at_ms: u64) -> Self {
        let slot = match says.slot {
            1 => Some(SlotWord::A),
            2 => Some(SlotWord::B),
            _ => None,
        };
        Self {
            digest: hex(&says.digest),
            version: Dotted(says.version).to_string(),
            board: says.board_name().to_owned(),
            slot,
            key: says.key,
            size: says.size,
            by,
            at_ms,
        }
    }
}

/// A slot of a monitor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = ImageSlot)]
#[serde(rename_all = "lowercase")]
pub enum SlotWord {
    /// The first one.
    A,
    /// The second one.
    B,
}

/// What is to be updated.
#[derive(Clone, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct StartUpdate {
    /// The digest of one image, or those of two of one version and board, for slot A and slot B.
    pub images: Vec<String>,
    /// Ids of the monitors, in the order in which they are updated; left out or null: all of the configuration, in
    /// its order.
    pub monitors: Option<Vec<String>>,
    /// How much of the line's time the data may take, percent, 1 to 100; left out or null: 20 where others share the
    /// line, else 100.
    pub pace: Option<u8>,
}

/// A run: monitors that are updated one after the other.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct UpdateRun {
    /// User who started it.
    pub by: String,
    /// When it was started, ms since 1970.
    pub began_ms: u64,
    /// When it ended, ms since 1970; null: it runs.
    #[schema(required)]
    pub ended_ms: Option<u64>,
    /// Whether it runs, is done, or has ended before it was.
    pub state: RunWord,
    /// Digests of the images.
    pub images: Vec<String>,
    /// Their version.
    pub version: String,
    /// The monitors, in their order.
    pub monitors: Vec<MonitorUpdate>,
    /// Why it ended before it was done.
    #[schema(required)]
    pub text: Option<Both>,
}

/// How far a run is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[schema(as = UpdateRunState)]
#[serde(rename_all = "lowercase")]
pub enum RunWord {
    /// It runs.
    Running,
    /// Each monitor has the version.
    Done,
    /// It ended before.
    Ended,
}

/// A monitor of a run.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct MonitorUpdate {
    /// Its id.
    pub id: String,
    /// What is done with it.
    pub state: MonitorWord,
    /// How far its update is; null before it begins.
    #[schema(required)]
    pub stage: Option<StageWord>,
    /// Bytes of the payload that it has.
    #[schema(required)]
    pub done: Option<u32>,
    /// Bytes of the payload.
    #[schema(required)]
    pub size: Option<u32>,
    /// Time that sending still takes at the speed so far, s.
    #[schema(required)]
    pub left_s: Option<u64>,
    /// The version before, where it is known.
    #[schema(required)]
    pub from: Option<String>,
    /// The version that is confirmed.
    #[schema(required)]
    pub to: Option<String>,
    /// Why it failed, or what is left to be done.
    #[schema(required)]
    pub text: Option<Both>,
}

impl MonitorUpdate {
    /// Of a monitor whose turn has not come.
    pub fn new(id: &str) -> Self {
        Self {
            id: id.to_owned(),
            state: MonitorWord::Waiting,
            stage: None,
            done: None,
            size: None,
            left_s: None,
            from: None,
            to: None,
            text: None,
        }
    }

    /// Its update is at this stage.
    pub fn is_at(&mut self, stage: &Stage) {
        self.stage = Some(StageWord::from(stage));
        self.left_s = None;
        if let Stage::Sending { done, size, left } = *stage {
            (self.done, self.size) = (Some(done), Some(size));
            self.left_s = left.map(|left| left.as_secs());
        }
    }
}

/// What is done with a monitor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[schema(as = MonitorUpdateState)]
#[serde(rename_all = "lowercase")]
pub enum MonitorWord {
    /// Its turn has not come.
    Waiting,
    /// Its state is looked at.
    Checking,
    /// It is being locked out.
    Locking,
    /// Its software is being updated.
    Updating,
    /// The lockout of the update is being released.
    Unlocking,
    /// Its new software is confirmed.
    Done,
    /// It runs this version already.
    Same,
    /// It was not updated, or its lockout was not released.
    Failed,
    /// The run ended before its turn.
    Skipped,
}

/// How far the update of a monitor is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[schema(as = UpdateStage)]
#[serde(rename_all = "kebab-case")]
pub enum StageWord {
    /// Data are sent.
    Sending,
    /// The monitor hashes what it has received.
    Verifying,
    /// The next start of the monitor tries the image.
    Committed,
    /// It restarts.
    Restarting,
    /// The image runs on trial; the monitor is compared with what it was before.
    OnTrial,
    /// What confirms the image is sent.
    Confirming,
    /// The image is kept.
    Confirmed,
}

impl From<&Stage> for StageWord {
    fn from(stage: &Stage) -> Self {
        match stage {
            Stage::Sending { .. } => Self::Sending,
            Stage::Verifying => Self::Verifying,
            Stage::Committing | Stage::Committed => Self::Committed,
            Stage::Restarting => Self::Restarting,
            Stage::OnTrial => Self::OnTrial,
            Stage::Confirming => Self::Confirming,
            Stage::Confirmed => Self::Confirmed,
        }
    }
}
