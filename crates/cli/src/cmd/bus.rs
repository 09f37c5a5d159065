//! `lafet bus`: the network controller of a bus (observed), and queries to one.

use std::ops::RangeInclusive;
use std::str::FromStr;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use clap::{Args, Subcommand};
use lafet_client::bus::{
    Change, ControllerConfig, Driver, DriverConfig, Entry, Event, LENT, Port, Repeat,
};
use lafet_client::overhear::{CONTROLLER_PAUSE, GLANCE, Overheard, Times};
use lafet_client::transport::Link;
use lafet_client::{Endpoint, Error, Framing, Role, SystemError, os_text};
use lafet_proto::bus::{BAUD_DEFAULT, CONSOLES, CONTROLLER, MONITORS};
use lafet_proto::{Record, Request, Status};
use lafet_texts::{Fixed, Shown, Text as _, cli as text};
use serde_json::{Value, json};
use time::OffsetDateTime;
use tokio::net::TcpListener;
use tokio::task::JoinSet;
use tokio::time::sleep;

use super::bus_ask;
use crate::cli::{Global, seconds};
use crate::connect::{can_be_overheard, listened, url_of, who};
use crate::describe::hex;
use crate::exchange::name;
use crate::failure::{Failure, Outcome};
use crate::interrupt::Interrupt;
use crate::lang::current;
use crate::out::Out;

/// How long the lines are listened to before the first frame.
const LISTEN: Times = Times {
    first: CONTROLLER_PAUSE,
    own: CONTROLLER_PAUSE,
    elsewhere: CONTROLLER_PAUSE,
    silent: GLANCE,
};
/// Silence on the line between the last byte received and our frame, unless the URL gives it.
const TURNAROUND: Duration = Duration::from_millis(1);

/// Arguments of `lafet bus`.
#[derive(Debug, Args)]
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "Examples:\n  lafet bus serial:///dev/ttyUSB0?baud=115200\n  \
                  lafet bus serial:///dev/ttyUSB0 serial:///dev/ttyUSB1 --addresses 1-8,129-131\n  \
                  lafet bus serial:///dev/ttyUSB0 --listen 127.0.0.1:10485\n  \
                  lafet -c 'serial:///dev/ttyUSB2?role=active&src=130' bus who\n  \
                  lafet -c tcp://127.0.0.1:10485 bus log"
)]
pub struct BusArgs {
    /// Query a running controller instead of being one
    #[command(subcommand)]
    command: Option<BusCommand>,
    #[arg(value_name = "URL", num_args = 1..=2)]
    urls: Vec<String>,
    #[arg(long, value_name = "ADDRESS")]
    listen: Option<String>,
    #[arg(long, value_name = "LIST", value_parser = addresses)]
    addresses: Option<Addresses>,
    #[arg(long, value_name = "SECONDS", default_value_t = 5.0, value_parser = positive)]
    watch: f64,
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u32).range(300..=4_000_000))]
    baud: Option<u32>,
    #[arg(long, value_name = "SECONDS", value_parser = delay)]
    latency: Option<f64>,
    #[arg(long)]
    repeat_all: bool,
    #[arg(long)]
    force: bool,
    #[arg(long = "for", value_name = "SECONDS", value_parser = positive)]
    duration: Option<f64>,
}

/// Queries to a running controller.
#[derive(Debug, Subcommand)]
enum BusCommand {
    Who(bus_ask::WhoArgs),
    Log(bus_ask::LogArgs),
}

/// Addresses that the controller may use, as given by `--addresses`.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Addresses(Vec<u8>);

fn positive(text: &str) -> Result<f64, String> {
    seconds(text, 0.1)
}

fn delay(text: &str) -> Result<f64, String> {
    seconds(text, 0.0)
}

