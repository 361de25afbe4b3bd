//! Columns that describe the causes, computed sample by sample from the start of a recording.
//!
//! A row is `[1, gauges, model, causes, time, loads]`. The rows contain raw columns; their sums are standardised later.

use std::ops::Range;

use faer::Mat;

use crate::scoring::budget::{
    cause::Cause,
    inputs::Inputs,
    run::{ColumnStream, Model, Run, Unit},
    time_scale::TimeScale,
};

/// Radii of the play operators, in standard deviations of the gauge that the loads predict.
const RADII: [f64; 4] = [0.1, 0.3, 0.8, 2.0];
/// Time constants of creep, in units of the time in which a sine of the load's speed passes one radian.
const TIME_CONSTANTS: [f64; 4] = [1.5, 6.0, 24.0, 96.0];
/// Further time constants of creep if the load rests most of the time.
const TIME_CONSTANTS_OF_RESTS: [f64; 2] = [0.1, 0.4];
/// Share of the variance by which a sine changes within one radian.
const CHANGE_OF_RADIAN: f64 = 0.45;
/// Intervals of the lag columns, in units of the change time.
const LAGS: [f64; 2] = [0.1, 0.4];
/// Maximum number of products of auxiliary channels with gauges. If there were more, the channels alone are used.
const MOST_PRODUCTS: usize = 64;

/// Which columns the rows have, and how they are computed.
#[derive(Debug)]
pub struct Columns {
    pub inputs: Inputs,
    n_model: usize,
    /// Columns of each cause that is tested.
    pub of_causes: Vec<(Cause, Range<usize>)>,
    /// Shares of the states of creep that are left after one sample, one for each time constant.
    decays: Vec<f64>,
    /// Intervals of lag columns (samples).
    lags: Vec<usize>,
    scale: TimeScale,
    /// Column of the time.
    pub time: usize,
    /// Column of the load on the first axis.
    pub loads: usize,
    pub width: usize,
}

impl Columns {
    pub fn new(inputs: Inputs, scale: TimeScale, median_samples: f64, n_model: usize) -> Self {
        let change = scale.change_samples;
        let lags = LAGS
            .iter()
            .enumerate()
            .map(|(at, share)| ((share * change).round_ties_even() as usize).max(at + 1));
        let of_rests = TIME_CONSTANTS_OF_RESTS.iter().filter(|_| scale.rests);
        let mut columns = Self {
            n_model,
            of_causes: Vec::new(),
            decays: (of_rests.chain(&TIME_CONSTANTS).map(|own| own * change / CHANGE_OF_RADIAN))
                .filter(|samples| (1.0..=median_samples / 2.0).contains(samples))
                .map(|samples| (-1.0 / samples).exp())
                .collect(),
            lags: lags.collect(),
            scale,
            time: 0,
            loads: 0,
            width: 0,
            inputs,
        };
        columns.lags.dedup();
        let mut at = columns.model().end;
        for cause in Cause::WITH_COLUMNS {
            let n = columns.n_columns(cause);
            if n > 0 {
                columns.of_causes.push((cause, at..at + n));
            }
            at += n;
        }
        (columns.time, columns.loads) = (at, at + 1);
        columns.width = at + 1 + columns.inputs.load_means.len();
        columns
    }

    pub fn n_axes(&self) -> usize {
        self.inputs.load_means.len()
    }

    pub fn n_gauges(&self) -> usize {
        self.inputs.gauges.len()
    }

    /// Returns the columns of the compensation.
    pub fn model(&self) -> Range<usize> {
        let first = 1 + self.n_gauges();
        first..first + self.n_model
    }

    /// Returns true if the noise is known, so that lag columns do not need the present sample.
    fn looks_around(&self) -> bool {
        self.scale.separates_noise()
    }

    fn has_products(&self) -> bool {
        self.inputs.auxiliary.len() * self.n_gauges() <= MOST_PRODUCTS
    }

