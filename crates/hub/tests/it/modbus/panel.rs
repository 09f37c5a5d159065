//! The other end of the line: a Modbus server that is not ours, and one that answers as a test wants.

use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use rmodbus::server::ModbusFrame;
use rmodbus::server::storage::ModbusStorageSmall;
use rmodbus::{ModbusFrameBuf, ModbusProto, guess_request_frame_len};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::sleep;

/// Devices of one server, all with the same memory.
#[derive(Clone)]
pub struct Panel {
    memory: Arc<Mutex<ModbusStorageSmall>>,
    /// It answers.
    pub answers: Arc<AtomicBool>,
    pub connections: Arc<AtomicUsize>,
    pub requests: Arc<AtomicUsize>,
}

impl Panel {
    pub fn new() -> Self {
        Self {
            memory: Arc::default(),
            answers: Arc::new(AtomicBool::new(true)),
            connections: Arc::default(),
            requests: Arc::default(),
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
                let answer = self.answer(&request, proto);
                if self.answers.load(Ordering::SeqCst) && stream.write_all(&answer).await.is_err() {
                    return;
                }
            }
        }
    }

    /// The answer as the library makes it; none of a unit above 9.
    fn answer(&self, request: &[u8], proto: ModbusProto) -> Vec<u8> {
        let at = if matches!(proto, ModbusProto::TcpUdp) { 6 } else { 0 };
        let mut frame: ModbusFrameBuf = [0; 256];
        frame[..request.len()].copy_from_slice(request);
        let mut answer = Vec::new();
        if request[at] <= 9 {
            let mut frame = ModbusFrame::new(request[at], &frame, proto, &mut answer);
            frame.parse().expect("a sound request");
            if frame.processing_required {
                frame.process_read(&*self.memory()).expect("it is read");
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
