//! What recordings tell of a model, as tables and a figure.

use crate::questions::check::independent_loads::{AxisReach, Sufficiency};
use crate::recording::Axis;
use crate::report::figure::{Figure, Line, Scale};
use crate::report::table::{Cell, Column, Table};
use crate::scoring::numbers::percent;
use crate::shown::and_more;

/// No more recordings, or groups, are listed: those on which most rests.
const LISTED: usize = 12;
/// Half the size of a cross, as a share of the figure.
const CROSS: f64 = 0.006;

fn share(share: f64) -> Cell {
    Cell::number(share, percent(share))
}

/// All tables that say something, in the order in which they are read.
pub fn sufficiency_tables(of: &Sufficiency) -> Vec<Table> {
    let tables = [reached(of), errors(of), pairs(of), leverage(of), outside(of), next(of)];
    tables.into_iter().filter(|table| !table.rows.is_empty()).collect()
}

fn reached(of: &Sufficiency) -> Table {
    let moves = |own: &AxisReach| own.full_scale > 0.0;
    let part = |own: &AxisReach, end: f64| {
        Cell::known(moves(own).then(|| share(end / own.full_scale)), "the load does not move")
    };
    Table::of(&of.axes)
        .words("Axis", |own| own.axis.label())
        .digits("from", 4, |own| Some(own.low))
        .digits("to", 4, |own| Some(own.high))
        .digits("full scale", 4, |own| moves(own).then_some(own.full_scale))
        .words("which is", |own| if own.rated { "rated" } else { "from the loads" })
        .about("Entered by somebody, or what the training loads span")
        .column(Column::numbers("from, of it"), |own| part(own, own.low))
        .column(Column::numbers("to, of it"), |own| part(own, own.high))
        .table("Training loads", "")
}

fn errors(of: &Sufficiency) -> Table {
    let ratio = |own: &AxisReach, error: Option<f64>| {
        let train = own.train_rmse.filter(|train| *train > 1e-9 * own.deviation);
        Some(error? / train?)
    };
    let over_fit = "Over the error of the fit";
    Table::of(&of.axes)
        .words("Axis", |own| own.axis.label())
        .digits("load", 4, |own| Some(own.deviation))
        .about(
            "Standard deviation of the training load: the error of somebody who always says its mean",
        )
        .digits("fit", 4, |own| own.train_rmse)
        .about("RMSE on the training samples")
        .digits("left out", 4, |own| own.left_out_rmse)
        .about("RMSE by cross-validation")
        .digits("× fit", 3, |own| ratio(own, own.left_out_rmse))
        .about(over_fit)
        .digits("load left out", 4, |own| own.load_left_out_rmse)
        .about(
            "RMSE where all samples of a load are predicted by the fit to the others; not with a past, nor with very many loads",
        )
        .digits("× fit", 3, |own| ratio(own, own.load_left_out_rmse))
        .about(over_fit)
        .table("Errors", "")
}

fn pairs(of: &Sufficiency) -> Table {
    let known = |cell: Option<Cell>| Cell::known(cell, "one of them does not move");
    Table::of(&of.pairs)
        .words("Axes", |own| own.axes.map(Axis::symbol).join(", "))
        .column(Column::numbers("correlation"), |own| {
            known(own.correlation.map(|r| Cell::number(r, format!("{r:+.2}"))))
        })
        .column(Column::numbers("enclosed"), |own| known(own.covered.map(share)))
        .about("The share of the rectangle of both full scales (or of both ranges, where none is entered) that the loads enclose")
        .table("Pairs of axes", "")
}

fn leverage(of: &Sufficiency) -> Table {
    let n = of.leverage.len();
    let listed = if n > 1 { LISTED } else { 0 };
    Table::of(of.leverage.iter().take(listed))
        .words("Recording", |own| &own.recording)
        .column(Column::numbers("of the samples"), |own| share(own.sample_share))
        .about("Its share of the training samples")
        .column(Column::numbers("of the leverage"), |own| share(own.share))
        .about("Its share of what determines the coefficients")
        .digits("leverage", 3, |own| Some(own.leverage))
        .about("The trace of (ΣG)⁻¹ G: over all recordings it adds up to the rank")
        .table("What rests on each recording", and_more(n, LISTED).unwrap_or_default())
}

fn outside(of: &Sufficiency) -> Table {
    let mut all: Vec<_> = of.outside.iter().collect();
    all.sort_by(|a, b| b.is_test.cmp(&a.is_test).then(b.share.total_cmp(&a.share)));
    Table::of(all.iter().take(LISTED))
        .words("Of", |own| match own.is_test {
            true => "test recordings".to_owned(),
            false => format!("{}, left out", own.of),
        })
        .words("Axis", |own| own.axis.label())
        .column(Column::numbers("of its samples"), |own| share(own.share))
        .digits("by up to", 3, |own| Some(own.farthest))
        .table("Loads outside those of the others", and_more(all.len(), LISTED).unwrap_or_default())
}

fn next(of: &Sufficiency) -> Table {
    let hangs = of.next.iter().any(|own| own.how.is_some());
    Table::of(of.next.iter().enumerate())
        .column(Column::numbers("No."), |(at, _)| Cell::whole(at + 1))
        .columns(
            of.axes.iter().enumerate(),
            |(_, own)| Column::load(own.axis),
            |(_, own), (axis, _)| Cell::digits(Some(own.load[*axis]), 3),
        )
        .digits("gain", 3, |(_, own)| Some(own.gain))
        .about("By how much the logarithm of the determinant of the design grows")
        .column(Column::numbers("variance left"), |(_, own)| share(own.variance_left))
        .about("What is left of the mean variance of predictions over these loads, with it and those above it")
        .columns(
            hangs.then_some("how"),
            |name| Column::words(*name),
            |(_, own), _| Cell::words(own.how.clone().unwrap_or_default()),
        )
        .table("Load cases to record next", of.next_note.clone())
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
