//! A site: several monitors, each with its own plant, around the same fires, in the same wind.
//!
//! Places are metres east and north of a point of the site; directions are compass bearings in
//! degrees, clockwise from north. A monitor is at a [`Pose`]; it knows nothing of the site, and
//! its world is shown the fires in its own coordinates (forward, left). Water that has landed is
//! counted here, on every fire it reaches, from any monitor. Walls and tanks stop what does not
//! pass over them.
//!
//! Monitors may draw from one [`Supply`]; then the more one takes, the less pressure the others
//! have. A step of 10 ms steps each monitor once, in their order: the cost is that of the monitors,
//! and the same seed gives the same run.

mod pose;
mod profile;
mod supply;
mod wind;

use crate::airborne::Portion;
use crate::detector::Glare;
use crate::event::{Event, Events, What};
use crate::fire::{Fire, FireSpec};
use crate::fires::Fires;
use crate::jet::Landing;
use crate::obstacle::{Obstacle, Shape};
use crate::sim::{Config, Sim};
use crate::world::STEP_MS;

use profile::Profile;

pub use pose::Pose;
pub use supply::{Supply, SupplySpec};
pub use wind::{Wind, WindSpec};

/// Water meets the ground, and fires burn, this often, ms.
const SLOW_MS: u64 = 100;

/// What a site is built from.
#[derive(Clone, Debug, Default)]
pub struct SiteConfig {
    /// Everything random comes from this.
    pub seed: u64,
    /// The wind.
    pub wind: WindSpec,
    /// Air, °C.
    pub ambient_c: f64,
    /// Walls and tanks.
    pub obstacles: Vec<Obstacle>,
    /// What shines without burning.
    pub glares: Vec<SiteGlare>,
    /// Mains that several monitors share.
    pub supplies: Vec<SupplySpec>,
    /// The monitors.
    pub monitors: Vec<MonitorConfig>,
    /// What burns, or can burn.
    pub fires: Vec<SiteFire>,
}

/// A monitor of a site.
#[derive(Clone, Debug, Default)]
pub struct MonitorConfig {
    /// Where it is.
    pub pose: Pose,
    /// Which of the site's supplies it draws from; `None` is a plant of its own.
    pub supply: Option<usize>,
    /// The monitor itself. Seed, wind, air, obstacles and fires are the site's.
    pub sim: Config,
}

/// A fire of a site.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SiteFire {
    /// Place, m east and north.
    pub at: (f64, f64),
    /// The fire; its direction and distance mean nothing here.
    pub spec: FireSpec,
    /// The obstacle that it is on: water on the wall of a tank cools what is on it.
    pub on: Option<usize>,
}

/// Something bright that is no fire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SiteGlare {
    /// A hot thing: place, height and size in m, and what it radiates, kW.
    Hot {
        /// Place, m east and north.
        at: (f64, f64),
        /// Height of its middle, m.
        height_m: f64,
        /// Width, m.
        size_m: f64,
        /// Radiation, kW.
        kw: f64,
    },
    /// The sun: bearing, elevation, and brightness as the detector sees it.
    Sun {
        /// Bearing, degrees.
        bearing_deg: f64,
        /// Elevation, degrees.
        elevation_deg: f64,
        /// Brightness in the detector's units.
        brightness: f64,
    },
}

/// A monitor on the site.
#[derive(Clone, Debug)]
pub struct Member {
    /// The monitor.
    pub sim: Sim,
    /// Where it is.
    pub pose: Pose,
    /// Water that has left its nozzle, l.
    pub litres: f64,
    /// Its supply, one of the site's.
    pub supply: Option<usize>,
}

/// Water that has come down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Splash {
    /// Which monitor threw it.
    pub monitor: usize,
    /// The water, in the site's coordinates.
    pub portion: Portion,
    /// The obstacle that stopped it.
    pub stopped_by: Option<usize>,
}

