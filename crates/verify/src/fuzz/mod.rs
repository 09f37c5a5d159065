//! The targets of the fuzzer.
//!
//! Each target turns any bytes into something that lafet has to handle, and asserts what must hold
//! for all of them. `fuzz/` links them with libFuzzer (`cargo xtask fuzz`); the committed inputs in
//! `fuzz/corpus` and `fuzz/regressions` are replayed by an ordinary test.
//!
//! A target returns the work that the input took. It is counted, not timed, and bounded by
//! [`Target::work_max`], so no input can be slow.

#[path = "../../../device/tests/store/flash.rs"]
#[allow(dead_code, missing_docs, reason = "the tests of the store use all of it")]
mod flash;

mod device;
mod drawing;
mod feed;
mod link;
mod records;
mod store;
mod text;
mod update;

/// Most bytes of an input that are used.
pub const INPUT_MAX: usize = 2048;

/// A target of the fuzzer.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Its name, and that of its folders in `fuzz/corpus` and `fuzz/regressions`.
    pub name: &'static str,
    /// What `work_max` counts.
    pub unit: &'static str,
    /// Most work for one input, in `unit`.
    pub work_max: u64,
    run: fn(&[u8]) -> u64,
}

impl Target {
    /// All targets.
    pub const ALL: [Self; 7] = [
        Self { name: "link", unit: "bytes decoded", work_max: 200_000, run: link::run },
        Self { name: "records", unit: "bytes encoded", work_max: 100_000, run: records::run },
        Self { name: "text", unit: "bytes written", work_max: 100_000, run: text::run },
        Self { name: "device", unit: "calls of the HAL", work_max: 20_000, run: device::run },
        Self {
            name: "store",
            unit: "reads and writes of the flash",
            work_max: 200_000,
            run: store::run,
        },
        Self {
            name: "update",
            unit: "reads and writes of the flash",
            work_max: 50_000,
            run: update::run,
        },
        Self {
            name: "drawing",
            unit: "points, layers and letters",
            work_max: 10_000,
            run: drawing::run,
        },
    ];

    /// The target of this name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|target| target.name == name)
    }

    /// Runs one input; returns the work it took.
    ///
    /// # Panics
    /// When an assertion fails: that is what the fuzzer looks for.
    pub fn run(&self, input: &[u8]) -> u64 {
        let work = (self.run)(&input[..input.len().min(INPUT_MAX)]);
        assert!(work <= self.work_max, "{work} {}, {} at most", self.unit, self.work_max);
        work
    }
}
