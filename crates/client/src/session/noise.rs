//! Bytes that are no frames: devices at another speed, or noise.

use std::time::Duration;

use super::Now;

/// Bytes that come for longer than this and are no frames were not those of a transceiver that is switched on,
/// nor the rest of a frame: the longest takes 0.6 s at 19200 baud.
const GOES_ON: Duration = Duration::from_secs(1);
/// After this time without bytes the line counts as quiet: a controller without a device to ask transmits more often.
const QUIET: Duration = Duration::from_secs(3);

/// After this time of bytes that are no frames one request is sent all the same, and one each [`TRY`]: a line that
/// floats while nothing is sent, or noise, must not keep the hub from its monitors for ever.
const PATIENCE: Duration = Duration::from_secs(30);
/// Time between two such requests: a controller at another speed repeats what one of them disturbs.
const TRY: Duration = Duration::from_secs(10);

/// Whether what arrives can be read at all.
#[derive(Debug, Default)]
pub struct Noise {
    /// A frame of another device was read since the start: the speed is right.
    readable: bool,
    /// Time of the first and of the last bytes without a pause of [`QUIET`].
    bytes: Option<(Now, Now)>,
    /// When something was sent last.
    sent: Option<Now>,
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

    /// Something was sent.
    pub const fn sent(&mut self, now: Now) {
        self.sent = Some(now);
    }

    /// Whether a request is to be tried though nothing can be read.
    fn tries(&self, now: Now) -> bool {
        let lasts = self.bytes.is_some_and(|(first, _)| now >= first + PATIENCE);
        lasts && self.sent.is_none_or(|sent| now >= sent + TRY)
    }

    /// From when on the line is quiet again after bytes that are no frames so far.
    pub fn quiet_from(&self, now: Now) -> Option<Now> {
        let bytes = self.bytes.filter(|_| !self.readable && !self.tries(now));
        bytes.map(|(_, last)| last + QUIET)
    }

    /// Whether bytes keep coming, and none of them has been in a frame so far.
    pub fn is_unreadable(&self, now: Now) -> bool {
        let goes_on = |(first, last): (Now, Now)| last >= first + GOES_ON && now < last + QUIET;
        !self.readable && self.bytes.is_some_and(goes_on) && !self.tries(now)
    }
}
