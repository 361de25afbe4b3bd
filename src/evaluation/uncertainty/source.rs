//! What an uncertainty comes from: each source with its formula and whose it is.

use crate::evaluation::metrology::Definition;

/// One source of uncertainty.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Source {
    /// The load that was taken for true.
    Reference,
    /// What temperature does beyond what the recordings show.
    Temperature,
    /// The steps of the gauges.
    Resolution,
    /// The output without a load.
    Zero,
    /// The same load again.
    Repeatability,
    /// Another group of recordings: mounting, day, programme.
    Reproducibility,
    /// The same load from above and from below.
    Reversibility,
    /// Output that moves while the load stands.
    Creep,
    /// The rest: interpolation, noise, what the model cannot follow.
    Residual,
}

/// What is said of a source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Texts {
    /// Short and stable, for programs.
    pub id: &'static str,
    /// For people.
    pub name: &'static str,
    /// How its standard uncertainty is made.
    pub formula: &'static str,
    /// Whose evaluation that is.
    pub basis: &'static str,
}

impl Source {
    /// All of them, in the order in which a budget lists them.
    pub const ALL: [Self; 9] = [
        Self::Reference,
        Self::Temperature,
        Self::Resolution,
        Self::Zero,
        Self::Repeatability,
        Self::Reproducibility,
        Self::Reversibility,
        Self::Creep,
        Self::Residual,
    ];

    /// What is said of it.
    pub fn texts(self) -> Texts {
        let [id, name, formula, basis] = match self {
            Self::Reference => [
                "reference",
                "Reference",
                "U_ref / 2: half of the expanded uncertainty (k = 2) that its certificate states",
                "GUM 4.3.3, type B",
            ],
            Self::Temperature => [
                "temperature",
                "Temperature",
                "not evaluated: what a temperature does that no recording has is in none of the errors",
                "GUM 4.3, type B",
            ],
            Self::Resolution => [
                "resolution",
                "Resolution",
                "√(Σ (A_g r_g)² / 12), with the step r_g that each gauge moves by and its coefficient A_g in the conventional matrix",
                "GUM F.2.2.1, type B, rectangular",
            ],
            Self::Zero => [
                "zero",
                "Zero",
                "root mean square of output − load, averaged over each dwell at zero",
                "GUM 4.2, type A; ISO 376 judges zero by f0",
            ],
            Self::Repeatability => [
                "repeatability",
                "Repeatability",
                "R / (2 √3), with the largest difference R between repeated branches",
                "GUM 4.3.7, rectangular; R as the figure Repeatability",
            ],
            Self::Reproducibility => [
                "reproducibility",
                "Reproducibility",
                "root mean square, over the groups, of the mean error of each",
                "GUM 4.2, type A",
            ],
            Self::Reversibility => [
                "reversibility",
                "Reversibility",
                "w / 2, with the mean width w of the mean loop: a reading lies half of it above or below its middle",
                "GUM 4.3, type B, two values",
            ],
            Self::Creep => [
                "creep",
                "Creep",
                "|c| / (2 √3), with the creep c of the longest hold under load",
                "GUM 4.3.7, rectangular; c as the figure Creep",
            ],
            Self::Residual => [
                "residual",
                "Interpolation and noise",
                "√(e² − Σ u²), with the root mean square e of all errors left out and the parts above that it holds; 0 where these are more",
                "GUM 4.2, type A",
            ],
        };
        Texts {
            id,
            name,
            formula,
            basis,
        }
    }

    /// Formula and basis, as the figures have theirs.
    pub fn definition(self) -> Definition {
        let Texts {
            id,
            name,
            formula,
            basis,
        } = self.texts();
        Definition {
            id: id.to_owned(),
            name: name.to_owned(),
            definition: formula,
            source: basis,
            free_running: "",
        }
    }
}
