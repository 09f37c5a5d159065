//! Every kind of message as fast as loopback takes it, and what becomes of Stop, Close and Lockout
//! of others, of the monitors' values and of the memory meanwhile.

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::time::sleep;

use crate::Fallible;
use crate::flood::{self, Target};
use crate::hub::{Hub, Used};
use crate::kinds::{self, Kind};
use crate::link;
use crate::others::{Found, Others};
use crate::prepare;
use crate::site::Site;
use crate::tally::{MANNERS, Manner, Tallies};
use crate::watch::Watch;

/// Most connections of the hub.
pub const CONNECTIONS: usize = 4000;
/// Memory above that at rest, KiB.
const MEMORY_KIB: f64 = 64.0 * 1024.0;
/// What may be kept of it after a flood, KiB.
const KEPT_KIB: f64 = MEMORY_KIB / 2.0;
/// What a flood leaves is gone after this time.
const REST: Duration = Duration::from_secs(20);
/// A flood goes on for so much longer at most until it is answered as it has to be.
const ANSWERED: Duration = Duration::from_secs(10);
/// Memory that changes less than this in as many seconds does not change, KiB.
const STABLE: (f64, usize) = (512.0, 4);

/// How much, for how long, and within which bounds.
pub struct Size {
    site: Scale,
    /// Connections of a flood, and for how long.
    connections: &'static [(usize, Duration)],
    /// Each manner by itself (read, unread, known, stranger), however many connections there are.
    apart: bool,
    bounds: Bounds,
    /// A flood is out of bounds of time if it is so every time. The next try is after all others: a pause of the
    /// machine is in one of them.
    tries: usize,
    /// It is so short that other work of the machine may leave no time to carry out any of it: that, too, is wrong only every
    /// time.
    short: bool,
}

/// The site that the hub serves.
struct Scale {
    monitors: usize,
    zones: usize,
    of_zone: usize,
    /// How often the monitors are polled, ms.
    poll_ms: u64,
}

/// Of the times of others' requests, ms.
struct Bounds {
    p50: f64,
    p99: f64,
    most: f64,
}

const WHOLE: Size = Size {
    site: Scale { monitors: 3, zones: 1, of_zone: 1, poll_ms: 100 },
    connections: &[(1, Duration::from_millis(2500)), (200, Duration::from_secs(6))],
    apart: false,
    bounds: Bounds { p50: 50.0, p99: 50.0, most: 250.0 },
    tries: 2,
    short: false,
};
/// Each kind for a minute from one connection, in four manners, and a minute from many.
const LONG: Size =
    Size { connections: &[(1, Duration::from_secs(15)), (200, Duration::from_secs(60))], ..WHOLE };
/// Of a few kinds.
const APART: Size = Size {
    connections: &[(1, Duration::from_secs(60)), (200, Duration::from_secs(60))],
    apart: true,
    ..WHOLE
};
/// Of a program without optimization, as CI has it, on a machine that does other things, too.
const QUICK: Size = Size {
    connections: &[(48, Duration::from_millis(400))],
    bounds: Bounds { p50: 1000.0, p99: 2000.0, most: 2000.0 },
    tries: 3,
    short: true,
    ..WHOLE
};
/// Of a large site: what costs time for each monitor or zone shows. The simulated monitors take the processors, too, and
/// a flood has too few requests of others for a 99th part of them.
const LARGE: Size = Size {
    site: Scale { monitors: 240, zones: 64, of_zone: 3, poll_ms: 500 },
    connections: &[(48, Duration::from_secs(2))],
    bounds: Bounds { p50: 50.0, p99: 250.0, most: 250.0 },
    ..WHOLE
};

