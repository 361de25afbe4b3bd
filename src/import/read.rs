use std::path::Path;

use super::inspect::map_for;
use super::load::{Loaded, Reading};
use super::map::ColumnMap;
use crate::import::error::ReadError;
use crate::progress::Progress;

/// Reads one file of any known format. Its first bytes select the format, not its name.
///
/// With a map, the file is read as the map describes, with the file of its reference if the map names one. Without a map,
/// the names of the columns give their roles: a time, 1 to 64 gauges, and the axes of the reference load if there is one.
/// Other columns are ignored. If the names do not suffice, the first of the `remembered` maps that fits is used;
/// [`Loaded::map`] holds the used map. A pause or a step back in time starts a new recording.
///
/// `progress` advances by bytes; the caller adds the size of the file to its total. Sizes of further reads, such as a second
/// file or a second clock in the same file, are added here.
///
/// **Units** of the map, else of the header, else N, N·m, and for times a unit derived from their values.
///
/// # Errors
/// [`ReadError`] if the file cannot be read, has no table or usable row, the map is for another kind of file, two clocks have
/// no common time, or `progress` is cancelled.
pub fn read(
    path: &Path,
    map: Option<&ColumnMap>,
    remembered: &[ColumnMap],
    progress: &Progress,
) -> Result<Loaded, ReadError> {
    let reading = Reading::whole(progress);
    match reading.load(path, map) {
        Err(error) if map.is_none() && error.wants_a_map() => {
            match map_for(path, remembered, progress)? {
                Some(map) => reading.load(path, Some(map)),
                None => Err(error),
            }
        }
        read => read,
    }
}
