//! Every wrong board is noticed.

use std::sync::Mutex;

use lafet_stm32f103_model::inspect::{CHECKS, find_fault};
use lafet_stm32f103_model::wrong::BOARDS;

#[test]
fn every_wrong_board_is_noticed() {
    let (next, missed) = (Mutex::new(BOARDS.iter()), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let Some((name, wrong)) = next.lock().unwrap().next() else { break };
                    match find_fault(*wrong) {
                        Some((check, why)) => println!("{name}: {check}: {why}"),
                        None => missed.lock().unwrap().push(*name),
                    }
                }
            });
        }
    });
    assert_eq!(*missed.lock().unwrap(), [""; 0]);
    assert!(BOARDS.len() >= 40, "{}", BOARDS.len());
}

/// What goes wrong while the flash is busy is noticed by the checks of that, not by chance.
#[test]
fn a_busy_flash_has_checks_of_its_own() {
    let boards = [
        ("a step behind each 32 bytes", "stop while a page is erased"),
        ("flash written in motion", "memory in motion"),
        ("page erased while an answer ends", "line while a page is erased"),
    ];
    for (name, check) in boards {
        let (_, wrong) = BOARDS.iter().find(|it| it.0 == name).expect("a board");
        let (_, look) = CHECKS.iter().find(|it| it.0 == check).expect("a check");
        let found = look(*wrong);
        assert!(found.is_err(), "{name}");
        println!("{name}: {found:?}");
    }
}
