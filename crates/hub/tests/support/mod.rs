//! A hub and simulated monitors in one process, in real time, over the loopback.
#![allow(dead_code, reason = "each test uses its part")]

use std::collections::BTreeSet;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use futures_util::{SinkExt, StreamExt};
use lafet_device::Source;
use lafet_device::composition::Composition;
use lafet_device::port::Port;
use lafet_hub::access::Role;
use lafet_hub::site::Place;
use lafet_hub::site::keep_out::{KeepOut, KeptFor};
use lafet_hub::{Clock, Config, Hub, MonitorConfig, Server, text};
use lafet_proto::RequestId;
use lafet_proto::link::{BODY_MAX, Decoder};
use lafet_proto::record::Records;
use lafet_proto::update::Order;
use lafet_sim::sim::{Config as SimConfig, Sim};
use serde_json::{Value, json};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use tokio::time::{Instant, interval, timeout};
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;

/// Nothing that is waited for takes so long.
pub const PATIENCE: Duration = Duration::from_secs(60);
pub const PASSWORD: &str = "correct horse";

/// Simulated monitors on one bus.
#[derive(Clone)]
pub struct Bus {
    sims: Arc<Mutex<Vec<Sim>>>,
    gate: Arc<watch::Sender<Gate>>,
}

/// What is kept back on its way to the monitors.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gate {
    request: Option<RequestId>,
    /// It is there and waits.
    waits: bool,
    /// This monitor hears nothing.
    silent: Option<usize>,
    /// How long an answer is under way.
    delay: Duration,
    /// What confirms an update is lost.
    unconfirmed: bool,
}

impl Bus {
    /// Keeps back what has this request, and all behind it, until [`Bus::let_through`].
    pub fn keep_back(&self, request: RequestId) {
        self.gate.send_modify(|it| (it.request, it.waits) = (Some(request), false));
    }

    pub fn let_through(&self) {
        self.gate.send_modify(|it| (it.request, it.waits) = (None, false));
    }

    /// Monitor 1, 2 … does not hear or answer any more.
    pub fn silence(&self, number: usize) {
        self.gate.send_modify(|it| it.silent = Some(number));
    }

    /// What confirms an update is lost on its way, or is not.
    pub fn lose_confirmations(&self, lost: bool) {
        self.gate.send_modify(|it| it.unconfirmed = lost);
    }

    fn loses(&self, bytes: &[u8]) -> bool {
        let mut decoder = Decoder::<BODY_MAX>::new();
        let mut confirms = false;
        for byte in bytes {
            let Some(frame) = decoder.push(*byte) else { continue };
            let mut records = Records::new(frame.payload).map_while(Result::ok);
            confirms |= records.any(|it| {
                it.request == RequestId::UPDATE
                    && matches!(Order::decode(it.data), Ok((Order::Confirm { .. }, _)))
            });
        }
        confirms && self.gate.borrow().unconfirmed
    }

    /// Each exchange takes so long, as on a slow line.
    pub fn slow(&self, delay: Duration) {
        self.gate.send_modify(|it| it.delay = delay);
    }

    /// Something is kept back now.
    pub fn waits(&self) -> bool {
        self.gate.borrow().waits
    }

    async fn pass(&self, bytes: &[u8]) {
        let mut gate = self.gate.subscribe();
        let mut decoder = Decoder::<BODY_MAX>::new();
        let mut has = BTreeSet::new();
        for byte in bytes {
            let Some(frame) = decoder.push(*byte) else { continue };
            let records = Records::new(frame.payload).map_while(Result::ok);
            has.extend(records.map(|it| it.request.0));
        }
        let kept = |it: &Gate| it.request.is_some_and(|id| has.contains(&id.0));
        if kept(&gate.borrow()) {
            self.gate.send_modify(|it| it.waits = true);
        }
        _ = gate.wait_for(|it| !kept(it)).await;
    }

    pub fn lock(&self) -> MutexGuard<'_, Vec<Sim>> {
        self.sims.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Starts monitors 1, 2 … and the port that they share.
    pub async fn start(count: u8, composition: Composition) -> (Self, SocketAddr) {
        let config = |address| SimConfig { composition, address, ..SimConfig::default() };
        Self::of((1..=count).map(config)).await
    }

