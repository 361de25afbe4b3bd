//! Which recordings a calibration comes from, so that whoever has both can tell whether they belong together.

use serde::{Deserialize, Serialize};

use crate::recording::Role;

/// A recording that a calibration was fitted to or scored on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct UsedRecording {
    /// Its name.
    pub name: String,
    /// What it was used for.
    pub role: Role,
    /// The name of the file it was read from, without its folder; `None` for the built-in simulated sensor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// SHA-256 of that file in hexadecimal digits; `None` where there is no file, or it could not be read again.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sha256: Option<String>,
}
