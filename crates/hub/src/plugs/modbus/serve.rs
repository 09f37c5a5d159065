//! The lines: who connects, what is read and written, when a connection ends. What is decided is in
//! [`super::desk`].

use std::io;
use std::net::{IpAddr, SocketAddr};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use lafet_texts::{Text as _, hub as text};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt, ReadHalf, WriteHalf};
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio::sync::{Notify, mpsc};
use tokio::time::{Instant, sleep, sleep_until, timeout};

use super::access::{self, Level};
use super::desk::{Around, Command, Desk};
use super::frames::{Frame, Next, Splitter};
use super::hand::{Answer, Hand};
use super::layout::{COMMAND, COMMAND_LAST, COMMAND_LEN};
use super::pdu::{self, Ask, Exception};
use super::view::PlugClient;
use super::{Place, Server, VIA};
use crate::access::{Bucket, Kind, Principal, Role, Standing};
use crate::clock::ms;
use crate::field::line::{Line, said};
use crate::field::wire::Framing;
use crate::hub::{Caller, Hub};
use crate::sync::lock;
use crate::text::Both;

/// Rest before a line that failed is opened again.
const RETRY: Duration = Duration::from_secs(2);
/// Rest after a connection that could not be taken; what is left of one that ends comes without longer pauses.
const REST: Duration = Duration::from_millis(100);
/// What was sent on two wires comes back within this time and that of its bytes.
const ECHO: Duration = Duration::from_millis(50);
/// Connections of one address.
const OF_ADDRESS_MAX: usize = 4;
/// A connection that is silent for this time gives way to a new one of its address: its master has lost it.
const GIVES_WAY: Duration = Duration::from_secs(3);
/// A frame over TCP is complete within this time.
const WITHIN: Duration = Duration::from_secs(2);
/// Shortest silence that ends a frame of a serial line: adapters pause within one.
const SILENCE: Duration = Duration::from_millis(20);
/// The same over TCP, where networks pause too.
const SILENCE_TCP: Duration = Duration::from_millis(50);
/// Longest time for sending an answer.
const SENT: Duration = Duration::from_secs(2);
/// Bytes of answers that the system keeps for a connection.
const UNREAD: u32 = 64 * 1024;
/// Bytes of requests that it keeps: what is behind them is still with the master, and lost with it.
const UNHEARD: u32 = 8 * 1024;
/// Connections that wait to be taken.
const BACKLOG: u32 = 64;
/// Answers that wait to be sent.
const ANSWERS_MAX: usize = 128;
/// Requests in one reading, at the most: nothing is read while there is no room for their answers.
const READ_AT_ONCE: usize = 64;
/// Results that wait for the session.
const RESULTS_MAX: usize = 64;
/// Requests of a connection, at once and per second. A master that waits for each answer gets it so much later; of what
/// one sends without waiting only Stop, Close and Lockout are taken.
const REQUESTS: (f64, f64) = (200.0, 500.0);
/// Requests that are read at all, at once and per second; more are read later.
const READ: (f64, f64) = (1000.0, 3000.0);
/// Units of Modbus TCP that mean the server itself.
const ITSELF: [u8; 2] = [0, 255];

/// Serves until the hub ends. A line that fails is opened again.
pub async fn run(hub: Hub, server: Arc<Server>) {
    let mut shutdown = hub.shutdown();
    loop {
        let failed = tokio::select! {
            failed = listen(&hub, &server) => failed,
            () = shutdown.requested() => return,
        };
        let name = &server.config.name;
        if server.counts.set_error(Some(failed.clone())) {
            hub.event(None, &text::PlugNotListening { name, why: &failed }.words());
        }
        tokio::select! {
            () = sleep(RETRY) => {}
            () = shutdown.requested() => return,
        }
    }
}

/// Returns why it does not listen any more.
async fn listen(hub: &Hub, server: &Arc<Server>) -> Both {
    let opened = |url: String| {
        if server.counts.set_error(None) {
            let name = &server.config.name;
            hub.event(None, &text::PlugListening { name, url: &url }.words());
        }
    };
    match &server.config.place {
        Place::Tcp(address, framing) => match bind(*address) {
            Ok(listener) => {
                opened(server.config.url());
                accept(hub, server, &listener, *framing).await
            }
            Err(error) => said(&error),
        },
        Place::Serial(line) => match line.open_port() {
            Ok((port, _claim)) => {
                opened(server.config.url());
                let silence = line.silence().max(SILENCE);
                let (from, heard) = (From { address: None, shown: shown(line) }, Arc::default());
                session(hub, server, port, (Framing::Rtu, silence), from, heard).await;
                text::PlugPortLost.words()
            }
            Err(why) => why,
        },
    }
}

