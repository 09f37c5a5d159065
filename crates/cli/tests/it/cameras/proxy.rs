//! What is between a camera and the hub: it passes on what the camera sends, as it is or corrupt.

use std::io::{BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex};

/// What is done to what a camera sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spoil {
    /// Nothing.
    Nothing,
    /// Each hundredth packet is lost.
    Lose,
    CutInHead,
    CutInDescription,
    CutInPicture,
    FewBits,
    ManyBits,
    AllZero,
    AllOnes,
    LengthZero,
    LengthHuge,
    OtherChannel,
    NoRtp,
    SequenceAtRandom,
    TimeAtRandom,
    OtherSource,
    UnitsOfNoKind,
    FragmentsWithoutBegin,
    SetsAtRandom,
    ShortPackets,
    Twice,
    BodyWithoutEnd,
    HeadWithoutEnd,
    SetsOfDescription,
    ReportsAtRandom,
}

impl Spoil {
    /// Streams that no camera should send.
    pub const MALFORMED: [Self; 23] = [
        Self::CutInHead,
        Self::CutInDescription,
        Self::CutInPicture,
        Self::FewBits,
        Self::ManyBits,
        Self::AllZero,
        Self::AllOnes,
        Self::LengthZero,
        Self::LengthHuge,
        Self::OtherChannel,
        Self::NoRtp,
        Self::SequenceAtRandom,
        Self::TimeAtRandom,
        Self::OtherSource,
        Self::UnitsOfNoKind,
        Self::FragmentsWithoutBegin,
        Self::SetsAtRandom,
        Self::ShortPackets,
        Self::Twice,
        Self::BodyWithoutEnd,
        Self::HeadWithoutEnd,
        Self::SetsOfDescription,
        Self::ReportsAtRandom,
    ];
}

/// A place that passes on what is sent to another one.
pub struct Proxy {
    pub place: String,
    spoil: Arc<Mutex<Spoil>>,
}

impl Proxy {
    pub fn to(target: &str, spoil: Spoil) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let place = listener.local_addr().unwrap().to_string();
        let spoil = Arc::new(Mutex::new(spoil));
        let (own, target) = (spoil.clone(), target.to_owned());
        std::thread::spawn(move || {
            let mut seed = 1;
            while let Ok((near, _)) = listener.accept() {
                let Ok(far) = TcpStream::connect(&target) else { continue };
                let (mut asks, mut asked) = (near.try_clone().unwrap(), far.try_clone().unwrap());
                std::thread::spawn(move || {
                    _ = std::io::copy(&mut asks, &mut asked);
                    _ = asked.shutdown(std::net::Shutdown::Both);
                });
                seed += 1;
                let mut way = Way { spoil: own.clone(), dice: Dice(seed), packets: 0 };
                std::thread::spawn(move || {
                    _ = way.pass(&mut BufReader::new(&far), &near);
                    for stream in [&near, &far] {
                        _ = stream.shutdown(std::net::Shutdown::Both);
                    }
                });
            }
        });
        Self { place, spoil }
    }

    pub fn now(&self, spoil: Spoil) {
        *self.spoil.lock().unwrap() = spoil;
    }
}

/// The same numbers in each run.
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn one_in(&mut self, many: u64) -> bool {
        self.next() % many == 0
    }

    fn byte(&mut self) -> u8 {
        (self.next() >> 24) as u8
    }
}

/// From a camera to the hub.
struct Way {
    spoil: Arc<Mutex<Spoil>>,
    dice: Dice,
    packets: u64,
}

/// RTP's head.
const HEAD: usize = 12;

impl Way {
    fn pass(&mut self, from: &mut impl Read, mut to: &TcpStream) -> std::io::Result<()> {
        loop {
            let mut first = [0];
            from.read_exact(&mut first)?;
            if first[0] == b'$' {
                let mut head = [0; 3];
                from.read_exact(&mut head)?;
                let mut packet = vec![0; usize::from(u16::from_be_bytes([head[1], head[2]]))];
                from.read_exact(&mut packet)?;
                for bytes in self.packet(head[0], packet)? {
                    to.write_all(&bytes)?;
                }
            } else {
                let message = message(first[0], from)?;
                to.write_all(&self.message(message)?)?;
            }
        }
    }

    /// What becomes of an answer of the camera.
    fn message(&mut self, mut message: Vec<u8>) -> std::io::Result<Vec<u8>> {
        let cut = |message: &[u8], at: usize| message[..at.min(message.len())].to_vec();
        let has_body = message.windows(4).any(|it| it == b"v=0\r");
        match *self.spoil.lock().unwrap() {
            Spoil::CutInHead => message = cut(&message, 20),
            Spoil::CutInDescription if has_body => message = cut(&message, message.len() - 40),
            Spoil::BodyWithoutEnd => {
                let text = String::from_utf8_lossy(&message)
                    .replace("Content-Length: ", "Content-Length: 999");
                message = text.into_bytes();
            }
            Spoil::HeadWithoutEnd => {
                let mut endless = b"RTSP/1.0 200 OK\r\n".to_vec();
                endless.extend(b"X: y\r\n".repeat(2_000_000));
                return Ok(endless);
            }
            Spoil::SetsOfDescription if has_body => {
                let text = String::from_utf8_lossy(&message).into_owned();
                let (before, after) =
                    text.split_once("sprop-parameter-sets=").unwrap_or((&text, ""));
                let other: String = after.chars().map(|c| if c == 'A' { '/' } else { c }).collect();
                return Ok(format!("{before}sprop-parameter-sets={other}").into_bytes());
            }
            _ => return Ok(message),
        }
        Ok(message)
    }

