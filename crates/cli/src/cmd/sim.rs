//! `lafet sim`: a simulated monitor that others can connect to.

use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::{Args, Subcommand};
use lafet_device::Composition;
use lafet_sim::fault::Fault;
use lafet_sim::fire::FireSpec;
use lafet_sim::flash::Flash;
use lafet_sim::radio::RadioConfig;
use lafet_sim::sim::{Config, Software, SoftwareFlash, Trial};
use lafet_texts::{Shown, Text as _, cli as text};
use lafet_update::BoardName;
use tokio::task::JoinSet;
use tokio::time::sleep;

use crate::cmd::exercise;
use crate::cmd::image::{Numbered, board, numbered, public_key};
use crate::failure::{Failure, Outcome};
use crate::interrupt::Interrupt;
use crate::lang::current;
use crate::out::Out;
use crate::serve::{Air, Listen, Paced, Shared};
use crate::simulator;
use crate::surroundings::Surroundings;
use crate::whole::Whole;

/// Interval at which changed memory is written to its file.
const KEEP: Duration = Duration::from_millis(500);

/// Simulated time that the monitor gets to finish at the end, ms.
const LAST_MS: u64 = 1000;

/// Default seed.
const SEED: u64 = 7;

/// Arguments of `lafet sim`.
#[derive(Debug, Args)]
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "Examples:\n  lafet sim\n  \
                        lafet sim --listen tcp://127.0.0.1:0 --listen pty --fire az=30,range=25\n  \
                        lafet sim --fire az=30,range=25 --wind -5,0 --gusts 0.15\n  \
                        lafet sim --fire az=30,range=25 --wall from=20,to=40,range=15,height=3\n  \
                        lafet sim --profile ex --speed 20 --listen radio+udp://0.0.0.0:10486\n  \
                        lafet sim --radio rate=9600,latency=80,loss=0.05\n  \
                        lafet sim --on qemu --firmware lafet-firmware --fire az=30,range=25\n  \
                        lafet sim --on qemu --boot lafet-boot --firmware 1.0.a.image --flash board\n  \
                        lafet sim --board my-board --update-key 0=key0.pub\n  \
                        lafet sim --site tank-farm\n  \
                        lafet sim run radio-loss --svg report.svg"
)]
pub struct SimArgs {
    /// Do something else than serve one monitor
    #[command(subcommand)]
    command: Option<SimCommand>,
    #[arg(long, value_name = "WHERE")]
    listen: Vec<Listen>,
    #[arg(long, value_name = "NAME", default_value = "full", value_parser = simulator::profile)]
    profile: Composition,
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        value_parser = clap::value_parser!(u8).range(1..=127)
    )]
    addr: u8,
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = simulator::speed)]
    speed: f64,
    #[arg(long, value_name = "FIRE", value_parser = simulator::fire)]
    fire: Vec<FireSpec>,
    #[arg(long, value_name = "FAULT", value_parser = simulator::fault,
          conflicts_with_all = ["firmware", "site"])]
    fault: Vec<Fault>,
    #[command(flatten)]
    surroundings: Surroundings,
    #[arg(long, value_name = "CHANNEL", value_parser = channel)]
    radio: Option<RadioConfig>,
    #[arg(long, value_name = "FILE", requires = "on", conflicts_with_all = ["radio", "site"])]
    firmware: Option<PathBuf>,
    #[arg(long, value_name = "EMULATOR", value_parser = ["qemu"], requires = "firmware")]
    on: Option<String>,
    #[arg(long, value_name = "FILE", requires = "on")]
    boot: Option<PathBuf>,
    #[arg(long, value_name = "FILE")]
    flash: Option<PathBuf>,
    #[command(flatten)]
    software: SoftwareArgs,
    #[arg(long, value_name = "SCENARIO", conflicts_with_all = ["profile", "addr", "fire", "wind", "gusts", "glare", "wall", "flash"])]
    site: Option<String>,
}

/// Options of a monitor whose software can be updated.
#[derive(Debug, Args)]
struct SoftwareArgs {
    #[arg(long, value_name = "BOARD", value_parser = board, requires = "update_key",
          conflicts_with_all = ["firmware", "site"])]
    board: Option<BoardName>,
    #[arg(long, value_name = "N=FILE", value_parser = numbered, requires = "board")]
    update_key: Vec<Numbered>,
    #[arg(long, value_name = "KIND", value_parser = ["dead-link", "hangs"], requires = "board")]
    bad_trial: Option<String>,
}

