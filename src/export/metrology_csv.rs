//! The metrology table as a table.

use std::io;

use crate::evaluation::metrology::{Figure, Metrology};
use crate::recording::write_csv::CsvWriter;

const HEADER: [&str; 17] = [
    "id",
    "quantity",
    "axis",
    "unit",
    "full_scale",
    "conventional",
    "conventional_percent_fs",
    "conventional_place",
    "conventional_reason",
    "compensated",
    "compensated_percent_fs",
    "compensated_place",
    "compensated_reason",
    "dead_band",
    "definition",
    "source",
    "free_running",
];

/// Writes one row per quantity and axis: conventional beside compensated, each in the axis' unit and in % of full scale,
/// with where it comes from, or with the reason why there is no figure; then what the quantity means.
///
/// Full scale and dead band are in the axis' load unit. Numbers are written so that reading them gives the same value.
///
/// # Errors
/// Whatever `out` fails with.
pub fn write_metrology_csv(table: &Metrology, out: &mut dyn io::Write) -> io::Result<()> {
    let mut csv = CsvWriter::new(out);
    csv.row(HEADER)?;
    for row in &table.rows {
        let about = &row.definition;
        for (at, cell) in row.cells.iter().enumerate() {
            let mut record = vec![
                about.id.clone(),
                about.name.clone(),
                cell.axis.symbol().to_owned(),
                cell.unit.to_owned(),
                table.full_scale[at].to_string(),
            ];
            record.extend(figure_cells(&cell.conventional));
            record.extend(figure_cells(&cell.compensated));
            record.push(table.dead_bands[at].to_string());
            record.extend([about.definition, about.source, about.free_running].map(str::to_owned));
            csv.row(&record)?;
        }
    }
    csv.flush()
}

/// Value, percent, place, reason; what is not there is empty.
fn figure_cells(figure: &Figure) -> [String; 4] {
    match figure {
        Ok(value) => [
            value.value.to_string(),
            value
                .percent_fs
                .map_or_else(String::new, |percent| percent.to_string()),
            value.place.as_ref().map_or_else(String::new, |place| {
                format!(
                    "{} {} s to {} s",
                    place.name, place.from_secs, place.to_secs
                )
            }),
            String::new(),
        ],
        Err(reason) => {
            let nothing = String::new;
            [nothing(), nothing(), nothing(), reason.to_string()]
        }
    }
}
