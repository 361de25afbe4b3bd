//! What changes from one session, or day, to the next: zero and sensitivity of every gauge, and what a calibration makes of it.

use serde::Serialize;

use crate::evaluation::Sensitivity;
use crate::evaluation::numbers::significant;
use crate::evaluation::sufficiency::{LoadSpread, percent};
use crate::recording::{Axis, DateSource, Day, RECORDING, Recording};

/// A session is cut into so many parts, whose scatter says how sure its figures are.
const PARTS: usize = 4;
/// A change below so many standard errors is none.
const SURE: f64 = 3.0;
/// Nor is one below this share, however sure.
const MATTERS: f64 = 0.002;
/// Sessions in which a calibration errs by no more than so many times as much are alike.
const ALIKE: f64 = 1.5;
/// The simplest refit within this share of the best is enough.
const AS_GOOD: f64 = 1.1;

/// One session.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Session {
    /// What it is called.
    pub name: String,
    /// When it began (s since 1970), where its clock says so.
    pub started: Option<f64>,
    /// The first day on which it was recorded, where that is known.
    pub day: Option<Day>,
    /// Where the days of its recordings come from, each once.
    pub dated_by: Vec<DateSource>,
    /// Its recordings.
    pub recordings: Vec<String>,
    /// How many samples it has.
    pub n_samples: u64,
    /// Zero and sensitivity of each gauge, where the loads move in all directions in which they are loaded.
    pub gauges: Option<Vec<GaugeState>>,
    /// Mean error of the old calibration, one per axis.
    pub mean_error: Vec<f64>,
    /// RMSE of the old calibration, one per axis.
    pub rmse: Vec<f64>,
}

/// A gauge in a session.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GaugeState {
    /// What it shows without a load.
    pub zero: f64,
    /// The standard error of that.
    pub zero_error: f64,
    /// What a unit of load on each axis adds.
    pub slopes: Vec<f64>,
    /// The standard errors of these.
    pub slope_errors: Vec<f64>,
}

/// What became of a gauge from the first session to the last.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GaugeChange {
    /// Its name.
    pub gauge: String,
    /// Its zero then and now.
    pub zero: [f64; 2],
    /// The change of the zero as a share of what full load makes of the gauge.
    pub zero_share: f64,
    /// The axis that it answers to most.
    pub axis: Axis,
    /// The change of its sensitivity on that axis, as a share.
    pub sensitivity_share: f64,
    /// Whether the change of the zero is more than the scatter within sessions.
    pub zero_is_sure: bool,
    /// Whether that of the sensitivity is.
    pub sensitivity_is_sure: bool,
}

/// How much of a calibration is fitted again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Refit {
    /// Nothing.
    Old,
    /// A constant for each axis.
    Offset,
    /// A matrix over the axes, with an offset.
    Transform,
    /// Everything.
    All,
}

impl Refit {
    /// What can be fitted again, the least first.
    pub const ALL: [Self; 3] = [Self::Offset, Self::Transform, Self::All];

    /// As arguments and files have it.
    pub fn key(self) -> &'static str {
        match self {
            Self::Old => "old",
            Self::Offset => "offset",
            Self::Transform => "transform",
            Self::All => "all",
        }
    }

    /// In words.
    pub fn label(self) -> &'static str {
        match self {
            Self::Old => "As it is",
            Self::Offset => "Offset only",
            Self::Transform => "Matrix on top",
            Self::All => "All",
        }
    }

    /// What is done.
    pub fn explanation(self) -> &'static str {
        match self {
            Self::Old => "The calibration that there is, on recordings that it never saw",
            Self::Offset => "A constant for each axis, on top of what there is",
            Self::Transform => "A matrix over the axes and an offset, on top of what there is",
            Self::All => "A new fit of the same features to the new recordings",
        }
    }
}

/// The errors of one way to go on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RefitScores {
    /// Which.
    pub refit: Refit,
    /// RMSE on what it was fitted to, one per axis.
    pub train_rmse: Option<Vec<f64>>,
    /// RMSE where new recordings, groups or blocks are left out; of the old calibration all are.
    pub left_out_rmse: Option<Vec<f64>>,
    /// Why it cannot be exported, or fitted.
    pub problem: Option<String>,
}

