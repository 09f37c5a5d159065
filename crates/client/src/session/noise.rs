//! Bytes that are no frames: devices at another speed, or noise.

use std::time::Duration;

use super::Now;

/// Bytes that come for longer than this and are no frames were not those of a transceiver that is switched on,
/// nor the rest of a frame: the longest takes 0.6 s at 19200 baud.
const GOES_ON: Duration = Duration::from_secs(1);
/// After this time without bytes the line counts as quiet: a controller without a device to ask transmits more often.
const QUIET: Duration = Duration::from_secs(3);

/// Whether what arrives can be read at all.
#[derive(Debug, Default)]
pub struct Noise {
    /// A frame of another device was read since the start: the speed is right.
    readable: bool,
    /// Time of the first and of the last bytes without a pause of [`QUIET`].
    bytes: Option<(Now, Now)>,
}

impl Noise {
    /// Bytes have come.
    pub fn received(&mut self, now: Now) {
        let since = self.bytes.filter(|(_, last)| now < *last + QUIET).map(|(first, _)| first);
        self.bytes = Some((since.unwrap_or(now), now));
    }

    /// A frame of another device was read.
    pub const fn readable(&mut self) {
        self.readable = true;
    }

    /// From when on the line is quiet again after bytes that are no frames so far.
    pub fn quiet_from(&self) -> Option<Now> {
        self.bytes.filter(|_| !self.readable).map(|(_, last)| last + QUIET)
    }

    /// Whether bytes keep coming, and none of them has been in a frame so far.
    pub fn is_unreadable(&self, now: Now) -> bool {
        let goes_on = |(first, last): (Now, Now)| last >= first + GOES_ON && now < last + QUIET;
        !self.readable && self.bytes.is_some_and(goes_on)
    }
}
