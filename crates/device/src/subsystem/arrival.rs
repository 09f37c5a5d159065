//! §3.1, §3.3.4 How a drive comes to rest at its target — ours: the document names the target alone.
//!
//! The motor answers late (StopLag), and not at all below some speed (MinSpeed); its gear has play. So a
//! drive has arrived only when it is at rest within a tolerance:
//!
//! ```text
//!  Run ── cut off so early that it runs out to the target ──▶ Settle ── at rest, near enough ──▶ arrived
//!   ▲                                                          │  ▲
//!   └──────────────── at rest, far off ────────────────────────┤  │ the pulse is over
//!                                                at rest, near ▼  │
//!                                                             Inch
//! ```
//!
//! A pulse moves a motor by its speed times its length, however late the motor answers. A motor that is
//! fed and does not turn, or that its load holds back to less than half of a slow speed, is fed more, step by
//! step, before the watch reports it.

use crate::math::isqrt;

/// Slowest speed of an approach, 0.1 °/s or 0.1 mm/s.
pub(crate) const CREEP_TENTHS: u32 = 2;
/// From farther away than this a drive comes at its full speed, ' or mm.
const FAR_COUNTS: u32 = 2_000_000;
const FAR_SIGNED: i32 = FAR_COUNTS.cast_signed();
/// How far from its target a drive may rest, ' or mm.
const NEAR_COUNTS: u32 = 2;
const NEAR_COUNTS_NOZZLE: u32 = 1;
/// From farther away it approaches once more, from nearer one pulse is enough, ' or mm.
const INCH_COUNTS: u32 = 30;
/// A sensor that says so little may belong to a drive at rest, 0.1 °/s or 0.1 mm/s …
const REST_TENTHS: u16 = 1;
/// … when it says no more for this long; and a speed that never ends is not waited for longer.
const REST_MS: u32 = 100;
const SETTLE_MS: u32 = 2000;
/// Fed and at rest, or held back, for this long, and StopLag, it is fed a tenth more each `KICK_STEP_MS`.
const KICK_MS: u32 = 150;
/// The same of one that its load holds back and whose StopLag is not known: it may only answer late.
const HELD_MS: u32 = 210;
const KICK_STEP_MS: u32 = 10;
/// What is added to MinSpeed at most, 0.1 °/s or 0.1 mm/s.
const KICK_MAX_TENTHS: u32 = 20;
/// A pulse that has moved nothing is followed by one that is so much faster, 0.1 °/s or 0.1 mm/s.
const KICK_PULSE_TENTHS: u32 = 2;
/// After so many corrections it stays where it is. Play of 12′ takes ten.
const CORRECTIONS_MAX: u8 = 40;
/// The speed sensor is smoothed over this time, so that a short lag does not make the speed swing.
const SMOOTH_MS: u32 = 40;

/// A drive must have been so fast for its running out to say something, 0.1 °/s or 0.1 mm/s.
const SEEN_TENTHS: u16 = 20;
/// The greatest StopLag, ms.
const LAG_MAX_MS: u32 = 500;

/// What a motion knows of its drive.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Means {
    /// Greatest speed, 0.1 °/s or 0.1 mm/s.
    pub cap: u32,
    /// 0.1 °/s² or 0.1 mm/s².
    pub acceleration: u32,
    /// StopLag, ms.
    pub lag_ms: u32,
    /// MinSpeed, 0.1 °/s or 0.1 mm/s.
    pub least: u32,
    /// Positions are millimetres, not arc-minutes.
    pub nozzle: bool,
}

impl Means {
    /// Way in a millisecond at a speed of one tenth, tenths of a milli-count.
    pub const fn way_per_tenth(&self) -> u32 {
        if self.nozzle { 1 } else { 60 }
    }

    /// How far it runs out from a speed in 1/1000 of a tenth, milli-counts.
    const fn coast_milli(&self, speed_milli: i32) -> i32 {
        let way = (self.way_per_tenth() * self.lag_ms / 10).cast_signed();
        (speed_milli / 100).saturating_mul(way) / 10
    }

