//! What recordings tell of a model, as tables and a figure.

use crate::questions::check::independent_loads::{AxisReach, Sufficiency, percent};
use crate::report::figure::{Figure, Line, Scale};
use crate::report::table::{Cell, Column, Table};
use crate::scoring::numbers::significant;
use crate::shown::and_more;

/// No more recordings, or groups, are listed: those on which most rests.
const LISTED: usize = 12;
/// Half the size of a cross, as a share of the figure.
const CROSS: f64 = 0.006;

fn words(text: impl Into<String>) -> Cell {
    Cell::words(text)
}

fn share(share: f64) -> Cell {
    Cell::number(share, percent(share))
}

/// All tables that say something, in the order in which they are read.
pub fn sufficiency_tables(of: &Sufficiency) -> Vec<Table> {
    let tables = [reached(of), errors(of), pairs(of), leverage(of), outside(of), next(of)];
    tables.into_iter().filter(|table| !table.rows.is_empty()).collect()
}

fn reached(of: &Sufficiency) -> Table {
    let rows = of.axes.iter().map(|own| {
        let part = |end: f64| match own.full_scale > 0.0 {
            true => share(end / own.full_scale),
            false => Cell::missing("–", "the load does not move"),
        };
        let rated = if own.rated { "rated" } else { "from the loads" };
        vec![
            words(own.axis.label()),
            Cell::digits(Some(own.low), 4),
            Cell::digits(Some(own.high), 4),
            Cell::digits((own.full_scale > 0.0).then_some(own.full_scale), 4),
            words(rated),
            part(own.low),
            part(own.high),
        ]
    });
    let mut columns = vec![Column::words("Axis")];
    columns.extend(["from", "to", "full scale"].map(Column::numbers));
    columns.push(Column {
        about: "Entered by somebody, or what the training loads span".to_owned(),
        ..Column::words("which is")
    });
    columns.extend(["from, of it", "to, of it"].map(Column::numbers));
    Table { title: "Training loads".to_owned(), columns, rows: rows.collect(), ..Table::default() }
}

fn errors(of: &Sufficiency) -> Table {
    let ratio = |own: &AxisReach, error: Option<f64>| {
        let train = own.train_rmse.filter(|train| *train > 1e-9 * own.deviation);
        match train.zip(error) {
            Some((train, error)) => Cell::number(error / train, significant(error / train, 3)),
            None => Cell::none(),
        }
    };
    let rows = of.axes.iter().map(|own| {
        vec![
            words(own.axis.label()),
            Cell::digits(Some(own.deviation), 4),
            Cell::digits(own.train_rmse, 4),
            Cell::digits(own.left_out_rmse, 4),
            ratio(own, own.left_out_rmse),
            Cell::digits(own.load_left_out_rmse, 4),
            ratio(own, own.load_left_out_rmse),
        ]
    });
    let mut columns = vec![Column::words("Axis")];
    let heads = [
        (
            "load",
            "Standard deviation of the training load: the error of somebody who always says its mean",
        ),
        ("fit", "RMSE on the training samples"),
        ("left out", "RMSE by cross-validation"),
        ("× fit", "Over the error of the fit"),
        (
            "load left out",
            "RMSE where all samples of a load are predicted by the fit to the others; not with a past, nor with very many loads",
        ),
        ("× fit", "Over the error of the fit"),
    ];
    columns.extend(
        heads.map(|(name, about)| Column { about: about.to_owned(), ..Column::numbers(name) }),
    );
    Table { title: "Errors".to_owned(), columns, rows: rows.collect(), ..Table::default() }
}

fn pairs(of: &Sufficiency) -> Table {
    let rows = of.pairs.iter().map(|own| {
        let [a, b] = own.axes.map(|axis| axis.symbol());
        let why = "one of them does not move";
        let correlation = own
            .correlation
            .map_or_else(|| Cell::missing("–", why), |r| Cell::number(r, format!("{r:+.2}")));
        let covered = own.covered.map_or_else(|| Cell::missing("–", why), share);
        vec![words(format!("{a}, {b}")), correlation, covered]
    });
    let covered = Column {
        about: "The share of the rectangle of both full scales (or of both ranges, where none is entered) that the loads enclose"
            .to_owned(),
        ..Column::numbers("enclosed")
    };
    Table {
        title: "Pairs of axes".to_owned(),
        columns: vec![Column::words("Axes"), Column::numbers("correlation"), covered],
        rows: rows.collect(),
        ..Table::default()
    }
}

