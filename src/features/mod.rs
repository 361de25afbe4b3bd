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
mod column;
mod design;
mod gauge_scale;
pub mod look_back;
mod monomial;
mod setting;
mod settings;
mod source;

pub use block::{Appends, Block, Lists, Search, Stream};
pub use blocks::{BLOCKS, Creep, FixedLag, Play, Polynomial};
pub use column::{Column, ColumnKind, History};
pub use design::{Design, FeatureStream};
pub use gauge_scale::GaugeScale;
pub use look_back::{Distance, F_TH, LiveLookBack, LoadPath, T_TH, Thresholds};
pub use monomial::Monomial;
pub use setting::{Choice, OutOfRange, Range, Setting, Unit, listed};
pub use settings::{Blocks, FeatureError, FeatureSettings, MOST_COLUMNS, Stored};
pub use source::{Code, Constant, Memory, Numbers, Precision, Rows, Source};
