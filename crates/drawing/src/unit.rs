//! Units of length of a drawing, and what a person states about them.

/// A unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// 0.001 m.
    Millimetre,
    /// 0.01 m.
    Centimetre,
    /// 0.1 m.
    Decimetre,
    /// 1 m.
    Metre,
    /// 1000 m.
    Kilometre,
    /// 0.0254 m.
    Inch,
    /// 0.3048 m.
    Foot,
    /// 1200/3937 m, of drawings of the US surveys.
    SurveyFoot,
    /// 0.9144 m.
    Yard,
}

impl Unit {
    /// All units.
    pub const ALL: [Self; 9] = [
        Self::Millimetre,
        Self::Centimetre,
        Self::Decimetre,
        Self::Metre,
        Self::Kilometre,
        Self::Inch,
        Self::Foot,
        Self::SurveyFoot,
        Self::Yard,
    ];

    /// Its symbol, as it is stated: `mm`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Millimetre => "mm",
            Self::Centimetre => "cm",
            Self::Decimetre => "dm",
            Self::Metre => "m",
            Self::Kilometre => "km",
            Self::Inch => "in",
            Self::Foot => "ft",
            Self::SurveyFoot => "us-ft",
            Self::Yard => "yd",
        }
    }

    /// Its length, m.
    pub const fn metres(self) -> f64 {
        match self {
            Self::Millimetre => 0.001,
            Self::Centimetre => 0.01,
            Self::Decimetre => 0.1,
            Self::Metre => 1.0,
            Self::Kilometre => 1000.0,
            Self::Inch => 0.0254,
            Self::Foot => 0.3048,
            Self::SurveyFoot => 1200.0 / 3937.0,
            Self::Yard => 0.9144,
        }
    }

    /// The unit of this symbol.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|unit| unit.name() == name)
    }

    /// The unit of a scale, m for a unit of the drawing, within a hundredth.
    pub(crate) fn near(metres: f64) -> Option<Self> {
        // The two feet are the same within two millionths.
        Self::ALL.into_iter().find(|unit| (metres / unit.metres() - 1.0).abs() < 0.01)
    }

    /// The unit of `$INSUNITS`; none for "unitless" and for what no site is drawn in.
    pub(crate) const fn of_insunits(code: i64) -> Option<Self> {
        match code {
            1 => Some(Self::Inch),
            2 => Some(Self::Foot),
            4 => Some(Self::Millimetre),
            5 => Some(Self::Centimetre),
            6 => Some(Self::Metre),
            7 => Some(Self::Kilometre),
            10 => Some(Self::Yard),
            14 => Some(Self::Decimetre),
            21 => Some(Self::SurveyFoot),
            _ => None,
        }
    }
}

/// What a person states about the coordinates of a drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stated {
    /// Plane, in this unit.
    Unit(Unit),
    /// Longitude and latitude, degrees of WGS 84.
    Wgs84,
    /// Plane, of no unit: known points or distances have the scale.
    Points,
}

impl Stated {
    /// As it is stated: a symbol of a unit, `wgs84` or `points`.
    pub fn by_name(name: &str) -> Option<Self> {
        match name {
            "wgs84" => Some(Self::Wgs84),
            "points" => Some(Self::Points),
            name => Unit::by_name(name).map(Self::Unit),
        }
    }

    /// All that may be stated.
    pub fn names() -> String {
        let units = Unit::ALL.map(Unit::name).join(", ");
        format!("{units}, wgs84, points")
    }
}
