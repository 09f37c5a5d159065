//! Everything that burns or can burn, and what water and heat do to it.
//!
//! A single monitor's world has its own; on a [site](crate::site) there is one for all, and each
//! monitor is shown a copy in its own coordinates.

use core::ops::{Deref, DerefMut};

use crate::airborne::Portion;
use crate::event::What;
use crate::fire::{Fire, spread};

/// Everything that was lit, burning or out, and what can catch fire. A fire's number is its place.
#[derive(Clone, Debug, Default)]
pub struct Fires {
    all: Vec<Fire>,
    /// Water has reached it.
    hit: Vec<bool>,
    /// It has burnt before.
    caught: Vec<bool>,
}

impl Deref for Fires {
    type Target = [Fire];

    fn deref(&self) -> &[Fire] {
        &self.all
    }
}

impl DerefMut for Fires {
    fn deref_mut(&mut self) -> &mut [Fire] {
        &mut self.all
    }
}

impl FromIterator<Fire> for Fires {
    fn from_iter<I: IntoIterator<Item = Fire>>(fires: I) -> Self {
        let mut all = Self::default();
        fires.into_iter().for_each(|fire| {
            all.add(fire);
        });
        all
    }
}

impl Fires {
    /// One more; its number.
    pub fn add(&mut self, fire: Fire) -> usize {
        self.hit.push(false);
        self.caught.push(fire.burns());
        self.all.push(fire);
        self.all.len() - 1
    }

    /// Whether it burns or has burnt.
    pub fn has_caught(&self, index: usize) -> bool {
        self.caught.get(index).copied().unwrap_or(false)
    }

    /// Lights what does not burn; whether it did not.
    pub fn ignite(&mut self, index: usize) -> bool {
        let Some(fire) = self.all.get_mut(index).filter(|fire| !fire.burns()) else {
            return false;
        };
        fire.heat = 1.0;
        self.caught[index] = true;
        true
    }

    /// A portion of water lands; `note` gets the fires that it reaches for the first time.
    pub fn catch(&mut self, portion: &Portion, note: impl FnMut(What)) {
        self.catch_where(portion, |_| true, note);
    }

    /// As [`Fires::catch`], for those fires alone that the water can get to.
    pub fn catch_where(
        &mut self,
        portion: &Portion,
        can_reach: impl Fn(usize) -> bool,
        mut note: impl FnMut(What),
    ) {
        let fires = self.all.iter_mut().enumerate();
        for (index, fire) in fires.filter(|(index, _)| can_reach(*index)) {
            let caught = fire.catch(portion);
            if caught && !core::mem::replace(&mut self.hit[index], true) {
                note(What::FireHit(index));
            }
        }
    }

    /// All burn for `dt_s` and light what is near; `note` gets what catches and goes out.
    pub fn burn(&mut self, dt_s: f64, mut note: impl FnMut(What)) {
        let burned: Vec<bool> = self.all.iter().map(Fire::burns).collect();
        self.all.iter_mut().for_each(|fire| fire.step(dt_s));
        spread(&mut self.all, dt_s);
        for (index, burned) in burned.into_iter().enumerate() {
            match (burned, self.all[index].burns()) {
                (true, false) => note(What::FireOut(index)),
                (false, true) if self.caught[index] => note(What::FireReignited(index)),
                (false, true) => {
                    self.caught[index] = true;
                    note(What::FireLit(index));
                }
                _ => {}
            }
        }
    }
}
