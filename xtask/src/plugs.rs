//! `cargo xtask plugs`: other protocols, with clients and brokers that are not ours.

use std::path::PathBuf;
use std::process::{Command, ExitCode};

use crate::run::{StepResult, TestProgram, cargo, output, root, shown_tests, test_programs};
use crate::test::pass_alone;
use crate::{TaskResult, flag, setup};

/// What Python has of Modbus, on this side and that, of MQTT, of OPC UA and of recordings, and what Home Assistant checks
/// its messages with.
const PACKAGES: [&str; 8] = [
    "asyncua==2.1.0",
    "cryptography==50.0.2",
    "mcap==1.6.0",
    "pymodbus==3.16.1",
    "pyserial==3.5",
    "paho-mqtt==2.1.0",
    "voluptuous==0.16.0",
    "Jinja2==3.1.6",
];

/// A host application of Sparkplug B. It wants an older paho-mqtt, so it has an environment of its own.
const SPARKPLUG: [&str; 3] = ["pysparkplug==0.6.1", "paho-mqtt==1.6.1", "protobuf==7.36.2"];

/// A client of OPC UA that is not made in Python.
const NODE: [&str; 1] = ["node-opcua-client@2.186.4"];

pub fn plugs(arguments: &[String]) -> TaskResult {
    flag(arguments, None)?;
    check().map(|()| ExitCode::SUCCESS)
}

/// Runs the tests that need programs of others, which are installed if permitted.
pub fn check() -> StepResult {
    let programs = setup::python("plug-tools", &PACKAGES)?;
    let host = setup::python("sparkplug-tools", &SPARKPLUG)?.join("python3");
    let modules = setup::node("plug-modules", &NODE)?;
    setup::program("mbpoll", "mbpoll")?;
    setup::found("mosquitto", "mosquitto")?;
    setup::found("mosquitto_sub", "mosquitto-clients")?;
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::iter::once(programs).chain(std::env::split_paths(&path));
    let path = std::env::join_paths(folders).map_err(|e| e.to_string())?;
    let messages = all_tests()?;
    for folder in ["crates/hub", "crates/cli"] {
        let program = tests_of(&messages, folder)?;
        let run = |arguments: &[&str]| {
            let mut tests = Command::new(&program);
            tests.arg("--ignored").args(arguments).current_dir(root().join(folder));
            tests.env("PATH", &path).env("NODE_PATH", &modules);
            shown_tests(tests.env("LAFET_SPARKPLUG_PYTHON", &host))
        };
        if let Err((error, failed)) = run(&["foreign::"]) {
            let alone = |name: &str| run(&["--exact", name]).is_ok();
            if !pass_alone(&format!("it of {folder}"), &failed, alone) {
                return Err(error);
            }
        }
    }
    Ok(())
}

/// Builds all tests; returns what cargo says. Those of one crate would be built again with fewer features.
pub fn all_tests() -> Result<String, String> {
    output(&mut cargo(&["test", "--workspace", "--no-run", "--message-format=json"]))
}

/// The program of a crate's integration tests, from what cargo says of a build.
pub fn tests_of(messages: &str, folder: &str) -> Result<PathBuf, String> {
    let package = format!("/{folder}#");
    let it = |test: &TestProgram| test.package.contains(&package) && test.name == "it";
    let program = test_programs(messages).find(it).map(|test| test.path);
    program.ok_or_else(|| format!("{folder} has no tests of the name `it`"))
}
