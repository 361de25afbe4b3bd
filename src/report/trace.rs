//! Loads that the program compares (reference, uncompensated, compensated, factory), and the units of their errors.

/// Origin of a load over time: the reference, or one of the calculations that are compared with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Trace {
    /// Reference load.
    Calculated,
    /// Uncompensated load, computed from the present gauge readings alone.
    Conventional,
    /// Compensated load, computed from present and earlier gauge readings.
    Compensated,
    /// Load that the factory calibration computes.
    Factory,
}

impl Trace {
    /// All loads in drawing order. The last load is drawn on top.
    pub const ALL: [Self; 4] =
        [Self::Calculated, Self::Factory, Self::Conventional, Self::Compensated];

    /// All loads in the order in which lists show them.
    pub const LISTED: [Self; 4] =
        [Self::Calculated, Self::Conventional, Self::Compensated, Self::Factory];

    /// The two loads that a fitted calibration computes: first uncompensated, then compensated.
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

    /// Returns a description of what the load is computed from.
    pub fn explanation(self) -> &'static str {
        match self {
            Self::Calculated => {
                "The load that was applied, given by the reference (\"Calc.\" in Koike et al., 2019)"
            }
            Self::Conventional => {
                "The load from the present gauge readings alone: the conventional calibration (Eq. 3-8, \"Conv.\" in Koike et al., 2019)"
            }
            Self::Compensated => {
                "The load from present gauge readings and the added features, such as an earlier sample (Eq. 9-12, \"Comp.\" in Koike et al., 2019)"
            }
            Self::Factory => "The load from the calibration that the sensor came with",
        }
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Shown {
    #[default]
    PercentFs,
    Units,
    All,
}

impl Shown {
    pub fn both<T>(self, in_units: T, in_percent: T) -> Vec<T> {
        match self {
            Self::PercentFs => vec![in_percent],
            Self::Units => vec![in_units],
            Self::All => vec![in_units, in_percent],
        }
    }
}
