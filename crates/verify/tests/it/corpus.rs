//! Replays the committed inputs of the fuzzer: no crash, and no more work than is allowed.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use flate2::read::GzDecoder;
use lafet_verify::fuzz::{INPUT_MAX, Target};
use tar::Archive;

/// Most bytes of all committed inputs together.
const CORPUS_MAX: usize = 1 << 20;

/// An input and its name.
type Input = (String, Vec<u8>);

fn folder(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz").join(path)
}

/// The inputs of `fuzz/corpus/NAME.tar.gz`.
fn corpus(target: &Target) -> Vec<Input> {
    let path = folder("corpus").join(format!("{}.tar.gz", target.name));
    let file = File::open(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let mut archive = Archive::new(GzDecoder::new(file));
    let entries = archive.entries().unwrap().map(|entry| {
        let mut entry = entry.unwrap();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        (entry.path().unwrap().display().to_string(), bytes)
    });
    entries.collect()
}

/// The inputs that have failed before; a target may have none.
fn regressions(target: &Target) -> Vec<Input> {
    let path = folder("regressions").join(target.name);
    let Ok(entries) = std::fs::read_dir(path) else { return Vec::new() };
    let paths = entries.map(|entry| entry.unwrap().path());
    paths.map(|it| (it.display().to_string(), std::fs::read(it).unwrap())).collect()
}

#[test]
fn corpus_and_regressions() {
    let mut size = 0;
    for target in Target::ALL {
        let corpus = corpus(&target);
        assert!(corpus.len() > 10, "{}: the corpus is missing", target.name);
        let (mut most, mut count) = (0, 0);
        for (path, input) in corpus.iter().chain(&regressions(&target)) {
            size += input.len();
            println!("{}: {path}", target.name);
            assert!(input.len() <= INPUT_MAX, "{path}: too long");
            most = most.max(target.run(input));
            count += 1;
        }
        let Target { name, unit, work_max, .. } = target;
        println!("{name}: {count} inputs, at most {most} of {work_max} {unit}");
        assert!(most > 0, "{name}: the corpus does nothing");
    }
    assert!(size <= CORPUS_MAX, "{size} bytes of corpus");
}

/// Every target handles an empty input and arbitrary bytes.
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
