//! Processes that are none: programs of the system in their place.

use std::ffi::OsString;

use bytes::Bytes;
use lafet_eyes::wire::Picture;

use super::*;
use crate::cameras::feed::Viewer;
use crate::cameras::{CameraConfig, Mount, start as start_all};
use crate::{Clock, Config};

const PATIENCE: Duration = Duration::from_secs(30);

/// A hub with one camera, whose process is this script.
fn hub(script: &str) -> Hub {
    let camera = CameraConfig {
        id: "C1".into(),
        name: Both::same("C1"),
        url: "rtsp://127.0.0.1:1/".into(),
        login: None,
        monitors: vec!["M1".into()],
        zones: Vec::new(),
        mount: Mount::Fixed,
    };
    let program = ["sh", "-c", &format!("PATH=/usr/bin:/bin; {script}")].map(OsString::from);
    let config =
        Config { cameras: vec![camera], camera_program: program.to_vec(), ..Config::default() };
    Hub::new(config, Clock::System, serde_json::Value::Null).unwrap()
}

fn frame(key: bool, shown_us: i64) -> Bytes {
    let picture = || Picture { codec: "avc1.64001f".into(), width: 640, height: 360 };
    let data = Bytes::from_static(&[0, 0, 0, 1, 0x65, 7]);
    let frame = Frame { key: key.then(picture), shown_us, captured_us: None, lost: 0, data };
    Said::Frame(frame).written()
}

/// Messages as the arguments of `printf`.
fn printed(messages: &[Bytes]) -> String {
    let bytes = messages.iter().flatten().map(|byte| format!("\\{byte:03o}"));
    format!("printf '{}'", bytes.collect::<String>())
}

/// The state that a camera comes to, once it is this word.
async fn until(hub: &Hub, word: CameraWord) -> crate::cameras::view::CameraView {
    let camera = hub.cameras().find("C1").unwrap().clone();
    let mut version = hub.topics().version();
    let reached = async {
        loop {
            let view = camera.view();
            if view.state == word {
                return view;
            }
            version.changed().await.unwrap();
        }
    };
    timeout(PATIENCE, reached).await.unwrap_or_else(|_| panic!("{word:?}: {:?}", camera.view()))
}

async fn why(script: &str) -> String {
    let hub = hub(script);
    start_all(&hub);
    let view = until(&hub, CameraWord::Failed).await;
    hub.begin_shutdown();
    view.why.unwrap().en
}

#[tokio::test]
async fn what_a_process_does_wrong_ends_it_alone_and_is_said() {
    assert_eq!(why("exit 3").await, text::CameraDied.words().en);
    assert_eq!(why("kill -SEGV $$").await, text::CameraDied.words().en);
    assert_eq!(why("cat /dev/zero").await, text::CameraDied.words().en, "no messages");
    assert_eq!(why("cat /dev/urandom").await, text::CameraDied.words().en, "no messages");
    assert_eq!(why("exec sleep 60").await, text::CameraHangs.words().en);
    let alive = printed(&[Said::Alive.written()]);
    assert_eq!(why(&format!("{alive}; exec sleep 60")).await, text::CameraHangs.words().en);
    let fault = Said::Fault(Fault::new(FaultKind::Missing, "404")).written();
    assert_eq!(why(&printed(&[fault])).await, text::CameraMissing.words().en);
}

/// It grows, though it says that it runs.
#[cfg(target_os = "linux")]
#[tokio::test]
async fn a_process_that_takes_too_much_memory_is_ended() {
    let alive = printed(&[Said::Alive.written()]);
    // Its input does not end: there it waits, as large as it is then.
    let large = "BEGIN { s = \"x\"; while (length(s) < 300000000) s = s s; getline }";
    let grow = format!("while :; do {alive}; sleep 0.2; done & exec awk '{large}'");
    assert_eq!(why(&grow).await, text::CameraHeavy.words().en);
}

#[tokio::test]
async fn pictures_are_passed_on_and_one_that_freezes_is_said() {
    let first = printed(&[frame(true, 0), frame(false, 40_000)]);
    let alive = printed(&[Said::Alive.written()]);
    let same = printed(&[frame(false, 40_000)]);
    // The camera sends the same picture again and again.
    let script = format!("{first}; while :; do {alive}; {same}; sleep 0.3; done");
    let hub = hub(&script);
    start_all(&hub);
    let view = until(&hub, CameraWord::Playing).await;
    let began = Instant::now();
    assert_eq!(
        view.codec.or(hub.cameras().find("C1").unwrap().view().codec).unwrap(),
        "avc1.64001f"
    );
    until(&hub, CameraWord::Frozen).await;
    assert!(began.elapsed() < Duration::from_secs(2), "{:?}", began.elapsed());
    let camera = hub.cameras().find("C1").unwrap();
    let taken = camera.feed.next(&mut Viewer::default(), Instant::now()).unwrap();
    assert_eq!(taken[1] & 1, 1, "a key frame first");
    assert!(hub.topics().get("cameras/C1").unwrap().get().contains("\"frozen\""));
    hub.begin_shutdown();
}