/// Listens. What the system keeps for a master that does not read, or that asks too much, is little.
fn bind(address: SocketAddr) -> io::Result<TcpListener> {
    let socket = if address.is_ipv4() { TcpSocket::new_v4() } else { TcpSocket::new_v6() }?;
    socket.set_reuseaddr(true)?;
    socket.set_send_buffer_size(UNREAD)?;
    socket.set_recv_buffer_size(UNHEARD)?;
    socket.bind(address)?;
    socket.listen(BACKLOG)
}

fn shown(line: &Line) -> String {
    match line {
        Line::Serial { path, .. } => path.display().to_string(),
        Line::Tcp { .. } => line.to_string(),
    }
}

/// Where a master is.
struct From {
    /// Its address; `None`: on a serial line.
    address: Option<IpAddr>,
    /// The same for people.
    shown: String,
}

/// An open connection.
struct Open {
    number: u64,
    from: IpAddr,
    /// Time of its last request, ms of the hub.
    heard: Arc<AtomicU64>,
    gives_way: Arc<Notify>,
}

async fn accept(hub: &Hub, server: &Arc<Server>, listener: &TcpListener, framing: Framing) -> Both {
    let open: Arc<Mutex<Vec<Open>>> = Arc::default();
    for number in 0_u64.. {
        let (stream, from) = match listener.accept().await {
            Ok((stream, address)) => (stream, address.ip().to_canonical()),
            // As when no file descriptor is left: the open ones go on.
            Err(_) => {
                sleep(REST).await;
                continue;
            }
        };
        let heard = Arc::new(AtomicU64::new(ms(hub.now())));
        let Some(gives_way) = place(hub, server, &open, (number, from), &heard) else {
            server.counts.count(|it| &it.rejected);
            tracing::warn!(server = server.config.name, %from, "a Modbus connection is rejected");
            continue;
        };
        let (hub, server, open) = (hub.clone(), server.clone(), open.clone());
        tokio::spawn(async move {
            tokio::select! {
                () = over_tcp(&hub, &server, stream, framing, from, heard) => {}
                () = gives_way.notified() => {}
            }
            lock(&open).retain(|it| it.number != number);
        });
    }
    Both::default()
}

/// Room for a connection; what ends it when it has to give way.
fn place(
    hub: &Hub,
    server: &Server,
    open: &Mutex<Vec<Open>>,
    (number, from): (u64, IpAddr),
    heard: &Arc<AtomicU64>,
) -> Option<Arc<Notify>> {
    let config = &server.config;
    let allowed = if config.allow.is_empty() {
        from.is_loopback()
    } else {
        config.allow.iter().any(|it| it.has(from))
    };
    if !allowed || access::name_of(&config.grants, Some(from)).is_none() {
        return None;
    }
    let mut open = lock(open);
    let own = open.iter().filter(|it| it.from == from).count();
    if own >= OF_ADDRESS_MAX || open.len() >= config.connections_max {
        let of_own = open.iter().filter(|it| it.from == from);
        let oldest = of_own.min_by_key(|it| it.heard.load(Ordering::Relaxed))?;
        let silent = ms(hub.now()).saturating_sub(oldest.heard.load(Ordering::Relaxed));
        if silent < ms(GIVES_WAY) {
            return None;
        }
        let number = oldest.number;
        oldest.gives_way.notify_one();
        open.retain(|it| it.number != number);
    }
    let gives_way = Arc::new(Notify::new());
    let heard = heard.clone();
    open.push(Open { number, from, heard, gives_way: gives_way.clone() });
    Some(gives_way)
}

