//! Control authority: one operator holds a monitor. No clock: times come from outside.
//!
//! ```text
//!          take                      connection lost            lost_ms, or nothing over HTTP
//!  Free ─────────▶ Held ◀──────────────────────────▶ Lost ───────────────────────────────▶ Free
//!   ▲               │ │  comes back                                           (drives stopped)
//!   └── release ────┘ └─ request: asked for 10 s ─▶ granted, denied, or no answer:
//!                        granted, unless the holder has commanded meanwhile
//! ```

use std::time::Duration;

use serde::Serialize;
use utoipa::ToSchema;

use crate::access::Role;
use crate::words::{ControlWord, LossWord};

/// A moment: time since the hub's start.
pub type Now = Duration;

/// How long a holder is asked.
pub const ASK: Duration = Duration::from_secs(10);
/// A holder over HTTP is lost this long after its last request.
pub const HTTP_LOST: Duration = Duration::from_secs(10);
/// Shortest reason of a take-over by force.
pub const REASON_MIN: usize = 5;
/// The longest reason, characters.
pub const REASON_MAX: usize = 500;

/// A client that can hold authority.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Seat {
    /// Name of the user.
    pub user: String,
    /// Role of the user.
    pub role: Role,
    /// A WebSocket connection, a session or a token.
    pub seat: String,
    /// Address of the other side.
    pub from: String,
    /// It is a WebSocket: its loss shows at once.
    #[serde(skip)]
    pub live: bool,
}

/// The authority over a monitor.
#[derive(Clone, Debug)]
pub struct Authority {
    holder: Option<Holder>,
    request: Option<(Seat, Now)>,
    lost_after: Duration,
    /// How often it was given to a client so far, and the last two clients, each with the number of its last time.
    given: u64,
    latest: [(String, u64); 2],
}

#[derive(Clone, Debug)]
struct Holder {
    seat: Seat,
    since: Now,
    commanded: Now,
    seen: Now,
    lost: Option<Now>,
}

/// Why authority was refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// Another client holds it.
    Held(Seat),
    /// Who asks does not hold it.
    NotHolder(Option<Seat>),
    /// There is nothing to grant or deny.
    NoRequest,
    /// `force` needs a reason.
    NoReason,
}

/// What a change means to others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Notice {
    /// Another client asks the holder for it.
    Asked {
        /// The client that holds it.
        holder: Seat,
        /// The client that asks for it.
        by: Seat,
    },
    /// A client has lost it; its motions by hand must be stopped.
    Lost {
        /// The former holder.
        seat: Seat,
        /// How it was lost.
        how: LossWord,
        /// The new holder.
        by: Option<Seat>,
        /// The reason of a take-over.
        reason: Option<String>,
    },
    /// Who asked has it now.
    Granted(Seat),
    /// Who asked does not get it.
    Denied(Seat),
}

impl Authority {
    /// Held by no client; a lost holder keeps it for `lost_after`.
    pub const fn new(lost_after: Duration) -> Self {
        let latest = [(String::new(), 0), (String::new(), 0)];
        Self { holder: None, request: None, lost_after, given: 0, latest }
    }

    /// How often it was given to a client so far.
    pub const fn given(&self) -> u64 {
        self.given
    }

    /// Whether another client than this seat has had it since it was given so often, for however short a time.
    pub fn had_another_since(&self, seat: &str, given: u64) -> bool {
        self.latest.iter().any(|(other, number)| *number > given && other != seat)
    }

    /// Who holds it, and since when.
    pub fn holder(&self) -> Option<(&Seat, Now)> {
        self.holder.as_ref().map(|holder| (&holder.seat, holder.since))
    }

    /// Who asks for it, and until when.
    pub fn request(&self) -> Option<(&Seat, Now)> {
        self.request.as_ref().map(|(seat, until)| (seat, *until))
    }

