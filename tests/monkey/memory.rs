//! Measures the memory of the program over time.

use std::cell::RefCell;
use std::collections::HashMap;
use std::fs::File;
use std::io::Write as _;
use std::rc::Rc;
use std::time::Duration;

use egui::{TextureId, TexturesDelta};
use egui_kittest::TestRenderer;
use loopscope::engine::Engine;

/// Number of rows of the printed table.
const ROWS: usize = 12;
/// Limits of growth that counts as no growth: a share of the memory, and a number of MB.
const STEADY: (f64, f64) = (0.05, 16.0);

/// Sizes of the textures that are allocated and not freed.
#[derive(Clone, Default)]
pub struct Textures(Rc<RefCell<HashMap<TextureId, usize>>>);

impl Textures {
    fn count_and_bytes(&self) -> (usize, usize) {
        let held = self.0.borrow();
        (held.len(), held.values().sum())
    }
}

impl TestRenderer for Textures {
    fn handle_delta(&mut self, delta: &mut TexturesDelta) {
        let mut held = self.0.borrow_mut();
        for (id, images) in delta.set.drain() {
            for image in images.iter().filter(|image| image.is_whole()) {
                let [width, height] = image.image.size();
                held.insert(id, 4 * width * height);
            }
        }
        for id in delta.free.drain() {
            held.remove(&id);
        }
    }
}

struct Point {
    secs: f64,
    resident: f64,
    threads: usize,
    textures: (usize, usize),
    recordings: usize,
    /// Memory of the recordings' numbers (MB).
    loaded: f64,
}

pub struct Curve {
    every: Duration,
    next: Duration,
    points: Vec<Point>,
    /// File to which each point is written immediately, so that no point is lost in a crash.
    file: Option<File>,
}

impl Curve {
    /// Returns an empty curve with one point per interval `every`.
    pub fn new(every: Duration, mut file: Option<File>) -> std::io::Result<Self> {
        if let Some(file) = &mut file {
            writeln!(
                file,
                "secs,resident_mb,threads,textures,texture_mb,recordings,loaded_mb,running"
            )?;
        }
        Ok(Self { every, next: Duration::ZERO, points: Vec::new(), file })
    }

    /// Adds a point if the interval since the last point has passed. `engine` gives the recordings of the window.
    pub fn follow(&mut self, now: Duration, textures: &Textures, engine: Option<&Engine>) {
        if now < self.next {
            return;
        }
        self.next = now + self.every;
        let entries = engine.map_or(&[][..], |engine| engine.project().recordings.entries());
        let numbers = entries.iter().map(|entry| {
            let own = &entry.recording;
            own.n_samples() * (1 + own.n_gauges() + own.axes().len())
        });
        let point = Point {
            secs: now.as_secs_f64(),
            resident: resident(),
            threads: status("Threads:") as usize,
            textures: textures.count_and_bytes(),
            recordings: entries.len(),
            loaded: mb(8 * numbers.sum::<usize>()),
        };
        if let Some(file) = &mut self.file {
            let (count, bytes) = point.textures;
            let running = engine.map(Engine::running).unwrap_or_default();
            let running: Vec<String> = running.into_iter().map(|own| own.title).collect();
            let written = writeln!(
                file,
                "{:.2},{:.2},{},{count},{:.2},{},{:.2},{}",
                point.secs,
                point.resident,
                point.threads,
                mb(bytes),
                point.recordings,
                point.loaded,
                running.join("+").replace(',', ";")
            );
            if let Err(error) = written {
                eprintln!("the curve: {error}");
                self.file = None;
            }
        }
        self.points.push(point);
    }

    /// Prints the curve. Returns true if memory grows.
    pub fn tell(&self) -> bool {
        println!("memory:  secs  MB resident  threads  textures (MB)  recordings (MB)");
        for point in self.points.iter().step_by(self.points.len().div_ceil(ROWS).max(1)) {
            println!(
                "{:13.0}  {:11.1}  {:7}  {:5} ({:5.1})  {:4} ({:7.1})",
                point.secs,
                point.resident,
                point.threads,
                point.textures.0,
                mb(point.textures.1),
                point.recordings,
                point.loaded
            );
        }
        let half = &self.points[self.points.len() / 2..];
        let (Some(first), Some(last)) = (half.first(), half.last()) else {
            return false;
        };
        let n = half.len() as f64;
        let mean = |of: fn(&Point) -> f64| half.iter().map(of).sum::<f64>() / n;
        let (secs, resident) = (mean(|point| point.secs), mean(|point| point.resident));
        let (mut together, mut own) = (0.0, 0.0);
        for point in half {
            together += (point.secs - secs) * (point.resident - resident);
            own += (point.secs - secs).powi(2);
        }
        let slope = if own > 0.0 { together / own } else { 0.0 };
        let gained = slope * (last.secs - first.secs);
        let grows = gained > (STEADY.0 * resident).max(STEADY.1);
        println!(
            "over the last half {:+.2} MB a minute, {gained:+.1} MB of {resident:.0} MB: {}",
            60.0 * slope,
            if grows { "it grows" } else { "steady" }
        );
        grows
    }
}

fn mb(bytes: usize) -> f64 {
    bytes as f64 / 1048576.0
}

pub fn resident() -> f64 {
    status("VmRSS:") / 1024.0
}

/// Returns the number that Linux reports about this process under this name; 0 on other systems.
fn status(name: &str) -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix(name));
    let number = line.and_then(|rest| rest.split_whitespace().next());
    number.and_then(|number| number.parse().ok()).unwrap_or(0.0)
}

/// Returns the processor time of this thread, as reported by Linux.
pub fn thread_time() -> Duration {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = text.split_whitespace().next().and_then(|number| number.parse().ok());
    Duration::from_nanos(nanoseconds.unwrap_or(0))
}
