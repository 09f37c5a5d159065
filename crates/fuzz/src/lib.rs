//! What the fuzzer does with its bytes.
//!
//! Each target turns any bytes into something that lafet has to cope with, and asserts what must
//! hold whatever they are. `fuzz/` links them with libFuzzer (`cargo xtask fuzz`); the committed
//! inputs in `fuzz/corpus` and `fuzz/regressions` are replayed by an ordinary test.
//!
//! A target returns the work that the input has cost. It is counted, not timed, and bounded by
//! [`Target::work_max`], so no input can be slow.
#![forbid(unsafe_code)]

#[path = "../../device/tests/store/flash.rs"]
#[allow(dead_code, missing_docs, reason = "the tests of the store use all of it")]
mod flash;

mod device;
mod feed;
mod link;
mod records;
mod store;
mod text;

/// Bytes of an input that are looked at.
pub const INPUT_MAX: usize = 2048;

/// One thing to fuzz.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Its name, that of its folders in `fuzz/corpus` and `fuzz/regressions`.
    pub name: &'static str,
    /// What `work_max` counts.
    pub unit: &'static str,
    /// Work that an input may cost at most.
    pub work_max: u64,
    run: fn(&[u8]) -> u64,
}

impl Target {
    /// All targets.
    pub const ALL: [Self; 5] = [
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
    ];

    /// The target of this name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|target| target.name == name)
    }

    /// Runs one input; returns the work it has cost.
    ///
    /// # Panics
    /// When something does not hold: that is what the fuzzer looks for.
    pub fn run(&self, input: &[u8]) -> u64 {
        let work = (self.run)(&input[..input.len().min(INPUT_MAX)]);
        assert!(work <= self.work_max, "{work} {}, {} at most", self.unit, self.work_max);
        work
    }
}