    /// `free`, `held` or `lost`.
    pub const fn state(&self) -> ControlWord {
        match &self.holder {
            None => ControlWord::Free,
            Some(Holder { lost: Some(_), .. }) => ControlWord::Lost,
            Some(_) => ControlWord::Held,
        }
    }

    /// Whether this seat may command; if so, it has.
    pub fn command(&mut self, now: Now, seat: &str) -> Result<(), Refusal> {
        match &mut self.holder {
            // One whose connection is lost comes back first: what it has sent before does not make it present.
            Some(holder)
                if holder.seat.seat == seat && !(holder.seat.live && holder.lost.is_some()) =>
            {
                (holder.commanded, holder.seen, holder.lost) = (now, now, None);
                Ok(())
            }
            other => Err(Refusal::NotHolder(other.as_ref().map(|holder| holder.seat.clone()))),
        }
    }

    /// Whether this seat holds it and is not lost; that is not counted as a command.
    pub fn is_present(&self, seat: &str) -> bool {
        self.holder.as_ref().is_some_and(|it| it.seat.seat == seat && it.lost.is_none())
    }

    /// Takes it when it is free; who has it renews it.
    pub fn take(&mut self, now: Now, seat: Seat) -> Result<Vec<Notice>, Refusal> {
        match &mut self.holder {
            Some(holder) if holder.seat.seat == seat.seat => {
                (holder.seen, holder.lost) = (now, None);
                Ok(Vec::new())
            }
            Some(holder) => Err(Refusal::Held(holder.seat.clone())),
            None => {
                self.give(now, seat);
                Ok(Vec::new())
            }
        }
    }

    /// The holder releases it.
    pub fn release(&mut self, now: Now, seat: &str) -> Result<Vec<Notice>, Refusal> {
        self.own(seat)?;
        Ok(self.free(now, LossWord::Released))
    }

    /// Asks the holder; what is free is taken.
    pub fn ask(&mut self, now: Now, seat: Seat) -> Result<Vec<Notice>, Refusal> {
        let Some(holder) = &self.holder else { return self.take(now, seat) };
        if holder.seat.seat == seat.seat {
            return Ok(Vec::new());
        }
        if let Some((other, _)) = &self.request
            && other.seat != seat.seat
        {
            return Err(Refusal::Held(other.clone()));
        }
        let asked = Notice::Asked { holder: holder.seat.clone(), by: seat.clone() };
        self.request = Some((seat, now + ASK));
        Ok(vec![asked])
    }

    /// Who asked does not need it any more; `true` if it had asked.
    pub fn withdraw(&mut self, seat: &str) -> bool {
        self.request.take_if(|(other, _)| other.seat == seat).is_some()
    }

    /// The holder gives it to who asks.
    pub fn grant(&mut self, now: Now, seat: &str) -> Result<Vec<Notice>, Refusal> {
        self.own(seat)?;
        self.hand_over(now).ok_or(Refusal::NoRequest)
    }

    /// The holder denies the request.
    pub fn deny(&mut self, seat: &str) -> Result<Vec<Notice>, Refusal> {
        self.own(seat)?;
        let (by, _) = self.request.take().ok_or(Refusal::NoRequest)?;
        Ok(vec![Notice::Denied(by)])
    }

    /// Takes it away, for a reason.
    pub fn force(&mut self, now: Now, seat: Seat, reason: &str) -> Result<Vec<Notice>, Refusal> {
        if reason.trim().chars().count() < REASON_MIN {
            return Err(Refusal::NoReason);
        }
        let mut notices = Vec::new();
        if let Some(holder) = self.holder.take_if(|holder| holder.seat.seat != seat.seat) {
            let (by, reason) = (Some(seat.clone()), Some(reason.trim().to_owned()));
            notices.push(Notice::Lost { seat: holder.seat, how: LossWord::Forced, by, reason });
        }
        if let Some((other, _)) = self.request.take_if(|(other, _)| other.seat != seat.seat) {
            notices.push(Notice::Denied(other));
        }
        self.request = None;
        if self.holder.is_none() {
            self.give(now, seat);
        }
        Ok(notices)
    }