    fn n_columns(&self, cause: Cause) -> usize {
        let (n_loads, n_curved) = (self.inputs.loads.ncols(), self.inputs.n_curved());
        match cause {
            Cause::Curvature => n_curved * (n_curved + 1) / 2 + n_curved,
            Cause::Temperature if self.has_products() => {
                self.inputs.auxiliary.len() * (1 + self.n_gauges())
            }
            Cause::Temperature => self.inputs.auxiliary.len(),
            _ if self.scale.is_table => 0,
            Cause::Hysteresis => RADII.len() * self.inputs.expected.ncols(),
            Cause::Creep | Cause::Lag if !self.scale.has_times => 0,
            Cause::Creep => self.decays.len() * n_loads,
            Cause::Lag if self.looks_around() => (self.lags.len() + 1) * n_loads,
            Cause::Lag => 2 * self.lags.len() * n_loads,
            Cause::Zeros | Cause::Drift | Cause::Sensitivity => 0,
        }
    }
}

/// Computes the rows of one recording, one after another.
pub struct Rows<'a> {
    columns: &'a Columns,
    run: &'a Run<'a>,
    model: Option<ColumnStream<'a>>,
    /// Conventional loads of the whole recording, `n_samples × n_loads` row-major.
    conventional: Vec<f64>,
    /// Positions of the play operators, for each radius and expected gauge.
    plays: Vec<f64>,
    /// States of creep, for each time constant and load.
    creeps: Vec<f64>,
    expected: Vec<f64>,
    curved: Vec<f64>,
}

