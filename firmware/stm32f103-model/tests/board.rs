//! The board's own program in the model of its chip, against the plant.

use lafet_proto::SubsystemId;
use lafet_proto::request::Body;
use lafet_stm32f103::pins::WIRING;
use lafet_stm32f103_model::chip::Reset;
use lafet_stm32f103_model::inspect::{CHECKS, fire};
use lafet_stm32f103_model::rig::{Rig, Wrong};
use lafet_stm32f103_model::wrong::BOARDS;

/// Every check on the board as it should be.
#[test]
fn the_board_is_as_it_should_be() {
    for (name, check) in CHECKS {
        let found = check(Wrong::NOTHING);
        assert_eq!(found, Ok(()), "{name}");
        println!("{name}: passed");
    }
}

/// What comes behind a moment that is gone back to is what came behind it before, and what was done meanwhile
/// is undone.
#[test]
fn a_rig_goes_back_to_a_moment() {
    let mut rig = Rig::new(Wrong::NOTHING, Vec::new());
    rig.run(300);
    let wrapped = rig.parts(|parts| parts.plant.world.drives[3].position);
    let saved = rig.save();
    let mut go_on = || {
        rig.restore(&saved);
        rig.order(SubsystemId::DEPLOYER, Body::Deploy).expect("it deploys");
        rig.run(2_000);
        let deployer = rig.parts(|parts| parts.plant.world.drives[3].position);
        let answers = rig.parts(|parts| parts.chip.outgoing.clone());
        let found = (rig.now_ns(), answers, rig.device.clone(), deployer);
        // None of this may be left behind.
        rig.parts(|parts| parts.plant.shorted[1] = true);
        rig.run(500);
        rig.cut_power();
        assert_eq!(rig.resets.len(), 1);
        found
    };
    let (first, second) = (go_on(), go_on());
    assert_eq!(first, second);
    assert!((first.3 - wrapped).abs() > 10.0, "nothing has moved");
}

/// An update of the watchdog that never ends keeps the start waiting for some ms, and the watchdog works.
#[test]
fn a_watchdog_that_stays_busy_holds_nothing_up() {
    const IWDG_SR: u32 = 0x4000_300C;
    let busy = Wrong {
        alter: |w, a, v| Some(if !w && a == IWDG_SR { 0b11 } else { v }),
        ..Wrong::NOTHING
    };
    for name in ["start", "watchdog"] {
        let (_, check) = CHECKS.iter().find(|it| it.0 == name).expect("a check");
        assert_eq!(check(busy), Ok(()), "{name}");
    }
}

/// The program starts in the time that a watchdog has which the option bytes have started, with a crystal and
/// without, its oscillator the fastest.
#[test]
fn the_start_is_quick_enough_for_a_watchdog_of_the_option_bytes() {
    for crystal in [true, false] {
        let mut rig = Rig::new(Wrong::NOTHING, Vec::new());
        rig.parts(|parts| {
            (parts.chip.watchdog_at_reset, parts.chip.lsi_hz) = (true, 60_000);
            parts.chip.crystal = crystal;
        });
        rig.cut_power();
        rig.run(3_000);
        assert_eq!(rig.resets, [Reset::Power], "crystal: {crystal}");
        rig.hang(1_400_000_000);
        assert_eq!(rig.parts(|parts| parts.chip.reset), Some(Reset::Watchdog));
    }
}

/// Deployment, water and a sector are asked for over the line; the plant says when the fire is out.
#[test]
fn a_fire_is_put_out() {
    let took_s = fire(Wrong::NOTHING).expect("the fire goes out");
    assert!((3.0..60.0).contains(&took_s), "{took_s} s");
    println!("the fire was out after {took_s:.1} s");
}

/// The wiring table has every pin that the program uses, with its mode, and no other.
#[test]
fn the_wiring_table_is_that_of_the_program() {
    let page = include_str!("../../../docs/board-stm32f103.md");
    let table = page.split("<!-- pins:begin -->").nth(1).expect("a table");
    let table = table.split("<!-- pins:end -->").next().expect("its end");
    let mut listed: Vec<(String, String)> = Vec::new();
    for line in table.lines().filter(|line| line.starts_with("| P")) {
        let cells: Vec<_> = line.split('|').map(str::trim).collect();
        listed.extend(cells[1].split(", ").map(|pin| (pin.to_owned(), cells[2].to_owned())));
    }
    let mut used: Vec<_> = WIRING
        .iter()
        .flat_map(|(mode, pins)| {
            let mode = format!("{mode:?}").to_lowercase();
            pins.iter().map(move |pin| {
                (format!("P{}{}", char::from(b'A' + pin.port), pin.bit), mode.clone())
            })
        })
        .collect();
    listed.sort();
    used.sort();
    assert_eq!(listed, used);
    assert!(page.contains(&format!("| pins | {} |", used.len())), "{} pins", used.len());
    let count = format!("{0} of {0} noticed", BOARDS.len());
    assert!(page.contains(&count), "{count}");
}
