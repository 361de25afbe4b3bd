//! Compares error budgets with the truth: the Shapley values of the held-out error over the switches of simulated sensors. Run by
//! hand: `BUDGET_FROM=1 BUDGET_SENSORS=60 cargo test --release --test budget -- --ignored --nocapture`.

mod remedies;
mod sensor;

use std::collections::BTreeMap;
use std::sync::Mutex;

use loopscope::calibration::FitSettings;
use loopscope::features::{Blocks, FeatureSettings, Play};
use loopscope::progress::Progress;
use loopscope::questions::check::query::CheckData;
use loopscope::questions::{analyse, sufficiency};
use loopscope::recording::ValidRange;
use sensor::{SOURCES, Sensor};
use serde_json::Value;

const MODELS: [&str; 3] = ["conventional", "look-back", "play"];
/// Default radii of `--play`.
const RADII: [f64; 6] = [0.1, 0.2, 0.4, 0.7, 1.1, 1.6];
const HISTORY: [&str; 3] = ["hysteresis", "creep", "lag"];

fn settings(model: &str) -> FitSettings {
    let play = || FeatureSettings {
        blocks: Blocks::default().with(&Play, &RADII),
        ..FeatureSettings::present()
    };
    match model {
        "play" => FitSettings { features: play(), ..FitSettings::default() },
        _ => FitSettings::default(),
    }
}

/// Mean squared held-out errors of the conventional calibration, with look-back, and with play.
fn errors(sensor: &Sensor, sources: &[&str]) -> [f64; 3] {
    let of = |model: &str| {
        let request = sensor.request(sources, settings(model));
        let quality = analyse(&request, &Progress::default()).unwrap().calibration.quality.clone();
        [quality.conventional.cv_rmse, quality.compensated.cv_rmse].map(|rmse| {
            let rmse = rmse.unwrap();
            let squares = rmse.iter().map(|own| (own / Sensor::largest()).powi(2));
            squares.sum::<f64>() / rmse.len() as f64
        })
    };
    let ([conventional, look_back], [_, play]) = (of("look-back"), of("play"));
    [conventional, look_back, play]
}

/// Returns the true shares of each source, and the error of noise alone, for each model.
fn truth(sensor: &Sensor) -> [BTreeMap<&'static str, f64>; 3] {
    let active = &sensor.active;
    let n = active.len();
    let of_set: Vec<[f64; 3]> = (0..1 << n)
        .map(|set: usize| {
            let on = (0..n).filter(|at| set & (1 << at) != 0).map(|at| active[at]);
            errors(sensor, &on.collect::<Vec<_>>())
        })
        .collect();
    let factorial = |n: usize| (1..=n).map(|k| k as f64).product::<f64>();
    [0, 1, 2].map(|model| {
        let share = |at: usize| {
            let without = (0..1_usize << n).filter(|set| set & (1 << at) == 0);
            let terms = without.map(|set| {
                let k = set.count_ones() as usize;
                let weight = factorial(k) * factorial(n - 1 - k) / factorial(n);
                weight * (of_set[set | 1 << at][model] - of_set[set][model])
            });
            terms.sum::<f64>()
        };
        let mut shares: BTreeMap<&str, f64> = (0..n).map(|at| (active[at], share(at))).collect();
        shares.insert("noise", of_set[0][model]);
        shares.insert("total", of_set[(1 << n) - 1][model]);
        shares
    })
}

/// Returns the budgets and the sentence of a fit with a model.
fn budgets(sensor: &Sensor, model: &str) -> (Value, String) {
    let request = sensor.request(&sensor.active, settings(model));
    let asked = CheckData::of(&request, ValidRange::default());
    let found = sufficiency(&asked, &Progress::default()).unwrap();
    let budget = found.budget.as_ref().unwrap();
    (serde_json::to_value(budget).unwrap(), budget.sentences().join(" "))
}

#[derive(Debug, Default)]
struct Counts {
    budgets: usize,
    no_budget: usize,
    absent: usize,
    invented: usize,
    present: usize,
    missed: usize,
    named: usize,
    within: usize,
    ratios: Vec<f64>,
    mostly: [usize; 2],
    factors: Vec<f64>,
}

