//! The table of the error budget.

use strum::IntoEnumIterator as _;

use crate::{
    questions::budget::query::ErrorBudget,
    report::table::{Cell, Column, Table},
    scoring::budget::{Budget, Cause, Shares},
};

/// Row of the table.
#[derive(Clone, Copy)]
enum Row {
    Total,
    Cause(Cause),
    Noise,
    Unexplained,
}

/// Returns the table of the budgets: a row for each cause, a column for each pool of axes whose error is split, root shares in %
/// of full scale. The squares of the shares add to the square of the total.
pub fn budget_table(of: &ErrorBudget) -> Table {
    let rows = [Row::Total].into_iter().chain(Cause::iter().map(Row::Cause));
    let rows: Vec<Row> = rows.chain([Row::Noise, Row::Unexplained]).collect();
    let uncompensated = [("", &of.uncompensated)];
    let compensated = of.compensated.iter().map(|own| (", compensated", own));
    let budgets: Vec<(&str, &Budget)> = uncompensated.into_iter().chain(compensated).collect();
    let columns = of.pools.iter().enumerate().flat_map(|(pool, name)| {
        budgets.iter().filter_map(move |(kind, budget)| {
            let shares = budget.pools[pool].as_ref().ok()?;
            Some((format!("{name}{kind}"), *budget, shares))
        })
    });
    let head =
        |(name, ..): &(String, &Budget, &Shares)| Column::numbers(name.as_str()).unit("% FS");
    Table::of(&rows)
        .words("Cause", |row| match row {
            Row::Total => "error".to_owned(),
            Row::Cause(cause) => cause.name(of.uncompensated.are_segments).to_owned(),
            Row::Noise => "noise".to_owned(),
            Row::Unexplained => "unexplained".to_owned(),
        })
        .columns(columns, head, |row, (_, budget, shares)| cell(**row, budget, shares))
        .table("Where the error comes from", of.sentences().join(" "))
}

fn cell(row: Row, budget: &Budget, shares: &Shares) -> Cell {
    let shown = |square: f64| Cell::digits(Some(100.0 * square.max(0.0).sqrt()), 3);
    match row {
        Row::Total => shown(shares.total),
        Row::Noise if budget.noise_is_known => shown(shares.noise),
        Row::Noise => Cell::words("not known"),
        Row::Unexplained => shown(shares.unexplained),
        Row::Cause(cause) => match shares.shares.iter().find(|own| own.cause == cause) {
            Some(own) => shown(own.square),
            None if budget.in_model.contains(&cause) => Cell::words("in the model"),
            None if !budget.tested.contains(&cause) => Cell::words("not tested"),
            None if shares.perhaps.contains(&cause) => Cell::words("perhaps"),
            None => Cell::words("not found"),
        },
    }
}
