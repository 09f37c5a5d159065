//! The other end of the line: a Modbus server that is not ours, and one that answers as a test wants.

use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use rmodbus::server::ModbusFrame;
use rmodbus::server::context::ModbusContext;
use rmodbus::server::storage::ModbusStorageSmall;
use rmodbus::{ModbusFrameBuf, ModbusProto, guess_request_frame_len};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::{Instant, sleep};

/// Devices of one server, all with the same memory.
#[derive(Clone)]
pub struct Panel {
    memory: Arc<Mutex<ModbusStorageSmall>>,
    /// It answers.
    pub answers: Arc<AtomicBool>,
    pub connections: Arc<AtomicUsize>,
    pub requests: Arc<AtomicUsize>,
    /// Requests to devices that are not there.
    pub ignored: Arc<AtomicUsize>,
    /// What came to be written, and when.
    pub writes: Arc<Mutex<Vec<(Instant, Written)>>>,
    /// How it misbehaves at writes.
    pub mischief: Arc<Mutex<Option<Mischief>>>,
}

/// A write: function, address, value.
pub type Written = (u8, u16, u16);

/// How a device misbehaves at writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mischief {
    /// It refuses.
    Refuses,
    /// It knows functions 15 and 16 alone.
    ManyOnly,
    /// It neither does it nor answers.
    Ignores,
    /// It does it and does not answer.
    Mute,
    /// It confirms another value, and does nothing.
    OtherEcho,
    /// It confirms, and does nothing.
    Lies,
    /// It does it and answers too late.
    Late,
    /// It does it and answers twice.
    Twice,
}

impl Panel {
    pub fn new() -> Self {
        Self {
            memory: Arc::default(),
            answers: Arc::new(AtomicBool::new(true)),
            connections: Arc::default(),
            requests: Arc::default(),
            ignored: Arc::default(),
            writes: Arc::default(),
            mischief: Arc::default(),
        }
    }

    pub fn misbehaves(&self, how: Option<Mischief>) {
        *self.mischief.lock().unwrap_or_else(PoisonError::into_inner) = how;
    }

    /// What was written to an address, with its time.
    pub fn written(&self, address: u16) -> Vec<(Instant, u16)> {
        let writes = self.writes.lock().unwrap_or_else(PoisonError::into_inner);
        let of = writes.iter().filter(|(_, (_, it, _))| *it == address);
        of.map(|(at, (_, _, value))| (*at, *value)).collect()
    }

    pub fn coil(&self, address: u16) -> bool {
        self.memory().get_coil(address).unwrap()
    }

    /// Something that is wired to it is on, or not.
    pub fn set(&self, at: u16, on: bool) {
        self.memory().set_discrete(at, on).unwrap();
    }

    /// All of its coils are off.
    pub fn reboots(&self) {
        for address in 0..100 {
            self.memory().set_coil(address, false).unwrap();
        }
    }

    /// One that listens.
    pub async fn listen() -> (Self, SocketAddr) {
        let panel = Self::new();
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let own = panel.clone();
        tokio::spawn(async move {
            loop {
                let (stream, _) = listener.accept().await.unwrap();
                own.connections.fetch_add(1, Ordering::SeqCst);
                tokio::spawn(own.clone().serve(stream, ModbusProto::TcpUdp));
            }
        });
        (panel, address)
    }

    pub fn memory(&self) -> MutexGuard<'_, ModbusStorageSmall> {
        self.memory.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Answers the requests of a stream.
    pub async fn serve(self, mut stream: impl AsyncRead + AsyncWrite + Unpin, proto: ModbusProto) {
        let mut received = Vec::new();
        let mut buffer = [0; 256];
        while let Ok(len @ 1..) = stream.read(&mut buffer).await {
            received.extend_from_slice(&buffer[..len]);
            while let Ok(len) = guess_request_frame_len(&received, proto) {
                if received.len() < usize::from(len) {
                    break;
                }
                let request: Vec<u8> = received.drain(..usize::from(len)).collect();
                self.requests.fetch_add(1, Ordering::SeqCst);
                let at = if matches!(proto, ModbusProto::TcpUdp) { 6 } else { 0 };
                let mischief = self.note(&request[at + 1..]);
                let answer = match mischief {
                    Some(how) => self.misbehaving(how, &request, at, proto).await,
                    None => self.answer(&request, proto),
                };
                if self.answers.load(Ordering::SeqCst) && stream.write_all(&answer).await.is_err() {
                    return;
                }
            }
        }
    }

    /// Notes a write; how it is to be answered, if not rightly.
    fn note(&self, pdu: &[u8]) -> Option<Mischief> {
        let word = |at: usize| u16::from_be_bytes([pdu[at], pdu[at + 1]]);
        let value = match pdu[0] {
            5 => u16::from(word(3) != 0),
            6 => word(3),
            15 => u16::from(pdu[6]),
            16 => word(6),
            _ => return None,
        };
        let written = (Instant::now(), (pdu[0], word(1), value));
        self.writes.lock().unwrap_or_else(PoisonError::into_inner).push(written);
        *self.mischief.lock().unwrap_or_else(PoisonError::into_inner)
    }

