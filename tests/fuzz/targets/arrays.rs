//! Any bytes behind the first ones of a file of arrays: the first byte chooses which.
#![no_main]

use std::io::Write as _;

use libfuzzer_sys::fuzz_target;
use loopscope::progress::Progress;
use loopscope::recording::delimited::read;

const STARTS: [&[u8]; 4] = [
    b"\x93NUMPY\x01\x00",
    b"PK\x03\x04",
    b"MATLAB 5.0 MAT-file",
    b"\x89MCAP0\r\n",
];

fuzz_target!(|content: &[u8]| {
    let Some((first, rest)) = content.split_first() else {
        return;
    };
    let mut start = STARTS[usize::from(*first) % STARTS.len()].to_vec();
    if start.starts_with(b"MATLAB") {
        start.resize(124, b' ');
        start.extend(b"\x00\x01IM");
    }
    let mut file = tempfile::NamedTempFile::new().expect("a file can be made");
    file.write_all(&[&start[..], rest].concat())
        .expect("the file can be written");
    if let Ok(loaded) = read(file.path(), &Progress::default()) {
        assert!(!loaded.recordings.is_empty());
    }
});
