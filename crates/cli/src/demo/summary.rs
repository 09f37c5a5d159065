//! Results of a demonstration: how long each step took, and how much water was used.

use lafet_texts::{Text as _, cli as text};
use serde_json::{Value, json};

use crate::lang::current;
use crate::out::columns;

/// Results. Times are simulated, ms since the start unless stated otherwise.
#[derive(Clone, Debug, Default)]
pub struct Summary {
    /// Seed of the simulation.
    pub seed: u64,
    /// Number of fires lit.
    pub fires: usize,
    /// Number of fires extinguished.
    pub out: usize,
    /// When the first fire was lit, ms.
    pub lit_ms: Option<u64>,
    /// When the monitor reported it, ms.
    pub detected_ms: Option<u64>,
    /// When water reached it, ms.
    pub water_ms: Option<u64>,
    /// When the last fire was out, ms.
    pub out_ms: Option<u64>,
    /// When the monitor was stowed again, ms.
    pub end_ms: u64,
    /// Water that left the nozzle, litres.
    pub water_l: f64,
    /// Requests sent.
    pub requests: u64,
    /// Answers received.
    pub answers: u64,
}

impl Summary {
    /// Whether every fire is out.
    pub const fn is_success(&self) -> bool {
        self.fires > 0 && self.out == self.fires
    }

    fn since_lit_s(&self, at_ms: Option<u64>) -> Option<f64> {
        Some(at_ms?.saturating_sub(self.lit_ms?) as f64 / 1000.0)
    }

    /// The summary as text.
    pub fn text(&self) -> String {
        let seconds = |at_ms| match self.since_lit_s(at_ms) {
            Some(seconds) => format!("{seconds:6.1} {}", text::UnitS.str(current())),
            None => text::Never.str(current()).into(),
        };
        let rows = [
            (text::TimeToDetect.str(current()), seconds(self.detected_ms)),
            (text::TimeToWater.str(current()), seconds(self.water_ms)),
            (text::TimeToOut.str(current()), seconds(self.out_ms)),
            (text::TimeToStandby.str(current()), seconds(Some(self.end_ms))),
            (
                text::WaterUsed.str(current()),
                format!("{:6.0} {}", self.water_l, text::UnitLitre.str(current())),
            ),
            (
                text::RequestsAndAnswers.str(current()),
                format!("{:>6} / {}", self.requests, self.answers),
            ),
        ];
        let rows = rows.map(|(name, value)| vec![format!("  {name}"), value]);
        let title =
            text::DemoSummary { seed: self.seed, out: self.out, fires: self.fires }.of(current());
        format!("{title}\n{}", columns(&rows))
    }

    /// The summary as JSON.
    pub fn json(&self) -> Value {
        json!({
            "seed": self.seed,
            "fires": self.fires,
            "fires_out": self.out,
            "time_to_detect_s": self.since_lit_s(self.detected_ms),
            "time_to_water_s": self.since_lit_s(self.water_ms),
            "time_to_out_s": self.since_lit_s(self.out_ms),
            "time_to_standby_s": self.since_lit_s(Some(self.end_ms)),
            "water_l": self.water_l.round(),
            "requests": self.requests,
            "answers": self.answers,
        })
    }
}
