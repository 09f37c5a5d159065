use std::sync::Arc;

use super::*;

const HEAD: &str = "
[scenario]
title = { en = \"a\", ru = \"б\" }
about = { en = \"a\", ru = \"б\" }
duration = \"20s\"
";
const MONITOR: &str = "
[[monitor]]
name = \"M1\"
at = [0, 0]
profile = \"remote\"
";
const EXPECT: &str = "
[[expect]]
text = { en = \"calm\", ru = \"тихо\" }
never = \"world jet on\"
";

fn problem(text: &str) -> Problem {
    Exercise::parse("x.toml", text).expect_err(text)
}

fn outcome(rest: &str) -> Outcome {
    let exercise = Exercise::parse("x.toml", &format!("{HEAD}{MONITOR}{EXPECT}{rest}"));
    run(&Arc::new(exercise.expect(rest)), 7, false)
}

fn failed(outcome: &Outcome) -> Vec<&str> {
    let failed = outcome.checks.iter().filter(|check| !check.passed);
    failed.map(|check| check.text.en.as_str()).collect()
}

/// What is appended to a scenario, the line and the key that are named, and words of the message.
const MISTAKES: &[(&str, usize, &str, &str)] = &[
    ("[[fire]]\nname = \"F\"\nat = [1, 2]\nsize = 900", 19, "fire.size", "0.2 … 60"),
    (
        "[[fire]]\nname = \"F\"\nat = [1, 2]\nsize = 1\nclass = \"gas\"",
        20,
        "fire.class",
        "solid, hydrocarbon",
    ),
    ("[foam]\ndrains = \"2s\"", 17, "foam.drains", "from 10 s to 1 h"),
    ("[foam]\nexpansion = 1", 17, "foam.expansion", "2 … 20"),
    ("[[fire]]\nname = \"F\"\nat = [1]\nsize = 1", 18, "fire.at", "2 numbers"),
    ("[[fire]]\nname = \"F\"\nsize = 1", 16, "fire.at", "on = "),
    ("[[fire]]\nname = \"F F\"\nat = [1, 2]\nsize = 1", 17, "fire.name", "without blanks"),
    ("[[monitor]]\nname = \"M1\"\nat = [1, 1]", 17, "monitor.name", "already"),
    ("[[monitor]]\nname = \"M2\"\nat = [1, 1]\naddress = 1", 19, "monitor.address", "M1"),
    (
        "[[monitor]]\nname = \"M2\"\nat = [1, 1]\nprofile = \"fulll\"",
        19,
        "monitor.profile",
        "full, remote",
    ),
    ("[[monitor]]\nname = \"M2\"\nat = [1, 1]\nhight = 2", 19, "monitor.hight", "height"),
    (
        "[[monitor]]\nname = \"M2\"\nat = [1, 1]\nset = \"Vertical Speed 0\"",
        19,
        "monitor.set",
        "InvalidValue",
    ),
    ("[[event]]\nat = \"1s\"\ninject = \"vertical-teapot\"", 18, "event.inject", "vertical-jam"),
    ("[[event]]\nat = \"1 hour\"\ninject = \"vertical-jam\"", 17, "event.at", "1.5min"),
    ("[[event]]\nat = \"1s\"", 16, "event", "inject"),
    ("[[event]]\ninject = \"vertical-jam\"", 16, "event.at", "when"),
    ("[[event]]\nat = \"1s\"\nradio = \"gone\"", 18, "event.radio", "up, lost, answers-lost"),
    ("[[operator]]\nat = \"1s\"\nsend = \"Opn Valve1\"", 18, "operator.send", "request"),
    ("[[operator]]\nafter = \"x\"\nsend = \"Stop All\"", 17, "operator.after", "`x`"),
    (
        "[[operator]]\nwhen = \"Detector Fond\"\nsend = \"Stop All\"",
        17,
        "operator.when",
        "condition",
    ),
    (
        "[[operator]]\nwhen = \"Deployer Deployed\"\nsend = \"Stop All\"",
        17,
        "operator.when",
        "Deployer",
    ),
    (
        "[[fire]]\nname = \"F\"\nat = [1, 2]\nsize = 1\n[[operator]]\n\
         when = \"not fire F gonee\"\nsend = \"Stop All\"",
        21,
        "operator.when",
        "`gonee` is none of burning, out, unlit",
    ),
    (
        "[[operator]]\nwhen = \"not Vertical Mvoe\"\nsend = \"Stop All\"",
        17,
        "operator.when",
        "`Mvoe` is no flag of Vertical; did you mean `Move`?",
    ),
    ("[[operator]]\nwhen = \"fire F out\"\nsend = \"Stop All\"", 17, "operator.when", "`F`"),
    ("[[expect]]\ntext = { en = \"a\" }\nthat = \"time > 1\"", 17, "expect.text.ru", "missing"),
    ("[[expect]]\ntext = { en = \"a\", ru = \"a\" }", 16, "expect.that", "never"),
    ("[expekt]\na = 1", 16, "expekt", "expect"),
    ("a = ", 16, "", "TOML"),
];

/// What is appended as in [`MISTAKES`]: words that would do nothing.
const WITHOUT_EFFECT: &[(&str, usize, &str, &str)] = &[
    ("[[operator]]\nsend = \"Stop All\"\nanswer = \"OK\"", 18, "operator.answer", "none, Ok"),
    (
        "[[operator]]\nsend = \"Stop All\"\nanswer = \"Denied (Deploier)\"",
        18,
        "operator.answer",
        "`Deploier` is not known here; allowed: ExtButtons",
    ),
    (
        "[[operator]]\nsend = \"Stop All\"\nrepeat = \"2s\"\nanswer = \"none\"",
        19,
        "operator.answer",
        "repeated until it is answered",
    ),
    (
        "[[event]]\nat = \"1s\"\nwind = 2\nmonitor = \"M1\"",
        19,
        "event.monitor",
        "no effect without inject",
    ),
    ("[[event]]\nat = \"1s\"\nwind = 2\npercent = 5", 19, "event.percent", "without supply"),
    ("[[event]]\nat = \"1s\"\nwind = 2\ninject = []", 19, "event.inject", "empty list"),
    ("[[event]]\nat = \"1s\"\nwind_from = 90", 18, "event.wind_from", "without wind"),
    ("[weather]\nwind_from = 90", 17, "weather.wind_from", "without wind"),
    ("[[event]]\nat = \"21s\"\nwind = 2", 17, "event.at", "ends at  0:20.0"),
    ("[[event]]\nat = \"1s\"\ndelay = \"20s\"\nwind = 2", 18, "event.delay", "ends at  0:20.0"),
    ("[[event]]\nname = \"a\"\nafter = \"a\"\nwind = 2", 18, "event.after", "waits for itself"),
    (
        "[[event]]\nname = \"a\"\nafter = \"b\"\nwind = 2\n\
         [[event]]\nname = \"b\"\nafter = \"a\"\nwind = 2",
        18,
        "event.after",
        "waits for itself",
    ),
    ("[[event]]\nat = \"1s\"\ninject = \"deployer-jam\"", 18, "event.inject", "M1 has no Deployer"),
    (
        "[[event]]\nat = \"1s\"\ninject = \"vertical-unit-offline\"",
        18,
        "event.inject",
        "no remote unit of M1",
    ),
    ("[[event]]\nat = \"1s\"\nclear = \"vertical-jam\"", 18, "event.clear", "nothing to undo"),
    ("[[event]]\nat = \"1s\"\nrelease = \"buttons up\"", 18, "event.release", "nothing to undo"),
    ("[[controller]]\nat = \"1s\"", 16, "controller", "M1 has no Detector"),
    (
        "[[expect]]\ntext = { en = \"a\", ru = \"a\" }\nthat = \"time > 1\"\nuntil = \"5s\"",
        19,
        "expect.until",
        "no effect beside that",
    ),
    (
        "[[expect]]\ntext = { en = \"a\", ru = \"a\" }\nthat = \"time > 1\"\nat = \"5s\"\nby = \"6s\"",
        20,
        "expect.by",
        "no effect beside at",
    ),
    (
        "[[expect]]\ntext = { en = \"a\", ru = \"a\" }\nnever = \"time < 0\"\nwithin = \"5s\"",
        19,
        "expect.within",
        "no effect beside never",
    ),
    (
        "[[expect]]\ntext = { en = \"a\", ru = \"a\" }\nthat = \"time is 5\"",
        18,
        "expect.that",
        "too many words",
    ),
    (
        "[[expect]]\ntext = { en = \"a\", ru = \"a\" }\nthat = \"fires burning now = 0\"",
        18,
        "expect.that",
        "too many words",
    ),
    (
        "[[expect]]\ntext = { en = \"a\", ru = \"a\" }\nthat = \"Vertical position < inf\"",
        18,
        "expect.that",
        "a number is expected",
    ),
    (
        "[[expect]]\ntext = { en = \"a\", ru = \"a\" }\nnever = \"Buttons UpButtonState=Shrot\"",
        18,
        "expect.never",
        "did you mean `Short`",
    ),
    (
        "[[expect]]\ntext = { en = \"a\", ru = \"a\" }\nnever = \"Vertical flags has none\"",
        18,
        "expect.never",
        "`none` has to be alone",
    ),
    ("[foam]\nexpansion = 5", 16, "foam", "without Valve2"),
    (
        "[[supply]]\nname = \"S\"\npressure = 1\nat_flow = 40\npressure_at_flow = 0.8",
        17,
        "supply.name",
        "no monitor",
    ),
    (
        "[[monitor]]\nname = \"M2\"\nat = [1, 1]\nprofile = \"remote\"\nmisalignment = [3, 3]",
        20,
        "monitor.misalignment",
        "without Detector",
    ),
    ("[[monitor]]\nname = \"M2\"\nat = [1, 1]\naddress = 1.5", 19, "monitor.address", "whole"),
    (
        "[[monitor]]\nname = \"M2\"\nat = [1, 1]\n\
         set = \"Vertical Speed 50 ; Horizontal Speed 0\"",
        19,
        "monitor.set",
        "InvalidValue",
    ),
    (
        "[[fire]]\nname = \"F\"\nat = [1, 2]\nsize = 1\nlit = \"21s\"",
        20,
        "fire.lit",
        "ends at  0:20.0",
    ),
];

/// Each mistake is reported with file, line, key, and what is allowed, in both languages.
#[test]
fn mistakes_are_told() {
    let with = |rest: &str| problem(&format!("{HEAD}{MONITOR}{EXPECT}{rest}"));
    for &(rest, line, key, words) in MISTAKES.iter().chain(WITHOUT_EFFECT) {
        let problem = with(rest);
        let line = line - 1;
        assert_eq!((problem.line, problem.key.as_str()), (line, key), "{rest}: {problem}");
        assert!(problem.what.en.contains(words), "{rest}: {problem}");
        let russian = problem.told(Lang::Ru);
        assert!(russian.starts_with(&format!("x.toml:{line}: ")), "{russian}");
        assert!(russian.chars().any(|c| ('а'..='я').contains(&c)), "{russian}");
    }
    let nothing = problem(&format!("{HEAD}{MONITOR}"));
    assert!(nothing.what.en.contains("expects nothing"), "{nothing}");
}

/// Every rule of expectation can hold and can fail.
#[test]
fn rules() {
    let text = |name: &str, rule: &str| {
        format!("[[expect]]\ntext = {{ en = \"{name}\", ru = \"{name}\" }}\n{rule}\n")
    };
    let action = "[[event]]\nname = \"later\"\nat = \"5s\"\ninject = \"pressure-break\"\n\
                  [[operator]]\nat = \"10s\"\nsend = \"Open Valve1\"\nanswer = \"Denied\"\n\
                  [[operator]]\nname = \"never\"\nat = \"30s\"\nsend = \"Stop All\"\n";
    let broken = "General PressureSensorBreak";
    let rules = [
        ("by", format!("that = \"{broken}\"\nby = \"6s\"")),
        ("by-not", format!("that = \"{broken}\"\nby = \"4s\"")),
        ("within", format!("that = \"{broken}\"\nafter = \"later\"\nwithin = \"1s\"")),
        ("within-not", "that = \"time > 9\"\nafter = \"later\"\nwithin = \"1s\"".into()),
        ("at", format!("that = \"not {broken}\"\nat = \"3s\"")),
        ("at-not", format!("that = \"{broken}\"\nat = \"3s\"")),
        ("end", format!("that = \"{broken}\"")),
        ("end-not", format!("that = \"not {broken}\"")),
        ("always", format!("always = \"{broken}\"\nfrom = \"6s\"")),
        ("always-not", format!("always = \"{broken}\"\nfrom = \"4s\"")),
        ("never-until", format!("never = \"{broken}\"\nuntil = \"later\"")),
        ("never-not", format!("never = \"{broken}\"")),
        ("mark-not", "always = \"time >= 0\"\nfrom = \"never\"".into()),
    ];
    let rules: String = rules.iter().map(|(name, rule)| text(name, rule)).collect();
    let outcome = outcome(&format!("{action}{rules}"));
    assert_eq!(
        failed(&outcome),
        [
            "M1: Open Valve1 → Denied",
            "M1: Stop All",
            "calm",
            "by-not",
            "within-not",
            "at-not",
            "end-not",
            "always-not",
            "never-not",
            "mark-not",
        ]
    );
    assert!(!outcome.passed());
}

/// A lost link: no answer and nothing done; lost answers: done all the same; a monitor without
/// power answers no request.
#[test]
fn links_and_power() {
    let step = |at: &str, send: &str, answer: &str| {
        format!("[[operator]]\nat = \"{at}\"\nsend = \"{send}\"\nanswer = \"{answer}\"\n")
    };
    let event = |at: &str, what: &str| format!("[[event]]\nat = \"{at}\"\n{what}\n");
    let expect = |text: &str, that: &str, at: &str| {
        format!(
            "[[expect]]\ntext = {{ en = \"{text}\", ru = \"{text}\" }}\nthat = \"{that}\"\nat = \"{at}\"\n"
        )
    };
    let outcome = outcome(
        &[
            event("1s", "external = \"lost\""),
            step("2s", "Move Vertical 600", "none"),
            expect("still", "output vertical = 0", "3s"),
            event("4s", "external = \"answers-lost\""),
            step("5s", "Move Vertical 600", "none"),
            expect("moves", "output vertical > 0", "6s"),
            event("9s", "external = \"up\"\npower = \"off\""),
            step("10s", "GetStatus Vertical", "none"),
            event("11s", "power = \"on\""),
            step("12s", "Move Vertical 0", "Accepted"),
            expect("back", "Vertical Move", "13s"),
        ]
        .concat(),
    );
    assert_eq!(failed(&outcome), [""; 0], "{}", text(&outcome, Lang::En));
    let counts = outcome.monitors[0].counts;
    assert_eq!((counts.requests, counts.unanswered, counts.accepted), (4, 3, 1));
    assert_eq!(outcome.monitors[0].restarts, 1);
}

/// Every scenario that comes with lafet holds, within its time, and is the same for a seed.
#[test]
fn shipped_scenarios_hold() {
    for shipped in SHIPPED {
        let exercise = Arc::new(shipped.exercise().expect(shipped.name));
        let outcome = run(&exercise, exercise.site.seed, false);
        let report = text(&outcome, Lang::En);
        assert!(outcome.passed(), "{}\n{report}", shipped.name);
        assert!(outcome.checks.len() >= 5, "{}", shipped.name);
        for lang in [Lang::En, Lang::Ru] {
            let picture = svg(&outcome, lang);
            assert!(picture.ends_with("</svg>\n") && !picture.contains("NaN"), "{}", shipped.name);
            assert!(picture.contains(outcome.exercise.title.of(lang)), "{}", shipped.name);
        }
        assert_eq!(json(&outcome)["passed"], true);
    }
}

/// What a scenario expects can fail: without its remedy it does.
#[test]
fn shipped_scenarios_can_fail() {
    for (name, from, to, expected) in [
        (
            "tank-farm",
            "send = \"Open Valve1\"",
            "send = \"Close Valve1\"",
            "T-2 never catches fire",
        ),
        // Water instead of foam: the petrol burns on.
        (
            "tank-farm",
            "send = \"Open Valve2\"",
            "send = \"Open Valve1\"",
            "T-1 is out within 2½ minutes of the first foam",
        ),
        (
            "hangar",
            "valve = \"Valve2\"",
            "valve = \"Valve1\"",
            "the spill is out within 90 s of the alarm",
        ),
        ("hangar", "height = 4.5", "height = 0.5", "the fuselage hides the fire from M1"),
        (
            "turbine-hall",
            "ignore = [[-30, -4]]",
            "",
            "the barrel never extinguishes on the side of the casing",
        ),
        (
            "jammed-drive",
            "horizontal-jam",
            "horizontal-speed-dead",
            "the overload is reported within 1.5 s",
        ),
        (
            "lost-pressure",
            "percent = 10\n",
            "percent = 100\n",
            "M1 reports TrajectoryPressureFault within 5 s",
        ),
        (
            "radio-loss",
            "radio = \"lost\"",
            "radio = \"up\"",
            "water is not stopped by the lost radio",
        ),
    ] {
        let shipped = Shipped::by_name(name).expect(name);
        let changed = shipped.text.replace(from, to);
        assert_ne!(changed, shipped.text, "{name}: nothing to change");
        let exercise = Arc::new(Exercise::parse(name, &changed).expect(name));
        let outcome = run(&exercise, exercise.site.seed, false);
        assert!(failed(&outcome).contains(&expected), "{name}:\n{}", text(&outcome, Lang::En));
    }
}

/// The same seed, the same run; another one, another.
#[test]
fn a_run_follows_from_its_seed() {
    let exercise = Arc::new(Shipped::by_name("hangar").unwrap().exercise().unwrap());
    let short = Arc::new(Exercise { duration_ms: 60_000, ..(*exercise).clone() });
    let trace = |seed| run(&short, seed, true).trace;
    let first = trace(7);
    assert_eq!(first.lines().count(), 1_200);
    assert!(first == trace(7), "the same seed gives another run");
    assert!(first != trace(8), "the seed has no effect");
}
