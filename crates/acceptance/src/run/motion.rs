//! Dry, a monitor at a time: it turns there and back, stops, and points to its target.

use lafet_texts::{Shown, Text as _, Words, acceptance as text};

use super::look::STALE_MS;
use super::{Held, Run, Step};
use crate::check::{self, Check};
use crate::facts::{Monitor, Urgent};
use crate::judge::wrapped_deg;
use crate::order::{Drive, Order, part};
use crate::plan;
use crate::wire::{Answer, Asks, Person, Wire};

/// How far a drive turns, and how near it has to come, arc-minutes.
const TURN: f64 = 180.0;
const NEAR: f64 = 30.0;
/// A drive that goes away from its target by so much is stopped, arc-minutes.
const ASTRAY: f64 = 90.0;
/// A turn of so little takes at most, ms.
const TURN_MS: u64 = 10_000;
/// A turn to a target, and deploying, take at most, ms.
const FAR_MS: u64 = 60_000;
/// A motion that is stopped is long, arc-minutes, or less long where there is no room; it rests after, ms.
const STOPPED: [f64; 2] = [3600.0, 1200.0];
/// Tries: a motion may be over before its Stop arrives.
const STOPS: usize = 3;
const REST_MS: u64 = 1000;
/// The barrel points to a surveyed target within, degrees.
const HEADING_DEG: f64 = 1.0;

/// What is seen when a barrel points to its target.
const OF_TARGET: [&Check; 2] = [&check::WHICH, &check::HEADING];