fn addresses(text: &str) -> Result<Addresses, String> {
    let range = |part: &str| -> Option<RangeInclusive<u8>> {
        let (from, to) = part.split_once('-').unwrap_or((part, part));
        let (from, to) = (from.trim().parse().ok()?, to.trim().parse().ok()?);
        let range: RangeInclusive<u8> = from..=to;
        let valid = |a: u8| MONITORS.contains(&a) || CONSOLES.contains(&a);
        (from <= to && range.clone().all(|a| valid(a) || a == CONTROLLER)).then_some(range)
    };
    let ranges: Option<Vec<_>> = text.split(',').map(range).collect();
    ranges
        .map(|ranges| Addresses(ranges.into_iter().flatten().collect()))
        .ok_or_else(|| text::BusAddressesExpected.str(current()).into())
}

/// Runs the controller until it is interrupted, or queries a running one.
pub async fn run(args: BusArgs, global: &Global, out: &mut Out) -> Outcome {
    match args.command {
        Some(BusCommand::Who(_)) => return bus_ask::who(global, out).await,
        Some(BusCommand::Log(args)) => return bus_ask::log(&args, global, out).await,
        None => {}
    }
    // A full disk or a reader that pauses must not keep others from their turns.
    let mut aside = out.aside()?;
    let out = &mut aside;
    let mut interrupt = Interrupt::catch()?;
    let urls = match &args.urls[..] {
        [] => vec![url_of(global)?.to_owned()],
        urls => urls.to_vec(),
    };
    let lines = urls.iter().map(|url| line(url)).collect::<Result<Vec<_>, _>>()?;
    let controller = configured(&args, &lines, args.listen.is_some())?;
    let force = args.force || global.insist;
    let ready = tokio::select! {
        ready = vacant(&urls, &lines, force, out) => ready?,
        () = interrupt.wait() => return Err(Failure::Interrupted),
    };
    // Not before: what programs ask meanwhile would be sent when they have stopped waiting for it.
    let programs = match &args.listen {
        Some(place) => Some(listen(place, out).await?),
        None => None,
    };
    let controller = ControllerConfig { epoch_s: wall_s(), ..controller };
    let mut lines = lines.into_iter();
    let Some(monitors) = lines.next() else { return Ok(()) };
    let config = DriverConfig { controller, monitors, consoles: lines.next(), programs };
    let mut driver = driver(config, ready);
    let mut told = Ok(());
    let mut opened = [false; 2];
    {
        let duration = args.duration.map_or(Duration::MAX, Duration::from_secs_f64);
        let (stop, mut stopped) = tokio::sync::mpsc::channel(1);
        let running = driver.run(|event| {
            if told.is_ok() {
                told = first_opening(&event, &urls, &mut opened)
                    .and_then(|()| tell(&event, &urls, out));
            }
            if told.is_err() {
                // The channel holds one message, and one is enough: an error means that it is
                // already there.
                let _ = stop.try_send(());
            }
        });
        tokio::select! {
            () = running => {}
            () = sleep(duration) => {}
            () = interrupt.wait() => {}
            _ = stopped.recv() => {}
        }
    }
    told?;
    finish(&driver, out)
}

/// A controller that begins with these open links; a line that is lost is opened again at once.
fn driver(config: DriverConfig, ready: Vec<(Endpoint, Link)>) -> Driver {
    let ready = Mutex::new(ready);
    Driver::opening(config, move |endpoint| {
        let mut ready = ready.lock().unwrap_or_else(PoisonError::into_inner);
        let place = ready.iter().position(|(at, _)| *at == endpoint);
        let link = place.map(|place| ready.swap_remove(place).1);
        async move {
            match link {
                Some(link) => Ok(link),
                // Each Stop of the consoles goes through it.
                None => Link::open_urgently(&endpoint).await,
            }
        }
    })
}

