//! The table of the error budget.

use strum::IntoEnumIterator as _;

use crate::{
    questions::budget::{query::ErrorBudget, sentence},
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

/// Returns the table of one budget: a row for each cause, a column for each pool of axes, root shares in % of full scale.
/// The squares of the shares add to the square of the total.
pub fn budget_table(of: &ErrorBudget) -> Table {
    let rows = [Row::Total].into_iter().chain(Cause::iter().map(Row::Cause));
    let rows: Vec<Row> = rows.chain([Row::Noise, Row::Unexplained]).collect();
    let head = |(name, ..): &(String, &Budget, usize)| Column::numbers(name.as_str()).unit("% FS");
    let uncompensated = [("uncompensated", &of.uncompensated)];
    let compensated = of.compensated.iter().map(|own| ("compensated", own));
    let budgets: Vec<(&str, &Budget)> = uncompensated.into_iter().chain(compensated).collect();
    let columns = of.pools.iter().enumerate().flat_map(|(pool, name)| {
        budgets.iter().map(move |(kind, budget)| (format!("{name}, {kind}"), *budget, pool))
    });
    Table::of(&rows)
        .words("Cause", |row| match row {
            Row::Total => "error".to_owned(),
            Row::Cause(cause) => sentence::name(*cause, &of.uncompensated).to_owned(),
            Row::Noise => "noise".to_owned(),
            Row::Unexplained => "unexplained".to_owned(),
        })
        .columns(columns, head, |row, (_, budget, pool)| cell(**row, budget, *pool))
        .table("Where the error comes from", of.sentences().join(" "))
}

fn cell(row: Row, budget: &Budget, pool: usize) -> Cell {
    let shares: &Shares = match &budget.pools[pool] {
        Ok(shares) => shares,
        Err(reason) => return Cell::known(None, reason.to_string()),
    };
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
