//! The rules that the machine goes by, one field each.
//!
//! A site runs by [`Rules::RIGHT`], the default. The tests of the oracle change one field at a time, which
//! makes a wrong machine that the oracle has to find; nothing else does.

/// The rules; `true` is right for each of those that are a yes or no.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rules {
    /// A release by hand is refused for so long after a no, ms.
    pub no_holds_ms: u64,
    /// A Close, or a command of a valve with feedback, is repeated at this distance, ms.
    pub repeat_ms: u64,
    /// A valve that is not reported as commanded for so long is a trouble, ms.
    pub overdue_ms: u64,
    /// An order to open or start is void if it was not delivered within this time, ms.
    pub valid_ms: u64,
    /// Votes that may be missing.
    pub missing_votes: usize,
    /// A detector in fault, or that tests itself, has no vote.
    pub fault_has_no_vote: bool,
    /// A silent detector has no vote.
    pub silent_has_no_vote: bool,
    /// A masked or disabled detector has no vote.
    pub masked_has_no_vote: bool,
    /// An alarm that was there at the start has no vote.
    pub stale_has_no_vote: bool,
    /// A failed detector changes how many votes are needed, or ends the automatic release.
    pub failure_reduces: bool,
    /// Votes have to be of different kinds.
    pub kinds_count: bool,
    /// Votes have to coincide for a time.
    pub coincidence: bool,
    /// The delay is waited for.
    pub delay: bool,
    /// A hold holds.
    pub hold: bool,
    /// A hold ends by itself.
    pub hold_ends: bool,
    /// A no lasts until it is withdrawn.
    pub no_lasts: bool,
    /// A no ends the water that is on.
    pub no_ends_water: bool,
    /// A pressed abort keeps a release by hand back.
    pub abort_before_hand: bool,
    /// Lockout keeps a release by hand back.
    pub lockout_before_hand: bool,
    /// Close is repeated until the valve is reported closed.
    pub close_repeats: bool,
    /// Automatic water ends by itself.
    pub water_ends: bool,
    /// Manual and off keep the automatic release back.
    pub mode_counts: bool,
    /// The mode returns by itself.
    pub mode_returns: bool,
    /// A test wets nothing.
    pub test_is_dry: bool,
    /// A monitor in a person's hands is left alone.
    pub person_keeps: bool,
    /// A release by hand needs no votes and no automatic mode.
    pub hand_is_free: bool,
    /// A lost monitor is replaced.
    pub lost_is_replaced: bool,
    /// A release by hand ends a test and gives water.
    pub hand_ends_test: bool,
    /// Pumps wait for each other.
    pub pumps_wait: bool,
    /// A pump that fails is replaced by the next.
    pub pump_is_replaced: bool,
    /// A start closes and opens nothing.
    pub start_is_inert: bool,
}

impl Rules {
    /// What a site runs by.
    pub const RIGHT: Self = Self {
        no_holds_ms: 2000,
        repeat_ms: 1000,
        overdue_ms: 10_000,
        valid_ms: 2000,
        missing_votes: 0,
        fault_has_no_vote: true,
        silent_has_no_vote: true,
        masked_has_no_vote: true,
        stale_has_no_vote: true,
        failure_reduces: true,
        kinds_count: true,
        coincidence: true,
        delay: true,
        hold: true,
        hold_ends: true,
        no_lasts: true,
        no_ends_water: true,
        abort_before_hand: true,
        lockout_before_hand: true,
        close_repeats: true,
        water_ends: true,
        mode_counts: true,
        mode_returns: true,
        test_is_dry: true,
        person_keeps: true,
        hand_is_free: true,
        lost_is_replaced: true,
        hand_ends_test: true,
        pumps_wait: true,
        pump_is_replaced: true,
        start_is_inert: true,
    };
}

impl Default for Rules {
    fn default() -> Self {
        Self::RIGHT
    }
}
