//! What the loop pane and the metrology pane draw: loops, cross-plots, dwells, the table of figures.
//!
//! A [`Viewer`] answers one [`Question`] at a time. Between questions it remembers only the loads that the calibration
//! gives, so that another axis, a zoom or another dead band costs a pass over what is drawn and nothing more.
//!
//! Guarantees: every number in an answer is finite; loops and cross-plots are drawn to the pixel, whatever the number of
//! samples; what the data cannot give is a sentence.

pub mod asked;
mod cross;
mod dwell;
pub(crate) mod error;
mod figure;
mod frame;
mod output;
mod picture;
pub mod query;
pub(crate) mod shown;
mod source;

pub use cross::{Channel, CrossPlot, CrossQuestion, LoadKind};
pub(crate) use dwell::{DwellCurve, DwellPlot, DwellQuestion};
pub use error::LookError;
pub(crate) use figure::{FiguresOf, Inks, LoopView};
pub use output::{Output, Span, TableOf};
pub(crate) use picture::LoopPlot;
pub use picture::{LoopQuestion, Up};
pub use query::{Look, LookRequest, Question, TableQuestion, Viewer};
pub(crate) use shown::{LoopMeasures, LoopScale, drifts, lag_in_words, loop_figures};
pub use source::OutputLag;

#[cfg(test)]
mod tests;
