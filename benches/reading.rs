//! Time to read a text file as a recording: 243,000 rows of a time, six gauges and six axes.
//!
//! `cargo bench --no-default-features --bench reading -- --keep FILE` writes the file, to time other readers.

use std::fmt::Write as _;
use std::path::Path;

use criterion::{Criterion, Throughput};
use loopscope::import::read;
use loopscope::progress::Progress;

const N_ROWS: usize = 243_000;

/// Returns the text of a recording: slow sums of sines with six decimals, as a logger would write them.
fn text() -> String {
    let mut text = String::from("t,S1,S2,S3,S4,S5,S6,Fx,Fy,Fz,Tx,Ty,Tz\n");
    for row in 0..N_ROWS {
        let t = row as f64 * 0.05;
        write!(text, "{t:.6}").expect("a String takes all");
        for column in 1..=12 {
            let phase = f64::from(column);
            let value = 300.0 * (t * 0.11 + phase).sin() + 40.0 * (t * 1.7 * phase).cos();
            write!(text, ",{value:.6}").expect("a String takes all");
        }
        text.push('\n');
    }
    text
}

fn reading(criterion: &mut Criterion, path: &Path, n_bytes: u64) {
    let mut group = criterion.benchmark_group("reading");
    group.sample_size(20).throughput(Throughput::Bytes(n_bytes));
    group.bench_function("243,000 rows, 13 columns", |bencher| {
        bencher.iter(|| read(path, None, &[], &Progress::default()).expect("the file is sound"));
    });
    group.finish();
}

fn main() {
    let text = text();
    let mut arguments = std::env::args().skip_while(|argument| argument != "--keep");
    if let Some(path) = arguments.nth(1) {
        std::fs::write(path, text).expect("the file can be written");
        return;
    }
    let folder = tempfile::tempdir().expect("a folder for the file");
    let path = folder.path().join("reading.csv");
    std::fs::write(&path, &text).expect("the file can be written");
    let mut criterion = Criterion::default().configure_from_args();
    reading(&mut criterion, &path, text.len() as u64);
    criterion.final_summary();
}