impl Size {
    /// The size of this name, if one is given, and what the names of the kinds hold.
    pub fn named<'a>(words: &[&'a str]) -> Option<(&'static Self, &'a str)> {
        let (size, rest) = match words {
            ["--quick", rest @ ..] => (&QUICK, rest),
            ["--long", rest @ ..] => (&LONG, rest),
            ["--large", rest @ ..] => (&LARGE, rest),
            ["--apart", rest @ ..] => (&APART, rest),
            ["--whole", rest @ ..] | rest => (&WHOLE, rest),
        };
        match rest {
            [] => Some((size, "")),
            [only] if !only.starts_with('-') => Some((size, only)),
            _ => None,
        }
    }
}

/// Floods a hub with the kinds whose names hold `only`, first in the clear, then over TLS.
pub async fn run(lafet: &Path, folder: &Path, size: &Size, only: &str) -> Fallible<()> {
    let of = |kinds: Vec<Kind>| -> Vec<Kind> {
        kinds.into_iter().filter(|kind| kind.name.contains(only)).collect()
    };
    let (plain, tls) = (of(kinds::all()?), of(kinds::of_tls()));
    let count = plain.len() + tls.len();
    if count == 0 {
        return Err(format!("no kind of message is called `{only}`").into());
    }
    std::fs::create_dir_all(folder)?;
    println!(
        "| flood | connections | messages | carried out | requests of others | p50, ms | p99 | most \
         | over new connections | p50, ms | p99 | most | processor, % | memory above rest, MiB |\n\
         |---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|"
    );
    let failed = served(lafet, folder, (&plain, &tls), size).await?;
    println!("{count} kinds of messages");
    std::fs::remove_dir_all(folder)?;
    if failed.is_empty() {
        Ok(())
    } else {
        Err(format!("out of bounds: {}", failed.join("; ")).into())
    }
}

/// A hub with users, without TLS and then with it.
async fn served(
    lafet: &Path,
    folder: &Path,
    (plain, tls): (&[Kind], &[Kind]),
    size: &Size,
) -> Fallible<Vec<String>> {
    let Scale { monitors, zones, of_zone, poll_ms } = size.site;
    let site = Site::start(monitors);
    let (config, certificate) = (folder.join("hub.toml"), folder.join("cert.pem"));
    let text =
        site.config(poll_ms).replace("login = false\n", "") + &prepare::zones(zones, of_zone);
    std::fs::write(&config, &text)?;
    let (hub, setup) = Hub::with_users(lafet, &config)?;
    let secret = setup.as_deref().and_then(|link| link.split_once('#')).ok_or("no link")?.1;
    let tokens = prepare::fill(&hub, secret).await?;
    hub.kill()?;
    prepare::history(&folder.join("data")).await?;
    let mut failed = Vec::new();
    if !plain.is_empty() {
        let (hub, _) = Hub::with_users(lafet, &config)?;
        prepare::ready(&hub, &tokens, monitors).await?;
        failed = Flooded::start(hub, &tokens, None).await?.all(plain, size).await?;
    }
    if !tls.is_empty() {
        let own = rcgen::generate_simple_self_signed(["localhost".to_owned()])?;
        std::fs::write(&certificate, own.cert.pem())?;
        std::fs::write(folder.join("key.pem"), own.signing_key.serialize_pem())?;
        let tables = text
            .replace("[recording]", "[tls]\ncert = \"cert.pem\"\nkey = \"key.pem\"\n[recording]");
        std::fs::write(&config, tables)?;
        let (hub, _) = Hub::with_users(lafet, &config)?;
        failed.extend(Flooded::start(hub, &tokens, Some(certificate)).await?.all(tls, size).await?);
    }
    Ok(failed)
}

/// A hub, and who is at it.
struct Flooded {
    hub: Hub,
    target: Arc<Target>,
    others: Others,
    watch: Watch,
    /// Memory before the first flood, KiB.
    rest_kib: f64,
}

/// What a flood came to.
struct Outcome {
    found: Found,
    tallies: Tallies,
    used: Used,
    processor: f64,
}