async fn over_tcp(
    hub: &Hub,
    server: &Arc<Server>,
    stream: TcpStream,
    framing: Framing,
    from: IpAddr,
    heard: Arc<AtomicU64>,
) {
    if stream.set_nodelay(true).is_err() {
        return;
    }
    let silence = if framing == Framing::Tcp { WITHIN } else { SILENCE_TCP };
    let from = From { address: Some(from), shown: from.to_string() };
    session(hub, server, stream, (framing, silence), from, heard).await;
}

async fn session<S>(
    hub: &Hub,
    server: &Arc<Server>,
    stream: S,
    (framing, silence): (Framing, Duration),
    from: From,
    heard: Arc<AtomicU64>,
) where
    S: AsyncRead + AsyncWrite + Send + 'static,
{
    let (mut reader, writer) = tokio::io::split(stream);
    let (outgoing, sent) = mpsc::channel(ANSWERS_MAX);
    let mut session = Session::begin(hub, server, Splitter::new(framing), from, outgoing);
    tokio::select! {
        () = session.run(&mut reader, framing, silence, &heard) => {}
        () = write(writer, sent, hub.start()) => {}
    }
    // Its motions end first.
    session.end();
    _ = timeout(SENT, session.read_rest(&mut reader, framing)).await;
}

/// Sends answers until the master does not take them.
async fn write<W: AsyncWrite>(
    mut writer: WriteHalf<W>,
    mut answers: mpsc::Receiver<(Duration, Vec<u8>)>,
    start: Instant,
) {
    while let Some((at, answer)) = answers.recv().await {
        sleep_until(start + at).await;
        let sent = timeout(SENT, async {
            writer.write_all(&answer).await?;
            writer.flush().await
        });
        if !matches!(sent.await, Ok(Ok(()))) {
            return;
        }
    }
}

/// What is taken of a write.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Taking {
    All,
    /// It is to all units of a line, or its beginning is not certain.
    Broadcast,
    /// It is more than the master may ask.
    Surplus,
}

/// A connection of a master. Dropped, it ends what it has started.
struct Session {
    hub: Hub,
    server: Arc<Server>,
    from: Option<IpAddr>,
    key: crate::hub::SeatKey,
    desks: Vec<(u8, Desk, Hand)>,
    splitter: Splitter,
    outgoing: mpsc::Sender<(Duration, Vec<u8>)>,
    results: mpsc::Receiver<Answer>,
    bucket: Bucket,
    /// When a master that waits for its answers may ask again.
    owed: Duration,
    /// When the present answer is sent.
    answers_at: Duration,
    /// What keeps a master from taking all the time of the machine.
    guard: Bucket,
    /// Until when what was sent last may come back.
    echo_until: Duration,
    /// Where the next frame begins is not known any more.
    broken: bool,
    /// What it has started has ended.
    ended: bool,
}

impl Session {
    fn begin(
        hub: &Hub,
        server: &Arc<Server>,
        splitter: Splitter,
        from: From,
        outgoing: mpsc::Sender<(Duration, Vec<u8>)>,
    ) -> Self {
        let config = &server.config;
        let name = access::name_of(&config.grants, from.address).unwrap_or_default().to_owned();
        let operates = |unit: u8| {
            access::level(&config.grants, from.address, unit, COMMAND, COMMAND_LAST)
                == Level::Operator
        };
        let units = config.units();
        let any = units.iter().any(|(unit, _)| operates(*unit));
        let principal = Principal {
            user: format!("modbus {name}"),
            role: if any { Role::Operator } else { Role::Observer },
            kind: Kind::Modbus,
            key: session_key(&config.name),
            csrf: String::new(),
            expires_ms: 0,
            standing: Standing::Good,
        };
        let key = hub.connect(&principal, &from.shown, None);
        let caller = Caller::plug(principal, from.shown.clone(), key.seat.clone(), VIA);
        let (answers, results) = mpsc::channel(RESULTS_MAX);
        let (number, reports) = (session_number(), server.reports.of(&name));
        let desk = |((unit, ids), version): (&(u8, &[String]), &u32)| {
            let hand = Hand::new((hub, &caller), (*unit, *version), ids, &answers, &reports);
            (*unit, Desk::new(config.terms, number, hub.now(), &mut random), hand)
        };
        let desks = units.iter().zip(&server.versions).map(desk).collect();
        let since_ms = hub.clock().now_ms();
        let (seat, from_address) = (key.seat.clone(), from.address);
        server.counts.came(PlugClient { name, from: from.shown, seat, since_ms });
        Self {
            hub: hub.clone(),
            server: server.clone(),
            from: from_address,
            key,
            desks,
            splitter,
            outgoing,
            results,
            bucket: Bucket::new(hub.now(), REQUESTS.0, REQUESTS.1),
            owed: Duration::ZERO,
            answers_at: Duration::ZERO,
            guard: Bucket::new(hub.now(), READ.0, READ.1),
            echo_until: Duration::ZERO,
            broken: false,
            ended: false,
        }
    }

