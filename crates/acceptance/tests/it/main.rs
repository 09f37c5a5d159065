//! The tester against installations behind a real hub: good ones, and ones with exactly one thing wrong.

mod bench;
mod good;
mod outlet;
mod panel;
mod people;
mod person;
mod records;
mod stopped;
mod wrong;