    const fn near(&self) -> u32 {
        if self.nozzle { NEAR_COUNTS_NOZZLE } else { NEAR_COUNTS }
    }
}

/// What the drive shall do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Order {
    /// It rests at its target, or as near as it can.
    Arrived,
    /// Speed to reach by its ramp, 1/1000 of 0.1 °/s or 0.1 mm/s.
    Ramp(i32),
    /// Speed of a pulse: at once.
    Pulse(i32),
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Phase {
    #[default]
    Run,
    Settle,
    Inch {
        up: bool,
    },
}

/// The way of a drive to its target.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Arrival {
    phase: Phase,
    /// It has turned towards its target.
    toward: bool,
    /// Speed by its sensor, smoothed, 1/1000 of 0.1 °/s or 0.1 mm/s.
    smooth_milli: i32,
    /// For how long it has been fed at rest or held back, and how long it has been at rest or waited for.
    still_ms: u32,
    held_ms: u32,
    rest_ms: u32,
    waited_ms: u32,
    /// Added to MinSpeed, 0.1 °/s or 0.1 mm/s.
    kick: u32,
    /// It is fed more than in the step before, because it does not turn.
    kicked: bool,
    corrections: u8,
    /// What is left of a pulse.
    left_ms: u32,
    /// Where it was when it was last seen to move, or when the last pulse began.
    from: i32,
    pulsed: bool,
}

impl Arrival {
    /// A new target: what the sensor says of the speed stays.
    pub fn begin(&mut self) {
        *self = Self { smooth_milli: self.smooth_milli, ..Self::default() };
    }

    /// What the speed sensor says in a step, in motion or not, 0.1 °/s or 0.1 mm/s.
    pub fn sense(&mut self, dt_ms: u32, sensed: i16) {
        let change = i32::from(sensed) * 1000 - self.smooth_milli;
        let share = change.saturating_mul(dt_ms.min(SMOOTH_MS).cast_signed());
        // What a division loses would keep it short of the sensed speed for ever.
        self.smooth_milli += match share / SMOOTH_MS.cast_signed() {
            0 if dt_ms > 0 => change.signum(),
            part => part,
        };
    }

    /// It rests farther from its target than it may.
    pub const fn has_given_up(&self) -> bool {
        self.corrections >= CORRECTIONS_MAX
    }

    /// It is fed more than before: its motion is judged again.
    pub const fn is_kicked(&self) -> bool {
        self.kicked
    }

    /// One step towards a target `way` counts above the position. `commanded_milli` is what the motor was
    /// fed in the step before, `sensed` what the speed sensor says, 0.1 °/s or 0.1 mm/s.
    pub fn step(
        &mut self,
        dt_ms: u32,
        (position, way): (i32, i32),
        (commanded_milli, sensed): (i32, i16),
        means: &Means,
    ) -> Order {
        self.kicked = false;
        if let Phase::Inch { up } = self.phase {
            if let Some(order) = self.inch(dt_ms, up, (position, way), sensed, means) {
                return order;
            }
            self.settle();
        }
        if self.phase == Phase::Run {
            if let Some(order) = self.run(dt_ms, (position, way), (commanded_milli, sensed), means)
            {
                return order;
            }
            self.settle();
        }
        self.rest(dt_ms, (position, way), sensed, means)
    }

    const fn settle(&mut self) {
        self.phase = Phase::Settle;
        (self.rest_ms, self.waited_ms) = (0, 0);
    }

