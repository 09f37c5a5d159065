//! Coverage of a site: its file, its table, its picture.

pub mod file;
pub mod picture;
pub mod report;
