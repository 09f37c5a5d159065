//! `conformance/faults.txt`: each flag of each subsystem, each state of each button and each status
//! has a row, each row holds in the simulator, and faults are reported within a second.

use std::path::Path;

use lafet_proto::Status;
use lafet_proto::flags::Severity;
use lafet_sim::scenario::Failure;
use lafet_verify::faults_table::{Subject, TOLD_MS, Table};

/// Faults that show later than after a second, for the reason that the file gives: a valve between
/// its switches, and a deployment, can only be late when their time is over; a lossy unit is lost by
/// chance; water that flows has to last.
const LATE: [&str; 8] = [
    "Vertical ConnLost",
    "Deployer InternalFault",
    "Valve1 CloseSensorFault",
    "Valve2 CloseSensorFault",
    "Valve1 CloseSensorFault",
    "Valve2 CloseSensorFault",
    "Valve1 CloseSensorFault",
    "Valve1 OpenSensorFault",
];

fn shipped() -> Table {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../conformance/faults.txt");
    let text = std::fs::read_to_string(path).expect("conformance/faults.txt is there");
    Table::parse("faults.txt", &text).unwrap_or_else(|failure| panic!("{failure}"))
}

/// §3.3.1–§3.3.10, §2: no hole.
#[test]
fn everything_has_a_row() {
    let holes = shipped().holes();
    assert!(holes.is_empty(), "{} holes:\n{}", holes.len(), holes.join("\n"));
    // What must be there at least, counted from the document's own tables.
    let all = Subject::all();
    let count = |what: fn(&Subject) -> bool| all.iter().filter(|subject| what(subject)).count();
    let common = 14 * 16;
    let own = 3 + 16 + (14 + 14 + 14) + 2 * 8 + 9 + 8 + 16;
    assert_eq!(count(|subject| matches!(subject, Subject::Flag(..))), common + own);
    assert_eq!(count(|subject| matches!(subject, Subject::Button(..))), 2 * 8 * 4);
    assert_eq!(count(|subject| matches!(subject, Subject::Status(_))), 19);
}

/// Each row holds: not set before, set in time, and nothing set that is said to be never.
#[test]
fn every_row_holds() {
    let table = shipped();
    let (mut failures, mut late) = (Vec::new(), Vec::new());
    for row in &table.rows {
        match row.run() {
            Err(failure) => failures.push(failure.to_string()),
            Ok(Some(ms)) if ms > TOLD_MS && row.subject.severity() >= Some(Severity::Warning) => {
                late.push(row.subject.to_string());
            }
            Ok(_) => {}
        }
    }
    assert!(failures.is_empty(), "{} failed:\n\n{}", failures.len(), failures.join("\n\n"));
    assert_eq!(late, LATE);
    // Only what the document itself excludes or leaves empty may stay without a fault.
    let never: Vec<&Subject> =
        table.rows.iter().filter(|row| !row.is_reached()).map(|row| &row.subject).collect();
    assert!(never.contains(&&Subject::Status(Status::SYSTEM_FAULT)));
    for subject in never {
        match subject {
            Subject::Flag(_, flag) => assert!(flag.shift < 16 || flag.name == "TRVEngage"),
            Subject::Status(status) => {
                assert!([Status::SYSTEM_FAULT, Status::UNIMPLEMENTED].contains(status));
            }
            Subject::Button(..) => panic!("{subject}: a button has all its states"),
        }
    }
}

fn row(block: &str) -> Result<Option<u64>, Failure> {
    let table = Table::parse("t.txt", block)?;
    table.rows[0].run()
}

fn failure(block: &str) -> (usize, String) {
    let failure = row(block).expect_err("it must fail");
    (failure.line, format!("{} / {}", failure.expected, failure.came))
}

/// The time is taken from the line after `then`.
#[test]
fn the_time_is_measured() {
    let lockout = "flag LockedOut of General\nstate wrapped\nafter 2s\nthen ! Lockout All on\n";
    assert_eq!(row(&format!("{lockout}within 1s\n")), Ok(Some(0)));
    let lost = "flag ConnLost of Radio\nsource radio\n! Stop Vertical\nthen ! Stop Vertical\n\
                within 4s\nbecause of the document\n";
    assert_eq!(row(lost), Ok(Some(3000)));
    let button = "let button LeftButtonState=left\nflag LeftButtonState = Open of Buttons\n\
                  state wrapped\nthen inject buttons-{button}-break\nwithin 1s\n";
    assert_eq!(row(button), Ok(Some(10)));
}