    /// The speed towards the target; `None` from where it runs out to it.
    fn run(
        &mut self,
        dt_ms: u32,
        (position, way): (i32, i32),
        (commanded_milli, sensed): (i32, i16),
        means: &Means,
    ) -> Option<Order> {
        let up = way > 0;
        let turns = if up { commanded_milli > 0 } else { commanded_milli < 0 };
        let passed = self.toward && commanded_milli != 0 && !turns;
        self.toward |= turns;
        let ahead = |coast: i32| if up { coast } else { -coast }.max(0).unsigned_abs();
        let left = way.unsigned_abs().min(FAR_COUNTS) * 1000;
        if way == 0 || passed || left <= ahead(means.coast_milli(i32::from(sensed) * 1000)) {
            return None;
        }
        let left = left.saturating_sub(ahead(means.coast_milli(self.smooth_milli)));
        // Distance in units of 0.1 ° or 0.1 mm, so that v² = 2·a·s holds with the tenths of speed.
        let braking = if means.nozzle { left / 100 } else { left / 6000 };
        let brake = isqrt((means.acceleration.saturating_mul(braking) / 2).saturating_mul(3));
        // The last stretch is approached in proportion: a quarter of a second to go.
        let near = if means.nozzle { left / 25 } else { left / 1500 };
        let wanted = means.cap.min(brake).min(near);
        let still = commanded_milli != 0 && sensed.unsigned_abs() <= REST_TENTHS;
        let slow = i32::from(sensed.unsigned_abs()) * 2000 < commanded_milli.saturating_abs();
        // One that turns is never taken over its speed.
        let held = slow && wanted <= KICK_MAX_TENTHS && self.least(means) < means.cap;
        let kicked = self.kick(dt_ms, position, (still, held), means);
        let least = self.least(means);
        self.kicked = kicked && wanted < least;
        Some(Order::Ramp(signed(wanted.max(least), up)))
    }

    /// The slowest command at which it turns.
    fn least(&self, means: &Means) -> u32 {
        means.least.max(CREEP_TENTHS) + self.kick
    }

    /// Fed and not turning, or held back, it is fed more.
    fn kick(
        &mut self,
        dt_ms: u32,
        position: i32,
        (still, held): (bool, bool),
        means: &Means,
    ) -> bool {
        let before = self.kick;
        // Whose StopLag is not known may only answer late.
        let fed = still && position == self.from || held && means.lag_ms > 0;
        if fed {
            self.still_ms = self.still_ms.saturating_add(dt_ms);
        } else {
            (self.from, self.still_ms) = (position, 0);
        }
        self.held_ms = match (held, fed) {
            (false, _) => 0,
            // One that creeps rests between two counts.
            (true, true) => self.held_ms,
            (true, false) => self.held_ms.saturating_add(dt_ms),
        };
        for (ms, patience) in [(&mut self.still_ms, KICK_MS), (&mut self.held_ms, HELD_MS)] {
            while *ms >= patience + means.lag_ms + KICK_STEP_MS && self.kick < KICK_MAX_TENTHS {
                *ms -= KICK_STEP_MS;
                self.kick += 1;
            }
        }
        self.kick > before
    }

    /// Not fed: has it come to rest, and where?
    fn rest(
        &mut self,
        dt_ms: u32,
        (position, way): (i32, i32),
        sensed: i16,
        means: &Means,
    ) -> Order {
        // What has crept to it, and is not known to run out, is at rest at once.
        let crept = self.waited_ms == 0 && way == 0 && sensed.unsigned_abs() <= CREEP_TENTHS as u16;
        self.waited_ms = self.waited_ms.saturating_add(dt_ms);
        let quiet = sensed.unsigned_abs() <= REST_TENTHS;
        self.rest_ms = if quiet { self.rest_ms.saturating_add(dt_ms) } else { 0 };
        let at_once = means.lag_ms == 0 && (sensed == 0 || crept);
        let waited = self.rest_ms >= REST_MS + means.lag_ms / 2 || self.waited_ms >= SETTLE_MS;
        let far = way.clamp(-FAR_SIGNED, FAR_SIGNED) * 1000 - means.coast_milli(self.smooth_milli);
        let near = far.unsigned_abs() <= means.near() * 1000;
        if near && (at_once || waited) || self.has_given_up() {
            return Order::Arrived;
        }
        if !waited && (sensed != 0 || means.lag_ms > 0) {
            return Order::Ramp(0);
        }
        self.corrections += 1;
        if way.unsigned_abs() > INCH_COUNTS {
            (self.phase, self.toward) = (Phase::Run, false);
            return Order::Ramp(0);
        }
        // Of its way a pulse has left more than half.
        let short = position == self.from
            || way.unsigned_abs() > position.abs_diff(self.from)
                && self.least(means) + KICK_PULSE_TENTHS <= means.cap;
        if core::mem::replace(&mut self.pulsed, true) && short {
            self.kick = (self.kick + KICK_PULSE_TENTHS).min(KICK_MAX_TENTHS);
        }
        (self.from, self.still_ms) = (position, 0);
        self.pulse(dt_ms, way, means)
    }

