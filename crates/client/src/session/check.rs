//! §L/7 The checksum of frames to a monitor: found by presence probes, and checked again later
//! (ours).
//!
//! A monitor answers each frame in the form of the request, and does not answer a form that it does
//! not support. So a probe shows it, at the cost of a short wait when it is not answered:
//!
//! - before the first frame of a connection, and later from time to time, one with a CRC-32C;
//! - after requests without answer, one in the present form and one in the other: the monitor may
//!   have been replaced.
//!
//! Probes are sent only while requests wait to be sent, and Stop, Close and Lockout on never wait
//! for them: their tries alternate between the forms. An answer is accepted only in a form in which
//! its request was sent.

use std::collections::VecDeque;
use std::time::Duration;

use lafet_proto::link::{self, Check, Frame};

use super::input::Incoming;
use super::medium::{Addresses, Framing};
use super::operation::Outstanding;
use super::{Now, Outcome, Session, Verdict};

/// Checksum of frames, `check=`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CheckMode {
    /// CRC-16/MODBUS (observed).
    #[default]
    Crc16,
    /// CRC-32C (ours) with every monitor that supports it, CRC-16 with the others.
    Auto,
    /// CRC-32C; a monitor that does not support it is an error.
    Crc32c,
}

/// The shortest wait for the answer to a probe, when the usual round trip is known.
const PROBE_LEAST: Duration = Duration::from_millis(30);
/// Shortest time between two checks of both forms after requests without answer.
const SILENCE_PAUSE: Duration = Duration::from_secs(5);
/// Seconds between the probes of a monitor without CRC-32C: earlier ones may have been lost.
const LOOKS_S: [u64; 6] = [1, 3, 10, 30, 100, 300];

/// A probe that was sent.
#[derive(Clone, Copy, Debug)]
struct Probe {
    check: Check,
    sent: Now,
    deadline: Now,
}

/// What is known of a monitor's checksums.
#[derive(Debug)]
pub struct Negotiation {
    mode: CheckMode,
    form: Check,
    /// It answers, but not with the CRC-32C that is required.
    missing: bool,
    probe: Option<Probe>,
    /// Probes to be sent before anything else.
    plan: VecDeque<Check>,
    looks: usize,
    next_look: Now,
    next_after_silence: Now,
    /// Time of the last probe with a CRC-32C.
    last_long: Option<Now>,
}

impl Negotiation {
    pub fn new(mode: CheckMode, framing: Framing) -> Self {
        let mode = if framing == Framing::Records { CheckMode::Crc16 } else { mode };
        let form = if mode == CheckMode::Crc32c { Check::Crc32c } else { Check::Crc16 };
        Self {
            mode,
            form,
            missing: false,
            probe: None,
            plan: VecDeque::new(),
            looks: 0,
            next_look: Now::ZERO,
            next_after_silence: Now::ZERO,
            last_long: None,
        }
    }

    /// Whether the checksum depends on the monitor.
    pub const fn negotiates(&self) -> bool {
        !matches!(self.mode, CheckMode::Crc16)
    }

    /// The checksum in use.
    pub const fn form(&self) -> Check {
        self.form
    }

    /// Whether a probe is awaiting its answer.
    pub const fn is_probing(&self) -> bool {
        self.probe.is_some()
    }

    /// Start and end of the time in which a probe takes the line.
    pub fn occupies(&self) -> Option<(Now, Now)> {
        self.probe.map(|probe| (probe.sent, probe.deadline))
    }

    /// Starts again for a new connection.
    pub fn connected(&mut self) {
        *self = Self::new(self.mode, Framing::Link);
        match self.mode {
            CheckMode::Crc16 => {}
            CheckMode::Auto => self.plan.push_back(Check::Crc32c),
            CheckMode::Crc32c => self.plan.extend([Check::Crc32c, Check::Crc32c, Check::Crc16]),
        }
    }

    pub fn disconnected(&mut self) {
        self.probe = None;
        self.plan.clear();
    }

    /// Records that a frame was not answered.
    pub fn silence(&mut self, now: Now) {
        if self.negotiates() && now >= self.next_after_silence && self.plan.is_empty() {
            self.next_after_silence = now + SILENCE_PAUSE;
            self.plan.extend([self.form, other(self.form)]);
        }
    }

    /// The probe to be sent now.
    fn due(&mut self, now: Now) -> Option<Check> {
        let plain = self.mode == CheckMode::Auto && self.form == Check::Crc16;
        if self.plan.is_empty() && (plain || self.missing) && now >= self.next_look {
            self.plan.push_back(Check::Crc32c);
        }
        self.plan.pop_front()
    }

    fn sent(&mut self, check: Check, now: Now, wait: Duration) {
        self.probe = Some(Probe { check, sent: now, deadline: now + wait });
        if check == Check::Crc32c {
            self.last_long = Some(now);
            let pause = LOOKS_S[self.looks.min(LOOKS_S.len() - 1)];
            self.looks += 1;
            self.next_look = now + Duration::from_secs(pause);
        }
    }

    /// The form of the next try of an operation.
    fn form_of(&self, urgent: bool, tries: u32) -> Check {
        let turned = self.negotiates() && urgent && !tries.is_multiple_of(2);
        if turned { other(self.form) } else { self.form }
    }
}

