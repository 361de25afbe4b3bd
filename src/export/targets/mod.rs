//! The formats of calibration files, one source file each. [`TARGETS`] is the only list of them.

mod c_array;
mod c_header;
mod cal;
mod csv;
mod json;
mod m_function;
mod matlab;
mod matrix;
mod numpy;
mod package;
mod python;
mod rust;
mod yaml;

use std::path::{Path, is_separator};

pub use self::cal::name_gauges;
pub(super) use self::package::files;
use super::target::Target;
use crate::shown::joined;

/// All formats of calibration files. The first one holds the complete calibration.
pub static TARGETS: &[&Target] = &[
    &json::JSON,
    &c_header::C_HEADER,
    &rust::RUST,
    &python::PYTHON,
    &m_function::M_FUNCTION,
    &package::PACKAGE,
    &yaml::YAML,
    &cal::CAL,
    &c_array::C_ARRAY,
    &csv::CSV,
    &numpy::NUMPY,
    &matlab::MATLAB,
];

/// Returns the format that the file name ending selects. A path that names a folder selects the format of libraries.
pub fn target_for(path: &Path) -> Option<&'static Target> {
    if asks_for_folder(path) {
        return Some(&package::PACKAGE);
    }
    let ending = path.extension()?.to_str()?.to_ascii_lowercase();
    TARGETS.iter().copied().find(|target| target.endings.contains(&&*ending))
}

/// Returns the format of a file to be written. If the file name ending belongs to no format, returns a message that lists the
/// endings.
pub fn known_target(path: &Path) -> Result<&'static Target, String> {
    target_for(path).ok_or_else(|| {
        let (path, endings) = (path.display(), target_endings());
        format!("{path}: this file name ending is no export format; use one of {endings}")
    })
}

pub(super) fn asks_for_folder(path: &Path) -> bool {
    let last = path.as_os_str().as_encoded_bytes().last();
    last.is_some_and(|last| is_separator(char::from(*last)))
}

/// Returns true if the format of this file contains the names of the gauges. Otherwise gauges are identified by their order.
pub fn names_gauges(path: &Path) -> bool {
    target_for(path).is_none_or(|target| target.names_gauges)
}

/// Returns the usual file name endings of all formats with their dots, for messages.
pub fn target_endings() -> String {
    joined(" ", TARGETS.iter().map(|target| format!(".{}", target.endings[0])))
}

/// Returns a list of all formats with their file name endings, for help texts.
pub fn listed_targets() -> String {
    let listed = |target: &&Target| format!(".{} {}", target.endings.join(" ."), target.name);
    joined(", ", TARGETS.iter().map(listed))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_guide_lists_every_format() {
        let rows = TARGETS.iter().map(|target| {
            let endings = target.endings.iter().map(|ending| format!("`.{ending}`"));
            let reads_back = match (target.reader, target.names_gauges) {
                (None, _) => "no",
                (Some(_), true) => "yes",
                (Some(_), false) => "yes, gauges in file order",
            };
            let endings = endings.collect::<Vec<_>>().join(", ");
            format!("| {endings} | {} | {} | {reads_back} |\n", target.name, target.holds)
        });
        let table = format!(
            "| file | format | holds | reads back |\n|---|---|---|---|\n{}",
            rows.collect::<String>()
        );
        let guide = include_str!("../../../assets/guide/exports.md");
        assert!(guide.contains(&table), "assets/guide/exports.md needs\n{table}");
    }
}
