//! The text form of requests and answers (ours).
//!
//! A request is its name, its addressee and its data:
//!
//! ```text
//! Move Vertical 1200                    GetStatus All               Stop All
//! GetParam Detector Hotbeds             SetParam Vertical MinLimit -900
//! Open Valve1                           Open Valve1 key=0x1234      (not the key of §3.8)
//! Lockout All on | off                  SwitchLimits Vertical off | on | reject
//! StartSeek Detector -1800 1800 -300 900 analyse
//! StartQuench Control program=3 centre=0,0 nozzle=60
//! StartQuench Control centre=1200,300 nozzle=60 sector=600,300 step=2 distance=25
//! StartQuench Control centre=1200,300 nozzle=60 sector=600,300 step=2 corrections=0,1,2,3
//! StartTrajectory Control ballistics repeat stored=0,3
//! StartTrajectory Control point=1200,300,25,10 point=1300,300,25,10
//! SetupCorrectionTable Control first=0 corrections=0,0,1,1,2
//! GetLog General first=0 count=10
//! 0x12 0x34 de ad be                    an unknown request and subsystem, with data
//! ```
//!
//! Names are understood in any case; `key=value` parts in any order; a request with a single
//! possible addressee may leave it out (`Deploy`, `Lockout on`). Numbers are decimal or `0x`. A
//! parameter is a name of the dictionary, its id (`0x23fe`), or `@` and any name, which is hashed.
//! A number instead of a request's name (`0x4d Vertical b0`) takes any data, valid or not. What
//! follows `#` is a comment.
//!
//! An answer is `addressee request → status (who answered instead): data`.

mod answer;
pub(crate) mod error;
pub(crate) mod fields;
pub(crate) mod parse;
pub(crate) mod request;

pub use answer::{AnswerText, Exchange, Measured};
pub use error::{ParseError, Wanted, nearest};
pub use parse::parse;
pub use request::RequestText;

use crate::dictionary;
use crate::id::{ParamId, RequestId, SubsystemId};
use crate::param::Param;
use core::fmt;

/// Bytes of buffer that [`parse`] needs at most.
pub const BUFFER_SIZE: usize = crate::record::DATA_MAX;

/// Writes the name of a request, or its number if it is unknown.
fn write_request(f: &mut fmt::Formatter<'_>, id: RequestId) -> fmt::Result {
    match dictionary::request(id) {
        Some(info) => f.write_str(info.name),
        None => write!(f, "{:#04x}", id.0),
    }
}

/// The parameter with this id: the subsystem's own, else that of any subsystem, for All has none.
fn find_param(subsystem: SubsystemId, id: ParamId) -> Option<Param> {
    Param::find(subsystem, id).or_else(|| Param::ALL.into_iter().find(|p| p.spec().id == id))
}

/// Writes the name of a parameter, or its number if it is unknown.
fn write_param(f: &mut fmt::Formatter<'_>, subsystem: SubsystemId, id: ParamId) -> fmt::Result {
    match find_param(subsystem, id) {
        Some(param) => f.write_str(param.name()),
        None => write!(f, "{id}"),
    }
}

/// Writes items with a separator between them.
pub(crate) fn write_list<T: fmt::Display>(
    f: &mut fmt::Formatter<'_>,
    separator: &str,
    items: impl IntoIterator<Item = T>,
) -> fmt::Result {
    for (index, item) in items.into_iter().enumerate() {
        if index > 0 {
            f.write_str(separator)?;
        }
        item.fmt(f)?;
    }
    Ok(())
}

/// Bytes in hexadecimal: `de ad be`.
struct Hex<'a>(&'a [u8]);

impl fmt::Display for Hex<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_list(f, " ", self.0.iter().map(|byte| HexByte(*byte)))
    }
}

struct HexByte(u8);

impl fmt::Display for HexByte {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:02x}", self.0)
    }
}
