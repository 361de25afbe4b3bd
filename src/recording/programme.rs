//! Load programmes: finds recordings in which the load takes the same course over time, and short presses of the same shape.

use crate::{
    min_max::MinMax,
    recording::{recording::Recording, shared::join},
};

/// Minimum number of samples of a recording whose load programme is compared with others.
const FEWEST_SAMPLES: usize = 16;
/// Number of samples at which two load programmes are compared, evenly spread over each recording.
const COMPARED: usize = 64;
/// Maximum RMS difference between the loads of two recordings with the same programme, as a share of the load range.
const SAME_PROGRAMME: f64 = 0.05;

impl Recording {
    /// Returns true if the load takes the same course in both recordings, at the same or another speed.
    pub(crate) fn repeats(&self, other: &Self) -> bool {
        let is_comparable =
            |recording: &Self| recording.n_samples() >= FEWEST_SAMPLES && recording.has_reference();
        if self.axes() != other.axes() || ![self, other].into_iter().all(is_comparable) {
            return false;
        }
        let n_axes = self.axes().len();
        let load = |of: &Self, at: usize, axis: usize| {
            let sample = at * (of.n_samples() - 1) / (COMPARED - 1);
            of.loads()[sample * n_axes + axis]
        };
        let range: f64 = other.load_ranges().iter().map(|range| range.span().powi(2)).sum();
        let most = SAME_PROGRAMME.powi(2) * range * COMPARED as f64;
        let mut squares = 0.0;
        // The sum stops as soon as it exceeds the limit: for most different programmes, a few samples suffice.
        (0..COMPARED).all(|at| {
            let difference = |axis| load(self, at, axis) - load(other, at, axis);
            squares += (0..n_axes).map(|axis| difference(axis).powi(2)).sum::<f64>();
            squares <= most
        })
    }
}

/// Returns, for each recording, the index of the first recording in which the load takes the same course.
pub(crate) fn repeated_programmes(recordings: &[&Recording]) -> Vec<usize> {
    let mut programmes: Vec<usize> = Vec::new();
    let mut programme_of = |at: usize| {
        let known = programmes.iter().find(|first| recordings[at].repeats(recordings[**first]));
        known.copied().unwrap_or_else(|| {
            programmes.push(at);
            at
        })
    };
    (0..recordings.len()).map(&mut programme_of).collect()
}

/// Maximum number of samples of a press, a recording too short to compare its load sample by sample.
const LONGEST_PRESS: usize = 64;
/// Minimum and maximum number of presses that are grouped by their shape. The maximum bounds the pairs that are compared.
const N_PRESSES: std::ops::RangeInclusive<usize> = 12..=4000;
/// Minimum ratio between the distances of presses with different shapes and of presses with the same shape. Of 360 sets of
/// simulated presses whose shapes vary continuously, one exceeded it. Of 240 sets of 4 to 12 programmes on three axes, 196 did.
const CLEAR_GAP: f64 = 1.6;
/// Maximum share of the presses that may have a shape of their own.
const SINGLE_SHAPES: f64 = 0.1;

/// Returns the shape of the load of each recording as a number, equal for presses of the same shape. `None` if the recordings
/// are not short presses, or if their shapes do not fall into groups with a clear distance between them.
///
/// A shape consists of the place of the peak as a share of the length, the logarithm of the length, the steepest change as a
/// share of the steepest of all, and the peak and the mean of each axis as shares of its load range. The groups are those of
/// single linkage: the sorted distances of the minimum spanning tree are cut where the ratio of neighbours is largest. No group
/// may be wider than the least distance between groups.
pub(crate) fn press_shapes(recordings: &[&Recording]) -> Option<Vec<usize>> {
    let n = recordings.len();
    let axes = recordings.first()?.axes();
    let is_press = |recording: &&Recording| {
        (3..=LONGEST_PRESS).contains(&recording.n_samples())
            && recording.has_reference()
            && recording.axes() == axes
    };
    if !N_PRESSES.contains(&n) || !recordings.iter().all(is_press) {
        return None;
    }
    let mut ranges = vec![MinMax::NONE; axes.len()];
    recordings.iter().for_each(|press| join(&mut ranges, press.load_ranges()));
    let mut shapes: Vec<Vec<f64>> = recordings.iter().map(|press| shape_of(press)).collect();
    let steepest = shapes.iter().map(|shape| shape[STEEPEST]).fold(0.0, f64::max);
    let share = |value: f64, of: f64| if of > 0.0 { value / of } else { 0.0 };
    for shape in &mut shapes {
        shape[STEEPEST] = share(shape[STEEPEST], steepest);
        for (of_axis, range) in shape[OF_AXES..].chunks_mut(2).zip(&ranges) {
            of_axis.iter_mut().for_each(|value| *value = share(*value, range.span()));
        }
    }
    let mut edges = spanning_tree(&shapes);
    edges.sort_by(|a, b| b.2.total_cmp(&a.2));
    // Without the `cut` longest edges there are `cut + 1` groups: at least three, with two presses in each on average.
    let ratio = |cut: usize| edges[cut - 1].2 / edges[cut].2.max(1e-9);
    let cut = (2..n / 2).max_by(|a, b| ratio(*a).total_cmp(&ratio(*b)))?;
    if ratio(cut) < CLEAR_GAP {
        return None;
    }
    let mut groups: Vec<usize> = (0..n).collect();
    for &(a, b, _) in &edges[cut..] {
        let (kept, joined) = (groups[a].min(groups[b]), groups[a].max(groups[b]));
        groups.iter_mut().filter(|group| **group == joined).for_each(|group| *group = kept);
    }
    // Single linkage also joins a chain of presses whose shape varies continuously.
    let are_compact =
        (0..n).all(|at| distance(&shapes[at], &shapes[groups[at]]) < edges[cut - 1].2);
    let mut sizes = vec![0; n];
    groups.iter().for_each(|group| sizes[*group] += 1);
    let n_single = sizes.iter().filter(|size| **size == 1).count();
    (are_compact && n_single as f64 <= SINGLE_SHAPES * n as f64).then_some(groups)
}