    /// The connection of a seat is lost; `true` if it holds the monitor.
    pub fn lost(&mut self, now: Now, seat: &str) -> bool {
        self.request.take_if(|(other, _)| other.seat == seat);
        let holder = self.holder.as_mut().filter(|holder| holder.seat.seat == seat);
        holder.is_some_and(|holder| {
            holder.lost.get_or_insert(now);
            true
        })
    }

    /// The seat has a connection again; `false`: it holds nothing here.
    pub fn back(&mut self, now: Now, seat: &str) -> bool {
        let holder = self.holder.as_mut().filter(|holder| holder.seat.seat == seat);
        holder.is_some_and(|holder| {
            (holder.lost, holder.seen) = (None, now);
            true
        })
    }

    /// Whether the seat asks the holder for it.
    pub fn is_asked_by(&self, seat: &str) -> bool {
        self.request.as_ref().is_some_and(|(by, _)| by.seat == seat)
    }

    /// Its holder if it has been lost for too long, which [`Authority::handle_timeout`] is to say.
    pub fn expired(&self, now: Now) -> Option<&Seat> {
        self.expires().filter(|at| now >= *at)?;
        self.holder().map(|(seat, _)| seat)
    }

    /// Time has passed: see [`Authority::timeout`].
    pub fn handle_timeout(&mut self, now: Now) -> Vec<Notice> {
        let mut notices = Vec::new();
        if self.expired(now).is_some() {
            notices.extend(self.free(now, LossWord::Expired));
        }
        if let Some((_, until)) = self.request
            && now >= until
        {
            let busy = self.holder.as_ref().is_some_and(|it| it.commanded + ASK > until);
            if busy {
                notices.extend(self.request.take().map(|(by, _)| Notice::Denied(by)));
            } else {
                notices.extend(self.hand_over(now).unwrap_or_default());
            }
        }
        notices
    }

    /// When [`Authority::handle_timeout`] is to be called.
    pub fn timeout(&self) -> Option<Now> {
        self.expires().into_iter().chain(self.request.as_ref().map(|(_, until)| *until)).min()
    }

    fn expires(&self) -> Option<Now> {
        let holder = self.holder.as_ref()?;
        match holder.lost {
            Some(lost) => Some(lost + self.lost_after),
            None => (!holder.seat.live).then_some(holder.seen + HTTP_LOST),
        }
    }

    fn own(&self, seat: &str) -> Result<(), Refusal> {
        match &self.holder {
            Some(holder) if holder.seat.seat == seat => Ok(()),
            other => Err(Refusal::NotHolder(other.as_ref().map(|holder| holder.seat.clone()))),
        }
    }

    fn give(&mut self, now: Now, seat: Seat) {
        self.given += 1;
        let [latest, before] = &mut self.latest;
        if latest.0 != seat.seat {
            *before = std::mem::replace(latest, (seat.seat.clone(), 0));
        }
        latest.1 = self.given;
        // Who has just got it has not commanded yet: `commanded` lies before any request.
        self.holder =
            Some(Holder { seat, since: now, commanded: Now::ZERO, seen: now, lost: None });
    }

    fn free(&mut self, now: Now, how: LossWord) -> Vec<Notice> {
        let Some(holder) = self.holder.take() else { return Vec::new() };
        let next = self.request.take().map(|(seat, _)| seat);
        let lost = Notice::Lost { seat: holder.seat, how, by: next.clone(), reason: None };
        if let Some(seat) = next {
            self.give(now, seat.clone());
            return vec![lost, Notice::Granted(seat)];
        }
        vec![lost]
    }

