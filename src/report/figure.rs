//! Figures as plain data (scales, lines, heat maps), and as SVG and PNG images.

mod cloud;
pub(crate) mod color;
mod parts;
mod svg;

pub use cloud::{Cloud, CloudPicture, png};
pub use parts::{Arrow, DASHED, DOTTED, Figure, HeatMap, Line, STANDS_ALONE, Scale};
pub use svg::{part_inside, stacked_svg};
