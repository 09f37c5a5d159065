//! What the hub and the process of a camera say to each other over two pipes.
//!
//! The hub sends [`Settings`] once, as JSON behind its length, and keeps the pipe open: its end is the end of the
//! process. The process sends messages: one byte that says which, the length of what follows, and that. Numbers are
//! big-endian. Each side refuses what is longer than a message can be, before there is memory for it.

use std::fmt;
use std::io::{self, Read};

use bytes::{Buf, BufMut, Bytes, BytesMut};
use serde::{Deserialize, Serialize};
use tokio::io::{AsyncRead, AsyncReadExt};

/// Longest settings.
pub const SETTINGS_MAX: usize = 8 * 1024;
/// Longest access unit: a key frame of a camera with 8 million pixels has less than 2 MiB.
pub const UNIT_MAX: usize = 4 * 1024 * 1024;
/// Longest name of a codec, as `avc1.64001f`.
pub const CODEC_MAX: usize = 64;
/// Longest detail of a fault.
pub const DETAIL_MAX: usize = 240;
/// Shortest part of an address that a fault must not have.
const PLACE_LEAST: usize = 4;
/// What an access unit has around it, at most.
const AROUND_MAX: usize = 32 + CODEC_MAX;
/// Longest message.
pub const MESSAGE_MAX: usize = UNIT_MAX + AROUND_MAX;
/// Which, and the length.
const HEAD: usize = 5;

const ALIVE: u8 = 1;
const FRAME: u8 = 2;
const FAULT: u8 = 3;

const KEY: u8 = 1;
const CAPTURED: u8 = 2;

/// Which camera to watch.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Settings {
    /// `rtsp://…`, without a user.
    pub url: String,
    /// Whom the camera knows.
    pub login: Option<Login>,
}

/// A user of a camera.
#[derive(Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Login {
    /// The name.
    pub user: String,
    /// The password.
    pub password: String,
}

impl fmt::Debug for Login {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Login").finish_non_exhaustive()
    }
}

/// What a process says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Said {
    /// It runs.
    Alive,
    /// The camera has sent a picture.
    Frame(Frame),
    /// It gives up; the last message.
    Fault(Fault),
}

/// An access unit: what a decoder makes one picture of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// It can be decoded without any other: how.
    pub key: Option<Picture>,
    /// When it is to be shown, since the first one, µs.
    pub shown_us: i64,
    /// When it was taken by the camera's clock, µs since 1970, if the camera says so.
    pub captured_us: Option<u64>,
    /// Packets that were lost before it.
    pub lost: u16,
    /// NAL units behind start codes (Annex B); before a key frame its parameter sets.
    pub data: Bytes,
}

/// How a stream is decoded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// The codec as browsers name it: `avc1.64001f`.
    pub codec: String,
    /// Width, pixels.
    pub width: u16,
    /// Height, pixels.
    pub height: u16,
}

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Its kind.
    pub kind: FaultKind,
    /// What the library says of it, for the log: never for clients, as the camera may have written it.
    pub detail: String,
}

/// Kinds of faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum FaultKind {
    /// No connection to the camera.
    Unreachable = 1,
    /// The camera refuses user or password.
    Login = 2,
    /// The camera has no such stream.
    Missing = 3,
    /// There is no H.264 or H.265 in it.
    Codec = 4,
    /// What the camera sends breaks the rules of its protocol.
    Broken = 5,
    /// The camera has ended the stream.
    Ended = 6,
    /// The camera sends nothing.
    Silent = 7,
    /// A picture is larger than any may be.
    Large = 8,
}

impl FaultKind {
    const ALL: [Self; 8] = [
        Self::Unreachable,
        Self::Login,
        Self::Missing,
        Self::Codec,
        Self::Broken,
        Self::Ended,
        Self::Silent,
        Self::Large,
    ];
}

