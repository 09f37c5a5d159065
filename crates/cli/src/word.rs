//! Random bytes for words and keys, and how bytes are written in texts.

use std::io;

pub use lafet_client::update::{hex, unhex};
use lafet_texts::cli as text;

use crate::failure::Failure;
use crate::lang::current;

/// Random bytes of the system, good for keys.
pub fn random<const N: usize>() -> Result<[u8; N], Failure> {
    let mut bytes = [0; N];
    getrandom::fill(&mut bytes).map_err(|error| {
        let error = io::Error::other(error.to_string());
        Failure::io(text::NoRandomBytes.str(current()), error)
    })?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_differ() {
        assert_ne!(random::<16>().unwrap(), random::<16>().unwrap());
    }
}