impl Counts {
    fn add(&mut self, budget: &Value, sensor: &Sensor, truth: &BTreeMap<&str, f64>) {
        let shares = &budget["pools"][0];
        if !shares["no_budget"].is_null() {
            self.no_budget += 1;
            return;
        }
        self.budgets += 1;
        self.factors.push(shares["factor"].as_f64().unwrap());
        let total = truth["total"];
        let named: BTreeMap<&str, f64> = (shares["shares"].as_array().unwrap().iter())
            .map(|own| (own["cause"].as_str().unwrap(), own["square"].as_f64().unwrap()))
            .collect();
        let reported = shares["total"].as_f64().unwrap();
        assert!(
            (reported / total - 1.0).abs() < 1e-6,
            "the total is that of the fit: {reported} {total}"
        );
        for source in SOURCES {
            let share = truth.get(source).copied();
            match (share, named.get(source)) {
                (None, found) if source != "temperature" || sensor.tests_temperature() => {
                    self.absent += 1;
                    self.invented += usize::from(found.is_some());
                }
                (Some(share), found) if share >= 0.04 * total => {
                    self.present += 1;
                    match found {
                        None => self.missed += 1,
                        Some(square) => {
                            let ratio = (square / share).sqrt();
                            self.named += 1;
                            self.within += usize::from((0.8..=1.2).contains(&ratio));
                            self.ratios.push(ratio);
                        }
                    }
                }
                _ => {}
            }
        }
    }

    /// Judges what a sentence calls most of the error.
    fn judge_mostly(&mut self, words: &str, truth: &BTreeMap<&str, f64>) {
        let words = words.split(['.', ';']).next().unwrap_or_default();
        if words.contains("not told apart") {
            return;
        }
        let of = |source: &str| truth.get(source).copied().unwrap_or(0.0);
        let mut sum = 0.0;
        if HISTORY.iter().any(|own| words.contains(own) && *own != "creep")
            || words.replace("slow creep", "").contains("creep")
        {
            sum += HISTORY.iter().map(|own| of(own)).sum::<f64>();
        }
        for source in ["curvature", "drift", "sensitivity", "noise"] {
            sum += if words.contains(source) { of(source) } else { 0.0 };
        }
        if words.contains("slow changes") {
            sum += of("zeros") + of("temperature") + of("creep");
        } else if words.contains("auxiliary channels") {
            sum += of("temperature");
        }
        self.mostly[usize::from(sum < 0.4 * truth["total"])] += 1;
    }
}

fn number(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

fn quantiles(of: &mut [f64]) -> [f64; 3] {
    of.sort_by(f64::total_cmp);
    [0.1, 0.5, 0.9].map(|share| of[((of.len() - 1) as f64 * share) as usize])
}

fn tried(first: u64, n: u64) -> [Counts; 3] {
    let counts = Mutex::new([(); 3].map(|()| Counts::default()));
    let next = std::sync::atomic::AtomicU64::new(first);
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                    if seed >= first + n {
                        break;
                    }
                    let sensor = Sensor::new(seed);
                    let truth = truth(&sensor);
                    let found = ["look-back", "play"].map(|model| budgets(&sensor, model));
                    let mut counts = counts.lock().unwrap();
                    for (at, (budget, words)) in found.iter().enumerate() {
                        println!("{seed} {}: {words} {:?}", MODELS[at + 1], truth[at + 1]);
                        let (before, after) =
                            words.split_once(". Compensated").unwrap_or((words, ""));
                        if at == 0 {
                            counts[0].add(&budget["uncompensated"], &sensor, &truth[0]);
                            if let Some((_, what)) = before.split_once("mostly ") {
                                counts[0].judge_mostly(what, &truth[0]);
                            }
                        }
                        let own = &mut counts[at + 1];
                        if !budget["compensated"].is_null() {
                            own.add(&budget["compensated"], &sensor, &truth[at + 1]);
                        }
                        if let Some((_, what)) = after.split_once("is mostly ") {
                            own.judge_mostly(what, &truth[at + 1]);
                        }
                    }
                }
            });
        }
    });
    counts.into_inner().unwrap()
}

#[test]
#[ignore = "takes minutes"]
fn shares_and_sentences_are_those_of_the_simulator() {
    let counts = tried(number("BUDGET_FROM", 1), number("BUDGET_SENSORS", 60));
    for (model, mut own) in MODELS.iter().zip(counts) {
        let (ratios, factors) = (quantiles(&mut own.ratios), quantiles(&mut own.factors));
        println!(
            "{model}: {} budgets, {} without; invented {} of {}; missed {} of {}; within 20 % {} of {}; ratios {ratios:.2?}; factors {factors:.3?}",
            own.budgets,
            own.no_budget,
            own.invented,
            own.absent,
            own.missed,
            own.present,
            own.within,
            own.named
        );
        println!("    mostly right and wrong: {:?}", own.mostly);
        assert!(20 * own.invented <= own.absent, "{model}");
        assert!(10 * own.mostly[1] <= own.mostly[0] + 10, "{model}");
    }
}
