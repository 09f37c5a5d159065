//! A simulated monitor under the hand of a validation: requests as text, waiting for conditions.

use lafet_device::Source;
use lafet_proto::record::Writer;
use lafet_proto::request::Body;
use lafet_proto::status::Hotbed;
use lafet_proto::{SubsystemId, text};
use lafet_sim::condition::Condition;
use lafet_sim::sim::{Config, Sim};

/// The monitor, deployed.
pub(super) struct Bench(pub(super) Sim);

impl Bench {
    /// Powers a monitor up; it stays wrapped.
    pub(super) fn powered_up(config: Config) -> Self {
        let mut bench = Self(Sim::new(config));
        // What its contacts say counts once it has lasted.
        bench.until("Deployer flags has AbsoluteMinLimitReached", 30_000);
        bench.until("Valve1 flags has Closed", 30_000);
        bench
    }

    /// Powers a monitor up and deploys it.
    pub(super) fn deployed(config: Config) -> Self {
        let mut bench = Self::powered_up(config);
        bench.send("Deploy Deployer");
        bench.until("Deployer flags has Deployed", 30_000);
        bench
    }

    /// Sends a request. One that cannot be written changes nothing, and what waits for it shows it.
    pub(super) fn send(&mut self, request: &str) {
        let (mut buffer, mut record) = ([0; text::BUFFER_SIZE], [0; 260]);
        let mut writer = Writer::new(&mut record);
        if text::parse(request, &mut buffer).is_ok_and(|parsed| parsed.encode(&mut writer).is_ok())
        {
            self.0.request(Source::ExternalConn, writer.written());
        }
    }

    /// Waits for a condition; the time that it took, ms, or `None` when it did not come.
    pub(super) fn until(&mut self, condition: &str, at_most_ms: u64) -> Option<u64> {
        let condition = Condition::parse(condition).ok()?;
        let start_ms = self.0.now_ms();
        while self.0.now_ms() - start_ms <= at_most_ms {
            if condition.holds(&mut self.0).ok()?.0 {
                return Some(self.0.now_ms() - start_ms);
            }
            self.0.tick();
        }
        None
    }

    /// What the last search has found.
    pub(super) fn hotbeds(&mut self) -> Vec<Hotbed> {
        let mut found = Vec::new();
        self.0.ask(SubsystemId::DETECTOR, Body::GetHotbed, |answer| {
            found = answer.hotbeds().map(Iterator::collect).unwrap_or_default();
        });
        found
    }
}
