//! The person beside the installation: looks at what is there, and does what is asked.

use std::sync::Arc;

use lafet_acceptance::{Answer, Person, Question};
use lafet_texts::Words;

use crate::bench::{HORN, World};

pub struct Beside {
    world: Arc<World>,
    pub heard: Vec<String>,
    /// Questions that get no answer begin so.
    pub skips: Vec<&'static str>,
}

impl Beside {
    pub const fn of(world: Arc<World>) -> Self {
        Self { world, heard: Vec::new(), skips: Vec::new() }
    }

    /// Bearing from the place of a monitor to the target, degrees.
    fn wanted(&self, monitor: usize) -> f64 {
        let plan = self.world.site.planned();
        let (target, at) = (plan.targets[0].at, plan.monitors[monitor].at.unwrap());
        (target[0] - at[0]).atan2(target[1] - at[1]).to_degrees()
    }

    fn off(&self, monitor: usize) -> f64 {
        let off = self.world.bearing(monitor) - self.wanted(monitor);
        (off + 180.0).rem_euclid(360.0) - 180.0
    }

    /// A detector of the plan gets its test source.
    fn source(&self, detector: &str) {
        match detector {
            "flame-west" => self.world.sources()[0] = true,
            "flame-east" => self.world.sources()[1] = true,
            _ => self.close(0, true),
        }
    }

    fn close(&self, contact: usize, on: bool) {
        if let Some(at) = self.world.site.wired[contact] {
            self.world.panel.set(at, on);
        }
    }

    /// Presses a button for a moment, after some time.
    fn press(&self, contact: usize, after_ms: u64) {
        let world = self.world.clone();
        tokio::spawn(async move {
            for (on, ms) in [(true, after_ms), (false, 1500)] {
                tokio::time::sleep(std::time::Duration::from_millis(ms)).await;
                if let Some(at) = world.site.wired[contact] {
                    world.panel.set(at, on);
                }
            }
        });
    }

    fn clear(&self) {
        *self.world.sources() = [false; 2];
        self.close(0, false);
    }
}

impl Person for Beside {
    fn hear(&mut self, what: &Words) {
        self.heard.push(what.en.clone());
    }

    async fn answer(&mut self, question: &Question) -> Answer {
        let id = question.id.as_str();
        if self.skips.iter().any(|it| id.starts_with(it)) {
            return Answer::Skip;
        }
        let parts: Vec<&str> = id.split('/').collect();
        match parts.as_slice() {
            [_, monitor, "heading"] => {
                let index = usize::from(*monitor == "M2");
                return Answer::Number((self.off(index) * 10.0).round() / 10.0);
            }
            [_, _, "which"] => {
                // The one that looks at the target best, if any does by far.
                let near = |it: &usize| self.off(*it).abs() < 5.0;
                return match (0..2).find(near) {
                    Some(index) => Answer::Name(["M1", "M2"][index].to_owned()),
                    None => Answer::No,
                };
            }
            [_, _, "detector", detector] => self.source(detector),
            [_, _, "sources"] => {
                ["flame-west", "heat", "flame-east"].iter().for_each(|it| self.source(it))
            }
            [_, "abort", "press"] | [_, _, "input", "abort"] => self.press(1, 0),
            [_, "station", "press"] | [_, _, "input", "station"] => self.press(2, 0),
            ["drill", _, "source"] => {
                self.source("heat");
                if self.world.site.answers_drill {
                    self.press(1, 1500);
                }
            }
            [_, _, "clear"] => self.clear(),
            [_, _, "sounder"] => {
                let sounds = self.world.panel.coil(HORN) && self.world.site.horn;
                return if sounds { Answer::Yes } else { Answer::No };
            }
            [_, _, "where"] => {
                return match self.world.outlet() {
                    Some(index) => Answer::Name(["hall", "store"][index].to_owned()),
                    None => Answer::No,
                };
            }
            [_, _, "right"] => {
                let flows = self.world.sims().iter().any(|it| it.world().inputs().flow_lps > 0);
                return if flows { Answer::Yes } else { Answer::No };
            }
            _ => {}
        }
        Answer::Yes
    }
}
