//! A line between `lafet` and a board that can be cut: over TCP, or as a serial port with noise.

use std::fs::File;
use std::io::{self, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

/// How often a line looks whether it has been cut, and at a board that is not there.
const LOOK: Duration = Duration::from_millis(50);
/// One byte of so many is flipped, lost, or has another one in front of it.
const SPOILED: u64 = 4_000;

/// The line.
pub struct Relay {
    /// What `lafet` connects to.
    pub url: String,
    cable: Arc<Cable>,
    /// The other end of a serial port, which does not hang up between two openings.
    _kept: Option<File>,
}

impl Relay {
    /// Over TCP: a cut ends the connection, and none is taken while it lasts.
    pub fn tcp(board: SocketAddr) -> io::Result<Self> {
        let listener = TcpListener::bind("127.0.0.1:0")?;
        let url = format!("tcp://{}", listener.local_addr()?);
        let cable = Arc::new(Cable::to(board));
        let far = cable.clone();
        thread::spawn(move || accept(&listener, &far));
        Ok(Self { url, cable, _kept: None })
    }

    /// A serial port with noise: a cut swallows all that is sent.
    pub fn serial(board: SocketAddr) -> io::Result<Self> {
        let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
        let ours = openpt(flags)?;
        grantpt(&ours)?;
        unlockpt(&ours)?;
        let path = ptsname(&ours, Vec::new())?.to_string_lossy().into_owned();
        let kept = File::options().read(true).write(true).open(&path)?;
        let mut settings = tcgetattr(&kept)?;
        settings.make_raw();
        tcsetattr(&kept, OptionalActions::Now, &settings)?;
        let ours = File::from(ours);
        let cable = Arc::new(Cable::to(board));
        let (there, back) = (cable.clone(), cable.clone());
        let port = ours.try_clone()?;
        thread::spawn(move || there.carry(port));
        thread::spawn(move || back.carry_back(ours));
        let url = format!("serial://{path}?baud=115200");
        Ok(Self { url, cable, _kept: Some(kept) })
    }

    /// Cuts it for so long.
    pub fn cut(&self, time: Duration) {
        *lock(&self.cable.dead_until) = Some(Instant::now() + time);
    }

    /// How many bytes the noise has changed.
    pub fn spoiled(&self) -> u64 {
        lock(&self.cable.noise).spoiled
    }
}

impl Drop for Relay {
    /// The port of the board takes one connection: it is given back.
    fn drop(&mut self) {
        self.cable.ended.store(true, Ordering::SeqCst);
        if let Some(far) = lock(&self.cable.far).take() {
            let _ = far.shutdown(Shutdown::Both);
        }
    }
}

struct Cable {
    board: SocketAddr,
    /// It is not used any more.
    ended: AtomicBool,
    dead_until: Mutex<Option<Instant>>,
    noise: Mutex<Noise>,
    /// The connection to the board, of a serial port.
    far: Mutex<Option<TcpStream>>,
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn accept(listener: &TcpListener, cable: &Arc<Cable>) {
    for near in listener.incoming().map_while(Result::ok) {
        if cable.is_dead() {
            continue;
        }
        let Ok(far) = TcpStream::connect(cable.board) else { continue };
        let (Ok(near_back), Ok(far_back)) = (near.try_clone(), far.try_clone()) else { continue };
        let (there, back) = (cable.clone(), cable.clone());
        thread::spawn(move || there.pump(near, far));
        thread::spawn(move || back.pump(far_back, near_back));
    }
}

impl Cable {
    fn to(board: SocketAddr) -> Self {
        let noise = Noise { state: 0x9E37_79B9_7F4A_7C15, spoiled: 0 };
        Self {
            board,
            ended: AtomicBool::new(false),
            dead_until: Mutex::new(None),
            noise: Mutex::new(noise),
            far: Mutex::new(None),
        }
    }

    fn is_dead(&self) -> bool {
        lock(&self.dead_until).is_some_and(|until| Instant::now() < until)
    }

    /// One direction, to the end of the connection or to a cut.
    fn pump(&self, mut from: TcpStream, mut to: TcpStream) {
        let mut buffer = [0; 1024];
        let _ = from.set_read_timeout(Some(LOOK));
        while !self.is_dead() {
            match from.read(&mut buffer) {
                Ok(0) => break,
                Ok(len) if to.write_all(&buffer[..len]).is_ok() => {}
                Err(error) if is_timeout(&error) => {}
                _ => break,
            }
        }
        // The other direction may have ended first.
        let _ = from.shutdown(Shutdown::Both);
        let _ = to.shutdown(Shutdown::Both);
    }

    /// From the serial port to the board.
    fn carry(&self, mut port: File) {
        let mut buffer = [0; 1024];
        while let Ok(len @ 1..) = port.read(&mut buffer) {
            let bytes = lock(&self.noise).over(&buffer[..len]);
            if let Some(far) = lock(&self.far).as_mut().filter(|_| !self.is_dead()) {
                // A board without power hears nothing.
                let _ = far.write_all(&bytes);
            }
        }
    }

    /// From the board to the serial port, over one connection after another.
    fn carry_back(&self, mut port: File) {
        let mut buffer = [0; 1024];
        while !self.ended.load(Ordering::SeqCst) {
            let Ok(mut board) = TcpStream::connect(self.board) else {
                thread::park_timeout(LOOK);
                continue;
            };
            let mut far = lock(&self.far);
            if self.ended.load(Ordering::SeqCst) {
                return;
            }
            *far = board.try_clone().ok();
            drop(far);
            while let Ok(len @ 1..) = board.read(&mut buffer) {
                let bytes = lock(&self.noise).over(&buffer[..len]);
                if !self.is_dead() && port.write_all(&bytes).is_err() {
                    return;
                }
            }
        }
    }
}

fn is_timeout(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut)
}

/// The same noise in every run.
struct Noise {
    state: u64,
    spoiled: u64,
}

impl Noise {
    fn next(&mut self) -> u64 {
        self.state ^= self.state << 13;
        self.state ^= self.state >> 7;
        self.state ^= self.state << 17;
        self.state
    }

    /// What arrives of these bytes.
    fn over(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut arrived = Vec::new();
        for byte in bytes {
            if !self.next().is_multiple_of(SPOILED) {
                arrived.push(*byte);
                continue;
            }
            self.spoiled += 1;
            let random = self.next();
            match random % 3 {
                0 => arrived.push(byte ^ (1 << ((random >> 8) % 8))),
                1 => {}
                _ => arrived.extend([(random >> 8) as u8, *byte]),
            }
        }
        arrived
    }
}
