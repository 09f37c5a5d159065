//! Hashes of passwords: argon2id, one at a time, in memory that is taken once.

use std::sync::Mutex;

use argon2::password_hash::phc::{Output, ParamsString, Salt};
use argon2::{Algorithm, Argon2, Block, Params, PasswordHash, Version};

use crate::sync::lock;

/// One password takes 19 MiB and a processor for a while, so there is room for one at a time. The
/// room is kept after the first: an allocator that gives it back to the system each time spends as
/// long on that as on hashing, and one that does not give it back keeps it once for each thread.
#[derive(Default)]
pub struct Hasher(Mutex<Vec<Block>>);

impl std::fmt::Debug for Hasher {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Hasher")
    }
}

impl Hasher {
    /// argon2id with the crate's parameters (19 MiB, 2 passes: OWASP's). `None`: no random numbers.
    pub fn hash(&self, password: &str) -> Option<String> {
        let (algorithm, version, params) = <(Algorithm, Version, Params)>::default();
        let mut salt = [0; Salt::RECOMMENDED_LENGTH];
        getrandom::fill(&mut salt).ok()?;
        let salt = Salt::new(&salt).ok()?;
        let hash = PasswordHash {
            algorithm: algorithm.ident(),
            version: Some(version.into()),
            params: ParamsString::try_from(&params).ok()?,
            salt: Some(salt),
            hash: Some(self.output(&Argon2::new(algorithm, version, params), password, &salt)?),
        };
        Some(hash.to_string())
    }

    /// Whether this password has this hash.
    pub fn verify(&self, password: &str, hash: &str) -> bool {
        let expected = || {
            let hash = PasswordHash::new(hash).ok()?;
            let algorithm = Algorithm::try_from(hash.algorithm.as_str()).ok()?;
            let version = Version::try_from(hash.version?).ok()?;
            let argon2 = Argon2::new(algorithm, version, Params::try_from(&hash).ok()?);
            // Outputs are compared in constant time.
            Some(self.output(&argon2, password, &hash.salt?)? == hash.hash?)
        };
        expected().unwrap_or(false)
    }

    fn output(&self, argon2: &Argon2<'_>, password: &str, salt: &[u8]) -> Option<Output> {
        let mut output = [0; Output::MAX_LENGTH];
        let len = argon2.params().output_len().unwrap_or(Params::DEFAULT_OUTPUT_LEN);
        let output = output.get_mut(..len)?;
        let mut memory = lock(&self.0);
        memory.resize(argon2.params().block_count(), Block::new());
        let hashed = argon2.hash_password_into_with_memory(
            password.as_bytes(),
            salt,
            output,
            memory.as_mut_slice(),
        );
        hashed.ok()?;
        Output::new(output).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use argon2::{PasswordHasher, PasswordVerifier};

    #[test]
    fn hashes_are_those_of_the_crate() {
        let hasher = Hasher::default();
        let hash = hasher.hash("correct horse").unwrap();
        assert!(Argon2::default().verify_password(b"correct horse", hash.as_str()).is_ok());
        assert!(hasher.verify("correct horse", &hash) && !hasher.verify("correct house", &hash));
        let theirs = Argon2::default().hash_password(b"correct horse").unwrap().to_string();
        assert!(hasher.verify("correct horse", &theirs) && !hasher.verify("", &theirs));
        assert!(!hasher.verify("correct horse", "no hash"));
        assert_ne!(hasher.hash("correct horse").unwrap(), hash, "each has its salt");
    }
}
