//! Runs every scenario of `conformance/scenarios`, and checks that the runner itself can fail.

use std::fs;
use std::path::{Path, PathBuf};

use lafet_sim::scenario::Scenario;
use lafet_texts::{Lang, Text as _};

/// A test for each file: `scenarios::s3_14` runs that of §3.14.
macro_rules! files {
    ($($test:ident $file:literal;)+) => {
        $(
            #[test]
            fn $test() {
                holds($file);
            }
        )+
        const FILES: &[&str] = &[$($file),+];
    };
}

files! {
    s1_general "1-general.txt";
    s2_record "2-record.txt";
    s3_01_move "3.01-move.txt";
    s3_02_stop "3.02-stop.txt";
    s3_03_getstatus "3.03-getstatus.txt";
    s3_03_01_common_flags "3.03.01-common-flags.txt";
    s3_03_02_general "3.03.02-general.txt";
    s3_03_03_climatics "3.03.03-climatics.txt";
    s3_03_04_drives "3.03.04-drives.txt";
    s3_03_05_valves "3.03.05-valves.txt";
    s3_03_06_control "3.03.06-control.txt";
    s3_03_07_detector "3.03.07-detector.txt";
    s3_03_08_deployer "3.03.08-deployer.txt";
    s3_03_09_connections "3.03.09-connections.txt";
    s3_03_10_buttons "3.03.10-buttons.txt";
    s3_04_getparam "3.04-getparam.txt";
    s3_05_setparam "3.05-setparam.txt";
    s3_06_correction_table "3.06-correction-table.txt";
    s3_07_retrieve_limits "3.07-retrieve-limits.txt";
    s3_08_open "3.08-open.txt";
    s3_09_close "3.09-close.txt";
    s3_10_deploy "3.10-deploy.txt";
    s3_11_wrap "3.11-wrap.txt";
    s3_12_restart "3.12-restart.txt";
    s3_13_justify "3.13-justify.txt";
    s3_14_quench "3.14-quench.txt";
    s3_15_trajectory "3.15-trajectory.txt";
    s3_16_seek "3.16-seek.txt";
    s3_17_switch_limits "3.17-switch-limits.txt";
    s3_18_lockout "3.18-lockout.txt";
    s3_19_clean_flash "3.19-clean-flash.txt";
    s3_20_crash_data "3.20-crash-data.txt";
    s3_21_hotbeds "3.21-hotbeds.txt";
    d_power_up "D-power-up.txt";
    p_parameters "P-parameters.txt";
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../conformance/scenarios")
}

#[test]
fn no_scenario_is_left_out() {
    let mut files: Vec<String> = fs::read_dir(folder())
        .expect("conformance/scenarios is there")
        .map(|entry| entry.expect("a readable folder").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "txt"))
        .map(|path| path.file_name().unwrap_or_default().to_string_lossy().into_owned())
        .collect();
    files.sort();
    assert_eq!(files, FILES, "the files, and the tests of them above");
}

fn holds(name: &str) {
    let text = fs::read_to_string(folder().join(name)).expect("a readable file");
    let Scenario { file, cases } =
        Scenario::parse(name, &text).unwrap_or_else(|failure| panic!("{failure}"));
    assert!(!cases.is_empty(), "{file} has no case");
    let mut failures = Vec::new();
    for case in cases {
        // Each case alone, so that one failure does not hide the others.
        let alone = Scenario { file: file.clone(), cases: vec![case] };
        failures.extend(alone.run(&mut |_| {}).err().map(|failure| failure.to_string()));
    }
    assert!(failures.is_empty(), "{} failed:\n\n{}", failures.len(), failures.join("\n\n"));
}

/// Runs a text and returns where and why it fails.
fn failure(text: &str) -> (usize, String) {
    let failure = Scenario::parse("t.txt", text)
        .and_then(|scenario| scenario.run(&mut |_| {}))
        .expect_err("the scenario must fail");
    (failure.line, format!("{} / {}", failure.expected, failure.came))
}

#[test]
fn a_wrong_answer_is_found() {
    let (line, text) = failure("case a\n> Move Vertical 10\n< Vertical Move → Accepted\n");
    assert_eq!(line, 3);
    assert!(text.contains("Vertical Move → Denied (Deployer)"), "{text}");
}

#[test]
fn missing_and_further_answers_are_found() {
    let (line, text) = failure(
        "case a\n> Move Vertical 10\n< Vertical Move → Denied (Deployer)\n< Vertical Move → Ok\n",
    );
    assert!(line == 4 && text.contains("no further answer"), "{line} {text}");
    let (line, text) =
        failure("case a\n> Move Vertical 1 ; Move Nozzle 1\n< Vertical Move → Denied (Deployer)\n");
    assert!(line == 3 && text.contains("Nozzle Move"), "{line} {text}");
}

#[test]
fn watches_and_waits_fail_at_their_line() {
    let (line, text) = failure("case a\nnever output motion > 0\n! Deploy Deployer\nafter 2s\n");
    assert!(line == 2 && text.contains("never output motion > 0"), "{line} {text}");
    let (line, _) = failure("case a\nalways output motion = 0\n! Deploy Deployer\nafter 2s\n");
    assert_eq!(line, 2);
    let (line, text) = failure("case a\nuntil Vertical flags has Move within 1s\n");
    assert!(line == 2 && text.contains("within 1000 ms"), "{line} {text}");
    let (line, _) = failure("case a\n\nexpect world jet on\n");
    assert_eq!(line, 3);
}

#[test]
fn what_cannot_be_read_names_its_line() {
    for (text, wrong) in [
        ("expect world jet on\n", 1),
        ("case a\nafter soon\nexpect world jet off\n", 2),
        ("case a\nexpect Vertical flags has Moved\n", 2),
        ("case a\n> Mov Vertical 10\n< …\n", 2),
        ("case a\n> Move Vertical 10\nafter 1s\n", 2),
        ("case a\n< Vertical Move → Ok\n", 2),
        ("case a\ninject fault teapot\nexpect world jet off\n", 2),
        ("case a\nstate asleep\nexpect world jet off\n", 2),
        ("case a\nafter 1s\n", 1),
        ("case a\nteapot\n", 2),
        ("case a\nwind calm\nexpect world jet off\n", 2),
        ("case a\npower off\nexpect world jet off\n", 2),
        ("case a\n> hex 4d zz\n< …\n", 2),
        ("case a\nafter 2h\nexpect world jet off\n", 2),
        ("case a\nend never\nexpect world jet off\n", 2),
    ] {
        assert_eq!(failure(text).0, wrong, "{text}");
        let failed = Scenario::parse("t.txt", text).unwrap_err();
        let (english, russian) = (failed.of(Lang::En), failed.of(Lang::Ru));
        assert!(english.starts_with(&format!("t.txt:{wrong}: expected ")), "{english}");
        assert!(russian.starts_with(&format!("t.txt:{wrong}: ожидается ")), "{russian}");
        let expected = failed.expected.of(Lang::Ru);
        assert!(expected.chars().any(|it| ('а'..='я').contains(&it)), "{text}: {expected}");
    }
}
