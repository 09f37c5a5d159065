//! The ed25519 signature of a header.

use crate::hash::Hash;
use crate::image::{HEADER_LEN, Header, PublicKey, SIGNED_LEN, UNIT};
use crate::refusal::Refusal;
use ed25519_compact as ed25519;

/// Whether the signature of a header is that of a key.
// Apart: the only function beside the library's own in which a check of its indices may end up.
#[inline(never)]
pub(crate) fn check(raw: &[u8; HEADER_LEN], key: &[u8; 32]) -> bool {
    let (signed, signature) = raw.split_at(SIGNED_LEN);
    let key = ed25519::PublicKey::from_slice(key);
    let signature = ed25519::Signature::from_slice(signature);
    match (key, signature) {
        (Ok(key), Ok(signature)) => key.verify(signed, &signature).is_ok(),
        _ => false,
    }
}

/// The private half of a key.
pub struct SigningKey {
    id: u8,
    pair: ed25519::KeyPair,
}

impl SigningKey {
    /// The key of 32 random bytes, under a number of 0 to 15.
    pub fn new(id: u8, seed: [u8; 32]) -> Self {
        Self { id, pair: ed25519::KeyPair::from_seed(ed25519::Seed::new(seed)) }
    }

    /// Its public half.
    pub fn public(&self) -> PublicKey {
        PublicKey { id: self.id, bytes: *self.pair.pk }
    }

    /// Signs an image: `header` with the size and the hash of the payload and the number of the key.
    ///
    /// # Errors
    ///
    /// Those of [`Header::parse`], and [`Refusal::Size`] when the payload is empty, too large for
    /// a header, or not a multiple of [`crate::UNIT`].
    pub fn sign(&self, header: &Header, payload: &[u8]) -> Result<[u8; HEADER_LEN], Refusal> {
        let size = u32::try_from(payload.len()).map_err(|_| Refusal::Size)?;
        if payload.is_empty() || !payload.len().is_multiple_of(UNIT) {
            return Err(Refusal::Size);
        }
        let header = Header { size, key: self.id, hash: Hash::of(payload), ..*header };
        let raw = self.sign_header(&header);
        Header::parse(&raw)?;
        Ok(raw)
    }

    /// Signs a header as it is.
    pub fn sign_header(&self, header: &Header) -> [u8; HEADER_LEN] {
        let signed = header.bytes();
        let signature = self.pair.sk.sign(signed, None);
        let mut raw = [0; HEADER_LEN];
        for (byte, value) in raw.iter_mut().zip(signed.iter().chain(signature.as_ref())) {
            *byte = *value;
        }
        raw
    }
}
