//! A camera as clients of the API see it: without its address and its password.

use serde::Serialize;
use utoipa::ToSchema;

use super::Mount;
use crate::text::Both;

/// How a camera is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum CameraWord {
    /// It is being connected for the first time.
    Connecting,
    /// Pictures come.
    Playing,
    /// It is connected, and no new picture has come for more than a second.
    Frozen,
    /// There is no picture: why says the reason. It is tried again and again.
    Failed,
}

/// A camera and its state; the topic `cameras/ID`.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct CameraView {
    /// Its id.
    pub id: String,
    /// Its name.
    pub name: Both,
    /// The monitors that it looks at.
    pub monitors: Vec<String>,
    /// The zones that it looks at.
    pub zones: Vec<String>,
    /// Where it is mounted.
    pub mount: Mount,
    /// How it is.
    pub state: CameraWord,
    /// Why there is no picture, and what to do; null: there is one.
    #[schema(required)]
    pub why: Option<Both>,
    /// Since when its state is this, ms since 1970.
    pub since_ms: u64,
    /// The codec, as `avc1.64001f`; null until the first picture.
    #[schema(required)]
    pub codec: Option<String>,
    /// Width and height, pixels; null until the first picture.
    #[schema(required, min_items = 2, max_items = 2)]
    pub size: Option<[u16; 2]>,
}

/// A camera now, with what it counts since the start of the hub.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct CameraNow {
    /// The camera.
    #[serde(flatten)]
    pub camera: CameraView,
    /// Viewers now.
    pub viewers: usize,
    /// Pictures that came.
    pub frames: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Packets that were lost on the way from the camera.
    pub packets_lost: u64,
    /// Times that a slow viewer was sent on to the next key frame.
    pub skipped: u64,
    /// Starts of its process.
    pub starts: u64,
}
