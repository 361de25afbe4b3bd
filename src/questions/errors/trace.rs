//! Names of the loads that are compared, and units of their errors.

/// A load that is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Trace {
    /// Reference load.
    Calculated,
    /// Load from the present gauges.
    Conventional,
    /// Load from present and past gauges.
    Compensated,
    /// Load by the factory calibration.
    Factory,
}

impl Trace {
    /// All loads in drawing order; later ones are drawn over earlier ones.
    pub const ALL: [Self; 4] =
        [Self::Calculated, Self::Factory, Self::Conventional, Self::Compensated];

    /// All loads in the order of lists.
    pub const LISTED: [Self; 4] =
        [Self::Calculated, Self::Conventional, Self::Compensated, Self::Factory];

    /// Returns the paper's abbreviation.
    pub fn label(self) -> &'static str {
        match self {
            Self::Calculated => "Calc.",
            Self::Conventional => "Conv.",
            Self::Compensated => "Comp.",
            Self::Factory => "Factory",
        }
    }

    /// Returns the meaning of the abbreviation.
    pub fn explanation(self) -> &'static str {
        match self {
            Self::Calculated => "Calculated: the reference, the load that was applied",
            Self::Conventional => "Conventional: from the present gauges alone (Eq. 3-8)",
            Self::Compensated => {
                "Compensated: from the present gauges and those of the past sample (Eq. 9-12)"
            }
            Self::Factory => "Factory: by the calibration that the sensor came with",
        }
    }
}

/// Unit in which errors are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shown {
    /// Percent of full scale.
    #[default]
    PercentFs,
    /// The unit of the axis.
    Units,
    /// Both units.
    All,
}

impl Shown {
    /// Returns the units that are shown.
    pub(crate) fn both<T>(self, in_units: T, in_percent: T) -> Vec<T> {
        match self {
            Self::PercentFs => vec![in_percent],
            Self::Units => vec![in_units],
            Self::All => vec![in_units, in_percent],
        }
    }
}