impl SoftwareArgs {
    /// The software that is kept beside this memory, or that of a new monitor; `None` without a board.
    fn software(&self, memory: Option<&Path>) -> Result<Option<Software>, Failure> {
        let Some(board) = &self.board else { return Ok(None) };
        let own = Software::factory_key().public().id;
        let keys = self.update_key.iter().map(public_key).collect::<Result<Vec<_>, _>>()?;
        if keys.iter().any(|key| key.id == own) {
            return Err(Failure::Usage(text::OwnKeyOfSimulator.str(current()).into()));
        }
        let kept = |memory: &Path| load(&software_file(memory), SoftwareFlash::from_bytes);
        let trial = match self.bad_trial.as_deref() {
            Some("dead-link") => Trial::DeadLink,
            Some(_) => Trial::Hangs,
            None => Trial::Good,
        };
        Ok(Some(Software {
            board: board.as_str().to_owned(),
            keys,
            flash: memory.map_or(Ok(None), kept)?,
            trial,
            ..Software::default()
        }))
    }
}

/// Subcommands of `lafet sim`.
#[derive(Debug, Subcommand)]
enum SimCommand {
    Run(exercise::RunArgs),
}

/// Parameters accepted at rest are stored before the power is cut.
fn keep_last(sim: &Shared, path: &Path) -> Outcome {
    sim.lock().advance_ms(LAST_MS);
    store_all(sim, path).map_err(|error| cannot_keep(path, error))
}

/// Runs `lafet sim` until SIGINT or SIGTERM.
pub async fn run(args: SimArgs, out: &mut Out) -> Outcome {
    if let Some(SimCommand::Run(args)) = args.command {
        return exercise::run(&args, out);
    }
    if let Some(scenario) = &args.site {
        let place = exercise::Serving {
            scenario,
            seed: args.seed,
            speed: args.speed,
            listen: args.listen,
            radio: args.radio,
        };
        return exercise::serve(place, out).await;
    }
    if let Some(firmware) = &args.firmware {
        return emulate(firmware, &args, out).await;
    }
    let mut interrupt = Interrupt::catch()?;
    let memory = args.flash.as_deref();
    let flash = memory.map_or(Ok(None), |path| load(path, Flash::from_bytes))?;
    let software = args.software.software(memory)?;
    let mut sim = simulator::power_up(Config {
        seed: args.seed.unwrap_or(SEED),
        composition: args.profile,
        address: args.addr,
        fires: args.fire,
        flash,
        software,
        ..args.surroundings.config()
    });
    args.fault.iter().for_each(|fault| sim.world_mut().inject(*fault));
    let sim = Shared::new(sim);
    let mut listen = args.listen;
    let burns = !sim.lock().world().fires.is_empty();
    if listen.is_empty() {
        listen.push(Listen::tcp(format!("127.0.0.1:{}", lafet_proto::bus::PORT_EXTERNAL_CONN)));
    }
    let air = by_radio(args.radio, args.seed.unwrap_or(SEED), &mut listen)?;
    let mut tasks = JoinSet::new();
    let paced = Paced::new(sim.clone(), args.speed);
    if let Some(air) = &air {
        tasks.spawn(air.clone().carry(paced.clone()));
    }
    for place in &listen {
        let listening = place.open().await.map_err(|error| cannot_listen(place, error))?;
        let url = listening.url();
        out.show(format!("listening {url}"), || serde_json::json!({ "listening": url }))?;
        tasks.spawn(listening.serve_over(air.clone(), paced.clone()));
    }
    if !burns {
        nothing_burns(out)?;
    }
    tasks.spawn(run_time(paced));
    if let Some(path) = args.flash.clone() {
        tasks.spawn(keep(sim.clone(), path));
    }
    let ended = tokio::select! {
        () = interrupt.wait() => Ok(()),
        Some(ended) = tasks.join_next() => Err(ended),
    };
    if let Some(path) = &args.flash {
        keep_last(&sim, path)?;
    }
    match ended {
        Ok(()) => Ok(()),
        Err(Ok(Err(error))) => Err(Failure::io(text::TheSimulator.str(current()), error)),
        Err(_) => Err(Failure::Ended(text::SimulatorFailed.str(current()).into())),
    }
}