/// It is started again, and what the hub knows of it is as new.
#[tokio::test]
async fn a_process_that_was_killed_is_started_again() {
    let first = printed(&[frame(true, 0)]);
    let hub = hub(&format!("{first}; sleep 0.5; kill -KILL $$"));
    start_all(&hub);
    for _ in 0..2 {
        until(&hub, CameraWord::Playing).await;
        let failed = until(&hub, CameraWord::Failed).await;
        assert_eq!(failed.why.unwrap().en, text::CameraDied.words().en);
    }
    hub.begin_shutdown();
}

/// A process that ignores everything is gone with the hub.
#[cfg(target_os = "linux")]
#[tokio::test]
async fn no_process_outlives_the_hub() {
    let alive = printed(&[Said::Alive.written()]);
    let hub = hub(&format!("trap '' TERM HUP PIPE; while :; do {alive}; sleep 0.2; done"));
    start_all(&hub);
    let mut ours = Vec::new();
    let deadline = Instant::now() + PATIENCE;
    while ours.is_empty() && Instant::now() < deadline {
        ours = children();
        sleep(Duration::from_millis(50)).await;
    }
    let process = *ours.first().expect("it runs");
    hub.begin_shutdown();
    while memory_of(process).is_some() && Instant::now() < deadline {
        sleep(Duration::from_millis(50)).await;
    }
    assert!(memory_of(process).is_none(), "{process} runs on");
}

/// Processes of this program that are called as that of a camera.
#[cfg(target_os = "linux")]
fn children() -> Vec<u32> {
    let own = std::process::id().to_string();
    let of = |entry: std::io::Result<std::fs::DirEntry>| {
        let number: u32 = entry.ok()?.file_name().to_str()?.parse().ok()?;
        let read = |what: &str| std::fs::read_to_string(format!("/proc/{number}/{what}")).ok();
        let parent = read("stat")?.rsplit(") ").next()?.split(' ').nth(1)?.to_owned();
        let ours = parent == own && read("cmdline")?.contains("trap ''");
        ours.then_some(number)
    };
    std::fs::read_dir("/proc").unwrap().filter_map(of).collect()
}

#[test]
fn pauses_grow_and_a_wrong_password_is_tried_seldom() {
    let (mut pauses, short) = (Pauses::default(), Duration::from_secs(1));
    let seconds = |pause: Duration| pause.as_secs_f64();
    let all: Vec<f64> = (0..7).map(|_| seconds(pauses.next(short, false))).collect();
    assert_eq!(all, [0.5, 1.0, 2.0, 4.0, 8.0, 15.0, 15.0]);
    assert_eq!(seconds(pauses.next(short, true)), 30.0);
    let all: Vec<f64> = (0..4).map(|_| seconds(pauses.next(short, true))).collect();
    assert_eq!(all, [60.0, 120.0, 240.0, 300.0]);
    assert_eq!(seconds(pauses.next(PLAYED, false)), 0.5, "it has played meanwhile");
}

#[test]
fn a_camera_may_send_so_much_and_no_more() {
    let start = Instant::now();
    let mut rate = Rate::new(start);
    let at = |ms: u32| start + Duration::from_millis(ms.into());
    assert!((0..1000).all(|frame| rate.allows(at(frame * 40), 200_000)), "40 Mbit/s");
    assert!(!(1000..2000).all(|frame| rate.allows(at(frame * 40), 300_000)), "60 Mbit/s");
    let mut burst = Rate::new(start);
    assert!(!(0..7).all(|_| burst.allows(start, 4_000_000)));
    let mut small = Rate::new(start);
    assert!((0..10_000).all(|message| small.allows(at(message * 10), 1)), "100 messages a second");
    assert!(!(10_000..20_000).all(|message| small.allows(at(100_000 + message - 10_000), 1)));
}

/// However often a stream changes, clients that are sent states are not flooded with it.
#[tokio::test]
async fn a_stream_that_changes_all_the_time_is_published_seldom() {
    let hub = hub("exit 0");
    let camera = hub.cameras().find("C1").unwrap().clone();
    let start = Instant::now();
    let mut stream = Stream::new(start);
    let (mut published, mut last) = (0, None);
    for number in 0..1000_u16 {
        let now = start + Duration::from_millis(u64::from(number) * 5);
        let picture = Picture { codec: "avc1.64001f".into(), width: number, height: 360 };
        let (shown_us, data) = (i64::from(number) * 5000, Bytes::from_static(&[0, 0, 0, 1, 0x65]));
        let frame = Frame { key: Some(picture), shown_us, captured_us: None, lost: 0, data };
        stream.came(&hub, &camera, &frame, now);
        stream.publish(&hub, &camera, now);
        let text = hub.topics().get("cameras/C1").map(|it| it.get().to_owned());
        published += usize::from(text != last);
        last = text;
    }
    // 5 s.
    assert!((4..=6).contains(&published), "{published}");
    assert_eq!(camera.view().size, Some([999, 360]), "who asks is answered what is");
    stream.publish(&hub, &camera, start + Duration::from_secs(7));
    assert!(hub.topics().get("cameras/C1").unwrap().get().contains("[999,360]"));
    hub.begin_shutdown();
}