    fn hand_over(&mut self, now: Now) -> Option<Vec<Notice>> {
        let (seat, _) = self.request.take()?;
        let mut notices = Vec::new();
        if let Some(holder) = self.holder.take() {
            let by = Some(seat.clone());
            notices.push(Notice::Lost {
                seat: holder.seat,
                how: LossWord::Granted,
                by,
                reason: None,
            });
        }
        self.give(now, seat.clone());
        notices.push(Notice::Granted(seat));
        Some(notices)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seat(name: &str, live: bool) -> Seat {
        Seat { user: name.into(), role: Role::Operator, seat: name.into(), from: "x".into(), live }
    }

    const fn s(seconds: u64) -> Now {
        Duration::from_secs(seconds)
    }

    fn held() -> Authority {
        let mut authority = Authority::new(s(3));
        authority.take(s(100), seat("anna", true)).unwrap();
        authority
    }

    #[test]
    fn a_lost_holder_is_not_present_and_asking_does_not_bring_it_back() {
        let mut it = held();
        assert!(it.is_present("anna") && !it.is_present("boris"));
        it.lost(s(101), "anna");
        assert!(!it.is_present("anna"));
        assert_eq!(it.timeout(), Some(s(104)), "it expires all the same");
    }

    #[test]
    fn one_holds_it() {
        let mut it = held();
        assert_eq!(it.take(s(101), seat("boris", true)), Err(Refusal::Held(seat("anna", true))));
        assert!(it.command(s(101), "boris").is_err() && it.command(s(101), "anna").is_ok());
        assert!(it.release(s(101), "boris").is_err());
        assert_eq!(it.release(s(101), "anna").unwrap().len(), 1);
        assert_eq!(it.state(), ControlWord::Free);
        assert_eq!(it.command(s(102), "anna"), Err(Refusal::NotHolder(None)));
        assert!(it.take(s(102), seat("boris", true)).is_ok());
    }

    /// Between two looks others may have taken and released it.
    #[test]
    fn who_had_it_meanwhile_is_known_afterwards() {
        let mut it = Authority::new(s(3));
        let mut hold = |names: &[&str]| {
            let given = it.given();
            for name in names {
                it.take(s(1), seat(name, true)).unwrap();
                it.release(s(1), name).unwrap();
            }
            ["anna", "boris"].map(|name| it.had_another_since(name, given))
        };
        assert_eq!(hold(&[]), [false, false]);
        assert_eq!(hold(&["anna"]), [false, true]);
        assert_eq!(hold(&["anna", "boris"]), [true, true]);
        assert_eq!(hold(&["boris", "anna", "anna"]), [true, true]);
        assert_eq!(hold(&["clara", "anna", "boris", "anna", "boris"]), [true, true]);
        assert_eq!(hold(&["boris", "boris"]), [true, false], "what was before does not count");
        assert_eq!(hold(&[]), [false, false]);
    }

    #[test]
    fn who_is_asked_may_grant_or_deny() {
        let mut it = held();
        let asked = it.ask(s(110), seat("boris", true)).unwrap();
        assert_eq!(asked, [Notice::Asked { holder: seat("anna", true), by: seat("boris", true) }]);
        assert!(it.ask(s(111), seat("clara", true)).is_err(), "one asks at a time");
        assert_eq!(it.deny("anna").unwrap(), [Notice::Denied(seat("boris", true))]);
        assert_eq!(it.grant(s(112), "anna"), Err(Refusal::NoRequest));
        it.ask(s(112), seat("boris", true)).unwrap();
        let told = it.grant(s(113), "anna").unwrap();
        assert_eq!(told[1], Notice::Granted(seat("boris", true)));
        assert!(it.command(s(113), "boris").is_ok() && it.command(s(113), "anna").is_err());
    }

    #[test]
    fn who_has_asked_may_withdraw() {
        let mut it = held();
        it.ask(s(110), seat("boris", true)).unwrap();
        assert!(!it.withdraw("clara") && it.withdraw("boris") && !it.withdraw("boris"));
        assert_eq!(it.timeout(), None);
        assert!(it.handle_timeout(s(121)).is_empty() && it.is_present("anna"));
    }

    #[test]
    fn a_holder_who_does_not_answer_loses_it_unless_at_work() {
        for (commanded, granted) in [(None, true), (Some(s(109)), true), (Some(s(111)), false)] {
            let mut it = held();
            if let Some(at) = commanded.filter(|at| *at < s(110)) {
                it.command(at, "anna").unwrap();
            }
            it.ask(s(110), seat("boris", true)).unwrap();
            if let Some(at) = commanded.filter(|at| *at > s(110)) {
                it.command(at, "anna").unwrap();
            }
            assert_eq!(it.timeout(), Some(s(120)));
            assert!(it.handle_timeout(Duration::from_millis(119_999)).is_empty());
            let told = it.handle_timeout(s(120));
            assert_eq!(told.contains(&Notice::Granted(seat("boris", true))), granted, "{told:?}");
            assert_eq!(it.command(s(120), "boris").is_ok(), granted);
        }
    }

    #[test]
    fn force_wants_a_reason_and_tells_it() {
        let mut it = held();
        let boris = seat("boris", true);
        assert_eq!(it.force(s(1), boris.clone(), "  abc "), Err(Refusal::NoReason));
        let told = it.force(s(101), boris, " anna is away").unwrap();
        let Notice::Lost { how: LossWord::Forced, reason: Some(reason), .. } = &told[0] else {
            panic!("{told:?}")
        };
        assert_eq!(reason, "anna is away");
        assert!(it.command(s(101), "boris").is_ok());
    }

    #[test]
    fn a_lost_holder_may_come_back_for_a_while() {
        let mut it = held();
        assert!(it.lost(s(110), "anna") && !it.lost(s(110), "boris"));
        assert_eq!((it.state(), it.timeout()), (ControlWord::Lost, Some(s(113))));
        it.back(s(112), "anna");
        assert_eq!((it.state(), it.timeout()), (ControlWord::Held, None));
        it.lost(s(120), "anna");
        assert!(it.handle_timeout(s(122)).is_empty());
        let told = it.handle_timeout(s(123));
        assert!(matches!(&told[..], [Notice::Lost { how: LossWord::Expired, .. }]), "{told:?}");
        assert_eq!(it.state(), ControlWord::Free);
    }

    #[test]
    fn over_http_each_command_renews_it() {
        let mut it = Authority::new(s(3));
        it.take(s(0), seat("token", false)).unwrap();
        it.command(s(9), "token").unwrap();
        assert_eq!(it.timeout(), Some(s(19)));
        assert_eq!(it.handle_timeout(s(19)).len(), 1);
    }

    #[test]
    fn when_the_holder_goes_who_asked_gets_it() {
        let mut it = held();
        it.ask(s(110), seat("boris", true)).unwrap();
        let told = it.release(s(110), "anna").unwrap();
        assert_eq!(told.last(), Some(&Notice::Granted(seat("boris", true))));
        assert!(it.command(s(111), "boris").is_ok());
    }

    /// Who asked over HTTP has its whole time, however long ago the holder was heard.
    #[test]
    fn who_gets_it_next_has_its_whole_time() {
        for live in [true, false] {
            let mut it = Authority::new(s(3));
            it.take(s(100), seat("anna", live)).unwrap();
            it.ask(s(105), seat("boris", false)).unwrap();
            if live {
                it.release(s(110), "anna").unwrap();
            } else {
                assert_eq!(it.handle_timeout(s(110)).len(), 2, "anna is gone");
            }
            assert_eq!(it.timeout(), Some(s(120)), "{live}");
            assert!(it.handle_timeout(s(111)).is_empty() && it.command(s(112), "boris").is_ok());
        }
    }

    /// A command that is judged after the connection of its sender was lost does not bring that back.
    #[test]
    fn a_command_of_a_lost_connection_does_not_renew_it() {
        let mut it = held();
        it.lost(s(110), "anna");
        assert!(it.command(s(111), "anna").is_err());
        assert_eq!(it.timeout(), Some(s(113)));
        assert!(it.back(s(112), "anna") && it.command(s(112), "anna").is_ok());
    }
}