impl<W: Wire, P: Person> Run<'_, W, P> {
    /// Each monitor, one after another.
    pub(super) async fn dry(&mut self) -> Step {
        let monitors: Vec<String> =
            self.facts.monitors.iter().flat_map(|it| it.keys().cloned()).collect();
        for id in &monitors {
            self.monitor(id).await?;
        }
        Ok(())
    }

    async fn monitor(&mut self, id: &str) -> Step {
        let monitors = self.look().await?;
        // A Stop that comes from now on, also while the question waits, is meant.
        let urgent = monitors.get(id).and_then(|it| it.urgent.clone());
        if let Some(why) = self.unready(id).await? {
            let checks = [&check::MOTION, &check::STOP, &check::WHICH, &check::HEADING];
            self.none_tried(&checks, id, &why);
            return Ok(());
        }
        match self.hold(id, urgent).await? {
            Some(why) => {
                self.tried(&check::MOTION, id, false, text::MotionLimit, why);
                let others = [&check::STOP, &check::WHICH, &check::HEADING];
                self.none_tried(&others, id, &text::NoMotion.words());
            }
            None => {
                self.turns(id).await?;
                self.stops(id).await?;
                self.points(id).await?;
            }
        }
        self.give_back(id).await
    }

    /// Why a monitor is not tried.
    async fn unready(&mut self, id: &str) -> Step<Option<Words>> {
        // A state may be stale for a moment.
        let heard = self
            .until(STALE_MS, |all| {
                all.get(id).filter(|it| it.is_heard()).map(Monitor::is_locked_out)
            })
            .await?;
        match heard {
            None => return Ok(Some(text::NoLink.words())),
            Some((true, _)) => return Ok(Some(text::LockedOut.words())),
            Some((false, _)) => {}
        }
        let go = text::AskMotion { monitor: id }.words();
        if !self.agrees(format!("dry/{}/go", part(id)), go).await? {
            return Ok(Some(text::NoGo.words()));
        }
        let monitors = self.look().await?;
        if monitors.get(id).is_some_and(Monitor::is_locked_out) {
            return Ok(Some(text::LockedOut.words()));
        }
        let free = monitors.get(id).is_some_and(|it| it.authority.state == "free");
        // Another test may have it, under the same name.
        Ok((!free).then(|| text::NotFree.words()))
    }

    /// Takes a monitor, and deploys it if it is stowed. `Some`: why that does not work.
    async fn hold(&mut self, id: &str, urgent: Option<Urgent>) -> Step<Option<Words>> {
        self.held = Some(Held {
            id: id.to_owned(),
            taken_ms: self.wire.now_ms(),
            stowed: false,
            urgent,
            stopping: 0,
            watched: true,
            locked: false,
        });
        if let Some(why) = self.send(id, &Order::Take).await? {
            self.held = None;
            return Ok(Some(why));
        }
        if let Some(why) = self.must_rest(id).await? {
            return Ok(Some(why));
        }
        let monitors = self.look().await?;
        if !monitors.get(id).is_some_and(|it| it.has("Deployer", "Wrapped")) {
            return Ok(None);
        }
        self.held.iter_mut().for_each(|it| it.stowed = true);
        if let Some(why) = self.moves(id, Order::Deploy).await? {
            return Ok(Some(why));
        }
        let deployed = self
            .until(FAR_MS, |all| all.get(id).filter(|it| it.has("Deployer", "Deployed")).map(drop))
            .await?;
        Ok(deployed.is_none().then(|| text::NotDeployed.words()))
    }

    /// Stows it if it was, and gives it back.
    async fn give_back(&mut self, id: &str) -> Step {
        let Some(stowed) = self.held.as_ref().map(|it| it.stowed) else { return Ok(()) };
        if stowed {
            let again = match self.moves(id, Order::Wrap).await? {
                Some(_) => None,
                None => {
                    let wrapped = |it: &&Monitor| it.has("Deployer", "Wrapped");
                    self.until(FAR_MS, |all| all.get(id).filter(wrapped).map(drop)).await?
                }
            };
            if again.is_none() {
                self.leave_word(text::LeftDeployed { monitor: id }.words());
            }
        }
        self.send(id, &Order::Release).await?;
        if self.held.take().is_some_and(|it| it.watched) {
            let closed = text::Seen.words();
            self.tried(&check::CLOSED, id, true, text::RestLimit, closed);
        } else {
            self.not_tried(&check::CLOSED, id, text::NoLink);
        }
        Ok(())
    }

    /// Orders a motion, right after a look that shows that it may be. `Some`: why it is not.
    async fn moves(&mut self, id: &str, order: Order) -> Step<Option<Words>> {
        if let Some(why) = self.must_rest(id).await? {
            return Ok(Some(why));
        }
        if let Some(words) = order.words(id) {
            self.announce(words);
        }
        self.send(id, &order).await
    }

    /// A drive to a position; how long it took, `None`: it does not get there in time.
    async fn turn(&mut self, id: &str, drive: Drive, to: f64, ms: u64) -> Step<Result<u64, Words>> {
        let order = Order::Move { drive, to: to.round() as i16 };
        if let Some(why) = self.moves(id, order).await? {
            return Ok(Err(why));
        }
        let name = drive.name();
        let mut least = f64::MAX;
        let arrived = self
            .until(ms, |all| {
                let it = all.get(id)?;
                let left = (it.position(name)? - to).abs();
                least = least.min(left);
                let there = left <= NEAR && !it.has(name, "Move");
                (there || left > least + ASTRAY).then_some(there)
            })
            .await?;
        match arrived {
            Some((true, took)) => Ok(Ok(took)),
            _ => {
                // What goes the wrong way, or does not arrive in time, goes no further.
                self.stop_now(id).await?;
                let at = self.position(id, drive).await?;
                let at = at.map_or_else(|| text::Unknown.words(), |at| degrees(at / 60.0));
                Ok(Err(text::NotThere { drive: name, at }.words()))
            }
        }
    }

    /// Stops it. The next looks know this Stop as an own one.
    async fn stop_now(&mut self, id: &str) -> Step<Option<Words>> {
        self.held.iter_mut().for_each(|it| it.stopping += 1);
        self.send(id, &Order::Stop).await
    }

    async fn position(&mut self, id: &str, drive: Drive) -> Step<Option<f64>> {
        let monitors = self.look().await?;
        Ok(monitors.get(id).and_then(|it| it.position(drive.name())))
    }

    /// A position so far away that is within the limits.
    async fn away(&mut self, id: &str, drive: Drive, far: f64) -> Step<Option<(f64, f64)>> {
        // A state may be stale for a moment.
        let known = self
            .until(STALE_MS, |all| {
                let it = all.get(id)?;
                let limits = it.limits.as_ref().and_then(|it| it.get(drive.name()));
                Some((it.position(drive.name())?, limits.cloned()))
            })
            .await?;
        let Some(((from, limits), _)) = known else { return Ok(None) };
        let fits = |to: &f64| limits.as_ref().is_none_or(|it| (it.min..=it.max).contains(to));
        Ok([from + far, from - far].into_iter().find(fits).map(|to| (from, to)))
    }

    async fn turns(&mut self, id: &str) -> Step {
        let mut wrong = Vec::new();
        let mut longest = 0;
        for drive in Drive::ALL {
            let Some((from, to)) = self.away(id, drive, TURN).await? else {
                wrong.push(text::NoPosition { drive: drive.name() }.words());
                continue;
            };
            for to in [to, from] {
                match self.turn(id, drive, to, TURN_MS).await? {
                    Ok(took) => longest = longest.max(took),
                    Err(why) => {
                        wrong.push(why);
                        break;
                    }
                }
            }
        }
        let measured = match wrong.first() {
            Some(why) => why.clone(),
            None => text::Seconds { value: tenths(longest) }.words(),
        };
        self.tried(&check::MOTION, id, wrong.is_empty(), text::MotionLimit, measured);
        Ok(())
    }

    async fn stops(&mut self, id: &str) -> Step {
        let drive = Drive::Horizontal;
        let check = &check::STOP;
        if self.has_failed(&check::MOTION, id) {
            self.not_tried(check, id, text::NoMotion);
            return Ok(());
        }
        let mut room = None;
        for far in STOPPED {
            if room.is_none() {
                room = self.away(id, drive, far).await?;
            }
        }
        let Some((from, to)) = room else {
            self.not_tried(check, id, text::NoRoom);
            return Ok(());
        };
        for number in 1..=STOPS {
            let (good, measured) = self.stop(id, from, to).await?;
            // What went there goes back.
            _ = self.turn(id, drive, from, TURN_MS * 3).await?;
            if good || number == STOPS {
                self.tried(check, id, good, text::StopLimit, measured);
                break;
            }
        }
        Ok(())
    }

    /// A motion that is stopped on its way; whether it stays there, and where.
    async fn stop(&mut self, id: &str, from: f64, to: f64) -> Step<(bool, Words)> {
        let drive = Drive::Horizontal;
        let order = Order::Move { drive, to: to.round() as i16 };
        if let Some(why) = self.moves(id, order).await? {
            return Ok((false, why));
        }
        let left = |at: f64| (at - from).abs() > 20.0;
        let moving = self
            .until(TURN_MS, |all| {
                all.get(id)?.position("Horizontal").filter(|at| left(*at)).map(drop)
            })
            .await?;
        if let Some(why) = self.stop_now(id).await? {
            return Ok((false, why));
        }
        self.pause(REST_MS).await?;
        let first = self.position(id, drive).await?;
        self.pause(300).await?;
        let second = self.position(id, drive).await?;
        Ok(match (moving, first, second) {
            (Some(_), Some(first), Some(second)) => {
                let rests = (first - second).abs() <= 6.0 && (second - to).abs() > 60.0;
                (
                    rests,
                    text::StoppedAt { at: degrees(second / 60.0), of: degrees(to / 60.0) }.words(),
                )
            }
            _ => (false, text::NoMotion.words()),
        })
    }

    /// Turns to the surveyed target, and asks where the barrel points.
    async fn points(&mut self, id: &str) -> Step {
        let planned = self.plan.monitors.iter().find(|it| it.id == id);
        let target = planned.and_then(|it| self.plan.target(it.target.as_ref()));
        let (Some(planned), Some(target)) = (planned, target) else {
            self.none_tried(&OF_TARGET, id, &text::NotPlanned.words());
            return Ok(());
        };
        if self.has_failed(&check::MOTION, id) {
            self.none_tried(&OF_TARGET, id, &text::NoMotion.words());
            return Ok(());
        }
        let monitors = self.look().await?;
        let limits = monitors.get(id).and_then(|it| it.limits.as_ref()?.get("Horizontal").cloned());
        let span = limits.map_or([-10_800.0, 10_800.0], |it| [it.min, it.max]);
        if planned.at.is_none() || planned.heading.is_none() {
            self.none_tried(&OF_TARGET, id, &text::NotPlanned.words());
            return Ok(());
        }
        let Some([horizontal, vertical]) = toward(planned, target, span) else {
            self.not_tried(&check::WHICH, id, text::TargetOutside);
            let limit = text::AtMostDegrees { value: HEADING_DEG };
            self.tried(&check::HEADING, id, false, limit, text::TargetOutside);
            return Ok(());
        };
        let words = text::AskTarget { monitor: id, target: &target.name }.words();
        if !self.agrees(format!("dry/{}/target", part(id)), words).await? {
            self.none_tried(&OF_TARGET, id, &text::NoGo.words());
            return Ok(());
        }
        let before = (
            self.position(id, Drive::Horizontal).await?,
            self.position(id, Drive::Vertical).await?,
        );
        for (drive, to) in [(Drive::Horizontal, horizontal), (Drive::Vertical, vertical)] {
            if let Err(why) = self.turn(id, drive, to, FAR_MS).await? {
                self.none_tried(&OF_TARGET, id, &why);
                return Ok(());
            }
        }
        self.ask_where(id, &target.name).await?;
        // A person who has sighted along the barrel is beside it.
        let back = text::AskBack { monitor: id }.words();
        if !self.agrees(format!("dry/{}/back", part(id)), back).await? {
            if self.held.as_mut().is_some_and(|it| std::mem::take(&mut it.stowed)) {
                self.leave_word(text::LeftDeployed { monitor: id }.words());
            }
            return Ok(());
        }
        for (drive, to) in [(Drive::Horizontal, before.0), (Drive::Vertical, before.1)] {
            if let Some(to) = to {
                _ = self.turn(id, drive, to, FAR_MS).await?;
            }
        }
        Ok(())
    }

    /// Which monitor points to the target, and how far off: by a person's eyes.
    async fn ask_where(&mut self, id: &str, target: &str) -> Step {
        let names: Vec<String> = self.plan.monitors.iter().map(|it| it.id.clone()).collect();
        let asks = text::AskWhich { target }.words();
        let which = self.ask(format!("dry/{}/which", part(id)), asks, Asks::Name(names)).await?;
        match &which {
            Answer::Name(name) => {
                self.tried(&check::WHICH, id, name == id, Shown(id), Shown(name));
            }
            Answer::No => self.tried(&check::WHICH, id, false, Shown(id), text::Nothing),
            _ => self.not_tried(&check::WHICH, id, text::NoAnswer),
        }
        if matches!(&which, Answer::Name(name) if name != id) || which == Answer::No {
            self.not_tried(&check::HEADING, id, text::OtherMonitor);
            return Ok(());
        }
        let asks = text::AskHeading { monitor: id, target }.words();
        match self.ask(format!("dry/{}/heading", part(id)), asks, Asks::Degrees).await? {
            Answer::Number(off) => {
                let limit = text::AtMostDegrees { value: HEADING_DEG };
                let good = off.abs() <= HEADING_DEG;
                self.tried(&check::HEADING, id, good, limit, degrees(off));
            }
            _ => self.not_tried(&check::HEADING, id, text::NoAnswer),
        }
        Ok(())
    }
}

