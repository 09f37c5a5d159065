//! `cargo xtask api`: tests the hub's API against its description, with schemathesis.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, ExitCode, Stdio};

use crate::run::{StepResult, show, target};
use crate::{TaskResult, demo, flag, setup};

/// The version used for the figures in docs/hub.md.
const SCHEMATHESIS: &str = "schemathesis==4.32.5";
/// Duration of the generated requests, seconds.
const SECONDS: &str = "30";
/// Request rate; the hub allows a user 50 requests a second.
const RATE: &str = "40/s";
/// Properties of an answer that are checked against the description.
const CHECKS: &str = "status_code_conformance,content_type_conformance,response_schema_conformance";

pub fn api(arguments: &[String]) -> TaskResult {
    flag(arguments, None)?;
    check().map(|()| ExitCode::SUCCESS)
}

/// Sends a demo requests that the description allows, and ones that it does not.
pub fn check() -> StepResult {
    let schemathesis = setup::python("schemathesis", &[SCHEMATHESIS])?.join("schemathesis");
    let program = demo::program()?;
    // The demo would end if its output pipe were closed.
    let (mut demo, _printed, url) = serve(&program)?;
    let result = ask(&schemathesis, &url);
    // It may have ended already; the verdict is that of the requests.
    let _ = demo.kill();
    let _ = demo.wait();
    result
}

fn ask(schemathesis: &Path, url: &str) -> StepResult {
    let mut run = Command::new(schemathesis);
    run.args(["run", &format!("{url}/api/openapi.json"), "--phases", "coverage,fuzzing"]);
    // schemathesis leaves a folder in its working directory.
    run.current_dir(target());
    run.args(["-n", "5", "--max-time", SECONDS, "--rate-limit", RATE, "--seed", "7"]);
    run.args(["--checks", CHECKS, "--continue-on-failure", "--warnings", "off"]);
    // A WebSocket has no ordinary answer; password hashing is slow on purpose.
    run.args(["--exclude-path", "/api/ws", "--exclude-path-regex", "users|password|setup"]);
    show(&mut run)
}

fn serve(program: &Path) -> Result<(Child, BufReader<ChildStdout>, String), String> {
    let mut demo = Command::new(program)
        .args(["--lang", "en", "demo", "--port", "0", "--no-browser"])
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|e| format!("cannot run the demo: {e}"))?;
    let mut line = String::new();
    let mut stdout = BufReader::new(demo.stdout.take().ok_or("the demo has no output")?);
    stdout.read_line(&mut line).map_err(|e| e.to_string())?;
    let url = line.trim().to_owned();
    if url.starts_with("http://") {
        Ok((demo, stdout, url))
    } else {
        Err(format!("no address: {url}"))
    }
}