impl<'a> Rows<'a> {
    pub fn new<'m: 'a>(
        columns: &'a Columns,
        runs: &'a [Run<'a>],
        at: usize,
        model: Option<Model<'m>>,
    ) -> Self {
        let (run, inputs) = (&runs[at], &columns.inputs);
        let n_loads = inputs.loads.ncols();
        let mut gauges = vec![0.0; inputs.gauges.len()];
        let mut conventional = vec![0.0; run.n_samples * n_loads];
        let samples = run.gauges.chunks_exact(run.gauges.len() / run.n_samples);
        for (sample, loads) in samples.zip(conventional.chunks_exact_mut(n_loads)) {
            inputs.gauges.standardise(sample, &mut gauges);
            apply(&inputs.loads, &gauges, loads);
        }
        Self {
            columns,
            run,
            model: model.map(|own| -> ColumnStream<'a> { (own.stream)(at) }),
            conventional,
            plays: Vec::new(),
            creeps: Vec::new(),
            expected: vec![0.0; inputs.expected.ncols()],
            curved: vec![0.0; inputs.n_curved()],
        }
    }

    fn load(&self, sample: usize, shift: isize) -> &[f64] {
        let n = self.columns.inputs.loads.ncols();
        let at = sample.saturating_add_signed(shift).min(self.run.n_samples - 1);
        &self.conventional[at * n..][..n]
    }

    /// Writes the row of the next sample of the unit. The samples of a recording must be asked for in order.
    pub fn next(&mut self, unit: &Unit, sample: usize, row: &mut [f64]) {
        let (columns, inputs) = (self.columns, &self.columns.inputs);
        let width = self.run.gauges.len() / self.run.n_samples;
        row[0] = 1.0;
        let gauges = &self.run.gauges[sample * width..][..width];
        inputs.gauges.standardise(gauges, &mut row[1..=columns.n_gauges()]);
        if let Some(model) = &mut self.model {
            model(sample, &mut row[columns.model()]);
        }
        let n_axes = columns.n_axes();
        let loads = self.run.loads[sample * n_axes..][..n_axes].iter().zip(&inputs.load_means);
        row[columns.loads..]
            .iter_mut()
            .zip(loads)
            .for_each(|(out, (load, mean))| *out = load - mean);
        for (cause, own) in &columns.of_causes {
            let (before, rest) = row.split_at_mut(own.start);
            let out = &mut rest[..own.len()];
            match cause {
                Cause::Hysteresis => self.play(sample, out),
                Cause::Creep => self.creep(sample, out),
                Cause::Lag => self.lag(sample, out),
                _ => self.present(*cause, sample, &before[1..=columns.n_gauges()], out),
            }
        }
        row[columns.time] = unit.time(sample);
    }

    /// Writes the columns of a cause that depend on the present sample only.
    fn present(&mut self, cause: Cause, sample: usize, gauges: &[f64], row: &mut [f64]) {
        let inputs = &self.columns.inputs;
        if cause == Cause::Temperature {
            let n = inputs.auxiliary.len();
            let width = self.run.auxiliary.len() / self.run.n_samples;
            let channels = &self.run.auxiliary[sample * width..][..width];
            let (alone, products) = row.split_at_mut(n);
            inputs.auxiliary.standardise(channels, alone);
            let pairs =
                alone.iter().flat_map(|channel| gauges.iter().map(move |own| channel * own));
            products.iter_mut().zip(pairs).for_each(|(out, product)| *out = product);
            return;
        }
        let curved = match &inputs.components {
            Some(components) => {
                apply(components, gauges, &mut self.curved);
                &self.curved[..]
            }
            None => gauges,
        };
        let mut out = row.iter_mut();
        for (at, first) in curved.iter().enumerate() {
            for (second, out) in curved[at..].iter().zip(&mut out) {
                *out = first * second;
            }
        }
        for (value, out) in curved.iter().zip(out) {
            *out = value.powi(3);
        }
    }

    fn play(&mut self, sample: usize, row: &mut [f64]) {
        let n = self.columns.inputs.loads.ncols();
        let loads = &self.conventional[sample * n..][..n];
        apply(&self.columns.inputs.expected, loads, &mut self.expected);
        if self.plays.is_empty() {
            self.plays = self.expected.repeat(RADII.len());
        }
        let plays = self.plays.chunks_exact_mut(self.expected.len());
        for (radius, (plays, row)) in
            RADII.iter().zip(plays.zip(row.chunks_exact_mut(self.expected.len())))
        {
            for ((play, out), input) in plays.iter_mut().zip(row).zip(&self.expected) {
                *play = play.max(input - radius).min(input + radius);
                *out = input - *play;
            }
        }
    }

    fn creep(&mut self, sample: usize, row: &mut [f64]) {
        let n = self.columns.inputs.loads.ncols();
        let loads = &self.conventional[sample * n..][..n];
        if self.creeps.is_empty() {
            self.creeps = loads.repeat(self.columns.decays.len());
        }
        let creeps = self.creeps.chunks_exact_mut(n).zip(row.chunks_exact_mut(n));
        for (kept, (creeps, row)) in self.columns.decays.iter().zip(creeps) {
            for ((creep, out), load) in creeps.iter_mut().zip(row).zip(loads) {
                *creep = kept * *creep + (1.0 - kept) * load;
                *out = *creep - load;
            }
        }
    }

    fn lag(&self, sample: usize, row: &mut [f64]) {
        let columns = self.columns;
        let mut row = row.chunks_exact_mut(columns.inputs.loads.ncols());
        let mut write = |values: &dyn Fn(usize) -> f64| {
            let out = row.next().into_iter().flatten();
            out.enumerate().for_each(|(at, out)| *out = values(at));
        };
        let at = |shift: isize| self.load(sample, shift);
        for lag in columns.lags.iter().map(|lag| lag.cast_signed()) {
            let (later, earlier) = (at(lag), at(-lag));
            if columns.looks_around() {
                write(&|axis| later[axis] - earlier[axis]);
            } else {
                let now = at(0);
                write(&|axis| earlier[axis] - now[axis]);
                write(&|axis| later[axis] - now[axis]);
            }
        }
        if let (true, Some(lag)) = (columns.looks_around(), columns.lags.last()) {
            let lag = lag.cast_signed();
            let [near, far] = [1, 2].map(|times| [at(times * lag), at(-times * lag)]);
            write(&|axis| far[0][axis] + far[1][axis] - near[0][axis] - near[1][axis]);
        }
    }
}

/// Writes `coefficientsᵀ · values`.
pub fn apply(coefficients: &Mat<f64>, values: &[f64], out: &mut [f64]) {
    for (column, out) in coefficients.col_iter().zip(out) {
        *out = column.iter().zip(values).map(|(own, value)| own * value).sum();
    }
}