const fn other(check: Check) -> Check {
    match check {
        Check::Crc16 => Check::Crc32c,
        Check::Crc32c => Check::Crc16,
    }
}

/// The forms in which an operation has been sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Forms {
    crc16: bool,
    crc32c: bool,
}

impl Forms {
    pub const fn add(&mut self, check: Check) {
        match check {
            Check::Crc16 => self.crc16 = true,
            Check::Crc32c => self.crc32c = true,
        }
    }

    pub const fn has(self, check: Check) -> bool {
        match check {
            Check::Crc16 => self.crc16,
            Check::Crc32c => self.crc32c,
        }
    }
}

impl Session {
    /// The checksum of frames to this monitor at present.
    pub const fn check(&self) -> Check {
        self.check.form()
    }

    /// The form of the next try of the outstanding operation.
    pub(super) fn next_form(&self, outstanding: &Outstanding) -> Check {
        self.check.form_of(outstanding.operation.is_urgent(), outstanding.tries)
    }

    /// Replaces the contents of `wire` by a probe, if one is to be sent before waiting operations.
    pub(super) fn poll_check(&mut self, now: Now, wire: &mut Vec<u8>) -> bool {
        let waits = self.outstanding.is_some() || !self.queue.is_empty();
        if !waits || self.check.is_probing() {
            return false;
        }
        let Some(check) = self.check.due(now) else { return false };
        let usual = self.stats.rtt_average.map(|rtt| PROBE_LEAST.max(rtt * 3));
        let wait = usual.unwrap_or(self.config.patience).min(self.config.timeout);
        self.check.sent(check, now, wait);
        self.stats.frames_sent += 1;
        let Addresses { monitor: dst, source: src } = self.config.addresses;
        self.trace(Verdict::Sent, dst, src, false, &[]);
        encode(check, &Frame { dst, src, payload: &[] }, wire);
        true
    }

    /// Time until which a probe delays waiting operations.
    pub(super) fn probed_until(&self, urgent: bool) -> Option<Now> {
        let (sent, until) = self.check.occupies()?;
        Some(if urgent { until.min(sent + self.config.patience) } else { until })
    }

    /// Handles a probe without answer.
    pub(super) fn probe_failed(&mut self) {
        let Some(probe) = self.check.probe.take() else { return };
        if probe.check == Check::Crc16 {
            self.suspicion.raise(None, probe.sent);
        }
    }

    pub(super) fn check_timed_out(&mut self, now: Now) {
        if !self.check.negotiates() {
            return;
        }
        if self.check.probe.is_some_and(|probe| now >= probe.deadline) {
            self.probe_failed();
        }
        self.refuse_missing(now);
    }

    /// Evaluates the checksum of a frame from the monitor; returns whether it answers a probe.
    pub(super) fn check_heard(&mut self, now: Now, frame: &Incoming) -> bool {
        if !self.check.negotiates() {
            return false;
        }
        let answers = |probe: &Probe| probe.check == frame.check && frame.payload.is_empty();
        let probe = self.check.probe.filter(answers);
        if let Some(probe) = probe {
            self.check.probe = None;
            self.check.plan.clear();
            self.stats.note_rtt(now.saturating_sub(probe.sent));
            if self.config.duplicates {
                self.suspicion.raise(None, probe.sent);
            }
        }
        // Only a monitor that supports CRC-32C sends one, however late.
        if frame.check == Check::Crc32c {
            self.use_crc32c();
        } else if probe.is_some() {
            self.use_crc16(now);
        }
        probe.is_some()
    }

    fn use_crc32c(&mut self) {
        if self.check.form == Check::Crc16
            && let Some(sent) = self.check.last_long
        {
            self.suspicion.raise(None, sent);
        }
        self.check.form = Check::Crc32c;
        self.check.missing = false;
        self.check.plan.clear();
    }

    fn use_crc16(&mut self, now: Now) {
        match self.check.mode {
            CheckMode::Crc32c => self.check.missing = true,
            _ if self.check.form == Check::Crc32c => {
                self.check.form = Check::Crc16;
                // The probe with a CRC-32C may have been lost.
                self.check.looks = 0;
                self.check.next_look = now + Duration::from_secs(LOOKS_S[0]);
            }
            _ => {}
        }
    }

    /// Ends operations for a monitor without the required checksum, except those that stop it.
    pub(super) fn refuse_missing(&mut self, now: Now) {
        let settled = !self.check.is_probing() && self.check.plan.is_empty();
        if !self.check.missing || !settled || now >= self.check.next_look {
            return;
        }
        // A frame in a form that the monitor does not read was not executed either.
        let due = |o: &mut Outstanding| o.due && !o.operation.is_urgent();
        if let Some(outstanding) = self.outstanding.take_if(due) {
            let ticket = self.give_up(outstanding).operation.ticket;
            self.outcomes.push_back((ticket, Outcome::CheckMissing));
        }
        self.refuse_waiting(&Outcome::CheckMissing, false);
    }
}

/// Replaces the contents of `wire` by a frame.
pub(super) fn encode(check: Check, frame: &Frame<'_>, wire: &mut Vec<u8>) {
    wire.clear();
    wire.resize(link::wire_max(frame.payload.len()), 0);
    let len = link::encode_with(check, frame, wire).unwrap_or(0);
    wire.truncate(len);
}
