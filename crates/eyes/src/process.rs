//! The process of one camera, from its start to its end.

use std::io::{self, Read};
use std::process::ExitCode;

use tokio::io::AsyncWrite;
use tokio::runtime::Builder;

use crate::camera::{say, watch};
use crate::wire::{Said, Settings};

/// Where memory runs out, the system takes that of this process first.
const FIRST_TO_GO: &str = "700";

/// Watches the camera that standard input names, and writes what it sends to standard output. Ends with either of them,
/// and when the camera fails.
pub fn run() -> ExitCode {
    // Elsewhere than on Linux there is no such file.
    _ = std::fs::write("/proc/self/oom_score_adj", FIRST_TO_GO);
    let Ok(settings) = Settings::read(&mut io::stdin().lock()) else { return ExitCode::FAILURE };
    // A thread, so that a parser that goes round in circles does not outlive the hub.
    let watched = std::thread::Builder::new().spawn(|| {
        let mut rest = [0; 64];
        while io::stdin().lock().read(&mut rest).is_ok_and(|len| len > 0) {}
        std::process::exit(0);
    });
    let runtime = Builder::new_current_thread().enable_all().build();
    let (Ok(_), Ok(runtime)) = (watched, runtime) else { return ExitCode::FAILURE };
    match runtime.block_on(to_its_end(&settings, &mut tokio::io::stdout())) {
        Ok(()) => ExitCode::SUCCESS,
        Err(_) => ExitCode::FAILURE,
    }
}

async fn to_its_end(settings: &Settings, to: &mut (impl AsyncWrite + Unpin)) -> io::Result<()> {
    let fault = watch(settings, to).await?;
    say(to, &Said::Fault(fault)).await
}
