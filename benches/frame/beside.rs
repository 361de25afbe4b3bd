//! Time of a frame with loops, relative to a frame with the traces of the same samples. Time of a frame with traces, relative to
//! the same panes zoomed in to one or two samples.

use std::time::Instant;

use loopscope::engine::Action;
use loopscope::questions::View;
use loopscope::recording::simulated;
use loopscope::ui::{Command, TimeMove, pane};

use crate::long_recording::long_recording;
use crate::screen::Screen;

/// Number of frames of each kind; the bench prints the median of their times.
const FRAMES: usize = 200;

pub fn report() {
    println!("a frame at rest, median of {FRAMES} [ms]");
    println!(
        "{:<24} {:>8} {:>8} {:>8} {:>16} {:>16}",
        "samples", "empty", "traces", "loops", "traces : empty", "loops : traces"
    );
    let sensor = || simulated::recordings(simulated::DEFAULT_SEED);
    // 2,700 samples are drawn as lines, the two larger numbers as density.
    row("2,700, one recording", Screen::showing(sensor()), View::One(0));
    row("243,000", Screen::showing(sensor()), View::All);
    row("20,000,000", Screen::showing(long_recording(20_000_000)), View::All);
}

fn row(name: &str, mut screen: Screen, view: View) {
    screen.shell.send(Action::Show(view));
    let mut shown = |key: &str, zoom: TimeMove| {
        let shown = pane(key).expect("the pane exists");
        screen.shell.send(Command::ShowPane(shown));
        screen.shell.send(Command::Time(zoom));
        screen.settle();
        median_ms(&mut screen)
    };
    let traces = shown("traces", TimeMove::Fit);
    let loops = shown("loops", TimeMove::Fit);
    let empty = shown("traces", TimeMove::Zoom(1e-9));
    println!(
        "{name:<24} {empty:>8.2} {traces:>8.2} {loops:>8.2} {:>16.2} {:>16.2}",
        traces / empty,
        loops / traces
    );
}

fn median_ms(screen: &mut Screen) -> f64 {
    let mut all: Vec<f64> = (0..FRAMES)
        .map(|_| {
            let start = Instant::now();
            screen.frame(None);
            1e3 * start.elapsed().as_secs_f64()
        })
        .collect();
    all.sort_unstable_by(f64::total_cmp);
    all[FRAMES / 2]
}
