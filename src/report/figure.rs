//! Figures as plain data, and as images.

mod cloud;
pub(crate) mod color;
mod parts;
mod svg;

pub use cloud::{Cloud, CloudPicture};
pub use parts::{Arrow, DASHED, DOTTED, Figure, HeatMap, Line, STANDS_ALONE, Scale};
