//! Controls of the regressor (linear fit, network or kernel), of the ridge, and of the training of networks and kernels.

use egui::Ui;
use egui_plot::{Legend, Line, LineStyle, PlotPoints};

use crate::{
    calibration::{
        CONSTANT_RATE, CROSS_VALIDATE, EARLY_STOPPING, EPOCHS, EpochReport, FitSettings, LANDMARKS,
        Learner, RIDGE, RidgeChoice, SEED,
    },
    engine::{Action, Engine, query::Background as _},
    features::Setting,
    questions::{TrainingStep, cross_validation_cost, models::asked::Train},
    scoring::score_set::ScoreSet,
    ui::{
        command::Out,
        controls::Controls as _,
        numbers::{duration, significant},
        palette, plots,
        setting::{found, number, switch},
    },
};

const LOSS_HEIGHT: f32 = 110.0;

/// Draws the settings of a network or kernel.
pub fn learner(ui: &mut Ui, engine: &Engine, settings: &mut FitSettings, out: &mut Out) {
    if let Some(learner) = settings.regressor.learner() {
        let (network, kernel) = (&mut settings.network, &mut settings.kernel);
        ui.horizontal_wrapped(|ui| match learner {
            Learner::Network => {
                number(ui, &EPOCHS, &mut network.epochs);
                number(ui, &SEED, &mut network.seed);
                switch(ui, &CONSTANT_RATE, &mut network.constant_rate);
                switch(ui, &EARLY_STOPPING, &mut network.early_stopping);
                switch(ui, &CROSS_VALIDATE, &mut network.cross_validate);
            }
            Learner::Kernel => number(ui, &LANDMARKS, &mut kernel.landmarks),
        });
        let epochs = engine.lane::<Train>().answer().map_or(&[][..], |trained| &trained.epochs);
        if learner == Learner::Network && !epochs.is_empty() {
            loss_curve(ui, epochs, out);
        }
    }
}

pub fn in_use(settings: &FitSettings) -> Vec<Setting> {
    let of_learner: &[Setting] = match settings.regressor.learner() {
        Some(Learner::Network) => &[EPOCHS, SEED, CONSTANT_RATE, EARLY_STOPPING, CROSS_VALIDATE],
        Some(Learner::Kernel) => &[LANDMARKS],
        None => &[],
    };
    [&[RIDGE], of_learner].concat()
}

pub fn ridge(ui: &mut Ui, ridge: &mut RidgeChoice) {
    let (mut auto, mut by_block) = match *ridge {
        RidgeChoice::Strength(_) => (false, false),
        RidgeChoice::Auto => (true, false),
        RidgeChoice::ByBlock => (true, true),
    };
    match ridge {
        RidgeChoice::Strength(strength) => number(ui, &RIDGE, strength),
        RidgeChoice::Auto | RidgeChoice::ByBlock => {
            ui.label(RIDGE.label).on_hover_text(RIDGE.help());
        }
    }
    let switch = ui.checkbox(&mut auto, "auto");
    if !matches!(ridge, RidgeChoice::Strength(_)) {
        found(&RIDGE, &switch);
    }
    let mut is_changed = switch.on_hover_text(RIDGE.help()).changed();
    if auto {
        let switch = ui.tick(
            &mut by_block,
            "for each feature",
            "Chooses a ridge strength for each feature and axis, and omits features that do not reduce the error. Takes longer",
        );
        is_changed |= switch;
    }
    if is_changed {
        *ridge = match (auto, by_block) {
            (false, _) => RidgeChoice::default(),
            (true, false) => RidgeChoice::Auto,
            (true, true) => RidgeChoice::ByBlock,
        };
    }
}