/// Opens the lines and listens to them, for as long as a controller may be silent. Fails if there is
/// one, or devices at another speed, unless the user wants it all the same. Noise is reported: a bus
/// must not be without its controller because of it.
async fn vacant(
    urls: &[String],
    lines: &[Endpoint],
    force: bool,
    out: &mut Out,
) -> Result<Vec<(Endpoint, Link)>, Failure> {
    if force {
        return Ok(Vec::new());
    }
    let s = CONTROLLER_PAUSE.as_secs();
    out.progress(text::ListeningForController { s }.of(current()));
    let mut listening = JoinSet::new();
    for (url, line) in urls.iter().zip(lines).filter(|(_, line)| can_be_overheard(line)) {
        let (url, line) = (url.clone(), line.clone());
        listening.spawn(async move { (listened(&url, &line, LISTEN).await, url, line) });
    }
    let mut ready = Vec::new();
    while let Some(ended) = listening.join_next().await {
        let Ok((heard, url, line)) = ended else { continue };
        let (link, heard) = heard.map_err(|failure| never_open(&url, failure))?;
        if let Some(why) = occupied(&url, &line, &heard) {
            return Err(Failure::Silent(why));
        }
        let others = who(&heard.speakers());
        if heard.unreadable {
            out.warn(&text::BusLineUnreadable { url: &url }.of(current()));
        } else if !others.is_empty() {
            out.warn(&text::OthersOnBus { url: &url, who: &others }.of(current()));
        }
        ready.push((line, link));
    }
    Ok(ready)
}

/// Why there must be no controller on this line.
fn occupied(url: &str, line: &Endpoint, heard: &Overheard) -> Option<String> {
    let own = match line {
        Endpoint::Serial { line, .. } => Some(line.baud),
        _ => None,
    };
    let baud = heard.elsewhere.as_ref().map(|(baud, _)| *baud).or(own);
    let at = baud.map(|baud| text::AtBaud { baud }.of(current())).unwrap_or_default();
    if heard.has_controller() {
        return Some(text::SecondController { url, at, controller: CONTROLLER }.of(current()));
    }
    let who = who(&heard.speakers());
    heard.elsewhere.as_ref().map(|_| text::BusAtOtherSpeed { url, at, who }.of(current()))
}

/// A line that cannot be opened the first time: its URL is most likely wrong.
fn never_open(url: &str, failure: Failure) -> Failure {
    match failure {
        Failure::Client(Error::Link { source, .. }) => {
            let never = text::LineNeverOpen { url, why: SystemError(&source) };
            Failure::Silent(never.of(current()))
        }
        failure => failure,
    }
}

/// Fails when a line cannot be opened the first time: its URL is most likely wrong. A line that was
/// open before is retried.
fn first_opening(event: &Event, urls: &[String], opened: &mut [bool; 2]) -> Outcome {
    let index = |port: &Port| usize::from(*port == Port::Consoles);
    match event {
        Event::Up(port) => opened[index(port)] = true,
        Event::Down(port, why) if !opened[index(port)] => {
            let url = if index(port) == 0 { urls.first() } else { urls.last() };
            let url = url.map_or("", String::as_str);
            let never = text::LineNeverOpen { url, why: SystemError(why) };
            return Err(Failure::Silent(never.of(current())));
        }
        _ => {}
    }
    Ok(())
}

fn line(url: &str) -> Result<Endpoint, Failure> {
    let endpoint = Endpoint::from_str(url).map_err(Error::from)?;
    let wrong = |why: Fixed| Failure::Usage(format!("`{url}`: {}", why.str(current())));
    if matches!(endpoint, Endpoint::Sim { .. }) {
        return Err(wrong(text::BusNeedsLine.fixed()));
    }
    if endpoint.framing() == Framing::Records {
        return Err(wrong(text::BusNeedsAddresses.fixed()));
    }
    if endpoint.behaviour().role == Role::Active {
        return Err(wrong(text::ControllerNotConsole.fixed()));
    }
    Ok(endpoint)
}

