//! What recordings tell of a model, as tables and a figure.

use crate::questions::check::independent_loads::{AxisReach, Sufficiency};
use crate::recording::Axis;
use crate::report::table::{Cell, Column, Table};
use crate::scoring::numbers::percent;

fn share(share: f64) -> Cell {
    Cell::number(share, percent(share))
}

/// All tables that say something, in the order in which they are read.
pub fn sufficiency_tables(of: &Sufficiency) -> Vec<Table> {
    let tables = [reached(of), errors(of), pairs(of), next(of)];
    of.rig.tables().into_iter().chain(tables).filter(|table| !table.rows.is_empty()).collect()
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
        .table("Pairs of axes", "")
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
