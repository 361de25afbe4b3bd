//! Delay between a display's request for an image and the complete image, while the program works in the background.

use std::time::{Duration, Instant};

use loopscope::calibration::Regressor;
use loopscope::engine::{Action, Edit};
use loopscope::questions::Candidates;
use loopscope::recording::{RecordingSet, simulated};
use loopscope::ui::{Command, Workspace};

use crate::long_recording::long_recording;
use crate::screen::Screen;

/// Time of one frame of a display.
const FRAME: Duration = Duration::from_nanos(16_666_667);
/// Number of requested images.
const FRAMES: u32 = 300;

/// Pause after a window is closed, in which its memory is freed.
const CALM: Duration = Duration::from_secs(3);

/// Background work while images are requested.
#[derive(Clone, Copy, Debug)]
enum Work {
    Nothing,
    /// The user drags F_th: every image has a new value, so all fits are repeated.
    Slider,
    /// The user drags F_th, with the map of thresholds on screen.
    SliderAndMap,
    /// A network trains on all samples.
    Network,
    /// All regressors of the paper are compared, with two networks at a time.
    Comparison,
}

pub fn report() {
    println!(
        "from the moment when a display asks (60 times a second) to the picture, pointer moving over a trace [ms]"
    );
    println!(
        "{:<22} {:<14} {:>8} {:>8} {:>8} {:>10} {:>11}",
        "samples", "meanwhile", "median", "95 %", "worst", "> 1 frame", "> 2 frames"
    );
    let sensor = simulated::recordings(simulated::DEFAULT_SEED);
    let all = [Work::Nothing, Work::Slider, Work::SliderAndMap, Work::Network, Work::Comparison];
    rows("243,000", &sensor, &all);
    let long = long_recording(20_000_000);
    rows("20,000,000", &long, &all[..3]);
}

fn rows(name: &str, recordings: &RecordingSet, all: &[Work]) {
    for work in all {
        let mut delays = delays(recordings.clone(), *work);
        delays.sort_unstable();
        let at = |share: f64| {
            let at = (share * (delays.len() - 1) as f64) as usize;
            1e3 * delays[at].as_secs_f64()
        };
        let later = |than: u32| delays.iter().filter(|delay| **delay > than * FRAME).count();
        println!(
            "{name:<22} {:<14} {:>8.2} {:>8.2} {:>8.2} {:>10} {:>4} of {}",
            format!("{work:?}"),
            at(0.5),
            at(0.95),
            at(1.0),
            later(1),
            later(2),
            delays.len()
        );
    }
}

fn delays(recordings: RecordingSet, work: Work) -> Vec<Duration> {
    // While the threads of the previous window free gigabytes, times would be too long.
    std::thread::sleep(CALM);
    let mut screen = Screen::showing(recordings);
    begin(&mut screen, work);
    for _ in 0..20 {
        screen.frame(None);
    }
    let mut x = 700.0;
    let mut due = Instant::now();
    let mut delays = Vec::new();
    for at in 0..FRAMES {
        due += FRAME;
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
        if matches!(work, Work::Slider | Work::SliderAndMap) {
            let mut settings = screen.shell.engine().project().settings.clone();
            settings.features.look_backs[0].f_th = 2.0 + 0.01 * f64::from(at % 200);
            screen.shell.send(Edit::Settings(settings));
        }
        x = if x > 900.0 { 700.0 } else { x + 1.0 };
        screen.frame(Some(egui::pos2(x, 150.0)));
        delays.push(due.elapsed());
        // A display does not request a missed image again.
        while due.elapsed() > FRAME {
            due += FRAME;
        }
    }
    if matches!(work, Work::Network | Work::Comparison) {
        assert!(screen.shell.is_busy(), "the work ended too early to be measured");
    }
    delays
}

fn begin(screen: &mut Screen, work: Work) {
    match work {
        Work::Nothing | Work::Slider => {}
        Work::SliderAndMap => screen.shell.send(Command::Show(Workspace::Thresholds)),
        Work::Network => {
            let mut settings = screen.shell.engine().project().settings.clone();
            settings.regressor = Regressor::Network;
            screen.shell.send(Edit::Settings(settings));
            screen.settle();
            let start = Action::Train;
            screen.shell.send(start);
        }
        Work::Comparison => {
            let start = Action::FindBest(Candidates::Paper, Duration::MAX);
            screen.shell.send(start);
        }
    }
}
