use serde::{Deserialize, Serialize};

use crate::recording::Role;

/// Recording on which a calibration was fitted or scored.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct UsedRecording {
    pub name: String,
    pub role: Role,
    /// Name of the file without its folder; `None` for the built-in simulated sensor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// SHA-256 of the file in hexadecimal, by which the file can be recognised; `None` if the file could not be read again.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sha256: Option<String>,
}