/// Index of the steepest change in a shape, and of the first number of an axis.
const STEEPEST: usize = 2;
const OF_AXES: usize = 3;

fn shape_of(press: &Recording) -> Vec<f64> {
    let (n, n_axes) = (press.n_samples(), press.axes().len());
    let load = |sample: usize, axis: usize| press.loads()[sample * n_axes + axis];
    let ranges: Vec<f64> = press.load_ranges().iter().map(|range| range.span()).collect();
    let main = (0..n_axes).max_by(|a, b| ranges[*a].total_cmp(&ranges[*b])).unwrap_or(0);
    let peak = |axis: usize| {
        (0..n).max_by(|a, b| load(*a, axis).abs().total_cmp(&load(*b, axis).abs())).unwrap_or(0)
    };
    let mean = |axis| (0..n).map(|sample| load(sample, axis)).sum::<f64>() / n as f64;
    let step = |sample: usize| (load(sample, main) - load(sample - 1, main)).abs();
    let steepest = (1..n).map(step).fold(0.0, f64::max);
    let of_axes = (0..n_axes).flat_map(|axis| [load(peak(axis), axis), mean(axis)]);
    [peak(main) as f64 / n as f64, (n as f64).ln(), steepest].into_iter().chain(of_axes).collect()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// Returns the edges of the minimum spanning tree of these points: two points and their distance (Prim's algorithm).
fn spanning_tree(points: &[Vec<f64>]) -> Vec<(usize, usize, f64)> {
    // Distance from the tree, and the point of the tree that is nearest, of each point outside the tree.
    let mut outside: Vec<(usize, usize, f64)> =
        (1..points.len()).map(|at| (0, at, distance(&points[0], &points[at]))).collect();
    let mut edges = Vec::with_capacity(outside.len());
    while let Some(next) = (0..outside.len()).min_by(|a, b| outside[*a].2.total_cmp(&outside[*b].2))
    {
        let edge = outside.swap_remove(next);
        edges.push(edge);
        for (nearest, at, least) in &mut outside {
            let from_new = distance(&points[edge.1], &points[*at]);
            if from_new < *least {
                (*nearest, *least) = (edge.1, from_new);
            }
        }
    }
    edges
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{Axis, Source};

    /// Returns presses of three axes with 8 to 30 samples: half-sines that begin anywhere within a sample.
    fn presses(kinds: &[[f64; 5]]) -> Vec<Recording> {
        let mut share = shares();
        let press = |at: usize| {
            let [x, y, z, length, place] = kinds[at % kinds.len()];
            let n = (30.0 * length) as usize + 2;
            let begin = share();
            let rise = |sample: usize| {
                let t = (sample as f64 + begin) / (n as f64);
                (if t < place { t / place } else { (1.0 - t) / (1.0 - place) }).clamp(0.0, 1.0)
            };
            let loads = (0..n).flat_map(|k| [x, y, z].map(|peak| peak * rise(k)));
            let times = (0..n).map(|k| 0.1 * k as f64).collect();
            let loads = loads.map(|load| load + 0.01 * share()).collect();
            let axes = vec![Axis::Fx, Axis::Fy, Axis::Fz];
            let name = format!("press_{at}");
            Recording::new(name, Source::File("a".into()), times, vec![], vec![], axes, loads)
        };
        (0..48).map(press).collect::<Result<_, _>>().unwrap()
    }

    fn shares() -> impl FnMut() -> f64 {
        let mut state = 0x9e37_79b9_u64;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888);
            (state >> 33) as f64 / 2f64.powi(31)
        }
    }

    #[test]
    fn presses_of_six_shapes_form_six_groups() {
        let kind = |at: usize| {
            let share = at as f64 / 5.0;
            let mixed = (at * 7 % 6) as f64 / 5.0;
            [share, 1.0 - share, 0.5, 0.3 + 0.6 * mixed, 0.3 + 0.4 * share]
        };
        let presses = presses(&std::array::from_fn::<_, 6, _>(kind));
        let groups = press_shapes(&presses.iter().collect::<Vec<_>>()).unwrap();
        assert_eq!(groups, (0..48).map(|at| at % 6).collect::<Vec<_>>());
    }

    #[test]
    fn presses_of_continuously_varying_shape_form_no_groups() {
        let mut share = shares();
        let kinds: [[f64; 5]; 48] =
            std::array::from_fn(|_| std::array::from_fn(|_| 0.2 + 0.7 * share()));
        let presses = presses(&kinds);
        assert_eq!(press_shapes(&presses.iter().collect::<Vec<_>>()), None);
    }
}
