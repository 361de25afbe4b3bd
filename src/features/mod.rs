//! What a sample is described by: its gauges, and what each chosen block appends.
//!
//! The look-back (Eq. 9-12, [`look_back`]) stands first: it finds its past by the load. The other blocks are those of the list
//! [`BLOCKS`]; each is one file that implements [`Block`] and says there all that window, command line, exports and guide
//! know of it.
//!
//! Each is causal, runs in bounded memory and starts anew in each recording. Columns enter the fit *standardised*
//! ([`GaugeScale`]), those that are gauges of the past relative to the present one (`(s_past − s) / scale`): where the
//! past never differs they are zero, and the answer is the conventional one. [`Design::columns`] says which column is which.

mod block;
mod blocks;
mod channel;
mod column;
mod design;
mod gauge_scale;
mod kept;
pub mod look_back;
mod monomial;
mod setting;
mod settings;
mod source;

pub(crate) use block::{Appends, Block, Lists, Search};
pub(crate) use blocks::BLOCKS;
pub use blocks::{Auxiliary, Creep, FixedLag, Play, Polynomial};
pub use channel::AuxiliaryChannel;
pub use column::Column;
pub(crate) use column::ColumnKind;
pub use design::Design;
pub(crate) use design::FeatureStream;
pub(crate) use gauge_scale::GaugeScale;
pub(crate) use look_back::{Distance, F_TH, HISTORY_RATE, LiveLookBack, T_TH};
pub use look_back::{LoadPath, Thresholds};
pub use setting::listed;
pub(crate) use setting::{Choice, OutOfRange, Range, Setting, Unit};
pub(crate) use settings::FeatureError;
pub use settings::{Blocks, FeatureSettings, Stored};
pub(crate) use source::{Numbers, Precision};
pub use source::{Rows, Source};
