//! Reads any file with any column map. The input holds the map up to the first zero byte, then the file.
#![no_main]

use std::io::Write as _;

use libfuzzer_sys::fuzz_target;
use loopscope::progress::Progress;
use loopscope::import::map::ColumnMap;
use loopscope::import::read;

fuzz_target!(|input: &[u8]| {
    let Some(end) = input.iter().position(|byte| *byte == 0) else {
        return;
    };
    // Only the file of the input may be read, never a file that a random map names.
    let Ok(map) = ColumnMap::from_json(&input[..end]).map(|map| ColumnMap { reference: None, ..map }) else {
        return;
    };
    let mut file = tempfile::NamedTempFile::new().expect("a file can be made");
    file.write_all(&input[end + 1..]).expect("the file can be written");
    let _ = read(file.path(), Some(&map), &[], &Progress::default());
});
