//! What is heard on a line before anything is sent on it.
//!
//! A frame at a wrong speed reaches no device and disturbs those of others, and a second controller
//! transmits in the turns of the first. Neither can be seen afterwards, so it is listened for before
//! the first byte. [`overhear`] sends nothing.

use std::io;
use std::time::Duration;

use lafet_proto::bus::CONTROLLER;

use crate::prober::{Heard, HeardFrame, Prober};
use crate::transport::Link;
use crate::url::{Endpoint, SerialLine};

pub use crate::session::medium::CONTROLLER_PAUSE;

/// How long is listened at each other speed to a line that is silent at its own.
pub const GLANCE: Duration = Duration::from_millis(150);
/// Time to hear, after the first frame, who else transmits.
const COMPANY: Duration = Duration::from_millis(500);
/// Speeds to try: those of the bus (observed) and other common settings of adapters.
const SPEEDS: [u32; 7] = [19_200, 57_600, 115_200, 9_600, 38_400, 4_800, 2_400];

/// How long is listened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Times {
    /// Before a line counts as quiet.
    pub first: Duration,
    /// For a first frame at the speed of the URL, after bytes that are no frame.
    pub own: Duration,
    /// For a first frame at each other speed.
    pub elsewhere: Duration,
    /// The same after silence: a driver may drop what comes at a wrong speed. Zero: not at all.
    pub silent: Duration,
}

/// What was heard.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Overheard {
    /// At the speed of the URL.
    pub here: Heard,
    /// Bytes kept coming there, and none of them is in a frame: noise, or devices at another speed.
    pub unreadable: bool,
    /// Another speed at which frames were read, baud, and what was heard there.
    pub elsewhere: Option<(u32, Heard)>,
}

impl Overheard {
    /// The addresses that transmit without being asked, in order, at whatever speed.
    pub fn speakers(&self) -> Vec<u8> {
        let elsewhere = self.elsewhere.iter().flat_map(|(_, heard)| &heard.frames);
        let mut all: Vec<u8> =
            self.here.frames.iter().chain(elsewhere).map(HeardFrame::speaker).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Whether a frame of a bus controller was heard, at whatever speed.
    pub fn has_controller(&self) -> bool {
        self.speakers().contains(&CONTROLLER)
    }
}

/// Listens to a line that `dial` opens, and gives it back. If bytes come that are no frames, listens
/// for longer, since the first ones may be the end of a frame, and then at the other speeds of a
/// serial line; after silence, too, for as long as `times` says. Not at those of a line that another
/// program shares, whose speed must not change.
///
/// # Errors
///
/// The error of the link when it cannot be opened or is lost.
pub async fn overhear(
    endpoint: &Endpoint,
    times: Times,
    mut dial: impl AsyncFnMut(&Endpoint) -> io::Result<Link>,
) -> io::Result<(Link, Overheard)> {
    let mut prober = Prober::new(dial(endpoint).await?, endpoint.addresses().source);
    let mut here = prober.listen(times.first).await?;
    let (mut unreadable, mut elsewhere) = (here.is_garbage(), None);
    if unreadable {
        unreadable = prober.listen_on(&mut here, times.own).await?;
        listen_for_company(&mut prober, &mut here, times.own).await?;
    }
    let time = if unreadable { times.elsewhere } else { times.silent };
    let wanted = (unreadable || here.bytes == 0) && !time.is_zero();
    if wanted && at_other_speeds(endpoint).next().is_some() {
        // A port is opened again only after it is closed.
        drop(prober);
        elsewhere = listen_elsewhere(endpoint, time, &mut dial).await?;
        prober = Prober::new(dial(endpoint).await?, endpoint.addresses().source);
    }
    Ok((prober.into_link(), Overheard { here, unreadable, elsewhere }))
}

/// Listens a little longer if a frame has come.
async fn listen_for_company(
    prober: &mut Prober,
    heard: &mut Heard,
    time: Duration,
) -> io::Result<()> {
    if !heard.frames.is_empty() {
        heard.add(prober.listen(COMPANY.min(time)).await?);
    }
    Ok(())
}

/// Listens at the other speeds of a serial line, for `time` at each; the first one at which a frame
/// comes.
pub(crate) async fn listen_elsewhere(
    endpoint: &Endpoint,
    time: Duration,
    dial: &mut impl AsyncFnMut(&Endpoint) -> io::Result<Link>,
) -> io::Result<Option<(u32, Heard)>> {
    for (baud, at) in at_other_speeds(endpoint) {
        let link = match dial(&at).await {
            Ok(link) => link,
            // Another program has opened the port in between: nothing is known about the line.
            Err(error) if error.kind() == io::ErrorKind::ResourceBusy => return Err(error),
            // A port that does not support a speed is skipped.
            Err(_) => continue,
        };
        let mut prober = Prober::new(link, endpoint.addresses().source);
        let mut heard = prober.listen_for_frame(time).await?;
        listen_for_company(&mut prober, &mut heard, time).await?;
        if !heard.frames.is_empty() {
            return Ok(Some((baud, heard)));
        }
    }
    Ok(None)
}

/// The endpoints of a serial line at other speeds. None for other links, and for a port that is
/// shared: its speed would change for the other program as well.
pub(crate) fn at_other_speeds(endpoint: &Endpoint) -> impl Iterator<Item = (u32, Endpoint)> {
    let serial = match endpoint {
        Endpoint::Serial { path, line, addresses, behaviour } if !line.shared => {
            Some((path, *line, *addresses, *behaviour))
        }
        _ => None,
    };
    serial.into_iter().flat_map(|(path, line, addresses, behaviour)| {
        SPEEDS.into_iter().filter(move |baud| *baud != line.baud).map(move |baud| {
            let (path, line) = (path.clone(), SerialLine { baud, ..line });
            (baud, Endpoint::Serial { path, line, addresses, behaviour })
        })
    })
}