/// Something that has happened, to a monitor or to a fire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SiteEvent {
    /// The monitor; `None` for fires.
    pub monitor: Option<usize>,
    /// What, and when. Fires are numbered as the site's.
    pub event: Event,
}

/// A site.
#[derive(Clone, Debug)]
pub struct Site {
    /// The monitors.
    pub members: Vec<Member>,
    /// What burns, or can burn.
    pub fires: Fires,
    /// Mains that several monitors share.
    pub supplies: Vec<Supply>,
    /// The wind.
    pub wind: Wind,
    obstacles: Vec<Obstacle>,
    on: Vec<Option<usize>>,
    events: Events,
    splashes: Vec<Splash>,
    now_ms: u64,
}

impl Site {
    /// Builds the site and powers all monitors up.
    pub fn new(config: SiteConfig) -> Self {
        let wind = Wind::new(config.wind, config.seed);
        let supplies: Vec<Supply> = config.supplies.into_iter().map(Supply::new).collect();
        let fires = config.fires.iter().map(|fire| Fire::at(fire.spec, fire.at)).collect();
        let mut site = Self {
            members: Vec::new(),
            fires,
            supplies,
            wind,
            obstacles: config.obstacles,
            on: config.fires.iter().map(|fire| fire.on).collect(),
            events: Events::default(),
            splashes: Vec::new(),
            now_ms: 0,
        };
        for (index, fire) in site.fires.iter().enumerate() {
            if fire.burns() {
                site.events.note(0, What::FireLit(index));
            }
        }
        for (index, monitor) in (0..).zip(config.monitors) {
            let seed = config.seed.wrapping_add(index);
            let member = site.member(monitor, seed, config.ambient_c, &config.glares);
            site.members.push(member);
        }
        site.share_water();
        site.show();
        site
    }

    fn member(
        &self,
        monitor: MonitorConfig,
        seed: u64,
        ambient_c: f64,
        glares: &[SiteGlare],
    ) -> Member {
        let MonitorConfig { pose, supply, sim } = monitor;
        let eye = (pose.at.0, pose.at.1, sim.height_m);
        let seen = glares.iter().filter(|glare| !self.hidden(glare, eye));
        let local = |shape: Shape| match shape {
            Shape::Wall(a, b) => Shape::Wall(pose.local(a), pose.local(b)),
            Shape::Tank(middle, diameter_m) => Shape::Tank(pose.local(middle), diameter_m),
        };
        let glares = seen.map(|glare| glare.seen_from(&pose, sim.height_m)).collect();
        let obstacles =
            self.obstacles.iter().map(|it| Obstacle { shape: local(it.shape), ..*it }).collect();
        let wind = pose.turned(self.wind.now_mps());
        let mut sim = Sim::new(Config {
            seed,
            ambient_c,
            wind,
            glares,
            obstacles,
            fires: Vec::new(),
            shared_ground: true,
            ..sim
        });
        if supply.is_some() {
            // The pump belongs to the main.
            sim.world_mut().water.pump_drop_mpa = 0.0;
        }
        Member { sim, pose, litres: 0.0, supply }
    }

    fn hidden(&self, glare: &SiteGlare, eye: (f64, f64, f64)) -> bool {
        match *glare {
            SiteGlare::Hot { at, height_m, .. } => {
                self.obstacles.iter().any(|it| it.hides(eye, (at.0, at.1, height_m)))
            }
            SiteGlare::Sun { .. } => false,
        }
    }

    /// Virtual time since the beginning, ms.
    pub const fn now_ms(&self) -> u64 {
        self.now_ms
    }

