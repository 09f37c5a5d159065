//! Names of the hub, origins that may use it, and the map of the site.

use std::collections::BTreeMap;

use lafet_texts::{Text as _, hub as text};
use toml::Spanned;

use super::check::Check;
use super::file::Monitor;
use crate::site::{Place, Site, Tank, Wall};

/// What is on a site is not farther from its middle, nor higher.
const FARTHEST_M: f64 = 100_000.0;
const HIGHEST_M: f64 = 1000.0;

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

    /// The plan has to be drawn.
    pub fn places(
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
}

/// Where things are, if the file says it of a monitor.
pub fn site(
    monitors: &[Spanned<Monitor>],
    tanks: Vec<Spanned<Tank>>,
    walls: Vec<Spanned<Wall>>,
) -> Option<Site> {
    let placed = monitors.iter().map(Spanned::get_ref).filter_map(|it| {
        let (at, heading, height) = (*it.at.as_ref()?.get_ref(), it.heading, it.height);
        Some((it.id.get_ref().clone(), Place { at, heading, height }))
    });
    let monitors: BTreeMap<String, Place> = placed.collect();
    let tanks = tanks.into_iter().map(Spanned::into_inner).collect();
    let walls = walls.into_iter().map(Spanned::into_inner).collect();
    (!monitors.is_empty()).then_some(Site { monitors, tanks, walls })
}