    /// What becomes of a packet.
    fn packet(&mut self, channel: u8, mut packet: Vec<u8>) -> std::io::Result<Vec<Vec<u8>>> {
        self.packets += 1;
        let whole = |channel: u8, packet: &[u8]| {
            let len = u16::try_from(packet.len()).unwrap().to_be_bytes();
            [&[b'$', channel][..], &len, packet].concat()
        };
        let spoil = *self.spoil.lock().unwrap();
        let is_report = channel % 2 == 1;
        let (dice, len) = (&mut self.dice, packet.len());
        // A stream begins well.
        if self.packets < 20 || (is_report && spoil != Spoil::ReportsAtRandom) || len <= HEAD + 2 {
            return Ok(vec![whole(channel, &packet)]);
        }
        match spoil {
            Spoil::Lose if dice.one_in(100) => return Ok(Vec::new()),
            Spoil::CutInPicture if self.packets > 100 => {
                let mut part = whole(channel, &packet);
                part.truncate(len / 2);
                return Ok(vec![part]).and_then(|it| match self.packets > 101 {
                    true => Err(std::io::ErrorKind::BrokenPipe.into()),
                    false => Ok(it),
                });
            }
            Spoil::FewBits if dice.one_in(30) => flip(&mut packet, dice, 1),
            Spoil::ManyBits => flip(&mut packet, dice, 20),
            Spoil::AllZero => packet.fill(0),
            Spoil::AllOnes => packet.fill(0xFF),
            Spoil::LengthZero => return Ok(vec![vec![b'$', channel, 0, 0], packet]),
            Spoil::LengthHuge => return Ok(vec![vec![b'$', channel, 0xFF, 0xFF], packet]),
            Spoil::OtherChannel => return Ok(vec![whole(dice.byte(), &packet)]),
            Spoil::NoRtp => packet[0] = dice.byte(),
            Spoil::SequenceAtRandom => packet[2..4].copy_from_slice(&[dice.byte(), dice.byte()]),
            Spoil::TimeAtRandom => packet[4..8].iter_mut().for_each(|it| *it = dice.byte()),
            Spoil::OtherSource => packet[8..12].iter_mut().for_each(|it| *it = dice.byte()),
            Spoil::UnitsOfNoKind => {
                packet[HEAD] = [0, 24, 25, 29, 30, 31][(dice.next() % 6) as usize]
            }
            Spoil::FragmentsWithoutBegin => {
                (packet[HEAD], packet[HEAD + 1]) = (28, dice.byte() & 0x7F)
            }
            Spoil::SetsAtRandom => {
                packet[HEAD] = 7 + (dice.byte() & 1);
                packet[HEAD + 1..].iter_mut().for_each(|it| *it = dice.byte());
            }
            Spoil::ShortPackets => packet.truncate(HEAD + (dice.next() as usize) % (len - HEAD)),
            Spoil::Twice => return Ok(vec![whole(channel, &packet); 3]),
            Spoil::ReportsAtRandom => {
                let mut report = vec![0x80 | (dice.byte() & 0x1F), 200, 0, dice.byte() & 0x0F];
                report.extend((0..40).map(|_| dice.byte()));
                return Ok(vec![whole(channel | 1, &report), whole(channel, &packet)]);
            }
            _ => {}
        }
        Ok(vec![whole(channel, &packet)])
    }
}

fn flip(packet: &mut [u8], dice: &mut Dice, bits: usize) {
    for _ in 0..bits {
        let at = dice.next() as usize % packet.len();
        packet[at] ^= 1 << (dice.byte() % 8);
    }
}

/// A message of RTSP, with its body.
fn message(first: u8, from: &mut impl Read) -> std::io::Result<Vec<u8>> {
    let mut message = vec![first];
    while !message.ends_with(b"\r\n\r\n") {
        let mut byte = [0];
        from.read_exact(&mut byte)?;
        message.push(byte[0]);
    }
    let text = String::from_utf8_lossy(&message).to_ascii_lowercase();
    let length = text.lines().find_map(|line| line.strip_prefix("content-length:"));
    let length: usize = length.and_then(|it| it.trim().parse().ok()).unwrap_or(0);
    let mut body = vec![0; length];
    from.read_exact(&mut body)?;
    message.extend(body);
    Ok(message)
}
