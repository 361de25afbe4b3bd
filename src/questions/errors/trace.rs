//! What the loads are called, and what their errors are shown in.

/// One of the loads that are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Trace {
    /// The true load.
    Calculated,
    /// From the present gauges.
    Conventional,
    /// With what the past adds.
    Compensated,
    /// By the matrix that the sensor came with.
    Factory,
}

impl Trace {
    /// All, in the order in which they are drawn: the later over the earlier.
    pub const ALL: [Self; 4] =
        [Self::Calculated, Self::Factory, Self::Conventional, Self::Compensated];

    /// All, in the order in which they are listed.
    pub const LISTED: [Self; 4] =
        [Self::Calculated, Self::Conventional, Self::Compensated, Self::Factory];

    /// The paper's abbreviation.
    pub fn label(self) -> &'static str {
        match self {
            Self::Calculated => "Calc.",
            Self::Conventional => "Conv.",
            Self::Compensated => "Comp.",
            Self::Factory => "Factory",
        }
    }

    /// What the abbreviation stands for.
    pub fn explanation(self) -> &'static str {
        match self {
            Self::Calculated => "Calculated: the load that was really applied",
            Self::Conventional => "Conventional: from the present gauges alone (Eq. 3-8)",
            Self::Compensated => {
                "Compensated: from the present gauges and those of the past sample (Eq. 9-12)"
            }
            Self::Factory => "By the matrix that the sensor came with",
        }
    }
}

/// What errors are shown in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shown {
    /// Percent of full scale.
    #[default]
    PercentFs,
    /// The unit of the axis.
    Units,
    /// Both.
    All,
}

impl Shown {
    /// What is shown of the two.
    pub(crate) fn both<T>(self, in_units: T, in_percent: T) -> Vec<T> {
        match self {
            Self::PercentFs => vec![in_percent],
            Self::Units => vec![in_units],
            Self::All => vec![in_units, in_percent],
        }
    }
}