    /// Begins a pulse that is as long as the way to the target.
    fn pulse(&mut self, dt_ms: u32, way: i32, means: &Means) -> Order {
        let (speed, up) = (self.least(means), way > 0);
        let way_per_ms = (speed * means.way_per_tenth()).max(1);
        let whole_ms = way.unsigned_abs() * 10_000 / way_per_ms;
        self.phase = Phase::Inch { up };
        self.left_ms = whole_ms.saturating_sub(dt_ms);
        Order::Pulse(signed(speed, up))
    }

    /// Goes on with a pulse; `None` when it is over.
    fn inch(
        &mut self,
        dt_ms: u32,
        up: bool,
        (position, way): (i32, i32),
        sensed: i16,
        means: &Means,
    ) -> Option<Order> {
        if self.left_ms == 0 {
            return None;
        }
        let still = sensed.unsigned_abs() <= REST_TENTHS;
        if self.kick(dt_ms, position, (still, false), means) && way.unsigned_abs() <= INCH_COUNTS {
            // Nothing has moved yet: the pulse begins again, at its new speed.
            self.kicked = true;
            return Some(self.pulse(dt_ms, way, means));
        }
        self.left_ms = self.left_ms.saturating_sub(dt_ms);
        Some(Order::Pulse(signed(self.least(means), up)))
    }
}

/// What its motions have shown of a drive: what StopLag and MinSpeed should be.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Seen {
    lag_ms: i32,
    least: i32,
    fed: bool,
    /// Where it was when it was no longer fed, and its speed then; 0 once it rests.
    cut_at: i32,
    cut_tenths: i16,
    still_ms: u32,
}

impl Seen {
    /// StopLagSeen, ms.
    pub const fn lag_ms(&self) -> i32 {
        self.lag_ms
    }

    /// MinSpeedSeen, 0.1 °/s or 0.1 mm/s.
    pub const fn least(&self) -> i32 {
        self.least
    }

    /// It has come to its target: how much it had to be fed to turn at all.
    pub fn arrived(&mut self, arrival: &Arrival, means: &Means) {
        let kicked = arrival.least(means);
        self.least =
            if arrival.kick > 0 { kicked.cast_signed() } else { means.least.cast_signed() };
    }

    /// Measures how far it runs out when it is no longer fed.
    pub fn step(&mut self, dt_ms: u32, fed: bool, position: i32, sensed: i16, way_per_tenth: u32) {
        let cut = core::mem::replace(&mut self.fed, fed) && !fed;
        if fed || cut {
            let fast = cut && sensed.unsigned_abs() >= SEEN_TENTHS;
            self.cut_tenths = if fast { sensed } else { 0 };
            (self.cut_at, self.still_ms) = (if fast { position } else { 0 }, 0);
            return;
        }
        if self.cut_tenths == 0 {
            return;
        }
        self.still_ms = if sensed == 0 { self.still_ms.saturating_add(dt_ms) } else { 0 };
        if self.still_ms >= REST_MS {
            let way = position.abs_diff(self.cut_at).min(FAR_COUNTS / 10);
            let speed = u32::from(self.cut_tenths.unsigned_abs()) * way_per_tenth;
            self.lag_ms = (way * 10_000 / speed.max(1)).min(LAG_MAX_MS).cast_signed();
            (self.cut_tenths, self.cut_at, self.still_ms) = (0, 0, 0);
        }
    }
}

/// A speed in thousandths, as far as an output can hold it.
fn signed(tenths: u32, up: bool) -> i32 {
    let speed = tenths.min(i16::MAX.unsigned_abs().into()).cast_signed() * 1000;
    if up { speed } else { -speed }
}