/// What changed between sessions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Drift {
    /// What the sessions are told apart by.
    pub by: &'static str,
    /// In order of time.
    pub sessions: Vec<Session>,
    /// From which of them on refits are fitted and judged: that in which the old calibration began to err as in the last.
    pub refitted_from: usize,
    /// Axes of the calibration.
    pub axes: Vec<Axis>,
    /// Their full scales.
    pub full_scale: Vec<f64>,
    /// The gauges' names.
    pub gauges: Vec<String>,
    /// What became of each gauge; empty where sessions cannot be compared.
    pub changes: Vec<GaugeChange>,
    /// Where the old calibration comes from.
    pub old: String,
    /// How left-out errors were left out.
    pub left_out: Option<String>,
    /// The ways to go on, the least first.
    pub refits: Vec<RefitScores>,
    /// What follows, in sentences without full stops.
    pub sentences: Vec<String>,
}

/// Zero and sensitivity of each gauge over these recordings, with the scatter of parts of them; `None` where the loads do not
/// tell them apart, or there are too few samples.
pub fn gauge_states(recordings: &[&Recording]) -> Option<Vec<GaugeState>> {
    let whole = Sensitivity::of(recordings)?;
    let n_axes = whole.moves.len();
    let ranges = |own: &[&Recording]| {
        let mut all = vec![(f64::INFINITY, f64::NEG_INFINITY); n_axes];
        for one in own {
            let each = all.iter_mut().zip(one.load_ranges());
            each.for_each(|(all, own)| *all = (all.0.min(own.0), all.1.max(own.1)));
        }
        all
    };
    let is_told = |own: &[&Recording]| {
        let loads = own
            .iter()
            .flat_map(|one| one.loads().chunks_exact(n_axes.max(1)));
        let spread = LoadSpread::of(loads, &ranges(own));
        spread.n_directions > 0
            && spread.n_directions == whole.moves.iter().filter(|moves| **moves).count()
    };
    if !is_told(recordings) {
        return None;
    }
    // Parts of each recording, so that each part sees most of its loads where recordings are many, else parts of one.
    let cut: Vec<Vec<Recording>> = recordings.iter().map(|own| own.segments(PARTS)).collect();
    let parts: Vec<Sensitivity> = match recordings.len() < PARTS {
        true => {
            let part = |at: usize| cut.iter().filter_map(|own| own.get(at)).collect::<Vec<_>>();
            (0..PARTS)
                .map(part)
                .filter(|own| is_told(own))
                .filter_map(|own| Sensitivity::of(&own))
                .collect()
        }
        false => {
            let part = |at: usize| {
                recordings
                    .iter()
                    .skip(at)
                    .step_by(PARTS)
                    .copied()
                    .collect::<Vec<_>>()
            };
            (0..PARTS)
                .map(part)
                .filter(|own| is_told(own))
                .filter_map(|own| Sensitivity::of(&own))
                .collect()
        }
    };
    let error = |of: &dyn Fn(&Sensitivity) -> f64| {
        let n = parts.len() as f64;
        let mean = parts.iter().map(of).sum::<f64>() / n;
        let squares: f64 = parts.iter().map(|own| (of(own) - mean).powi(2)).sum();
        if n < 2.0 {
            f64::INFINITY
        } else {
            (squares / (n - 1.0) / n).sqrt()
        }
    };
    let states = (0..whole.zero.len()).map(|gauge| GaugeState {
        zero: whole.zero[gauge],
        zero_error: error(&|own| own.zero[gauge]),
        slopes: whole.slopes[gauge].clone(),
        slope_errors: (0..n_axes)
            .map(|axis| error(&|own| own.slopes[gauge][axis]))
            .collect(),
    });
    Some(states.collect())
}

