//! The dashboard of `lafet top`.
//!
//! ```text
//! feed: links, subscriptions ─▶ scene: known state ─▶ frame ─▶ list | detail | link
//! ```
//!
//! A scene is plain data, so every picture can be drawn without a link and without a terminal.

mod detail;
pub mod feed;
mod frame;
mod link;
mod list;
pub mod scene;
#[cfg(test)]
mod tests;
mod words;

pub use frame::{plain, render};
pub use words::silence;
