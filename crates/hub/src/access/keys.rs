//! Secrets: random ones, and what is kept of them.

use sha2::{Digest, Sha256};

/// Random bytes of a secret: 256 bits cannot be guessed.
const BYTES: usize = 32;

/// A new secret, in hexadecimal.
pub fn secret() -> Result<String, getrandom::Error> {
    let mut bytes = [0; BYTES];
    getrandom::fill(&mut bytes)?;
    Ok(hex(&bytes))
}

/// What is kept of a secret: who reads the database cannot log in with it.
pub fn digest(secret: &str) -> String {
    hex(&Sha256::digest(secret))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
