//! The rows about crosstalk: what an axis reads while another one alone is loaded.

use super::measured::{Columns, Measured, OUTPUTS};
use super::reason::Reason;
use super::{Found, Result};

/// Fewer samples than this are no interval but a load that passes by.
const FEWEST_SAMPLES: usize = 10;
/// From this share of its full scale on an axis can be the one that is loaded alone.
const PRESENT: f64 = 0.1;

/// The largest errors of all axes while one alone is loaded.
#[derive(Clone, Debug)]
pub(super) struct Alone {
    /// In how many samples.
    count: usize,
    /// The greatest size of the load of the lone axis.
    reached: f64,
    /// Per output and axis: the largest error, with its run and sample.
    largest: [Vec<(f64, usize, usize)>; OUTPUTS],
}

/// Which axis is loaded alone, sample by sample; one entry per loaded axis.
pub(super) fn stretches_alone(measured: &Measured<'_>) -> Vec<Alone> {
    let n_axes = measured.axes.len();
    let nothing = Alone {
        count: 0,
        reached: 0.0,
        largest: std::array::from_fn(|_| vec![(-1.0, 0, 0); n_axes]),
    };
    let mut all = vec![nothing; n_axes];
    for (index, run) in measured.runs.iter().enumerate() {
        let Some(loads) = run.all_loads() else {
            continue;
        };
        for k in 0..run.times.len() {
            if let Some(lone) = lone_axis(measured, &loads, k) {
                all[lone].count += 1;
                all[lone].reached = all[lone].reached.max(loads[lone][k].abs());
                all[lone].keep_largest(run, &loads, (index, k));
            }
        }
    }
    all
}

/// The one axis that is loaded in sample `k`, all others staying within their share.
fn lone_axis(measured: &Measured<'_>, loads: &[&[f64]], k: usize) -> Option<usize> {
    let mut lone = None;
    for (axis, full_scale) in measured.full_scale.iter().enumerate() {
        if loads[axis][k].abs() > measured.settings.alone_share * full_scale
            && lone.replace(axis).is_some()
        {
            return None;
        }
    }
    lone.filter(|&axis| {
        let present = PRESENT.max(measured.settings.alone_share) * measured.full_scale[axis];
        loads[axis][k].abs() > present
    })
}

impl Alone {
    fn keep_largest(&mut self, run: &Columns<'_>, loads: &[&[f64]], at: (usize, usize)) {
        for (largest, outputs) in self.largest.iter_mut().zip(&run.outputs) {
            for (axis, largest) in largest.iter_mut().enumerate() {
                let error = (outputs[axis][at.1] - loads[axis][at.1]).abs();
                if error > largest.0 {
                    *largest = (error, at.0, at.1);
                }
            }
        }
    }
}

/// What `axis` reads while `loaded` alone is loaded (both columns of the table).
pub(super) fn crosstalk_figure(
    measured: &Measured<'_>,
    alone: &[Alone],
    loaded: usize,
    axis: usize,
    output: usize,
) -> Result<Found> {
    let (settings, loaded_axis) = (measured.settings, measured.axes[loaded]);
    if measured.axes.len() == 1 {
        return Err(Reason::OnlyAxis { axis: loaded_axis });
    }
    if loaded == axis {
        return Err(Reason::LoadedAxis { axis: loaded_axis });
    }
    let full_scale = measured.full_scale[loaded];
    if full_scale <= 0.0 {
        return Err(Reason::NoFullScale { axis: loaded_axis });
    }
    let found = &alone[loaded];
    if found.count < FEWEST_SAMPLES || found.reached < settings.loaded_share * full_scale {
        return Err(Reason::NeverAlone {
            axis: loaded_axis,
            loaded_share: settings.loaded_share,
            alone_share: settings.alone_share,
        });
    }
    let (size, run, k) = found.largest[output][axis];
    Ok(Found {
        size,
        place: Some(measured.runs[run].place(run, k..k + 1)),
    })
}
