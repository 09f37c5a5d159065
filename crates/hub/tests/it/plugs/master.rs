//! A master that is not ours as far as its frames go: `rmodbus` makes the requests and reads the answers.

use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, AtomicU16, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use rmodbus::client::ModbusRequest;
use rmodbus::{ModbusProto, guess_response_frame_len};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::sync::{mpsc, oneshot};
use tokio::time::{interval, timeout};

use crate::support::PATIENCE;

/// How often the heartbeat changes.
const BEAT: Duration = Duration::from_millis(40);
pub const SESSION: u16 = 128;
pub const RESULTS: u16 = 136;
pub const JOG_RESULT: u16 = 160;
pub const KEYS: u16 = 168;
pub const HEARTBEAT: u16 = 256;
pub const JOG: u16 = 257;
pub const COMMAND: u16 = 264;

/// Registers that are read, or that were written.
pub type Words = Result<Vec<u16>, u8>;

enum Ask {
    Read(u16, u16),
    Write(u16, Vec<u16>),
}

/// A master with its connection and heartbeat on a task of its own.
pub struct Master {
    asks: mpsc::Sender<(Ask, oneshot::Sender<Words>)>,
    beats: Arc<AtomicBool>,
    sequence: AtomicU16,
    /// The frames that were sent.
    pub sent: Arc<Mutex<Vec<Vec<u8>>>>,
    task: tokio::task::JoinHandle<()>,
}

impl Drop for Master {
    fn drop(&mut self) {
        self.task.abort();
    }
}

impl Master {
    /// Connects over TCP, without a heartbeat yet.
    pub async fn connect(address: SocketAddr) -> Self {
        let began = tokio::time::Instant::now();
        let stream = loop {
            match TcpStream::connect(address).await {
                Ok(stream) => break stream,
                Err(error) => assert!(began.elapsed() < PATIENCE, "{address}: {error}"),
            }
            tokio::time::sleep(Duration::from_millis(20)).await;
        };
        stream.set_nodelay(true).unwrap();
        Self::on(stream, ModbusProto::TcpUdp, 1)
    }

    /// Speaks over any stream.
    pub fn on(
        stream: impl AsyncRead + AsyncWrite + Unpin + Send + 'static,
        proto: ModbusProto,
        unit: u8,
    ) -> Self {
        let (asks, taken) = mpsc::channel(8);
        let (beats, sent) = (Arc::new(AtomicBool::new(false)), Arc::default());
        let line = Line { stream, proto, unit, number: 0, sent: Arc::clone(&sent) };
        let task = tokio::spawn(line.run(taken, beats.clone()));
        Self { asks, beats, sequence: AtomicU16::new(0), sent, task }
    }

    /// Starts or ends the heartbeat.
    pub fn beat(&self, beats: bool) {
        self.beats.store(beats, Ordering::SeqCst);
    }

    async fn ask(&self, ask: Ask) -> Words {
        let (answer, answered) = oneshot::channel();
        self.asks.send((ask, answer)).await.expect("the connection stays");
        timeout(PATIENCE, answered).await.expect("an answer in time").expect("an answer")
    }

    pub async fn read(&self, first: u16, count: u16) -> Vec<u16> {
        self.try_read(first, count).await.unwrap_or_else(|code| panic!("exception {code}"))
    }

    pub async fn try_read(&self, first: u16, count: u16) -> Words {
        self.ask(Ask::Read(first, count)).await
    }

    pub async fn try_write(&self, first: u16, words: &[u16]) -> Words {
        self.ask(Ask::Write(first, words.to_vec())).await
    }

    pub async fn write(&self, first: u16, words: &[u16]) {
        self.try_write(first, words).await.unwrap_or_else(|code| panic!("exception {code}"));
    }

    /// Beats until the hub has heard it.
    pub async fn live(self) -> Self {
        self.beat(true);
        let began = tokio::time::Instant::now();
        while self.read(SESSION + 3, 1).await != [1] {
            assert!(began.elapsed() < PATIENCE, "no heartbeat");
        }
        self
    }

    /// Sends a command with the session's number and the key of its monitor; returns its sequence number.
    pub async fn send(&self, command: u16, monitor: u16, arguments: [u16; 4]) -> u16 {
        let session = self.read(SESSION, 2).await;
        let key = self.read(KEYS + 4 * monitor.saturating_sub(1), 4).await;
        let sequence = self.sequence.fetch_add(1, Ordering::SeqCst) + 1;
        let mut block = vec![sequence, session[0], session[1], command, monitor];
        block.extend(arguments);
        block.extend(key);
        self.write(COMMAND, &block).await;
        sequence
    }

