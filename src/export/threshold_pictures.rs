//! The errors over both thresholds as pictures: curves along either threshold, and the map.

use std::path::{Path, PathBuf};

use crate::evaluation::threshold_study::{Measure, ScoreSet, Suggestion, ThresholdMap};
use crate::export::{WriteError, write_atomically, write_threshold_csv};
use crate::features::Distance;
use crate::report::figure::{self, Figure, HeatMap, Line, Scale, color};

/// The name of F_th with its unit.
pub fn f_th_label(distance: Distance) -> &'static str {
    match distance {
        Distance::Force => "F_th [N]",
        Distance::FullScale => "F_th [share of full scale]",
    }
}

/// Width and height of the pictures.
const SIZE: (f64, f64) = (720.0, 440.0);
/// Room above and below curves, as a share of their range.
const ROOM: f64 = 0.06;
const T_TH_LABEL: &str = "t_th [s]";

fn rmse_label(map: &ThresholdMap, measure: Measure) -> String {
    format!("RMSE [{}]", measure.unit(&map.scale))
}

/// The curves of every set over F_th, at the t_th at this position; where there is a suggestion, its F_th is marked and the
/// F_th within one standard error are shaded.
///
/// # Panics
/// If there is no such t_th.
pub fn curves_over_f_th(
    map: &ThresholdMap,
    measure: Measure,
    t_at: usize,
    suggestion: Option<&Suggestion>,
) -> Figure<'static> {
    let t_th = map.grid.t_ths_secs()[t_at];
    Figure {
        title: format!("{} at t_th {t_th} s", measure.label(&map.scale)),
        shaded: suggestion.map(|found| (found.f_th_range.from, found.f_th_range.to)),
        marked: suggestion.map(|found| found.thresholds.f_th),
        ..curves(f_th_label(map.distance), rmse_label(map, measure), |set| {
            map.curve_over_f_th(set, measure, t_at)
        })
    }
}

/// The curves of every set over t_th, at the F_th at this position; otherwise like [`curves_over_f_th`].
///
/// # Panics
/// If there is no such F_th.
pub fn curves_over_t_th(
    map: &ThresholdMap,
    measure: Measure,
    f_at: usize,
    suggestion: Option<&Suggestion>,
) -> Figure<'static> {
    let (f_th, f_th_label) = (map.grid.f_ths()[f_at], f_th_label(map.distance));
    Figure {
        title: format!("{} at {f_th_label} = {f_th}", measure.label(&map.scale)),
        shaded: suggestion.map(|found| (found.t_th_range.from, found.t_th_range.to)),
        marked: suggestion.map(|found| found.thresholds.t_th_secs),
        ..curves(T_TH_LABEL, rmse_label(map, measure), |set| {
            map.curve_over_t_th(set, measure, f_at)
        })
    }
}

/// One line for every set that has scores. As in the window the one to choose by is solid; the others are seen on top of it.
fn curves(
    across: &str,
    up: String,
    curve: impl Fn(ScoreSet) -> Vec<(f64, f64)>,
) -> Figure<'static> {
    let lines = ScoreSet::ALL.into_iter().rev().map(|set| {
        let points: Vec<[f64; 2]> = curve(set).into_iter().map(Into::into).collect();
        let dash = match set {
            ScoreSet::Train => Some(figure::DOTTED),
            ScoreSet::Test => Some(figure::DASHED),
            ScoreSet::LeftOut => None,
        };
        Line {
            dash,
            ..Line::new(set.label(), color::SCORE, [points])
        }
    });
    let lines: Vec<_> = lines.filter(|line| !line.pieces[0].is_empty()).collect();
    let along = |at: usize| {
        lines
            .iter()
            .flat_map(move |line| line.pieces[0].iter().map(move |point| point[at]))
    };
    Figure {
        across: Scale::spanning(across, along(0), 0.0),
        up: Scale::spanning(up, along(1), ROOM),
        lines,
        ..Figure::default()
    }
}

/// The map of one number, a suggested pair marked.
pub fn threshold_heat_map(
    map: &ThresholdMap,
    set: ScoreSet,
    measure: Measure,
    suggestion: Option<&Suggestion>,
) -> Figure<'static> {
    let values = map.values(set, measure);
    let shades = map.shades(set, measure).unwrap_or((0.0, 1.0));
    Figure {
        title: format!("{}, {}", measure.label(&map.scale), set.label()),
        across: Scale::of_cells(f_th_label(map.distance), map.grid.f_ths()),
        up: Scale::of_cells(T_TH_LABEL, map.grid.t_ths_secs()),
        heat_map: Some(HeatMap {
            shades: Scale::new(rmse_label(map, measure), shades),
            marked: suggestion.map(|found| found.at),
            values,
        }),
        ..Figure::default()
    }
}

/// Writes such a figure as SVG.
///
/// # Errors
/// [`WriteError`] if the file cannot be written.
pub fn write_threshold_svg(figure: &Figure<'_>, path: &Path) -> Result<(), WriteError> {
    write_atomically(path, |out| out.write_all(figure.svg(SIZE).as_bytes()))
}

/// The files that [`write_threshold_map`] writes: this one, and the two beside a picture.
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
    let (f_at, t_at) = found.map_or((0, 0), |found| found.at);
    let heat_map = threshold_heat_map(map, ScoreSet::LeftOut, measure, found);
    write_threshold_svg(&heat_map, path)?;
    write_threshold_svg(&curves_over_f_th(map, measure, t_at, found), over_f_th)?;
    write_threshold_svg(&curves_over_t_th(map, measure, f_at, found), over_t_th)
}