    /// The same of these monitors, whose addresses are 1, 2 ….
    pub async fn of(configs: impl Iterator<Item = SimConfig>) -> (Self, SocketAddr) {
        let sim = |config| {
            let mut sim = Sim::new(config);
            sim.advance_ms(200);
            sim
        };
        let sims = Arc::new(Mutex::new(configs.map(sim).collect()));
        let bus = Self { sims, gate: Arc::new(watch::Sender::new(Gate::default())) };
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let own = bus.clone();
        tokio::spawn(async move {
            loop {
                let (stream, _) = listener.accept().await.unwrap();
                tokio::spawn(own.clone().serve(stream));
            }
        });
        let own = bus.clone();
        tokio::spawn(async move {
            let mut ticks = interval(Duration::from_millis(10));
            loop {
                ticks.tick().await;
                own.lock().iter_mut().for_each(Sim::tick);
            }
        });
        (bus, address)
    }

    async fn serve(self, mut stream: TcpStream) {
        stream.set_nodelay(true).unwrap();
        let count = self.lock().len();
        let mut ports: Vec<Port> = (0..count).map(|_| Port::new(Source::ExternalConn)).collect();
        let mut buffer = [0; 2048];
        while let Ok(len @ 1..) = stream.read(&mut buffer).await {
            if self.loses(&buffer[..len]) {
                continue;
            }
            self.pass(&buffer[..len]).await;
            let delay = self.gate.borrow().delay;
            tokio::time::sleep(delay).await;
            let answers: Vec<u8> = {
                let mut sims = self.lock();
                let silent = self.gate.borrow().silent;
                let each = sims.iter_mut().zip(&mut ports).zip(1..);
                let each = each.filter(|(_, number)| silent != Some(*number));
                each.flat_map(|((sim, port), _)| sim.receive(port, &buffer[..len])).collect()
            };
            if stream.write_all(&answers).await.is_err() {
                return;
            }
        }
    }

    /// The speed to which a drive is commanded now, 0.1 °/s: 0 vertical, 1 horizontal, 2 nozzle.
    pub fn commanded(&self, monitor: usize, drive: usize) -> i16 {
        self.lock()[monitor].world().outputs().drives[drive].speed_tenths
    }

    pub fn position(&self, monitor: usize, drive: usize) -> f64 {
        self.lock()[monitor].world().drives[drive].position
    }
}

/// A hub with its monitors.
pub struct Site {
    pub bus: Bus,
    pub hub: Hub,
    pub address: SocketAddr,
    _end: tokio::sync::oneshot::Sender<()>,
}

impl Site {
    /// All users are administrators.
    pub async fn open(monitors: u8) -> Self {
        Self::with(monitors, |config| config.login = false).await
    }

    pub async fn with(monitors: u8, change: impl FnOnce(&mut Config)) -> Self {
        Self::at(monitors, Clock::System, change).await
    }

    pub async fn at(monitors: u8, clock: Clock, change: impl FnOnce(&mut Config)) -> Self {
        Self::of((monitors, Composition::REMOTE), clock, change).await
    }

    /// With monitors of a composition.
    pub async fn of(
        (monitors, composition): (u8, Composition),
        clock: Clock,
        change: impl FnOnce(&mut Config),
    ) -> Self {
        Self::on(Bus::start(monitors, composition).await, clock, change).await
    }

    /// At monitors that are there already.
    pub async fn on(
        (bus, place): (Bus, SocketAddr),
        clock: Clock,
        change: impl FnOnce(&mut Config),
    ) -> Self {
        let monitors = u8::try_from(bus.lock().len()).unwrap();
        let monitor = |number: u8| MonitorConfig {
            id: format!("M{number}"),
            name: text::both(format!("M{number}"), format!("М{number}")),
            endpoint: format!("tcp://{place}?addr={number}").parse().unwrap(),
            poll_ms: 50,
        };
        let mut config = Config {
            listen: SocketAddr::from(([127, 0, 0, 1], 0)),
            monitors: (1..=monitors).map(monitor).collect(),
            lost_ms: 500,
            ..Config::default()
        };
        change(&mut config);
        let hub = Hub::new(config, clock, json!({})).unwrap();
        let server = Server::bind(hub.clone()).await.unwrap();
        let address = server.address().unwrap();
        let (end, ending) = tokio::sync::oneshot::channel::<()>();
        tokio::spawn(server.serve(async { _ = ending.await }));
        let site = Self { bus, hub, address, _end: end };
        until("the monitors answer", || {
            site.hub.stations().iter().all(|station| station.health() == "up")
        })
        .await;
        site
    }

    /// Tokens of every role.
    pub fn tokens(&self) -> Vec<(Role, String)> {
        let token = |role: Role| {
            let (_, token) = self.hub.access().add_token(1, role.name(), role).unwrap();
            (role, token)
        };
        Role::ALL.into_iter().map(token).collect()
    }

