//! A monkey test of the window without a display: random clicks, drags, keys, words, files and sizes, from a seed. Start it by hand:
//!
//! ```text
//! cargo test --test monkey -- [--seed N] [--minutes M | --steps N] [--samples N] [--memory curve.csv] [FILE…]
//! cargo test --test monkey -- --soak 10000 [FILE…]      only moves F_th and t_th; memory must not grow
//! ```
//!
//! The test opens FILEs, `--samples` of a generated sensor, or the built-in sensor. It writes only into a temporary folder. It prints
//! the actions, the longest frames with the action before each, each panic with seed and step, and the memory over time. It fails on
//! a panic, on a frame of more than a second, on more memory than `--ceiling`, and if memory grows in a soak. After a failure it
//! prints the last actions. Background threads do not depend on the seed, so a repeated run may differ.

#[path = "../support/dropped.rs"]
mod dropped;
mod hands;
mod memory;

use std::cell::RefCell;
use std::collections::VecDeque;
use std::fmt::Write as _;
use std::io::{BufWriter, Write as _};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::rc::Rc;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use clap::Parser;
use egui::accesskit::Role;
use egui::{Event, ViewportCommand, ViewportId};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};

use loopscope::engine::Preferences;
use loopscope::ui::{Dialogs, PathFor, Reply, Shell, chosen};

use dropped::Dropped;
use hands::{Hands, Random};
use memory::{Curve, Textures};

/// Duration from which a frame counts as a freeze.
const FROZEN: Duration = Duration::from_secs(1);
/// Number of frames in the printed list of the longest frames.
const LISTED: usize = 8;
/// Number of recent actions that a failure lists.
const REMEMBERED: usize = 20;
/// Maximum times to wait for background results: usual, and occasional.
const PATIENCE: [Duration; 2] = [Duration::from_secs(1), Duration::from_secs(20)];
/// Interval between two checks of the watchdog, which ends a hanging test.
const WATCH: Duration = Duration::from_millis(50);
/// Duration of a frame after which the watchdog ends the test.
const HUNG: Duration = Duration::from_secs(60);
/// Maximum time to wait for a background result in a soak test.
const HANGS: Duration = Duration::from_secs(60);
/// Number of slider moves between two waits for background results.
const MOVES_PER_REST: u64 = 25;

#[derive(Parser)]
struct Choices {
    /// Seed of the random actions.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[arg(long, default_value_t = 1.0)]
    minutes: f64,
    /// Maximum number of actions.
    #[arg(long, default_value_t = u64::MAX)]
    steps: u64,
    /// Number of moves of the threshold sliders; no other actions are done.
    #[arg(long)]
    soak: Option<u64>,
    /// Opens a generated recording with this number of samples.
    #[arg(long)]
    samples: Option<usize>,
    /// Memory above which the test fails at once (MB).
    #[arg(long, default_value_t = 6000.0)]
    ceiling: f64,
    /// CSV file for the memory over time.
    #[arg(long)]
    memory: Option<PathBuf>,
    /// Interval between two points of the memory curve (s).
    #[arg(long, default_value_t = 5.0)]
    every: f64,
    files: Vec<PathBuf>,
}

struct World {
    folder: PathBuf,
    files: Vec<PathBuf>,
    log: Log,
    random: Random,
}

/// A growing log file. The rows of a recording are appended repeatedly.
struct Log {
    path: PathBuf,
    rows: Vec<String>,
    written: usize,
}

impl Log {
    /// Returns a log that repeats the rows of the text file `source`.
    fn new(path: PathBuf, source: &Path) -> std::io::Result<Self> {
        let mut head = vec![0; 200_000];
        let read = std::io::Read::read(&mut std::fs::File::open(source)?, &mut head)?;
        let head = String::from_utf8_lossy(&head[..read]);
        let rows: Vec<String> = head.lines().map(|row| format!("{row}\n")).collect();
        let mut log = Self { path, rows, written: 0 };
        std::fs::write(&log.path, "")?;
        log.grow(100)?;
        Ok(log)
    }

    fn grow(&mut self, n: usize) -> std::io::Result<()> {
        let rows = self.rows.len() - 1; // the last row may be incomplete
        let mut text = String::new();
        for _ in 0..n {
            // The header is written only once.
            let at = if self.written < rows { self.written } else { 1 + self.written % (rows - 1) };
            text.push_str(&self.rows[at]);
            self.written += 1;
        }
        let mut file = std::fs::OpenOptions::new().append(true).open(&self.path)?;
        file.write_all(text.as_bytes())
    }
}

#[derive(Clone)]
struct AnyFile(Rc<RefCell<World>>);

