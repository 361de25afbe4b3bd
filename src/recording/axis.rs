//! The six load axes and their names.

use serde::{Deserialize, Serialize};
use strum::{Display, IntoStaticStr};

/// One axis of the applied load: a force (N) or a moment (N·m). Columns of loads are always in the order of the variants.
#[derive(
    Clone,
    Copy,
    Debug,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    Serialize,
    Deserialize,
    Display,
    IntoStaticStr,
)]
#[expect(missing_docs, reason = "the names of the axes say everything")]
pub enum Axis {
    Fx,
    Fy,
    Fz,
    Mx,
    My,
    Mz,
}

impl Axis {
    /// All axes in the order of columns.
    pub const ALL: [Self; 6] = [Self::Fx, Self::Fy, Self::Fz, Self::Mx, Self::My, Self::Mz];

    /// Returns the symbol of the axis, `Fx` to `Mz`.
    pub fn symbol(self) -> &'static str {
        self.into()
    }

    /// Returns the symbols of these axes, such as `Fx`.
    pub fn symbols(axes: &[Self]) -> Vec<&'static str> {
        axes.iter().map(|axis| axis.symbol()).collect()
    }

    /// Returns true for a force and false for a moment.
    pub const fn is_force(self) -> bool {
        matches!(self, Self::Fx | Self::Fy | Self::Fz)
    }

    /// Returns the SI unit of the axis: N or N·m.
    pub const fn unit(self) -> &'static str {
        if self.is_force() { "N" } else { "N·m" }
    }

    /// Returns symbol and unit for the head of a column, such as `Fx [N]`.
    pub fn label(self) -> String {
        format!("{} [{}]", self.symbol(), self.unit())
    }

    /// Returns the label of one quantity of the axis, such as `Fx error [N]`.
    pub fn label_of(self, what: &str) -> String {
        format!("{} {what} [{}]", self.symbol(), self.unit())
    }
}