    async fn run<S: AsyncRead>(
        &mut self,
        reader: &mut ReadHalf<S>,
        framing: Framing,
        silence: Duration,
        heard: &AtomicU64,
    ) {
        let mut buffer = [0; 512];
        let (mut shutdown, start) = (self.hub.shutdown(), self.hub.start());
        let (mut last_bytes, mut paused) = (self.hub.now(), Duration::ZERO);
        let (outgoing, mut full) = (self.outgoing.clone(), None);
        let idle = self.from.map(|_| self.server.config.idle);
        loop {
            let now = self.hub.now();
            let last_frame = Duration::from_millis(heard.load(Ordering::Relaxed));
            let ends = idle.map(|idle| last_frame + idle);
            let silent = self.splitter.is_within().then(|| last_bytes + silence);
            let desks = self.desks.iter().filter_map(|(_, desk, _)| desk.timeout());
            let reads_again = (paused > now).then_some(paused);
            let has_room = self.outgoing.capacity() >= READ_AT_ONCE;
            full = if has_room { None } else { full.or(Some(now + SENT)) };
            let next = desks.chain(ends).chain(silent).chain(reads_again).chain(full).min();
            tokio::select! {
                () = shutdown.requested() => return,
                Some((unit, ticket, result)) = self.results.recv() => {
                    if let Some((_, desk, _)) = self.desks.iter_mut().find(|it| it.0 == unit) {
                        desk.answered(ticket, result);
                    }
                }
                // Messages are not for this client: what concerns the session is in its registers.
                Some(_) = self.key.events.recv() => {}
                // A master that does not take its answers is not heard; see [`SENT`].
                room = outgoing.reserve_many(READ_AT_ONCE), if !has_room => drop(room),
                read = reader.read(&mut buffer), if paused <= now && has_room => {
                    let Ok(len @ 1..) = read else { return };
                    if self.hub.now() > self.echo_until {
                        self.splitter.forget_echo();
                    }
                    self.splitter.feed(buffer.get(..len).unwrap_or_default());
                    last_bytes = self.hub.now();
                    match self.heed_all(framing, heard) {
                        Some(until) => paused = until,
                        None => return,
                    }
                }
                () = until(start, next) => {
                    let now = self.hub.now();
                    self.tick();
                    if ends.into_iter().chain(full).any(|at| now >= at) {
                        return;
                    }
                    if silent.is_some_and(|silent| now >= silent) && !self.fell_silent(framing) {
                        return;
                    }
                }
            }
        }
    }

    /// Heeds what was read. Until when nothing more is; `None`: the connection ends.
    fn heed_all(&mut self, framing: Framing, heard: &AtomicU64) -> Option<Duration> {
        let mut paused = Duration::ZERO;
        loop {
            match self.splitter.next() {
                Next::Frame(frame) => {
                    let now = self.hub.now();
                    heard.store(ms(now), Ordering::Relaxed);
                    // A Stop behind more than the master may ask does not wait for its turn.
                    let surplus = now < self.owed;
                    if !surplus && let Some(wait) = self.bucket.owe(now, 1.0) {
                        self.owed = now + wait;
                    }
                    self.answers_at = if surplus { Duration::ZERO } else { self.owed };
                    if !self.heed(&frame, framing, surplus) {
                        return None;
                    }
                    if let Some(wait) = self.guard.owe(now, 1.0) {
                        paused = now + wait;
                    }
                }
                Next::More => break,
                Next::Broken => {
                    self.count_malformed();
                    self.broken = true;
                    return None;
                }
            }
        }
        self.count_malformed();
        Some(paused)
    }

