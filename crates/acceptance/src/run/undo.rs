//! The end of a run, however it comes: what was started is ended and put back, or said loudly.

use std::collections::BTreeMap;

use lafet_texts::{Text as _, Words, acceptance as text};

use super::{End, Run, Step, Under};
use crate::check;
use crate::facts::{Monitor, Zones};
use crate::judge::names;
use crate::order::{Posting, Safe};
use crate::wire::{Failed, Person, Wire};

/// Tries, and the pause between them, ms.
const TRIES: usize = 10;
const PAUSE_MS: u64 = 500;

impl<W: Wire, P: Person> Run<'_, W, P> {
    /// Ends and puts back all that was started.
    pub(super) async fn undo(&mut self) {
        self.end_releases().await;
        for monitor in std::mem::take(&mut self.begun.water) {
            self.begun.closed.insert(monitor.clone());
            self.shut(&monitor).await;
        }
        for monitor in std::mem::take(&mut self.begun.held).into_keys() {
            let stop = Safe::Stop { monitor: monitor.clone() };
            let release = Safe::Release { monitor: monitor.clone() };
            let stopped = self.insist(&stop.posting()).await;
            // A hub that is not reached gives it back by itself.
            self.insist(&release.posting()).await.ok();
            if let Err(why) = stopped {
                self.leave_word(text::LeftMonitor { monitor, why }.words());
            }
        }
        for monitor in std::mem::take(&mut self.begun.deployed) {
            self.leave_word(text::LeftDeployed { monitor }.words());
        }
        let zones: Vec<String> = self.begun.zones.keys().cloned().collect();
        for zone in zones {
            // What could not be put back is in the list.
            _ = self.leave(&zone).await;
        }
        let zones = self.zones_of_closed();
        if !zones.is_empty() {
            let list: Vec<&String> = self.begun.closed.iter().collect();
            let (monitors, zones) = (names(&list), names(&zones));
            self.leave_word(text::LeftClosed { monitors, zones }.words());
        }
    }

    /// Ends what a station was to release for its test, unless a detector has seen a fire meanwhile: the water
    /// stays then.
    async fn end_releases(&mut self) {
        let released = std::mem::take(&mut self.begun.released);
        if released.is_empty() {
            return;
        }
        let fire = self.zones_now().await.is_ok_and(|it| !it.alarms().is_empty());
        for zone in released {
            if fire {
                self.begun.water.clear();
                let why = text::ReleasedByHand.words();
                self.leave_word(text::LeftZone { zone, why }.words());
                continue;
            }
            if let Err(why) = self.insist(&Safe::Abort { zone: zone.clone() }.posting()).await {
                self.leave_word(text::LeftZone { zone, why }.words());
            }
        }
    }

    /// Closes a monitor until it is reported closed.
    pub(super) async fn shut(&mut self, monitor: &str) {
        let mut why = text::Unknown.words();
        for _ in 0..TRIES {
            let close = Safe::Close { monitor: monitor.to_owned() };
            if let Err(failed) = self.wire.post(&close.posting()).await {
                why = failed.words().clone();
            }
            self.wire.settle(PAUSE_MS).await;
            let monitors = self.wire.get("/api/monitors").await.ok();
            let monitors = monitors
                .and_then(|it| serde_json::from_value::<BTreeMap<String, Monitor>>(it).ok())
                .unwrap_or_default();
            if monitors
                .get(monitor)
                .is_some_and(|it| !it.status.stale && it.not_closed().is_empty())
            {
                return;
            }
        }
        self.leave_word(text::LeftOpen { monitor, why }.words());
    }

    fn leave_word(&mut self, words: Words) {
        self.person.hear(&words);
        self.out.left.push(words);
    }

    /// Sends until it is accepted or refused.
    async fn insist(&mut self, posting: &Posting) -> Result<(), Words> {
        let mut why = Words::default();
        for _ in 0..TRIES {
            match self.wire.post(posting).await {
                Ok(_) => return Ok(()),
                Err(Failed::Refused { text, .. }) => return Err(text),
                Err(Failed::Lost(text)) => why = text,
            }
            self.wire.settle(PAUSE_MS).await;
        }
        Err(why)
    }

    async fn zones_now(&mut self) -> Step<Zones> {
        let mut why = Words::default();
        for _ in 0..TRIES {
            match self.wire.get("/api/zones").await {
                Ok(value) => return Ok(serde_json::from_value(value).unwrap_or_default()),
                Err(failed) => why = failed.words().clone(),
            }
            self.wire.settle(PAUSE_MS).await;
        }
        Err(End::Lost(why))
    }

    /// Takes a zone out of its test: ended, quiet, reset, and back in its former mode, in this order. One whose
    /// detectors still see fire stays ended and in its test: to put it back would let the votes count.
    pub(super) async fn leave(&mut self, zone: &str) -> Step {
        let Some(under) = self.begun.zones.remove(zone) else { return Ok(()) };
        let back = self.put_back(zone, &under).await;
        let mode = text::ModeIs { mode: &under.former.mode }.words();
        match &back {
            Ok(()) => self.tried(&check::MODE_BACK, zone, true, mode.clone(), mode),
            Err(End::Lost(why) | End::Unsafe(why)) => {
                self.tried(&check::MODE_BACK, zone, false, mode, why.clone());
                self.leave_word(text::LeftZone { zone, why }.words());
            }
            Err(End::Stopped) => {}
        }
        back
    }

    /// The zones, as soon as this one sees no fire any more.
    async fn without_alarms(&mut self, zone: &str) -> Step<Zones> {
        let mut state = self.zones_now().await?;
        for _ in 0..TRIES {
            if state.zone(zone).is_some_and(|it| it.alarms.is_empty()) {
                break;
            }
            self.wire.settle(PAUSE_MS).await;
            state = self.zones_now().await?;
        }
        let alarms = state.zone(zone).map(|it| it.alarms.clone()).unwrap_or_default();
        if alarms.is_empty() {
            return Ok(state);
        }
        Err(End::Unsafe(text::ZoneSeesFire { detectors: alarms.join(", ") }.words()))
    }

    async fn put_back(&mut self, zone: &str, Under { former, sources, .. }: &Under) -> Step {
        let lost = |why: Words| End::Lost(why);
        let state = self.zones_now().await?;
        let phase = state.zone(zone).map(|it| it.phase().to_owned()).unwrap_or_default();
        // No test releases by hand: a person needs the water.
        if state.zone(zone).is_some_and(|it| it.released("automatic") == Some(false)) {
            return Err(End::Unsafe(text::ReleasedByHand.words()));
        }
        if !matches!(phase.as_str(), "quiet" | "ended") {
            self.insist(&Safe::Abort { zone: zone.to_owned() }.posting()).await.map_err(lost)?;
        }
        let state = match sources {
            // Without test sources an alarm is a fire, and the votes have to count.
            false => self.zones_now().await?,
            true => self.without_alarms(zone).await?,
        };
        // A reset would withdraw the no of a person too: the mode goes back without it.
        let refused = self.refused(&state, zone);
        if refused.is_none() && state.zone(zone).is_some_and(|it| it.ended().is_some()) {
            let mut reset = Ok(());
            for _ in 0..TRIES {
                reset = self.insist(&Safe::Reset { zone: zone.to_owned() }.posting()).await;
                if reset.is_ok() {
                    break;
                }
                self.wire.settle(PAUSE_MS).await;
            }
            reset.map_err(End::Unsafe)?;
        }
        let order = Safe::Back { zone: zone.to_owned(), former: former.clone() };
        self.insist(&order.posting()).await.map_err(lost)?;
        if let Some(monitor) = refused {
            return Err(End::Unsafe(text::MonitorRefused { monitor: &monitor }.words()));
        }
        let state = self.zones_now().await?;
        let now = state.zone(zone);
        match now.is_some_and(|it| it.mode == former.mode && it.ended().is_none()) {
            true => Ok(()),
            false => {
                let mode = now.map(|it| it.mode.clone()).unwrap_or_default();
                Err(End::Unsafe(text::ModeIs { mode }.words()))
            }
        }
    }
}