impl Fault {
    /// A fault whose detail is short and of printable ASCII.
    pub fn new(kind: FaultKind, detail: &str) -> Self {
        let plain = |c: char| if c.is_ascii_graphic() { c } else { ' ' };
        Self { kind, detail: detail.chars().map(plain).take(DETAIL_MAX).collect() }
    }
}

/// A message that is none.
pub fn broken() -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, "no message of a camera process")
}

impl Settings {
    /// As they are sent.
    ///
    /// # Errors
    ///
    /// They are too long.
    pub fn written(&self) -> io::Result<Vec<u8>> {
        let text = serde_json::to_vec(self)?;
        let len = u32::try_from(text.len()).map_err(|_| broken())?;
        if text.len() > SETTINGS_MAX {
            return Err(broken());
        }
        Ok([&len.to_be_bytes()[..], &text].concat())
    }

    /// Why there is no picture: nothing of a text that has the password in it, or what the address has behind its host,
    /// in which some cameras want one. A camera may send back what it is asked for.
    pub fn fault(&self, kind: FaultKind, text: &str) -> Fault {
        let password = self.login.as_ref().map(|login| login.password.as_str());
        let place = self.url.split_once("://").map_or("", |(_, place)| place);
        let behind = place.find(['/', '?', '#']).map(|at| place[at..].trim_start_matches('/'));
        let query = place.split_once('?').map(|(_, query)| query);
        // A path of a few letters is no password, and in many texts.
        let behind = [behind, query].into_iter().flatten().filter(|it| it.len() >= PLACE_LEAST);
        let mut secret = behind.chain(password.filter(|it| !it.is_empty()));
        Fault::new(kind, if secret.any(|it| text.contains(it)) { "" } else { text })
    }

    /// Reads them.
    ///
    /// # Errors
    ///
    /// The pipe has ended, or there is something else in it.
    pub fn read(from: &mut impl Read) -> io::Result<Self> {
        let mut len = [0; 4];
        from.read_exact(&mut len)?;
        let len = usize::try_from(u32::from_be_bytes(len)).map_err(|_| broken())?;
        if len > SETTINGS_MAX {
            return Err(broken());
        }
        let mut text = vec![0; len];
        from.read_exact(&mut text)?;
        serde_json::from_slice(&text).map_err(|_| broken())
    }
}

impl Said {
    /// As it is sent.
    pub fn written(&self) -> Bytes {
        let mut bytes = BytesMut::with_capacity(HEAD + AROUND_MAX);
        bytes.put_bytes(0, HEAD);
        let kind = match self {
            Self::Alive => ALIVE,
            Self::Frame(frame) => {
                frame.put(&mut bytes);
                FRAME
            }
            Self::Fault(fault) => {
                bytes.put_u8(fault.kind as u8);
                let detail = fault.detail.as_bytes();
                bytes.put_slice(detail.get(..DETAIL_MAX).unwrap_or(detail));
                FAULT
            }
        };
        let len = u32::try_from(bytes.len() - HEAD).unwrap_or(u32::MAX);
        let mut head = &mut bytes[..HEAD];
        head.put_u8(kind);
        head.put_u32(len);
        bytes.freeze()
    }

    /// Reads the next one; `None`: the pipe has ended.
    ///
    /// # Errors
    ///
    /// The pipe fails, ends within a message, or has something else in it.
    pub async fn read(from: &mut (impl AsyncRead + Unpin)) -> io::Result<Option<Self>> {
        let mut head = [0; HEAD];
        match from.read_exact(&mut head).await {
            Ok(_) => {}
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(None),
            Err(error) => return Err(error),
        }
        let [kind, len @ ..] = head;
        let len = usize::try_from(u32::from_be_bytes(len)).map_err(|_| broken())?;
        if len > MESSAGE_MAX {
            return Err(broken());
        }
        let mut bytes = vec![0; len];
        from.read_exact(&mut bytes).await?;
        Self::of(kind, bytes.into()).map(Some)
    }

