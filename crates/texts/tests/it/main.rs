//! The texts as a program has them, and what their compiler refuses.

#[path = "../../build/catalogue.rs"]
mod catalogue;
#[path = "../../build/rust.rs"]
mod rust;

mod compiler;
mod dictionary;
mod texts;
