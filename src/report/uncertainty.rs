//! How far readings may be off, as tables.

use super::table::{Cell, Column, Table};
use crate::evaluation::numbers::significant;
use crate::evaluation::uncertainty::{Coverage, Source, StepQuantity, Uncertainty};

/// A share as percent.
fn share(of: f64) -> String {
    significant(100.0 * of, 3)
}

/// One row per axis: U, and how often it holds.
pub fn expanded(of: &Uncertainty) -> Table {
    let about = |name: &str, about: &str| Column {
        about: about.to_owned(),
        ..Column::numbers(name)
    };
    let mut columns = vec![
        Column::words("Axis"),
        Column::numbers("Full scale"),
        about(
            "U (k = 2)",
            "expanded uncertainty of a reading: the load is within U of it, in 95 of 100 cases",
        ),
        about("U [% FS]", "of full scale"),
        about(
            "Errors within U [%]",
            "of recordings that were left out, each judged by the U of the others",
        ),
        about(
            "Fewest in a group [%]",
            "the group with the fewest errors within U",
        ),
        about(
            "Degrees of freedom",
            "effective, by Welch and Satterthwaite; ∞ where groups do not differ",
        ),
    ];
    let tested = of.axes.iter().any(|own| own.test_coverage.is_some());
    if tested {
        columns.push(about(
            "Test within U [%]",
            "of the recordings in the test role",
        ));
    }
    let rows = of.axes.iter().map(|own| {
        let covered =
            |coverage: Result<&Coverage, &String>, pick: fn(&Coverage) -> f64| match coverage {
                Ok(coverage) => Cell::number(100.0 * pick(coverage), share(pick(coverage)))
                    .about(&coverage.least_of),
                Err(reason) => Cell::missing("–", reason.clone()),
            };
        let none = "no recording is in the test role".to_owned();
        let mut cells = vec![
            Cell::words(own.axis.symbol()),
            Cell::number(
                own.full_scale,
                format!("{} {}", significant(own.full_scale, 4), own.unit),
            ),
            Cell::number(
                own.expanded,
                format!("{} {}", significant(own.expanded, 3), own.unit),
            ),
            match own.percent_fs {
                Some(percent) => Cell::digits(Some(percent), 3),
                None => Cell::missing("–", "no full scale"),
            },
            covered(own.coverage.as_ref(), |own| own.share),
            covered(own.coverage.as_ref(), |own| own.least),
            match own.degrees {
                Some(degrees) => Cell::number(degrees, format!("{degrees:.0}")),
                None => Cell::words("∞"),
            },
        ];
        if tested {
            cells.push(covered(own.test_coverage.as_ref().ok_or(&none), |own| {
                own.share
            }));
        }
        cells
    });
    Table {
        title: "Uncertainty of a reading".to_owned(),
        columns,
        rows: rows.collect(),
        note: format!("U = 2 u of {}.", of.of),
    }
}

/// One row per source, one column per axis: standard uncertainties.
pub fn budget(of: &Uncertainty) -> Table {
    let mut columns = vec![Column::words("Source"), Column::words("Counts")];
    columns.extend(of.axes.iter().map(|own| Column::load(own.axis)));
    let row = |source: Source| {
        let texts = source.texts();
        let parts = of
            .axes
            .iter()
            .map(|own| own.budget.iter().find(|part| part.source == source));
        let parts: Vec<_> = parts.collect();
        let added = parts.iter().flatten().any(|part| part.added);
        let mut cells = vec![
            Cell::words(texts.name).about(format!("{}\n{}", texts.formula, texts.basis)),
            Cell::words(if added { "added" } else { "within the errors" }),
        ];
        let same = parts
            .iter()
            .map(|part| part.and_then(|part| part.standard.as_ref().err()));
        let same: Vec<_> = same.collect();
        if let Some(Some(reason)) = same.first()
            && same.iter().all(|own| *own == Some(reason))
        {
            cells.push(Cell::missing("–", (*reason).clone()));
            cells.resize(columns.len(), Cell::continued());
            return cells;
        }
        cells.extend(
            parts
                .iter()
                .map(|part| match part.map(|part| &part.standard) {
                    Some(Ok(standard)) => Cell::digits(Some(*standard), 3),
                    Some(Err(reason)) => Cell::missing("–", reason.clone()),
                    None => Cell::none(),
                }),
        );
        cells
    };
    let mut rows: Vec<Vec<Cell>> = Source::ALL.into_iter().map(row).collect();
    for (name, pick) in [
        (
            "Combined, u",
            (|own| own.standard) as fn(&crate::evaluation::uncertainty::AxisUncertainty) -> f64,
        ),
        ("Expanded, U = 2 u", |own| own.expanded),
    ] {
        let mut cells = vec![Cell::words(name), Cell::words("")];
        cells.extend(of.axes.iter().map(|own| Cell::digits(Some(pick(own)), 3)));
        rows.push(cells);
    }
    Table {
        title: "Budget: standard uncertainties".to_owned(),
        columns,
        rows,
        note: "What counts within the errors is a part of the errors on what was left out, which count as a whole, and can be more than it where it is a worst case; what is added is in none of them."
            .to_owned(),
    }
}

/// One row per figure of load steps, one column per axis.
pub fn steps(of: &Uncertainty) -> Table {
    let mut columns = vec![Column::words("Figure"), Column::words("Unit")];
    columns.extend(
        of.steps
            .iter()
            .map(|own| Column::numbers(own.axis.symbol())),
    );
    let row = |(at, quantity): (usize, StepQuantity)| {
        let [symbol, name, about] = quantity.texts();
        let unit = match of.steps.first() {
            Some(_) if quantity == StepQuantity::LowerLimitFactor => "N, N·m",
            Some(own) => quantity.unit(own.axis),
            None => "",
        };
        let mut cells = vec![
            Cell::words(format!("{symbol}, {}", lower(name))).about(about),
            Cell::words(unit),
        ];
        cells.extend(of.steps.iter().map(|own| match &own.figures[at].value {
            Ok(value) => Cell::digits(Some(*value), 3),
            Err(reason) => Cell::missing("–", reason.clone()),
        }));
        cells
    };
    Table {
        title: "Load steps (ISO 376, ASTM E74)".to_owned(),
        columns,
        rows: StepQuantity::ALL.into_iter().enumerate().map(row).collect(),
        note: match of.steps.iter().all(|own| own.levels.is_empty()) {
            true => "No axis alone is loaded in steps that are held.".to_owned(),
            false => "Of steps of one axis alone, from 10 % of full scale on.".to_owned(),
        },
    }
}

fn lower(name: &str) -> String {
    let mut letters = name.chars();
    let first = letters.next().map(char::to_lowercase);
    first.into_iter().flatten().chain(letters).collect()
}

/// All of them, in the order in which they are read.
pub fn uncertainty_tables(of: &Uncertainty) -> Vec<Table> {
    let has_steps = of.steps.iter().any(|own| !own.levels.is_empty());
    let steps = has_steps.then(|| steps(of));
    [expanded(of), budget(of)]
        .into_iter()
        .chain(steps)
        .collect()
}
