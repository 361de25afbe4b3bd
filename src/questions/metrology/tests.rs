//! Known values for every row, and the reason for every missing figure.

use crate::{
    calibration::AppliedLoads,
    finding::Id,
    progress::{Cancelled, Progress},
    questions::metrology::*,
    random::Random,
    recording::{
        Axis, Recording, Source,
        simulated::{self, LAG_SECS, Late, PLAY_NEWTONS},
    },
    scoring::{
        holds::NoTimeConstant,
        loops::{LoadExtent, extents_of_set},
    },
};

/// One axis at 20 Hz: its load, and two outputs.
struct One {
    times: Vec<f64>,
    load: Vec<f64>,
    conventional: Vec<f64>,
    compensated: Vec<f64>,
}

impl One {
    /// Makes the compensated output equal to the load.
    fn new(load: Vec<f64>, conventional: Vec<f64>) -> Self {
        Self {
            times: (0..load.len()).map(|k| k as f64 / 20.0).collect(),
            conventional,
            compensated: load.clone(),
            load,
        }
    }

    fn run(&self) -> Run<'_> {
        Run {
            name: "one",
            times: &self.times,
            gauges: &[],
            reference_axes: &[Axis::Fz],
            reference: &self.load,
            conventional: &self.conventional,
            compensated: &self.compensated,
            auxiliary: None,
            is_static: false,
            is_load_case: false,
            is_table: false,
        }
    }

    fn table(&self, full_scale: f64) -> Metrology {
        table_of(&[self.run()], &[Axis::Fz], &[full_scale])
    }
}