/// Positions of both drives with which a monitor looks at a target, arc-minutes; `None`: it cannot, or its place
/// is not in the plan.
fn toward(monitor: &plan::Monitor, target: &plan::Target, span: [f64; 2]) -> Option<[f64; 2]> {
    let (at, heading) = (monitor.at?, monitor.heading?);
    let (east, north) = (target.at[0] - at[0], target.at[1] - at[1]);
    let bearing = east.atan2(north).to_degrees();
    let turned = wrapped_deg(heading - bearing) * 60.0;
    let all = [turned, turned - 21_600.0, turned + 21_600.0];
    let horizontal = all.into_iter().find(|it| (span[0]..=span[1]).contains(it))?;
    let rise = target.at[2] - monitor.height.unwrap_or(target.at[2]);
    let vertical = rise.atan2(east.hypot(north)).to_degrees() * 60.0;
    Some([horizontal, vertical])
}

/// Degrees with a decimal.
fn degrees(value: f64) -> Words {
    Words::same(format!("{value:.1}°"))
}

/// Milliseconds as seconds with a decimal.
pub(super) fn tenths(ms: u64) -> String {
    format!("{:.1}", ms as f64 / 1000.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_monitor_looks_at_a_target_by_its_heading() {
        let monitor = plan::Monitor {
            at: Some([0.0, 0.0]),
            heading: Some(90.0),
            height: Some(2.0),
            ..plan::Monitor::default()
        };
        let target = plan::Target { name: "T".into(), at: [0.0, 20.0, 2.0] };
        let [horizontal, vertical] = toward(&monitor, &target, [-10_800.0, 10_800.0]).unwrap();
        assert!(
            (horizontal - 5400.0).abs() < 1e-6 && vertical.abs() < 1e-6,
            "a quarter to the left"
        );
        assert!(toward(&monitor, &target, [-5000.0, 5000.0]).is_none(), "outside of its limits");
        let none = plan::Monitor::default();
        assert!(toward(&none, &target, [-5000.0, 5000.0]).is_none());
    }
}
