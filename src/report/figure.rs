//! Figures as plain data (scales, lines, heat maps), and as SVG and PNG images.

mod cloud;
pub(crate) mod color;
mod parts;
mod svg;

pub(crate) use cloud::png;
pub use cloud::{Cloud, CloudPicture};
pub use parts::{Arrow, DASHED, DOTTED, Figure, HeatMap, Line, STANDS_ALONE, Scale};
pub(crate) use svg::part_inside;
