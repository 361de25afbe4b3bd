use serde::{Deserialize, Serialize};

use crate::recording::Role;

/// Recording that a calibration was fitted to or scored on, so that files and calibration can be matched.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct UsedRecording {
    pub name: String,
    pub role: Role,
    /// Name of the file without its folder; `None` for the built-in simulated sensor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// SHA-256 of the file in hexadecimal; `None` without file, or if the file could not be read again.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sha256: Option<String>,
}
