//! Fewer points of a series than are stored, with the least and the greatest value of each part of
//! the range: a peak of a second is in a picture of a month.

use serde::Serialize;

/// Spans begin at whole minutes, and are not shorter.
pub const MINUTE_MS: u64 = 60_000;

/// A value of a series and since when it holds; `None`: from then on it is not known.
pub type Point = (u64, Option<f64>);

/// Start, mean over the time in which the value was known, least, greatest.
pub type Span = (u64, f64, f64, f64);

/// Mean, least and greatest value from a time on until another; `None`: not known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// First moment, ms since 1970.
    pub from_ms: u64,
    /// Last moment, ms since 1970.
    pub until_ms: u64,
    /// Mean, least and greatest value.
    pub figures: [f64; 3],
}

/// What is answered of a series.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Rows {
    /// `[t, value]`: each change, or of more than the wanted points the extreme ones.
    Changes(Vec<Point>),
    /// `[t, mean, least, greatest]` over `resolution_ms` from `t` on.
    Spans(Vec<Span>),
}

/// At most `points` (at least four) of the changes: of each part of the range the least, the
/// greatest and the last value, and where it stopped to be known.
pub fn changes(all: Vec<Point>, points: usize) -> Vec<Point> {
    let (Some(first), Some(last)) = (all.first(), all.last()) else { return all };
    if all.len() <= points {
        return all;
    }
    let parts = (points / 4).max(1) as u64;
    let (from_ms, width_ms) = (first.0, (last.0 - first.0) / parts + 1);
    let part = |point: &Point| (point.0 - from_ms) / width_ms;
    let mut thinned = Vec::with_capacity(points);
    for part in all.chunk_by(|a, b| part(a) == part(b)) {
        let known = || part.iter().enumerate().filter_map(|(index, it)| Some((index, it.1?)));
        let mut kept = [
            known().min_by(|a, b| a.1.total_cmp(&b.1)).map(|it| it.0),
            known().max_by(|a, b| a.1.total_cmp(&b.1)).map(|it| it.0),
            part.iter().position(|it| it.1.is_none()),
            part.len().checked_sub(1),
        ];
        kept.sort_unstable();
        let mut before = None;
        for index in kept.into_iter().flatten() {
            if before.replace(index) != Some(index) {
                thinned.extend(part.get(index));
            }
        }
    }
    thinned
}

/// How long a span is when a range is to have at most `points` of them.
pub fn resolution_ms((from_ms, to_ms): (u64, u64), points: usize) -> u64 {
    // Spans begin at multiples of their length: the first and the last may be cut.
    let parts = points.saturating_sub(1).max(1) as u64;
    let minutes = to_ms.saturating_sub(from_ms).div_ceil(parts).div_ceil(MINUTE_MS);
    minutes.max(1).saturating_mul(MINUTE_MS)
}

/// Pieces, in order of time and not overlapping, as spans of one length; a span in which nothing was
/// known is left out.
pub fn spans(
    pieces: impl Iterator<Item = Piece>,
    (from_ms, to_ms): (u64, u64),
    resolution_ms: u64,
) -> Vec<Span> {
    let mut spans: Vec<(u64, Sum)> = Vec::new();
    for piece in pieces {
        let (mut at_ms, end_ms) = (piece.from_ms.max(from_ms), piece.until_ms.min(to_ms));
        while at_ms < end_ms {
            let start_ms = at_ms - at_ms % resolution_ms;
            let until_ms = end_ms.min(start_ms.saturating_add(resolution_ms));
            if spans.last().is_none_or(|last| last.0 != start_ms) {
                spans.push((start_ms, Sum::default()));
            }
            if let Some((_, sum)) = spans.last_mut() {
                sum.add(piece.figures, until_ms - at_ms);
            }
            at_ms = until_ms;
        }
    }
    spans.into_iter().map(|(at_ms, sum)| sum.span(at_ms)).collect()
}

/// What has come together of a span.
#[derive(Clone, Copy)]
struct Sum {
    area: f64,
    over_ms: u64,
    least: f64,
    most: f64,
}

impl Default for Sum {
    fn default() -> Self {
        Self { area: 0.0, over_ms: 0, least: f64::INFINITY, most: f64::NEG_INFINITY }
    }
}

impl Sum {
    fn add(&mut self, [mean, least, most]: [f64; 3], for_ms: u64) {
        self.area += mean * for_ms as f64;
        self.over_ms += for_ms;
        self.least = self.least.min(least);
        self.most = self.most.max(most);
    }

    fn span(self, at_ms: u64) -> Span {
        let mean = self.area / self.over_ms.max(1) as f64;
        (at_ms, mean.clamp(self.least, self.most), self.least, self.most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_changes_peaks_gaps_and_the_last_value_are_kept() {
        let mut all: Vec<Point> = (0..10_000).map(|t| (t * 100, Some((t % 7) as f64))).collect();
        all[1234].1 = Some(1000.0);
        all[7777].1 = Some(-1000.0);
        all[5000].1 = None;
        for points in [1, 4, 5, 60, 600, 9_999] {
            let thinned = changes(all.clone(), points);
            assert!(thinned.len() <= points.max(4), "{points}: {}", thinned.len());
            for kept in [1234, 7777, 5000, 9_999] {
                assert!(thinned.contains(&all[kept]), "{points}: {:?}", all[kept]);
            }
            assert!(thinned.is_sorted_by(|a, b| a.0 < b.0));
        }
        assert_eq!(changes(all.clone(), 10_000), all);
        assert_eq!(changes(Vec::new(), 4), []);
    }

    #[test]
    fn spans_keep_least_greatest_mean_and_gaps() {
        let piece = |from_ms, until_ms, figures| Piece { from_ms, until_ms, figures };
        let pieces = [
            piece(0, 60_000, [1.0, 0.0, 9.0]),
            piece(60_000, 120_000, [3.0, -5.0, 4.0]),
            piece(240_000, 245_000, [7.0, 7.0, 7.0]),
        ];
        let all = spans(pieces.into_iter(), (0, 1_000_000), 120_000);
        assert_eq!(all, [(0, 2.0, -5.0, 9.0), (240_000, 7.0, 7.0, 7.0)]);
        let part = spans(pieces.into_iter(), (90_000, 241_000), 60_000);
        assert_eq!(part, [(60_000, 3.0, -5.0, 4.0), (240_000, 7.0, 7.0, 7.0)]);
    }

    #[test]
    fn a_range_has_at_most_the_wanted_spans() {
        for (range, points) in [((0, 1), 1), ((59_999, 2_592_000_000), 600), ((7, 86_400_007), 2)] {
            let resolution_ms = resolution_ms(range, points);
            let whole = Piece { from_ms: 0, until_ms: u64::MAX, figures: [0.0; 3] };
            let spans = spans([whole].into_iter(), range, resolution_ms);
            assert!(!spans.is_empty() && spans.len() <= points.max(2), "{range:?} {}", spans.len());
        }
    }
}
