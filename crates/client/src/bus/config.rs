//! Configuration of a bus controller.

use std::time::Duration;

use lafet_proto::bus::{
    BAUD_DEFAULT, CONSOLES, MONITORS, PROBE_TIMEOUT_MS, REPLY_TIMEOUT_MS, TRIES,
};

use crate::session::LONGEST;

/// More transmissions of a frame count as this many: each waits twice as long as the one before.
const TRIES_MOST: u32 = 10;
/// Bits of a byte on the line: start, eight, stop (8N1, observed).
const BITS: u32 = 10;

/// Wiring of consoles and monitors (ours).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ports {
    /// One line: monitors receive the frames of consoles directly, and the controller only listens.
    #[default]
    One,
    /// Consoles on a separate line: the controller forwards their frames and the answers.
    Two,
}

/// One of the lines of [`Ports::Two`]; with [`Ports::One`] they are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Port {
    /// The line of the monitors.
    Monitors,
    /// The line of the consoles.
    Consoles,
}

/// Which requests of consoles are sent to the monitor again if no answer comes (ours).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Repeat {
    /// Those that may be executed twice: reads, Stop, Close and Lockout on.
    #[default]
    Repeatable,
    /// All (observed): if only the answer was lost, the monitor executes the request twice.
    All,
}

/// Configuration of a bus controller. A time of more than a day counts as a day.
#[derive(Clone, Debug)]
pub struct ControllerConfig {
    /// Speed of the line, baud; the duration of frames follows from it.
    pub baud: u32,
    /// Wiring of the devices.
    pub ports: Ports,
    /// Addresses in use: others are never probed.
    pub addresses: Vec<u8>,
    /// Longest time until the answer to a request starts (observed: 150 ms).
    pub reply_timeout: Duration,
    /// Longest time until the answer to a probe or grant starts (observed: 30 ms).
    pub probe_timeout: Duration,
    /// Transmissions of a frame, each with twice the timeout of the one before (observed: 3); at most 10.
    pub tries: u32,
    /// Requests that are repeated without an answer.
    pub repeat: Repeat,
    /// Time between two probes of a device that was dropped (observed: about 1 s).
    pub probe_again: Duration,
    /// Time without a frame after which a present monitor is probed (ours); `None`: its absence is
    /// noticed only when it is addressed.
    pub watch: Option<Duration>,
    /// Pause between the last received byte and the next frame.
    pub turnaround: Duration,
    /// Pause on the line before a frame to a console, so that it is not taken for a part of the
    /// previous frame (ours).
    pub frame_pause: Duration,
    /// Frames of the controller's own client between two grants, while it has some (ours).
    pub own_share: u32,
    /// Unix time at time 0 of the caller's clock, s; used in the journal.
    pub epoch_s: u32,
}

impl Default for ControllerConfig {
    fn default() -> Self {
        Self {
            baud: BAUD_DEFAULT,
            ports: Ports::One,
            addresses: MONITORS.chain(CONSOLES).collect(),
            reply_timeout: Duration::from_millis(REPLY_TIMEOUT_MS.into()),
            probe_timeout: Duration::from_millis(PROBE_TIMEOUT_MS.into()),
            tries: TRIES,
            repeat: Repeat::default(),
            probe_again: Duration::from_secs(1),
            watch: None,
            turnaround: Duration::ZERO,
            frame_pause: Duration::from_millis(3),
            own_share: 8,
            epoch_s: 0,
        }
    }
}

impl ControllerConfig {
    /// Without times that are too long to be added to others.
    pub(super) fn bounded(self) -> Self {
        let most = |time: Duration| time.min(LONGEST);
        Self {
            reply_timeout: most(self.reply_timeout),
            probe_timeout: most(self.probe_timeout),
            tries: self.tries.min(TRIES_MOST),
            probe_again: most(self.probe_again),
            watch: self.watch.map(most),
            turnaround: most(self.turnaround),
            frame_pause: most(self.frame_pause),
            ..self
        }
    }

    /// Duration of this many bytes on the line.
    pub fn sending(&self, bytes: usize) -> Duration {
        let bits = BITS * bytes as u32;
        Duration::from_secs(bits.into()) / self.baud.max(1)
    }

    /// Time that a console waits for an answer: the duration of all tries. Its request is not
    /// forwarded later.
    pub fn patience(&self) -> Duration {
        self.reply_timeout.min(LONGEST) * ((1 << self.tries.min(TRIES_MOST)) - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Controller;
    use super::*;

    /// Times and tries that no clock can add are long ones.
    #[test]
    fn the_longest_times_are_long_ones() {
        let most = Duration::MAX;
        let config = ControllerConfig {
            addresses: vec![1, 129],
            reply_timeout: most,
            probe_timeout: most,
            tries: u32::MAX,
            probe_again: most,
            watch: Some(most),
            turnaround: most,
            frame_pause: most,
            ..ControllerConfig::default()
        };
        assert!(config.patience() > LONGEST);
        let mut controller = Controller::new(config);
        let (mut now, mut sent) = (Duration::ZERO, 0);
        for _ in 0..100 {
            controller.handle_timeout(now);
            while controller.poll_transmit(now, || None).is_some() {
                sent += 1;
            }
            let Some(next) = controller.poll_timeout(now) else { break };
            now = next.max(now + Duration::from_millis(1));
        }
        assert!(sent > 1, "{sent}");
    }
}