/// What has to be watched is reported within a second whenever it breaks in a motion, at any phase of the
/// watch, and by slow drives too. (A wrong connection does not come in the middle of a motion.)
#[test]
fn whenever_it_breaks() {
    let faults = [
        ("PosEncoderFault", "encoder-dead"),
        ("SpeedEncoderFault", "speed-dead"),
        ("InternalFault", "power-stage"),
        ("AmperageOverload", "jam"),
    ];
    for (flag, fault) in faults {
        for after_ms in (300..1200).step_by(30) {
            for speed in ["", "! SetParam Horizontal Speed 1\n"] {
                let text = format!(
                    "flag {flag} of Horizontal\nstate deployed\n{speed}! Move Horizontal 9000\n\
                     after {after_ms}ms\nthen inject horizontal-{fault}\nwithin 1s\n"
                );
                assert!(row(&text).is_ok(), "{:?}", row(&text));
            }
        }
    }
}

/// A flag that does not come, that was there before, that is said to be never, at its line.
#[test]
fn rows_can_fail() {
    let (line, text) =
        failure("flag BadPower of General\nstate wrapped\nthen after 1s\nwithin 1s\n");
    assert!(line == 4 && text.contains("General flags has BadPower within 1000 ms"), "{text}");
    let (line, text) =
        failure("flag LockedOut of General\n! Lockout All on\nthen ! Lockout All on\nwithin 1s\n");
    assert!(line == 3 && text.contains("General flags lacks LockedOut"), "{text}");
    let (line, text) = failure(
        "flag Restarting of General\nthen ! Restart All\nwithin 1s\n\
         flag Terminated of General\nnever it is\n",
    );
    assert!(line == 3 && text.contains("General flags lacks Terminated"), "{text}");
    let (line, text) = failure(
        "status Denied\nstate deployed\nthen > Move Vertical 1\n< Vertical Move → Denied\n",
    );
    assert!(line == 4 && text.contains("Vertical Move → Accepted"), "{text}");
}

#[test]
fn what_cannot_be_read_names_its_line() {
    for (text, wrong) in [
        ("inject pressure-break\n", 1),
        ("flag Teapot of General\n", 1),
        ("flag LockedOut of Teapot\n", 1),
        ("flag LockedOut of Vertical\n", 1),
        ("flag LockedOut\n", 1),
        ("status Teapot\n", 1),
        ("\nflag LockedOut of General\n", 2),
        ("flag LockedOut of General\nthen ! Lockout All on\n", 1),
        ("flag LockedOut of General\nthen ! Lockout All on\nwithin 2s\n", 1),
        ("flag LockedOut of General\nthen ! Lockout All on\nwithin soon\n", 3),
        ("flag LockedOut of General\nthen ! Lockout All on\nthen after 1s\nwithin 1s\n", 3),
        ("flag LockedOut of General\nthen ! Lockout All on\nafter 1s\nwithin 1s\n", 3),
        ("flag LockedOut of General\nstate wrapped\nnever it is\n", 3),
        ("flag LockedOut of General\nthen inject teapot\nwithin 1s\n", 2),
        ("flag LeftButtonState of Buttons\nthen after 1s\nwithin 1s\n", 1),
        ("flag LockedOut = Short of General\nthen after 1s\nwithin 1s\n", 1),
        ("status Denied\nthen > Move Vertical 1\n< Vertical Move → Accepted\n", 1),
        ("status Ok\nthen > Stop Vertical\n< Vertical Stop → Ok\nwithin 1s\n", 1),
        ("let far\n", 1),
    ] {
        let failure = Table::parse("t.txt", text).map(|_| ()).expect_err(text);
        assert_eq!(failure.line, wrong, "{text}: {failure}");
    }
}

#[test]
fn holes_are_found() {
    let text = "flag LockedOut of General\nthen ! Lockout All on\nwithin 1s\n\
                flag LockedOut of General\nnever it is not\n";
    let holes = Table::parse("t.txt", text).expect("readable").holes();
    assert_eq!(holes.len(), Subject::all().len());
    assert!(holes.contains(&"General LockedOut: reached and never set".to_owned()));
    assert!(holes.contains(&"Buttons LeftButtonState=Short: no row".to_owned()));
    assert!(holes.contains(&"Cached: no row".to_owned()));
}
