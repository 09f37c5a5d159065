//! `lafet site test` beside the terminal: the hub over HTTP, the person at the keyboard, files.

mod answers;
mod console;
mod http;
mod records;
mod report;

pub use answers::Answers;
pub use console::{AtTerminal, Console};
pub use http::{Access, Hub};
pub use records::{Keeping, kept, read, signature_of};
pub use report::{dates, dates_json, lines, short};
