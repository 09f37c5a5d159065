//! Coverage of a site: its file, its table, its picture.

pub mod file;
mod hub;
pub mod picture;
pub mod report;
