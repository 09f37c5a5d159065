//! Prints the dissector.
fn main() { print!("{}", lafet_capture::dissector::lua(lafet_capture::dissector::Language::En)); }
