//! The person beside the installation: looks at what is there; and what others do while a question waits.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use lafet_acceptance::{Answer, Person, Question};
use lafet_proto::SubsystemId;
use lafet_proto::id::key;
use lafet_proto::request::Body;
use lafet_texts::Words;
use serde_json::{Value, json};
use tokio::time::sleep;

use crate::bench::{ABORT, FLAMES, Field, Running, World, order};

/// What happens when a question is asked, before its answer.
pub enum Deed {
    /// Another client orders this.
    Order(&'static str, Value),
    /// The same client does, as another program of its token.
    Own(&'static str, Value),
    /// A detector sees fire.
    Fire,
    /// A monitor is locked out at its own post.
    Post,
    /// The line of the monitors is dead.
    Silence,
    /// Nothing.
    Nothing,
}

pub struct Beside {
    world: Arc<World>,
    address: std::net::SocketAddr,
    tokens: [String; 2],
    pub heard: Vec<String>,
    /// Questions that were asked, in order.
    pub asked: Vec<String>,
    /// Questions that get no answer.
    pub skips: Vec<&'static str>,
    /// The question at which the person stops the run.
    pub stops: Option<&'static str>,
    /// Says yes, and has not set the mode of the test.
    pub idle: bool,
    /// What happens at a question, once; so long before its answer, ms.
    pub deed: Option<(&'static str, Deed, u64)>,
}

impl Beside {
    pub fn of(running: &Running) -> Self {
        Self {
            world: Arc::clone(&running.world),
            address: running.address,
            tokens: [running.other.clone(), running.token.clone()],
            heard: Vec::new(),
            asked: Vec::new(),
            skips: Vec::new(),
            stops: None,
            idle: false,
            deed: None,
        }
    }

    fn off(&self, monitor: usize) -> f64 {
        let off = self.world.bearing(monitor) - self.world.wanted(monitor);
        (off + 180.0).rem_euclid(360.0) - 180.0
    }

    async fn orders(&self, path: &str, body: Value) {
        let status = order(self.address, &self.tokens[0], path, &body).await;
        assert!(status < 300, "{path} {body}: {status}");
    }

    /// Holds a test source in front of a detector, or takes it away.
    fn holds(&self, detector: &str, on: bool) {
        match FLAMES.iter().position(|it| *it == detector) {
            Some(index) => self.world.sources()[index] = on,
            None => self.world.heat.store(on, Ordering::Relaxed),
        }
    }

    /// What the people do who try a test outlet: at the console, at the detectors, at the outlet.
    async fn tries(&self, zone: &str, what: &[&str], text: &Words) -> Answer {
        let of = |end: &str| format!("/api/zones/{zone}/{end}");
        let all = || FLAMES.into_iter().chain(["heat"]);
        match what {
            ["go"] if !self.idle => {
                self.orders(&of("mode"), json!({ "mode": "test_outlet" })).await;
            }
            [detector, "on"] => self.holds(detector, true),
            [detector, "off"] => self.holds(detector, false),
            ["votes"] => {
                all().filter(|it| text.en.contains(*it)).for_each(|it| self.holds(it, true))
            }
            ["water"] if !self.world.is_running() => return Answer::No,
            ["pressure"] => return Answer::Number(self.world.gauge()),
            ["abort"] => {
                all().for_each(|it| self.holds(it, false));
                // A press is held until it is read.
                let pressed = self.world.site.field != Field::AbortCut;
                self.world.panel.set(ABORT, pressed);
                sleep(Duration::from_millis(500)).await;
                self.world.panel.set(ABORT, false);
            }
            ["back"] => {
                all().for_each(|it| self.holds(it, false));
                self.orders(&of("abort"), json!({})).await;
                // A reset that comes sooner counts as simultaneous, and is refused.
                sleep(Duration::from_millis(2500)).await;
                self.orders(&of("reset"), json!({})).await;
                self.orders(&of("mode"), json!({ "mode": "automatic" })).await;
            }
            _ => {}
        }
        Answer::Yes
    }

    async fn does(&self, deed: &Deed) {
        match deed {
            Deed::Order(path, body) => _ = order(self.address, &self.tokens[0], path, body).await,
            Deed::Own(path, body) => _ = order(self.address, &self.tokens[1], path, body).await,
            Deed::Fire => self.world.sources()[0] = true,
            Deed::Post => {
                let body = Body::Lockout { key: key::ENABLE };
                self.world.sims()[0].ask(SubsystemId::ALL, body, |_| {});
            }
            Deed::Silence => self.world.silence(),
            Deed::Nothing => {}
        }
    }
}

impl Person for Beside {
    fn hear(&mut self, what: &Words) {
        self.heard.push(what.en.clone());
    }

    fn ask(&mut self, question: &Question) {
        self.asked.push(question.id.clone());
    }

    async fn answer(&mut self, question: &Question, ms: u64) -> Option<Answer> {
        let id = question.id.as_str();
        if let Some((at, deed, left_ms)) = self.deed.take() {
            if at == id {
                self.does(&deed).await;
                sleep(Duration::from_millis(ms)).await;
                if let Some(left_ms) = left_ms.checked_sub(ms) {
                    self.deed = Some((at, Deed::Nothing, left_ms));
                    return None;
                }
            } else {
                self.deed = Some((at, deed, left_ms));
            }
        }
        if self.stops == Some(id) {
            return Some(Answer::Stop);
        }
        if self.skips.contains(&id) {
            return Some(Answer::Skip);
        }
        let parts: Vec<&str> = id.split('/').collect();
        if let ["outlet", zone, what @ ..] = parts.as_slice() {
            return Some(self.tries(zone, what, &question.text).await);
        }
        Some(match parts.as_slice() {
            [_, monitor, "heading"] => {
                let index = usize::from(*monitor == "M2");
                Answer::Number((self.off(index) * 10.0).round() / 10.0)
            }
            // The one that looks at the target best, if any does by far.
            [.., "which"] => match (0..2).find(|it| self.off(*it).abs() < 5.0) {
                Some(index) => Answer::Name(["M1", "M2"][index].to_owned()),
                None => Answer::No,
            },
            _ => Answer::Yes,
        })
    }
}
