//! Draws scenes into memory and checks the pictures.

use std::time::Duration;

use lafet_client::{AnswerBuf, LinkStatistics};
use lafet_proto::flags::{ConnFlags, DetectorFlags, DriveFlags, GeneralFlags};
use lafet_proto::record::Record;
use lafet_proto::status::{Hotbed, Limits};
use lafet_proto::{RequestId, Status, SubsystemId};
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::style::{Color, Modifier};

use super::scene::{Connected, Page, Scene, Seen};
use super::{plain, render};

fn answer(device: SubsystemId, data: &[u8]) -> AnswerBuf {
    let request = RequestId::GET_STATUS;
    AnswerBuf::new(&Record { request, device, status: Status::OK, data })
}

fn drive(who: SubsystemId, flags: u32, position: i16) -> AnswerBuf {
    let mut data = flags.to_le_bytes().to_vec();
    data.extend(position.to_le_bytes());
    data.extend([21, 10]);
    answer(who, &data)
}

/// A monitor that does not extinguish; its barrel moves, at 6.3 atm.
fn monitor(name: &str) -> Seen {
    let mut general = GeneralFlags::empty().bits().to_le_bytes().to_vec();
    general.extend([24, 0, 63, 0, 20, 0]);
    Seen {
        name: name.into(),
        url: format!("tcp://{name}"),
        connected: Connected::Up,
        answers: vec![
            drive(SubsystemId::HORIZONTAL, DriveFlags::MOVE.bits(), 1800),
            drive(SubsystemId::VERTICAL, 0, -60),
            drive(SubsystemId::NOZZLE, 0, 30),
            answer(SubsystemId::GENERAL, &general),
        ],
        age: Duration::from_millis(300),
        limits: vec![(SubsystemId::HORIZONTAL, Limits { min: -3600, max: 3600 })],
        ..Seen::default()
    }
}

fn with(mut seen: Seen, who: SubsystemId, flags: u32) -> Seen {
    seen.answers.push(answer(who, &flags.to_le_bytes()));
    seen
}

fn scene(monitors: Vec<Seen>, page: Page) -> Scene {
    Scene { monitors, page, ..Scene::default() }
}

fn shows(picture: &str, words: &[&str]) {
    for word in words {
        assert!(picture.contains(word), "{word}:\n{picture}");
    }
}

#[test]
fn the_list_shows_state_position_pressure_and_faults() {
    let found = with(monitor("b:1/2"), SubsystemId::DETECTOR, DetectorFlags::FOUND.bits());
    let silent = Seen {
        name: "c:1/3".into(),
        connected: Connected::Down("refused".into()),
        ..Seen::default()
    };
    let mut scene = scene(vec![monitor("a:1/1"), found, silent], Page::List);
    scene.selected = 1;
    let picture = plain(&scene, 80, 24);
    let line = |name: &str| picture.lines().find(|line| line.contains(name)).unwrap().to_owned();
    shows(&line("a:1/1"), &["moving", "30.0°", "-1.0°", "30 mm", "6.3", "20", "0.3 s"]);
    assert!(!line("a:1/1").contains('!'), "{picture}");
    shows(&picture, &["▶ !! b:1/2", "!!Detector Found", "no link", "refused", "2 of 3"]);
    // The faults shown are those of the selected monitor.
    shows(&picture, &["b:1/2: problems", "Detector Found [alarm]:"]);
    shows(&picture, &["STOP ALL: b:1/2", "alarms: 2", "stale: 1"]);
    assert_eq!(picture.lines().count(), 24, "{picture}");
}

/// The reading of a broken sensor is not shown as a value.
#[test]
fn an_invalid_value_is_not_shown_as_a_number() {
    let mut broken = monitor("a:1/1");
    let encoder = DriveFlags::POS_ENCODER_FAULT.bits();
    broken.answers[1] = drive(SubsystemId::VERTICAL, encoder, -60);
    let mut general = GeneralFlags::PRESSURE_SENSOR_BREAK.bits().to_le_bytes().to_vec();
    general.extend([24, 0, 63, 0, 20, 0]);
    broken.answers[3] = answer(SubsystemId::GENERAL, &general);
    let scene = scene(vec![broken, monitor("b:1/2")], Page::List);
    let picture = plain(&scene, 80, 24);
    let line = |name: &str| picture.lines().find(|line| line.contains(name)).unwrap().to_owned();
    assert_eq!(line("a:1/1").matches("??").count(), 2, "{picture}");
    assert!(!line("a:1/1").contains("6.3") && !line("a:1/1").contains("-1.0°"), "{picture}");
    assert!(!line("b:1/2").contains("??"), "{picture}");
}

#[test]
fn what_is_stale_is_grey_and_says_so() {
    let stale = Seen {
        stale: true,
        age: Duration::from_secs(42),
        error: Some("no answer to GetStatus".into()),
        ..with(monitor("a:1/1"), SubsystemId::RADIO, ConnFlags::CONN_LOST.bits())
    };
    let scene = scene(vec![monitor("fresh"), stale], Page::List);
    let mut terminal = Terminal::new(TestBackend::new(80, 24)).unwrap();
    terminal.draw(|frame| render(frame, &scene)).unwrap();
    let buffer = terminal.backend().buffer();
    let row = |name: &str| {
        (0..24).find(|y| {
            let text: String = (0..80).map(|x| buffer[(x, *y)].symbol().to_owned()).collect();
            text.contains(name) && !text.contains("what")
        })
    };
    let (fresh, old) = (row("fresh").unwrap(), row("a:1/1").unwrap());
    assert_eq!(buffer[(5, old)].fg, Color::DarkGray);
    assert_ne!(buffer[(5, fresh)].fg, Color::DarkGray);
    assert!(buffer[(5, fresh)].modifier.contains(Modifier::REVERSED), "it is selected");
    shows(&plain(&scene, 80, 24), &["42 s", "stale: no answer to GetStatus"]);
}

