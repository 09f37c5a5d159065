//! lafet
fn main() {}