    pub fn token(&self, role: Role) -> String {
        self.hub.access().add_token(1, role.name(), role).unwrap().1
    }

    pub async fn http(
        &self,
        method: &str,
        path: &str,
        headers: &[(&str, &str)],
        body: &str,
    ) -> Reply {
        let stream = TcpStream::connect(self.address).await.unwrap();
        http_over(stream, &self.address.to_string(), method, path, headers, body).await
    }

    pub async fn post(&self, token: &str, path: &str, body: Value) -> Reply {
        let authorization = format!("Bearer {token}");
        let headers = [("Authorization", authorization.as_str())];
        self.http("POST", path, if token.is_empty() { &[] } else { &headers }, &body.to_string())
            .await
    }

    pub async fn get(&self, token: &str, path: &str) -> Reply {
        let authorization = format!("Bearer {token}");
        let headers = [("Authorization", authorization.as_str())];
        self.http("GET", path, if token.is_empty() { &[] } else { &headers }, "").await
    }

    pub async fn ws(&self, token: &str) -> Socket {
        self.ws_at(token, "/api/ws").await
    }

    pub async fn ws_at(&self, token: &str, path: &str) -> Socket {
        let authorization = format!("Bearer {token}");
        let headers = [("Authorization", authorization.as_str())];
        self.ws_with(path, if token.is_empty() { &[] } else { &headers }).await
    }

