//! The history of variables, as the hub has it: each change, a page at a time.

use opcua::server::ContinuationPoint;
use opcua::server::node_manager::HistoryNode;
use opcua::types::{
    DataValue, DateTime, HistoryData, ReadRawModifiedDetails, StatusCode, TimestampsToReturn,
};

use super::events::{millis, time};
use crate::hub::Hub;
use crate::store::{RAW_RANGE_MS, Rows};

/// Most values of one answer.
pub const RETURNED_MAX: usize = 10_000;
/// Pages that are looked through for one answer: a longer time without a change takes another request.
const PAGES_MAX: usize = 24;

/// What is still to be read: from here to there, and back in time if it is less.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cursor {
    from: u64,
    to: u64,
    back: bool,
}

/// A value, or that it is not known, since a time.
type Point = (u64, Option<f64>);

impl Cursor {
    /// Of a request.
    fn new(details: &ReadRawModifiedDetails, now_ms: u64) -> Result<Self, StatusCode> {
        if details.is_read_modified {
            return Err(StatusCode::BadHistoryOperationUnsupported);
        }
        let (start, end) = (millis(&details.start_time), millis(&details.end_time));
        match (start, end) {
            (Some(from), Some(to)) => Ok(Self { from, to, back: to < from }),
            (Some(from), None) => Ok(Self { from, to: now_ms.max(from), back: false }),
            (None, Some(from)) => Ok(Self { from, to: 0, back: true }),
            (None, None) => Err(StatusCode::BadInvalidTimestampArgument),
        }
    }

    fn is_over(self) -> bool {
        if self.back { self.from < self.to } else { self.from > self.to }
    }

    /// The next page, from the earlier time to the later one.
    fn page(self) -> (u64, u64) {
        if self.back {
            (self.from.saturating_sub(RAW_RANGE_MS).max(self.to), self.from)
        } else {
            (self.from, self.from.saturating_add(RAW_RANGE_MS).min(self.to))
        }
    }

    /// What is to be read after a time was.
    fn after(self, at_ms: u64) -> Option<Self> {
        let from = if self.back { at_ms.checked_sub(1)? } else { at_ms + 1 };
        Some(Self { from, ..self }).filter(|it| !it.is_over())
    }

    /// Takes of a page what there is room for; what is to be read after that.
    fn take(self, mut points: Vec<Point>, room: usize, taken: &mut Vec<Point>) -> Option<Self> {
        let (from, to) = self.page();
        // What held at the beginning changed before it.
        points.retain(|(at_ms, _)| (from..=to).contains(at_ms));
        if self.back {
            points.reverse();
        }
        let is_cut = points.len() > room;
        points.truncate(room);
        let last = points.last().map(|(at_ms, _)| *at_ms);
        taken.extend(points);
        match last {
            Some(last) if is_cut => self.after(last),
            _ => self.after(if self.back { from } else { to }),
        }
    }
}

/// What is asked for.
pub struct Asked<'a> {
    /// The times.
    pub details: &'a ReadRawModifiedDetails,
    /// The times that are returned.
    pub stamps: TimestampsToReturn,
    /// The monitor.
    pub monitor: &'a str,
    /// The series, and what its values are multiplied by.
    pub series: (&'a str, f64),
}

/// Reads the history of a variable.
pub async fn read(hub: &Hub, node: &mut HistoryNode, asked: &Asked<'_>) {
    match answer(hub, node, asked).await {
        Ok((values, rest)) => {
            let is_empty = values.is_empty();
            node.set_next_continuation_point(rest.map(|it| ContinuationPoint::new(Box::new(it))));
            node.set_result(HistoryData { data_values: Some(values) });
            let nothing = is_empty && rest.is_none();
            node.set_status(if nothing { StatusCode::GoodNoData } else { StatusCode::Good });
        }
        Err(status) => node.set_status(status),
    }
}

