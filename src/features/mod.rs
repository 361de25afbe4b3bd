//! Features of a sample, from which a fit computes the load: its gauges, and the columns of each chosen feature block.
//!
//! The look-back ([`look_back`], Eq. 9-12 of Koike et al. 2019) selects a past sample by its load difference. The other
//! feature blocks are listed in [`BLOCKS`]. Each of them is one file that implements [`Block`]. The fields of the window, the
//! options of the command line, the exported code and the tables of the guide follow from this trait.
//!
//! Feature blocks are causal, run in bounded memory and start anew in each recording. The fit uses standardised columns
//! ([`GaugeScale`]). Past gauges are differences from the present gauges, `(s_past − s) / scale`. If the past gauges equal
//! the present ones, the differences are zero, and the fit is the conventional calibration. [`Design::columns`] lists the
//! columns.

mod block;
mod blocks;
mod channel;
mod column;
mod design;
mod gauge_scale;
mod kept;
pub(crate) mod look_back;
mod monomial;
mod setting;
mod settings;
mod source;

pub(crate) use block::{Appends, Block, Lists, MOST_RISE, STORED_SAMPLES, Search};
pub(crate) use blocks::BLOCKS;
pub use blocks::{Auxiliary, Creep, FixedLag, Play, Polynomial};
pub(crate) use channel::{AuxiliaryChannel, named};
pub use column::Column;
pub(crate) use column::ColumnKind;
pub use design::Design;
pub(crate) use design::{FeatureStream, next_share};
pub(crate) use gauge_scale::GaugeScale;
pub(crate) use look_back::{Distance, F_TH, HISTORY_RATE, LiveLookBack, T_TH};
pub use look_back::{LoadPath, Thresholds};
pub use setting::MAX_COLUMNS;
pub use setting::listed;
pub(crate) use setting::{Choice, FeatureError, Range, Setting, Unit};
pub use settings::{Blocks, FeatureSettings, Stored};
pub(crate) use source::{Numbers, Precision};
pub use source::{Rows, Source};
