//! One thing that is measured.

use std::hint::black_box;
use std::time::Instant;

/// A function that is run on a state of its own; what it has done is looked at afterwards.
pub struct Case {
    /// Who, and what: `lafet::drive_decode`.
    pub name: &'static str,
    /// The function as callgrind will see it.
    pub symbol: &'static str,
    /// Bytes that are made or read.
    pub bytes: usize,
    /// Where the function is: two of the same code may have been made one, with one of the names.
    pub address: usize,
    subject: Box<dyn Subject>,
}

trait Subject {
    fn repeat(&mut self, times: u64);
    fn is_right(&self) -> bool;
}

struct Entry<S> {
    state: S,
    run: fn(&mut S),
    right: fn(&S) -> bool,
}

impl<S> Subject for Entry<S> {
    fn repeat(&mut self, times: u64) {
        for _ in 0..times {
            (self.run)(black_box(&mut self.state));
        }
    }

    fn is_right(&self) -> bool {
        (self.right)(&self.state)
    }
}

impl Case {
    /// A case of this name; `right` says whether a run has done what it should.
    pub fn new<S: 'static>(
        [name, symbol]: [&'static str; 2],
        bytes: usize,
        state: S,
        run: fn(&mut S),
        right: fn(&S) -> bool,
    ) -> Self {
        let subject = Box::new(Entry { state, run, right });
        Self { name, symbol, bytes, address: run as usize, subject }
    }

    /// Runs it so often. The error says that it has not done its work.
    pub fn run(&mut self, times: u64) -> Result<(), String> {
        self.subject.repeat(times);
        if self.subject.is_right() { Ok(()) } else { Err(format!("{}: wrong result", self.name)) }
    }

    /// Nanoseconds a run, the least of several tries: whatever disturbs makes it longer.
    pub fn nanoseconds(&mut self) -> f64 {
        const TIMES: u64 = 20_000;
        let tries = (0..40).map(|_| {
            let start = Instant::now();
            self.subject.repeat(TIMES);
            start.elapsed().as_secs_f64() * 1e9 / TIMES as f64
        });
        tries.fold(f64::INFINITY, f64::min)
    }
}

/// A case whose name is that of the function.
#[macro_export]
macro_rules! case {
    ($module:ident :: $function:ident, $bytes:expr, $state:expr, $right:expr) => {
        $crate::case::Case::new(
            [
                concat!(stringify!($module), "::", stringify!($function)),
                concat!(module_path!(), "::", stringify!($function)),
            ],
            $bytes,
            $state,
            $function,
            $right,
        )
    };
}