    /// The message of this kind.
    fn of(kind: u8, mut bytes: Bytes) -> io::Result<Self> {
        match kind {
            ALIVE if bytes.is_empty() => Ok(Self::Alive),
            FRAME => Frame::of(bytes).map(Self::Frame),
            FAULT => {
                let code = bytes.try_get_u8().map_err(|_| broken())?;
                let kind = FaultKind::ALL.into_iter().find(|it| *it as u8 == code);
                let detail = String::from_utf8_lossy(&bytes);
                Ok(Self::Fault(Fault::new(kind.ok_or_else(broken)?, &detail)))
            }
            _ => Err(broken()),
        }
    }
}

impl Frame {
    fn put(&self, bytes: &mut BytesMut) {
        let flag = |is: bool, flag: u8| if is { flag } else { 0 };
        bytes.put_u8(flag(self.key.is_some(), KEY) | flag(self.captured_us.is_some(), CAPTURED));
        bytes.put_u16(self.lost);
        bytes.put_i64(self.shown_us);
        bytes.put_u64(self.captured_us.unwrap_or(0));
        if let Some(picture) = &self.key {
            bytes.put_u16(picture.width);
            bytes.put_u16(picture.height);
            let codec = picture.codec.as_bytes();
            let codec = codec.get(..CODEC_MAX).unwrap_or(codec);
            bytes.put_u8(u8::try_from(codec.len()).unwrap_or(0));
            bytes.put_slice(codec);
        }
        bytes.put_slice(&self.data);
    }

    fn of(mut bytes: Bytes) -> io::Result<Self> {
        let flags = bytes.try_get_u8().map_err(|_| broken())?;
        let lost = bytes.try_get_u16().map_err(|_| broken())?;
        let shown_us = bytes.try_get_i64().map_err(|_| broken())?;
        let captured_us = bytes.try_get_u64().map_err(|_| broken())?;
        let key = match flags & KEY {
            0 => None,
            _ => Some(Picture::of(&mut bytes)?),
        };
        if flags & !(KEY | CAPTURED) != 0 || bytes.is_empty() || bytes.len() > UNIT_MAX {
            return Err(broken());
        }
        let captured_us = (flags & CAPTURED != 0).then_some(captured_us);
        Ok(Self { key, shown_us, captured_us, lost, data: bytes })
    }
}

