//! Tracks what may be going on: what was requested and has neither ended nor been stopped.
//!
//! It follows the document from outside, from requests, answers and status words, independently of
//! the device's implementation.

use crate::model::view::{Reply, View};
use lafet_device::image::{AXES, Axis, VALVES, ValveNo};
use lafet_proto::flags::{Button, ControlFlags, DriveFlags, GeneralFlags, ValveFlags};
use lafet_proto::id::key;
use lafet_proto::request::Body;
use lafet_proto::{Request, SubsystemId};

/// Requests in effect.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Mandate {
    /// Whether a Move is in effect, by [`Axis`].
    moves: [bool; AXES],
    /// Whether a held button moves the drive, by [`Axis`].
    buttons: [bool; AXES],
    opens: [bool; VALVES],
    closes: [bool; VALVES],
    deploys: bool,
    wraps: bool,
    program: bool,
    search: bool,
    alignment: bool,
    /// The button last sampled by the monitor.
    seen: Option<u8>,
    /// Whether it is locked out.
    pub locked: bool,
    /// Whether the state of the lockout is stored.
    pub sure: bool,
    /// Everything was stopped, and nothing requested since.
    pub stopped: bool,
}

impl Mandate {
    /// State after power-up: the valves close, and the lockout has been read from memory.
    pub fn after_reset(locked: bool) -> Self {
        Self { closes: [true; VALVES], locked, sure: true, ..Self::default() }
    }

    /// Everything is stopped.
    fn stop(&mut self, closes: bool) {
        let Self { locked, sure, seen, .. } = *self;
        *self =
            Self { closes: [closes; VALVES], locked, sure, seen, stopped: true, ..Self::default() };
    }

    /// Records the answer to a request.
    pub fn note_answer(&mut self, request: &Request<'_>, reply: Reply, before: &View) {
        if !reply.status.is_success() {
            return;
        }
        let axis = Axis::ALL.into_iter().find(|axis| axis.id() == request.to);
        let valve = ValveNo::ALL.into_iter().find(|valve| valve.id() == request.to);
        match (request.body, axis, valve) {
            (Body::Lockout { key }, ..) => {
                let on = key == key::ENABLE;
                if on {
                    self.stop(true);
                }
                self.sure &= self.locked == on;
                self.locked = on;
                return;
            }
            (Body::Stop, ..) if request.to == SubsystemId::ALL => return self.stop(false),
            (Body::Restart | Body::CleanFlash { .. }, ..) => return self.stop(true),
            (Body::Stop, ..) => return self.note_stop(request.to, axis, valve),
            (Body::Move { .. }, Some(axis), _) => {
                self.moves[axis as usize] = true;
                if axis == Axis::Deployer {
                    (self.deploys, self.wraps) = (false, false);
                    self.end_aiming();
                }
            }
            (Body::Open { .. }, _, Some(valve)) => {
                (self.opens[valve as usize], self.closes[valve as usize]) = (true, false);
            }
            (Body::Close { .. }, _, Some(valve)) => {
                (self.opens[valve as usize], self.closes[valve as usize]) = (false, true);
            }
            (Body::Deploy, ..) => self.note_deploy(),
            (Body::Wrap, ..) => {
                // §3.11/7 Wrap ends the program and any aiming.
                let Self { opens, closes, locked, sure, seen, .. } = *self;
                *self = Self { wraps: true, opens, closes, locked, sure, seen, ..Self::default() };
            }
            (Body::StartQuench(_) | Body::StartTrajectory(_), ..) => {
                self.program = true;
                self.note_start(before);
            }
            (Body::StartSeek(_), ..) => {
                self.search = true;
                self.note_start(before);
            }
            (Body::StartJustify, ..) => self.alignment = true,
            _ => return,
        }
        self.stopped = false;
    }

    /// §3.14/5, §3.16/3 A start while stowed deploys first.
    fn note_start(&mut self, before: &View) {
        if !before.is_deployed() {
            self.note_deploy();
        }
    }

