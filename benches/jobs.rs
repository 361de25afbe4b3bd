//! Processor time of the jobs of the command line, for growing numbers of samples and gauges. The recordings have six axes with
//! smooth random loads at 1 kHz, and gauges with some play and noise.
//!
//! `cargo bench --bench jobs` prints one table for each number of gauges. Arguments after `--` are the jobs to measure, and
//! numbers of gauges. Linux only, because the processor time of a job is read from /proc.

use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::Path;
use std::process::{Command, Stdio};

/// Numbers of samples for each number of gauges. With more gauges, a file of 16 million samples would not fit in memory.
const SIZES: [(usize, &[usize]); 3] = [
    (6, &[250_000, 1_000_000, 4_000_000, 16_000_000]),
    (24, &[250_000, 1_000_000, 4_000_000]),
    (64, &[250_000, 1_000_000]),
];
const AXES: [(&str, f64); 6] =
    [("Fx", 40.0), ("Fy", 40.0), ("Fz", 80.0), ("Mx", 2.0), ("My", 2.0), ("Mz", 1.5)];
/// Number of waves that make up the load of an axis.
const WAVES: usize = 5;
/// Jobs with their arguments; FILE stands for the recording, PAGE for a file to write.
const JOBS: [(&str, &str); 8] = [
    ("fit", "fit --train FILE"),
    ("fit without look-back", "fit --train FILE --look-back none"),
    ("check", "check FILE"),
    ("metrology", "metrology FILE"),
    ("sweep of 16 pairs", "sweep --train FILE --f-th 1:4:1 --t-th 2,5,10,15"),
    ("report", "report --train FILE --out PAGE --force"),
    ("best", "best --train FILE"),
    ("NumPy", ""),
];
/// The least that a fit without look-back does: reads the file, fits the gauges by least squares, and computes the RMSE.
const NUMPY: &str = "
import sys, numpy
table = numpy.load(sys.argv[1])
names = table.dtype.names
matrix = lambda kind: numpy.stack([table[name] for name in names if name[0] in kind], axis=1)
gauges, loads = matrix('S'), matrix('FM')
x = numpy.hstack([gauges, numpy.ones((len(table), 1))])
found = numpy.linalg.solve(x.T @ x, x.T @ loads)
print(numpy.sqrt(((x @ found - loads) ** 2).mean(axis=0)))
";

fn main() -> Result<(), Box<dyn Error>> {
    // `cargo test` also runs benches, but without this argument.
    if !std::env::args().any(|argument| argument == "--bench") {
        return Ok(());
    }
    let asked: Vec<String> =
        std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let (gauges, names): (Vec<_>, Vec<_>) =
        asked.iter().partition(|argument| argument.parse::<usize>().is_ok());
    let folder = tempfile::tempdir()?;
    for (n_gauges, sizes) in SIZES {
        if !gauges.is_empty() && !gauges.contains(&&n_gauges.to_string()) {
            continue;
        }
        let heads = sizes.iter().map(|n| format!(" {} million |", *n as f64 / 1e6));
        println!("\n| {n_gauges} gauges, processor seconds |{}", heads.collect::<String>());
        println!("|---|{}", "---|".repeat(sizes.len()));
        let mut rows = JOBS.map(|(name, _)| format!("| {name} |"));
        for n in sizes {
            let file = folder.path().join("recording.npy");
            write_recording(&file, *n, n_gauges)?;
            for ((name, arguments), row) in JOBS.iter().zip(&mut rows) {
                let is_asked = names.is_empty() || names.iter().any(|asked| asked == name);
                let secs = if is_asked { processor_secs(&file, arguments)? } else { None };
                *row += &secs.map_or(" |".to_owned(), |secs| format!(" {secs:.1} |"));
                eprintln!("{n_gauges} gauges, {n} samples, {name}: {secs:?}");
            }
        }
        rows.iter().for_each(|row| println!("{row}"));
    }
    Ok(())
}

