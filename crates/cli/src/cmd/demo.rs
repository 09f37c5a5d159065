//! `lafet demo`: a tank farm with three simulated monitors and a fire, in the browser; in the
//! terminal, a simulated monitor finds a fire and puts it out.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use lafet_hub::Config;
use lafet_hub::text::Both;
use lafet_sim::fire::FireSpec;
use lafet_texts::{Text as _, cli as text};
use serde_json::json;
use tokio::task::JoinSet;

use crate::demo::{self, Options};
use crate::failure::{Failure, Outcome};
use crate::hub::training::Training;
use crate::hub::{Running, browse, log};
use crate::interrupt::Interrupt;
use crate::lang::current;
use crate::out::Out;
use crate::serve::{Listen, pace};
use crate::simulator;

/// Name of the scenario that the demo runs.
const SCENARIO: &str = "tank-farm";
/// The port of the console, if it is free.
const PORT: u16 = 8480;
/// Interval at which fires and jets are shown.
const SCENE: Duration = Duration::from_millis(200);
/// Every how many [`SCENE`] intervals the state of the exercise is shown.
const STATE_TICKS: u64 = 3;

/// Arguments of `lafet demo`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet demo\n  \
                        lafet demo --port 0 --no-browser\n  \
                        lafet demo --terminal\n  \
                        lafet demo --plain --speed 0 --fire az=-40,range=30,size=2\n  \
                        lafet demo --seed 3 --trace trace.txt")]
pub struct DemoArgs {
    #[arg(long, value_name = "PORT")]
    port: Option<u16>,
    #[arg(long)]
    no_browser: bool,
    #[arg(long)]
    terminal: bool,
    #[arg(long, value_name = "N", default_value_t = 7)]
    seed: u64,
    #[arg(
        long,
        value_name = "FACTOR",
        default_value_t = 1.0,
        value_parser = simulator::speed_or_zero
    )]
    speed: f64,
    #[arg(long)]
    plain: bool,
    #[arg(long, value_name = "FIRE", value_parser = simulator::fire)]
    fire: Vec<FireSpec>,
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    #[arg(long, value_name = "SECONDS", default_value_t = 60, requires = "picture")]
    picture_at: u64,
}

/// Runs `lafet demo`, in the browser or in the terminal.
pub async fn run(args: DemoArgs, out: &mut Out) -> Outcome {
    let terminal = args.terminal
        || args.plain
        || args.speed != 1.0
        || !args.fire.is_empty()
        || args.trace.is_some()
        || args.picture.is_some();
    if terminal { in_terminal(args, out).await } else { in_browser(args, out).await }
}

/// Runs a site, a hub and a browser; its monitors listen on a loopback port.
async fn in_browser(args: DemoArgs, out: &mut Out) -> Outcome {
    let mut interrupt = Interrupt::catch()?;
    let _log = log(out.json(), "warn")?;
    let bus = lafet_proto::bus::PORT_EXTERNAL_CONN;
    let listening = match Listen::tcp(format!("127.0.0.1:{bus}")).open().await {
        Ok(listening) => listening,
        Err(_) => Listen::tcp("127.0.0.1:0").open().await?,
    };
    let place = listening.url().to_owned();
    let cannot = |text: Both| Failure::Usage(text.of(current()).to_owned());
    let training = Training::new(SCENARIO, Some(args.seed), &place).map_err(cannot)?;
    let loaded = training.loaded().map_err(cannot)?;
    let mut tasks = JoinSet::new();
    tasks.spawn(listening.serve(training.clone()));
    let all = training.clone();
    tasks.spawn(async move {
        pace(all, 1.0).await;
        Ok(())
    });
    let config = |port| Config {
        listen: SocketAddr::from(([127, 0, 0, 1], port)),
        login: false,
        monitors: loaded.monitors.clone(),
        site: loaded.site.clone(),
        simulation: true,
        demo: true,
        ..Config::default()
    };
    let mut running = match (args.port, Running::start(config(args.port.unwrap_or(PORT))).await) {
        (None, Err(_)) => Running::start(config(0)).await?,
        (_, running) => running?,
    };
    running.hub().simulate(Box::new(training.clone()));
    say(&running, &place, out)?;
    if !args.no_browser {
        browse(running.url());
    }
    let mut ticks = tokio::time::interval(SCENE);
    for tick in 0_u64.. {
        tokio::select! {
            () = interrupt.wait() => break,
            failure = running.failed() => return Err(failure),
            _ = ticks.tick() => {}
        }
        running.hub().publish_scene(&training.scene());
        if tick.is_multiple_of(STATE_TICKS) {
            running.hub().publish_simulation();
        }
        for (monitor, text) in training.news() {
            running.hub().event(monitor.as_deref(), &text);
        }
    }
    running.end().await;
    Ok(())
}

/// Command lines to try next, quoted for a shell; `crates/cli/tests/it/try_next.rs` runs each one.
fn lines_to_try(url: &str, place: &str) -> Vec<String> {
    let monitor = format!("'{place}?addr=1'");
    vec![
        format!("lafet -c {monitor} status"),
        format!("lafet -c {monitor} record demo.pcapng --for 5"),
        "lafet decode demo.pcapng".into(),
        format!("curl {url}/api/monitors/M1"),
        format!("curl -X POST {url}/api/stop"),
        format!("curl -X POST {url}/api/sim/fire -d '{{\"at\":[5,-8]}}'"),
        format!(
            "curl -X POST {url}/api/sim/scenario -d '{{\"id\":\"hangar\",\"automatic\":true}}'"
        ),
    ]
}

/// Prints the URL of the console and what to try next.
fn say(running: &Running, place: &str, out: &mut Out) -> Outcome {
    let url = running.url();
    let lines = lines_to_try(url, place);
    let list: String = lines.iter().map(|line| format!("  {line}\n")).collect();
    let text = text::DemoRunning { url, list }.of(current());
    out.show(text, || {
        json!({
            "listening": url, "bus": place, "lang": format!("{:?}", current()), "try": lines,
        })
    })
}

async fn in_terminal(args: DemoArgs, out: &mut Out) -> Outcome {
    let summary = demo::run(Options {
        seed: args.seed,
        speed: args.speed,
        plain: args.plain,
        silent: out.json(),
        fires: args.fire,
        trace: args.trace,
        picture: args.picture.map(|path| (path, args.picture_at.saturating_mul(1000))),
    })
    .await?;
    out.show(format!("\n{}", summary.text()), || summary.json())
}
