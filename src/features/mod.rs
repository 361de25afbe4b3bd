//! What a sample is described by: its gauges, and what each chosen block appends.
//!
//! | block | columns | file |
//! |---|---|---|
//! | look-back | the gauges when the load last differed by F_th (Eq. 9-12) | [`look_back`] |
//! | fixed lag | the gauges a fixed time ago | [`fixed_lag`] |
//! | creep | first-order low-passes of the gauges | [`creep`] |
//! | play | play operators on the gauges | [`play`] |
//! | polynomial | squares, products, cubes: no past | [`polynomial`] |
//!
//! Each is causal, runs in bounded memory and starts anew in each recording. Columns enter the fit *standardised*
//! ([`GaugeScale`]), those that are gauges of the past relative to the present one (`(s_past − s) / scale`): where the
//! past never differs they are zero, and the answer is the conventional one. [`Design::columns`] says which column is which.

mod column;
pub mod creep;
mod design;
pub mod fixed_lag;
mod gauge_scale;
pub mod look_back;
pub mod play;
pub mod polynomial;
mod settings;

pub use column::{Column, ColumnKind, History};
pub use design::{Design, FeatureStream};
pub use gauge_scale::GaugeScale;
pub use look_back::{Distance, LiveLookBack, LoadPath, Thresholds};
pub use settings::{FeatureError, FeatureSettings, MOST_COLUMNS};