    /// Walls and tanks.
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.obstacles
    }

    /// One step of 10 ms.
    pub fn tick(&mut self) {
        self.now_ms += STEP_MS;
        for member in &mut self.members {
            // One whose program has waited for its flash with an answer is ahead, and waits.
            while member.sim.now_ms() < self.now_ms {
                member.sim.tick();
                let jet_lps = member.sim.world().water.jet_lps();
                member.litres += jet_lps * (STEP_MS as f64 / 1000.0);
            }
        }
        self.share_water();
        if self.now_ms.is_multiple_of(SLOW_MS) {
            self.slow();
        }
    }

    /// Moves time; a part of a step is left out.
    pub fn advance_ms(&mut self, ms: u64) {
        for _ in 0..ms / STEP_MS {
            self.tick();
        }
    }

    /// Lights something that does not burn.
    pub fn ignite(&mut self, fire: usize) {
        if self.fires.ignite(fire) {
            self.events.note(self.now_ms, What::FireLit(fire));
            self.show();
        }
    }

    /// Adds something that burns, or can burn.
    pub fn add_fire(&mut self, fire: SiteFire) {
        let index = self.fires.add(Fire::at(fire.spec, fire.at));
        self.on.push(fire.on);
        if fire.spec.lit {
            self.events.note(self.now_ms, What::FireLit(index));
        }
        self.show();
    }

    /// Changes the temperature of the air for all monitors.
    pub fn set_ambient_c(&mut self, ambient_c: f64) {
        for member in &mut self.members {
            member.sim.world_mut().climate.ambient_c = ambient_c;
        }
    }

    /// What has happened since the last call, in the order of time.
    pub fn take_events(&mut self) -> Vec<SiteEvent> {
        let fires = self.events.take().into_iter().map(|event| SiteEvent { monitor: None, event });
        let mut all: Vec<SiteEvent> = fires.collect();
        for (index, member) in self.members.iter_mut().enumerate() {
            let events = member.sim.world_mut().take_events().into_iter();
            all.extend(events.map(|event| SiteEvent { monitor: Some(index), event }));
        }
        all.sort_by_key(|event| event.event.at_ms);
        all
    }

    /// The water that came down in the last 100 ms.
    pub fn splashes(&self) -> &[Splash] {
        &self.splashes
    }

    /// Where a monitor's jet lands now, in the site's coordinates.
    pub fn landing(&self, monitor: usize) -> Option<Landing> {
        let member = self.members.get(monitor)?;
        member.sim.world().landing().map(|landing| member.pose.landing(landing))
    }

    /// Each supply gives its monitors the pressure that the flow of all of them leaves.
    fn share_water(&mut self) {
        for index in 0..self.supplies.len() {
            let head_mpa = self.supplies[index].head_mpa(self.flow_lps(index));
            for member in self.members.iter_mut().filter(|member| member.supply == Some(index)) {
                member.sim.world_mut().water.head_mpa = head_mpa;
            }
        }
    }

    /// What the monitors draw from a supply together, l/s.
    pub fn flow_lps(&self, supply: usize) -> f64 {
        let drawing = self.members.iter().filter(|member| member.supply == Some(supply));
        drawing.map(|member| member.sim.world().water.flow_lps).sum()
    }

    fn slow(&mut self) {
        self.splashes.clear();
        for index in 0..self.members.len() {
            let Member { sim, pose, .. } = &mut self.members[index];
            let pose = *pose;
            for portion in sim.world_mut().take_landed() {
                let portion = Portion { landing: pose.landing(portion.landing), ..portion };
                self.land(index, portion);
            }
        }
        let dt_s = SLOW_MS as f64 / 1000.0;
        let (now_ms, events) = (self.now_ms, &mut self.events);
        self.fires.burn(dt_s, |what| events.note(now_ms, what));
        self.wind.step(dt_s);
        self.show();
    }

    /// Water comes down: on the ground, on a tank, or on the wall that it does not pass.
    fn land(&mut self, monitor: usize, portion: Portion) {
        let stop = self.stop(self.members[monitor].pose.at, &portion);
        let mut fallen = portion;
        let (now_ms, events, on) = (self.now_ms, &mut self.events, &self.on);
        let note = |what| events.note(now_ms, what);
        match stop {
            None => self.fires.catch_where(&portion, |fire| on[fire].is_none(), note),
            Some(Stop { obstacle, place, on_top }) => {
                fallen.landing.at = place;
                if on_top {
                    let above = above_ground(&fallen, self.obstacles[obstacle].height_m);
                    self.fires.catch_where(&above, |fire| on[fire] == Some(obstacle), note);
                } else {
                    let own = on.iter().zip(self.fires.iter_mut());
                    let cooled = own.filter(|(on, fire)| **on == Some(obstacle) && !fire.burns());
                    // Foam on the wall cools like water; none of it gets into the tank.
                    cooled.for_each(|(_, fire)| fire.wet(portion.litres, 0.0));
                }
            }
        }
        let stopped_by = stop.map(|stop| stop.obstacle);
        self.splashes.push(Splash { monitor, portion: fallen, stopped_by });
    }

    /// The first obstacle in the way of a jet, and where the water strikes it.
    fn stop(&self, from: (f64, f64), portion: &Portion) -> Option<Stop> {
        let to = portion.landing.at;
        let way = (to.0 - from.0, to.1 - from.1);
        let crossed: Vec<_> = (0..)
            .zip(&self.obstacles)
            .filter_map(|(index, it)| {
                let [near, far] = it.crossings(from, to);
                Some((index, it, near?, far.unwrap_or(1.0)))
            })
            .collect();
        if crossed.is_empty() {
            return None;
        }
        let profile = Profile::of(portion);
        let strikes = crossed.into_iter().filter_map(|(obstacle, it, near, far)| match it.shape {
            _ if profile.height_m(near) < it.height_m => Some((near, obstacle, false)),
            // Water that passes the near edge of a tank but not the far one falls into it.
            Shape::Tank(..) if profile.height_m(far) < it.height_m => {
                Some((profile.falls_to(it.height_m, near, far), obstacle, true))
            }
            _ => None,
        });
        let (part, obstacle, on_top) = strikes.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Stop { obstacle, place: (from.0 + way.0 * part, from.1 + way.1 * part), on_top })
    }

    /// Each monitor sees the fires and feels the wind in its own coordinates.
    fn show(&mut self) {
        let wind_mps = self.wind.now_mps();
        for Member { sim, pose, .. } in &mut self.members {
            let world = sim.world_mut();
            world.wind = pose.turned(wind_mps);
            world.fires = self.fires.iter().map(|fire| pose.fire(fire)).collect();
        }
    }
}