/// Draws the button that trains a network or kernel, or the progress of its training.
pub fn training(
    ui: &mut Ui,
    engine: &Engine,
    settings: &FitSettings,
    learner: Learner,
    out: &mut Out,
) {
    let trained = engine.lane::<Train>().answer();
    let epochs = trained.map_or(&[][..], |trained| &trained.epochs);
    let fits = engine.fitting().is_some();
    ui.horizontal_wrapped(|ui| {
        if let Some(running) = engine.lane::<Train>().running() {
            let is_running = !running.progress.is_cancelled();
            let about = "Stops the training and keeps the best network so far";
            if ui.press_if(is_running, "Stop training", about) {
                out.send(Action::StopTraining);
            }
            ui.label(match trained.and_then(|trained| trained.step) {
                Some(step @ TrainingStep::Epoch(report)) => {
                    let left = duration(step.time_left());
                    let text = format!("epoch {} of {}, {left} left", report.epoch, report.epochs);
                    match cross_validation_cost(settings) {
                        0.0 => text,
                        cost => {
                            let whole = report.elapsed + report.time_left();
                            format!("{text}, then {} for the cross-validation", duration(whole.mul_f64(cost)))
                        }
                    }
                }
                Some(step) => format!("cross-validation, {} left", duration(step.time_left())),
                None => "training".to_owned(),
            });
        } else {
            let wants_score = learner == Learner::Network && settings.network.cross_validate;
            let lacks_score = wants_score && trained.is_none_or(|model| !model.is_cross_validated());
            let label = match learner {
                Learner::Network if wants_score => cost_text(settings, epochs.last()),
                Learner::Network => "Train the network".to_owned(),
                Learner::Kernel => "Train the kernel".to_owned(),
            };
            if ui.press_if(
                !fits || lacks_score,
                label,
                "Trains in the background, on the training recordings with the present settings. You can stop the training at any time",
            ) {
                out.send(Action::Train);
            }
            let (color, text) = match (fits, trained.and_then(|trained| trained.calibration.as_ref())) {
                (true, _) => (ui.visuals().weak_text_color(), "The compensated load is computed by the trained model."),
                (false, Some(_)) => (
                    ui.visuals().warn_fg_color,
                    "The trained model belongs to other settings or recordings. Until the next training, the compensated load is computed by the linear fit.",
                ),
                (false, None) => (
                    ui.visuals().warn_fg_color,
                    "Not trained yet: the compensated load is computed by the linear fit.",
                ),
            };
            ui.colored_label(color, text);
        }
    });
}

/// Returns the label of the button that trains and cross-validates the network. The label holds the time that this takes,
/// estimated from the previous training.
fn cost_text(settings: &FitSettings, last: Option<&EpochReport>) -> String {
    let cost = 1.0 + cross_validation_cost(settings);
    let cost = match last {
        Some(report) => {
            let of_epoch = report.elapsed.div_f64(report.epoch.max(1) as f64);
            duration(of_epoch.mul_f64(cost * settings.network.epochs as f64))
        }
        None => format!("{cost:.1} times the duration of the training alone"),
    };
    format!("Train and cross-validate the network (about {cost})")
}

fn loss_curve(ui: &mut Ui, epochs: &[EpochReport], out: &mut Out) {
    let curve = |loss: &dyn Fn(&EpochReport) -> Option<f64>| -> PlotPoints<'_> {
        epochs
            .iter()
            .filter_map(|report| {
                let loss = loss(report).filter(|loss| *loss > 0.0)?;
                Some([report.epoch as f64, loss.log10()])
            })
            .collect()
    };
    let train = curve(&|report| Some(report.train_loss));
    let held_out = curve(&|report| report.held_out_loss);
    let visuals = ui.visuals().clone();
    let plot = plots::still("loss", [ui.available_width(), LOSS_HEIGHT]);
    let shown = plots::scales(plot, Some("epoch"), "loss")
        .legend(Legend::default())
        .y_axis_formatter(|mark, _| significant(10_f64.powf(mark.value), 2))
        .show(ui, |plot| {
            for (name, points, set, style) in [
                ("train", train, ScoreSet::Train, LineStyle::dotted_dense()),
                ("held out", held_out, ScoreSet::LeftOut, LineStyle::Solid),
            ] {
                let color = palette::score(set, &visuals);
                plot.line(Line::new(name, points).color(color).style(style).width(1.5));
            }
        });
    plots::finish(&shown.response, "Training loss", None, out);
}