async fn listen(place: &str, out: &mut Out) -> Result<TcpListener, Failure> {
    let place = place.strip_prefix("tcp://").unwrap_or(place);
    let cannot = |error| {
        let what = text::CannotListen { place }.of(current());
        Failure::io(what, error)
    };
    let listener = TcpListener::bind(place).await.map_err(cannot)?;
    let bound = listener.local_addr()?;
    out.show(
        format!("listening tcp://{bound}"),
        || json!({ "listening": format!("tcp://{bound}") }),
    )?;
    Ok(listener)
}

/// The time field of the journal has 32 bits (observed).
#[expect(clippy::disallowed_methods, reason = "the journal of a bus records the time of day")]
fn wall_s() -> u32 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_secs()) as u32
}

fn configured(
    args: &BusArgs,
    lines: &[Endpoint],
    programs: bool,
) -> Result<ControllerConfig, Failure> {
    let serial = |endpoint: &Endpoint| match endpoint {
        Endpoint::Serial { line, .. } => Some(line.baud),
        _ => None,
    };
    let baud = lines.iter().filter_map(serial).min().or(args.baud).unwrap_or(BAUD_DEFAULT);
    let usual_s = if lines.iter().all(|line| serial(line).is_some()) { 0.0 } else { 0.02 };
    let latency = Duration::from_secs_f64(args.latency.unwrap_or(usual_s));
    let usual = ControllerConfig::default();
    let lent = |address: &u8| programs && LENT.contains(address);
    let addresses = match &args.addresses {
        Some(Addresses(chosen)) => match chosen.iter().find(|address| lent(address)) {
            Some(address) => return Err(lent_to_programs(*address)),
            None => chosen.clone(),
        },
        None => usual.addresses.into_iter().filter(|address| !lent(address)).collect(),
    };
    Ok(ControllerConfig {
        baud,
        addresses,
        reply_timeout: usual.reply_timeout + latency,
        probe_timeout: usual.probe_timeout + latency,
        watch: Some(Duration::from_secs_f64(args.watch)),
        turnaround: TURNAROUND,
        repeat: if args.repeat_all { Repeat::All } else { Repeat::Repeatable },
        ..usual
    })
}

fn lent_to_programs(address: u8) -> Failure {
    let (first, last) = (LENT.start(), LENT.end());
    Failure::Usage(text::AddressesLent { first, last, address }.of(current()))
}

fn tell(event: &Event, urls: &[String], out: &mut Out) -> Outcome {
    let url = |port: Port| match port {
        Port::Consoles => urls.last(),
        Port::Monitors => urls.first(),
    };
    match event {
        Event::Up(port) => {
            let url = url(*port).map_or("", String::as_str);
            let text = text::LineOpen { url }.of(current());
            out.show(text, || json!({ "open": url }))
        }
        Event::Down(port, why) => {
            let url = url(*port).map_or("", String::as_str);
            let why = os_text(why, current());
            let text = text::LineRetrying { url, why: &why }.of(current());
            out.show(text, || json!({ "lost": url, "why": why }))
        }
        Event::Change(change) => told_change(*change, out),
        Event::Asked(entry) => told_entry(entry, out),
        Event::Program(from, address) => {
            out.progress(text::AddressLent { from: Shown(from), address }.of(current()));
            json_only(out, &json!({ "program": from, "address": address }))
        }
        Event::ProgramGone(address) => {
            out.progress(text::ProgramDisconnected { address }.of(current()));
            json_only(out, &json!({ "program_gone": address }))
        }
    }
}

fn json_only(out: &mut Out, value: &Value) -> Outcome {
    if out.json() { out.value(value) } else { Ok(()) }
}

/// The role of an address with its number: monitor, console or controller.
pub fn called(address: u8) -> String {
    match address {
        CONTROLLER => text::DeviceController.str(current()).into(),
        a if MONITORS.contains(&a) => text::DeviceMonitor { a }.of(current()),
        a => text::DeviceConsole { a }.of(current()),
    }
}