impl Picture {
    fn of(bytes: &mut Bytes) -> io::Result<Self> {
        let width = bytes.try_get_u16().map_err(|_| broken())?;
        let height = bytes.try_get_u16().map_err(|_| broken())?;
        let len = usize::from(bytes.try_get_u8().map_err(|_| broken())?);
        if len > CODEC_MAX || len > bytes.len() {
            return Err(broken());
        }
        let codec = bytes.split_to(len);
        let fine = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'.';
        let codec = String::from_utf8(codec.to_vec()).map_err(|_| broken())?;
        match !codec.is_empty() && codec.as_bytes().iter().all(fine) {
            true => Ok(Self { codec, width, height }),
            false => Err(broken()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(key: bool, len: usize) -> Said {
        let picture = || Picture { codec: "avc1.64001f".into(), width: 1920, height: 1080 };
        Said::Frame(Frame {
            key: key.then(picture),
            shown_us: -40_000,
            captured_us: key.then_some(1_763_712_000_123_456),
            lost: 3,
            data: Bytes::from(vec![7; len]),
        })
    }

    async fn read(bytes: &[u8]) -> io::Result<Option<Said>> {
        let mut bytes = bytes;
        Said::read(&mut bytes).await
    }

    #[tokio::test]
    async fn what_is_said_is_read_as_it_was() {
        let fault = Said::Fault(Fault::new(FaultKind::Login, "401 Unauthorized"));
        let all = [Said::Alive, frame(true, 1), frame(false, UNIT_MAX), fault];
        let bytes: Vec<u8> = all.iter().flat_map(Said::written).collect();
        let mut rest = &bytes[..];
        for said in all {
            assert_eq!(Said::read(&mut rest).await.unwrap(), Some(said));
        }
        assert_eq!(Said::read(&mut rest).await.unwrap(), None);
    }

    /// A head that promises more than a message has costs no memory and no time.
    #[tokio::test]
    async fn what_is_too_long_is_refused_by_its_head() {
        for len in [u32::MAX, u32::try_from(MESSAGE_MAX).unwrap() + 1] {
            let head = [&[FRAME][..], &len.to_be_bytes()].concat();
            assert_eq!(read(&head).await.unwrap_err().kind(), io::ErrorKind::InvalidData);
        }
        let mut long = frame(false, UNIT_MAX).written().to_vec();
        long.push(7);
        let len = u32::try_from(long.len() - HEAD).unwrap();
        long[1..HEAD].copy_from_slice(&len.to_be_bytes());
        assert_eq!(read(&long).await.unwrap_err().kind(), io::ErrorKind::InvalidData);
    }

    /// Each prefix and each changed byte of a message is another message or none, never a panic.
    #[tokio::test]
    async fn what_is_cut_or_changed_is_another_message_or_none() {
        for said in [frame(true, 20), Said::Fault(Fault::new(FaultKind::Large, "x")), Said::Alive] {
            let whole = said.written().to_vec();
            for end in 1..whole.len() {
                let cut = read(&whole[..end]).await;
                assert!(matches!(cut, Ok(None) | Err(_)), "{end}: {cut:?}");
            }
            for at in 0..whole.len() {
                for bit in 0..8 {
                    let mut other = whole.clone();
                    other[at] ^= 1 << bit;
                    assert_ne!(read(&other).await.ok().flatten(), Some(said.clone()), "{at}");
                }
            }
        }
    }

    #[test]
    fn settings_are_read_and_no_log_has_the_password() {
        let login = Login { user: "viewer".into(), password: "geheim".into() };
        let settings = Settings { url: "rtsp://10.0.0.9/1".into(), login: Some(login) };
        let bytes = settings.written().unwrap();
        assert_eq!(Settings::read(&mut &bytes[..]).unwrap(), settings);
        assert!(!format!("{settings:?}").contains("geheim"));
        let long = Settings { url: "x".repeat(SETTINGS_MAX), login: None };
        assert!(long.written().is_err());
        for bad in [&u32::MAX.to_be_bytes()[..], &[0, 0, 0, 2, b'{', b'}'], &bytes[..9], &[]] {
            assert!(Settings::read(&mut &bad[..]).is_err());
        }
    }

    /// Also where only a part of it would be left of a long text.
    #[test]
    fn no_fault_has_a_password() {
        let login = Some(Login { user: "viewer".into(), password: "geheim".into() });
        let url = "rtsp://10.0.0.9:554/live?key=secret".to_owned();
        let settings = Settings { url, login };
        let long = format!("{}geheim", "x".repeat(DETAIL_MAX - 3));
        for text in
            ["no geheim", &long, "bad url rtsp://10.0.0.9:554/live?key=secret", "key=secret"]
        {
            let fault = settings.fault(FaultKind::Broken, text);
            assert_eq!((fault.kind, fault.detail.as_str()), (FaultKind::Broken, ""), "{text}");
        }
        let plain = "404 Not Found from 10.0.0.9:554";
        assert_eq!(settings.fault(FaultKind::Missing, plain).detail, plain);
        for url in ["rtsp://10.0.0.9", "rtsp://10.0.0.9/", "rtsp://10.0.0.9/1"] {
            let settings = Settings { url: url.into(), login: None };
            assert_eq!(settings.fault(FaultKind::Missing, "RTSP/1.0 401").detail, "RTSP/1.0 401");
        }
    }

    /// What a camera writes reaches the log as short, plain text.
    #[test]
    fn a_detail_is_short_and_plain() {
        let fault = Fault::new(FaultKind::Broken, &"\u{1b}[31m\nж".repeat(100));
        assert_eq!(fault.detail.len(), DETAIL_MAX);
        assert!(fault.detail.chars().all(|c| c == ' ' || c.is_ascii_graphic()));
    }
}
