//! Replays what the fuzzer has found worth keeping: no crash, and no more work than is allowed.

use std::path::{Path, PathBuf};

use lafet_fuzz::{INPUT_MAX, Target};

/// All committed inputs together, bytes.
const CORPUS_MAX: u64 = 1 << 20;

fn inputs(folder: &str, target: &Target) -> Vec<PathBuf> {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz").join(folder).join(target.name);
    let Ok(entries) = std::fs::read_dir(&path) else { return Vec::new() };
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

#[test]
fn corpus_and_regressions() {
    let mut size = 0;
    for target in Target::ALL {
        let corpus = inputs("corpus", &target);
        assert!(corpus.len() > 10, "{}: the corpus is missing", target.name);
        let (mut most, mut count) = (0, 0);
        for path in corpus.iter().chain(&inputs("regressions", &target)) {
            let input = std::fs::read(path).unwrap();
            size += input.len() as u64;
            println!("{}", path.display());
            assert!(input.len() <= INPUT_MAX, "{}: too long", path.display());
            most = most.max(target.run(&input));
            count += 1;
        }
        let Target { name, unit, work_max, .. } = target;
        println!("{name}: {count} inputs, at most {most} of {work_max} {unit}");
        assert!(most > 0, "{name}: the corpus does nothing");
    }
    assert!(size <= CORPUS_MAX, "{size} bytes of corpus");
}

/// A new input must be able to find something, also an empty one and one of anything.
#[test]
fn any_bytes() {
    let mut state = 1_u64;
    let mut byte = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 56) as u8
    };
    for target in Target::ALL {
        target.run(&[]);
        for len in 0..200 {
            let input: Vec<u8> = (0..len * 5).map(|_| byte()).collect();
            target.run(&input);
        }
    }
}