fn told_change(change: Change, out: &mut Out) -> Outcome {
    match change {
        Change::Appeared(address) => {
            let who = called(address);
            out.show(text::DeviceHere { who }.of(current()), || json!({ "appeared": address }))
        }
        Change::Dropped(address) => {
            let who = called(address);
            let text = text::DeviceDropped { who }.of(current());
            out.show(text, || json!({ "dropped": address }))
        }
    }
}

fn told_entry(entry: &Entry, out: &mut Out) -> Outcome {
    let Entry { time_s, dst, src, request, device, data } = entry;
    let record = Record { request: *request, device: *device, status: Status::OK, data };
    out.show(logged(*time_s, *dst, *src, &record), || logged_json(*time_s, *dst, *src, &record))
}

/// A line of the journal as text: time, source → destination, record.
pub fn logged(time_s: u32, dst: u8, src: u8, record: &Record<'_>) -> String {
    format!("{} {src} → {dst}  {}", moment(time_s), spelt(record))
}

/// A line of the journal as JSON.
pub fn logged_json(time_s: u32, dst: u8, src: u8, record: &Record<'_>) -> Value {
    json!({
        "time": moment(time_s), "time_s": time_s, "src": src, "dst": dst,
        "request": spelt(record), "bytes": hex(record.data),
    })
}

fn spelt(record: &Record<'_>) -> String {
    match Request::decode(record) {
        Ok(request) => request.to_string(),
        Err(_) => format!("{} {} {}", name(record.request), record.device, hex(record.data)),
    }
}

/// UTC date and time, ISO 8601.
fn moment(time_s: u32) -> String {
    let Ok(time) = OffsetDateTime::from_unix_timestamp(time_s.into()) else {
        return time_s.to_string();
    };
    let (year, month, day) = time.to_calendar_date();
    let (hour, minute, second) = time.to_hms();
    format!("{year}-{:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z", u8::from(month))
}

fn finish(driver: &Driver, out: &mut Out) -> Outcome {
    let stats = driver.controller().stats();
    let dropped = driver.gateway().dropped();
    let present: Vec<u8> = driver.controller().present().iter().collect();
    let text = text::BusCounters {
        sent: stats.sent,
        passed_on: stats.passed_on,
        requests: stats.requests,
        answers: stats.answers,
        repeated: stats.repeated,
        strays: stats.strays,
        dropped,
    }
    .of(current());
    out.show(text, || {
        json!({
            "sent": stats.sent, "passed_on": stats.passed_on, "requests": stats.requests,
            "answers": stats.answers, "repeated": stats.repeated, "idle_grants": stats.idle_grants,
            "strays": stats.strays, "programs_dropped": dropped, "present": present,
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_addresses() {
        assert_eq!(addresses("1-3,129"), Ok(Addresses(vec![1, 2, 3, 129])));
        assert_eq!(addresses("127-130").map(|a| a.0.len()), Ok(4));
        for text in ["", "0", "255", "3-1", "a", "1-", "1,,2"] {
            assert!(addresses(text).is_err(), "{text}");
        }
    }

    #[test]
    fn moments() {
        assert_eq!(moment(0), "1970-01-01T00:00:00Z");
        assert_eq!(moment(1_792_573_512), "2026-10-21T09:05:12Z");
        assert_eq!(moment(u32::MAX), "2106-02-07T06:28:15Z");
    }

    #[test]
    fn a_line_of_the_journal() {
        let data = [0xB0, 4];
        let record = Record {
            request: lafet_proto::RequestId::MOVE,
            device: lafet_proto::SubsystemId::VERTICAL,
            status: Status::OK,
            data: &data,
        };
        assert_eq!(logged(0, 1, 129, &record), "1970-01-01T00:00:00Z 129 → 1  Move Vertical 1200");
        let cut = Record { data: &data[..1], ..record };
        assert_eq!(logged(0, 1, 129, &cut), "1970-01-01T00:00:00Z 129 → 1  Move Vertical b0");
    }
}
