//! Many measurements in few figures.

/// Sorted measurements.
pub struct Figures(Vec<f64>);

impl Figures {
    pub fn new(mut all: Vec<f64>) -> Self {
        all.sort_by(f64::total_cmp);
        Self(all)
    }

    pub const fn count(&self) -> usize {
        self.0.len()
    }

    /// What so many of a hundred do not exceed.
    pub fn percentile(&self, percent: usize) -> f64 {
        let index = (self.0.len() * percent).div_ceil(100).saturating_sub(1);
        self.0.get(index).copied().unwrap_or(f64::NAN)
    }

    pub fn most(&self) -> f64 {
        self.0.last().copied().unwrap_or(f64::NAN)
    }

    /// Median, 99th percentile and maximum, as cells of a table.
    pub fn cells(&self) -> String {
        format!("{:.1} | {:.1} | {:.1}", self.percentile(50), self.percentile(99), self.most())
    }
}
