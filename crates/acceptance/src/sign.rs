//! The signature of a record: Ed25519 over the bytes of its JSON, in a file beside it.

use std::fmt::Write;

use ed25519_compact::{KeyPair, PublicKey, Seed, Signature};

/// The key of who tests.
pub struct Key(KeyPair);

/// A signature, with the public half of its key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Signed {
    /// Public key, hexadecimal.
    pub public: String,
    /// Signature, hexadecimal.
    pub signature: String,
}

impl Key {
    /// A key as it is kept: 64 hexadecimal digits.
    pub fn read(text: &str) -> Option<Self> {
        let seed: [u8; 32] = bytes(text.trim())?.try_into().ok()?;
        Some(Self(KeyPair::from_seed(Seed::new(seed))))
    }

    /// Signs a record.
    pub fn sign(&self, record: &[u8]) -> Signed {
        let signature = self.0.sk.sign(record, None);
        Signed { public: digits(self.0.pk.as_ref()), signature: digits(signature.as_ref()) }
    }
}

impl Signed {
    /// As it is kept: a line.
    pub fn line(&self) -> String {
        format!("ed25519 {} {}\n", self.public, self.signature)
    }

    /// Out of its line.
    pub fn read(text: &str) -> Option<Self> {
        let mut words = text.split_whitespace();
        let of = (words.next()?, words.next()?, words.next()?, words.next());
        let ("ed25519", public, signature, None) = of else { return None };
        Some(Self { public: public.to_lowercase(), signature: signature.to_lowercase() })
    }

    /// Whether it is that of a record, made with the private half of its key.
    pub fn is_of(&self, record: &[u8]) -> bool {
        let check = || {
            let public = PublicKey::from_slice(&bytes(&self.public)?).ok()?;
            let signature = Signature::from_slice(&bytes(&self.signature)?).ok()?;
            public.verify(record, &signature).ok()
        };
        check().is_some()
    }
}

/// Hexadecimal digits.
pub(crate) fn digits(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

fn bytes(digits: &str) -> Option<Vec<u8>> {
    if !digits.is_ascii() || !digits.len().is_multiple_of(2) {
        return None;
    }
    let all = (0..digits.len()).step_by(2);
    all.map(|at| u8::from_str_radix(digits.get(at..at + 2)?, 16).ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signature_is_that_of_its_record_and_key_alone() {
        let key = Key::read(&format!(" {}\n", "5a".repeat(32))).unwrap();
        let signed = key.sign(b"record");
        assert_eq!(Signed::read(&signed.line()), Some(signed.clone()));
        assert!(signed.is_of(b"record") && !signed.is_of(b"recorD"));
        let other = Key::read(&"5b".repeat(32)).unwrap().sign(b"record");
        let mixed = Signed { public: other.public, ..signed.clone() };
        assert!(!mixed.is_of(b"record"));
        for wrong in ["", "5a", &"5a".repeat(33), &"5g".repeat(32), &"ф".repeat(32)] {
            assert!(Key::read(wrong).is_none(), "{wrong}");
        }
        for wrong in ["", "ed25519 5a", "rsa 5a 5a", "ed25519 5a 5a 5a"] {
            assert!(Signed::read(wrong).is_none(), "{wrong}");
        }
        assert!(!Signed { public: "5a".into(), signature: "ф".into() }.is_of(b""));
    }
}
