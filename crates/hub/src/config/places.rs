//! Names of the hub, origins that may use it, and the map of the site.

use std::collections::BTreeMap;

use lafet_texts::{Text as _, hub as text};
use toml::Spanned;

use super::check::Check;
use super::file::{File, Monitor};
use crate::site::keep_out::{KeepOut, Span, Swept};
use crate::site::planned::check_place;
use crate::site::{Place, Site, Tank, Wall};

/// What is on a site is not farther from its middle, nor higher.
const FARTHEST_M: f64 = 100_000.0;
const HIGHEST_M: f64 = 1000.0;
/// Most keep-outs: each request of a monitor is compared with all.
const KEEP_OUTS_MAX: usize = 64;
/// Longest name of a keep-out.
const NAME_MAX: usize = 64;

impl Check<'_> {
    /// Names under which the hub is reached.
    pub fn names(&mut self, names: Vec<Spanned<String>>) -> Vec<String> {
        let fine = |c: char| c.is_alphanumeric() || c == '.' || c == '-' || c == '_';
        for name in &names {
            if name.get_ref().is_empty() || !name.get_ref().chars().all(fine) {
                let name_text = name.get_ref();
                self.say(
                    name.span().start,
                    text::CheckHostName { name: name_text }.words(),
                    text::CheckHostNameRemedy.words(),
                );
            }
        }
        names.into_iter().map(Spanned::into_inner).collect()
    }

    /// An origin is compared as browsers send it.
    pub fn origins(&mut self, origins: Vec<Spanned<String>>) -> Vec<String> {
        for origin in &origins {
            let place = ["https://", "http://"]
                .iter()
                .find_map(|scheme| origin.get_ref().strip_prefix(scheme))
                .filter(|place| !place.is_empty() && !place.contains(['/', '*', '?', '#', '@']));
            if place.is_none() {
                let text = origin.get_ref();
                self.say(
                    origin.span().start,
                    text::CheckOrigin { text }.words(),
                    text::CheckOriginRemedy.words(),
                );
            }
        }
        let lower = |origin: Spanned<String>| origin.into_inner().to_ascii_lowercase();
        origins.into_iter().map(lower).collect()
    }

    /// Where things are, if the file says it of a monitor. The plan has to be drawn.
    pub fn site(&mut self, read: &File) -> Option<Site> {
        self.places(&read.monitor, &read.tank, &read.wall);
        let placed = read.monitor.iter().map(Spanned::get_ref).filter_map(|it| {
            let (at, heading, height) = (*it.at.as_ref()?.get_ref(), it.heading, it.height);
            Some((it.id.get_ref().clone(), Place { at, heading, height }))
        });
        let monitors: BTreeMap<String, Place> = placed.collect();
        let keep_outs = self.keep_outs(read, &monitors);
        let tanks = values(&read.tank);
        let walls = values(&read.wall);
        self.plannable(read, &monitors);
        (!monitors.is_empty()).then_some(Site { monitors, tanks, walls, keep_outs })
    }

    /// The planner of the zones computes within narrower bounds than a map may have.
    fn plannable(&mut self, read: &File, placed: &BTreeMap<String, Place>) {
        if read.detector.iter().all(|it| it.get_ref().at.is_none()) {
            return;
        }
        let monitors = read.monitor.iter().filter_map(|it| {
            let place = placed.get(it.get_ref().id.get_ref())?;
            Some((it.span().start, check_place(place)))
        });
        let tanks = read.tank.iter().map(|it| (it.span().start, it.get_ref().check_planned()));
        let walls = read.wall.iter().map(|it| (it.span().start, it.get_ref().check_planned()));
        let all = monitors.chain(tanks).chain(walls);
        let found: Vec<_> = all.filter_map(|(at, it)| Some((at, it.err()?))).collect();
        for (at, problem) in found {
            self.warn(at, problem.0, text::CheckPlannedRemedy.words());
        }
        let obstacles = read.tank.len() + read.wall.len();
        if obstacles > lafet_place::OBSTACLES_MAX {
            let at = read.wall.last().map_or(0, |it| it.span().start);
            let most = lafet_place::OBSTACLES_MAX;
            self.warn(at, text::CheckObstacles { most }.words(), text::CheckPlannedRemedy.words());
        }
    }

    fn places(
        &mut self,
        monitors: &[Spanned<Monitor>],
        tanks: &[Spanned<Tank>],
        walls: &[Spanned<Wall>],
    ) {
        let on_site = |it: &[f64]| it.iter().all(|it| it.abs() <= FARTHEST_M);
        let height = |it: f64| (0.0..=HIGHEST_M).contains(&it);
        let wrong = monitors
            .iter()
            .filter(|it| {
                let it = it.get_ref();
                let at = it.at.as_ref().is_none_or(|at| on_site(at.get_ref()));
                !(at && it.heading.abs() <= 360.0 && it.height.abs() <= HIGHEST_M)
            })
            .map(|it| it.span().start);
        let tank = |it: &Tank| on_site(&it.at) && it.diameter > 0.0 && height(it.height);
        let wrong = wrong.chain(
            tanks
                .iter()
                .filter(|it| !tank(it.get_ref()) || it.get_ref().diameter > FARTHEST_M)
                .map(|it| it.span().start),
        );
        let wall = |it: &Wall| on_site(&it.from) && on_site(&it.to) && height(it.height);
        let wrong: Vec<usize> = wrong
            .chain(walls.iter().filter(|it| !wall(it.get_ref())).map(|it| it.span().start))
            .collect();
        for byte in wrong {
            self.say(byte, text::CheckPlan.words(), text::CheckPlanRemedy.words());
        }
    }

    /// A keep-out that does not count for a monitor as written protects nothing.
    fn keep_outs(&mut self, read: &File, placed: &BTreeMap<String, Place>) -> Vec<KeepOut> {
        let mut keep_outs: Vec<KeepOut> = Vec::new();
        for spanned in &read.keep_out {
            let (it, at) = (spanned.get_ref(), spanned.span().start);
            let name = it.name.get_ref();
            let known = name.chars().count() <= NAME_MAX && !name.trim().is_empty();
            if !known || keep_outs.iter().any(|other| other.name == *name) {
                let byte = it.name.span().start;
                let remedy = text::CheckKeepOutNameRemedy { most: NAME_MAX }.words();
                self.say(byte, text::CheckKeepOutName { name }.words(), remedy);
            }
            let [from, to] = it.elevations;
            let bearings = it.bearings.iter().all(|bearing| bearing.abs() <= 360.0);
            let elevations = it.elevations.iter().all(|it| it.abs() <= 90.0) && from <= to;
            if !bearings || !elevations {
                let remedy = text::CheckKeepOutAnglesRemedy.words();
                self.say(at, text::CheckKeepOutAngles { name }.words(), remedy);
            }
            let [left, right] = it.bearings;
            let turns = (right - left).rem_euclid(360.0) > 0.0 || right - left >= 360.0;
            if bearings && elevations && !(turns && from < to) {
                let remedy = text::CheckKeepOutNarrowRemedy.words();
                self.say(at, text::CheckKeepOutNarrow { name }.words(), remedy);
            }
            let monitor = it.monitor.as_ref().map(Spanned::get_ref);
            if let Some(of) = monitor
                && !read.monitor.iter().any(|it| it.get_ref().id.get_ref() == of)
            {
                let remedy = text::CheckKeepOutMonitorRemedy.words();
                self.say(at, text::CheckKeepOutMonitor { name, monitor: of }.words(), remedy);
            }
            let keep_out = KeepOut {
                name: name.clone(),
                of: it.of,
                monitor: monitor.cloned(),
                bearings: it.bearings,
                elevations: it.elevations,
            };
            self.placed(read, placed, at, &keep_out);
            self.aims_clear_of(read, placed, &keep_out);
            keep_outs.push(keep_out);
        }
        if let Some(first) = read.keep_out.get(KEEP_OUTS_MAX) {
            let at = first.span().start;
            let what = text::CheckKeepOutsTooMany { most: KEEP_OUTS_MAX }.words();
            self.say(at, what, text::CheckKeepOutsTooManyRemedy.words());
        }
        keep_outs
    }

    /// Bearings are those of the site: a monitor without a place has none.
    fn placed(
        &mut self,
        read: &File,
        placed: &BTreeMap<String, Place>,
        at: usize,
        keep_out: &KeepOut,
    ) {
        let ids = read.monitor.iter().map(|it| it.get_ref().id.get_ref());
        for id in ids.filter(|id| keep_out.is_of(id) && !placed.contains_key(*id)) {
            let what = text::CheckKeepOutPlace { name: &keep_out.name, monitor: id }.words();
            self.say(at, what, text::CheckKeepOutPlaceRemedy { monitor: id }.words());
        }
    }

    /// Where a monitor aims without knowing more must not be kept clear.
    fn aims_clear_of(&mut self, read: &File, placed: &BTreeMap<String, Place>, keep_out: &KeepOut) {
        for spanned in &read.aim {
            let aim = spanned.get_ref();
            let place = placed.get(&aim.monitor).filter(|_| keep_out.is_of(&aim.monitor));
            let horizontal = Span::at(aim.horizontal.into());
            let swept = Swept { horizontal, ..Swept::WHOLE };
            if place.is_some_and(|place| keep_out.meets(place, swept)) {
                let (name, monitor) = (&keep_out.name, &aim.monitor);
                let what = text::CheckKeepOutAim { monitor, zone: &aim.zone, name }.words();
                self.say(spanned.span().start, what, text::CheckKeepOutAimRemedy.words());
            }
        }
    }
}

/// What a list of tables consists of.
pub fn values<T: Clone>(list: &[Spanned<T>]) -> Vec<T> {
    list.iter().map(|it| it.get_ref().clone()).collect()
}
