//! The monitors of a site on the network: all on one bus, or each at an address of its own.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use lafet_device::Source;
use lafet_sim::exercise::{Director, Link};

use super::{Bus, Wire};

/// The site shared by all connections.
#[derive(Clone)]
pub struct SharedSite(Arc<Mutex<Director>>);

impl SharedSite {
    /// Shares a site.
    pub fn new(director: Director) -> Self {
        Self(Arc::new(Mutex::new(director)))
    }

    /// Locks the site. Do not hold the guard across an await.
    pub fn lock(&self) -> MutexGuard<'_, Director> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A connection to some of its monitors, by index.
    pub fn tap(&self, members: Vec<usize>) -> Tap {
        Tap { site: self.clone(), members }
    }
}

/// A connection to some monitors of a site. It carries nothing over a link that the scenario has
/// cut.
#[derive(Clone)]
pub struct Tap {
    site: SharedSite,
    members: Vec<usize>,
}

impl Bus for Tap {
    fn receive(&self, wire: &mut Wire, bytes: &[u8]) -> Vec<u8> {
        let mut director = self.site.lock();
        let mut answers = Vec::new();
        for (number, member) in self.members.iter().enumerate() {
            let link = director.link(*member, wire.source());
            if link == Link::Lost {
                continue;
            }
            let own = wire.receive(number, &mut director.site.members[*member].sim, bytes);
            if link == Link::Up {
                answers.extend(own);
            }
        }
        answers
    }

    fn datagram(&self, source: Source, bytes: &[u8]) -> Option<Vec<u8>> {
        let mut director = self.site.lock();
        self.members.iter().find_map(|member| {
            let link = director.link(*member, source);
            if link == Link::Lost {
                return None;
            }
            let answer = director.site.members[*member].sim.datagram(source, bytes);
            answer.filter(|_| link == Link::Up)
        })
    }

    fn advance_ms(&self, ms: u64) {
        self.site.lock().advance_ms(ms);
    }
}
