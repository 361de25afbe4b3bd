//! Settings of the text layout, and of rows to recordings: rate, bursts, gaps, tare.

use egui::{ComboBox, DragValue};

use crate::formats::FilePart;
use crate::formats::text::{Decimal, Delimiter, TextLayout, Thousands};
use crate::import::map::{ColumnMap, Stamps};
use crate::recording::Tare;
use crate::ui::choice::choice;
use crate::ui::controls::Controls as _;

pub(super) fn layout(ui: &mut egui::Ui, text: &mut TextLayout) {
    ui.horizontal_wrapped(|ui| {
        let button =
            ComboBox::from_label("delimiter").selected_text(text.delimiter.name()).width(90.0);
        let items = Delimiter::ALL.into_iter();
        let items = items.map(|delimiter| (delimiter, delimiter.name().into(), ""));
        choice(ui, button, &mut text.delimiter, items)
            .on_hover_text("Character between the cells of a line");
        let mut comma = text.decimal == Decimal::Comma;
        if ui.tick(&mut comma, "decimal comma", "1,5 is one and a half") {
            text.decimal = match comma {
                true => Decimal::Comma,
                false => Decimal::Point,
            };
        }
        let name = |own: Option<Thousands>| own.map_or("none", Thousands::name);
        let button =
            ComboBox::from_label("thousands").selected_text(name(text.thousands)).width(90.0);
        let items = [None].into_iter().chain(Thousands::ALL.map(Some));
        let items = items.map(|own| (own, name(own).into(), ""));
        choice(ui, button, &mut text.thousands, items)
            .on_hover_text("Character between groups of three digits, as in 1,234.5");
        let lines = DragValue::new(&mut text.skip_rows).range(0..=100_000);
        ui.field("skip lines", lines, "Number of lines before the table");
        ui.tick(
            &mut text.header,
            "header row",
            "The first line of the table holds the names of the columns",
        );
        ui.tick(&mut text.units_row, "units row", "The next line holds the units");
    });
}

pub(super) fn parts(ui: &mut egui::Ui, parts: &[FilePart], text: &mut TextLayout) {
    if parts.is_empty() {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        ui.label("Tables to read:");
        for part in parts {
            let mut is_used = part.is_used;

            let explanation = format!(
                "{}. One topic of gauges and one of the reference are joined; tables with the same columns are read one after the other",
                part.what
            );
            if ui.tick(&mut is_used, &part.name, explanation) { let used = parts.iter().filter(|own| match own.name == part.name {
                    true => is_used,
                    false => own.is_used,
                });
                let used: Vec<String> = used.map(|own| own.name.clone()).collect();
                // One table stays selected.
                if !used.is_empty() {
                    text.parts = used;
                }
            }
        }
    });
}

pub(super) fn clock(ui: &mut egui::Ui, map: &mut ColumnMap) {
    ui.horizontal_wrapped(|ui| {
        optional(
            ui,
            [
                "sample rate",
                " Hz",
                "Sample rate, if no column is the time or the time counts samples",
            ],
            100.0,
            &mut map.table.sample_rate_hz,
        );
        let stamps = &mut map.table.stamps;
        let named = Stamps::ALL.into_iter().find(|(own, ..)| own == stamps);
        let button = ComboBox::from_label("times")
            .selected_text(named.map_or("", |(_, name, _)| name))
            .width(150.0);
        let items = Stamps::ALL.map(|(own, name, explanation)| (own, name.into(), explanation));
        choice(ui, button, stamps, items)
            .on_hover_text("For rows that are out of order or share one time");
        optional(
            ui,
            [
                "average bursts within",
                " s",
                "Averages successive gauge samples that are no further apart than this",
            ],
            0.001,
            &mut map.average_bursts_secs,
        );
        optional(
            ui,
            [
                "new recording after a pause of",
                " s",
                "A longer step in time starts a new recording; without a number, the limit follows from the steps",
            ],
            2.0,
            &mut map.gap_secs,
        );
        tare(ui, &mut map.tare);
    });
}

fn tare(ui: &mut egui::Ui, tare: &mut Option<Tare>) {
    let text = match tare {
        None => "none",
        Some(Tare::Auto) => "first quiet half second without load",
        Some(Tare::Interval(..)) => "a segment",
    };
    let button = ComboBox::from_label("tare").selected_text(text).width(150.0);
    let segment = match *tare {
        Some(segment @ Tare::Interval(..)) => segment,
        _ => Tare::Interval(0.0, 1.0),
    };
    let items = [
        (None, "none".into(), ""),
        (Some(Tare::Auto), "first quiet half second without load".into(), ""),
        (Some(segment), "a segment".into(), ""),
    ];
    choice(ui, button, tare, items).on_hover_text(
        "Subtracts the mean gauges of this interval. The sensor must be unloaded there",
    );
    if let Some(Tare::Interval(from, to)) = tare {
        for (name, value) in [("from", from), ("to", to)] {
            let field = DragValue::new(value).range(0.0..=1e9).speed(0.01).suffix(" s");
            ui.field(name, field, "Time from the recording's first sample");
        }
    }
}

pub(super) fn number(ui: &mut egui::Ui, [name, suffix, explanation]: [&str; 3], value: &mut f64) {
    let field = DragValue::new(value).speed(0.001).max_decimals(6).suffix(suffix);
    ui.field(name, field, explanation);
}
fn optional(
    ui: &mut egui::Ui,
    [name, suffix, explanation]: [&str; 3],
    default: f64,
    value: &mut Option<f64>,
) {
    let mut on = value.is_some();
    let tick = ui.checkbox(&mut on, name).on_hover_text(explanation);
    if tick.changed() {
        *value = on.then_some(default);
    }
    if let Some(value) = value {
        let speed = 0.01 * *value;
        let field =
            DragValue::new(value).range(1e-9..=1e9).max_decimals(6).speed(speed).suffix(suffix);
        ui.add(field).labelled_by(tick.id).on_hover_text(explanation);
    }
}