/// What became of each gauge from the first session to the last that can be compared.
pub fn changes(
    sessions: &[Session],
    gauges: &[String],
    axes: &[Axis],
    full_scale: &[f64],
) -> Vec<GaugeChange> {
    let mut told = sessions.iter().filter_map(|own| own.gauges.as_ref());
    let (Some(first), Some(last)) = (told.next(), told.next_back()) else {
        return Vec::new();
    };
    let change = |(name, (then, now)): (&String, (&GaugeState, &GaugeState))| {
        // What full load makes of the gauge, axis by axis; only axes that both sessions load.
        let response = |axis: &usize| (then.slopes[*axis] * full_scale[*axis]).abs();
        let both =
            (0..axes.len()).filter(|axis| then.slopes[*axis] != 0.0 && now.slopes[*axis] != 0.0);
        let axis = both.max_by(|a, b| response(a).total_cmp(&response(b)))?;
        let (full, moved) = (response(&axis), now.zero - then.zero);
        let slope_moved = now.slopes[axis] - then.slopes[axis];
        let is_sure = |moved: f64, errors: [f64; 2], whole: f64| {
            moved.abs() > SURE * errors[0].hypot(errors[1]) && moved.abs() > MATTERS * whole
        };
        let slope_errors = [then.slope_errors[axis], now.slope_errors[axis]];
        (full > 0.0).then(|| GaugeChange {
            gauge: name.clone(),
            zero: [then.zero, now.zero],
            zero_share: moved / full,
            axis: axes[axis],
            sensitivity_share: slope_moved / then.slopes[axis],
            zero_is_sure: is_sure(moved, [then.zero_error, now.zero_error], full),
            sensitivity_is_sure: is_sure(slope_moved, slope_errors, then.slopes[axis].abs()),
        })
    };
    gauges
        .iter()
        .zip(first.iter().zip(last))
        .filter_map(change)
        .collect()
}

/// From which session on an old calibration errs as it does in the last one; what was good before says nothing against a refit.
pub fn latest(sessions: &[Session], full_scale: &[f64]) -> usize {
    let errors: Vec<f64> = sessions
        .iter()
        .map(|own| of_full_scale(&own.rmse, full_scale))
        .collect();
    let Some(last) = errors.last() else {
        return 0;
    };
    let is_alike = |error: &&f64| **error <= ALIKE * last && *last <= ALIKE * **error;
    errors.len() - errors.iter().rev().take_while(is_alike).count().max(1)
}

/// Errors over full scale, all axes together.
fn of_full_scale(errors: &[f64], full_scale: &[f64]) -> f64 {
    let errors = errors.iter().zip(full_scale);
    let squares: Vec<f64> = errors
        .filter(|(_, scale)| **scale > 0.0)
        .map(|(error, scale)| (error / scale).powi(2))
        .collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}

impl Drift {
    /// Whether somebody or the clocks say that these are other sessions; else recordings may be of one day, and differ in what they load.
    pub fn is_between_sessions(&self) -> bool {
        let is_one = self.sessions.len() < 2;
        is_one || self.by != RECORDING || self.sessions.iter().all(|own| own.started.is_some())
    }

    /// Without what would be told of the gauges between recordings of which nothing says that they are other sessions, and without
    /// errors of a fit to one of them.
    pub fn of_unknown_days(mut self, is_calibration_given: bool) -> Self {
        self.changes.clear();
        self.sentences.clear();
        if is_calibration_given {
            let mut said = Vec::new();
            self.tell_refits(&mut said);
            self.sentences = said;
        } else {
            self.refits.clear();
        }
        let dated = |own: &&Session| own.day.is_some();
        let undated: Vec<&str> = self
            .sessions
            .iter()
            .filter(|own| !dated(own))
            .map(|own| &*own.name)
            .collect();
        self.sentences.push(match (undated.first(), self.sessions[0].day) {
            (None, Some(day)) => format!(
                "all recordings are of one day, {day}, so there is nothing between days to compare; where that is wrong, enter their \
                 dates (right-click a recording)"
            ),
            (Some(first), _) if undated.len() < self.sessions.len() => format!(
                "{first}{} no date, so what moved between days cannot be told; enter it (right-click a recording), or put the \
                 recordings of each day in a group",
                match undated.len() {
                    1 => " has".to_owned(),
                    n => format!(" and {} more have", n - 1),
                }
            ),
            _ => "nothing says which recordings are of another day: their clocks count from their own start, neither header nor name has a \
                  date, and nobody put them in groups; what moved between days cannot be told. Enter the dates of recordings, or put those \
                  of each day in a group (right-click a recording in the list)"
                .to_owned(),
        });
        self
    }

    /// With what follows from the figures.
    pub fn told(mut self) -> Self {
        let mut said = Vec::new();
        if self.sessions.len() < 2 {
            said.push("there is one session only, so nothing can be compared; open recordings of another day, or put them in groups".to_owned());
        }
        self.tell_gauges(&mut said);
        self.tell_refits(&mut said);
        self.sentences = said;
        self
    }