    /// The connection ends, as when its master takes no answers: of what it has sent before, Stop, Close and Lockout are
    /// taken.
    async fn read_rest<S: AsyncRead>(&mut self, reader: &mut ReadHalf<S>, framing: Framing) {
        let (mut buffer, mut left) = ([0; 512], UNREAD as usize);
        while !self.broken {
            match self.splitter.next() {
                Next::Frame(frame) => _ = self.heed(&frame, framing, true),
                Next::Broken => return,
                Next::More => {
                    let Ok(Ok(len @ 1..)) = timeout(REST, reader.read(&mut buffer)).await else {
                        return;
                    };
                    let Some(less) = left.checked_sub(len) else { return };
                    left = less;
                    self.splitter.feed(buffer.get(..len).unwrap_or_default());
                }
            }
        }
    }

    /// The line is silent; `false`: the connection ends.
    fn fell_silent(&mut self, framing: Framing) -> bool {
        let next = self.splitter.silence();
        self.count_malformed();
        match next {
            // Over TCP a frame was never completed.
            _ if framing == Framing::Tcp => false,
            Next::Frame(frame) => self.heed(&frame, framing, false),
            Next::More | Next::Broken => true,
        }
    }

    fn count_malformed(&mut self) {
        let malformed = self.splitter.malformed();
        self.server.counts.malformed.fetch_add(malformed, Ordering::Relaxed);
    }

    fn tick(&mut self) {
        for (_, desk, hand) in &mut self.desks {
            let acts = desk.tick(self.hub.now(), &mut random);
            hand.carry_out(desk, acts);
        }
    }

    /// Answers a request; `false`: the master does not read its answers.
    fn heed(&mut self, frame: &Frame, framing: Framing, surplus: bool) -> bool {
        let result = self.carry_out(frame, framing, surplus);
        if !matches!(result, Some(Ok(_))) {
            for (_, desk, _) in &mut self.desks {
                desk.refused(&frame.pdu, &mut random);
            }
        }
        let Some(result) = result else { return true };
        let answer = result.unwrap_or_else(|why| {
            if why != Exception::NoPath {
                self.server.counts.count(|it| &it.exceptions);
            }
            pdu::refusal(&frame.pdu, why)
        });
        self.answer(frame, &answer)
    }

    /// Carries out a request; `None`: it is not answered, and nothing but Stop and Close was taken of it.
    fn carry_out(
        &mut self,
        frame: &Frame,
        framing: Framing,
        surplus: bool,
    ) -> Option<Result<Vec<u8>, Exception>> {
        let serial = framing == Framing::Rtu;
        let first = self.server.config.unit;
        if serial && frame.unit == 0 {
            if let Ok(Ask::Write { first, words }) = pdu::parse(&frame.pdu) {
                for at in 0..self.desks.len() {
                    _ = self.write(at, first, &words, Taking::Broadcast);
                }
            }
            return None;
        }
        let unit = if !serial && ITSELF.contains(&frame.unit) { first } else { frame.unit };
        let Some(at) = self.desks.iter().position(|it| it.0 == unit) else {
            // On a serial line it is another device's.
            return (!serial).then_some(Err(Exception::NoPath));
        };
        Some(match pdu::parse(&frame.pdu) {
            Ok(Ask::Read { .. }) if surplus => Err(Exception::Busy),
            Ok(Ask::Read { first, count }) => self.read(at, first, count).map(|words| {
                pdu::read_answer(frame.pdu.first().copied().unwrap_or_default(), &words)
            }),
            // Where its beginning is not certain, nothing but Stop is taken: as from a broadcast.
            Ok(Ask::Write { first, words }) if !frame.certain => {
                _ = self.write(at, first, &words, Taking::Broadcast);
                return None;
            }
            Ok(Ask::Write { first, words }) if surplus => {
                self.write_surplus(at, first, &words).map(|()| pdu::write_answer(&frame.pdu))
            }
            Ok(Ask::Write { first, words }) => {
                let written = self.write(at, first, &words, Taking::All);
                written.map(|()| pdu::write_answer(&frame.pdu))
            }
            Err(why) => Err(why),
        })
    }

