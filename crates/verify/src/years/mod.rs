//! Years in the life of a monitor, with what an owner does to it: a test every week, heating
//! through the seasons, parameters, restarts, power cuts, faults now and then, and fires.
//!
//! What must hold is checked all the time; the first thing that does not ends the run with an
//! error that names the day and the seed. The clock of the monitor starts a minute before it
//! wraps, and wraps again after each 49.7 days without a reset.

mod check;
mod life;

use core::f64::consts::TAU;

use lafet_sim::rng::Rng;
use lafet_sim::sim::{Config, Sim};

/// Days of a year.
pub const YEAR_DAYS: u64 = 365;

const HOUR_MS: u64 = 3_600_000;
/// Power-up happens so long before the clock wraps, ms.
const BEFORE_WRAP_MS: u32 = 60_000;
const WRAP_MS: u64 = 1 << 32;

/// What has happened so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Days gone.
    pub days: u64,
    /// Virtual time, ms.
    pub ms: u64,
    /// Of it stepped through, ms; the rest was rest.
    pub stepped_ms: u64,
    /// Weekly tests passed.
    pub tests: u64,
    /// Fires lit; each was found and put out.
    pub fires: u64,
    /// Longest time from the search to the last flame, s.
    pub fire_s_max: u64,
    /// Faults injected; each was reported, or does not show at rest, and none was left in the flags.
    pub faults: u64,
    /// Of them reported by a flag while the monitor was idle.
    pub faults_told: u64,
    /// Parameters accepted and found again after a reset.
    pub parameters: u64,
    /// Restarts asked for.
    pub restarts: u64,
    /// Power cuts.
    pub power_cuts: u64,
    /// Lockouts that outlived a power cut and a restart.
    pub lockouts: u64,
    /// Words of the flash that were written, by all that was stored.
    pub flash_words: u64,
    /// How often the page that was erased most was erased.
    pub flash_erases: u32,
    /// Times the heaters went on.
    pub heatings: u64,
    /// Times the monitor's clock wrapped.
    pub wraps: u64,
    /// Water used, m³.
    pub water_m3: f64,
    /// Way of each drive: °, °, mm, °.
    pub ways: [f64; 4],
    /// Worst difference between where a drive is and where it was sent, ' or mm.
    pub error_max: f64,
    /// The same in the last year alone: it must not grow.
    pub error_last_year: f64,
}

/// A monitor with its owner.
#[derive(Clone, Debug)]
pub struct Years {
    sim: Sim,
    rng: Rng,
    seed: u64,
    report: Report,
    heated: bool,
    locked: bool,
    /// Virtual time of the last power-up.
    started_ms: u64,
}

impl Years {
    /// A new monitor, wrapped.
    pub fn new(seed: u64) -> Self {
        let clock_ms = 0_u32.wrapping_sub(BEFORE_WRAP_MS);
        let sim = Sim::new(Config { seed, clock_ms, ambient_c: 5.0, ..Config::default() });
        let (rng, report) = (Rng::new(seed ^ 0x7965_6172), Report::default());
        Self { sim, rng, seed, report, heated: false, locked: false, started_ms: 0 }
    }

    /// What has happened so far.
    pub const fn report(&self) -> &Report {
        &self.report
    }

    /// One day; the error says what did not hold.
    pub fn day(&mut self) -> Result<(), String> {
        let day = self.report.days;
        if day.is_multiple_of(YEAR_DAYS) {
            self.report.error_last_year = 0.0;
        }
        for hour in 0..24 {
            self.weather(day, hour);
            self.hour(day, hour).map_err(|what| {
                format!(
                    "seed {}, day {day}, hour {hour}: {what}\n{}",
                    self.seed,
                    self.sim.trace_line()
                )
            })?;
        }
        let chip = self.sim.world().flash.chip();
        let erases = chip.erases();
        self.report.flash_erases = erases.iter().copied().max().unwrap_or(0);
        let pages: u64 = erases.iter().copied().map(u64::from).sum();
        self.report.flash_words = chip.steps().saturating_sub(pages);
        self.report.days += 1;
        self.report.ms = self.sim.now_ms();
        self.report.stepped_ms = self.sim.now_ms() - self.sim.passed_over_ms();
        Ok(())
    }

    /// −25 °C on a winter's night, 31 °C on a summer's afternoon; the same all through the hour.
    fn weather(&mut self, day: u64, hour: u64) {
        let season = (TAU * (day % YEAR_DAYS) as f64 / YEAR_DAYS as f64).cos();
        let sun = (TAU * (hour as f64 - 15.0) / 24.0).cos();
        self.sim.world_mut().climate.ambient_c = 3.0 - 20.0 * season + 8.0 * sun;
    }

    /// An hour: perhaps with work; then at rest.
    fn hour(&mut self, day: u64, hour: u64) -> Result<(), String> {
        let start_ms = self.sim.now_ms();
        match (day % 7, hour) {
            (0, 10) => self.weekly_test()?,
            (2, 14) => self.trouble()?,
            (3, 9) if day % 28 == 3 => self.parameters()?,
            (4, 23) if day % 91 == 4 => self.lockout()?,
            (5, 3) if day % 70 == 5 => self.fire()?,
            (6, 11) if day % 63 == 6 => self.restart()?,
            _ => {}
        }
        let spent_ms = self.sim.now_ms() - start_ms;
        self.pass(HOUR_MS.saturating_sub(spent_ms));
        self.stands_still()
    }

    fn pass(&mut self, ms: u64) {
        let clock =
            |sim: &Sim, started_ms| sim.now_ms() - started_ms + WRAP_MS - u64::from(BEFORE_WRAP_MS);
        let before = clock(&self.sim, self.started_ms) / WRAP_MS;
        self.sim.pass_ms(ms);
        self.report.wraps += clock(&self.sim, self.started_ms) / WRAP_MS - before;
        let heats = self.sim.world().outputs().heaters.contains(&true);
        self.report.heatings += u64::from(heats && !self.heated);
        self.heated = heats;
    }

    fn power_up(&mut self) {
        self.started_ms = self.sim.now_ms();
    }
}

impl core::fmt::Display for Report {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let [vertical, horizontal, nozzle, deployer] = self.ways;
        let rows = [
            ("days", format!("{}", self.days)),
            ("of them stepped through", format!("{:.2} h", self.stepped_ms as f64 / 3.6e6)),
            ("weekly tests", format!("{}", self.tests)),
            ("fires found and put out", format!("{}, longest {} s", self.fires, self.fire_s_max)),
            ("faults", format!("{}, {} reported at rest", self.faults, self.faults_told)),
            ("parameters kept over a reset", format!("{}", self.parameters)),
            ("restarts, power cuts", format!("{}, {}", self.restarts, self.power_cuts)),
            ("lockouts over both", format!("{}", self.lockouts)),
            (
                "flash",
                format!(
                    "{} words written, no page erased more than {} times",
                    self.flash_words, self.flash_erases
                ),
            ),
            ("times heated", format!("{}", self.heatings)),
            ("wraps of the clock", format!("{}", self.wraps)),
            ("water", format!("{:.0} m³", self.water_m3)),
            ("way, elevation and traverse", format!("{vertical:.0}°, {horizontal:.0}°")),
            ("way, nozzle and deployment", format!("{nozzle:.0} mm, {deployer:.0}°")),
            (
                "worst position",
                format!("{:.2}, in the last year {:.2}", self.error_max, self.error_last_year),
            ),
        ];
        for (name, value) in rows {
            writeln!(f, "{name:<30} {value}")?;
        }
        Ok(())
    }
}
