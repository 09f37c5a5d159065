//! lafet's controlling side: what an exchange of its session costs, without I/O and clock.

use std::time::Duration;

use lafet_client::session::line::Line;
use lafet_client::session::{Config, Outcome, Terms};
use lafet_proto::request::Body;
use lafet_proto::{Request, SubsystemId};

use crate::case;
use crate::case::Case;

const MONITOR: u8 = 1;

/// Cases of the session: an answer of this kind is received again and again.
pub fn cases(answer: &[u8]) -> Vec<Case> {
    let answered = |asking: &Asking| asking.answered;
    vec![case!(lafet::exchange, answer.len(), Asking::new(answer), answered)]
}

/// A line to a monitor, settled: no answer of another program can come.
struct Asking {
    line: Line,
    now: Duration,
    request: lafet_client::RequestBuf,
    wire: Vec<u8>,
    answer: Vec<u8>,
    answered: bool,
}

impl Asking {
    fn new(answer: &[u8]) -> Self {
        let mut line = Line::new(Config::default());
        line.handle_connected(Duration::ZERO);
        let request = Request { to: SubsystemId::VERTICAL, body: Body::GetStatus };
        let request = lafet_client::RequestBuf::new(&request).expect("it fits");
        let (wire, answer) = (Vec::new(), answer.to_vec());
        Self { line, now: Duration::ZERO, request, wire, answer, answered: true }
    }
}

/// From the request to its answer, as the blocking client does it.
#[inline(never)]
fn exchange(asking: &mut Asking) {
    let Asking { line, now, request, wire, answer, answered } = asking;
    *now += Duration::from_micros(20);
    let asked = line.submit(*now, MONITOR, Terms::default(), [request.clone()]);
    let sent = line.transmit(*now, wire);
    let due = line.poll_timeout(*now);
    *now += Duration::from_micros(20);
    line.handle_bytes(*now, answer);
    let outcome = line.poll_outcome();
    *answered &= sent && due.is_some();
    *answered &= matches!((asked, outcome), (Ok(of), Some((by, Outcome::Answered(_)))) if of == by);
}
