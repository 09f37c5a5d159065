//! Pictures of a camera over their WebSocket: who may see them, how many, who is slow. The process of the camera is a
//! script that prints pictures; docs/cameras.md names the tests with cameras that are not ours.
#![cfg(unix)]

use std::ffi::OsString;
use std::fs;
use std::path::PathBuf;
use std::time::Duration;

use bytes::Bytes;
use futures_util::{SinkExt, StreamExt};
use lafet_eyes::wire::{Frame, Picture, Said};
use lafet_hub::access::Role;
use lafet_hub::{CameraConfig, Mount, text};
use serde_json::json;
use tokio::net::{TcpSocket, TcpStream};
use tokio::time::{Instant, sleep, timeout};
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::tungstenite::{Error, Message};

use crate::support::{PATIENCE, Site};

/// Pictures between two key frames, and pauses between pictures: 20 a second.
const GROUP: usize = 20;
const EACH_S: &str = "0.05";
/// A slow viewer is sent on to a key frame within this time.
const LONG: Duration = Duration::from_secs(12);

/// Pictures of a camera, and the script that prints them for ever.
struct Played(PathBuf);

impl Played {
    /// Each picture has so many bytes.
    fn new(name: &str, len: usize) -> Self {
        let folder = std::env::temp_dir().join(format!("lafet-eyes-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let picture = || Picture { codec: "avc1.64001f".into(), width: 1280, height: 720 };
        for number in 0..GROUP {
            let said = Said::Frame(Frame {
                key: (number == 0).then(picture),
                shown_us: i64::try_from(number).unwrap() * 50_000,
                captured_us: Some(1_763_712_000_000_000),
                lost: 0,
                data: Bytes::from(vec![7; len]),
            });
            fs::write(folder.join(format!("{number:03}")), said.written()).unwrap();
        }
        Self(folder)
    }

    fn program(&self) -> Vec<OsString> {
        let folder = self.0.display();
        let script = format!(
            "PATH=/usr/bin:/bin; while :; do for it in {folder}/*; do cat $it; sleep {EACH_S}; done; done"
        );
        ["sh", "-c", &script].map(OsString::from).to_vec()
    }
}

impl Drop for Played {
    fn drop(&mut self) {
        _ = fs::remove_dir_all(&self.0);
    }
}

async fn site(played: &Played, login: bool) -> Site {
    let camera = CameraConfig {
        id: "C1".into(),
        name: text::both("West", "Запад"),
        url: "rtsp://127.0.0.1:1/?key=geheim".into(),
        login: None,
        monitors: vec!["M1".into()],
        zones: Vec::new(),
        mount: Mount::Mast,
    };
    Site::with(1, |config| {
        (config.login, config.cameras) = (login, vec![camera]);
        config.camera_program = played.program();
    })
    .await
}

struct Viewer(WebSocketStream<TcpStream>);

impl Viewer {
    async fn open(site: &Site, token: &str) -> Result<Self, u16> {
        let stream = TcpStream::connect(site.address).await.unwrap();
        Self::over(stream, site, token).await
    }

    /// What is not read stays little.
    async fn narrow(site: &Site) -> Self {
        let socket = TcpSocket::new_v4().unwrap();
        socket.set_recv_buffer_size(16 * 1024).unwrap();
        let stream = socket.connect(site.address).await.unwrap();
        Self::over(stream, site, "").await.unwrap()
    }

    async fn over(stream: TcpStream, site: &Site, token: &str) -> Result<Self, u16> {
        let url = format!("ws://{}/api/cameras/C1/stream", site.address);
        let mut request = url.into_client_request().unwrap();
        if !token.is_empty() {
            let bearer = format!("Bearer {token}").parse().unwrap();
            request.headers_mut().insert("Authorization", bearer);
        }
        match tokio_tungstenite::client_async(request, stream).await {
            Ok((socket, _)) => Ok(Self(socket)),
            Err(Error::Http(answer)) => Err(answer.status().as_u16()),
            Err(error) => panic!("{error}"),
        }
    }

    /// The next picture, which is said to be seen; the code with which it is closed.
    async fn next(&mut self) -> Result<Vec<u8>, u16> {
        loop {
            match timeout(PATIENCE, self.0.next()).await.expect("in time") {
                Some(Ok(Message::Binary(picture))) => {
                    let number = picture[4..8].to_vec();
                    _ = self.0.send(Message::Binary(number.into())).await;
                    return Ok(picture.to_vec());
                }
                Some(Ok(Message::Close(frame))) => {
                    return Err(frame.map_or(0, |it| it.code.into()));
                }
                Some(Ok(_)) => {}
                Some(Err(_)) | None => return Err(0),
            }
        }
    }
}

fn number(picture: &[u8]) -> u32 {
    u32::from_be_bytes(picture[4..8].try_into().unwrap())
}

#[tokio::test]
async fn a_viewer_begins_at_once_with_a_key_frame_and_misses_nothing() {
    let played = Played::new("begin", 2000);
    let site = site(&played, false).await;
    let mut first = Viewer::open(&site, "").await.unwrap();
    for _ in 0..GROUP / 2 {
        first.next().await.unwrap();
    }
    // In the middle of a group.
    let began = Instant::now();
    let mut second = Viewer::open(&site, "").await.unwrap();
    let mut last = None;
    for at in 0..GROUP * 2 {
        let picture = second.next().await.unwrap();
        if at == 0 {
            assert_eq!(picture[1] & 1, 1, "a key frame");
            assert_eq!(&picture[36..47], b"avc1.64001f");
            assert!(began.elapsed() < Duration::from_millis(800), "{:?}", began.elapsed());
        }
        let number = number(&picture);
        assert!(last.is_none_or(|last| number == last + 1), "{last:?} {number}");
        last = Some(number);
    }
    let all = site.get("", "/api/cameras").await;
    let camera = &all.body[0];
    assert_eq!((&camera["state"], &camera["viewers"]), (&json!("playing"), &json!(2)));
    assert_eq!((&camera["size"], &camera["mount"]), (&json!([1280, 720]), &json!("mast")));
    assert!(!all.text.contains("geheim") && !all.text.contains("rtsp"), "{}", all.text);
    let mut page = site.ws("").await;
    page.next_of("state").await;
    assert_eq!(page.known["cameras/C1"]["name"], json!({ "en": "West", "ru": "Запад" }));
}

/// One viewer takes nothing, one a little: the third misses nothing, and Stop is as quick as without them.
#[tokio::test(flavor = "multi_thread")]
async fn slow_viewers_delay_no_other_and_no_stop() {
    let played = Played::new("slow", 100_000);
    let site = site(&played, false).await;
    let _deaf = Viewer::narrow(&site).await;
    let mut slow = Viewer::narrow(&site).await;
    let mut quick = Viewer::open(&site, "").await.unwrap();
    // A third of what comes.
    let of_slow = tokio::spawn(async move {
        let (mut seen, end) = (Vec::new(), Instant::now() + LONG);
        while Instant::now() < end {
            let picture = slow.next().await.unwrap();
            seen.push((number(&picture), picture[1] & 1 == 1));
            sleep(Duration::from_millis(150)).await;
        }
        seen
    });
    let (mut last, mut gaps, end) = (None, Vec::new(), Instant::now() + LONG);
    let mut longest = Duration::ZERO;
    while Instant::now() < end {
        let number = number(&quick.next().await.unwrap());
        gaps.extend(last.filter(|last| number != last + 1));
        last = Some(number);
        if number % 10 == 0 {
            let began = Instant::now();
            let reply = site.post("", "/api/monitors/M1/stop", json!({})).await;
            assert!(reply.status < 300, "{reply:?}");
            longest = longest.max(began.elapsed());
        }
    }
    assert_eq!(gaps, [0; 0], "the quick one");
    assert!(longest < Duration::from_millis(1000), "{longest:?}");
    let of_slow = of_slow.await.unwrap();
    let jumps = of_slow.windows(2).filter(|it| it[1].0 != it[0].0 + 1);
    let jumps: Vec<_> = jumps.map(|it| it[1]).collect();
    assert!(!jumps.is_empty() && jumps.iter().all(|(_, key)| *key), "{of_slow:?}");
}

#[tokio::test]
async fn who_may_see_pictures_and_how_many() {
    let played = Played::new("who", 500);
    let site = site(&played, true).await;
    assert_eq!(Viewer::open(&site, "").await.err(), Some(401));
    let token = site.token(Role::Observer);
    let nothing = site.get(&token, "/api/cameras/C9/stream").await;
    assert_eq!((nothing.status, nothing.code()), (404, "no_camera"));
    let plain = site.get(&token, "/api/cameras/C1/stream").await;
    assert_eq!((plain.status, plain.code()), (400, "bad_request"));
    let mut viewers = Vec::new();
    for _ in 0..16 {
        viewers.push(Viewer::open(&site, &token).await.unwrap());
    }
    assert_eq!(Viewer::open(&site, &token).await.err(), Some(503));
    let mut first = viewers.remove(0);
    first.next().await.unwrap();
    // What a viewer says is little.
    for _ in 0..600 {
        _ = first.0.send(Message::Text("x".into())).await;
    }
    let closed = async {
        loop {
            if let Err(code) = first.next().await {
                return code;
            }
        }
    };
    assert_eq!(timeout(PATIENCE, closed).await.unwrap(), 4429);
    viewers.push(Viewer::open(&site, &token).await.expect("there is room again"));
    // The token is withdrawn.
    let tokens = site.hub.access().tokens().unwrap();
    let id = tokens.first().expect("one").id;
    site.hub.access().remove_token(id).unwrap();
    site.hub.access_changed();
    for mut viewer in viewers {
        let code = loop {
            if let Err(code) = viewer.next().await {
                break code;
            }
        };
        assert_eq!(code, 4401);
    }
}
