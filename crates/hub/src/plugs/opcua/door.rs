//! Who may open a channel, and for what: decided before the library decrypts or decodes anything. It knows a client by
//! the certificate that is sent in clear; the library sees to it that the client has its key.

use std::fs;

use opcua::crypto::{CertificateStore, SecurityPolicy, X509};

use super::{ServerConfig, folder};

/// What is safe: signed and encrypted.
pub const POLICIES: [SecurityPolicy; 3] = [
    SecurityPolicy::Basic256Sha256,
    SecurityPolicy::Aes128Sha256RsaOaep,
    SecurityPolicy::Aes256Sha256RsaPss,
];
/// Longest request for a channel, bytes: each block of it makes the hub decrypt.
const OPEN_MAX: usize = 8192;
/// Longest certificate, bytes, and longest name of its file.
const CERTIFICATE_MAX: usize = 4096;
const NAME_MAX: usize = 200;
/// Types of requests that everyone may make who looks for a server: FindServers and GetEndpoints.
const DISCOVERY: [u16; 2] = [422, 428];

/// Why a connection ends, as the standard numbers it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum No {
    /// The certificate is not in the folder of those that are trusted.
    Untrusted,
    /// This security is not offered, or not for this request.
    Policy,
    /// The certificate cannot be used, even if it is trusted.
    Certificate,
    /// What was sent cannot be read.
    Malformed,
}

impl No {
    /// The status of OPC UA.
    pub const fn status(self) -> u32 {
        match self {
            Self::Untrusted => 0x801A_0000,
            Self::Policy => 0x8055_0000,
            Self::Certificate => 0x8012_0000,
            Self::Malformed => 0x8007_0000,
        }
    }

    /// In words.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Untrusted => "the certificate is not trusted: it is in the folder `rejected`",
            Self::Policy => "this security policy is not offered, or not for this request",
            Self::Certificate => "the certificate cannot be read, or its name be that of a file",
            Self::Malformed => "the message cannot be read",
        }
    }
}

/// A request for a channel, as far as it is not encrypted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opening<'a> {
    /// The security.
    pub policy: SecurityPolicy,
    certificate: &'a [u8],
}

/// Takes a string or an array of bytes; none is empty.
fn bytes<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    let (size, after) = rest.split_first_chunk::<4>()?;
    let size = i32::from_le_bytes(*size);
    let size = if size == -1 { 0 } else { usize::try_from(size).ok()? };
    let (taken, after) = after.split_at_checked(size)?;
    *rest = after;
    Some(taken)
}

impl<'a> Opening<'a> {
    /// Reads a chunk behind its header.
    pub fn read(body: &'a [u8]) -> Result<Self, No> {
        // The number of the channel is in front.
        let mut rest = body.get(4..).filter(|_| body.len() <= OPEN_MAX).ok_or(No::Malformed)?;
        let uri = bytes(&mut rest).ok_or(No::Malformed)?;
        let certificate = bytes(&mut rest).ok_or(No::Malformed)?;
        bytes(&mut rest).ok_or(No::Malformed)?;
        let offered = POLICIES.into_iter().chain([SecurityPolicy::None]);
        let policy = offered.into_iter().find(|it| it.to_uri().as_bytes() == uri);
        Ok(Self { policy: policy.ok_or(No::Policy)?, certificate })
    }

    /// Whether a channel may be opened with this certificate. One that is not known is kept for an administrator, who
    /// may trust it.
    pub fn check(&self, config: &ServerConfig) -> Result<(), No> {
        if self.policy == SecurityPolicy::None {
            return Ok(());
        }
        if self.certificate.is_empty() || self.certificate.len() > CERTIFICATE_MAX {
            return Err(No::Certificate);
        }
        let read = X509::from_der(self.certificate).map_err(|_| No::Certificate)?;
        // As the library names it. Names are chosen by strangers.
        let name = CertificateStore::cert_file_name(&read);
        let special = if cfg!(windows) { "/\\:*?\"<>|" } else { "/\\" };
        let plain = |c: char| !c.is_control() && !special.contains(c);
        if name.len() > NAME_MAX || !name.chars().all(plain) {
            return Err(No::Certificate);
        }
        let is_same = |it: Vec<u8>| it == self.certificate;
        if fs::read(folder::trusted(config).join(&name)).is_ok_and(is_same) {
            return Ok(());
        }
        if let Err(error) = fs::write(folder::rejected(config).join(&name), self.certificate) {
            tracing::warn!(server = config.name, %error, "a certificate is not kept");
        }
        Err(No::Untrusted)
    }
}

/// Whether a message on a channel without security asks for what everyone may know.
pub fn is_discovery(body: &[u8]) -> bool {
    // Channel, token, sequence and request are in front; the type is a number of the standard.
    let Some([1, 0, low, high]) = body.get(16..20) else { return false };
    DISCOVERY.contains(&u16::from_le_bytes([*low, *high]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn opening(policy: &str, certificate: &[u8]) -> Vec<u8> {
        let mut body = vec![0; 4];
        for part in [policy.as_bytes(), certificate] {
            body.extend(u32::try_from(part.len()).unwrap().to_le_bytes());
            body.extend(part);
        }
        body.extend((-1_i32).to_le_bytes());
        body.extend([7; 256]);
        body
    }

    #[test]
    fn only_offered_security_is_passed_on() {
        let read = |policy: &SecurityPolicy| {
            Opening::read(&opening(policy.to_uri(), b"x")).map(|it| it.policy)
        };
        for policy in POLICIES.into_iter().chain([SecurityPolicy::None]) {
            assert_eq!(read(&policy), Ok(policy));
        }
        for policy in [SecurityPolicy::Basic128Rsa15, SecurityPolicy::Basic256] {
            assert_eq!(read(&policy), Err(No::Policy));
        }
    }

    #[test]
    fn what_cannot_be_read_is_refused_without_a_panic() {
        let whole = opening(SecurityPolicy::Basic256Sha256.to_uri(), &[1; 900]);
        for size in 0..whole.len() - 256 {
            assert!(Opening::read(&whole[..size]).is_err(), "{size}");
        }
        for at in 0..whole.len().min(1100) {
            let mut other = whole.clone();
            other[at] ^= 0xFF;
            _ = Opening::read(&other);
        }
        let long = opening(SecurityPolicy::Basic256Sha256.to_uri(), &[1; OPEN_MAX]);
        assert_eq!(Opening::read(&long), Err(No::Malformed));
    }

    #[test]
    fn without_security_nothing_is_asked_but_what_everyone_may_know() {
        let body = |head: [u8; 4]| [&[9; 16][..], &head, &[0; 40]].concat();
        assert!(is_discovery(&body([1, 0, 0xAC, 0x01])), "GetEndpoints");
        assert!(is_discovery(&body([1, 0, 0xA6, 0x01])), "FindServers");
        for head in [[1, 0, 0xCD, 0x01], [2, 0, 0xAC, 0x01], [1, 1, 0xAC, 0x01], [0, 0xAC, 1, 0]] {
            assert!(!is_discovery(&body(head)), "{head:?}");
        }
        assert!(!is_discovery(&[9; 19]));
    }
}