    async fn misbehaving(
        &self,
        how: Mischief,
        request: &[u8],
        at: usize,
        proto: ModbusProto,
    ) -> Vec<u8> {
        let refusal = |code: u8| {
            let mut answer = request[..=at].to_vec();
            answer.extend([request[at + 1] | 0x80, code]);
            if at > 0 {
                answer[5] = 3;
            }
            answer
        };
        match how {
            Mischief::Refuses => refusal(4),
            Mischief::ManyOnly if request[at + 1] < 15 => refusal(1),
            Mischief::ManyOnly => self.answer(request, proto),
            Mischief::Ignores => Vec::new(),
            Mischief::Mute => {
                self.answer(request, proto);
                Vec::new()
            }
            Mischief::OtherEcho => {
                let mut answer = request.to_vec();
                answer[at + 4] ^= 0xFF;
                answer
            }
            Mischief::Lies => request.to_vec(),
            Mischief::Late => {
                let answer = self.answer(request, proto);
                sleep(Duration::from_millis(300)).await;
                answer
            }
            Mischief::Twice => self.answer(request, proto).repeat(2),
        }
    }

    /// The answer as the library makes it; none of a unit above 9.
    fn answer(&self, request: &[u8], proto: ModbusProto) -> Vec<u8> {
        let at = if matches!(proto, ModbusProto::TcpUdp) { 6 } else { 0 };
        let mut frame: ModbusFrameBuf = [0; 256];
        frame[..request.len()].copy_from_slice(request);
        let mut answer = Vec::new();
        if request[at] > 9 {
            self.ignored.fetch_add(1, Ordering::SeqCst);
        } else {
            let mut frame = ModbusFrame::new(request[at], &frame, proto, &mut answer);
            frame.parse().expect("a sound request");
            if frame.processing_required {
                match frame.readonly {
                    true => frame.process_read(&*self.memory()).expect("it is read"),
                    false => frame.process_write(&mut *self.memory()).expect("it is written"),
                }
            }
            frame.finalize_response().expect("it fits");
        }
        answer
    }
}

/// How a server misbehaves. All of them would say that there is fire.
#[derive(Clone, Copy, Debug)]
pub enum Bad {
    Silent,
    Closes,
    ClosesInTheAnswer,
    Exception,
    OtherUnit,
    OtherFunction,
    OtherNumber,
    Longer,
    Shorter,
    Huge,
    Text,
    Zeros,
    Drips,
}

impl Bad {
    /// Each, with the kind of failure that it is.
    pub const ALL: [(Self, &str); 13] = [
        (Self::Silent, "timeout"),
        (Self::Closes, "closed"),
        (Self::ClosesInTheAnswer, "closed"),
        (Self::Exception, "exception"),
        (Self::OtherUnit, "wrong"),
        (Self::OtherFunction, "wrong"),
        (Self::OtherNumber, "late"),
        (Self::Longer, "wrong"),
        (Self::Shorter, "wrong"),
        (Self::Huge, "garbage"),
        (Self::Text, "garbage"),
        (Self::Zeros, "garbage"),
        (Self::Drips, "timeout"),
    ];

    pub async fn listen(self) -> SocketAddr {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        tokio::spawn(async move {
            loop {
                let (stream, _) = listener.accept().await.unwrap();
                tokio::spawn(self.serve(stream));
            }
        });
        address
    }

    async fn serve(self, mut stream: TcpStream) {
        let mut request = [0; 12];
        while stream.read_exact(&mut request).await.is_ok() {
            let right = vec![request[0], request[1], 0, 0, 0, 4, request[6], request[7], 1, 0xFF];
            let with = |at: usize, value: u8| {
                let mut answer = right.clone();
                answer[at] = value;
                answer
            };
            let answer = match self {
                Self::Silent => Vec::new(),
                Self::Closes => return,
                Self::ClosesInTheAnswer => {
                    _ = stream.write_all(&right[..8]).await;
                    return;
                }
                Self::Exception => {
                    vec![request[0], request[1], 0, 0, 0, 3, request[6], request[7] | 0x80, 4]
                }
                Self::OtherUnit => with(6, 77),
                Self::OtherFunction => with(7, 1),
                Self::OtherNumber => with(1, request[1].wrapping_add(9)),
                Self::Longer => {
                    let mut answer = with(5, 5);
                    answer[8] = 2;
                    answer.push(0xFF);
                    answer
                }
                Self::Shorter => with(5, 3)[..9].to_vec(),
                Self::Huge => with(4, 0xFF),
                Self::Text => b"HTTP/1.1 400 Bad Request\r\n\r\n".to_vec(),
                Self::Zeros => vec![0; 65_536],
                Self::Drips => {
                    for byte in &right {
                        sleep(Duration::from_millis(100)).await;
                        if stream.write_all(&[*byte]).await.is_err() {
                            return;
                        }
                    }
                    Vec::new()
                }
            };
            if stream.write_all(&answer).await.is_err() {
                return;
            }
        }
    }
}
