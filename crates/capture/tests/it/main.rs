//! Tests of recordings, in one program: it is linked once. `light` measures the threads and the
//! memory of its process, and so has one of its own.

mod dissector;
mod recordings;
