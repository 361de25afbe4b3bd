//! The errors over both thresholds as pictures: curves along either threshold, and the map.

use std::path::{Path, PathBuf};

use crate::evaluation::threshold_study::{Measure, ScoreSet, Suggestion, ThresholdMap};
use crate::export::svg::{CurvePlot, HeatMap, Labels, Line, write_curves_svg, write_heat_map_svg};
use crate::export::{WriteError, write_atomically, write_threshold_csv};
use crate::features::Distance;

/// The name of F_th with its unit.
#[must_use]
pub fn f_th_label(distance: Distance) -> &'static str {
    match distance {
        Distance::Force => "F_th [N]",
        Distance::FullScale => "F_th [share of full scale]",
    }
}

const T_TH_LABEL: &str = "t_th [s]";

fn rmse_label(map: &ThresholdMap, measure: Measure) -> String {
    format!("RMSE [{}]", measure.unit(&map.scale))
}

/// The curves of every set over F_th, at the t_th at this position; where there is a suggestion, its F_th is marked and the
/// F_th that do about as well are shaded.
///
/// # Panics
/// If there is no such t_th.
#[must_use]
pub fn curves_over_f_th(
    map: &ThresholdMap,
    measure: Measure,
    t_at: usize,
    suggestion: Option<&Suggestion>,
) -> CurvePlot {
    let t_th = map.grid.t_ths_secs()[t_at];
    CurvePlot {
        labels: Labels {
            title: format!("{} at t_th {t_th} s", measure.label(&map.scale)),
            x: f_th_label(map.distance).to_owned(),
            y: rmse_label(map, measure),
        },
        lines: lines(|set| map.curve_over_f_th(set, measure, t_at)),
        shaded: suggestion.map(|found| (found.f_th_range.from, found.f_th_range.to)),
        marked: suggestion.map(|found| found.thresholds.f_th),
    }
}

/// The curves of every set over t_th, at the F_th at this position; otherwise like [`curves_over_f_th`].
///
/// # Panics
/// If there is no such F_th.
#[must_use]
pub fn curves_over_t_th(
    map: &ThresholdMap,
    measure: Measure,
    f_at: usize,
    suggestion: Option<&Suggestion>,
) -> CurvePlot {
    let f_th = map.grid.f_ths()[f_at];
    CurvePlot {
        labels: Labels {
            title: format!(
                "{} at {} = {f_th}",
                measure.label(&map.scale),
                f_th_label(map.distance)
            ),
            x: T_TH_LABEL.to_owned(),
            y: rmse_label(map, measure),
        },
        lines: lines(|set| map.curve_over_t_th(set, measure, f_at)),
        shaded: suggestion.map(|found| (found.t_th_range.from, found.t_th_range.to)),
        marked: suggestion.map(|found| found.thresholds.t_th_secs),
    }
}

/// One line for every set that has scores.
fn lines(curve: impl Fn(ScoreSet) -> Vec<(f64, f64)>) -> Vec<Line> {
    let lines = ScoreSet::ALL.into_iter().map(|set| Line {
        label: set.label().to_owned(),
        points: curve(set),
        dashed: set == ScoreSet::Train,
    });
    lines.filter(|line| !line.points.is_empty()).collect()
}

/// The map of one number, a suggested pair marked.
#[must_use]
pub fn threshold_heat_map(
    map: &ThresholdMap,
    set: ScoreSet,
    measure: Measure,
    suggestion: Option<&Suggestion>,
) -> HeatMap {
    HeatMap {
        labels: Labels {
            title: format!("{}, {}", measure.label(&map.scale), set.label()),
            x: f_th_label(map.distance).to_owned(),
            y: T_TH_LABEL.to_owned(),
        },
        value_label: rmse_label(map, measure),
        xs: map.grid.f_ths().to_vec(),
        ys: map.grid.t_ths_secs().to_vec(),
        values: map.values(set, measure),
        marked: suggestion.map(|found| found.at),
    }
}

/// The files that [`write_threshold_map`] writes: this one, and the two beside a picture.
#[must_use]
pub fn threshold_map_files(path: &Path) -> Vec<PathBuf> {
    let mut files = vec![path.to_owned()];
    let is_svg = path
        .extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("svg"));
    if is_svg {
        files.extend(["f_th", "t_th"].map(|along| {
            let mut name = path.file_stem().unwrap_or_default().to_owned();
            name.push(format!("_{along}.svg"));
            path.with_file_name(name)
        }));
    }
    files
}

/// Writes a map in the format of the file's ending: `.svg` the picture of the left-out errors with the suggested pair
/// (beside it, as `<name>_f_th.svg` and `<name>_t_th.svg`, the curves through that pair), anything else every number as CSV.
///
/// # Errors
/// [`WriteError`] if a file cannot be written.
pub fn write_threshold_map(
    map: &ThresholdMap,
    measure: Measure,
    path: &Path,
) -> Result<(), WriteError> {
    let files = threshold_map_files(path);
    let [_, over_f_th, over_t_th] = &files[..] else {
        return write_atomically(path, |out| write_threshold_csv(map, out));
    };
    let suggestion = map.suggestion(measure).ok();
    let found = suggestion.as_ref();
    let picture = threshold_heat_map(map, ScoreSet::LeftOut, measure, found);
    write_atomically(path, |out| write_heat_map_svg(&picture, out))?;
    let (f_at, t_at) = found.map_or((0, 0), |found| found.at);
    for (file, curves) in [
        (over_f_th, curves_over_f_th(map, measure, t_at, found)),
        (over_t_th, curves_over_t_th(map, measure, f_at, found)),
    ] {
        write_atomically(file, |out| write_curves_svg(&curves, out))?;
    }
    Ok(())
}