/// Writes a recording as a NumPy array with named columns.
fn write_recording(path: &Path, n: usize, n_gauges: usize) -> Result<(), Box<dyn Error>> {
    let gauges: Vec<String> = (1..=n_gauges).map(|at| format!("S{at}")).collect();
    let names = ["time"].into_iter().chain(gauges.iter().map(String::as_str));
    let names = names.chain(AXES.map(|(axis, _)| axis));
    let columns: String = names.map(|name| format!("('{name}', '<f8'), ")).collect();
    let head = format!("{{'descr': [{columns}], 'fortran_order': False, 'shape': ({n},), }}");
    let length = (10 + head.len() + 1).next_multiple_of(64) - 10;
    let mut out = BufWriter::new(File::create(path)?);
    out.write_all(b"\x93NUMPY\x01\x00")?;
    out.write_all(&u16::try_from(length)?.to_le_bytes())?;
    out.write_all(format!("{head:<width$}\n", width = length - 1).as_bytes())?;
    let mut random = random();
    let mut waves = [[[0.0; 3]; WAVES]; AXES.len()];
    for wave in waves.as_flattened_mut() {
        *wave = [0.3 + random(), 0.3 + 4.0 * random(), 6.3 * random()];
    }
    let factors: Vec<[f64; 6]> =
        (0..n_gauges).map(|_| AXES.map(|(_, load)| 1000.0 * (random() - 0.5) / load)).collect();
    let mut states = vec![0.0_f64; n_gauges];
    for k in 0..n {
        let time = k as f64 / 1000.0;
        let mut loads = [0.0; 6];
        for ((load, (_, size)), waves) in loads.iter_mut().zip(AXES).zip(&waves) {
            let sum: f64 =
                waves.iter().map(|[a, rate, phase]| a * (rate * time + phase).sin()).sum();
            *load = size * sum / 3.0;
        }
        out.write_all(&time.to_le_bytes())?;
        for (factors, state) in factors.iter().zip(&mut states) {
            let signal: f64 = factors.iter().zip(&loads).map(|(factor, load)| factor * load).sum();
            *state = state.clamp(signal - 20.0, signal + 20.0);
            out.write_all(&(signal + 0.1 * *state + random()).to_le_bytes())?;
        }
        for load in loads {
            out.write_all(&load.to_le_bytes())?;
        }
    }
    Ok(out.flush()?)
}

/// Returns a generator of numbers from 0 to 1.
fn random() -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Runs a job and returns its processor time in user and system mode; `None` if it cannot run.
fn processor_secs(file: &Path, arguments: &str) -> Result<Option<f64>, Box<dyn Error>> {
    let mut job = if arguments.is_empty() {
        let mut job = Command::new("python3");
        job.arg("-c").arg(NUMPY).arg(file);
        job
    } else {
        let mut job = Command::new(env!("CARGO_BIN_EXE_loopscope"));
        job.args(arguments.split(' ').map(|argument| match argument {
            "FILE" => file.to_path_buf(),
            "PAGE" => file.with_extension("html"),
            other => other.into(),
        }));
        job
    };
    let before = secs_of_children()?;
    let ended = job.stdout(Stdio::null()).stderr(Stdio::null()).status()?;
    // Exit code 3 of a check means that the recordings are not enough, which takes as long.
    let has_run = ended.success() || ended.code() == Some(3);
    Ok(has_run.then_some(secs_of_children()? - before))
}

/// Returns the processor time of all ended child processes, in hundredths of a second as Linux counts it.
fn secs_of_children() -> Result<f64, Box<dyn Error>> {
    let stat = std::fs::read_to_string("/proc/self/stat")?;
    let after_name = stat.rsplit_once(')').ok_or("no process name")?.1;
    let fields: Vec<&str> = after_name.split_whitespace().collect();
    let ticks = fields[13].parse::<f64>()? + fields[14].parse::<f64>()?;
    Ok(ticks / 100.0)
}
