//! Runs every scenario of `conformance/scenarios`, and checks that the runner itself can fail.

use std::fs;
use std::path::Path;

use lafet_sim::scenario::Scenario;

#[test]
fn all_scenarios_hold() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../conformance/scenarios");
    let mut files: Vec<_> = fs::read_dir(&folder)
        .expect("conformance/scenarios is there")
        .map(|entry| entry.expect("a readable folder").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "txt"))
        .collect();
    files.sort();
    assert!(!files.is_empty(), "no scenarios in {}", folder.display());
    let mut failures = Vec::new();
    for path in files {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let text = fs::read_to_string(&path).expect("a readable file");
        // Each case alone, so that one failure does not hide the others.
        match Scenario::parse(&name, &text) {
            Err(failure) => failures.push(failure.to_string()),
            Ok(Scenario { file, cases }) => {
                assert!(!cases.is_empty(), "{file} has no case");
                for case in cases {
                    let alone = Scenario { file: file.clone(), cases: vec![case] };
                    failures
                        .extend(alone.run(&mut |_| {}).err().map(|failure| failure.to_string()));
                }
            }
        }
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
    ] {
        assert_eq!(failure(text).0, wrong, "{text}");
    }
}