    fn tell_gauges(&self, said: &mut Vec<String>) {
        let days: Vec<Option<Day>> = self.sessions.iter().map(|own| own.day).collect();
        if self.by == RECORDING
            && days.len() > 1
            && days[0].is_some()
            && days.iter().all(|day| *day == days[0])
        {
            said.push(
                "all recordings are of one day, so they do not tell which gauge moved since the calibration was made; its errors do"
                    .to_owned(),
            );
            return;
        }
        if self.changes.is_empty() {
            if self.sessions.len() > 1 {
                said.push(
                    "no two sessions load the axes in as many independent directions as there are axes that move, so zeros and \
                     sensitivities of the gauges cannot be told apart"
                        .to_owned(),
                );
            }
            return;
        }
        let signed = |share: f64| {
            format!(
                "{}{}",
                if share < 0.0 { "−" } else { "+" },
                percent(share.abs())
            )
        };
        let zeros = self.changes.iter().filter(|own| own.zero_is_sure);
        match zeros.max_by(|a, b| a.zero_share.abs().total_cmp(&b.zero_share.abs())) {
            Some(own) => said.push(format!(
                "the zero of {} moved most: {} of what full load makes of it, from {} to {}",
                own.gauge,
                signed(own.zero_share),
                significant(own.zero[0], 4),
                significant(own.zero[1], 4),
            )),
            None => said
                .push("no gauge's zero moved by more than it scatters within a session".to_owned()),
        }
        let slopes = self.changes.iter().filter(|own| own.sensitivity_is_sure);
        match slopes.max_by(|a, b| {
            a.sensitivity_share
                .abs()
                .total_cmp(&b.sensitivity_share.abs())
        }) {
            Some(own) => said.push(format!(
                "the sensitivity of {} to {} moved most: {}",
                own.gauge,
                own.axis.symbol(),
                signed(own.sensitivity_share)
            )),
            None => said.push(
                "no gauge's sensitivity moved by more than it scatters within a session".to_owned(),
            ),
        }
    }

    /// The left-out error of a way over full scale, all axes together.
    fn error(&self, refit: Refit) -> Option<f64> {
        let own = self.refits.iter().find(|own| own.refit == refit)?;
        let moves = self.full_scale.iter().any(|scale| *scale > 0.0);
        let errors = own.left_out_rmse.as_ref().filter(|_| moves)?;
        Some(of_full_scale(errors, &self.full_scale))
    }

