//! Pictures as SVG: curves and heat maps, each one file that needs nothing beside it.
//!
//! Guarantees: text is escaped, whatever it says; numbers that are not finite are left out; the same data give the same
//! file.

mod curves;
mod frame;
mod heat_map;

pub use curves::{CurvePlot, Line, write_curves_csv, write_curves_svg};
pub use heat_map::{HeatMap, write_heat_map_svg};

/// What is written above and beside a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Labels {
    /// Above it.
    pub title: String,
    /// Below it, with the unit.
    pub x: String,
    /// Beside it, with the unit.
    pub y: String,
}
