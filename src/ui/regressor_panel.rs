//! Controls of the regressor (linear fit, network or kernel), of the ridge, and of the training of networks and kernels.

use egui::Ui;

use crate::{
    calibration::{
        CONSTANT_RATE, CROSS_VALIDATE, EARLY_STOPPING, EPOCHS, FitSettings, LANDMARKS, Learner,
        RIDGE, RidgeChoice, SEED,
    },
    engine::{Action, Engine, query::Background as _},
    features::Setting,
    questions::{cross_validation_cost, models::asked::Train},
    ui::{
        command::Out,
        controls::Controls as _,
        numbers::duration,
        setting::{found, number, switch},
    },
};

/// Draws the settings of a network or kernel.
pub fn learner(ui: &mut Ui, settings: &mut FitSettings) {
    let (network, kernel) = (&mut settings.network, &mut settings.kernel);
    ui.horizontal_wrapped(|ui| match settings.regressor.learner() {
        Some(Learner::Network) => {
            number(ui, &EPOCHS, &mut network.epochs);
            number(ui, &SEED, &mut network.seed);
            switch(ui, &CONSTANT_RATE, &mut network.constant_rate);
            switch(ui, &EARLY_STOPPING, &mut network.early_stopping);
            switch(ui, &CROSS_VALIDATE, &mut network.cross_validate);
        }
        Some(Learner::Kernel) => number(ui, &LANDMARKS, &mut kernel.landmarks),
        None => {}
    });
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
    ui.horizontal_wrapped(|ui| {
        if let Some(running) = engine.lane::<Train>().running() {
            let is_running = !running.progress.is_cancelled();
            let about = "Stops the training and keeps the best network so far";
            if ui.press_if(is_running, "Stop training", about) {
                out.send(Action::StopTraining);
            }
            let step = trained.and_then(|trained| trained.step);
            let left = step.map(|step| format!("{} left", duration(step.time_left())));
            ui.label(left.unwrap_or_else(|| "training".to_owned()));
            return;
        }
        let mut label = match learner {
            Learner::Network => "Train the network".to_owned(),
            Learner::Kernel => "Train the kernel".to_owned(),
        };
        if let Some(last) = trained.and_then(|trained| trained.epoch) {
            let n = settings.network.epochs as f64 * (1.0 + cross_validation_cost(settings));
            let time = last.elapsed.div_f64(last.epoch.max(1) as f64).mul_f64(n);
            label += &format!(" (about {})", duration(time));
        }
        let fits = engine.fitting().is_some();
        let wants_score = learner == Learner::Network && settings.network.cross_validate;
        let lacks_score = wants_score && trained.is_none_or(|model| !model.is_cross_validated());
        let about = "Trains in the background on the training recordings; you can stop it at any time";
        if ui.press_if(!fits || lacks_score, label, about) {
            out.send(Action::Train);
        }
        if fits {
            ui.weak("The compensated load is computed by the trained model.");
        } else if trained.is_some_and(|trained| trained.calibration.is_some()) {
            ui.warn("The trained model belongs to other settings or recordings; the linear fit stands in for it.");
        } else {
            ui.warn("Not trained yet; the linear fit stands in.");
        }
    });
}
