//! An opening that was refused, and what it has shown.

use super::*;

/// What makes an opening one that is refused, and why.
type Spoiled = (fn(&mut Bench, &mut [u16; COMMAND_LEN]), Refusal);

/// Assumed: who forwards the requests spoils an opening, and sends it later as it should be.
#[test]
fn an_opening_that_was_refused_never_opens() {
    let cases: [Spoiled; 9] = [
        (|_, block| block[0] = 0x9000, Refusal::Sequence),
        (|_, block| block[2] ^= 1, Refusal::Session),
        (|_, block| block[3] = 77, Refusal::Command),
        (|_, block| block[4] = 9, Refusal::Monitor),
        (|_, block| block[4] = 2, Refusal::Key),
        (|_, block| block[5] = 3, Refusal::Argument),
        (|bench, _| bench.operates = false, Refusal::Role),
        (|bench, _| bench.sight.monitors[0].holder = Holder::Other, Refusal::Held),
        (|_, _| {}, Refusal::Busy),
    ];
    for (spoil, why) in cases {
        let mut bench = Bench::live();
        // A number from before is an old one.
        bench.command(Command::Stop, 1, [0; 4]);
        assert_eq!(bench.refusal(), 0);
        let take = bench.command(Command::Take, 1, [0; 4]);
        bench.desk.answered(ticket(&take), Ok(()));
        let busy = why == Refusal::Busy;
        let waits = busy.then(|| ticket(&bench.command(Command::GoTo, 2, [1, 0, 0, 0])));
        let mut block = bench.block(5, 1, [1, 0, 0, 0]);
        let key: [u16; 4] = *block.last_chunk().unwrap();
        spoil(&mut bench, &mut block);
        assert_eq!(what(&bench.write(COMMAND, &block).unwrap()), None, "{why:?}");
        assert_eq!(bench.read(RESULTS, 3)[2], why.number(), "{why:?}");
        (bench.operates, bench.sight.monitors[0].holder) = (true, Holder::Mine);
        bench.beats(1);
        if let Some(ticket) = waits {
            bench.desk.answered(ticket, Ok(()));
        }
        let mut block = bench.block(5, 1, [1, 0, 0, 0]);
        *block.last_chunk_mut().unwrap() = key;
        assert_eq!(what(&bench.write(COMMAND, &block).unwrap()), None, "{why:?}");
        assert_eq!(bench.refusal(), Refusal::Key.number(), "{why:?}");
        let acts = bench.command(Command::Open, 1, [1, 0, 0, 0]);
        assert_eq!(what(&acts), Some(What::Open(1)), "{why:?}: by the rules it opens");
    }
}

/// A request that is none, or a part of one, or is not taken as it has come.
#[test]
fn a_key_in_a_request_that_was_not_taken_is_used_up() {
    let mut bench = Bench::live();
    for lead in 0..3 {
        let block = bench.block(5, 2, [1, 0, 0, 0]);
        let before = bench.read(KEYS, 8);
        let part = block.get(1..).unwrap_or_default();
        assert_eq!(bench.write(COMMAND, part), Err(Exception::Value));
        let mut bytes = vec![0; lead];
        bytes.extend(part.iter().flat_map(|it| it.to_be_bytes()));
        bench.desk.refused(&bytes[..bytes.len() - 1], &mut || Some(7));
        assert_eq!(bench.read(KEYS, 8), before, "its key is cut off");
        bench.desk.refused(&bytes, &mut || Some(7_000 + lead as u64));
        let after = bench.read(KEYS, 8);
        assert!(after[..4] == before[..4] && after[4..] != before[4..], "{lead}");
    }
    bench.desk.refused(&[0; 64], &mut || panic!("no key is zero"));
}
