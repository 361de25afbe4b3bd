//! Rows of the metrology table for the noise of the load, and for the effect of the temperature on zero and span.

use crate::{
    min_max::MinMax,
    questions::metrology::{
        figures::{Figure, Found, Value},
        measured::AxisView,
        quantity::Quantity,
        reason::Reason,
    },
    recording::median::white_noise,
};

/// The effects are given for this change of the temperature (°C).
const PER: f64 = 10.0;
/// Smallest range of temperatures from which their effects are computed (°C).
const LEAST: f64 = 2.0;
/// Number of parts that are left out in turn to find the uncertainty of the effects.
const PARTS: usize = 10;
/// Offset, load, temperature, and their product.
const TERMS: usize = 4;

pub fn noise_figures(view: &AxisView<'_>, output: usize) -> [(Quantity, Figure); 2] {
    let dwells = view.runs.iter().flat_map(|run| {
        let holds = view.measured.holds[run.index].iter();
        holds.map(move |hold| (run, hold))
    });
    let longest = dwells.max_by_key(|(_, hold)| hold.samples.len());
    let settings = view.measured.settings;
    let (noise, span) = match longest {
        Some((run, hold)) => {
            let outputs = &run.outputs[output][hold.samples.clone()];
            // A value minus the mean of its neighbours has 1.5 times the variance of white noise.
            let off = outputs.windows(3).map(|near| near[1] - 0.5 * (near[0] + near[2]));
            let off: Vec<f64> = off.map(|off| off / 1.5_f64.sqrt()).collect();
            let mean_square = off.iter().map(|off| off * off).sum::<f64>() / off.len() as f64;
            let place = Some(run.place(hold.samples.clone()));
            let span = Value::at(off.into_iter().collect::<MinMax>().span(), place.clone());
            (Value::at(mean_square.sqrt(), place), Ok(span))
        }
        None => {
            let all = view.runs.iter().map(|run| white_noise(&run.outputs[output]));
            let (axis, secs) = (view.axis, settings.hold_secs);
            (
                Value::everywhere(all.fold(0.0, f64::max)),
                Err(Reason::NoHold { axis, share: 0.0, secs }),
            )
        }
    };
    [(Quantity::Noise, Ok(noise)), (Quantity::NoisePeakToPeak, span)]
}

/// Sums for the least-squares fit of errors: products of the terms, and of the terms and the error.
#[derive(Clone, Copy, Default)]
struct Sums([[f64; TERMS + 1]; TERMS]);

impl Sums {
    fn add(&mut self, terms: [f64; TERMS], error: f64) {
        for (row, term) in self.0.iter_mut().zip(terms) {
            row.iter_mut().zip(terms).for_each(|(sum, other)| *sum += term * other);
            row[TERMS] += term * error;
        }
    }

    fn plus(mut self, other: &Self) -> Self {
        let all = self.0.as_flattened_mut().iter_mut().zip(other.0.as_flattened());
        all.for_each(|(sum, other)| *sum += other);
        self
    }

    /// Returns the coefficients by elimination; `None` if the terms do not determine them.
    fn solved(self) -> Option<[f64; TERMS]> {
        let mut rows = self.0;
        for at in 0..TERMS {
            let pivot = rows[at];
            // The terms are centred and scaled, so a small pivot means that a term follows from the others.
            if pivot[at] <= 1e-6 * self.0[at][at] {
                return None;
            }
            for (other, row) in rows.iter_mut().enumerate() {
                let factor = if other == at { 0.0 } else { row[at] / pivot[at] };
                row.iter_mut().zip(pivot).for_each(|(value, pivot)| *value -= factor * pivot);
            }
        }
        Some(std::array::from_fn(|at| rows[at][TERMS] / rows[at][at]))
    }
}

pub fn temperature_figures(view: &AxisView<'_>, output: usize) -> [(Quantity, Figure); 2] {
    let effects = temperature_effects(view, output);
    [(Quantity::TemperatureZero, 0), (Quantity::TemperatureSpan, 1)].map(|(quantity, at)| {
        let figure = effects.as_ref().map_err(Clone::clone).map(|(values, errors)| Value {
            uncertainty: Some(errors[at]),
            ..Value::everywhere(values[at])
        });
        (quantity, figure)
    })
}

/// Returns the change of the error at zero and at full load by a change of the temperature, and both standard uncertainties.
fn temperature_effects(view: &AxisView<'_>, output: usize) -> Found<([f64; 2], [f64; 2])> {
    let (axis, full_scale) = (view.axis, view.full_scale);
    let none = Reason::NoTemperature { axis, least: LEAST };
    let runs: Vec<(_, Vec<f64>)> = (view.runs.iter())
        .filter_map(|run| {
            let table = run.columns.run.auxiliary?;
            let at = table.units().iter().position(|unit| unit == "°C")?;
            Some((run, (0..run.loads.len()).map(|k| table.at(k)[at]).collect()))
        })
        .collect();
    let range: MinMax = runs.iter().flat_map(|(_, temperatures)| temperatures).copied().collect();
    if range.span().is_nan() || range.span() < LEAST {
        return Err(none);
    }
    if full_scale <= 0.0 {
        return Err(Reason::NoFullScale { axis });
    }
    let (middle, half) = (0.5 * (range.min + range.max), 0.5 * range.span());
    let n: usize = runs.iter().map(|(_, temperatures)| temperatures.len()).sum();
    let mut parts = [Sums::default(); PARTS];
    let mut done = 0;
    for (run, temperatures) in &runs {
        let errors = run.errors(output, 0..run.loads.len());
        for ((error, load), warm) in errors.zip(run.loads).zip(temperatures) {
            let (load, warm) = (load / full_scale, (warm - middle) / half);
            parts[done * PARTS / n].add([1.0, load, warm, load * warm], error);
            done += 1;
        }
    }
    let all = |left_out: Option<usize>| {
        let kept = parts.iter().enumerate().filter(|(part, _)| Some(*part) != left_out);
        let sums = kept.fold(Sums::default(), |sums, (_, part)| sums.plus(part));
        let [.., zero, span] = sums.solved()?;
        Some([zero, span].map(|effect| effect * PER / half))
    };
    let values = all(None).ok_or(none)?;
    // Jackknife: the effects without each part in turn.
    let without: Vec<[f64; 2]> = (0..PARTS).filter_map(|part| all(Some(part))).collect();
    let errors = [0, 1].map(|at| {
        let mean = without.iter().map(|own| own[at]).sum::<f64>() / without.len() as f64;
        let squares = without.iter().map(|own| (own[at] - mean).powi(2)).sum::<f64>();
        (squares * (PARTS - 1) as f64 / PARTS as f64).sqrt()
    });
    Ok((values, errors))
}
