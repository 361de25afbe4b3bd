use std::path::Path;

use super::{
    abandonable::abandonable,
    inspect::map_for,
    load::{Loaded, Reading},
    map::ColumnMap,
};
use crate::{import::error::ReadError, progress::Progress};

/// Reads one file of any known format. The first bytes of the file show the format; the name of the file does not matter.
///
/// With a column map, the file is read as the map describes. If the map names a separate file with the reference load, this
/// file is read, too. Without a map, names, units and values of the columns propose their roles; what a map leaves out and does
/// not ignore is proposed, too. If the names do not suffice, the first of the `remembered` maps that fits the file is used.
/// [`Loaded::map`] holds the map that was used. A pause or a step back in time starts a new recording.
///
/// `progress` counts the bytes that were read. The caller adds the size of the file to the total of `progress`. If a second
/// file is read, or the same file a second time, this function adds its size.
///
/// **Units** of columns are those of the map, else those of the header. Without either, loads are taken to be in N and N·m,
/// and the unit of times is derived from their values.
///
/// # Errors
/// [`ReadError`] if the file cannot be read, it has no table or no usable row, the map is for another kind of file, the
/// times of gauges and reference do not overlap, or `progress` is cancelled.
///
/// # Panics
/// If a thread cannot be started, or a defect of the program shows.
pub fn read(
    path: &Path,
    map: Option<&ColumnMap>,
    remembered: &[ColumnMap],
    progress: &Progress,
) -> Result<Loaded, ReadError> {
    let (at, map, remembered) = (path.to_owned(), map.cloned(), remembered.to_vec());
    abandonable(path, progress, move |progress| {
        let reading = Reading::whole(progress);
        let read = reading.load(&at, map.as_ref());
        let is_unsure = match &read {
            Ok(loaded) => !loaded.mapped.is_certain,
            Err(error) => error.wants_a_map(),
        };
        if map.is_none()
            && is_unsure
            && !remembered.is_empty()
            && let Some(map) = map_for(&at, &remembered, progress)?
        {
            return reading.load(&at, Some(map));
        }
        read
    })
}
