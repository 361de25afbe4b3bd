//! The files of the recordings that a calibration uses, with the hashes of their contents.

use std::collections::HashMap;
use std::path::Path;

use crate::{
    calibration::{Calibration, UsedRecording},
    export::hash::sha256,
    recording::{RecordingSet, Role},
    shown::file_name,
};

/// Returns every recording of a set with its role, the name of its file, and the present SHA-256 of the file. Each file is
/// read once, even for several recordings. A file that cannot be read has no hash.
pub fn used_recordings(recordings: &RecordingSet) -> Vec<UsedRecording> {
    let mut hashes: HashMap<&Path, Option<String>> = HashMap::new();
    recordings
        .entries()
        .iter()
        .map(|entry| {
            let path = entry.recording.source().path();
            UsedRecording {
                name: entry.recording.name().to_owned(),
                role: entry.role,
                file: path.map(|path| file_name(path).into_owned()),
                sha256: path.and_then(|path| {
                    let hash = hashes.entry(path).or_insert_with(|| sha256(path).ok());
                    hash.clone()
                }),
            }
        })
        .collect()
}

/// Returns a calibration with the names and hashes of the files that it was fitted to and tested on. Each call reads every
/// file again. So it is called when a calibration is written, not in a fit.
pub fn with_sources(calibration: &Calibration, recordings: &RecordingSet) -> Calibration {
    let used = used_recordings(recordings).into_iter();
    Calibration {
        sources: used.filter(|used| used.role != Role::Off && used.file.is_some()).collect(),
        ..calibration.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{Axis, Entry, Recording, Source, simulated};

    fn entry(path: &Path, role: Role) -> Entry {
        let recording = Recording::new(
            "run",
            Source::File(path.to_owned()),
            vec![0.0],
            vec!["S1".to_owned()],
            vec![1.0],
            vec![Axis::Fz],
            vec![2.0],
        );
        Entry::new(recording.unwrap(), role)
    }

    #[test]
    fn a_file_is_identified_by_its_content_and_a_lost_file_by_its_name() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("abc.csv");
        std::fs::write(&path, "abc").unwrap();
        let mut set = RecordingSet::default();
        set.push(entry(&path, Role::Train)).unwrap();
        set.push(entry(Path::new("gone/lost.csv"), Role::Test)).unwrap();
        let used = used_recordings(&set);
        assert_eq!(
            used[0].sha256.as_deref(),
            Some("ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad")
        );
        assert_eq!((used[0].role, used[1].role), (Role::Train, Role::Test));
        assert_eq!(used[1].file.as_deref(), Some("lost.csv"));
        assert_eq!(used[1].sha256, None);
        let simulated = used_recordings(&simulated::recordings(1));
        assert!(simulated.iter().all(|used| used.file.is_none()));
    }
}