    fn answer(&mut self, frame: &Frame, pdu: &[u8]) -> bool {
        self.server.counts.count(|it| &it.requests);
        let answer = self.splitter.answer(frame, pdu);
        let takes = match &self.server.config.place {
            Place::Serial(line) => line.takes(answer.len()),
            Place::Tcp(..) => Duration::ZERO,
        };
        self.echo_until = self.hub.now() + takes + ECHO;
        self.outgoing.try_send((self.answers_at, answer)).is_ok()
    }

    fn level(&self, unit: u8, first: u16, count: usize) -> Level {
        let last = usize::from(first) + count.saturating_sub(1);
        let Ok(last) = u16::try_from(last) else { return Level::None };
        access::level(&self.server.config.grants, self.from, unit, first, last)
    }

    fn read(&mut self, at: usize, first: u16, count: u16) -> Result<Vec<u16>, Exception> {
        let unit = self.desks.get(at).ok_or(Exception::NoPath)?.0;
        if self.level(unit, first, usize::from(count)) == Level::None {
            return Err(Exception::Address);
        }
        let operates = self.level(unit, COMMAND, COMMAND_LEN) == Level::Operator;
        let (_, desk, hand) = self.desks.get_mut(at).ok_or(Exception::NoPath)?;
        let acts = desk.stopped(&hand.stops(), &mut random);
        hand.carry_out(desk, acts);
        desk.read(operates, &hand.sight(), first, count)
    }

    fn write(
        &mut self,
        at: usize,
        first: u16,
        words: &[u16],
        taking: Taking,
    ) -> Result<(), Exception> {
        let unit = self.desks.get(at).ok_or(Exception::NoPath)?.0;
        let level = self.level(unit, first, words.len());
        if level == Level::None {
            return Err(Exception::Address);
        }
        let Some((_, desk, hand)) = self.desks.get_mut(at) else { return Err(Exception::NoPath) };
        let acts = desk.stopped(&hand.stops(), &mut random);
        hand.carry_out(desk, acts);
        let sight = if taking == Taking::Surplus { hand.outline() } else { hand.sight() };
        let mut around = Around {
            now: self.hub.now(),
            operates: level == Level::Operator,
            broadcast: taking == Taking::Broadcast,
            surplus: taking == Taking::Surplus,
            sight: &sight,
            random: &mut random,
        };
        let acts = desk.write(&mut around, first, words)?;
        hand.carry_out(desk, acts);
        Ok(())
    }

    /// Of what is more than the master may ask Stop, Close and Lockout are taken.
    fn write_surplus(&mut self, at: usize, first: u16, words: &[u16]) -> Result<(), Exception> {
        let is_last = usize::from(first) + words.len() == usize::from(COMMAND_LAST) + 1;
        let command = words.last_chunk::<COMMAND_LEN>().filter(|_| is_last).map(|block| block[3]);
        if !command.and_then(Command::by_number).is_some_and(Command::is_urgent) {
            return Err(Exception::Busy);
        }
        self.write(at, first, words, Taking::Surplus)?;
        // What was written with it was not taken.
        if first == COMMAND { Ok(()) } else { Err(Exception::Busy) }
    }
}

impl Session {
    /// Ends what it has started, once.
    fn end(&mut self) {
        if std::mem::replace(&mut self.ended, true) {
            return;
        }
        for (_, desk, hand) in &mut self.desks {
            let acts = desk.end(&mut random);
            hand.carry_out(desk, acts);
        }
        self.hub.disconnect(&self.key);
        self.server.counts.went(&self.key.seat);
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.end();
    }
}

/// Waits for a moment after the start of the hub.
async fn until(start: Instant, next: Option<Duration>) {
    match next {
        Some(at) => sleep_until(start + at).await,
        None => std::future::pending().await,
    }
}

fn random() -> Option<u64> {
    getrandom::u64().ok()
}

/// The number of a session: 0, to which nothing is allowed that is not urgent, if there are no random numbers.
fn session_number() -> u32 {
    getrandom::u32().map_or(0, |number| number.max(1))
}

/// What distinguishes the sessions, also those of a hub that has no random numbers.
fn session_key(name: &str) -> String {
    static SESSIONS: AtomicU64 = AtomicU64::new(0);
    let count = SESSIONS.fetch_add(1, Ordering::Relaxed);
    format!("modbus {name} {count} {}", random().unwrap_or_default())
}
