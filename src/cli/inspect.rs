//! The job `inspect`: what a file holds, what would be loaded, what is wrong, and a column map to change.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;

use super::error::{JobError, failed, usage};
use super::examples::examples;
use super::inputs::Files;
use super::reading::{ReadArgs, not_recording};
use super::run::{Run, Work};
use super::values::named_file;
use crate::export::write_atomically;
use crate::formats;
use crate::formats::text::Decimal;
use crate::import::estimate_weight;
use crate::import::inspect::{Check, Inspection, Known, TableReport, inspect};
use crate::import::pose::WeightEstimate;
use crate::recording::Axis;
use crate::report::Table;
use crate::shown::{and_more, message, printable};

/// Say what a file holds, what would be loaded and what is wrong; write a column map for it.
#[derive(Debug, Args)]
#[command(after_help = examples(&[
    ("loopscope inspect press.csv", "what would be loaded"),
    ("loopscope inspect log.mat --write-map map.json", "a column map to correct by hand"),
]))]
pub struct InspectJob {
    #[arg(required = true, value_name = "FILE", value_parser = named_file(),
        help = format!("Recordings, or folders of them: {}", formats::listed()))]
    files: Vec<PathBuf>,
    #[command(flatten)]
    read: ReadArgs,
    /// Write the column map that was given or found for the one file, to be changed and used with --columns.
    #[arg(long, value_name = "MAP.json", value_parser = named_file())]
    write_map: Option<PathBuf>,
    /// Write over a map that is there already.
    #[arg(long, requires = "write_map")]
    force: bool,
    /// Instead of looking: find the weight that the sensor carries, from its pose and a measured load in one file.
    #[arg(long, requires = "columns")]
    estimate_weight: bool,
    /// Print one JSON object instead of a text, or of several files a list of them.
    #[arg(long)]
    json: bool,
}

impl Work for InspectJob {
    fn files(&self) -> Files<'_> {
        // The map that is read may be written again, with what is added to it.
        let files = Files { recordings: &self.files, ..Files::default() };
        files.writing(&self.write_map, self.force)
    }

    fn run(&self, run: &Run) -> Result<(), JobError> {
        let map = self.read.map()?;
        let inputs = &run.inputs.recordings;
        let of = inputs.len();
        let for_one = [
            (self.write_map.is_some(), "--write-map"),
            (self.estimate_weight, "--estimate-weight"),
        ];
        if let (Some((_, option)), 2..) = (for_one.iter().find(|own| own.0), of) {
            let why = "is for one file; name the one that it is for";
            return usage(format!("{option} {why}"));
        }
        if let (true, Some(map), [input]) = (self.estimate_weight, &map, &inputs[..]) {
            let estimate = estimate_weight(&input.path, map, &run.progress)?;
            return run.print(self.json, &estimate, |out| print_weight(&estimate, out));
        }
        let known = map.as_ref().map_or(Known::Nothing, Known::Map);
        let (mut all, mut count) = (Vec::new(), 0);
        for (at, input) in inputs.iter().enumerate() {
            let found = inspect(&input.path, known, &run.progress).map(Some);
            let found = found.map_err(|error| self.read.unread(input, error));
            let Some(mut inspection) = self.read.or_left_out(run, found)? else {
                continue;
            };
            if inspection.check.error.is_some() {
                count += 1;
                if let Some(error) = not_recording(&input.path) {
                    return Err(error);
                }
            }
            inspection.map.tare = self.read.tare.or(inspection.map.tare);
            // What was assumed stands in the map that is written, to be changed.
            inspection.map.gap_secs =
                (inspection.map.gap_secs).or(inspection.check.assumed_gap_secs);
            if let Some(path) = &self.write_map {
                write_atomically(path, |mut out| inspection.map.write_json(&mut out))?;
            }
            if self.json {
                all.push(inspection);
                continue;
            }
            run.print_text(|out| {
                if of > 1 {
                    let space = if at == 0 { "" } else { "\n" };
                    writeln!(out, "{space}== {} ==", message(&input.path.display()))?;
                }
                print(&inspection, out)
            })?;
        }
        if self.json {
            match &all[..] {
                [one] if of == 1 => run.print_json(one)?,
                all => run.print_json(&all)?,
            }
        }
        // A map to correct is what was asked for, and written.
        match count > 0 && self.write_map.is_none() {
            true => failed(format!("{count} of {of} files would not be loaded")),
            false => Ok(()),
        }
    }
}

fn print(inspection: &Inspection, out: &mut impl Write) -> io::Result<()> {
    print_table(&inspection.table, out)?;
    if let Some(reference) = &inspection.reference {
        writeln!(out)?;
        print_table(reference, out)?;
    }
    writeln!(out)?;
    print_check(&inspection.check, out)?;
    for question in &inspection.questions {
        writeln!(out, "to decide: {}", message(question))?;
    }
    Ok(())
}

fn print_table(table: &TableReport, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "{}: {table}", message(&table.path.display()))?;
    if table.kind.is_none() {
        print_layout(table, out)?;
    }
    for part in &table.parts {
        let is_used = if part.is_used { "read" } else { "not read" };
        let (name, what) = (message(&part.name), message(&part.what));
        writeln!(out, "{is_used}: {name} ({what})")?;
    }
    print_columns(table, out)
}