    fn note_deploy(&mut self) {
        (self.deploys, self.wraps, self.moves[Axis::Deployer as usize]) = (true, false, false);
    }

    fn note_stop(&mut self, to: SubsystemId, axis: Option<Axis>, valve: Option<ValveNo>) {
        match to {
            SubsystemId::CONTROL => self.program = false,
            SubsystemId::DETECTOR => (self.search, self.alignment) = (false, false),
            SubsystemId::DEPLOYER => {
                // §3.2/2 What waits for the deployment ends with it.
                if self.deploys {
                    (self.program, self.search) = (false, false);
                }
                (self.deploys, self.wraps) = (false, false);
            }
            _ => {}
        }
        if let Some(axis) = axis {
            (self.moves[axis as usize], self.buttons[axis as usize]) = (false, false);
        }
        if let Some(valve) = valve {
            (self.opens[valve as usize], self.closes[valve as usize]) = (false, false);
        }
    }

    /// Records the buttons as the next cycle will sample them.
    pub fn note_buttons(&mut self, held: Option<Button>, restarting: bool) {
        let held = held.map(|button| button as u8);
        if held == self.seen {
            return;
        }
        self.seen = held;
        self.buttons = [false; AXES];
        let Some(button) = held.filter(|_| !self.locked && !restarting) else { return };
        self.stopped = false;
        let all = [Axis::Horizontal, Axis::Vertical, Axis::Nozzle];
        if let Some(axis) = all.get(usize::from(button / 2)) {
            self.buttons[*axis as usize] = true;
        } else if button == Button::Open as u8 {
            (self.opens[0], self.closes[0]) = (true, self.closes[0]);
        } else {
            self.closes[0] = true;
        }
    }

    /// A cycle has passed: what has ended must be requested again.
    pub fn note_cycle(&mut self, before: &View, now: &View) {
        for axis in Axis::ALL {
            self.moves[axis as usize] &= now.drive(axis).contains(DriveFlags::MOVE);
        }
        for valve in ValveNo::ALL {
            let flags = now.valve(valve);
            self.opens[valve as usize] &= flags.contains(ValveFlags::OPENING);
            // §3.9/2 It is owed until it has closed.
            self.closes[valve as usize] &=
                flags.contains(ValveFlags::CLOSING) || !flags.contains(ValveFlags::CLOSED);
        }
        if !now.is_on_the_way() {
            (self.deploys, self.wraps) = (false, false);
        }
        self.program &= now.is_quenching();
        self.search &= now.is_searching();
        self.alignment &= now.is_justifying();
        // Leaving the working position ends all aiming.
        if before.is_deployed() && !now.is_deployed() {
            self.end_aiming();
        }
    }

    fn end_aiming(&mut self) {
        (self.program, self.search, self.alignment) = (false, false, false);
        for axis in [Axis::Vertical, Axis::Horizontal, Axis::Nozzle] {
            self.moves[axis as usize] = false;
        }
    }

    /// Whether a drive may turn up/left (1) or down/right (-1).
    pub fn allows_drive(&self, axis: Axis, way: i16) -> bool {
        let by_hand = self.moves[axis as usize] || self.buttons[axis as usize];
        way == 0
            || by_hand
            || match axis {
                Axis::Deployer => {
                    if way > 0 {
                        self.deploys
                    } else {
                        self.wraps
                    }
                }
                Axis::Nozzle => self.program,
                Axis::Vertical | Axis::Horizontal => {
                    self.program || self.search || self.alignment || self.wraps
                }
            }
    }

    /// Whether a valve may open.
    pub fn allows_opening(&self, valve: ValveNo) -> bool {
        self.opens[valve as usize]
    }

    /// Whether a valve may close; under lockout it must.
    pub fn allows_closing(&self, valve: ValveNo) -> bool {
        self.closes[valve as usize] || self.locked
    }