impl AnyFile {
    fn one(&self) -> PathBuf {
        let world = &mut *self.0.borrow_mut();
        world.random.of(&world.files).clone()
    }
}

impl Dialogs for AnyFile {
    fn ask(&mut self, what: PathFor, reply: Reply) {
        let path = match &what {
            PathFor::Locate => return,
            PathFor::Open | PathFor::Import => self.one(),
            PathFor::Follow => self.0.borrow().log.path.clone(),
            PathFor::Save(content) => {
                let world = &mut *self.0.borrow_mut();
                let endings: Vec<&str> =
                    (content.formats().into_iter()).flat_map(|(_, endings)| endings).collect();
                let usual = Path::new(content.usual_name());
                let ending = if endings.is_empty() {
                    usual.extension().map_or("", |ending| ending.to_str().unwrap_or(""))
                } else {
                    world.random.of(&endings)
                };
                world.folder.join(format!("saved_{}.{ending}", world.random.below(3)))
            }
        };
        if let Some(command) = chosen(what, vec![path]) {
            reply.send(command);
        }
    }
}

/// Recent actions, and the start of the present frame. The watchdog thread also reads them.
#[derive(Clone, Default)]
struct Last(Arc<Mutex<(VecDeque<String>, Option<Instant>)>>);

impl Last {
    fn held(&self) -> std::sync::MutexGuard<'_, (VecDeque<String>, Option<Instant>)> {
        self.0.lock().unwrap_or_else(|error| error.into_inner())
    }

    fn push(&self, action: String) {
        let actions = &mut self.held().0;
        if actions.len() == REMEMBERED {
            actions.pop_front();
        }
        actions.push_back(action);
    }

    fn newest(&self) -> String {
        self.held().0.back().cloned().unwrap_or_default()
    }

    fn print(&self) {
        println!("the last actions:");
        for action in &self.held().0 {
            println!("  {action}");
        }
    }

    /// Starts the watchdog, which ends the program if memory exceeds `ceiling` (MB), or if a frame does not end.
    fn guard(&self, ceiling: f64, seed: u64) {
        let own = self.clone();
        std::thread::spawn(move || {
            loop {
                std::thread::sleep(WATCH);
                let resident = memory::resident();
                let since = own.held().1;
                let failure = match since {
                    _ if resident > ceiling => format!("{resident:.0} MB"),
                    Some(since) if since.elapsed() > HUNG => "a frame that does not end".to_owned(),
                    _ => continue,
                };
                println!("FAILED: {failure} (seed {seed})");
                own.print();
                std::process::exit(1);
            }
        });
    }
}

/// The window of the test, with its measurements.
struct Watch {
    window: Harness<'static, Option<Shell>>,
    world: Rc<RefCell<World>>,
    textures: Textures,
    curve: Curve,
    start: Instant,
    frames: u64,
    actions: u64,
    restarts: u64,
    last: Last,
    /// Longest frames: duration, processor time, step, and preceding action.
    longest: Vec<(Duration, Duration, u64, String)>,
}

impl Watch {
    fn new(choices: &Choices, world: Rc<RefCell<World>>, curve: Curve) -> Self {
        let dialogs = AnyFile(Rc::clone(&world));
        let (files, recovery) = {
            let world = world.borrow();
            let own = choices.files.is_empty() && choices.samples.is_none();
            let files = if own { Vec::new() } else { world.files.clone() };
            (files, world.folder.join("recovery"))
        };
        let preferences = Preferences::default();
        let textures = Textures::default();
        let window = Harness::builder()
            .with_size([1400.0, 900.0])
            .with_step_dt(1.0 / 60.0)
            .allow_missing_glyphs()
            .renderer(textures.clone())
            .build_ui_state(
                move |ui, shell: &mut Option<Shell>| {
                    shell
                        .get_or_insert_with(|| {
                            Shell::new(ui.ctx(), files.clone(), Box::new(dialogs.clone()))
                                .with_preferences(preferences.clone())
                                .with_recovery(&recovery)
                        })
                        .frame(ui);
                },
                None,
            );
        Self {
            window,
            world,
            textures,
            curve,
            start: Instant::now(),
            frames: 0,
            actions: 0,
            restarts: 0,
            last: Last::default(),
            longest: Vec::new(),
        }
    }

    fn is_busy(&self) -> bool {
        self.window.state().as_ref().is_some_and(Shell::is_busy)
    }

    fn note(&mut self, action: String) {
        self.actions += 1;
        self.last.push(format!("{}: {action}", self.actions));
    }

