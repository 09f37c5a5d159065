//! The board's own program in the model of its chip, against the plant.

use lafet_stm32f103::pins::WIRING;
use lafet_stm32f103_model::inspect::{CHECKS, fire};
use lafet_stm32f103_model::rig::Wrong;
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
