//! The check under proof: monitors that do something wrong, each of which the swarm must find out.
//! A check that nothing can fail says nothing.

mod acts;
mod answers;
mod claims;

use lafet_verify::swarm::{Wrong, run, run_wrong};

/// Lives in which a wrong must show.
const SEEDS: u64 = 60;

/// What it does, how it is made, and the words by which it is to be found out.
type Seeded = (&'static str, fn() -> Box<dyn Wrong>, &'static [&'static str]);

/// Every wrong is found out, and reported in the words that belong to it.
#[test]
fn every_wrong_is_found_out() {
    let all: Vec<&Seeded> = [acts::ALL, claims::ALL, answers::ALL].into_iter().flatten().collect();
    assert!(all.len() >= 20, "{}", all.len());
    let mut escaped = Vec::new();
    for (name, make, words) in all {
        let found = (0..SEEDS).find_map(|seed| {
            let outcome = run_wrong(seed, make().as_mut());
            outcome.failure.map(|failure| (seed, failure.text))
        });
        match found {
            None => escaped.push(format!("{name}: escapes")),
            Some((seed, text)) if !words.iter().any(|part| text.contains(part)) => {
                escaped.push(format!("{name}: seed {seed} says “{text}”"));
            }
            Some(_) => {}
        }
    }
    assert!(escaped.is_empty(), "{escaped:#?}");
}

/// The witness: one that could do wrong and does not lives as if it were not there.
#[test]
fn who_does_no_wrong_is_not_accused() {
    struct Honest;
    impl Wrong for Honest {}
    for seed in 0..5 {
        let (with, without) = (run_wrong(seed, &mut Honest), run(seed, &mut ()));
        assert_eq!(with.failure, None);
        assert_eq!(with.tally.changes, without.tally.changes);
        assert_eq!(with.tally.frames, without.tally.frames);
    }
}
