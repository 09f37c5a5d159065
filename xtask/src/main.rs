//! The workspace's tasks: `cargo xtask <task>`. Each law of ARCHITECTURE.md that a machine can
//! check is checked from here.

mod api;
mod bench;
mod bindings;
mod c_header;
mod ci;
mod citation;
mod console;
mod coverage;
mod crates;
mod cuts;
mod demo;
mod dissector;
mod dist;
mod docs;
mod elf;
mod faults;
mod firmware;
mod fuzz;
mod hub;
mod late;
mod laws;
mod layers;
mod licences;
mod links;
mod metadata;
mod mutants;
mod no_std;
mod package;
mod physics;
mod pictures;
mod playground;
mod plugs;
mod python;
mod run;
mod sections;
mod semver;
mod setup;
mod size;
mod source;
mod spec;
mod stack;
mod stops;
mod tables;
mod test;
mod texts;
mod thumb;
mod verify;
mod website;
mod words;

use std::process::ExitCode;

/// Result of a task: an exit code, or an error text that says what to do.
type TaskResult = Result<ExitCode, String>;

struct Task {
    name: &'static str,
    arguments: &'static str,
    about: &'static str,
    details: &'static str,
    run: fn(&[String]) -> TaskResult,
}

const TASKS: &[Task] = &[
    Task {
        name: "demo",
        arguments: "[arguments of `lafet demo`…]",
        about: "build lafet and watch a simulated monitor extinguish a fire",
        details: "Ctrl-C and the exit code pass through. Arguments: cargo xtask demo --help",
        run: demo::demo,
    },
    Task {
        name: "test",
        arguments: "",
        about: "all tests, the matrix of the protocol, the layers and the documentation",
        details: "The test command of the README.",
        run: test::test,
    },
    Task {
        name: "ci",
        arguments: "[STEP…]",
        about: "everything a change must pass: format, lints, licences, no_std, tests, demo",
        details: "What .ci/run calls. Every step runs, even after one that failed; with names, \
                  only those: console, lock, licences, words, fmt, build, test, python, plugs, api, browser, playground, dist, \
                  no-std, firmware, clippy, doc, website, package, model, dissector, bindings, bench, update, swarm, hub, demo.",
        run: ci::ci,
    },
    Task {
        name: "spec",
        arguments: "[--check]",
        about: "the matrix § × code × test",
        details: "Sections come from crates/conform/src/spec.txt. Code is cited in comments of \
                  proto and device; tests in test code and in conformance/scenarios. With --check, fails on \
                  a section without code or test and on a citation of a section that does not \
                  exist.",
        run: spec::spec,
    },
    Task {
        name: "layers",
        arguments: "",
        about: "the dependencies between the crates and the laws that text can show",
        details: "The allowed dependencies are in xtask/src/layers.rs, the laws in laws.rs.",
        run: layers::layers,
    },
    Task {
        name: "docs",
        arguments: "[--check | --tables]",
        about: "write the generated tables of docs/protocol.md and docs/protocol.ru.md; check links",
        details: "The tables come from `lafet schema`. With --check, nothing is written: a table \
                  that is out of date is an error. With --tables, no pictures are made.",
        run: docs::docs,
    },
    Task {
        name: "pictures",
        arguments: "",
        about: "the moving picture of the READMEs: docs/images/fire.svg, docs/images/fire.ru.svg",
        details: "Runs the demonstration once for each frame. The pictures of scenarios are \
                  written by `cargo xtask docs`, those of the console by `cargo xtask console \
                  pictures`.",
        run: pictures::pictures,
    },
    Task {
        name: "website",
        arguments: "[--check | serve]",
        about: "the documentation as a site with search: website/dist",
        details: "Built from docs/, with the help of every command as lafet prints it. It works \
                  below any address of any file server, without a network. With --check, its \
                  links, search, appearance and print are tested, in Chromium. serve shows it at \
                  http://127.0.0.1:8490.",
        run: website::website,
    },
    Task {
        name: "faults",
        arguments: "[--check]",
        about: "how each flag and status is reached, and how soon it shows: docs/faults.md, docs/faults.ru.md",
        details: "Runs every row of conformance/faults.txt in the simulator, prints the table and \
                  writes it. With --check, nothing is written: a flag without a row, a failing row \
                  and an outdated table are errors.",
        run: faults::faults,
    },
    Task {
        name: "cuts",
        arguments: "store|monitor [N]",
        about: "N random power cuts (a million without N) of the store, or of whole monitors",
        details: "Optimised, on all cores. LAFET_STORE_SEED or LAFET_MONITOR_SEED is the first \
                  seed; a failure prints the one that replays it.",
        run: cuts::cuts,
    },
    Task {
        name: "physics",
        arguments: "[--check]",
        about: "the models beside published figures, and the monitor's aim: docs/physics.md",
        details: "Computes every table of docs/physics.md in the simulator, prints and writes it. \
                  With --check, nothing is written: a table that is out of date is an error.",
        run: physics::physics,
    },
    Task {
        name: "late",
        arguments: "[EXCHANGES] | --processes [PROCESSES]",
        about: "the client against late and duplicate answers, 10 million times: none is accepted",
        details: "Seconds of virtual time in which answers are lost, come up to 30 s late, or \
                  twice. --processes: a session for each operation, on a medium that still carries \
                  answers to the previous one. The figures of a run are in docs/client.md.",
        run: late::late,
    },
    Task {
        name: "console",
        arguments: "build | check | api | browser | pictures | measure | monkey",
        about: "the operator's console: build it, check it, test it in a browser, take screenshots",
        details: "build makes console/dist, which is built into the hub. check is types and unit \
                  tests. api generates the types of the hub's API from docs/schema/hub-1.json. \
                  browser drives Chromium against the release build of lafet with simulated \
                  monitors. pictures takes those of the pages. measure: first paint, shifts of \
                  the layout, work on live data, memory; its figures are in docs/console.md. \
                  monkey clicks, drags and types at random.",
        run: console::console,
    },
    Task {
        name: "playground",
        arguments: "[--check]",
        about: "the protocol in a web page, with the simulator as WebAssembly: playground/dist",
        details: "Any file server can serve the folder. Fails when its files have more than 600 kB after gzip. \
                  --check also tests it: natively, WebAssembly against the native program, and in Chromium.",
        run: playground::playground,
    },
    Task {
        name: "api",
        arguments: "",
        about: "the hub's API against its description, by schemathesis",
        details: "Runs lafet demo and sends it, for 30 s, requests that the description allows and \
                  others. Installs schemathesis below target.",
        run: api::api,
    },
    Task {
        name: "hub-load",
        arguments: "[--quick | --long | --large | --flood KIND]",
        about: "the hub under load and failures: garbage, storms, a full disk, kill -9, floods",
        details: "Runs lafet serve with simulated monitors. Fails when a Stop is not through \
                  within 100 ms (99 of 100), when an entry of the audit log is lost or its chain \
                  broken; then floods it with every kind of message, and fails when Stops of \
                  others are late, memory grows, or a kind is never answered as it has to be. The \
                  figures of a run are in docs/hub.md. With --quick, less of everything: part of \
                  cargo xtask ci. --long: only the floods, a minute of each kind from 1 and from \
                  200 connections, some hours. --large: only the floods, beside 240 monitors in 64 \
                  zones. --flood KIND: only kinds whose names contain this, \
                  each for 60 s from 1 and 200 connections in every manner.",
        run: hub::load,
    },
    Task {
        name: "firmware",
        arguments: "build | test [--seeds N] [--steps N] | load | run [OPTIONS OF lafet sim] | \
                    images VERSION FOLDER [--key N=FILE] | update [--quick] | board | iron | wrong | fire | serve [PORT] | \
                    provision [OPTIONS]",
        about: "the monitor's program on a Cortex-M3: build it, test it on the emulated chip, run it",
        details: "build links the program for each board of firmware/, which fails when a panic \
                  can be reached. test runs it in QEMU beside the same monitor on the host, with \
                  the same inputs and requests: every answer and every output must be the same; \
                  then it lets the program crash and reads its crash data. load counts the \
                  instructions of steps and answers while it extinguishes a fire, and fails when a step takes too many. run serves it in \
                  a simulated plant. images makes the bootloader of the board mps2 and signed images of \
                  its program, for lafet sim --on qemu --boot and lafet update: docs/update.md. update \
                  updates that board over its link while lines are cut and power fails, with --quick once, as in CI. board tests the board stm32f103 in the model of its chip, and \
                  boards with one defect each; iron sends its barrels to and fro behind every \
                  combination of lag, stiction and play; wrong prints which check notices each of them \
                  first, where the list differs; fire extinguishes a fire with it over TCP; \
                  serve opens it at a port. provision writes the flash image of a new board: \
                  docs/board-stm32f103.md.",
        run: firmware::firmware,
    },
    Task {
        name: "size",
        arguments: "[--check]",
        about: "flash and RAM of the firmware, by board and crate: docs/footprint.md",
        details: "Fails over its limits. With --check nothing is written.",
        run: size::size,
    },
    Task {
        name: "bench",
        arguments: "[--check | --only PART]",
        about: "lafet and its peers, measured side by side: docs/performance.md",
        details: "Parts: codec, roundtrip, sim, capture, footprint. Installs the measuring tools \
                  if permitted. With --check nothing is written: instruction counts that have \
                  drifted by more than 3 % are an error.",
        run: bench::bench,
    },
    Task {
        name: "bindings",
        arguments: "[--header]",
        about: "lafet for C: builds it for host and Cortex-M3, and tests it under valgrind",
        details: "Checks that the header matches the library, runs the golden vectors, and lets \
                  the C controller move the C monitor. Installs missing tools if permitted. With \
                  --header it writes the header.",
        run: bindings::bindings,
    },
    Task {
        name: "python",
        arguments: "[--release]",
        about: "lafet for Python: builds the wheel, installs and tests it",
        details: "Checks the types with mypy and runs the tests on the package as it is installed, in an \
                  environment below target. With --release the wheel is optimised.",
        run: python::python,
    },
    Task {
        name: "plugs",
        arguments: "",
        about: "Modbus with pymodbus and mbpoll, which it installs if permitted",
        details: "The hub's server against masters of others, and its detectors and outputs against a server of \
                  others: over TCP and over a pseudo-terminal. A recording of a recorder that was killed, read by \
                  the Python library of MCAP.",
        run: plugs::plugs,
    },
    Task {
        name: "swarm",
        arguments: "--hours N | --minutes N | --seeds A..B | --pairs N [--from SEED] [--threads N]",
        about: "random lives of simulated monitors; every change of an output must be explained",
        details: "Seeds × profiles × faults × requests on all cores, each step under the check of \
                  lafet_verify::attribution. Fails on an output without a valid cause, on a broken \
                  invariant, and in a run of 1400 seeds or more on a behaviour never seen. A \
                  failure names its seed: cargo xtask replay SEED shows it. With --pairs each pair of \
                  faults is in force together in a short life of its own, in N rounds.",
        run: verify::swarm,
    },
    Task {
        name: "replay",
        arguments: "SEED [--from SECONDS] [--to SECONDS]",
        about: "a life of the swarm, step by step: requests, answers, outputs with their causes",
        details: "The same each time. Fails if the life ends in a failure.",
        run: verify::replay,
    },
    Task {
        name: "fuzz",
        arguments: "[target…] [--minutes N] [--merge]",
        about: "fuzz link, records, text, device, store and update with libFuzzer",
        details: "One minute each by default. Installs cargo-fuzz if it is missing. A failing \
                  input is kept in fuzz/artifacts; once fixed, it belongs in fuzz/regressions. \
                  With --merge, the committed corpus becomes the smallest that reaches all that \
                  has been reached.",
        run: fuzz::fuzz,
    },
    Task {
        name: "years",
        arguments: "[years] [seed]",
        about: "years in the life of a simulated monitor, checked continuously",
        details: "Ten years by default: docs/evidence-long-run.md describes them.",
        run: verify::years,
    },
    Task {
        name: "model",
        arguments: "[arguments of `lafet-verify model`…]",
        about: "check the interlock on every state that a request, a fault or time can lead to",
        details: "Prints states, unique states, depth and properties of each configuration; and \
                  for a law that can be broken the path to it. Without arguments about 12 minutes. \
                  Arguments: --list, --quick, --seconds S, --states N, --depth N, --threads N, and \
                  names of configurations. docs/model.md says what is checked and what is not.",
        run: verify::model,
    },
    Task {
        name: "stops",
        arguments: "[--cases N]",
        about: "a million Stops, Lockouts, resets and MoveTimeouts in the middle of everything",
        details: "Each time, outputs are off in the next step. Optimised, on all cores. \
                  LAFET_STOP_SEED is the first seed; a failure names the one that replays it. \
                  50,000 cases are part of cargo xtask test. The figure of a run is in \
                  docs/evidence-proof.md.",
        run: stops::stops,
    },
    Task {
        name: "coverage",
        arguments: "[--check]",
        about: "the lines and branches of lafet-device that its own tests reach",
        details: "Needs llvm-cov of the compiler's LLVM: rustup's llvm-tools or Debian's package, \
                  which it installs if permitted. Branches need RUSTC_BOOTSTRAP, set for this \
                  build alone. With --check, fails on a line or branch of guard.rs or chain.rs \
                  that is not reached.",
        run: coverage::coverage,
    },
    Task {
        name: "mutants",
        arguments: "[guard|chain|device|FILE…] [--minutes N] [--quick] [--shard K/N] [--apart K/N]",
        about: "mutation testing: changes to the device that none of its tests notices",
        details: "The mutants of cargo-mutants (installed if missing), woven into a copy of the \
                  device, so that it is built once. Fails on a survivor in guard.rs or chain.rs, \
                  and under 95 % of the device. xtask/mutants.toml explains those that change \
                  nothing. --minutes limits the time, --quick leaves out the tests that take \
                  minutes, --shard tries every Nth mutant, --apart every Nth of those that need a \
                  build each.",
        run: mutants::mutants,
    },
    Task {
        name: "licences",
        arguments: "",
        about: "the licences and sources of all dependencies against deny.toml",
        details: "Reads the same deny.toml that cargo-deny reads; needs no cargo-deny.",
        run: licences::licences,
    },
    Task {
        name: "words",
        arguments: "",
        about: "words that read translated, in prose, comments and texts",
        details: "xtask/words.txt has the words, what to write instead, and the areas that are free of \
                  them.",
        run: words::words,
    },
    Task {
        name: "package",
        arguments: "[--oldest]",
        about: "what the crates for other people's programs need to be published",
        details: "Manifests, licence files, READMEs whose examples are tested, no file that is read from \
                  outside of its package; the client's session without Tokio; each is packed as it \
                  would be published. With --oldest, they are also built with the oldest compiler \
                  that they name; rustup installs it.",
        run: package::package,
    },
    Task {
        name: "semver",
        arguments: "[REVISION]",
        about: "what the crates for other people's programs have changed in their interfaces",
        details: "Compares them with a revision, without one with the newest tag, by \
                  cargo-semver-checks, which is installed in target/tools. Fails on a change that \
                  the version does not allow. A step of a release, not of CI.",
        run: semver::semver,
    },
    Task {
        name: "dist",
        arguments: "[--release | --test | --quick | --twice | --state PROGRAM] [--arch amd64|arm64]… \
                    [--profile PROFILE] [--key FILE]",
        about: "what users install: static programs, Debian packages, images, and the test of them",
        details: "Makes target/dist-files/VERSION: programs without libraries of the system, packages, \
                  archives, container images, a bill of materials and SHA256SUMS, which --key signs with \
                  a secret key of minisign. --test installs, uses, upgrades, removes and purges them in a \
                  bare Debian; --quick does so with the program of the demo, as CI does. --release: \
                  both, from a commit without changes. --twice builds in two folders and compares. \
                  --state packs what a hub of a program leaves, for the tests of later versions.",
        run: dist::dist,
    },
    Task {
        name: "dissector",
        arguments: "",
        about: "test the Wireshark dissector in tshark, which it installs if permitted",
        details: "The dissector is what `lafet dissector` prints; it is run on the golden vectors.",
        run: dissector::dissector,
    },
    Task {
        name: "no-std",
        arguments: "",
        about: "build lafet-proto and lafet-device for a Cortex-M3",
        details: "Uses rustup's target, or Debian's compiler with its library sources.",
        run: no_std::no_std,
    },
];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match dispatch(&arguments) {
        Ok(code) => code,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

fn dispatch(arguments: &[String]) -> TaskResult {
    let Some((name, rest)) = arguments.split_first() else {
        eprint!("{}", overview());
        return Ok(ExitCode::from(2));
    };
    if matches!(name.as_str(), "help" | "-h" | "--help") {
        print!("{}", overview());
        return Ok(ExitCode::SUCCESS);
    }
    if name == test::RUN_EXAMPLE {
        return test::run_example(rest);
    }
    let Some(task) = TASKS.iter().find(|task| task.name == name) else {
        eprint!("error: no task `{name}`\n\n{}", overview());
        return Ok(ExitCode::from(2));
    };
    // The demo has its own help, with all its options.
    let asks_for_help = rest.iter().any(|a| a == "-h" || a == "--help");
    if asks_for_help && task.name != "demo" {
        println!(
            "cargo xtask {} {}\n\n{}.\n{}",
            task.name, task.arguments, task.about, task.details
        );
        return Ok(ExitCode::SUCCESS);
    }
    (task.run)(rest)
}

fn overview() -> String {
    let mut text = String::from("Tasks of the lafet workspace\n\nUsage: cargo xtask <task>\n\n");
    for task in TASKS {
        text += &format!("  {:<9} {}\n", task.name, task.about);
    }
    text += "\ncargo xtask <task> --help says more about one.\n";
    text
}

/// Parses the arguments of a task that has at most one flag.
fn flag(arguments: &[String], known: Option<&str>) -> Result<bool, String> {
    let mut given = false;
    for argument in arguments {
        if known != Some(argument.as_str()) {
            let hint = known.map_or("it takes none".into(), |flag| format!("it takes {flag}"));
            return Err(format!("unexpected argument `{argument}`: {hint}"));
        }
        given = true;
    }
    Ok(given)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_task_is_in_the_overview() {
        let text = overview();
        for task in TASKS {
            assert!(text.contains(&format!("\n  {}", task.name)), "{} is missing", task.name);
        }
    }

    #[test]
    fn flags_are_read_strictly() {
        let check = ["--check".to_string()];
        assert_eq!(flag(&check, Some("--check")), Ok(true));
        assert_eq!(flag(&[], Some("--check")), Ok(false));
        assert!(flag(&check, None).is_err());
        assert!(flag(&["--chekc".to_string()], Some("--check")).is_err());
    }
}
