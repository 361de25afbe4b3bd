//! The one way from a file to its recordings, for the window, sessions and the command line.

use std::path::Path;

use super::inspect::map_for;
use super::load::{Loaded, Reading};
use super::map::ColumnMap;
use crate::import::error::ReadError;
use crate::progress::Progress;

/// Reads one file, of any format that is known; its first bytes say which, not its name.
///
/// With a map, the file is read as it says, and the file of its reference if it names one. Without one, the names of the
/// columns say what they are: a time, 1 to 64 gauges, and the axes of the reference load if there is one; other columns
/// are not looked at. Where names settle too little, the first of the `remembered` maps is taken that was made for files
/// like this one; [`Loaded::map`] says by which map the file was read. A pause or a step back in time starts a new
/// recording.
///
/// `progress` advances by bytes; whoever shows it adds the size of the file to its total. What is read besides, a second
/// file or the same one for its second clock, is added here.
///
/// **Units** those of the map, then those that the header names; without one newtons, newton metres, and what the times
/// look like.
///
/// # Errors
/// [`ReadError`] if the file cannot be read, is no such table, has no usable row, the map is for another kind of file,
/// two clocks have no time in common, or `progress` is cancelled.
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
