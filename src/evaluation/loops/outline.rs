//! A branch as few enough points to draw.
//!
//! Guarantees: what is left out lies within the tolerance of what is drawn; ends of branches are kept; the number of points
//! depends on the picture, not on the number of samples.

use super::turns::Branch;

/// The first tolerance: about half a pixel.
const FINEST: f64 = 5e-4;

/// A part of the plane that is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Least and greatest load.
    pub loads: (f64, f64),
    /// Least and greatest output.
    pub outputs: (f64, f64),
}

impl Frame {
    fn contains(self, [load, output]: [f64; 2]) -> bool {
        (self.loads.0..=self.loads.1).contains(&load)
            && (self.outputs.0..=self.outputs.1).contains(&output)
    }

    /// A share of its width and height.
    fn reach(self, share: f64) -> [f64; 2] {
        [self.loads, self.outputs].map(|(low, high)| share * (high - low))
    }
}

/// A piece of a branch as points `[load, output]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// Whether the load rises in it.
    pub rising: bool,
    /// In the order of time.
    pub points: Vec<[f64; 2]>,
}

impl Stroke {
    /// How far it goes, each step by its larger share of the frame's width or height.
    fn length(&self, frame: Frame) -> f64 {
        let [width, height] = frame.reach(1.0);
        let steps = self.points.windows(2);
        steps
            .map(|step| {
                let along = (step[1][0] - step[0][0]).abs() / width;
                along.max((step[1][1] - step[0][1]).abs() / height)
            })
            .filter(|step| step.is_finite())
            .sum()
    }
}

/// Draws the branches of one recording in at most `most` points besides the ends of strokes.
///
/// More samples than that are thinned: one is left out while it lies within a tolerance of the last one that was kept. The
/// tolerance is the length of the way over `most`, so that steps no shorter than it are few enough, and at least 1/2000
/// of the frame's width and height. Where a branch leaves the frame its stroke ends, one sample beyond it; between two
/// samples that are both outside nothing is drawn.
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
    let is_long = loads.len() > most;
    let finest = if is_long { FINEST } else { 0.0 };
    let mut strokes = Vec::new();
    for branch in branches {
        let samples = branch.samples.clone();
        let path = loads[samples.clone()].iter().zip(&outputs[samples]);
        let path = path.map(|(load, output)| [*load, *output]);
        add_strokes(&mut strokes, path, branch.rising, frame, finest);
    }
    if is_long {
        let length: f64 = strokes.iter().map(|stroke| stroke.length(frame)).sum();
        let reach = frame.reach((length / most.max(1) as f64).max(finest));
        for stroke in &mut strokes {
            thin(&mut stroke.points, reach);
        }
    }
    strokes
}

/// Adds the pieces of a path that lie in the frame, thinned, each with its neighbours just outside.
fn add_strokes(
    strokes: &mut Vec<Stroke>,
    path: impl Iterator<Item = [f64; 2]>,
    rising: bool,
    frame: Frame,
    tolerance: f64,
) {
    let reach = frame.reach(tolerance);
    // Those of the stroke that is being drawn; none while the path is outside.
    let mut points: Vec<[f64; 2]> = Vec::new();
    let (mut before, mut kept) = (None, [0.0; 2]);
    for point in path {
        if frame.contains(point) {
            if points.is_empty() {
                points.extend(before);
            }
            if points.len() < 2 || is_beyond(kept, point, reach) {
                points.push(point);
                kept = point;
            }
        } else if !points.is_empty() {
            points.push(point);
            let points = std::mem::take(&mut points);
            strokes.push(Stroke { rising, points });
        }
        before = Some(point);
    }
    if !points.is_empty() {
        points.extend(before.filter(|end| *end != kept));
        strokes.push(Stroke { rising, points });
    }
}

fn is_beyond(a: [f64; 2], b: [f64; 2], reach: [f64; 2]) -> bool {
    (b[0] - a[0]).abs() > reach[0] || (b[1] - a[1]).abs() > reach[1]
}

/// Leaves out what lies within reach of the last kept point; keeps both ends.
fn thin(points: &mut Vec<[f64; 2]>, reach: [f64; 2]) {
    let Some(&end) = points.last() else { return };
    let mut last: Option<[f64; 2]> = None;
    points.retain(|point| {
        let keep = last.is_none_or(|last| is_beyond(last, *point, reach));
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
        let most = 2000 + 2 * strokes.len();
        assert!((1000..=most).contains(&points.len()), "{}", points.len());
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
