//! Names of the compared loads, and units of their errors.

/// Load that is compared with other loads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Trace {
    /// Reference load.
    Calculated,
    /// Uncompensated load, from the present gauges alone.
    Conventional,
    /// Compensated load, from present and past gauges.
    Compensated,
    /// Load by the factory calibration.
    Factory,
}

impl Trace {
    /// All loads in drawing order. The last load is drawn on top.
    pub const ALL: [Self; 4] =
        [Self::Calculated, Self::Factory, Self::Conventional, Self::Compensated];

    /// All loads in the order in which lists show them.
    pub const LISTED: [Self; 4] =
        [Self::Calculated, Self::Conventional, Self::Compensated, Self::Factory];

    /// Outputs of the calibration, in the order used everywhere.
    pub const OUTPUTS: [Self; 2] = [Self::Conventional, Self::Compensated];

    /// Returns the name of the load.
    pub fn label(self) -> &'static str {
        match self {
            Self::Calculated => "Reference",
            Self::Conventional => "Uncompensated",
            Self::Compensated => "Compensated",
            Self::Factory => "Factory",
        }
    }

    /// Returns a description of the inputs of the load.
    pub fn explanation(self) -> &'static str {
        match self {
            Self::Calculated => "The load that was applied (\"Calc.\" in the paper)",
            Self::Conventional => {
                "From the present gauges alone: the conventional calibration (Eq. 3-8; \"Conv.\" in the paper)"
            }
            Self::Compensated => {
                "From the present gauges and the appended features, such as the past sample (Eq. 9-12; \"Comp.\" in the paper)"
            }
            Self::Factory => "From the calibration that the sensor came with",
        }
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shown {
    #[default]
    PercentFs,
    Units,
    All,
}

impl Shown {
    pub(crate) fn both<T>(self, in_units: T, in_percent: T) -> Vec<T> {
        match self {
            Self::PercentFs => vec![in_percent],
            Self::Units => vec![in_units],
            Self::All => vec![in_units, in_percent],
        }
    }
}