fn print_weight(estimate: &WeightEstimate, out: &mut impl Write) -> io::Result<()> {
    let list = |values: [f64; 3]| values.map(|value| format!("{value:.6}")).join(", ");
    writeln!(out, "mass: {:.6} kg, from {} samples", estimate.mass_kg, estimate.n_samples)?;
    match estimate.centre_m {
        Some(centre) => writeln!(out, "centre of mass: {} m", list(centre))?,
        None => writeln!(
            out,
            "centre of mass: not found; it takes Mx, My and Mz, and a sensor turned about two axes"
        )?,
    }
    let offset = list(estimate.force_offset);
    writeln!(
        out,
        "offset of the reference: {offset} N, left over {:.6} N RMS",
        estimate.force_rms
    )?;
    if let (Some(offset), Some(rms)) = (estimate.moment_offset, estimate.moment_rms) {
        writeln!(out, "offset of its moments: {} N·m, left over {rms:.6} N·m RMS", list(offset))?;
    }
    if let Some(centre) = estimate.centre_m {
        let (mass, centre) = (estimate.mass_kg, list(centre));
        writeln!(
            out,
            "for a column map: \"weight\": {{ \"mass_kg\": {mass:.6}, \"centre_m\": [{centre}] }}"
        )?;
    }
    Ok(())
}

fn print_layout(table: &TableReport, out: &mut impl Write) -> io::Result<()> {
    let thousands = table.text.thousands;
    let thousands = thousands.map_or_else(String::new, |own| format!(", thousands {}", own.name()));
    let decimal = match table.text.decimal {
        Decimal::Point => "point",
        Decimal::Comma => "comma",
    };
    let place = match (table.line, table.text.header) {
        (None, _) => "no table".to_owned(),
        (Some(line), true) => format!("header on line {line}"),
        (Some(line), false) => format!("no header, first row on line {line}"),
    };
    let units = if table.text.units_row { ", units below" } else { "" };
    writeln!(
        out,
        "delimiter {}, decimal {decimal}{thousands}, {place}{units}",
        table.text.delimiter.name()
    )
}

fn print_columns(table: &TableReport, out: &mut impl Write) -> io::Result<()> {
    // More are no table that anybody looks through here.
    const LISTED: usize = 200;
    let listed = Table::of(table.columns.iter().take(LISTED))
        .words("column", |own| own.number.to_string())
        .words("name", |own| start(&own.name))
        .words("is", |own| start(&own.is.to_string()))
        .words("unit", |own| start(own.unit.as_deref().unwrap_or_default()))
        .words("first values", |own| start(&own.first.join("  ")))
        .words("range", |own| match (own.min, own.max) {
            (Some(min), Some(max)) => format!("{min} to {max}"),
            _ => own.content.name().to_owned(),
        })
        .table("", "");
    write!(out, "{}", listed.text())?;
    match and_more(table.columns.len(), LISTED) {
        None => Ok(()),
        Some(more) => writeln!(out, "  {more} columns; --json lists them all"),
    }
}

/// Of a cell without end only the start.
fn start(cell: &str) -> String {
    const SHOWN_CHARS: usize = 120;
    match cell.char_indices().nth(SHOWN_CHARS) {
        Some((end, _)) => format!("{}…", printable(&cell[..end])),
        None => printable(cell).into_owned(),
    }
}

fn print_check(check: &Check, out: &mut impl Write) -> io::Result<()> {
    let of_start = if check.is_sample { ", of the start of the file" } else { "" };
    if let Some(error) = &check.error {
        writeln!(out, "would not be loaded: {}", message(error))?;
    } else {
        let n_samples: usize = check.recordings.iter().map(|report| report.n_samples).sum();
        writeln!(
            out,
            "would be loaded{of_start}: {} recordings with {n_samples} samples",
            check.recordings.len()
        )?;
        const LISTED: usize = 10;
        for report in check.recordings.iter().take(LISTED) {
            let rate = report.rate_hz.map_or_else(String::new, |rate| format!(", {rate:.4} Hz"));
            writeln!(
                out,
                "  {}: {} samples, {:.3} s{rate}",
                printable(&report.name),
                report.n_samples,
                report.duration_secs
            )?;
            if !report.auxiliary.is_empty() {
                let channels = message(&report.auxiliary.join(", "));
                writeln!(out, "    auxiliary channels: {channels}")?;
            }
        }
        if let Some(more) = and_more(check.recordings.len(), LISTED) {
            writeln!(out, "  {more}")?;
        }
        writeln!(out, "  gauges: {}", message(&check.gauges.join(" ")))?;
        let axes = Axis::symbols(&check.axes);
        let axes = if axes.is_empty() { "none".to_owned() } else { axes.join(" ") };
        writeln!(out, "  reference: {axes}")?;
    }
    if let Some(offset) = check.clock_offset {
        writeln!(
            out,
            "clocks: the reference fits best {:.4} s {} (the gauges explain {:.2} % of it, {:.2} % as the clocks are); nothing is applied unless \"clock_offset_secs\" under \"join\" in the map says so; gauges that lag behind their load look the same",
            offset.offset_secs.abs(),
            if offset.offset_secs < 0.0 { "earlier" } else { "later" },
            100.0 * offset.explained,
            100.0 * offset.explained_without
        )?;
    }
    for warning in &check.warnings {
        writeln!(out, "warning: {}", message(warning))?;
    }
    Ok(())
}
