//! The button posts, as the ledger follows them: what is held, and what counts.

use lafet_device::image::Axis;
use lafet_proto::SubsystemId;
pub use lafet_proto::flags::Button;
use lafet_proto::flags::ButtonState;

use super::closing::STABLE_MS;

#[derive(Clone, Copy, Debug, Default)]
struct Track {
    /// Released since power-up, lockout and the last stop of its drive; Open, since it was last pressed.
    armed: bool,
    /// For how long it has been released, ms; `None` while it is not.
    released_ms: Option<u64>,
    /// For how long it has been pressed since it was armed, ms; `None` while it is not.
    pressed_ms: Option<u64>,
    held: bool,
    held_before: bool,
}

/// Both posts.
#[derive(Clone, Debug, Default)]
pub struct Posts([[Track; 8]; 2]);

impl Posts {
    /// A step of this length. Under a lockout none counts; while the monitor waits for its reset, Close alone.
    pub(super) fn sense(
        &mut self,
        passed_ms: u64,
        posts: &[[ButtonState; 8]; 2],
        locked: bool,
        restarting: bool,
    ) {
        for (post, states) in self.0.iter_mut().zip(posts) {
            for (number, (track, state)) in post.iter_mut().zip(states).enumerate() {
                let closes = number == Button::Close as usize;
                let locked = locked || restarting && !closes;
                track.held_before = track.held;
                // From the first sample on that shows it; a long step shows it as a whole.
                let lasts = |ms: Option<u64>| {
                    let since_ms = ms.map_or(0, |ms| ms + passed_ms);
                    if closes || passed_ms > STABLE_MS { STABLE_MS.max(since_ms) } else { since_ms }
                };
                track.released_ms =
                    (*state == ButtonState::Released).then(|| lasts(track.released_ms));
                track.armed = match state {
                    ButtonState::Released => {
                        track.armed || track.released_ms.is_some_and(|ms| ms >= STABLE_MS)
                    }
                    ButtonState::Pressed => track.armed && !locked,
                    ButtonState::Short | ButtonState::Open => false,
                };
                let pressed = track.armed && *state == ButtonState::Pressed;
                track.pressed_ms = pressed.then(|| lasts(track.pressed_ms));
                track.held = track.pressed_ms.is_some_and(|ms| ms >= STABLE_MS);
                // Open acts once.
                track.armed &= !(track.held && number == Button::Open as usize);
            }
        }
    }

    /// §3.2/1 After a stop of its drive a button counts again when it has been released.
    pub(super) fn disarm(&mut self, axis: Axis) {
        let Some((up, down)) = buttons_of(axis) else { return };
        for post in &mut self.0 {
            for track in [up, down] {
                post[track] = Track { held: post[track].held, ..Track::default() };
            }
        }
    }

    /// Whether any button that aims is held.
    pub(super) fn aims(&self) -> bool {
        self.0.iter().any(|post| post.iter().take(6).any(|button| button.held))
    }

    /// Whether a button of this post asks for this direction of a drive now.
    pub fn holds(&self, post: SubsystemId, axis: Axis, up: bool) -> bool {
        let Some((more, less)) = buttons_of(axis) else { return false };
        index(post).is_some_and(|post| self.0[post][if up { more } else { less }].held)
    }

    /// Whether a button of this post that may act is pressed for this direction of a drive, for however short a
    /// time: it contradicts the other one.
    pub fn shows(&self, post: SubsystemId, axis: Axis, up: bool) -> bool {
        let Some((more, less)) = buttons_of(axis) else { return false };
        index(post)
            .is_some_and(|post| self.0[post][if up { more } else { less }].pressed_ms.is_some())
    }

    /// Whether a button of this post asked for this direction of a drive in the step before.
    pub fn held_before(&self, post: SubsystemId, axis: Axis, up: bool) -> bool {
        let Some((more, less)) = buttons_of(axis) else { return false };
        index(post).is_some_and(|post| self.0[post][if up { more } else { less }].held_before)
    }

    /// Whether a button of this drive was pressed in this step: it takes the drive over, whose output is
    /// still that of what has moved it before.
    pub fn takes_over(&self, axis: Axis) -> bool {
        let Some((more, less)) = buttons_of(axis) else { return false };
        let pressed = |track: Track| track.held && !track.held_before;
        self.0.iter().any(|post| pressed(post[more]) || pressed(post[less]))
    }

    /// Whether a button of this drive is held, or was in the step before.
    pub fn was_held(&self, axis: Axis) -> bool {
        let Some((more, less)) = buttons_of(axis) else { return false };
        let held = |track: Track| track.held || track.held_before;
        self.0.iter().any(|post| held(post[more]) || held(post[less]))
    }

    /// Whether the button Open or Close of this post was pressed in this step; beside a Close that is
    /// held, Open is none.
    pub fn pressed(&self, post: SubsystemId, button: Button) -> bool {
        index(post).is_some_and(|post| {
            let [.., opens, closes] = self.0[post];
            let (track, hindered) = match button {
                Button::Open => (opens, closes.held),
                _ => (closes, false),
            };
            track.held && !track.held_before && !hindered
        })
    }
}

/// Buttons up/left/narrower and down/right/wider of a drive, in the order of §3.3.10.
const fn buttons_of(axis: Axis) -> Option<(usize, usize)> {
    match axis {
        Axis::Horizontal => Some((0, 1)),
        Axis::Vertical => Some((2, 3)),
        Axis::Nozzle => Some((5, 4)),
        Axis::Deployer => None,
    }
}

const fn index(post: SubsystemId) -> Option<usize> {
    match post {
        SubsystemId::BUTTONS => Some(0),
        SubsystemId::EXT_BUTTONS => Some(1),
        _ => None,
    }
}
