//! The first weeks of the long run, and the wrap of the monitor's clock in the middle of everything.

use lafet_device::Source;
use lafet_proto::record::Writer;
use lafet_proto::text;
use lafet_sim::fault::{DriveFault, Fault};
use lafet_sim::sim::{Config, Sim};
use lafet_verify::years::Years;

/// A test, a fault, a parameter and a fire; `cargo xtask years` goes on from there.
#[test]
fn the_first_days() {
    let mut years = Years::new(1);
    for _ in 0..6 {
        years.day().unwrap();
    }
    let report = years.report();
    let seen = [report.tests, report.faults, report.parameters, report.lockouts, report.fires];
    assert_eq!(seen, [1, 1, 2, 1, 1], "{report}");
    assert!(report.wraps > 0 && report.water_m3 > 0.1 && report.faults_told > 0, "{report}");
    assert!(report.flash_words > 0, "{report}");
}

/// Request and seconds until the next: about every timer of the monitor runs at some time.
const EXERCISE: [(&str, u64); 13] = [
    ("SetParam General MoveTimeout 1500", 1),
    ("Deploy", 11),
    ("Move Horizontal 21600", 3),
    ("SetParam General MoveTimeout 0", 1),
    ("StartSeek -300 300 -100 100", 6),
    ("Stop Detector", 1),
    ("StartQuench centre=100,100 nozzle=60 sector=60,60 step=1 distance=20", 3),
    ("Open Valve1", 6),
    ("Move Vertical 500", 5),
    ("Stop Control", 1),
    ("Close Valve1", 5),
    ("Wrap", 12),
    ("Restart", 3),
];

/// What can be seen of the exercise with the clock started so long before its wrap.
fn exercise(before_wrap_ms: u32) -> String {
    let clock_ms = 0_u32.wrapping_sub(before_wrap_ms);
    let fires = vec!["az=10,range=20,size=1".parse().unwrap()];
    let mut sim = Sim::new(Config { clock_ms, fires, trace: true, ..Config::default() });
    let mut shown = String::new();
    for (request, seconds) in EXERCISE {
        let (mut buffer, mut record) = ([0; text::BUFFER_SIZE], [0; 260]);
        for request in [request, "GetStatus All"] {
            let mut writer = Writer::new(&mut record);
            text::parse(request, &mut buffer).unwrap().encode(&mut writer).unwrap();
            let answer = sim.request(Source::ExternalConn, writer.written());
            shown += &format!("{request}: {answer:02x?}\n");
        }
        // An overload, which is forgotten 3 s after the drive has stopped.
        let jam = Fault::Drive(lafet_device::image::Axis::Vertical, DriveFault::Jam);
        if request.starts_with("Move Vertical") {
            sim.world_mut().inject(jam);
        }
        sim.advance_ms(seconds * 1_000);
        sim.world_mut().clear(jam);
    }
    shown + &sim.take_trace().unwrap_or_default()
}

/// §D/3 Wherever in the exercise the clock wraps, what happens is the same, byte for byte.
#[test]
fn the_wrap_changes_nothing() {
    let expected = exercise(0x8000_0000);
    assert!(expected.lines().count() > 500);
    for second in (0..60).step_by(2) {
        let shown = exercise(second * 1_000 + 5);
        let differs = expected.lines().zip(shown.lines()).find(|(a, b)| a != b);
        assert_eq!(differs, None, "wraps after {second} s");
        assert_eq!(shown.len(), expected.len());
    }
}