/// What of a flood was out of bounds.
struct Beyond {
    wrong: Vec<String>,
    /// Times, the age of values, and that nothing of a short flood was carried out: of these a pause of the machine can be the
    /// cause.
    late: Vec<String>,
}

/// One flood of a kind.
struct Part {
    name: String,
    count: usize,
    time: Duration,
    manners: Vec<Manner>,
}

impl Flooded {
    async fn start(hub: Hub, tokens: &prepare::Tokens, tls: Option<PathBuf>) -> Fallible<Self> {
        let tls = tls.as_deref();
        let target = Arc::new(Target {
            place: hub.place.clone(),
            token: String::new(),
            tls: link::connector(tls)?,
        });
        let watch = Watch::new(&hub.place, &tokens.watch, tls)?;
        let mut others = Others::start(&hub.place, &tokens.others, tls)?;
        others.work(Duration::from_secs(3)).await?;
        let rest_kib = hub.used()?.memory_kib;
        Ok(Self { hub, target, others, watch, rest_kib })
    }

    /// Sends each kind to the hub, which is killed then; what was out of bounds.
    async fn all(mut self, kinds: &[Kind], size: &Size) -> Fallible<Vec<String>> {
        let mut failed = Vec::new();
        let of = |kind| parts(kind, size).into_iter().map(move |part| (kind, part));
        let mut left: Vec<(&Kind, Part)> = kinds.iter().flat_map(of).collect();
        for last in (0..size.tries).rev() {
            let mut again = Vec::new();
            for (kind, part) in left {
                self.renew().await?;
                self.rested().await?;
                let named = |it: &dyn Display| format!("{} × {}: {it}", part.name, part.count);
                let tried = self.tried(kind, &part, size).await.map_err(|error| named(&error))?;
                let all = tried.wrong.iter().chain(&tried.late);
                all.for_each(|it| eprintln!("{}", named(it)));
                failed.extend(tried.wrong.iter().map(|it| named(it)));
                if last == 0 {
                    failed.extend(tried.late.iter().map(|it| named(it)));
                } else if tried.wrong.is_empty() && !tried.late.is_empty() {
                    again.push((kind, part));
                }
            }
            left = again;
        }
        let entries = self.watch.verified().await?;
        let rest_kib = self.at_rest().await?;
        let left = (rest_kib - self.rest_kib) / 1024.0;
        println!(
            "| at rest again: {:.1} MiB | 0 | | | | | | | | | | | | {left:.1} |",
            rest_kib / 1024.0
        );
        println!("{entries} entries of the audit log, chain whole");
        println!("priority of the hub: a nice value of {}", self.hub.used()?.nice);
        if left > KEPT_KIB / 1024.0 {
            failed.push(format!("what is kept at the end: {left:.1} MiB"));
        }
        self.hub.kill()?;
        Ok(failed)
    }

    /// The next flood is another user's: its limits are not used up.
    async fn renew(&mut self) -> Fallible<()> {
        let token = self.watch.token().await?;
        self.watch.knows(&token).await?;
        self.watch.take(&token).await?;
        self.target = Arc::new(Target { token, ..(*self.target).clone() });
        Ok(())
    }

    /// What the flood before it took is given back first, so that the bound is that of one. What is not given back in
    /// time counts.
    async fn rested(&self) -> Fallible<()> {
        let began = Instant::now();
        while self.hub.used()?.memory_kib - self.rest_kib > KEPT_KIB && began.elapsed() < REST {
            sleep(Duration::from_millis(100)).await;
        }
        Ok(())
    }