pub fn table_of(runs: &[Run<'_>], axes: &[Axis], full_scale: &[f64]) -> Metrology {
    table(runs, axes, full_scale, &MetrologySettings::default()).unwrap()
}

/// Returns the table whose rules come from these runs alone.
fn table(
    runs: &[Run<'_>],
    axes: &[Axis],
    full_scale: &[f64],
    settings: &MetrologySettings,
) -> std::result::Result<Metrology, MetrologyError> {
    let rules = Rules { axes, full_scale, settings, extents: &extents(runs, axes) };
    table_by(runs, &rules, lags_of(runs, rules.axes, &Progress::default()).unwrap())
}

fn extents(runs: &[Run<'_>], axes: &[Axis]) -> Vec<LoadExtent> {
    let of_axis = |axis: &Axis| {
        let of_run = |all: LoadExtent, run: &Run<'_>| {
            let axes = run.reference_axes;
            let Some(at) = axes.iter().position(|known| known == axis) else {
                return all;
            };
            let loads = run.reference.iter().skip(at).step_by(axes.len());
            all.with(LoadExtent::of([&loads.copied().collect::<Vec<_>>()[..]]))
        };
        runs.iter().fold(LoadExtent::default(), of_run)
    };
    axes.iter().map(of_axis).collect()
}

/// A table without times goes up and down three times. Its output is 0.2 N below the load on the way up and 0.2 N above it on
/// the way down, or equal to the load.
#[test]
fn the_branches_of_a_table_without_times_show_the_hysteresis_of_a_computed_load() {
    let cycle = (0..10).chain((1..=10).rev());
    let load: Vec<f64> = cycle.cycle().take(61).map(f64::from).collect();
    let way = |at: usize| match at % 20 {
        0 | 10 => 0.0,
        up if up < 10 => -0.2,
        _ => 0.2,
    };
    let output = load.iter().enumerate().map(|(at, load)| load + way(at)).collect();
    let one = One::new(load, output);
    let table = |of: &One| {
        let run = Run { is_static: true, ..of.run() };
        table_of(&[run], &[Axis::Fz], &[10.0])
    };
    let of_table = table(&one);
    let cell = of_table.cell(Quantity::Hysteresis, Axis::Fz).unwrap();
    let [late, even] =
        [&cell.conventional, &cell.compensated].map(|own| own.as_ref().unwrap().value);
    assert!((late - 0.4).abs() < 0.01 && even.abs() < 1e-9, "{late} {even}");
    let times = of_table.cell(Quantity::Creep, Axis::Fz).unwrap();
    assert!(matches!(times.conventional, Err(Reason::NoTimes { .. })));
}

/// A gauge reads 20 counts per newton. Weights of 4 and 10 N are put on and taken off in three cycles, for which c is 1, 3 and
/// 2. The gauge reads 80 + c at 4 N while the load rises, 80 + 2 c at 4 N while it falls, and c at zero after the cycle. The
/// computed load is a twentieth of the reading.
#[test]
fn a_table_of_weights_has_figures_of_readings_in_the_same_direction() {
    let cycle = |c: f64| [(4.0, 80.0 + c), (10.0, 200.0), (4.0, 80.0 + 2.0 * c), (0.0, c)];
    let rows: Vec<(f64, f64)> =
        std::iter::once((0.0, 0.0)).chain([1.0, 3.0, 2.0].into_iter().flat_map(cycle)).collect();
    let (load, counts): (Vec<f64>, Vec<f64>) = rows.into_iter().unzip();
    let one = One::new(load.clone(), counts.iter().map(|counts| counts / 20.0).collect());
    let run = Run { gauges: &counts, is_static: true, is_table: true, ..one.run() };
    // The steps between readings of a table are no noise.
    let extents = [LoadExtent { noise: 0.0, ..LoadExtent::of([&load[..]]) }];
    let settings = &MetrologySettings::default();
    let rules = Rules { axes: &[Axis::Fz], full_scale: &[10.0], settings, extents: &extents };
    let lags = lags_of(&[run], rules.axes, &Progress::default()).unwrap();
    let table = table_by(&[run], &rules, lags).unwrap();
    let found = |quantity| fz(&table, quantity).conventional.clone().unwrap();
    // In newtons: rising and falling readings at 4 N differ by c counts, which is most in the second cycle. At 4 N, those on
    // the way down span 2 to 6 counts, and those on the way up 1 to 3. The zero changes most in the second cycle, from 1 to 3.
    let closed = [
        (Quantity::Hysteresis, 3.0 / 20.0),
        (Quantity::MeanLoopHysteresis, 2.0 / 20.0),
        (Quantity::Repeatability, 4.0 / 20.0),
        (Quantity::ZeroReturn, 2.0 / 20.0),
    ];
    for (quantity, truth) in closed {
        let found = found(quantity);
        assert!((found.value - truth).abs() < 1e-9, "{quantity:?}: {found:?}");
        assert_eq!(found.place, None);
    }
    // Slope and standard error from NumPy's least squares.
    let sensitivity = found(Quantity::Sensitivity);
    assert!((sensitivity.value - 19.83870967741935).abs() < 1e-9, "{sensitivity:?}");
    assert!(
        (sensitivity.uncertainty.unwrap() - 0.13657106959074364).abs() < 1e-9,
        "{sensitivity:?}"
    );
    assert_eq!(
        (sensitivity.percent_fs, fz(&table, Quantity::Sensitivity).unit),
        (None, "reading/N")
    );
}

impl Metrology {
    fn cell(&self, quantity: Quantity, axis: Axis) -> Option<&Cell> {
        let row = self.rows.iter().find(|row| row.quantity == quantity)?;
        row.cells.iter().find(|cell| cell.axis == axis)
    }
}

fn fz(table: &Metrology, quantity: Quantity) -> &Cell {
    table.cell(quantity, Axis::Fz).unwrap()
}

#[track_caller]
fn value(figure: &Figure) -> f64 {
    figure.as_ref().unwrap().value
}

fn ids(table: &Metrology) -> Vec<Id> {
    table.findings.iter().map(|found| found.id).collect()
}

fn reason(table: &Metrology, quantity: Quantity) -> Reason {
    fz(table, quantity).conventional.clone().unwrap_err()
}

#[track_caller]
fn assert_near(actual: f64, expected: f64, share: f64) {
    let off = (actual / expected - 1.0).abs();
    assert!(off < share, "{actual} is not {expected}");
}

/// Returns straight lines between the corners, each in this number of steps.
fn path(corners: &[f64], steps: usize) -> Vec<f64> {
    let legs = corners.windows(2);
    let moving = legs
        .flat_map(|leg| (0..steps).map(|k| leg[0] + (leg[1] - leg[0]) * k as f64 / steps as f64));
    moving.chain(corners.last().copied()).collect()
}

/// Returns the output of a play operator that starts at its lower end.
fn play(load: &[f64], radius: f64) -> Vec<f64> {
    let mut state = load[0] + radius;
    let follow = |&load: &f64| {
        state = state.clamp(load - radius, load + radius);
        state
    };
    load.iter().map(follow).collect()
}

/// A play operator of radius 0.3 has a width of 0.6: 6 % of 10. The compensated load has no hysteresis and no width.
#[test]
fn hysteresis_of_a_play_operator_is_twice_its_radius() {
    let load = path(&[-10.0, 10.0, -10.0, 10.0, -10.0, 10.0, -10.0], 1000);
    let lagging = play(&load, 0.3);
    let table = One::new(load, lagging).table(10.0);
    for quantity in [Quantity::Hysteresis, Quantity::MeanLoopHysteresis] {
        let cell = fz(&table, quantity);
        assert_near(value(&cell.conventional), 0.6, 0.01);
        assert_near(cell.conventional.as_ref().unwrap().percent_fs.unwrap(), 6.0, 0.01);
        assert!(value(&cell.compensated) < 1e-12);
    }
    // The parallelogram's area is 4 r (A − r).
    let area = &fz(&table, Quantity::LoopArea).conventional;
    assert_near(value(area), 4.0 * 0.3 * 9.7, 0.01);
    assert_near(area.as_ref().unwrap().percent_fs.unwrap(), 4.0 * 0.3 * 9.7, 0.01);
    assert!(value(&fz(&table, Quantity::Repeatability).conventional) < 1e-9);
    let place = fz(&table, Quantity::Hysteresis).conventional.clone().unwrap().place.unwrap();
    assert_eq!((place.name.as_str(), place.samples), ("one", 0..2001));
    assert_eq!((place.from_secs, place.to_secs), (0.0, 100.0));
    for (quantity, n_cycles) in
        [(Quantity::Hysteresis, 1), (Quantity::MeanLoopHysteresis, 3), (Quantity::Repeatability, 3)]
    {
        let figure = fz(&table, quantity).conventional.clone().unwrap();
        let basis = figure.basis.unwrap();
        assert_eq!((basis.n_cycles, basis.range_share), (n_cycles, 1.0));
    }
}

/// The rising branch is `c x (1 − x)` over 0..1, which is c/4 above the line between its ends. Its best-fit line, at c/6, has
/// its largest deviation c/6 at the ends. The falling branch is `2 c x (1 − x)`, so the combined error is c/2.
#[test]
fn nonlinearity_of_a_parabola_is_known() {
    let load = path(&[0.0, 1.0, 0.0], 5000);
    let bent = |(k, x): (usize, &f64)| {
        let c = if k <= 5000 { 0.04 } else { 0.08 };
        3.0 + 1.1 * x + c * x * (1.0 - x)
    };
    let output = load.iter().enumerate().map(bent).collect();
    let table = One::new(load, output).table(1.0);
    let of = |quantity| value(&fz(&table, quantity).conventional);
    assert_near(of(Quantity::TerminalNonlinearity), 0.01, 0.01);
    assert_near(of(Quantity::BestFitNonlinearity), 0.04 / 6.0, 0.01);
    assert_near(of(Quantity::CombinedError), 0.02, 0.01);
    assert_near(of(Quantity::Hysteresis), 0.01, 0.01);
    assert_eq!(reason(&table, Quantity::Repeatability), Reason::TooFewCycles { axis: Axis::Fz });
}

/// Each of three cycles is 0.05 above the previous cycle, so the first and the last differ by 0.1.
#[test]
fn repeatability_is_the_spread_of_cycles_at_equal_load() {
    let load = path(&[0.0, 8.0, 0.0, 8.0, 0.0, 8.0, 0.0], 400);
    let risen = |(k, x): (usize, &f64)| x + 0.05 * (k / 800) as f64;
    let output = load.iter().enumerate().map(risen).collect();
    let table = One::new(load, output).table(8.0);
    let cell = fz(&table, Quantity::Repeatability);
    assert_near(value(&cell.conventional), 0.1, 0.01);
    assert!(value(&cell.compensated) < 1e-9);
}

/// Returns a load of 10 s at zero, a rise, 120 s at 10, a fall, and 80 s at zero.
fn held() -> Vec<f64> {
    let still = |value: f64, secs: usize| vec![value; 20 * secs];
    [
        still(0.0, 10),
        path(&[0.0, 10.0], 40),
        still(10.0, 120),
        path(&[10.0, 0.0], 40),
        still(0.0, 80),
    ]
    .concat()
}

/// Returns the load plus 3 % of its first-order low-pass: creep with one time constant.
fn crept(load: &[f64], tau_secs: f64) -> Vec<f64> {
    let share = -(-1.0 / (20.0 * tau_secs)).exp_m1();
    let mut slow = 0.0;
    let creep = |&load: &f64| {
        slow += share * (load - slow);
        load + 0.03 * slow
    };
    load.iter().map(creep).collect()
}

/// A ramp of duration T to x takes the creep element to `x (1 − τ/T (1 − exp(−T/τ)))`. In the dwell of 6 τ, the element
/// approaches x.
#[test]
fn creep_of_a_first_order_element_is_known() {
    let load = held();
    let output = crept(&load, 20.0);
    let table = One::new(load, output).table(10.0);
    let of = |quantity| fz(&table, quantity);
    assert_near(value(&of(Quantity::CreepTime).conventional), 20.0, 0.01);
    assert_eq!(of(Quantity::CreepTime).unit, "s");
    let after_the_ramp = 0.3 * (1.0 - 20.0 / 2.0 * (1.0 - (-0.1_f64).exp()));
    let creep = (0.3 - after_the_ramp) * (1.0 - (-6.0_f64).exp());
    assert_near(value(&of(Quantity::Creep).conventional), creep, 0.01);
    assert!(value(&of(Quantity::CreepRecovery).conventional) < -0.27);
    assert!(value(&of(Quantity::Creep).compensated).abs() < 1e-12);
    let still = of(Quantity::CreepTime).compensated.clone();
    assert!(matches!(still, Err(Reason::NoTimeConstant(NoTimeConstant::BelowNoise { .. }))));
}

#[test]
fn rests_are_found_with_their_levels() {
    let load = held();
    let one = One::new(load.clone(), load);
    let axes = [Axis::Fx, Axis::Fz];
    let both: Vec<f64> = one.load.iter().flat_map(|x| [0.0, *x]).collect();
    let run = Run { conventional: &both, compensated: &both, ..one.run() };
    let rules = Rules {
        axes: &axes,
        full_scale: &[1.0, 10.0],
        settings: &MetrologySettings::default(),
        extents: &extents(&[run], &axes),
    };
    let [fx, found] = [0, 1].map(|axis| dwells(&[run], &rules, axis).unwrap());
    let seen: Vec<_> = fx.iter().map(|rest| (rest.at_zero, rest.level)).collect();
    assert_eq!(seen, [(true, None), (false, None), (true, None)]);
    assert_near(found[1].level.unwrap(), 10.0, 1e-3);
    assert_near(found[1].place.to_secs - found[1].place.from_secs, 120.0, 1e-3);
}

/// The output's zero rises by 0.2 in the middle of the dwell.
#[test]
fn zero_return_is_the_shift_of_the_zero() {
    let load = held();
    let moved = |(k, x): (usize, &f64)| if k < 1500 { 7.0 + x } else { 7.2 + x };
    let output = load.iter().enumerate().map(moved).collect();
    let table = One::new(load, output).table(10.0);
    let cell = fz(&table, Quantity::ZeroReturn);
    assert_near(value(&cell.conventional), 0.2, 1e-9);
    assert_near(cell.conventional.as_ref().unwrap().percent_fs.unwrap(), 2.0, 1e-9);
}

/// The errors are 0.01, 0.02 … 1: the largest is 1, 95 % of them are at most 0.95, and `Σ k² = n (n + 1) (2n + 1) / 6`.
#[test]
fn error_figures_of_known_errors() {
    let load: Vec<f64> = (0..100).map(|k| f64::from(k % 10)).collect();
    let off =
        |(k, x): (usize, &f64)| x + (k + 1) as f64 / 100.0 * if k % 2 == 0 { 1.0 } else { -1.0 };
    let output = load.iter().enumerate().map(off).collect();
    let table = One::new(load, output).table(5.0);
    let of = |quantity| value(&fz(&table, quantity).conventional);
    assert_near(of(Quantity::LargestError), 1.0, 1e-12);
    assert_near(of(Quantity::Error95), 0.95, 1e-12);
    assert_near(of(Quantity::Rmse), (101.0 * 201.0 / 6.0_f64).sqrt() / 100.0, 1e-12);
    let largest = fz(&table, Quantity::LargestError).conventional.clone().unwrap();
    assert_near(largest.percent_fs.unwrap(), 20.0, 1e-12);
    assert_eq!(largest.place.unwrap().samples, 99..100);
}

/// Fx is loaded alone, up to 10 N, and adds 0.02 Fx to Fy. Fy is never loaded alone.
#[test]
fn crosstalk_is_the_reading_of_the_other_axes_while_one_axis_is_loaded() {
    let alone = path(&[0.0, 10.0, 0.0], 100);
    let n = alone.len();
    let mut reference: Vec<f64> = alone.iter().flat_map(|x| [*x, 0.0]).collect();
    reference.extend(alone.iter().flat_map(|x| [*x, 0.5 * x]));
    let conventional: Vec<f64> =
        reference.chunks(2).flat_map(|x| [x[0], x[1] + 0.02 * x[0]]).collect();
    let times: Vec<f64> = (0..2 * n).map(|k| k as f64).collect();
    let axes = [Axis::Fx, Axis::Fy];
    let run = Run {
        name: "two",
        times: &times,
        gauges: &[],
        reference_axes: &axes,
        reference: &reference,
        conventional: &conventional,
        compensated: &reference,
        auxiliary: None,
        is_static: false,
        is_load_case: false,
        is_table: false,
    };
    let table = table_of(&[run], &axes, &[10.0, 5.0]);
    let cell = |from, axis| table.cell(Quantity::Crosstalk(from), axis).unwrap();
    let onto_fy = cell(Axis::Fx, Axis::Fy);
    assert_near(value(&onto_fy.conventional), 0.2, 1e-9);
    assert_near(onto_fy.conventional.as_ref().unwrap().percent_fs.unwrap(), 4.0, 1e-9);
    assert_eq!(value(&onto_fy.compensated), 0.0);
    let loaded = Reason::LoadedAxis { axis: Axis::Fx };
    assert_eq!(cell(Axis::Fx, Axis::Fx).conventional, Err(loaded));
    let sentence = cell(Axis::Fy, Axis::Fx).conventional.clone().unwrap_err().to_string();
    assert!(sentence.starts_with("no recording loads Fy alone"), "{sentence}");
}

#[test]
fn missing_figures_have_a_reason() {
    use Quantity::*;
    let axis = Axis::Fz;
    let of = |load: Vec<f64>| One::new(load.clone(), load).table(10.0);
    let constant = of(vec![3.0; 300]);
    for quantity in [Hysteresis, LoopArea, TerminalNonlinearity, CombinedError, Repeatability] {
        assert!(matches!(reason(&constant, quantity), Reason::ConstantLoad { .. }), "{quantity:?}");
    }
    assert!(matches!(reason(&constant, Creep), Reason::NoHold { .. }));
    let rising = of(path(&[0.0, 10.0], 100));
    assert_eq!(reason(&rising, Hysteresis), Reason::OneBranch { axis, rises: true });
    assert!(value(&fz(&rising, TerminalNonlinearity).conventional) < 1e-12);
    assert!(matches!(reason(&rising, ZeroReturn), Reason::NoZero { .. }));
    assert_eq!(reason(&rising, Crosstalk(axis)), Reason::OnlyAxis { axis });
    let falling = of(path(&[10.0, 0.0], 100));
    assert_eq!(reason(&falling, TerminalNonlinearity), Reason::NoRisingBranch { axis });
    let short = of(vec![0.0, 10.0, 0.0]);
    assert!(matches!(reason(&short, BestFitNonlinearity), Reason::TooFewLoads { found: 2, .. }));
    let unloaded = of([held(), held()].concat().iter().map(|x| 0.04 * x).collect());
    assert!(matches!(reason(&unloaded, ZeroReturn), Reason::NoReturn { .. }));
    assert!(matches!(reason(&unloaded, CreepRecovery), Reason::NoRecovery { .. }));
}

#[test]
fn without_a_reference_every_figure_has_this_reason() {
    let load = path(&[0.0, 10.0, 0.0], 100);
    let one = One::new(load.clone(), load);
    let bare = Run { reference_axes: &[], reference: &[], ..one.run() };
    let empty = table_of(&[], &[Axis::Fz], &[1.0]);
    for table in [table_of(&[bare], &[Axis::Fz], &[10.0]), empty] {
        for row in &table.rows {
            let axis = Axis::Fz;
            assert_eq!(row.cells[0].conventional, Err(Reason::NoReference { axis }));
        }
    }
    let beside = table_of(&[bare, one.run()], &[Axis::Fz], &[10.0]);
    assert_eq!(ids(&beside), [Id::WithoutReference]);
    assert!(beside.findings[0].seen.starts_with("1 of 2 recordings"));
    let hysteresis = fz(&beside, Quantity::Hysteresis).conventional.clone().unwrap();
    assert_eq!(hysteresis.place.unwrap().recording, 1);
}

#[test]
fn a_number_that_is_not_finite_is_named_and_never_a_figure() {
    for bad in [f64::NAN, f64::INFINITY] {
        let load = path(&[0.0, 10.0, 0.0], 100);
        let mut one = One::new(load.clone(), load);
        one.compensated[7] = bad;
        let table = one.table(10.0);
        for row in &table.rows {
            let reason = row.cells[0].compensated.clone().unwrap_err();
            assert!(matches!(reason, Reason::NotFinite { sample: 7, .. }), "{reason}");
        }
    }
    let load = path(&[0.0, 1e308, -1e308, 1e308], 100);
    let table = One::new(load.clone(), load).table(1e-3);
    assert_eq!(reason(&table, Quantity::Rmse), Reason::Overflow { axis: Axis::Fz });
}

#[test]
fn a_written_figure_is_a_number_or_null_with_a_reason() {
    let load = held();
    let json = serde_json::to_value(One::new(load.clone(), load).table(10.0)).unwrap();
    let rows = json["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 22);
    for row in rows {
        assert!(
            row["id"].is_string() && row["definition"].is_string() && row["source"].is_string()
        );
        for output in ["conventional", "compensated"] {
            let figure = &row["cells"][0][output];
            assert_ne!(figure["value"].is_null(), figure["reason"].is_null(), "{figure}");
        }
    }
    assert_eq!(json["axes"], serde_json::json!(["Fz"]));
}

#[test]
fn loads_beyond_full_scale_and_axes_without_one_are_noted() {
    let load = path(&[0.0, 10.0, 0.0], 100);
    let table = One::new(load.clone(), load.clone()).table(5.0);
    assert_eq!(ids(&table), [Id::BeyondFullScale]);
    assert!(table.findings[0].seen.contains("reaches 10.00 N, beyond its full scale of 5.000 N"));
    let table = One::new(load.clone(), load).table(0.0);
    assert_eq!(ids(&table), [Id::NoFullScale]);
    let rmse = fz(&table, Quantity::Rmse).conventional.clone().unwrap();
    assert_eq!(rmse.percent_fs, None);
    assert_eq!(reason(&table, Quantity::Creep), Reason::NoFullScale { axis: Axis::Fz });
}

/// The load rises, falls by 3, rises again, and falls. A small threshold counts the fall by 3 as a cycle.
#[test]
fn a_chosen_reversal_threshold_decides_how_small_a_cycle_is_counted() {
    let load = path(&[0.0, 10.0, 7.0, 10.0, 0.0], 100);
    let one = One::new(load.clone(), load);
    for reversal_threshold in [4.0, 1.0] {
        let settings = MetrologySettings {
            reversal_thresholds: vec![Some(reversal_threshold)],
            ..MetrologySettings::default()
        };
        let table = table(&[one.run()], &[Axis::Fz], &[10.0], &settings).unwrap();
        assert_eq!(table.reversal_thresholds, [reversal_threshold]);
        let hysteresis = fz(&table, Quantity::Hysteresis).conventional.clone();
        assert_eq!(hysteresis.unwrap().place.unwrap().samples, 0..401);
    }
}

/// Three cycles of a staircase from 0 to 10 N with steps of 2.5 N and moves between them. While the load moves, the output is off
/// by 0.5 N. At the ends of the steps, it is `a x (10 − x) / 10` above the load, and `w x (10 − x) / 25` more when the load falls.
fn staircase(bend: f64, width: f64, noise: f64) -> One {
    let mut random = Random::new(2, &[]);
    let levels = [2.5, 5.0, 7.5, 10.0, 7.5, 5.0, 2.5, 0.0];
    let (mut load, mut output) = (vec![0.0; 40], vec![0.0; 40]);
    for (step, level) in levels.iter().cycle().take(24).enumerate() {
        let before = load[load.len() - 1];
        for k in 1..=50 {
            let moved = (f64::from(k) / 10.0).min(1.0);
            let x = before + (level - before) * moved;
            let falls = if step % 8 >= 4 { width * x * (10.0 - x) / 25.0 } else { 0.0 };
            let late = if k < 15 { 0.5 } else { 0.0 };
            load.push(x);
            output.push(x + bend * x * (10.0 - x) / 10.0 + falls + late);
        }
    }
    output.iter_mut().for_each(|output| *output += noise * random.normal());
    One::new(load, output)
}

/// At the five loads, `a x (10 − x) / 10` is 0, 1.875 a, 2.5 a, 1.875 a and 0. So the terminal deviation is 2.5 a, the best-fit line
/// lies at the mean 1.25 a, from which the ends and the middle deviate by 1.25 a. The falling branch is 2.5 a + w above the line at 5 N.
#[test]
fn the_readings_at_the_ends_of_steps_count() {
    for noise in [0.0, 0.02] {
        let table = staircase(0.1, 0.3, noise).table(10.0);
        for (quantity, truth) in [
            (Quantity::TerminalNonlinearity, 0.25),
            (Quantity::BestFitNonlinearity, 0.125),
            (Quantity::CombinedError, 0.55),
        ] {
            let found = value(&fz(&table, quantity).conventional);
            assert!((found - truth).abs() < 0.01, "{quantity:?}, noise {noise}: {found}");
        }
    }
}

/// Noise of 0.2 % of full scale on a linear sensor gives no figure, and hardly changes the figures of a curved sensor.
#[test]
fn noise_is_no_nonlinearity_and_no_repeatability() {
    use Quantity::*;
    let axis = Axis::Fz;
    let ramps = |bend: f64| {
        let mut random = Random::new(4, &[]);
        let load = path(&[0.0, 10.0, 0.0, 10.0, 0.0, 10.0, 0.0], 600);
        let bent = |x: &f64| x + bend * x * (10.0 - x) / 10.0 + 0.02 * random.normal();
        let output = load.iter().map(bent).collect();
        One::new(load, output).table(10.0)
    };
    for table in [ramps(0.0), staircase(0.0, 0.0, 0.02).table(10.0)] {
        for quantity in [TerminalNonlinearity, BestFitNonlinearity, CombinedError, Repeatability] {
            let Reason::BelowNoise { percent: Some(percent), .. } = reason(&table, quantity) else {
                panic!("{quantity:?}: {:?}", fz(&table, quantity));
            };
            assert!(percent < 0.4, "{quantity:?} {percent}");
        }
    }
    let table = ramps(0.06);
    for (quantity, truth) in
        [(TerminalNonlinearity, 0.15), (BestFitNonlinearity, 0.1), (CombinedError, 0.15)]
    {
        let found = fz(&table, quantity).conventional.clone().unwrap();
        assert!((found.value - truth).abs() < 0.015, "{quantity:?}: {found:?}");
        assert!(found.uncertainty.unwrap() > 0.001, "{found:?}");
    }
    assert_eq!(reason(&table, Repeatability).word(true).split(' ').next(), Some("below"));
    assert!(
        matches!(reason(&table, Repeatability), Reason::BelowNoise { axis: of, .. } if of == axis)
    );
}

/// In a dwell of 2000 samples, the noise spans about 6.9 standard deviations.
#[test]
fn noise_and_the_effects_of_temperature_are_measured() {
    let mut random = Random::new(6, &[]);
    let load = [vec![5.0; 2000], path(&[5.0, 10.0, 0.0, 10.0, 0.0], 500)].concat();
    let warm: Vec<f64> = (0..load.len()).map(|k| 20.0 + 4.0 * (0.002 * k as f64).sin()).collect();
    let output: Vec<f64> = (load.iter().zip(&warm))
        .map(|(x, warm)| {
            x + 0.02 * (warm - 20.0) + 0.003 * (warm - 20.0) * x + 0.05 * random.normal()
        })
        .collect();
    let names = |text: &str| vec![text.to_owned()];
    let times: Vec<f64> = (0..load.len()).map(|k| k as f64 / 20.0).collect();
    let recording = Recording::new(
        "warm",
        Source::Simulated,
        times,
        names("S1"),
        output.clone(),
        vec![Axis::Fz],
        load.clone(),
    );
    let recording = recording.unwrap().with_auxiliary(names("T"), names("°C"), warm).unwrap();
    let loads = AppliedLoads { conventional: output, compensated: load, past: Vec::new() };
    let table = table_of(&[Run::new(&recording, &loads)], &[Axis::Fz], &[10.0]);
    let of = |quantity| fz(&table, quantity).conventional.clone().unwrap();
    assert_near(of(Quantity::Noise).value, 0.05, 0.05);
    assert_near(of(Quantity::NoisePeakToPeak).value, 0.05 * 6.9, 0.15);
    assert_near(of(Quantity::TemperatureZero).value, 0.2, 0.1);
    assert_near(of(Quantity::TemperatureSpan).value, 0.3, 0.1);
    for quantity in [Quantity::TemperatureZero, Quantity::TemperatureSpan] {
        let uncertainty = of(quantity).uncertainty.unwrap();
        assert!(uncertainty > 0.001 && uncertainty < 0.05, "{quantity:?} {uncertainty}");
    }
    let cold = One::new(vec![1.0; 9], vec![1.0; 9]).table(10.0);
    assert!(matches!(reason(&cold, Quantity::TemperatureZero), Reason::NoTemperature { .. }));
}

/// Reproducible pseudo-random numbers in ±1.
fn uniform(k: usize) -> f64 {
    let mixed = (k as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    (mixed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Two axes, loaded one after the other. The outputs are the loads plus noise (a share of full scale). Fy also reads Fx
/// times `slope`, and its square times `square`.
pub fn bench(noise: f64, [slope, square]: [f64; 2]) -> Metrology {
    let ramp = path(&[0.0, 10.0, 0.0, -10.0, 0.0], 200);
    let loads = (ramp.iter().map(|x| [*x, 0.0])).chain(ramp.iter().map(|x| [0.0, *x]));
    let reference: Vec<f64> = loads.flatten().collect();
    let read = |(k, load): (usize, &[f64])| {
        let noise = [0, 1].map(|axis| 10.0 * noise * 3.0_f64.sqrt() * uniform(2 * k + axis));
        let crosstalk = slope * load[0] + square * load[0] * load[0] / 10.0;
        [load[0] + noise[0], load[1] + 0.7 + noise[1] + crosstalk]
    };
    let output: Vec<f64> = reference.chunks(2).enumerate().flat_map(read).collect();
    let times: Vec<f64> = (0..reference.len() / 2).map(|k| k as f64).collect();
    let run = Run {
        name: "bench",
        times: &times,
        gauges: &[],
        reference_axes: &[Axis::Fx, Axis::Fy],
        reference: &reference,
        conventional: &output,
        compensated: &output,
        auxiliary: None,
        is_static: false,
        is_load_case: false,
        is_table: false,
    };
    table_of(&[run], &[Axis::Fx, Axis::Fy], &[10.0, 10.0])
}

/// With noise of 0.03 % of full scale, the largest error of a sensor without crosstalk is about 0.09 %.
#[test]
fn noise_and_offset_are_no_crosstalk() {
    let table = bench(3e-4, [0.0; 2]);
    for (from, axis) in [(Axis::Fx, Axis::Fy), (Axis::Fy, Axis::Fx)] {
        let found = table.cell(Quantity::Crosstalk(from), axis).unwrap();
        let percent = found.conventional.clone().unwrap().percent_fs.unwrap();
        assert!(percent.abs() < 0.005, "{percent} % of full scale");
    }
}

/// `0.01 x` is 0.1 at full load. The square `0.02 x² / 10` is equal for both signs of the load and adds no slope.
#[test]
fn crosstalk_is_the_slope_also_if_it_is_not_linear() {
    let table = bench(3e-4, [0.01, 0.02]);
    let cell = table.cell(Quantity::Crosstalk(Axis::Fx), Axis::Fy).unwrap();
    assert_near(value(&cell.conventional), 0.1, 0.02);
}

/// With other turning points in each cycle, or an independent load on another axis, no cycle is repeated.
#[test]
fn repeatability_is_only_of_cycles_that_repeat() {
    let free = path(&[0.0, 10.0, 1.5, 8.5, -1.0, 9.5, 0.5], 100);
    let table = One::new(free.clone(), free).table(10.0);
    let axis = Axis::Fz;
    assert_eq!(reason(&table, Quantity::Repeatability), Reason::NotRepeated { axis });

    // A dwell, and the path to the first turn, belong to no repeated cycle.
    let late = path(&[0.0, 5.0, -5.0, 5.0, -5.0, 5.0, -5.0, 0.0], 100);
    let off = |(k, load): (usize, &f64)| if k < 100 { load + 3.0 } else { *load };
    let output = late.iter().enumerate().map(off).collect();
    let table = One::new(late, output).table(5.0);
    let found = fz(&table, Quantity::Repeatability).conventional.clone().unwrap();
    assert!(found.value < 1e-9, "{found:?}");
    // Small cycles may be similar by chance.
    let small = path(&[0.0, 10.0, 2.0, 8.0, 2.0, 8.0, 2.0, 8.0, 0.0], 100);
    let table = One::new(small.clone(), small).table(10.0);
    assert_eq!(reason(&table, Quantity::Repeatability), Reason::NotRepeated { axis });

    let cycles = path(&[0.0, 10.0, 0.0, 10.0, 0.0, 10.0, 0.0], 100);
    let one = One::new(cycles.clone(), cycles);
    let both: Vec<f64> =
        (one.load.iter().enumerate()).flat_map(|(k, load)| [*load, 0.01 * k as f64]).collect();
    let run = Run {
        reference_axes: &[Axis::Fz, Axis::Mx],
        reference: &both,
        conventional: &both,
        compensated: &both,
        ..one.run()
    };
    let axes = [Axis::Fz, Axis::Mx];
    let table = table_of(&[run], &axes, &[10.0, 6.0]);
    let other = Axis::Mx;
    assert_eq!(reason(&table, Quantity::Repeatability), Reason::OthersDiffer { axis, other });
    let with_leave = table_of(&[run], &axes, &[10.0, 600.0]);
    assert!(value(&fz(&with_leave, Quantity::Repeatability).conventional) < 1e-9);
}

#[test]
fn mismatched_inputs_are_refused() {
    let load = path(&[0.0, 1.0], 9);
    let one = One::new(load.clone(), load);
    let settings = MetrologySettings::default();
    let of = |run: Run<'_>, full_scale: &[f64]| table(&[run], &[Axis::Fz], full_scale, &settings);
    assert!(matches!(of(one.run(), &[]), Err(MetrologyError::Count { .. })));
    assert!(matches!(of(one.run(), &[f64::NAN]), Err(MetrologyError::PerAxis { position: 1, .. })));
    let short = Run { compensated: &one.compensated[1..], ..one.run() };
    let refused = of(short, &[1.0]);
    assert!(matches!(refused, Err(MetrologyError::Shape { expected: 10, actual: 9, .. })));
}

/// A low-pass of 30 ms is a lag without hysteresis; play is hysteresis without lag.
#[test]
fn a_lag_and_hysteresis_have_rows_of_their_own() {
    for (late, tau) in [(Late::Lag, LAG_SECS), (Late::Both, LAG_SECS), (Late::Hysteresis, 0.0)] {
        let recordings = simulated::late(7, late);
        let outputs: Vec<Vec<f64>> = (recordings.iter())
            .map(|recording| {
                recording.gauges().iter().step_by(2).map(|gauge| gauge / 0.08).collect()
            })
            .collect();
        let runs: Vec<Run<'_>> = (recordings.iter().zip(&outputs))
            .map(|(recording, outputs)| Run {
                name: recording.name(),
                times: recording.times(),
                gauges: recording.gauges(),
                reference_axes: recording.axes(),
                reference: recording.loads(),
                conventional: outputs,
                compensated: outputs,
                auxiliary: None,
                is_static: false,
                is_load_case: false,
                is_table: false,
            })
            .collect();
        let table = table_of(&runs, &[Axis::Fz], &[10.0]);
        let lag = match &fz(&table, Quantity::TimeLag).conventional {
            Err(Reason::NoLagFound { .. }) => 0.0,
            found => value(found),
        };
        assert!((lag - tau).abs() < 0.001, "{late:?}: {lag}");
        let has_note = ids(&table).contains(&Id::LagInLoop);
        assert_eq!(has_note, late != Late::Hysteresis);
        let without = &fz(&table, Quantity::HysteresisWithoutLag).conventional;
        match late {
            Late::Hysteresis => {
                assert!(matches!(without, Err(Reason::LagExplainsLittle { .. })), "{without:?}")
            }
            _ => {
                let play = if late == Late::Both { 2.0 * PLAY_NEWTONS } else { 0.0 };
                let left = value(without);
                assert!((left - play).abs() < (0.1 * play).max(0.05), "{late:?}: {left}");
                assert!(value(&fz(&table, Quantity::Hysteresis).conventional) > left + 0.5);
            }
        }
    }
}

#[test]
fn a_cancelled_measurement_of_the_lags_is_an_error() {
    let progress = Progress::default();
    progress.cancel();
    let set = simulated::recordings(7);
    let recording = &set.entries()[0].recording;
    let loads = AppliedLoads {
        conventional: recording.loads().to_vec(),
        compensated: recording.loads().to_vec(),
        past: Vec::new(),
    };
    let runs = [Run::new(recording, &loads)];
    let settings = MetrologySettings::default();
    let full_scale = vec![1.0; recording.axes().len()];
    let extents = extents_of_set(&set, recording.axes());
    let rules = Rules {
        axes: recording.axes(),
        full_scale: &full_scale,
        settings: &settings,
        extents: &extents,
    };
    assert_eq!(lags_of(&runs, rules.axes, &progress).err(), Some(Cancelled));
}
