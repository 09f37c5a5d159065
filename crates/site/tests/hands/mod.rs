//! Hands against each other and against the machine: at a post, at a key, at a pump, at two consoles at once.

use super::hazards::{OPEN, SHUT, of};
use super::*;

/// A button of its post takes a monitor while its order is on its way: the water of that order has its end.
#[test]
fn water_of_an_order_that_was_on_its_way_when_a_person_took_the_monitor_ends() {
    let person = MonitorReport { authority: Authority::Person, ..SHUT };
    let flows = MonitorReport { valve: Valve::Open, ..person };
    let taken = || {
        let mut hall = Hall::with(|config| config.zones[0].jets = Some(1));
        hall.fire();
        assert_eq!(of(&hall.wait(15_000), "Engage"), ["Engage north Some(60000)"]);
        let taken = orders(&hall.monitor("north", person));
        assert!(taken.contains(&"Engage south Some(60000)".to_owned()), "{taken:?}");
        hall.monitor("south", OPEN);
        hall
    };
    for site in [Authority::Site, Authority::Free] {
        let ours = MonitorReport { authority: site, ..OPEN };
        let mut hall = taken();
        hall.wait(200);
        hall.monitor("north", flows);
        hall.wait(30_000);
        hall.monitor("north", ours);
        let all = hall.wait(60_000);
        assert!(all.contains(&(75_000, "Close north".to_owned())), "{all:?}");
        // Given back before it opens.
        let mut hall = taken();
        hall.wait(100);
        hall.monitor("north", MonitorReport { authority: site, ..SHUT });
        hall.wait(100);
        hall.monitor("north", ours);
        let all = hall.wait(60_000);
        assert!(all.contains(&(75_000, "Close north".to_owned())), "{all:?}");
    }
    // What opens after the order is void was opened by the person.
    let mut hall = taken();
    assert!(of(&hall.wait(2000), "Close").is_empty());
    hall.monitor("north", flows);
    hall.wait(5000);
    hall.monitor("north", OPEN);
    let all = hall.wait(100_000);
    assert!(of(&all, "Close north").is_empty(), "{all:?}");
    // One that did not open is free again.
    let mut hall = taken();
    hall.wait(3000);
    hall.monitor("north", SHUT);
    hall.monitor("south", MonitorReport { failure: true, ..OPEN });
    assert_eq!(hall.site.state().zones[0].monitors, ["north", "south"]);
}

/// The order that it had would be accepted when its lockout is lifted.
#[test]
fn a_monitor_that_is_locked_out_before_it_opens_is_closed_at_once() {
    let mut hall = Hall::new();
    hall.fire();
    hall.wait(15_000);
    let locked = hall.monitor("north", MonitorReport { lockout: true, ..SHUT });
    assert_eq!(orders(&locked), ["Close north"]);
    hall.wait(5000);
    hall.monitor("north", SHUT);
    let later = hall.wait(40_000);
    assert!(of(&later, "Engage north").is_empty(), "{later:?}");
}
