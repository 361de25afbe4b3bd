//! Makes the tables that show the result of a check of the recordings.

use crate::questions::check::independent_loads::Sufficiency;
use crate::report::table::{Cell, Column, Table};
use crate::scoring::numbers::percent;

pub fn sufficiency_tables(of: &Sufficiency) -> Vec<Table> {
    let tables = [axes(of), next(of)];
    of.rig.tables().into_iter().chain(tables).filter(|table| !table.rows.is_empty()).collect()
}

fn axes(of: &Sufficiency) -> Table {
    Table::of(&of.axes)
        .words("Axis", |own| own.axis.label())
        .digits("smallest load", 4, |own| Some(own.low))
        .digits("largest load", 4, |own| Some(own.high))
        .digits("full scale", 4, |own| (own.full_scale > 0.0).then_some(own.full_scale))
        .words("full scale from", |own| if own.rated { "rated load" } else { "recorded loads" })
        .digits("fit RMSE", 4, |own| own.train_rmse)
        .about("RMS error of the fit on the training samples")
        .digits("cross-validation RMSE", 4, |own| own.left_out_rmse)
        .about("RMS error on samples that cross-validation held out of the fit")
        .words("correlated with", |own| match own.moves_with {
            Some((other, r)) => format!("{} ({r:+.2})", other.symbol()),
            None => String::new(),
        })
        .about(
            "Other axis whose training loads correlate most with those of this axis, and the correlation",
        )
        .table("Training loads and errors", "")
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
        .about("Increase of the logarithm of the determinant of the information matrix if this load is recorded")
        .column(Column::numbers("remaining share of the variance"), |(_, own)| {
            Cell::number(own.variance_left, percent(own.variance_left))
        })
        .about("Share of the mean variance of predicted loads that remains after this load and the loads above it in the table are recorded")
        .columns(
            hangs.then_some("how"),
            |name| Column::words(*name),
            |(_, own), _| Cell::words(own.how.clone().unwrap_or_default()),
        )
        .table("Load cases to record next", of.next_note.clone())
}
