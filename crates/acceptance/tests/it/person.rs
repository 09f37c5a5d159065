//! The person beside the installation: looks at what is there; and what others do while a question waits.

use std::sync::Arc;
use std::time::Duration;

use lafet_acceptance::{Answer, Person, Question};
use lafet_texts::Words;
use serde_json::Value;
use tokio::time::sleep;

use crate::bench::{Running, World, order};

/// What happens when a question is asked, before its answer.
pub enum Deed {
    /// Another client orders this.
    Order(&'static str, Value),
    /// The same client does, as another program of its token.
    Own(&'static str, Value),
    /// A detector sees fire.
    Fire,
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
            deed: None,
        }
    }

    fn off(&self, monitor: usize) -> f64 {
        let off = self.world.bearing(monitor) - self.world.wanted(monitor);
        (off + 180.0).rem_euclid(360.0) - 180.0
    }

    async fn does(&self, deed: &Deed) {
        match deed {
            Deed::Order(path, body) => _ = order(self.address, &self.tokens[0], path, body).await,
            Deed::Own(path, body) => _ = order(self.address, &self.tokens[1], path, body).await,
            Deed::Fire => self.world.sources()[0] = true,
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
        if self.skips.contains(&id) {
            return Some(Answer::Skip);
        }
        let parts: Vec<&str> = id.split('/').collect();
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
