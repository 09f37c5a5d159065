//! A pump and a main that several monitors draw from.

/// What a supply is built from. The pressure of the main falls with the square of the flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupplySpec {
    /// Pressure without flow, MPa.
    pub closed_mpa: f64,
    /// A flow, l/s …
    pub flow_lps: f64,
    /// … and the pressure at the monitors' branches with it, MPa.
    pub pressure_mpa: f64,
}

/// A supply.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Supply {
    /// What it was built from.
    pub spec: SupplySpec,
    /// How much of its pressure the pump gives, 0 … 1.
    pub share: f64,
}

impl Supply {
    /// A pump that runs.
    pub const fn new(spec: SupplySpec) -> Self {
        Self { spec, share: 1.0 }
    }

    /// Pressure at the branches when the monitors draw this much, MPa: P = P₀ − A·Q².
    pub fn head_mpa(&self, flow_lps: f64) -> f64 {
        let SupplySpec { closed_mpa, flow_lps: nominal_lps, pressure_mpa } = self.spec;
        let drop = (closed_mpa - pressure_mpa) / (nominal_lps * nominal_lps);
        (self.share * closed_mpa - drop * flow_lps * flow_lps).max(0.0)
    }
}