#[test]
fn a_page_for_one_monitor() {
    let mut seen = monitor("a:1/1");
    seen.hotbeds = vec![Hotbed { x1: 1900, x2: 1700, y1: -200, y2: -20, brightness: 1400 }];
    let seen = with(seen, SubsystemId::VALVE1, lafet_proto::flags::ValveFlags::OPEN.bits());
    let picture = plain(&scene(vec![seen], Page::Detail), 80, 24);
    shows(&picture, &["60.0° ├", "●", "┤ -60.0°", "2.1 A", "10 °/s", "Move"]);
    shows(&picture, &["Valve1       Open", "24 V, 6.3 atm, 20 l/s", "1400", "STOP ALL: a:1/1"]);
    // Left of the middle, as on the monitor: 30° between 60° and −60°.
    let bar = picture.split(['├', '┤']).nth(1).unwrap().chars().position(|c| c == '●').unwrap();
    assert!((2..10).contains(&bar), "{picture}");
}

#[test]
fn a_page_for_the_link() {
    let mut seen = monitor("a:1/1");
    shows(&plain(&scene(vec![monitor("a:1/1")], Page::Link), 80, 24), &["after a second"]);
    let mut figures = LinkStatistics::default();
    figures.last.frames_sent = 17;
    figures.last.believed = 15;
    figures.last.timeouts = 2;
    figures.total.frames_sent = 4711;
    figures.total.rtt_last = Some(Duration::from_micros(12_300));
    seen.figures = Some(figures);
    seen.own.frames_sent = 333;
    seen.round_trips = vec![1000, 0, 12_300];
    let picture = plain(&scene(vec![seen], Page::Link), 80, 24);
    shows(&picture, &["17", "4711", "333", "11.7 %", "last 12.3 ms", "longest: 12.3 ms", "█"]);
}

/// On every page, at every size, with the keys explained and with a notice.
#[test]
fn stop_is_always_visible() {
    for page in [Page::List, Page::Detail, Page::Link] {
        for (width, height) in [(20, 1), (20, 3), (40, 8), (80, 24), (120, 40), (300, 100)] {
            for help in [false, true] {
                let notice = help.then(|| "a:1/1: Stop All → Ok".to_owned());
                let monitors = vec![monitor("a:1/1")];
                let scene = Scene { help, notice, ..scene(monitors, page) };
                let picture = plain(&scene, width, height);
                let last = picture.lines().last().unwrap();
                assert!(last.contains("STOP ALL: a"), "{width}x{height}: {picture}");
                if help && height >= 24 {
                    shows(&picture, &["Stop All for the selected", "Stop All → Ok"]);
                }
            }
        }
    }
    for size in [(1, 1), (2, 2), (7, 5)] {
        plain(&scene(vec![monitor("a")], Page::List), size.0, size.1);
        plain(&scene(vec![], Page::Detail), size.0, size.1);
    }
}

#[test]
fn the_selected_monitor_of_many_is_in_sight() {
    let monitors: Vec<Seen> = (0..40).map(|index| monitor(&format!("m{index:02}"))).collect();
    let mut scene = scene(monitors, Page::List);
    for selected in [0, 7, 8, 25, 39] {
        scene.selected = selected;
        let picture = plain(&scene, 80, 24);
        let line = picture.lines().find(|line| line.starts_with('▶')).unwrap();
        assert!(line.contains(&format!("m{selected:02}")), "{picture}");
    }
}

#[test]
fn a_healthy_deployed_monitor_has_no_faults() {
    use lafet_proto::flags::DeployerFlags;
    let at_rest = DeployerFlags::DEPLOYED | DeployerFlags::ABSOLUTE_MAX_LIMIT_REACHED;
    let mut seen = monitor("one");
    seen.answers.push(drive(SubsystemId::DEPLOYER, at_rest.bits(), 5400));
    seen = with(seen, SubsystemId::EXTERNAL_CONN, ConnFlags::CONN_LOST.bits());
    seen = with(seen, SubsystemId::RADIO, ConnFlags::CONN_LOST.bits());
    assert_eq!(seen.faults(), []);
    assert_eq!(seen.severity(), lafet_proto::flags::Severity::Info);
    assert!(seen.flag_names().iter().any(|(_, name)| name == "Radio ConnLost"));
    let between = DeployerFlags::ABSOLUTE_MAX_LIMIT_REACHED;
    seen.answers.push(drive(SubsystemId::DEPLOYER, between.bits(), 5400));
    assert!(!seen.faults().is_empty());
}

#[test]
fn left_on_the_monitor_is_left_on_the_screen() {
    let mut seen = monitor("one");
    seen.limits = vec![(SubsystemId::HORIZONTAL, Limits { min: -10800, max: 10800 })];
    let picture = plain(&scene(vec![seen], Page::Detail), 120, 20);
    let line = picture.lines().find(|line| line.starts_with("Horizontal")).unwrap();
    let place = |text: &str| line.find(text).unwrap_or_else(|| panic!("{text}: {line}"));
    assert!(place(" 180.0°") < place("●") && place("●") < place("-180.0°"), "{line}");
    assert!(place("●") - place("├") < place("┤") - place("●"), "30° left of the middle: {line}");
}
