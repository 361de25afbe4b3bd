//! What a frame with loops costs beside one with the traces of the same samples, which should not be more; and one with traces
//! beside one of the same panes zoomed in so far that they are empty but for a sample or two.

use std::time::Instant;

use loopscope::engine::Action;
use loopscope::questions::View;
use loopscope::recording::simulated;
use loopscope::ui::{Command, TimeMove, pane};

use crate::long_recording::long_recording;
use crate::screen::Screen;

/// So many frames of each are drawn; their median counts.
const FRAMES: usize = 200;

/// Prints a table of frames.
pub fn report() {
    println!("a frame at rest, median of {FRAMES} [ms]");
    println!(
        "{:<24} {:>8} {:>8} {:>8} {:>16} {:>16}",
        "samples", "empty", "traces", "loops", "traces : empty", "loops : traces"
    );
    let sensor = || simulated::recordings(simulated::DEFAULT_SEED);
    // Few enough for lines, all of the built-in sensor, and very many: both by their density.
    row("2,700, one recording", Screen::showing(sensor()), View::One(0));
    row("243,000", Screen::showing(sensor()), View::All);
    row("20,000,000", Screen::showing(long_recording(20_000_000)), View::All);
}

fn row(name: &str, mut screen: Screen, view: View) {
    screen.shell.send(Action::Show(view));
    let mut shown = |key: &str, zoom: TimeMove| {
        let shown = pane(key).expect("there is such a pane");
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