    /// Draws one frame with these events, and measures its time, including layout and tessellation.
    fn frame(&mut self, events: impl IntoIterator<Item = Event>) {
        self.window.input_mut().events.extend(events);
        let (start, own) = (Instant::now(), memory::thread_time());
        self.last.held().1 = Some(start);
        self.window.step();
        let output = self.window.output();
        let shapes = output.shapes.clone();
        let meshes = self.window.ctx.tessellate(shapes, output.pixels_per_point);
        let took = (start.elapsed(), memory::thread_time().saturating_sub(own));
        drop(meshes);
        self.last.held().1 = None;
        self.frames += 1;
        self.longest.push((took.0, took.1, self.actions, self.last.newest()));
        self.longest.sort_by_key(|(took, ..)| std::cmp::Reverse(*took));
        self.longest.truncate(LISTED);
        let viewport = self.window.output().viewport_output.get(&ViewportId::ROOT);
        let commands = viewport.map_or(&[][..], |viewport| &viewport.commands);
        let closes = commands.iter().any(|command| matches!(command, ViewportCommand::Close));
        if closes {
            // After the window was closed, it is opened again.
            if let Some(mut shell) = self.window.state_mut().take() {
                shell.end();
            }
            self.restarts += 1;
        }
        let engine = self.window.state().as_ref().map(Shell::engine);
        self.curve.follow(self.start.elapsed(), &self.textures, engine);
    }

