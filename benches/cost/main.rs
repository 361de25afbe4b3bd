//! Times of the first fit and of a slider step, and memory, for growing numbers of samples. All samples are on screen.
//!
//! `cargo bench --bench cost` measures 10⁵ to 3·10⁷ samples. Arguments after `--` are other numbers of samples.

#[path = "../frame/long_recording.rs"]
mod long_recording;

use std::cell::Cell;
use std::sync::Arc;
use std::time::{Duration, Instant};

use loopscope::calibration::FitSettings;
use loopscope::progress::Progress;
use loopscope::questions::{Analyst, Request, View};

use long_recording::long_recording;

/// Number of slider steps. The bench prints the median of their times.
const STEPS: usize = 5;
/// Count of numbers in a sample: a time, six gauges, six loads.
const WIDTH: usize = 13;

fn main() {
    let asked: Vec<usize> = std::env::args().filter_map(|argument| argument.parse().ok()).collect();
    // `cargo test` also runs benches, but without this argument.
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    let sizes = match asked.is_empty() {
        true => vec![100_000, 300_000, 1_000_000, 3_000_000, 10_000_000, 30_000_000],
        false => asked,
    };
    println!(
        "{:>12} {:>12} {:>12} {:>12} {:>12} {:>10} {:>10}",
        "samples",
        "first [ms]",
        "step [ms]",
        "[ns/sample]",
        "preview [ms]",
        "memory [x]",
        "peak [x]"
    );
    for n in sizes {
        report(n);
    }
}

fn report(n: usize) {
    let mut request = Request {
        view: View::All,
        ..Request::fit(Arc::new(long_recording(n)), FitSettings::default())
    };
    let mut analyst = Analyst::default();
    let begin = Instant::now();
    let mut shown = analyst.analyse(&request, &Progress::default());
    let first = begin.elapsed();
    let preview = Cell::new(None);
    let mut steps: Vec<_> = (0..STEPS)
        .map(|at| {
            request.settings.features.look_backs[0].f_th = 3.0 + 0.01 * (at + 1) as f64;
            let begin = Instant::now();
            let show = |_| preview.set(Some(begin.elapsed()));
            let next = analyst.analyse_showing(&request, &Progress::default(), Some(&show));
            let elapsed = begin.elapsed();
            // The previous answer stays on screen until a newer one arrives.
            shown = next;
            elapsed
        })
        .collect();
    steps.sort_unstable();
    let step = steps[STEPS / 2].as_secs_f64();
    assert!(shown.is_ok(), "{shown:?}");
    let times_the_numbers = |bytes: Option<f64>| {
        let ratio = bytes.map(|bytes| bytes / (n * WIDTH * size_of::<f64>()) as f64);
        ratio.map_or_else(|| "-".to_owned(), |ratio| format!("{ratio:.2}"))
    };
    let preview = preview.get().map(|shown: Duration| 1e3 * shown.as_secs_f64());
    println!(
        "{n:>12} {:>12.1} {:>12.1} {:>12.1} {:>12} {:>10} {:>10}",
        1e3 * first.as_secs_f64(),
        1e3 * step,
        1e9 * step / n as f64,
        preview.map_or_else(|| "-".to_owned(), |shown| format!("{shown:.1}")),
        times_the_numbers(memory("VmRSS")),
        times_the_numbers(memory("VmHWM")),
    );
}

/// Returns the memory of this process (bytes) that Linux reports under the name `what`; `None` on other systems.
fn memory(what: &str) -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(what))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(1024.0 * kilobytes)
}