fn leverage(of: &Sufficiency) -> Table {
    let rows = of.leverage.iter().take(LISTED);
    let rows = rows.map(|own| {
        vec![
            words(&own.recording),
            share(own.sample_share),
            share(own.share),
            Cell::digits(Some(own.leverage), 3),
        ]
    });
    let heads = [
        ("of the samples", "Its share of the training samples"),
        ("of the leverage", "Its share of what determines the coefficients"),
        ("leverage", "The trace of (ΣG)⁻¹ G: over all recordings it adds up to the rank"),
    ];
    let mut columns = vec![Column::words("Recording")];
    columns.extend(
        heads.map(|(name, about)| Column { about: about.to_owned(), ..Column::numbers(name) }),
    );
    Table {
        title: "What rests on each recording".to_owned(),
        columns,
        rows: if of.leverage.len() > 1 { rows.collect() } else { Vec::new() },
        note: and_more(of.leverage.len(), LISTED).unwrap_or_default(),
    }
}

fn outside(of: &Sufficiency) -> Table {
    let mut all: Vec<_> = of.outside.iter().collect();
    all.sort_by(|a, b| b.is_test.cmp(&a.is_test).then(b.share.total_cmp(&a.share)));
    let rows = all.iter().take(LISTED).map(|own| {
        let name = if own.is_test {
            "test recordings".to_owned()
        } else {
            format!("{}, left out", own.of)
        };
        vec![
            words(name),
            words(own.axis.label()),
            share(own.share),
            Cell::digits(Some(own.farthest), 3),
        ]
    });
    let mut columns = ["Of", "Axis"].map(Column::words).to_vec();
    columns.extend(["of its samples", "by up to"].map(Column::numbers));
    Table {
        title: "Loads outside those of the others".to_owned(),
        columns,
        rows: rows.collect(),
        note: and_more(all.len(), LISTED).unwrap_or_default(),
    }
}

fn next(of: &Sufficiency) -> Table {
    let hangs = of.next.iter().any(|own| own.how.is_some());
    let mut columns = vec![Column::numbers("No.")];
    columns.extend(of.axes.iter().map(|own| Column::load(own.axis)));
    columns.push(Column {
        about: "By how much the logarithm of the determinant of the design grows".to_owned(),
        ..Column::numbers("gain")
    });
    columns.push(Column {
        about: "What is left of the mean variance of predictions over these loads, with it and those above it".to_owned(),
        ..Column::numbers("variance left")
    });
    columns.extend(hangs.then(|| Column::words("how")));
    let rows = of.next.iter().enumerate().map(|(at, own)| {
        let mut row = vec![Cell::number((at + 1) as f64, (at + 1).to_string())];
        row.extend(own.load.iter().map(|load| Cell::digits(Some(*load), 3)));
        row.push(Cell::digits(Some(own.gain), 3));
        row.push(share(own.variance_left));
        row.extend(hangs.then(|| words(own.how.clone().unwrap_or_default())));
        row
    });
    Table {
        title: "Load cases to record next".to_owned(),
        columns,
        rows: rows.collect(),
        note: of.next_note.clone(),
    }
}

/// The loads of two axes as crosses of the first colour, in the rectangle within which loads are to be expected, in the second.
pub fn pair_figure(
    of: &Sufficiency,
    [a, b]: [usize; 2],
    (ink, guide): ([u8; 3], [u8; 3]),
) -> Option<Figure<'static>> {
    let (across, up) = (of.axes.get(a)?, of.axes.get(b)?);
    let scale = |own: &AxisReach| {
        let ends = [own.region.0, own.region.1, own.low, own.high];
        Scale::spanning(own.axis.label(), ends, 0.05)
    };
    let (x_scale, y_scale) = (scale(across), scale(up));
    let half = |scale: &Scale| CROSS * (scale.range.1 - scale.range.0);
    let (dx, dy) = (half(&x_scale), half(&y_scale));
    let cross = |load: &Vec<f64>| {
        let (x, y) = (load[a], load[b]);
        [vec![[x - dx, y], [x + dx, y]], vec![[x, y - dy], [x, y + dy]]]
    };
    let ((x0, x1), (y0, y1)) = (across.region, up.region);
    let rated = match across.rated && up.rated {
        true => "Rated loads",
        false => "Range of both",
    };
    let frame = vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]];
    Some(Figure {
        title: format!("Training loads on {} and {}", across.axis.symbol(), up.axis.symbol()),
        across: x_scale,
        up: y_scale,
        lines: vec![
            Line { width: 1.0, ..Line::new(rated, guide, [frame]) },
            Line { width: 1.0, ..Line::new("Load cases", ink, of.cases.iter().flat_map(cross)) },
        ],
        ..Figure::default()
    })
}