    /// A flood, and what was out of bounds.
    async fn tried(&mut self, kind: &Kind, part: &Part, size: &Size) -> Fallible<Beyond> {
        let outcome = self.one(kind, part).await?;
        outcome.show(part, self.rest_kib);
        let (mut wrong, mut late) = (self.watch.beyond().await?, Vec::new());
        let unanswered = outcome.tallies.wrong(&part.manners, kind.answered);
        match size.short && outcome.tallies.is_too_much(&part.manners) {
            true => late.extend(unanswered),
            false => wrong.extend(unanswered),
        }
        let above_kib = outcome.used.peak_kib - self.rest_kib;
        if above_kib > MEMORY_KIB {
            wrong.push(format!("{:.1} MiB of memory", above_kib / 1024.0));
        }
        late.extend(size.bounds.broken(&outcome.found));
        if outcome.found.stale > 0 {
            late.push(format!("{} stale values", outcome.found.stale));
        }
        Ok(Beyond { wrong, late })
    }

    async fn one(&mut self, kind: &Kind, part: &Part) -> Fallible<Outcome> {
        self.hub.forget_peak()?;
        let (tallies, before, began) = (Tallies::default(), self.hub.used()?, Instant::now());
        let tasks = flood::start(&self.target, kind, part.count, &part.manners, &tallies);
        let found = self.others.work(part.time).await?;
        let (used, took_s) = (self.hub.used()?, began.elapsed().as_secs_f64());
        // What waits for the disk or for a hash is answered later.
        let wrong = || tallies.wrong(&part.manners, kind.answered).is_some();
        while wrong() && began.elapsed() < part.time + ANSWERED {
            sleep(Duration::from_millis(50)).await;
        }
        drop(tasks);
        let processor = (used.cpu_s - before.cpu_s) / took_s * 100.0;
        Ok(Outcome { found, tallies, used, processor })
    }

    /// The memory when it does not change any more, KiB.
    async fn at_rest(&self) -> Fallible<f64> {
        let (began, mut last) = (Instant::now(), Vec::new());
        loop {
            last.push(self.hub.used()?.memory_kib);
            let latest = &last[last.len().saturating_sub(STABLE.1)..];
            let (least, most) = latest
                .iter()
                .fold((f64::MAX, 0.0_f64), |(least, most), it| (least.min(*it), most.max(*it)));
            let stable = latest.len() == STABLE.1 && most - least < STABLE.0;
            let back = most - self.rest_kib <= KEPT_KIB;
            if (stable && back) || began.elapsed() > REST {
                return Ok(most);
            }
            sleep(Duration::from_secs(1)).await;
        }
    }
}

impl Outcome {
    fn show(&self, Part { name, count, .. }: &Part, rest_kib: f64) {
        let Found { times, fresh, .. } = &self.found;
        let done: u64 = MANNERS.into_iter().map(|it| self.tallies.of(it).done()).sum();
        println!(
            "| {name} | {count} | {} | {done} | {} | {} | {} | {} | {:.0} | {:.1} |",
            self.tallies.all_sent(),
            times.count(),
            times.cells(),
            fresh.count(),
            fresh.cells(),
            self.processor,
            (self.used.peak_kib - rest_kib) / 1024.0
        );
    }
}

impl Bounds {
    /// What was too late.
    fn broken(&self, found: &Found) -> Vec<String> {
        let mut broken = Vec::new();
        for (what, times) in [("Stops", &found.times), ("over new connections", &found.fresh)] {
            let within = times.percentile(50) <= self.p50
                && times.percentile(99) <= self.p99
                && times.most() <= self.most;
            // Without any request there is no figure, and no bound is kept.
            if !within {
                broken.push(format!("{what} {}", times.cells()));
            }
        }
        broken
    }
}

/// The floods of a kind: with too few connections for every manner, one after the other.
fn parts(kind: &Kind, size: &Size) -> Vec<Part> {
    let mut parts = Vec::new();
    for (count, time) in size.connections {
        let part = |name, manners| Part { name, count: *count, time: *time, manners };
        if size.apart || *count < MANNERS.len() {
            let each = MANNERS.into_iter();
            parts.extend(each.map(|it| part(format!("{}, {it}", kind.name), vec![it])));
        } else {
            parts.push(part(kind.name.clone(), MANNERS.to_vec()));
        }
    }
    parts
}