fn nothing_burns(out: &mut Out) -> Outcome {
    out.say(text::NothingBurns.str(current()))
}

#[cfg(unix)]
async fn emulate(firmware: &Path, args: &SimArgs, out: &mut Out) -> Outcome {
    let config = Config {
        seed: args.seed.unwrap_or(SEED),
        composition: args.profile,
        address: args.addr,
        fires: args.fire.clone(),
        ..args.surroundings.clone().config()
    };
    let (flash, listen, speed) = (args.flash.as_deref(), &args.listen, args.speed);
    let boot = args.boot.as_deref();
    let running = super::chip::Running { firmware, boot, flash, listen, config, speed };
    super::chip::serve(running, out).await
}

#[cfg(not(unix))]
async fn emulate(_: &Path, _: &SimArgs, _: &mut Out) -> Outcome {
    Err(Failure::io("QEMU", io::ErrorKind::Unsupported.into()))
}

/// The radio channel, and a listener to reach it.
pub fn by_radio(
    config: Option<RadioConfig>,
    seed: u64,
    listen: &mut Vec<Listen>,
) -> Result<Option<Air>, Failure> {
    let Some(config) = config else { return Ok(None) };
    if !listen.iter().any(Listen::is_radio) {
        listen.push(Listen::radio(format!("127.0.0.1:{}", lafet_proto::bus::PORT_RADIO)));
    }
    if let Some(place) = listen.iter().find(|place| place.is_radio() && place.has_records()) {
        return Err(Failure::Usage(text::RadioNeedsFrames { place: Shown(place) }.of(current())));
    }
    Ok(Some(Air::new(config, seed)))
}

fn channel(text: &str) -> Result<RadioConfig, String> {
    text.parse().map_err(|part: String| text::RadioExpected { part }.of(current()))
}

async fn run_time(sim: Paced<Shared>) -> io::Result<()> {
    sim.run().await;
    Ok(())
}

/// Describes why a listener cannot be opened.
pub fn cannot_listen(place: &Listen, error: io::Error) -> Failure {
    let what = text::CannotListenSim { place: Shown(place) }.of(current());
    Failure::io(what, error)
}

fn cannot_keep(path: &Path, error: io::Error) -> Failure {
    let path = path.display();
    let what = text::CannotKeepMemory { path: Shown(path) }.of(current());
    Failure::io(what, error)
}

/// Reads what is kept; a file that does not exist yet gives a new monitor.
fn load<T, E>(path: &Path, parse: impl Fn(&[u8]) -> Result<T, E>) -> Result<Option<T>, Failure> {
    let bytes = match std::fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(cannot_keep(path, error)),
    };
    parse(&bytes).map(Some).map_err(|_| {
        let path = path.display();
        Failure::Usage(text::NotAMemory { path: Shown(path) }.of(current()))
    })
}

/// Writes the memory to the file whenever it has changed, and the software to the one beside it.
async fn keep(sim: Shared, path: PathBuf) -> io::Result<()> {
    let mut kept = None;
    loop {
        let steps = steps(&sim);
        if kept != Some(steps) {
            store_all(&sim, &path)?;
            kept = Some(steps);
        }
        sleep(KEEP).await;
    }
}

/// Words written and pages erased so far: in the memory, and in the software that can be updated.
fn steps(sim: &Shared) -> (u64, Option<u64>) {
    let sim = sim.lock();
    let software = sim.world().software_chip().map(|chip| chip.steps());
    (sim.world().flash.chip().steps(), software)
}

fn store_all(sim: &Shared, path: &Path) -> io::Result<()> {
    let (memory, software) = {
        let sim = sim.lock();
        (sim.world().flash.to_bytes(), sim.software_flash())
    };
    store(path, &memory)?;
    software.map_or(Ok(()), |software| store(&software_file(path), &software))
}

fn store(path: &Path, image: &[u8]) -> io::Result<()> {
    Whole::beside(path)?.place(image)
}

/// The file of the software, beside that of the memory.
fn software_file(memory: &Path) -> PathBuf {
    let mut name = memory.as_os_str().to_owned();
    name.push(".software");
    name.into()
}
