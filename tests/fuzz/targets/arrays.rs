//! Reads files of arrays. A file that starts like one of the formats is read unchanged; `../formats` holds such files. Before any other
//! file, the start of a format is inserted. The first byte of the file selects the format.
#![no_main]

use std::io::Write as _;

use libfuzzer_sys::fuzz_target;
use loopscope::progress::Progress;
use loopscope::formats::FileError;
use loopscope::import::{ReadError, read};

const STARTS: [&[u8]; 10] = [
    b"\x93NUMPY\x01\x00",
    b"PK\x03\x04",
    b"MATLAB 5.0 MAT-file",
    b"MATLAB 7.3 MAT-file",
    b"\x89HDF\r\n\x1a\n",
    b"LabVIEW Measurement\n***End_of_Header***\n",
    b"\0\0\0\0\x02\0\0\0\x02\0\0\0\0\0\0\0\x02\0\0\0S\0",
    b"{\"t\": 0, \"S1\": 1}\n{\"t\": 1, \"S1\": 2}\n",
    b"\x89MCAP0\r\n",
    PARQUET,
];
const PARQUET: &[u8] = b"PAR1";
const BY_CRATES: [&[u8]; 4] = [PARQUET, b"PK\x03\x04", b"MATLAB 7.3", b"\x89HDF"];

fn file(content: &[u8]) -> Vec<u8> {
    let is_start = |start: &&[u8]| content.starts_with(&start[..4]);
    if STARTS.iter().any(is_start) {
        return content.to_vec();
    }
    let Some((first, rest)) = content.split_first() else {
        return Vec::new();
    };
    let mut file = STARTS[usize::from(*first) % STARTS.len()].to_vec();
    if file.starts_with(b"MATLAB") {
        file.resize(124, b' ');
        file.extend(b"\x00\x01IM");
    }
    let is_parquet = file == PARQUET;
    file.extend(rest);
    if is_parquet {
        // A Parquet file ends with a description of its contents and the length of this description.
        file.extend((rest.len() as u32).to_le_bytes());
        file.extend(PARQUET);
    }
    file
}

fuzz_target!(|content: &[u8]| {
    let content = file(content);
    let mut file = tempfile::NamedTempFile::new().expect("a file can be made");
    file.write_all(&content).expect("the file can be written");
    match read(file.path(), None, &[], &Progress::default()) {
        Ok(loaded) => assert!(!loaded.recordings.is_empty()),
        // The crates for these formats may panic on damaged files, which becomes an error. Nothing else may panic.
        Err(ReadError::File {
            source: FileError::ReaderFailed(panicked),
            ..
        }) if !BY_CRATES.iter().any(|start| content.starts_with(start)) => panic!("{panicked}"),
        Err(_) => {}
    }
});
