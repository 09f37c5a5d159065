//! `lafet site test` beside the terminal: the hub over HTTP, the person at the keyboard, files.

mod answers;
mod console;
mod http;
mod report;

pub use answers::Answers;
pub use console::{AtTerminal, Console};
pub use http::{Access, Hub};
pub use report::{short, told};