    /// Whether the activities in the status words were requested.
    pub fn allows_programs(&self, view: &View) -> bool {
        (self.program || !view.is_quenching())
            && (self.search || !view.is_searching())
            && (self.alignment || !view.is_justifying())
    }

    /// Whether a Move of the drive is in effect.
    pub fn moves(&self, axis: Axis) -> bool {
        self.moves[axis as usize]
    }

    /// Whether a held button moves a drive.
    pub fn is_held(&self, axis: Axis) -> bool {
        self.buttons[axis as usize]
    }

    /// Whether the program was started by this request of the model.
    pub fn has_program(&self) -> bool {
        self.program
    }
}

/// §3 The subsystems that may have to deny a request, by the scenarios of the document; empty if it
/// may be executed. Several may have reason to.
pub fn due_refusal(request: &Request<'_>, view: &View) -> Vec<SubsystemId> {
    use SubsystemId as Id;
    let to = request.to;
    if view.general().contains(GeneralFlags::LOCKED_OUT) {
        // §3.18/2, §3.18/3
        let passes = matches!(request.body, Body::SetParam { .. } | Body::Lockout { .. });
        return if passes { Vec::new() } else { vec![Id::GENERAL] };
    }
    let folded = !view.is_deployed();
    let busy = view.is_searching() || view.is_justifying();
    let reasons: &[(bool, Id)] = match request.body {
        // §3.1/1, §3.1/2
        Body::Move { .. } if to != Id::DEPLOYER => &[(folded, Id::DEPLOYER), (busy, Id::DETECTOR)],
        // §3.2/2
        Body::Stop if to != Id::ALL && view.is_on_the_way() => {
            &[(to != Id::DEPLOYER, Id::DEPLOYER)]
        }
        // §3.2/3, §3.2/4
        Body::Stop if to != Id::ALL => &[
            (busy && to != Id::DETECTOR, Id::DETECTOR),
            (view.is_quenching() && to != Id::CONTROL, Id::CONTROL),
        ],
        // §3.8/1, §3.8/2
        Body::Open { .. } => &[(folded, Id::DEPLOYER), (busy, Id::DETECTOR)],
        // §3.9/1
        Body::Close { .. } => &[(view.is_searching(), Id::DETECTOR)],
        // §3.11/6, §3.11/7
        Body::Wrap => &[
            (is_wet(view, ValveNo::Valve1), Id::VALVE1),
            (is_wet(view, ValveNo::Valve2), Id::VALVE2),
            (busy, Id::DETECTOR),
        ],
        // §3.13/2
        Body::StartJustify => &[
            (folded, Id::DEPLOYER),
            (view.is_searching(), Id::DETECTOR),
            (view.is_quenching(), Id::CONTROL),
        ],
        // §3.14/6, §3.15/4
        Body::StartQuench(_) | Body::StartTrajectory(_) => &[(busy, Id::DETECTOR)],
        // §3.16/4, §3.16/8
        Body::StartSeek(_) => &[
            (view.is_quenching() || view.is_justifying(), Id::DETECTOR),
            (is_wet(view, ValveNo::Valve1), Id::VALVE1),
            (is_wet(view, ValveNo::Valve2), Id::VALVE2),
        ],
        _ => &[],
    };
    let due = reasons.iter().filter(|(so, _)| *so).map(|(_, id)| *id);
    let mut due: Vec<Id> = due.collect();
    // §3.3.10/1 A held button also denies Move and Wrap, and comes earlier in the chain.
    if !due.is_empty() && matches!(request.body, Body::Move { .. } | Body::Wrap) {
        due.extend([Id::BUTTONS, Id::EXT_BUTTONS]);
    }
    due
}

fn is_wet(view: &View, valve: ValveNo) -> bool {
    let flags = view.valve(valve);
    view.has_valve(valve)
        && (!flags.contains(ValveFlags::CLOSED) || flags.contains(ValveFlags::OPENING))
}

/// Whether the program is paused, or waits.
pub fn is_paused(view: &View) -> bool {
    view.control().contains(ControlFlags::PAUSED)
}
