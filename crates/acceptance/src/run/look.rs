//! A look at the site: what must not be during a test ends it, before anything more is ordered.

use lafet_texts::{Text as _, Words, acceptance as text};

use super::{End, Monitors, POLL_MS, Run, Step};
use crate::check;
use crate::facts::{About, Monitor, Zones};
use crate::order::Order;
use crate::wire::{Person, Wire};

/// A monitor that is held is taken again so often, ms: it is lost 10 s after the last request.
const RENEW_MS: u64 = 3000;
/// A state that is stale for so long is so, ms.
pub(super) const STALE_MS: u64 = 5000;
/// After so long another client may have had it, ms.
const LAPSED_MS: u64 = 9000;

impl<W: Wire, P: Person> Run<'_, W, P> {
    /// Looks at the site: zones and monitors. What must not be during a test ends it.
    pub(super) async fn look(&mut self) -> Step<Monitors> {
        self.renew().await?;
        let (zones, monitors) = self.seen().await?;
        let heeded = self.is_heeded(&monitors);
        self.is_safe(&zones)?;
        if let Some(id) = wet(&monitors) {
            let words = text::ValveNotClosed { monitor: id }.words();
            self.tried(&check::CLOSED, id, false, text::RestLimit, words.clone());
            return Err(End::Unsafe(words));
        }
        heeded?;
        Ok(monitors)
    }

    /// Zones and monitors as they are now, of a hub that is the same as in the last look.
    pub(super) async fn seen(&mut self) -> Step<(Zones, Monitors)> {
        // The time first: what is seen after it is not older.
        let hub: About = self.known("/api/hub").await?;
        let zones: Zones = match self.zoneless {
            true => Zones::default(),
            false => self.known("/api/zones").await?,
        };
        let monitors: Monitors = self.known("/api/monitors").await?;
        self.is_the_same(&hub)?;
        self.all_there(&zones, &monitors)?;
        Ok((zones, monitors))
    }

    /// The hub has not been restarted since the last look.
    fn is_the_same(&mut self, hub: &About) -> Step {
        if hub.up_ms < self.up_ms || hub.up_ms == 0 {
            return Err(End::Unsafe(text::HubRestarted.words()));
        }
        self.up_ms = hub.up_ms;
        Ok(())
    }

    /// The monitor that is held stays so.
    async fn renew(&mut self) -> Step {
        let now = self.wire.now_ms();
        let Some(held) = &mut self.held else { return Ok(()) };
        let since_ms = now.saturating_sub(held.taken_ms);
        if since_ms < RENEW_MS {
            return Ok(());
        }
        let id = held.id.clone();
        held.taken_ms = now;
        let lost = match since_ms >= LAPSED_MS {
            true => Some(text::TooSlow.words()),
            false => self.send(&id, &Order::Take).await?,
        };
        match lost {
            None => Ok(()),
            Some(why) => Err(End::Unsafe(text::MonitorLost { monitor: &id, why }.words())),
        }
    }

    /// An answer without a zone or a monitor that was there is none.
    fn all_there(&self, zones: &Zones, monitors: &Monitors) -> Step {
        let configured = self.facts.configured.iter().flat_map(|it| &it.zones);
        let zone = configured.map(|it| &it.zone).find(|it| zones.zone(it).is_none());
        let mut known = self.facts.monitors.iter().flat_map(|it| it.keys());
        let monitor = known.find(|it| !monitors.contains_key(*it));
        match zone.or(monitor) {
            Some(name) => Err(End::Lost(text::NotInAnswer { name }.words())),
            None => Ok(()),
        }
    }

    /// Nothing needs the monitors, and no person has said no.
    fn is_safe(&self, zones: &Zones) -> Step {
        if zones.state.lockout {
            return Err(End::Unsafe(text::LockoutOn.words()));
        }
        if let Some(detector) = zones.alarms().first() {
            return Err(End::Unsafe(text::StrangeAlarm { detector }.words()));
        }
        if let Some(zone) = zones.state.zones.iter().find(|it| it.is_active()) {
            return Err(End::Unsafe(text::ZoneNotQuiet { zone: &zone.zone }.words()));
        }
        let held = self.held.as_ref().map(|it| it.id.as_str());
        let out = zones.state.monitors.iter().find(|it| Some(it.monitor.as_str()) == held);
        let out = out.filter(|it| {
            let no = matches!(it.withheld.as_deref(), Some("refused" | "lockout"));
            no || it.engaged_for.is_some() || it.closing
        });
        match out {
            Some(it) => Err(End::Unsafe(text::PersonStopped { monitor: &it.monitor }.words())),
            None => Ok(()),
        }
    }

    /// No person has stopped, closed or locked the monitor that is held.
    fn is_heeded(&mut self, monitors: &Monitors) -> Step {
        let Some(held) = &mut self.held else { return Ok(()) };
        let Some(monitor) = monitors.get(&held.id) else { return Ok(()) };
        held.watched &= !monitor.status.stale;
        let now = monitor.urgent.clone().or(held.urgent.clone()).unwrap_or_default();
        let before = held.urgent.get_or_insert_with(|| now.clone());
        let own = now.stop.saturating_sub(before.stop).min(held.stopping);
        held.stopping -= own;
        before.stop += own;
        // A button post locks it out without the hub.
        held.locked |= monitor.is_locked_out() || now.lockout != before.lockout;
        match *before == now && !held.locked {
            true => Ok(()),
            false => Err(End::Unsafe(text::PersonStopped { monitor: &held.id }.words())),
        }
    }

    /// Why a monitor must not move. The look that shows that it may dates the order that follows.
    pub(super) async fn must_rest(&mut self, id: &str) -> Step<Option<Words>> {
        let rests = |monitors: &Monitors| {
            let it = monitors.get(id)?;
            (it.is_shut() && !it.flows()).then_some(())
        };
        // A state may be stale for a moment.
        let may = self.until(STALE_MS, rests).await?;
        Ok(may.is_none().then(|| text::NotShut.words()))
    }

    /// Looks until something is so, `ms` at most; how long it took.
    pub(super) async fn until<T>(
        &mut self,
        ms: u64,
        mut so: impl FnMut(&Monitors) -> Option<T>,
    ) -> Step<Option<(T, u64)>> {
        let start = self.wire.now_ms();
        loop {
            let monitors = self.look().await?;
            let took = self.wire.now_ms().saturating_sub(start);
            if let Some(it) = so(&monitors) {
                return Ok(Some((it, took)));
            }
            if took >= ms {
                return Ok(None);
            }
            self.pause(POLL_MS).await?;
        }
    }
}

/// A monitor that is heard and has a valve that it does not report closed, or water that flows.
pub(super) fn wet(monitors: &Monitors) -> Option<&str> {
    let open = |it: &Monitor| !it.status.stale && (!it.not_closed().is_empty() || it.flows());
    monitors.iter().find(|(_, it)| open(it)).map(|(id, _)| id.as_str())
}
