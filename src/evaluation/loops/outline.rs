//! A branch as few enough points to draw.
//!
//! Guarantees: what is drawn is never farther from what was left out than the tolerance; ends of branches are kept; the
//! number of points depends on the picture, not on the number of samples.

use super::turns::Branch;

/// So many times the tolerance is doubled at most; a picture is then a point.
const MOST_DOUBLINGS: u32 = 32;

/// A part of the plane that is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Least and greatest load.
    pub loads: (f64, f64),
    /// Least and greatest output.
    pub outputs: (f64, f64),
}

/// A piece of a branch as points `[load, output]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// Whether the load rises in it.
    pub rising: bool,
    /// In the order of time.
    pub points: Vec<[f64; 2]>,
}

/// Draws the branches of one recording in at most about `most` points.
///
/// A sample is left out while it lies within the tolerance of the last one that was kept: first a thousandth of the
/// frame's width and height, doubled until the points are few enough. Where a branch leaves the frame its stroke ends, one
/// sample beyond it.
///
/// # Panics
/// If a branch is not one of these loads, or there are not as many outputs as loads.
#[must_use]
pub fn outline(
    branches: &[Branch],
    loads: &[f64],
    outputs: &[f64],
    frame: Frame,
    most: usize,
) -> Vec<Stroke> {
    assert_eq!(loads.len(), outputs.len(), "one output for each load");
    let mut strokes: Vec<Stroke> = branches
        .iter()
        .flat_map(|branch| {
            let samples = branch.samples.clone();
            let points = samples.map(|k| [loads[k], outputs[k]]);
            strokes_within(points, branch.rising, frame)
        })
        .collect();
    let mut tolerance = 1e-3;
    for _ in 0..MOST_DOUBLINGS {
        if strokes
            .iter()
            .map(|stroke| stroke.points.len())
            .sum::<usize>()
            <= most
        {
            break;
        }
        for stroke in &mut strokes {
            thin(&mut stroke.points, frame, tolerance);
        }
        tolerance *= 2.0;
    }
    strokes
}

/// The pieces of a path that lie in the frame, each with its neighbours just outside.
fn strokes_within(path: impl Iterator<Item = [f64; 2]>, rising: bool, frame: Frame) -> Vec<Stroke> {
    let within = |[load, output]: [f64; 2]| {
        (frame.loads.0..=frame.loads.1).contains(&load)
            && (frame.outputs.0..=frame.outputs.1).contains(&output)
    };
    let mut strokes: Vec<Stroke> = Vec::new();
    let (mut last, mut drawing) = (None, false);
    for point in path {
        let inside = within(point);
        if inside && !drawing {
            strokes.push(Stroke {
                rising,
                points: last.into_iter().collect(),
            });
        }
        if let Some(stroke) = strokes.last_mut()
            && (inside || drawing)
        {
            stroke.points.push(point);
        }
        (last, drawing) = (Some(point), inside);
    }
    strokes
}

/// Leaves out what lies within the tolerance (a share of the frame) of the last kept point; keeps both ends.
fn thin(points: &mut Vec<[f64; 2]>, frame: Frame, tolerance: f64) {
    let reach = [frame.loads, frame.outputs].map(|(low, high)| tolerance * (high - low));
    let Some(&end) = points.last() else { return };
    let mut last: Option<[f64; 2]> = None;
    points.retain(|point| {
        let keep = last.is_none_or(|last| (0..2).any(|i| (point[i] - last[i]).abs() > reach[i]));
        if keep {
            last = Some(*point);
        }
        keep
    });
    if last != Some(end) {
        points.push(end);
    }
}

#[cfg(test)]
mod tests {
    use super::super::turns::branches;
    use super::*;

    const FRAME: Frame = Frame {
        loads: (-1.0, 1.0),
        outputs: (-2.0, 2.0),
    };

    fn circle() -> (Vec<f64>, Vec<f64>) {
        let angles = (0..50_000).map(|k| f64::from(k) * std::f64::consts::TAU / 10_000.0);
        angles.map(|angle| (angle.sin(), angle.cos())).unzip()
    }

    #[test]
    fn many_samples_become_few_points_that_keep_the_shape() {
        let (loads, outputs) = circle();
        let found = branches(&loads, 0.1);
        let strokes = outline(&found, &loads, &outputs, FRAME, 2000);
        let points: Vec<_> = strokes.iter().flat_map(|stroke| &stroke.points).collect();
        assert!((500..=2000).contains(&points.len()), "{}", points.len());
        for [load, output] in points {
            assert!((load.hypot(*output) - 1.0).abs() < 1e-12);
        }
        for (stroke, branch) in strokes.iter().zip(&found) {
            let ends =
                [branch.samples.start, branch.samples.end - 1].map(|k| [loads[k], outputs[k]]);
            assert_eq!(
                [stroke.points[0], stroke.points[stroke.points.len() - 1]],
                ends
            );
            assert_eq!(stroke.rising, branch.rising);
        }
    }

    #[test]
    fn few_samples_are_all_drawn() {
        let (loads, outputs) = (vec![0.0, 0.5, 1.0, 0.0], vec![0.0, 1.0, 1.5, 0.0]);
        let strokes = outline(&branches(&loads, 0.1), &loads, &outputs, FRAME, 100);
        let lengths: Vec<_> = strokes.iter().map(|stroke| stroke.points.len()).collect();
        assert_eq!(lengths, [3, 2]);
    }

    #[test]
    fn what_is_outside_is_not_drawn_but_for_its_edge() {
        let (loads, outputs) = circle();
        let right = Frame {
            loads: (0.9, 1.0),
            ..FRAME
        };
        let strokes = outline(&branches(&loads, 0.1), &loads, &outputs, right, usize::MAX);
        let points = strokes.iter().flat_map(|stroke| &stroke.points);
        assert!(points.clone().all(|point| point[0] > 0.899));
        assert!(points.clone().any(|point| point[0] < 0.9));
        assert!(
            outline(
                &branches(&loads, 0.1),
                &loads,
                &outputs,
                Frame {
                    loads: (2.0, 3.0),
                    ..FRAME
                },
                9
            )
            .is_empty()
        );
    }
}
