//! §3.21 «Структура одного очага»: the list of hotbeds, brightest first.

use crate::subsystem::control::approach::Direction;
use lafet_proto::status::Hotbed;

/// Sightings whose boxes come this near to each other are one hotbed, arc-minutes. The barrel has
/// moved by up to 12' since the picture, to either side, so two of one fire lie up to 24' apart;
/// but a fire above the threshold is wider than that, and its boxes overlap. Two fires are kept
/// apart when half a degree lies between them.
const MARGIN_ARCMIN: i32 = 12;

/// At most four, brightest first (§3.16/5).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Hotbeds {
    list: [Hotbed; Hotbed::MAX],
    len: usize,
}

impl Hotbeds {
    pub(super) fn as_slice(&self) -> &[Hotbed] {
        self.list.get(..self.len).unwrap_or_default()
    }

    /// Takes a sighting: it makes a hotbed grow, joins several, or is a new one. The dimmest makes
    /// room for a brighter one.
    pub(super) fn see(&mut self, seen: Hotbed) {
        let mut all = seen;
        // Each round joins one, and may bring the next within reach.
        while let Some(index) = self.as_slice().iter().position(|known| near(known, &all)) {
            if let Some(known) = self.remove(index) {
                all = joined(&known, &all);
            }
        }
        if self.len < self.list.len() {
            self.len += 1;
            self.replace(self.len - 1, all);
        } else if let Some(last) = self.list.last_mut()
            && last.brightness < all.brightness
        {
            *last = all;
        }
        self.sort();
    }

    pub(super) fn replace(&mut self, index: usize, hotbed: Hotbed) {
        if let Some(place) = self.list.get_mut(index) {
            *place = hotbed;
        }
    }

    pub(super) fn remove(&mut self, index: usize) -> Option<Hotbed> {
        let mut rest = self.list.get_mut(index..self.len)?;
        let removed = *rest.first()?;
        while let [place, next, ..] = rest {
            *place = *next;
            rest = rest.get_mut(1..)?;
        }
        self.len -= 1;
        Some(removed)
    }

    /// Brightest first; of equals, the one that was found first.
    pub(super) fn sort(&mut self) {
        let Some(found) = self.list.get_mut(..self.len) else { return };
        // Insertion by neighbours: four entries, no allocation.
        for _ in 0..Hotbed::MAX {
            let mut rest = &mut *found;
            while let [first, second, ..] = rest {
                if first.brightness < second.brightness {
                    core::mem::swap(first, second);
                }
                rest = rest.get_mut(1..).unwrap_or_default();
            }
        }
    }
}

/// Two boxes that overlap or nearly do.
pub(super) fn near(a: &Hotbed, b: &Hotbed) -> bool {
    let meet = |low_a: i32, high_a: i32, low_b: i32, high_b: i32| {
        low_a <= high_b.saturating_add(MARGIN_ARCMIN)
            && low_b <= high_a.saturating_add(MARGIN_ARCMIN)
    };
    meet(a.x2, a.x1, b.x2, b.x1) && meet(a.y1, a.y2, b.y1, b.y2)
}

/// The middle of a box.
pub(super) fn centre(hotbed: &Hotbed) -> Direction {
    let middle = |a: i32, b: i32| a.saturating_add(b.saturating_sub(a) / 2);
    Direction { horizontal: middle(hotbed.x2, hotbed.x1), vertical: middle(hotbed.y1, hotbed.y2) }
}

/// The box around two.
pub(super) fn joined(a: &Hotbed, b: &Hotbed) -> Hotbed {
    Hotbed {
        x1: a.x1.max(b.x1),
        x2: a.x2.min(b.x2),
        y1: a.y1.min(b.y1),
        y2: a.y2.max(b.y2),
        brightness: a.brightness.max(b.brightness),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn spot(h: i32, v: i32, brightness: i32) -> Hotbed {
        Hotbed { x1: h + 50, x2: h - 50, y1: v - 50, y2: v + 50, brightness }
    }

    fn brightness(hotbeds: &Hotbeds) -> Vec<i32> {
        hotbeds.as_slice().iter().map(|hotbed| hotbed.brightness).collect()
    }

    /// §3.16/5
    #[test]
    fn four_brightest_first() {
        let mut hotbeds = Hotbeds::default();
        for (n, value) in [30, 50, 20, 40, 10, 60, 15].into_iter().enumerate() {
            hotbeds.see(spot(n as i32 * 500, 0, value));
        }
        assert_eq!(brightness(&hotbeds), [60, 50, 40, 30]);
        assert_eq!(hotbeds.remove(1).map(|hotbed| hotbed.brightness), Some(50));
        assert_eq!(brightness(&hotbeds), [60, 40, 30]);
        assert_eq!(hotbeds.remove(3), None);
    }

    /// §3.16/5 Of equally bright ones those that were found first.
    #[test]
    fn equals_keep_their_places() {
        let mut hotbeds = Hotbeds::default();
        for n in 0..6 {
            hotbeds.see(spot(n * 500, 0, 30));
        }
        let found: Vec<i32> = hotbeds.as_slice().iter().map(|h| centre(h).horizontal).collect();
        assert_eq!(found, [0, 500, 1000, 1500]);
    }

    #[test]
    fn sightings_of_one_fire_are_one() {
        let mut hotbeds = Hotbeds::default();
        hotbeds.see(spot(0, 0, 30));
        hotbeds.see(spot(12, -3, 32));
        hotbeds.see(spot(-12, 3, 31));
        let whole = Hotbed { x1: 62, x2: -62, y1: -53, y2: 53, brightness: 32 };
        assert_eq!(hotbeds.as_slice(), [whole]);
        assert_eq!(centre(&whole), Direction::default());
    }

    /// Two that were apart become one when something between them is seen.
    #[test]
    fn joining() {
        let mut hotbeds = Hotbeds::default();
        hotbeds.see(spot(0, 0, 30));
        hotbeds.see(spot(200, 0, 40));
        assert_eq!(hotbeds.as_slice().len(), 2);
        hotbeds.see(spot(100, 0, 10));
        let whole = Hotbed { x1: 250, x2: -50, y1: -50, y2: 50, brightness: 40 };
        assert_eq!(hotbeds.as_slice(), [whole]);
        assert!(!near(&spot(0, 0, 1), &spot(0, 113, 1)) && near(&spot(0, 0, 1), &spot(0, 112, 1)));
    }
}