/// Where an obstacle ends the way of the water.
#[derive(Clone, Copy, Debug)]
struct Stop {
    obstacle: usize,
    place: (f64, f64),
    /// On the top of a tank, not on its wall.
    on_top: bool,
}

/// Water that has landed at a height, as if it had flown on to the ground: so it meets the shadow
/// of what burns at that height.
fn above_ground(portion: &Portion, height_m: f64) -> Portion {
    let landing = &portion.landing;
    let on_m = height_m / landing.slope;
    let at = (
        landing.at.0 + on_m * libm::cos(landing.heading),
        landing.at.1 + on_m * libm::sin(landing.heading),
    );
    Portion { landing: Landing { at, ..*landing }, ..*portion }
}

impl SiteGlare {
    fn seen_from(&self, pose: &Pose, eye_m: f64) -> Glare {
        match *self {
            Self::Hot { at, height_m, size_m, kw } => {
                let local = pose.local(at);
                let range_m = libm::hypot(local.0, local.1).max(0.1);
                Glare {
                    azimuth_deg: libm::atan2(local.1, local.0).to_degrees(),
                    elevation_deg: libm::atan2(height_m - eye_m, range_m).to_degrees(),
                    size_deg: 2.0 * libm::atan2(size_m / 2.0, range_m).to_degrees(),
                    brightness: 1000.0 * kw / (range_m * range_m),
                }
            }
            Self::Sun { bearing_deg, elevation_deg, brightness } => Glare {
                azimuth_deg: pose.azimuth_deg(bearing_deg),
                elevation_deg,
                size_deg: 0.5,
                brightness,
            },
        }
    }
}

#[cfg(test)]
mod tests;
