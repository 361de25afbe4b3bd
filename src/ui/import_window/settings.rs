//! Settings of the text layout, and of the conversion from rows to recordings: sample rate, bursts of samples, pauses and
//! tare.

use egui::{DragValue, Ui};

use crate::{
    formats::{
        FilePart,
        text::{Decimal, Delimiter, TextLayout, Thousands},
    },
    import::map::{ColumnMap, Stamps},
    recording::Tare,
    ui::{choice::labelled_choice, controls::Controls as _},
};

pub fn layout(ui: &mut Ui, text: &mut TextLayout) {
    ui.horizontal_wrapped(|ui| {
        labelled_choice(
            ui,
            ("delimiter", 90.0),
            &mut text.delimiter,
            Delimiter::ALL,
            |delimiter| (delimiter.name(), ""),
        )
        .on_hover_text("Character between the cells of a line in the file");
        let mut comma = text.decimal == Decimal::Comma;
        if ui.tick(
            &mut comma,
            "decimal comma",
            "The decimal sign is a comma: 1,5 means one and a half",
        ) {
            text.decimal = if comma { Decimal::Comma } else { Decimal::Point };
        }
        let all = [None].into_iter().chain(Thousands::ALL.map(Some));
        let described = |mark: Option<Thousands>| (mark.map_or("none", Thousands::name), "");
        labelled_choice(ui, ("thousands", 90.0), &mut text.thousands, all, described)
            .on_hover_text(
                "Character between groups of three digits, such as the comma in 1,234.5",
            );
        let lines = DragValue::new(&mut text.skip_rows).range(0..=100_000);
        ui.field(
            "skip lines",
            lines,
            "Number of lines at the start of the file that are not part of the table",
        );
        ui.tick(
            &mut text.header,
            "header row",
            "The first line of the table holds the names of the columns",
        );
        ui.tick(&mut text.units_row, "units row", "The line after the header holds the units");
    });
}

pub fn parts(ui: &mut Ui, parts: &[FilePart], text: &mut TextLayout) {
    if parts.is_empty() {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        ui.label("Tables of the file to read:");
        for part in parts {
            let mut is_used = part.is_used;

            let explanation = format!(
                "{}. Ticked tables are read: joined by their times, or one after the other if they have the same columns",
                part.what
            );
            if ui.tick(&mut is_used, &part.name, explanation) {
                let used = parts.iter().filter(|other| {
                    if other.name == part.name { is_used } else { other.is_used }
                });
                let used: Vec<String> = used.map(|part| part.name.clone()).collect();
                if !used.is_empty() {
                    text.parts = used;
                }
            }
        }
    });
}

pub fn clock(ui: &mut Ui, map: &mut ColumnMap) {
    ui.horizontal_wrapped(|ui| {
        let about = "Sample rate, needed if there is no time column or if the time column counts samples";
        optional(ui, ["sample rate", " Hz", about], 100.0, &mut map.table.sample_rate_hz);
        let described = |stamps| {
            let named = Stamps::ALL.into_iter().find(|(known, ..)| *known == stamps);
            named.map_or(("", ""), |(_, name, explanation)| (name, explanation))
        };
        labelled_choice(ui, ("times", 150.0), &mut map.table.stamps, Stamps::ALL.map(|(stamps, ..)| stamps), described)
            .on_hover_text("What is done with rows whose times are out of order or equal");
        let about = "A pause between two samples that is longer than this starts a new recording. Without a tick, the limit follows from the time steps in the file";
        optional(ui, ["new recording after a pause of", " s", about], 2.0, &mut map.gap_secs);
        tare(ui, &mut map.tare);
    });
}

fn tare(ui: &mut Ui, tare: &mut Option<Tare>) {
    let described = |tare| match tare {
        None => ("none", ""),
        Some(Tare::Auto) => ("first quiet half second without load", ""),
        Some(Tare::Interval(..)) => ("an interval of time", ""),
    };
    let segment = tare.filter(|tare| *tare != Tare::Auto).unwrap_or(Tare::Interval(0.0, 1.0));
    let all = [None, Some(Tare::Auto), Some(segment)];
    labelled_choice(ui, ("tare", 150.0), tare, all, described).on_hover_text(
        "Subtracts the mean gauge values of an interval in which the sensor is unloaded",
    );
    if let Some(Tare::Interval(from, to)) = tare {
        for (name, value) in [("from", from), ("to", to)] {
            let field = DragValue::new(value).range(0.0..=1e9).speed(0.01).suffix(" s");
            ui.field(
                name,
                field,
                "Start or end of the tare interval, counted from the recording's first sample",
            );
        }
    }
}

pub fn number(ui: &mut Ui, [name, suffix, explanation]: [&str; 3], value: &mut f64) {
    let field = DragValue::new(value).speed(0.001).max_decimals(6).suffix(suffix);
    ui.field(name, field, explanation);
}
fn optional(
    ui: &mut Ui,
    [name, suffix, explanation]: [&str; 3],
    default: f64,
    value: &mut Option<f64>,
) {
    let mut on = value.is_some();
    let tick = ui.checkbox(&mut on, name).on_hover_text(explanation);
    *value = on.then_some(value.unwrap_or(default));
    if let Some(value) = value {
        let speed = 0.01 * *value;
        let field =
            DragValue::new(value).range(1e-9..=1e9).max_decimals(6).speed(speed).suffix(suffix);
        ui.add(field).labelled_by(tick.id).on_hover_text(explanation);
    }
}