    pub async fn ws_as(&self, headers: &[(&'static str, &str)]) -> Socket {
        self.ws_with("/api/ws", headers).await
    }

    async fn ws_with(&self, path: &str, headers: &[(&'static str, &str)]) -> Socket {
        let mut request = format!("ws://{}{path}", self.address).into_client_request().unwrap();
        for (name, value) in headers {
            request.headers_mut().insert(*name, value.parse().unwrap());
        }
        let stream = TcpStream::connect(self.address).await.unwrap();
        let (socket, _) = tokio_tungstenite::client_async(request, stream).await.unwrap();
        let mut socket = Socket { socket, hello: Value::Null, known: serde_json::Map::new() };
        socket.hello = socket.next_of("hello").await;
        socket
    }
}

/// An answer of the API.
#[derive(Debug)]
pub struct Reply {
    pub status: u16,
    pub headers: String,
    pub body: Value,
    pub text: String,
}

impl Reply {
    pub fn code(&self) -> &str {
        self.body["error"]["code"].as_str().unwrap_or_default()
    }

    pub fn header(&self, name: &str) -> Option<&str> {
        self.headers.lines().find_map(|line| {
            let (key, value) = line.split_once(':')?;
            key.eq_ignore_ascii_case(name).then(|| value.trim())
        })
    }
}

pub async fn http_over(
    mut stream: impl AsyncRead + AsyncWrite + Unpin,
    host: &str,
    method: &str,
    path: &str,
    headers: &[(&str, &str)],
    body: &str,
) -> Reply {
    let mut head = format!("{method} {path} HTTP/1.1\r\nConnection: close\r\n");
    if !headers.iter().any(|(name, _)| *name == "Host") {
        head += &format!("Host: {host}\r\n");
    }
    for (name, value) in headers {
        head += &format!("{name}: {value}\r\n");
    }
    head += &format!("Content-Length: {}\r\n\r\n{body}", body.len());
    stream.write_all(head.as_bytes()).await.unwrap();
    let mut bytes = Vec::new();
    _ = timeout(PATIENCE, stream.read_to_end(&mut bytes)).await.expect("an answer in time");
    let text = String::from_utf8_lossy(&bytes).into_owned();
    let (headers, body) = text.split_once("\r\n\r\n").unwrap_or((&text, ""));
    let status = headers.split(' ').nth(1).and_then(|it| it.parse().ok()).unwrap_or(0);
    Reply {
        status,
        headers: headers.to_owned(),
        body: serde_json::from_str(body).unwrap_or_default(),
        text: body.to_owned(),
    }
}

/// A WebSocket.
pub struct Socket {
    pub socket: WebSocketStream<TcpStream>,
    pub hello: Value,
    /// The topics, by every message that was read, whatever it was waited for.
    pub known: serde_json::Map<String, Value>,
}

impl Socket {
    pub fn seat(&self) -> &str {
        self.hello["seat"].as_str().unwrap()
    }

    pub async fn send(&mut self, message: Value) {
        self.socket.send(Message::Text(message.to_string().into())).await.unwrap();
    }

    /// The next message; `None` when the connection is closed.
    pub async fn next(&mut self) -> Option<Value> {
        loop {
            match timeout(PATIENCE, self.socket.next()).await.expect("a message in time")? {
                Ok(Message::Text(text)) => {
                    let message = serde_json::from_str(&text).unwrap();
                    self.apply(&message);
                    return Some(message);
                }
                Ok(Message::Close(frame)) => {
                    return Some(
                        json!({ "type": "closed", "code": frame.map(|it| u16::from(it.code)) }),
                    );
                }
                Ok(_) => {}
                Err(_) => return None,
            }
        }
    }

    fn apply(&mut self, message: &Value) {
        for (topic, value) in message["set"].as_object().into_iter().flatten() {
            self.known.insert(topic.clone(), value.clone());
        }
        for topic in message["gone"].as_array().into_iter().flatten() {
            self.known.remove(topic.as_str().unwrap());
        }
    }

    /// Reads until what is known is as wanted.
    pub async fn until(
        &mut self,
        what: &str,
        wanted: impl Fn(&serde_json::Map<String, Value>) -> bool,
    ) {
        let began = Instant::now();
        while !wanted(&self.known) {
            assert!(began.elapsed() < PATIENCE, "{what}: {:?}", self.known);
            self.next().await.expect("the connection stays");
        }
    }

    pub async fn next_of(&mut self, kind: &str) -> Value {
        self.next_where(|message| message["type"] == kind).await
    }

    pub async fn next_where(&mut self, wanted: impl Fn(&Value) -> bool) -> Value {
        let began = Instant::now();
        loop {
            assert!(began.elapsed() < PATIENCE, "what was waited for does not come");
            let message = self.next().await.expect("the connection stays");
            if wanted(&message) {
                return message;
            }
        }
    }

    /// Asks, and waits for the answer.
    pub async fn ask(&mut self, mut message: Value) -> Value {
        let mut id = message.to_string();
        // Longer ones are not taken as ids.
        id.truncate(100);
        message["id"] = json!(id);
        self.send(message).await;
        self.next_where(|answer| answer["type"] == "answer" && answer["id"] == json!(id)).await
    }

    pub async fn authority(&mut self, monitor: &str, action: &str) -> Value {
        let message = json!({ "type": "authority", "monitor": monitor, "action": action, "reason": "for the test" });
        self.ask(message).await
    }

    pub async fn beat(&mut self, drive: &str, toward: &str) {
        let message = json!({ "type": "jog", "monitor": "M1", "drive": drive, "toward": toward });
        self.send(message).await;
    }
}

/// A map on which M1 looks north and has a stand for people in the north-east: azimuths −30° … −60° are kept clear.
pub fn stand_for_people() -> lafet_hub::site::Site {
    let place = Place { at: [0.0, 0.0], heading: 0.0, height: 2.0 };
    let keep_out = KeepOut {
        name: "stand".into(),
        of: KeptFor::People,
        monitor: None,
        bearings: [30.0, 60.0],
        elevations: [-90.0, 90.0],
    };
    lafet_hub::site::Site {
        monitors: [("M1".to_owned(), place)].into(),
        keep_outs: vec![keep_out],
        ..Default::default()
    }
}

/// Waits until something is so.
pub async fn until(what: &str, condition: impl Fn() -> bool) {
    let began = Instant::now();
    let mut ticks = interval(Duration::from_millis(5));
    while !condition() {
        ticks.tick().await;
        assert!(began.elapsed() < PATIENCE, "{what}");
    }
}

/// Whether something stays so for a time.
pub async fn stays(time: Duration, condition: impl Fn() -> bool) -> bool {
    let began = Instant::now();
    let mut ticks = interval(Duration::from_millis(5));
    while began.elapsed() < time {
        if !condition() {
            return false;
        }
        ticks.tick().await;
    }
    true
}

/// Beats every 60 ms until something is so, however long that takes a machine that is busy.
pub async fn hold_until(socket: &mut Socket, drive: &str, toward: &str, wanted: impl Fn() -> bool) {
    let began = Instant::now();
    let mut ticks = interval(Duration::from_millis(60));
    while !wanted() {
        ticks.tick().await;
        assert!(began.elapsed() < PATIENCE, "{drive} does not get there");
        socket.beat(drive, toward).await;
    }
}

/// Beats every 60 ms for a time.
pub async fn hold(socket: &mut Socket, drive: &str, toward: &str, time: Duration) {
    let began = Instant::now();
    let mut ticks = interval(Duration::from_millis(60));
    while began.elapsed() < time {
        ticks.tick().await;
        socket.beat(drive, toward).await;
    }
}
