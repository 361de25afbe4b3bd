//! `loopscope inspect`: describes a file and the recordings that it would load, and writes a column map.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;

use super::{
    error::{JobError, failed, usage},
    inputs::Files,
    reading::{Needs, Rated, ReadArgs, not_recording},
    run::{Run, Work, examples},
    values::named_file,
};
use crate::{
    export::write_atomically,
    finding::Face,
    formats::{self, text::Decimal},
    import::{
        estimate_weight,
        inspect::{Check, Inspection, Known, TableReport, inspect},
        pose::WeightEstimate,
    },
    recording::Axis,
    report::Table,
    scoring::numbers::rate_in_words,
    shown::{and_more, counted, message, number, printable},
};

/// Show the columns of a file, the recordings that it would load, and any problems, and write a column map for the file.
#[derive(Debug, Args)]
#[command(after_help = examples(&[
    ("loopscope inspect press.csv", "shows the recordings that would be loaded"),
    ("loopscope inspect log.mat --write-map map.json", "writes a column map to correct by hand"),
    ("loopscope inspect log.mcap --out recordings", "writes each recording as a CSV file"),
]))]
pub struct InspectJob {
    #[arg(required = true, value_name = "FILE", value_parser = named_file(),
        help = format!("Recordings, or folders of them: {}", formats::listed()))]
    files: Vec<PathBuf>,
    #[command(flatten)]
    read: ReadArgs,
    /// Write the column map of the file to this file, as given by --columns or as detected. It can be edited and used with
    /// --columns. Needs a single input file.
    #[arg(long, value_name = "MAP.json", value_parser = named_file())]
    write_map: Option<PathBuf>,
    /// Write each recording as a CSV file to this folder: times, gauges, loads in N and N·m, and auxiliary channels, as the
    /// program reads them. A missing folder is created.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Overwrite existing files.
    #[arg(long)]
    force: bool,
    /// Only estimate the weight that the sensor carries, from the poses and the measured loads in one file.
    #[arg(long)]
    estimate_weight: bool,
    /// Print JSON instead of text: one object for a single file, an array for several.
    #[arg(long)]
    json: bool,
}

