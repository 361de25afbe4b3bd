use loopscope::recording::{Axis, Entry, Recording, RecordingSet, Role, Source};

pub fn long_recording(n: usize) -> RecordingSet {
    let wave = |k: usize, phase: usize| {
        let t = k as f64 * 1e-3;
        let noise = ((k * 7 + phase * 13) % 101) as f64 * 1e-3;
        (t * (0.3 + 0.01 * phase as f64)).sin() + noise
    };
    let rows = || (0..n).flat_map(|k| (0..6).map(move |phase| wave(k, phase)));
    let recording = Recording::new(
        "long",
        Source::Simulated,
        (0..n).map(|k| k as f64 * 1e-3).collect(),
        (1..=6).map(|gauge| format!("S{gauge}")).collect(),
        rows().collect(),
        Axis::ALL.to_vec(),
        rows().map(|value| 10.0 * value).collect(),
    )
    .expect("the recording is whole");
    let mut set = RecordingSet::default();
    set.push(Entry::new(recording, Role::Train)).expect("the set is empty");
    set
}
