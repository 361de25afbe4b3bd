//! Inspects and reads any bytes as a recording. Inspecting and reading must agree whether the file can be read.
#![no_main]

use std::io::Write as _;

use libfuzzer_sys::fuzz_target;
use loopscope::progress::Progress;
use loopscope::import::inspect::{Known, inspect};
use loopscope::import::read;

fuzz_target!(|content: &[u8]| {
    let mut file = tempfile::NamedTempFile::new().expect("a file can be made");
    file.write_all(content).expect("the file can be written");
    let progress = Progress::default();
    let loaded = read(file.path(), None, &[], &progress);
    if let Ok(loaded) = &loaded {
        assert!(!loaded.recordings.is_empty());
    }
    if let Ok(inspection) = inspect(file.path(), Known::Nothing, &progress) {
        let _ = inspection.map.write_json(&mut Vec::new());
        if let (Ok(loaded), None) = (loaded, &inspection.check.error) {
            assert_eq!(loaded.recordings.len(), inspection.check.recordings.len());
        }
    }
});