    fn tell_refits(&self, said: &mut Vec<String>) {
        let Some(old) = self.error(Refit::Old) else {
            return;
        };
        let others = Refit::ALL
            .iter()
            .filter_map(|refit| Some((*refit, self.error(*refit)?)));
        let others: Vec<(Refit, f64)> = others.collect();
        let before = &self.sessions[..self.refitted_from.min(self.sessions.len())];
        let named: Vec<&str> = self.sessions[before.len()..]
            .iter()
            .map(|own| &*own.name)
            .collect();
        let of_before = before
            .iter()
            .map(|own| of_full_scale(&own.rmse, &self.full_scale));
        let of_before = of_before.fold(0.0, f64::max);
        said.push(match before.len() {
            0 | 1 => format!(
                "on the new recordings the old calibration errs by {} of full scale",
                percent(old)
            ),
            n_before => format!(
                "in {} the old calibration errs by {} of full scale, in the {n_before} sessions before by {} at most",
                named.join(", "),
                percent(old),
                percent(of_before),
            ),
        });
        let Some(best) = others
            .iter()
            .map(|(_, error)| *error)
            .chain([old])
            .min_by(f64::total_cmp)
        else {
            return;
        };
        if others.is_empty() {
            said.push(
                "there is too little new to fit anything again and to score it on what is left out"
                    .to_owned(),
            );
        } else if old <= AS_GOOD * best {
            said.push(
                "no refit does clearly better on what is left out: keep it as it is".to_owned(),
            );
        } else if let Some((refit, error)) =
            others.iter().find(|(_, error)| *error <= AS_GOOD * best)
        {
            let how = match refit {
                Refit::Offset => "another offset is enough",
                Refit::Transform => "a matrix over the axes on top is enough",
                Refit::All | Refit::Old => "a new fit is what helps",
            };
            said.push(format!(
                "{how}: left out, it errs by {} of full scale",
                percent(*error)
            ));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::recording::Source;

    fn recording(zero: f64, slope: f64, noise: f64) -> Recording {
        let mut random = Random::new(4, &[(1e3 * zero) as u64, (1e3 * slope) as u64]);
        let loads: Vec<f64> = (0..400)
            .map(|k| 10.0 * (0.1 * f64::from(k)).sin())
            .collect();
        let recording = Recording::new(
            "r",
            Source::Simulated,
            (0..400).map(f64::from).collect(),
            vec!["S1".to_owned()],
            loads
                .iter()
                .map(|load| zero + slope * load + noise * random.normal())
                .collect(),
            vec![Axis::Fz],
            loads.clone(),
        );
        recording.unwrap()
    }

    fn session(recording: &Recording) -> Session {
        Session {
            name: "s".to_owned(),
            started: None,
            day: None,
            dated_by: Vec::new(),
            recordings: Vec::new(),
            n_samples: 400,
            gauges: gauge_states(&[recording]),
            mean_error: Vec::new(),
            rmse: Vec::new(),
        }
    }

    #[test]
    fn a_refit_is_to_the_sessions_that_are_as_the_last() {
        let of = |errors: &[f64]| {
            let one = |error: &f64| Session {
                rmse: vec![*error, 0.0],
                ..session(&recording(1.0, 2.0, 0.01))
            };
            let sessions: Vec<Session> = errors.iter().map(one).collect();
            latest(&sessions, &[10.0, 0.0])
        };
        assert_eq!(of(&[0.1, 0.12, 0.1, 3.0]), 3, "the last alone changed");
        assert_eq!(of(&[0.1, 3.1, 2.9, 3.0]), 1, "since then");
        assert_eq!(of(&[3.0, 0.1, 0.1]), 1, "it is good again");
        assert_eq!(of(&[0.1, 0.11, 0.1]), 0);
        assert_eq!(of(&[0.0, 0.0]), 0);
        assert_eq!(of(&[]), 0);
    }

    #[test]
    fn recordings_of_unknown_days_do_not_drift() {
        let sessions = [1.0, 2.0].map(|zero| session(&recording(zero, 2.0, 0.01)));
        let refit = |refit| RefitScores {
            refit,
            train_rmse: None,
            left_out_rmse: Some(vec![1.0]),
            problem: None,
        };
        let drift = Drift {
            by: RECORDING,
            refitted_from: 1,
            sessions: sessions.to_vec(),
            axes: vec![Axis::Fz],
            full_scale: vec![10.0],
            gauges: vec!["S1".to_owned()],
            changes: Vec::new(),
            old: String::new(),
            left_out: None,
            refits: Refit::ALL.map(refit).to_vec(),
            sentences: Vec::new(),
        };
        assert!(!drift.is_between_sessions());
        let told = drift.clone().of_unknown_days(false);
        assert!(told.refits.is_empty() && told.sentences.len() == 1);
        assert!(!drift.clone().of_unknown_days(true).refits.is_empty());
        let dated = Drift {
            sessions: sessions
                .map(|own| Session {
                    started: Some(1.7e9),
                    ..own
                })
                .to_vec(),
            ..drift
        };
        assert!(dated.is_between_sessions());
    }

    #[test]
    fn what_moved_is_found_and_what_only_scatters_is_not() {
        let of = |zero: f64, slope: f64| {
            let sessions = [
                session(&recording(1.0, 2.0, 0.1)),
                session(&recording(zero, slope, 0.1)),
            ];
            changes(&sessions, &["S1".to_owned()], &[Axis::Fz], &[10.0]).remove(0)
        };
        let moved = of(2.0, 2.2);
        assert!(
            (moved.zero_share - 0.05).abs() < 2e-3 && moved.zero_is_sure,
            "{moved:?}"
        );
        assert!((moved.sensitivity_share - 0.1).abs() < 2e-3 && moved.sensitivity_is_sure);
        let same = of(1.001, 2.0);
        assert!(!same.zero_is_sure && !same.sensitivity_is_sure, "{same:?}");
    }
}
