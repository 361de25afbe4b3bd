//! The table of the error budget.

use strum::IntoEnumIterator as _;

use crate::{
    questions::budget::query::ErrorBudget,
    report::table::{Cell, Column, Table},
    scoring::budget::{Budget, Cause, Shares},
};

/// Row of the table.
#[derive(Clone, Copy, PartialEq)]
pub enum Row {
    Total,
    Cause(Cause),
    Noise,
    Unexplained,
}

impl Row {
    /// Returns all rows: the total, the causes, and what is left.
    pub fn all() -> impl Iterator<Item = Self> {
        let causes = Cause::iter().map(Self::Cause);
        [Self::Total].into_iter().chain(causes).chain([Self::Noise, Self::Unexplained])
    }

    pub fn name(self, budget: &Budget) -> &'static str {
        match self {
            Self::Total => "error",
            Self::Cause(cause) => cause.name(budget.are_segments),
            Self::Noise => "noise",
            Self::Unexplained => "unexplained",
        }
    }

    /// Returns the part of the mean squared error; 0 for a cause that was not found.
    pub fn square(self, shares: &Shares) -> f64 {
        match self {
            Self::Total => shares.total,
            Self::Noise => shares.noise,
            Self::Unexplained => shares.unexplained,
            Self::Cause(cause) => {
                let found = shares.shares.iter().find(|share| share.cause == cause);
                found.map_or(0.0, |share| share.square)
            }
        }
    }

    /// Returns the root share in % of full scale, or words that say why there is none.
    pub fn cell(self, budget: &Budget, shares: &Shares) -> Cell {
        match self {
            Self::Noise if !budget.noise_is_known => Cell::words("not known"),
            Self::Cause(cause) if shares.shares.iter().all(|share| share.cause != cause) => {
                Cell::words(match cause {
                    _ if budget.in_model.contains(&cause) => "in the model",
                    _ if !budget.tested.contains(&cause) => "not tested",
                    _ if shares.perhaps.contains(&cause) => "perhaps",
                    _ => "not found",
                })
            }
            _ => Cell::digits(Some(100.0 * self.square(shares).max(0.0).sqrt()), 3),
        }
    }
}

/// Returns the table of the budgets: a row for each cause, a column for each pool of axes whose error is split, root shares in %
/// of full scale. The squares of the shares add to the square of the total.
pub fn budget_table(of: &ErrorBudget) -> Table {
    let rows: Vec<Row> = Row::all().collect();
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
        .words("Cause", |row| row.name(&of.uncompensated))
        .columns(columns, head, |row, (_, budget, shares)| row.cell(budget, shares))
        .table("Where the error comes from", of.sentences().join(" "))
}
