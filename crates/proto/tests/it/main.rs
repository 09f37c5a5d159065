//! Tests of the protocol, in one program: it is linked once.

mod dictionary;
mod interop;
mod layouts;
mod link;
mod text;
mod vectors;