async fn answer(
    hub: &Hub,
    node: &HistoryNode,
    asked: &Asked<'_>,
) -> Result<(Vec<DataValue>, Option<Cursor>), StatusCode> {
    let mut rest = Some(match node.continuation_point() {
        Some(point) => *point.get::<Cursor>().ok_or(StatusCode::BadContinuationPointInvalid)?,
        None => Cursor::new(asked.details, hub.clock().now_ms())?,
    });
    let most = match asked.details.num_values_per_node as usize {
        0 => RETURNED_MAX,
        most => most.min(RETURNED_MAX),
    };
    let (series, scale) = asked.series;
    let stored = hub.history().flushed();
    let base = stored.await;
    let mut points = Vec::new();
    for _ in 0..PAGES_MAX {
        let Some(cursor) = rest else { break };
        let room = most - points.len();
        if room == 0 {
            break;
        }
        let page = base.values(asked.monitor, series, cursor.page(), None, usize::MAX).await;
        let Ok(Rows::Changes(page)) = page else { return Err(StatusCode::BadResourceUnavailable) };
        rest = cursor.take(page, room, &mut points);
    }
    let value =
        |(at_ms, value): Point| stamped(time(at_ms), value.map(|it| it * scale), asked.stamps);
    Ok((points.into_iter().map(value).collect(), rest))
}

fn stamped(at: DateTime, value: Option<f64>, stamps: TimestampsToReturn) -> DataValue {
    let source = matches!(stamps, TimestampsToReturn::Source | TimestampsToReturn::Both);
    let server = matches!(stamps, TimestampsToReturn::Server | TimestampsToReturn::Both);
    DataValue {
        status: Some(if value.is_some() { StatusCode::Good } else { StatusCode::BadNoData }),
        value: value.map(Into::into),
        source_timestamp: source.then_some(at),
        source_picoseconds: None,
        server_timestamp: server.then_some(at),
        server_picoseconds: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All that a client gets which follows each continuation point, and in how many answers.
    fn followed(mut rest: Option<Cursor>, most: usize, points: &[u64]) -> (Vec<u64>, usize) {
        let (mut all, mut answers) = (Vec::new(), 0);
        while rest.is_some() {
            let mut taken = Vec::new();
            for _ in 0..PAGES_MAX {
                let Some(cursor) = rest.filter(|_| taken.len() < most) else { break };
                let page = points.iter().map(|at| (*at, Some(1.0))).collect();
                rest = cursor.take(page, most - taken.len(), &mut taken);
            }
            assert!(taken.len() <= most);
            all.extend(taken.iter().map(|(at, _)| *at));
            answers += 1;
        }
        (all, answers)
    }

    #[test]
    fn every_value_comes_once_in_both_directions() {
        let day = 24 * 3_600_000;
        let points: Vec<u64> = (0..100).map(|it| 1 + it * day / 50).collect();
        let cursor = |from, to| Some(Cursor { from, to, back: to < from });
        let wanted: Vec<u64> = points.iter().copied().filter(|it| (5..=day).contains(it)).collect();
        for most in [1, 7, 1000] {
            let (all, answers) = followed(cursor(5, day), most, &points);
            assert_eq!(all, wanted, "{most}");
            assert!(answers <= wanted.len() + 2);
            let (mut all, _) = followed(cursor(day, 5), most, &points);
            all.reverse();
            assert_eq!(all, wanted, "{most}, back");
        }
        let (all, answers) = followed(cursor(100 * day, 101 * day), 10, &points);
        assert_eq!((all, answers), (vec![], 1));
    }

    #[test]
    fn a_request_without_a_time_is_refused() {
        let details = |start: Option<u64>, end: Option<u64>| {
            let at = |it: Option<u64>| it.map_or_else(DateTime::null, time);
            ReadRawModifiedDetails {
                is_read_modified: false,
                start_time: at(start),
                end_time: at(end),
                num_values_per_node: 0,
                return_bounds: false,
            }
        };
        assert!(Cursor::new(&details(None, None), 9).is_err());
        let open = Cursor::new(&details(Some(5), None), 9).unwrap();
        assert_eq!(open, Cursor { from: 5, to: 9, back: false });
        assert!(Cursor::new(&details(None, Some(5)), 9).unwrap().back);
    }
}
