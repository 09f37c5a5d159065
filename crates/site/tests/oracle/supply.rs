//! Zone valves and pumps: what they may and must do.

use lafet_site::{Authority, Config, Valve};

use super::{Motor, Oracle, Seen, s};

impl Oracle {
    /// A person has water from this monitor, and no no has come since.
    fn by_hand(&self, monitor: usize) -> bool {
        let barrel = &self.barrels[monitor];
        let water = barrel.report.valve == Valve::Open || barrel.report.extinguishing;
        let theirs = barrel.hand || barrel.report.authority == Authority::Person;
        water && theirs && barrel.closing.is_none() && self.lockout.is_none()
    }

    /// Neither valve nor pumps are taken from the water of a person.
    pub(super) fn supplied(
        &self,
        config: &Config,
        stopped: &[&String],
        seen: &mut Seen,
    ) -> Result<(), String> {
        for (index, zone) in config.zones.iter().enumerate() {
            let serves = |it: &usize| zone.monitors.contains(&config.monitors[*it]);
            let flows = (0..self.barrels.len()).filter(serves).any(|it| self.by_hand(it));
            if !flows || self.pressed[index] {
                continue;
            }
            seen.insert("a person's water");
            let pumps = config.pumps.iter().map(|it| &it.id);
            let mut needs = pumps.chain(&zone.valve);
            if let Some(lost) = needs.find(|it| stopped.contains(it)) {
                return Err(format!("{lost} is taken from a person's water"));
            }
        }
        Ok(())
    }

    pub(super) fn opened(&self, config: &Config, output: &str) -> Result<(), String> {
        let allowed = config.zones.iter().zip(&self.areas).any(|(zone, area)| {
            let valve = zone.valve.as_deref() == Some(output);
            let by_hand = (0..self.barrels.len()).any(|it| self.by_hand(it));
            valve && (area.force.is_some_and(|(_, _, wet)| wet) || by_hand)
        });
        if allowed { Ok(()) } else { Err("a zone valve opens without a release".to_owned()) }
    }

    pub(super) fn pump(
        &mut self,
        config: &Config,
        pump: usize,
        on: bool,
        seen: &mut Seen,
    ) -> Result<(), String> {
        if !on {
            let Motor { off, stopped, .. } = self.motors[pump];
            self.motors[pump] = Motor { off, stopped, ..Motor::default() };
            return Ok(());
        }
        let configured = &config.pumps[pump];
        let wait = s(configured.start_delay_s);
        let before = &self.motors[..pump];
        let early = before.iter().filter_map(|it| it.on).any(|age| age < wait);
        let duty = before.iter().zip(&config.pumps).filter(|(_, it)| !it.standby);
        let skipped = duty.clone().any(|(it, _)| it.on.is_none() && it.off.is_none());
        let failed = before.iter().zip(&config.pumps).any(|(motor, it)| {
            let dry = motor.on.is_some() && motor.dry >= s(it.start_timeout_s);
            it.pressure.is_some() && dry || motor.off.is_some()
        });
        if early || skipped || self.lockout.is_some() {
            return Err(format!("pump {} starts too early", configured.id));
        }
        if configured.standby && !failed {
            return Err(format!("pump {} replaces nothing", configured.id));
        }
        if configured.standby {
            seen.insert("pump replaced");
        } else if pump > 0 {
            seen.insert("pumps in sequence");
        }
        if self.motors[pump].off.is_some() {
            return Err(format!("pump {} starts, which a person keeps off", configured.id));
        }
        self.motors[pump] = Motor { on: Some(0), ..Motor::default() };
        Ok(())
    }

    pub(super) fn is_wet(&self) -> bool {
        self.areas.iter().any(|area| area.force.is_some_and(|(_, _, wet)| wet))
    }

    pub(super) fn pumped(&self, config: &Config) -> Result<(), String> {
        let wet = self.is_wet();
        let failed = self.motors.iter().zip(&config.pumps).any(|(motor, it)| {
            // The standby pump waits for its turn in the row.
            let timeout = s(it.start_timeout_s + 1);
            let dry = it.pressure.is_some() && motor.on.is_some() && motor.dry >= timeout;
            dry || motor.off.is_some_and(|age| age > s(3))
        });
        let mut standby = self.motors.iter().zip(&config.pumps).filter(|(_, it)| it.standby);
        if wet && failed && standby.any(|(motor, _)| motor.on.is_none()) {
            return Err("a failed pump is not replaced".to_owned());
        }
        Ok(())
    }
}
