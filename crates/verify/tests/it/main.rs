//! Tests of the checks, in one program: it is linked once.

mod corpus;
mod faults;
mod interlock;
mod model;
mod replay;
mod swarm;
mod wrongs;
mod years;
