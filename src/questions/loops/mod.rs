//! Loops, cross-plots, dwells and metrology figures, as the loop pane and the metrology pane show them.
//!
//! [`look`] answers a [`Question`] (a request for one plot or table). All questions about one calibration share the computed
//! loads. After a change of axis, zoom or reversal threshold, the visible samples are read once.
//!
//! Guarantees: every number in an answer is finite. Loops and cross-plots are exact to the pixel for any number of samples.
//! If the data do not determine a figure, a sentence with the reason takes its place.

mod cross;
mod figure;
mod picture;
pub mod query;
mod request;

pub use crate::questions::dataset::applied::OutputLag;
pub(crate) use crate::questions::dataset::applied::Part;
pub use cross::CrossPlot;
pub(crate) use cross::{DwellCurve, DwellPlot};
pub(crate) use figure::{Inks, LoopView, drifts, figure_of_channels, lag_in_words};
pub(crate) use picture::{Drawn as Strokes, LoopPlot, drawn, frame_around};
pub use query::{Look, look};
pub(crate) use request::DwellQuestion;
pub use request::{
    Channel, CrossQuestion, LookError, LookRequest, LoopQuestion, Question, Span, TableOf, Up,
};

#[cfg(test)]
mod tests;
