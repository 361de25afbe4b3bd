//! Reads any bytes as a column map. A valid map must be unchanged after it is written and read again.
#![no_main]

use libfuzzer_sys::fuzz_target;
use loopscope::import::map::ColumnMap;

fuzz_target!(|text: &[u8]| {
    if let Ok(map) = ColumnMap::from_json(text) {
        let mut written = Vec::new();
        map.write_json(&mut written).expect("writing to a list cannot fail");
        assert_eq!(ColumnMap::from_json(&written).expect("a written map is valid"), map);
    }
});
