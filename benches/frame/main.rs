//! Time of one frame of the window with all six axes and all recordings on screen. A frame consists of layout, drawing lists and
//! tessellation, without a graphics card. Then follow the time of a frame with loops relative to a frame with traces, and the delay
//! of frames at the rate of a display during background work.
//!
//! `cargo bench --bench frame -- beside` measures only frames with loops relative to frames with traces.

mod beside;
mod long_recording;
mod paced;
mod screen;

use std::sync::Arc;

use criterion::{Criterion, criterion_group};
use loopscope::recording::{RecordingSet, simulated};
use loopscope::ui::{Command, pane};

use long_recording::long_recording;
use screen::Screen;

type MakeSet = Arc<dyn Fn() -> RecordingSet>;

fn frame(c: &mut Criterion) {
    let mut group = c.benchmark_group("frame, six axes, all on screen");
    group.sample_size(50);
    let sensor = simulated::recordings(simulated::DEFAULT_SEED);
    let sets: [(&str, MakeSet); 2] = [
        ("243,000 samples", Arc::new(move || sensor.clone())),
        ("20,000,000 samples", Arc::new(|| long_recording(20_000_000))),
    ];
    for (name, set) in sets {
        let mut screen = Screen::showing(set());
        group.bench_function(format!("{name}, at rest"), |b| b.iter(|| screen.frame(None)));
        let mut x = 700.0;
        group.bench_function(format!("{name}, pointer moving over a trace"), |b| {
            b.iter(|| {
                x = if x > 900.0 { 700.0 } else { x + 1.0 };
                screen.frame(Some(egui::pos2(x, 150.0)));
            });
        });
        for (shown, what) in
            [(pane("loops").unwrap(), "loop pane"), (pane("metrology").unwrap(), "metrology")]
        {
            screen.shell.send(Command::ShowPane(shown));
            screen.settle();
            group.bench_function(format!("{name}, {what}"), |b| b.iter(|| screen.frame(None)));
        }
    }
    group.finish();
}

criterion_group!(benches, frame);

fn main() {
    benches();
    // `cargo test` also runs benches, but without this argument.
    let is_asked = |word| std::env::args().any(|argument| argument == word);
    if is_asked("--bench") {
        beside::report();
        if !is_asked("beside") {
            paced::report();
        }
    }
    Criterion::default().configure_from_args().final_summary();
}
