//! Every wrong board is noticed.

use std::sync::Mutex;

use lafet_stm32f103_model::inspect::find_fault;
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
