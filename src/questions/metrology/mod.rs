//! Metrology figures per axis, of the uncompensated load beside those of the compensated load.
//!
//! [`table_by`] takes recordings with the loads of a calibration, and returns one row per [`Quantity`] with its definition
//! and source. If the data do not determine a figure, the cell has a [`Reason`] instead of a number.
//!
//! **Source** OIML R 60 and VDI/VDE 2638 (errors relative to full scale, not to the reading), and the glossaries of load-cell
//! makers. Each row gives its own source. Full scale is the rated load that the user entered, else the range of the
//! recordings (see [`full_scale_of`](crate::recording::full_scale_of)).
//!
//! **Conditions that a free-running recording does not meet** Standards prescribe that one axis alone is loaded, in steps
//! from zero to the rated load and back, after preloading, and that the output is read at set times at constant temperature.
//! A recording of a moving robot loads several axes at once, at varying speed, turns at any load, and seldom dwells. So the
//! hysteresis contains the effect of other axes, whose loads differ although the load of this axis is equal. Creep and
//! viscosity increase the width of a loop. Nonlinearity is that of a branch between two reversals.
//!
//! Each loop figure gives its number of cycles (counted by rainflow) and the share of the load range ([`Basis`]). The figures compare two calibrations on the same data fairly, but do not replace
//! a calibration in steps on a reference machine. [`free_running`](figures::Definition::free_running) lists the conditions
//! for each row.

mod dwell_rows;
mod figures;
mod loop_rows;
mod measured;
mod table;

pub(crate) use dwell_rows::{Dwell, dwells};
pub use figures::{
    Basis, Cell, Figure, Metrology, MetrologySettings, Place, Row, Rules, Run, Value,
};
pub(crate) use figures::{MetrologyError, Quantity, Reason};
pub(crate) use loop_rows::Cycles;
pub(crate) use measured::check_numbers;
pub use measured::{Lags, lags_of};
pub use table::crosstalk;
pub use table::table_by;
pub(crate) use table::{axis_figures, figure_records, overview};

#[cfg(test)]
pub(crate) mod tests;
