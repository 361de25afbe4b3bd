//! Makes the tables that show the result of a check of the recordings.

use crate::questions::check::independent_loads::Sufficiency;
use crate::report::table::Table;

pub fn sufficiency_tables(of: &Sufficiency) -> Vec<Table> {
    of.rig.tables().into_iter().chain([axes(of)]).collect()
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