    /// The state, refusal and result of the monitor of a command, once it has ended.
    pub async fn result(&self, sequence: u16) -> (u16, u16, u16) {
        let began = tokio::time::Instant::now();
        loop {
            let all = self.read(RESULTS, 24).await;
            let own = all.chunks(6).find(|it| it[0] == sequence && it[1] > 1);
            if let Some(own) = own {
                return (own[1], own[2], own[5]);
            }
            assert!(began.elapsed() < PATIENCE, "no result: {all:?}");
        }
    }

    /// Sends a command and waits for its result: state and refusal.
    pub async fn command(&self, command: u16, monitor: u16, arguments: [u16; 4]) -> (u16, u16) {
        let sequence = self.send(command, monitor, arguments).await;
        let (state, refusal, _) = self.result(sequence).await;
        (state, refusal)
    }

    /// Starts or ends motions by hand.
    pub async fn jog(&self, monitor: u16, directions: [i16; 3]) {
        let session = self.read(SESSION, 2).await;
        let sequence = self.sequence.fetch_add(1, Ordering::SeqCst) + 1;
        let [h, v, n] = directions.map(i16::cast_unsigned);
        self.write(JOG, &[sequence, session[0], session[1], monitor, h, v, n]).await;
    }

    pub fn frames(&self) -> Vec<Vec<u8>> {
        self.sent.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

struct Line<S> {
    stream: S,
    proto: ModbusProto,
    unit: u8,
    number: u16,
    sent: Arc<Mutex<Vec<Vec<u8>>>>,
}

impl<S: AsyncRead + AsyncWrite + Unpin> Line<S> {
    async fn run(
        mut self,
        mut asks: mpsc::Receiver<(Ask, oneshot::Sender<Words>)>,
        beats: Arc<AtomicBool>,
    ) {
        let (mut ticks, mut beat) = (interval(BEAT), 0_u16);
        ticks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        loop {
            tokio::select! {
                biased;
                _ = ticks.tick(), if beats.load(Ordering::SeqCst) => {
                    beat = beat.wrapping_add(1);
                    if self.exchange(&Ask::Write(HEARTBEAT, vec![beat])).await.is_none() {
                        return;
                    }
                }
                Some((ask, answer)) = asks.recv() => {
                    match self.exchange(&ask).await {
                        Some(words) => _ = answer.send(words),
                        None => return,
                    }
                }
                () = tokio::time::sleep(BEAT / 4), if !beats.load(Ordering::SeqCst) => {}
            }
        }
    }

    /// Whether an answer is complete. `rmodbus` takes no longer ones over TCP than 255 bytes.
    fn whole(&self, answer: &[u8]) -> bool {
        let len = match (self.proto, answer) {
            (ModbusProto::TcpUdp, [_, _, _, _, high, low, ..]) => {
                Some(6 + usize::from(u16::from_be_bytes([*high, *low])))
            }
            (ModbusProto::TcpUdp, _) => None,
            _ => guess_response_frame_len(answer, self.proto).ok().map(usize::from),
        };
        len.is_some_and(|len| answer.len() >= len)
    }

    /// `None`: the connection has ended.
    async fn exchange(&mut self, ask: &Ask) -> Option<Words> {
        self.number = self.number.wrapping_add(1);
        let mut request = ModbusRequest::new(self.unit, self.proto);
        request.tr_id = self.number;
        let mut frame = Vec::new();
        match ask {
            Ask::Read(first, count) => request.generate_get_holdings(*first, *count, &mut frame),
            Ask::Write(first, words) if words.len() == 1 => {
                request.generate_set_holding(*first, words[0], &mut frame)
            }
            Ask::Write(first, words) => {
                request.generate_set_holdings_bulk(*first, words, &mut frame)
            }
        }
        .unwrap();
        self.sent.lock().unwrap_or_else(PoisonError::into_inner).push(frame.clone());
        self.stream.write_all(&frame).await.ok()?;
        let mut answer = Vec::new();
        let mut buffer = [0; 300];
        loop {
            if self.whole(&answer) {
                break;
            }
            match timeout(PATIENCE, self.stream.read(&mut buffer)).await.expect("an answer in time")
            {
                Ok(len @ 1..) => answer.extend_from_slice(&buffer[..len]),
                _ => return None,
            }
        }
        let at = if matches!(self.proto, ModbusProto::TcpUdp) { 7 } else { 1 };
        if answer[at] >= 0x80 {
            return Some(Err(answer[at + 1]));
        }
        let mut words = Vec::new();
        match ask {
            Ask::Read(..) => request.parse_u16(&answer, &mut words).unwrap(),
            Ask::Write(..) => request.parse_ok(&answer).unwrap(),
        }
        Some(Ok(words))
    }
}