    /// Draws frames until no background work runs, at most for this time.
    fn rest(&mut self, patience: Duration) {
        let start = Instant::now();
        loop {
            self.frame([]);
            if !self.is_busy() || start.elapsed() > patience {
                return;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Does random actions until the time is over.
    fn play(&mut self, choices: &Choices) {
        let mut hands = Hands::new(choices.seed);
        while self.actions < choices.steps
            && self.start.elapsed().as_secs_f64() < 60.0 * choices.minutes
        {
            let act = hands.act(&self.window, &self.world.borrow().files);
            self.note(act.printed);
            if let Some(size) = act.size {
                self.window.set_size(size);
            }
            if let (Some(command), Some(shell)) = (act.command, self.window.state_mut().as_mut()) {
                shell.send(command);
            }
            if let Some(path) = act.dropped {
                self.window.input_mut().dropped_files.push(Arc::new(Dropped(path)));
            }
            if act.closes {
                let input = self.window.input_mut();
                let root = input.viewports.entry(ViewportId::ROOT).or_default();
                root.events.push(egui::ViewportEvent::Close);
            }
            if act.log_grows {
                let grown = self.world.borrow_mut().log.grow(50);
                grown.expect("the log is in its folder");
            }
            for frame in act.frames {
                self.frame(frame);
            }
            if act.rests {
                self.rest(PATIENCE[usize::from(hands.is_patient())]);
            }
        }
    }

    /// Moves the threshold sliders, with occasional waits for background results.
    fn soak(&mut self, seed: u64, moves: u64) {
        let mut random = Random::new(seed);
        self.rest(HANGS);
        let shell = self.window.state().as_ref().expect("made in the first frame");
        let recordings = &shell.engine().project().recordings;
        assert!(
            !recordings.entries().is_empty(),
            "nothing was loaded: files must name their columns"
        );
        for at in 0..moves {
            let name = if random.chance(0.5) { "F_th" } else { "t_th" };
            let slider = self.window.get_by_role_and_label(Role::Slider, name);
            let node = slider.accesskit_node();
            let data = node.data();
            let (min, max) = (data.min_numeric_value(), data.max_numeric_value());
            let (min, max) = (min.unwrap_or(0.0), max.unwrap_or(1.0));
            let value = min + (max - min) * random.share();
            slider.set_value_accesskit(value);
            self.note(format!("{name} to {value:.3}"));
            self.frame([]);
            if at % MOVES_PER_REST == 0 {
                self.rest(HANGS);
            }
        }
        self.rest(HANGS);
    }
}

/// Writes a recording of six gauges with play and creep, and three forces, at 500 Hz.
fn generate(path: &Path, n: usize) -> std::io::Result<()> {
    let mut file = BufWriter::new(std::fs::File::create(path)?);
    writeln!(file, "t [s],S1,S2,S3,S4,S5,S6,Fx [N],Fy [N],Fz [N]")?;
    let mut drag = [0.0_f64; 3];
    let mut line = String::new();
    for k in 0..n {
        let t = k as f64 / 500.0;
        let load = [0.31, 0.47, 0.73].map(|rate| 8.0 * (rate * t).sin() * (0.011 * rate * t).cos());
        line.clear();
        write!(line, "{t:.3}").expect("into a text");
        for gauge in 0..6 {
            let at = gauge % 3;
            drag[at] = drag[at].clamp(load[at] - 1.5, load[at] + 1.5);
            let noise = 0.003 * ((k.wrapping_mul(2_654_435_761 + gauge) >> 7) % 17) as f64;
            let value =
                load[at] + 0.2 * drag[at] + 0.1 * (gauge as f64) * load[(at + 1) % 3] + noise;
            write!(line, ",{value:.4}").expect("into a text");
        }
        for value in load {
            write!(line, ",{value:.4}").expect("into a text");
        }
        writeln!(file, "{line}")?;
    }
    file.flush()
}

/// Copies the recordings to a temporary folder. A session is not copied, because it contains the paths of its files.
fn prepare(choices: &Choices, folder: &Path) -> std::io::Result<World> {
    let mut files = Vec::new();
    for (at, path) in choices.files.iter().enumerate() {
        let own = folder.join(at.to_string());
        std::fs::create_dir(&own)?;
        let own = own.join(path.file_name().unwrap_or_default());
        // The copy must be writable, even if the file is not.
        std::fs::write(&own, std::fs::read(path)?)?;
        files.push(own);
    }
    let small = folder.join("generated.csv");
    generate(&small, choices.samples.unwrap_or(3_000))?;
    let source = files.first().unwrap_or(&small).clone();
    if choices.samples.is_some() || files.is_empty() {
        files.push(small);
    }
    let log = Log::new(folder.join("log.csv"), &source)?;
    Ok(World { folder: folder.to_owned(), files, log, random: Random::new(choices.seed ^ 0x5eed) })
}

fn main() -> ExitCode {
    let choices = Choices::parse();
    let folder = tempfile::tempdir().expect("a folder");
    let file = choices.memory.as_ref().map(std::fs::File::create);
    let curve = (file.transpose())
        .and_then(|file| Curve::new(Duration::from_secs_f64(choices.every), file))
        .unwrap_or_else(|error| panic!("monkey: {error}"));
    let world = prepare(&choices, folder.path()).unwrap_or_else(|error| panic!("monkey: {error}"));
    // Relative paths that the monkey types refer to this folder.
    std::env::set_current_dir(folder.path()).expect("the temporary folder exists");

    let panics = Arc::new(Mutex::new(Vec::new()));
    let heard = Arc::clone(&panics);
    std::panic::set_hook(Box::new(move |info| {
        let trace = std::backtrace::Backtrace::force_capture().to_string();
        let own: Vec<&str> = (trace.lines())
            .filter(|line| line.contains("loopscope::") || line.contains("at ./"))
            .take(12)
            .collect();
        let printed = format!("{info}\n{}", own.join("\n"));
        eprintln!("{printed}");
        heard.lock().unwrap_or_else(|error| error.into_inner()).push(printed);
    }));

    let mut watch = Watch::new(&choices, Rc::new(RefCell::new(world)), curve);
    watch.last.guard(choices.ceiling, choices.seed);
    let ended = catch_unwind(AssertUnwindSafe(|| match choices.soak {
        Some(moves) => watch.soak(choices.seed, moves),
        None => watch.play(&choices),
    }));
    let panics = panics.lock().unwrap_or_else(|error| error.into_inner()).clone();
    let minutes = watch.start.elapsed().as_secs_f64() / 60.0;
    println!(
        "seed {}: {} actions, {} frames, {} restarts in {minutes:.1} min",
        choices.seed, watch.actions, watch.frames, watch.restarts
    );
    println!("longest frames (of them the processor), and the action before:");
    for (took, own, _, action) in &watch.longest {
        println!(
            "  {:6.0} ms ({:6.0} ms)  {action}",
            1e3 * took.as_secs_f64(),
            1e3 * own.as_secs_f64()
        );
    }
    let grows = watch.curve.tell();
    let is_frozen = watch.longest.first().is_some_and(|(took, ..)| *took > FROZEN);
    let failures = [
        (ended.is_err() || !panics.is_empty(), format!("{} panics", panics.len())),
        (is_frozen, "a frame of more than a second".to_owned()),
        (grows && choices.soak.is_some(), "memory grows".to_owned()),
    ];
    let failures: Vec<String> =
        (failures.into_iter()).filter_map(|(is, what)| is.then_some(what)).collect();
    if failures.is_empty() {
        return ExitCode::SUCCESS;
    }
    println!("FAILED: {} (seed {}, step {})", failures.join(", "), choices.seed, watch.actions);
    for printed in panics {
        println!("  {printed}");
    }
    watch.last.print();
    ExitCode::FAILURE
}
