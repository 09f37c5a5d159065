//! Every wrong board is noticed, each by the check that `wrong.txt` names: the first in the order of the
//! checks.

use std::sync::Mutex;

use lafet_stm32f103_model::inspect::{CHECKS, Check, find_fault};
use lafet_stm32f103_model::rig::Wrong;
use lafet_stm32f103_model::wrong::BOARDS;

/// A line for each board in their order: its name, a tab, its check.
const LIST: &str = include_str!("wrong.txt");

/// Another check would hide one that has become blind, so no other is asked.
#[test]
fn every_wrong_board_is_noticed_by_its_own_check() {
    let listed: Vec<_> = LIST.lines().map(|line| line.split_once('\t').expect(line)).collect();
    let names: Vec<_> = listed.iter().map(|(name, _)| *name).collect();
    let boards = BOARDS.map(|(name, _)| name);
    assert_eq!(names, boards, "wrong.txt: cargo xtask firmware wrong prints it");
    let found = on_two_threads(|place, wrong| check(listed[place].1)(wrong).err());
    let mut missed = Vec::new();
    for ((name, check), why) in listed.into_iter().zip(found) {
        match why {
            Some(why) => println!("{name}: {check}: {why}"),
            None => missed.push((name, check)),
        }
    }
    assert_eq!(missed, [("", ""); 0]);
    assert!(boards.len() >= 40, "{}", boards.len());
}

#[test]
#[ignore = "minutes: cargo xtask firmware wrong"]
fn the_list_has_the_first_check_of_each_board() {
    let found = on_two_threads(|_, wrong| find_fault(wrong).map_or("none", |(check, _)| check));
    let lines = BOARDS.iter().zip(found).map(|((name, _), check)| format!("{name}\t{check}\n"));
    let list: String = lines.collect();
    assert!(list == LIST, "tests/wrong.txt is not:\n{list}");
}

/// What goes wrong while the flash is busy is noticed by the checks of that, not by chance.
#[test]
fn a_busy_flash_has_checks_of_its_own() {
    let boards = [
        ("a step behind each 32 bytes", "stop while a page is erased"),
        ("flash written in motion", "memory in motion"),
        ("page erased while an answer ends", "line while a page is erased"),
    ];
    for (name, check_name) in boards {
        let (_, wrong) = BOARDS.iter().find(|it| it.0 == name).expect("a board");
        let found = check(check_name)(*wrong);
        assert!(found.is_err(), "{name}");
        println!("{name}: {found:?}");
    }
}

/// A speed loop that is too fast for its motor comes to rest without lag and play, and not with them.
#[test]
fn a_loop_that_is_too_fast_does_not_settle_behind_iron() {
    let name = "full speed a third of what it is";
    let (_, wrong) = BOARDS.iter().find(|it| it.0 == name).expect("a board");
    let found = check("iron")(*wrong).expect_err("it is noticed");
    assert!(found.contains("does not end") || found.contains("settles too late"), "{found}");
    println!("{name}: {found}");
}

fn check(name: &str) -> Check {
    CHECKS.iter().find(|it| it.0 == name).unwrap_or_else(|| panic!("no check {name}")).1
}

/// What `judge` finds of each board, given its place in the list.
fn on_two_threads<T: Send>(judge: impl Fn(usize, Wrong) -> T + Sync) -> Vec<T> {
    let (next, found) = (Mutex::new(BOARDS.iter().enumerate()), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let Some((place, (_, wrong))) = next.lock().unwrap().next() else { break };
                    let judged = judge(place, *wrong);
                    found.lock().unwrap().push((place, judged));
                }
            });
        }
    });
    let mut found = found.into_inner().unwrap();
    found.sort_by_key(|(place, _)| *place);
    found.into_iter().map(|(_, judged)| judged).collect()
}
