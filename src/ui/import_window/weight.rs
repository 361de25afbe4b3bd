//! Controls of a reference load that is computed from the sensor's pose and a known weight.

use egui::Ui;

use super::settings::number;
use crate::{
    engine::ImportCommand,
    import::map::{Angles, Attitude, ColumnMap, WeightMap},
    ui::{command::Out, controls::Controls as _},
};

pub fn weight(ui: &mut Ui, map: &mut ColumnMap, out: &mut Out) {
    let mut used = map.weight.is_some();
    if ui.tick(
        &mut used,
        "Computes the reference load of a known weight from the pose columns",
        format!(
            "The load of a weight is computed from the columns of the pose: {}",
            Attitude::listed()
        ),
    ) {
        map.weight = used.then(|| WeightMap {
            mass_kg: Some(1.0),
            centre_m: Some([0.0; 3]),
            ..WeightMap::default()
        });
    }
    let Some(weight) = &mut map.weight else {
        return;
    };
    ui.horizontal_wrapped(|ui| {
        if let Some(mass) = &mut weight.mass_kg {
            number(ui, ["mass", " kg", "Mass of everything that hangs on the sensor"], mass);
        }
        if let Some(centre) = &mut weight.centre_m {
            for (name, value) in ["centre x", "centre y", "centre z"].into_iter().zip(centre) {
                number(ui, [name, " m", "Centre of mass of the weight in the frame of the sensor"], value);
            }
        }
        let names = ["gravity x", "gravity y", "gravity z"];
        for (name, value) in names.into_iter().zip(&mut weight.gravity) {
            number(ui, [name, " m/s²", "Acceleration of gravity in the frame of the pose"], value);
        }
        ui.select_radio(
            &mut weight.angles,
            Angles::FixedXyz,
            "angles about fixed axes",
            "Roll, pitch and yaw turn about the axes of the base, in this order",
        );
        ui.select_radio(
            &mut weight.angles,
            Angles::IntrinsicXyz,
            "angles about the axes of the turned sensor",
            "Each angle turns about an axis that the previous angles have turned",
        );
        if ui.press(
            "Find the weight",
            "Estimates the mass from the pose and measured forces, and the centre of mass if moments are measured too",
        ) {
            out.send(ImportCommand::FindWeight);
        }
    });
}