impl Work for InspectJob {
    fn files(&self) -> Files<'_> {
        // `--write-map` may overwrite the file of `--columns`, so that file is not protected like an input.
        let files = Files { recordings: &self.files, ..Files::default() };
        files.writing(&self.write_map, self.force)
    }

    fn run(&self, run: &Run) -> Result<(), JobError> {
        let map = self.read.map()?;
        let inputs = &run.inputs.recordings;
        if let Some(out) = &self.out {
            let recordings = self.read.read(run, inputs, &Rated::default(), Needs::Nothing)?;
            run.write_recordings(out, &recordings, None, self.force)?;
        }
        let of = inputs.len();
        let for_one = [
            (self.write_map.is_some(), "--write-map"),
            (self.estimate_weight, "--estimate-weight"),
        ];
        if let (Some((_, option)), 2..) = (for_one.iter().find(|choice| choice.0), of) {
            let why = "needs a single file; name one file only";
            return usage(format!("{option} {why}"));
        }
        if let (true, [input]) = (self.estimate_weight, &inputs[..]) {
            let estimate = estimate_weight(&input.path, map.as_ref(), &run.progress)?;
            return run.print(self.json, &estimate, |out| print_weight(&estimate, out));
        }
        let known = map.map_or(Known::Nothing, |map| Known::Map(Box::new(map)));
        let (mut all, mut count, mut n_open) = (Vec::new(), 0, 0);
        for (at, input) in inputs.iter().enumerate() {
            let found = inspect(&input.path, known.clone(), &run.progress).map(Some);
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
            n_open += usize::from(inspection.answer.is_some());
            inspection.map.tare = self.read.tare.or(inspection.map.tare);
            // The assumed gap length (longest time between samples that is no pause) is written to the map, so that the user
            // can change it.
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
        // With --write-map, unusable files are no error, because the map is written for the user to correct.
        if count > 0 && self.write_map.is_none() {
            failed(format!("{count} of {of} files would not be loaded"))
        } else if n_open > 0 && self.write_map.is_none() {
            let why = "need an answer before a calibration";
            Err(JobError::NotMet(format!("{n_open} of {of} files {why}")))
        } else {
            Ok(())
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
        writeln!(out, "open question: {}", message(&question.text(&inspection.table.columns)))?;
    }
    match &inspection.answer {
        Some(answer) => writeln!(out, "answer, for example: --columns \"{}\"", message(answer)),
        None => Ok(()),
    }
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
    for sentence in estimate.sentences() {
        writeln!(out, "{sentence}")?;
    }
    if let (mass, Some([x, y, z])) = (estimate.mass_kg, estimate.centre_m) {
        writeln!(
            out,
            "for a column map: \"weight\": {{ \"mass_kg\": {mass:.6}, \"centre_m\": [{x:.6}, {y:.6}, {z:.6}] }}"
        )?;
    }
    Ok(())
}

fn print_layout(table: &TableReport, out: &mut impl Write) -> io::Result<()> {
    let thousands = table.text.thousands;
    let thousands =
        thousands.map_or_else(String::new, |separator| format!(", thousands {}", separator.name()));
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
    // Maximum number of columns printed, because a longer table is not readable in a terminal.
    const LISTED: usize = 200;
    let listed = Table::of(table.columns.iter().take(LISTED))
        .words("column", |column| column.number.to_string())
        .words("name", |column| start(&column.name))
        .words("role", |column| start(&column.is.to_string()))
        .words("unit", |column| start(column.unit.as_deref().unwrap_or_default()))
        .words("because of", |column| column.why.words().to_owned())
        .words("first values", |column| start(&column.first.join("  ")))
        .words("range", |column| match (column.min, column.max) {
            (Some(min), Some(max)) => format!("{} to {}", number(min), number(max)),
            _ => column.content.name().to_owned(),
        })
        .table("", "");
    write!(out, "{}", listed.text())?;
    match and_more(table.columns.len(), LISTED) {
        None => Ok(()),
        Some(more) => writeln!(out, "  {more} columns; --json lists them all"),
    }
}

fn start(cell: &str) -> String {
    const SHOWN_CHARS: usize = 120;
    match cell.char_indices().nth(SHOWN_CHARS) {
        Some((end, _)) => format!("{}…", printable(&cell[..end])),
        None => printable(cell).into_owned(),
    }
}

fn print_check(check: &Check, out: &mut impl Write) -> io::Result<()> {
    let of_start = if check.is_sample { ", from the start of the file" } else { "" };
    if let Some(error) = &check.error {
        writeln!(out, "would not be loaded: {}", message(error))?;
    } else {
        let n_samples: usize = check.recordings.iter().map(|report| report.n_samples).sum();
        writeln!(
            out,
            "would be loaded{of_start}: {} with {}",
            counted(check.recordings.len(), "recording"),
            counted(n_samples, "sample")
        )?;
        const LISTED: usize = 10;
        for report in check.recordings.iter().take(LISTED) {
            let rate = rate_in_words(report.rate_hz, report.n_samples, report.duration_secs);
            let rate = rate.map_or_else(String::new, |rate| format!(", {rate}"));
            writeln!(
                out,
                "  {}: {}, {:.3} s{rate}",
                printable(&report.name),
                counted(report.n_samples, "sample"),
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
        let gauges = check.gauges.join(" ");
        let gauges = if gauges.is_empty() { "none" } else { &gauges };
        writeln!(out, "  gauges: {}", message(&gauges))?;
        let axes = Axis::symbols(&check.axes);
        let axes = if axes.is_empty() { "none".to_owned() } else { axes.join(" ") };
        writeln!(out, "  reference: {axes}")?;
    }
    if let Some(offset) = check.clock_offset {
        writeln!(
            out,
            "clocks: the reference fits the gauges best if it is shifted {:.4} s {} (the gauges then explain {:.2} % of the reference, and {:.2} % without a shift). The shift is applied only if the map has \"clock_offset_secs\" under \"join\". Slow gauges look the same as a clock offset",
            offset.offset_secs.abs(),
            if offset.offset_secs < 0.0 { "earlier" } else { "later" },
            100.0 * offset.explained,
            100.0 * offset.explained_without
        )?;
    }
    for warning in &check.warnings {
        writeln!(out, "warning: {}", message(&warning.text(Face::CommandLine)))?;
    }
    Ok(())
}
