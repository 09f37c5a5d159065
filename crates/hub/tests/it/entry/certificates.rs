//! A WebSocket that outlasts the certificate of its client.

use futures_util::{SinkExt, StreamExt};
use serde_json::Value;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;

use super::*;

const START_MS: u64 = 1_000_000_000_000;
const DAY_MS: u64 = 24 * 3_600_000;

/// A WebSocket over TLS.
struct Secure(WebSocketStream<TlsStream<TcpStream>>);

impl Secure {
    async fn open(stream: TlsStream<TcpStream>) -> Self {
        let request = "wss://localhost/api/ws".into_client_request().unwrap();
        Self(tokio_tungstenite::client_async(request, stream).await.unwrap().0)
    }

    async fn send(&mut self, message: Value) {
        self.0.send(Message::text(message.to_string())).await.unwrap();
    }

    /// The next text that is as wanted, or the code with which the connection is closed before.
    async fn next_where(&mut self, wanted: impl Fn(&Value) -> bool) -> Result<Value, u16> {
        let began = Instant::now();
        loop {
            assert!(began.elapsed() < PATIENCE, "what was waited for does not come");
            match timeout(PATIENCE, self.0.next()).await.unwrap().unwrap().unwrap() {
                Message::Text(text) => {
                    let message = serde_json::from_str(&text).unwrap();
                    if wanted(&message) {
                        return Ok(message);
                    }
                }
                Message::Close(frame) => return Err(frame.unwrap().code.into()),
                _ => {}
            }
        }
    }

    async fn ask(&mut self, mut message: Value) -> Value {
        let id = json!(message.to_string());
        message["id"] = id.clone();
        self.send(message).await;
        self.next_where(|it| it["type"] == "answer" && it["id"] == id).await.unwrap()
    }
}

/// A client that is known by its certificate, on a WebSocket that is open.
struct Certified {
    folder: std::path::PathBuf,
    time: std::sync::Arc<ManualTime>,
    site: Site,
    socket: Secure,
    /// When the certificate ends.
    ends_ms: u64,
}

impl Certified {
    async fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("lafet-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let authority = Authority::new();
        let tls = authority.write(&folder);
        let time = ManualTime::at(START_MS);
        let site = Site::at(1, Clock::Manual(time.clone()), |config| config.tls = Some(tls)).await;
        let connect = async || authority.connect(site.address, Some("scada")).await.unwrap();
        let about = http_over(connect().await, "localhost", "GET", "/api/session", &[], "").await;
        let ends_ms = about.body["expires_ms"].as_u64().unwrap();
        let mut socket = Secure::open(connect().await).await;
        assert!(socket.ask(take()).await["authority"].is_object());
        Self { folder, time, site, socket, ends_ms }
    }
}

fn take() -> Value {
    json!({ "type": "authority", "monitor": "M1", "action": "take" })
}

#[tokio::test]
async fn a_websocket_outlasts_the_certificate_of_its_client_to_stop() {
    let Certified { folder, time, site, mut socket, ends_ms } = Certified::new("outlasts").await;
    time.pass(ends_ms - START_MS + 1000);
    // Connections look at once whether they may go on.
    site.hub.access_changed();
    let up = json!({ "type": "request", "monitor": "M1", "request": "Move Vertical 900" });
    for refused in [up, take(), json!({ "type": "subscribe" })] {
        let error = socket.ask(refused).await["error"].clone();
        let expected = (&json!("login_needed"), &json!("expired"));
        assert_eq!((&error["code"], &error["standing"]), expected, "{error}");
        assert!((1..DAY_MS).contains(&error["left_ms"].as_u64().unwrap()), "{error}");
    }
    let beat = json!({ "type": "jog", "monitor": "M1", "drive": "Vertical", "toward": "max" });
    socket.send(beat).await;
    let ended = socket.next_where(|it| it["type"] == "jog").await.unwrap();
    assert_eq!((&ended["state"], &ended["end"]), (&json!("ended"), &json!("refused")), "{ended}");
    let station = site.hub.station("M1").unwrap();
    until("others may have the monitor", || station.control(&site.hub).holder.is_none()).await;
    for urgent in ["stop", "close", "lockout"] {
        let answer = socket.ask(json!({ "type": urgent, "monitor": "M1" })).await;
        assert_eq!(answer["result"]["ok"], true, "{urgent}: {answer}");
    }
    assert_eq!(site.bus.commanded(0, 0), 0);

    time.pass(DAY_MS);
    site.hub.access_changed();
    assert_eq!(socket.next_where(|_| false).await, Err(4401));
    std::fs::remove_dir_all(&folder).unwrap();
}

/// The hub was started with a wrong date, which is set while a connection is open.
#[tokio::test]
async fn a_date_that_is_set_ends_a_certificate_on_an_open_websocket() {
    let Certified { folder, time, site: _site, mut socket, ends_ms } =
        Certified::new("date-set").await;
    time.set_date(ends_ms + 1000);
    let error = socket.ask(take()).await["error"].clone();
    let expected = (&json!("login_needed"), &json!("expired"));
    assert_eq!((&error["code"], &error["standing"]), expected, "{error}");
    assert!((1..DAY_MS).contains(&error["left_ms"].as_u64().unwrap()), "{error}");
    let answer = socket.ask(json!({ "type": "stop", "monitor": "M1" })).await;
    assert_eq!(answer["result"]["ok"], true, "{answer}");
    std::fs::remove_dir_all(&folder).unwrap();
}
