//! Files and figures of a threshold map: a table as CSV, the heat map of the errors over both thresholds, and curves of the
//! error against one threshold. [`MAP_FORMATS`] is the only list of the file formats.

use std::io;
use std::path::{Path, PathBuf};

use crate::{
    export::{FileFormat, Together, WriteError},
    features::{Distance, Thresholds},
    questions::thresholds::{Along, Measure, Suggestion, ThresholdMap},
    report::{
        Cell, Column, Table,
        figure::{self, Figure, HeatMap, Line, Scale, color},
    },
    scoring::score_set::ScoreSet,
};

/// Writer of a threshold map in one format.
pub struct MapWriter {
    /// Function that returns the paths of all files that `write` creates if it is called with this path.
    pub files: fn(&Path) -> Vec<PathBuf>,
    pub write: fn(&ThresholdMap, Measure, &Path, &mut Together) -> Result<(), WriteError>,
}

pub static MAP_FORMATS: &[FileFormat<MapWriter>] = &[CSV, SVG];

/// Returns the file format that belongs to the ending of this path, or the first format for an unknown ending.
pub fn map_format(path: &Path) -> &'static FileFormat<MapWriter> {
    FileFormat::for_path(MAP_FORMATS, path).unwrap_or(&MAP_FORMATS[0])
}

pub const CSV: FileFormat<MapWriter> = FileFormat {
    name: "Delimited text",
    ending: "csv",
    holds: "every number",
    write: MapWriter {
        files: |path| vec![path.to_owned()],
        write: |map, _, path, files| files.write(path, |out| write_threshold_csv(map, out)),
    },
};

/// Writes the thresholds, the RMSE of each axis, and the combined RMSE of forces, of moments and of all axes. The first rows
/// have empty thresholds and describe the conventional calibration. Rows without errors are omitted.
///
/// **Units** `t_th` in s, `f_th` in N or as a share of full scale. The header gives the units of the errors. Numbers have
/// full precision.
///
/// # Errors
/// The I/O errors of `out`.
pub fn write_threshold_csv(map: &ThresholdMap, out: &mut dyn io::Write) -> io::Result<()> {
    let is_group = |measure: &Measure| !matches!(measure, Measure::Axis(_));
    let groups = map.scale.measures().into_iter().filter(is_group);
    let points = map.points().map(|(at, point)| (Some(at), &point.scores));
    let all = std::iter::once((None, &map.conventional.scores)).chain(points);
    let rows = all.flat_map(|(at, scores)| {
        let sets = ScoreSet::ALL.into_iter();
        sets.filter_map(move |set| Some((at, set, set.rmse(scores)?)))
    });
    let of = |at: &Option<Thresholds>, along: Along| {
        at.map_or_else(String::new, |at| along.of(at).to_string())
    };
    Table::of(rows)
        .words("f_th", |(at, ..)| of(at, Along::F))
        .words("t_th", |(at, ..)| of(at, Along::T))
        .words("set", |(_, set, _)| set.label())
        .columns(
            map.scale.axes.iter().enumerate(),
            |(_, axis)| Column::words(axis.label()),
            |(.., rmse), (at, _)| Cell::words(rmse[*at].to_string()),
        )
        .columns(
            groups,
            |group| Column::words(group.label(&map.scale)).unit(group.unit(&map.scale)),
            |(.., rmse), group| {
                let value = group.of_rmse(&map.scale, rmse);
                Cell::words(value.map_or_else(String::new, |value| value.to_string()))
            },
        )
        .table("", "")
        .write_csv(out)
}

/// Format with three files: the map of cross-validation errors, and the curves of the error against F_th (`<name>_f_th.svg`)
/// and against t_th (`<name>_t_th.svg`) through the suggested pair.
pub const SVG: FileFormat<MapWriter> = FileFormat {
    name: "Scalable vector graphics",
    ending: "svg",
    holds: "the map of errors, and the curves of the error against each threshold",
    write: MapWriter {
        files: |path| {
            let beside = [Along::F, Along::T].map(|along| beside(path, along));
            [vec![path.to_owned()], beside.to_vec()].concat()
        },
        write: |map, measure, path, files| {
            let suggestion = map.suggestion(measure).ok();
            let found = suggestion.as_ref();
            let at = found.map_or((0, 0), |found| found.at);
            let heat_map = threshold_heat_map(map, ScoreSet::LeftOut, measure, found);
            write_threshold_svg(&heat_map, path, files)?;
            [Along::F, Along::T].into_iter().try_for_each(|along| {
                let curve = threshold_curve(map, measure, along, at, found, &|_| color::SCORE);
                write_threshold_svg(&curve, &beside(path, along), files)
            })
        },
    },
};

fn beside(path: &Path, along: Along) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(match along {
        Along::F => "_f_th.svg",
        Along::T => "_t_th.svg",
    });
    path.with_file_name(name)
}

/// Unit in which the force threshold F_th is shown.
#[derive(Clone, Copy, Debug)]
pub struct ShownFTh {
    /// Factor by which a stored F_th is multiplied to obtain the shown number.
    pub factor: f64,
    pub unit: &'static str,
}

impl ShownFTh {
    pub fn of(distance: Distance) -> Self {
        let (factor, unit) = match distance {
            Distance::Force => (1.0, "N"),
            Distance::FullScale => (100.0, "% FS"),
        };
        Self { factor, unit }
    }

    /// Returns F_th in the shown unit, rounded to nine decimals so that the factor leaves no rounding error.
    pub fn number(self, f_th: f64) -> f64 {
        match self.factor {
            1.0 => f_th,
            factor => (f_th * factor * 1e9).round() / 1e9,
        }
    }

    /// Returns F_th with its unit.
    pub fn text(self, f_th: f64) -> String {
        format!("{} {}", self.number(f_th), self.unit)
    }

    pub fn label(self) -> String {
        format!("F_th [{}]", self.unit)
    }
}

const SIZE: (f64, f64) = (720.0, 440.0);
/// Margin above and below the curves, as a share of the range of their errors.
const ROOM: f64 = 0.06;
const T_TH_LABEL: &str = "t_th [s]";

fn rmse_label(map: &ThresholdMap, measure: Measure) -> String {
    format!("RMSE [{}]", measure.unit(&map.scale))
}

/// Returns a figure of the error against one threshold. The curves go through the pair at this row and column of the map. The
/// suggested threshold is marked, and the range of equally good thresholds is shaded. The cross-validation errors have a
/// solid line behind the other lines.
///
/// # Panics
/// If the map has no such row or column.
pub fn threshold_curve(
    map: &ThresholdMap,
    measure: Measure,
    along: Along,
    at: (usize, usize),
    suggestion: Option<&Suggestion>,
    ink: &dyn Fn(ScoreSet) -> [u8; 3],
) -> Figure<'static> {
    let shown = ShownFTh::of(map.distance);
    let Thresholds { f_th, t_th_secs } = map.thresholds(at.0, at.1);
    let (across, through, factor) = match along {
        Along::F => (shown.label(), format!("t_th {t_th_secs} s"), shown.factor),
        Along::T => {
            let through = format!("{} = {}", shown.label(), shown.number(f_th));
            (T_TH_LABEL.to_owned(), through, 1.0)
        }
    };
    let lines = ScoreSet::ALL.into_iter().rev().map(|set| {
        let points = map.curve(along, set, measure, at).into_iter();
        let points: Vec<[f64; 2]> = points.map(|(x, y)| [x * factor, y]).collect();
        let dash = match set {
            ScoreSet::Train => Some(figure::DOTTED),
            ScoreSet::Test => Some(figure::DASHED),
            ScoreSet::LeftOut => None,
        };
        Line { dash, ..Line::new(set.label(), ink(set), [points]) }
    });
    let lines: Vec<_> = lines.filter(|line| !line.pieces[0].is_empty()).collect();
    let numbers = |axis: usize| {
        let points = lines.iter().flat_map(|line| line.pieces[0].iter());
        points.map(move |point| point[axis])
    };
    let range = suggestion.map(|found| match along {
        Along::F => found.f_th_range,
        Along::T => found.t_th_range,
    });
    Figure {
        title: format!("{} at {through}", measure.label(&map.scale)),
        across: Scale::spanning(across, numbers(0), 0.0),
        up: Scale::spanning(rmse_label(map, measure), numbers(1), ROOM),
        shaded: range.map(|range| (range.from * factor, range.to * factor)),
        marked: suggestion.map(|found| along.of(found.thresholds) * factor),
        lines,
        ..Figure::default()
    }
}

/// Returns a heat map of the errors by one measure over both thresholds, with a mark at the suggested pair.
pub fn threshold_heat_map(
    map: &ThresholdMap,
    set: ScoreSet,
    measure: Measure,
    suggestion: Option<&Suggestion>,
) -> Figure<'static> {
    let shown = ShownFTh::of(map.distance);
    let f_ths = map.grid.f_ths.iter().map(|f_th| shown.number(*f_th));
    let f_ths: Vec<f64> = f_ths.collect();
    let values = map.values(set, measure);
    let shades = map.shades(set, measure).unwrap_or((0.0, 1.0));
    Figure {
        title: format!("{}, {}", measure.label(&map.scale), set.label()),
        across: Scale::of_cells(shown.label(), &f_ths),
        up: Scale::of_cells(T_TH_LABEL, &map.grid.t_ths_secs),
        heat_map: Some(HeatMap {
            shades: Scale::new(rmse_label(map, measure), shades),
            marked: suggestion.map(|found| found.at),
            values,
        }),
        ..Figure::default()
    }
}

/// Writes a figure as an SVG file, and adds the file to those in `files` that are saved together.
///
/// # Errors
/// [`WriteError`] if the file cannot be written.
pub fn write_threshold_svg(
    figure: &Figure<'_>,
    path: &Path,
    files: &mut Together,
) -> Result<(), WriteError> {
    files.write(path, |out| out.write_all(figure.svg(SIZE).as_bytes()))
}

#[cfg(test)]
mod tests {
    use crate::calibration::Scores;
    use crate::features::Distance;
    use crate::questions::thresholds::saved::*;
    use crate::questions::thresholds::study::PointScores;
    use crate::questions::thresholds::{MeasureScale, ThresholdGrid};
    use crate::recording::Axis;

    #[test]
    fn every_known_pair_and_set_has_a_row() {
        let point = |train: f64, cv: Option<f64>| PointScores {
            scores: Scores {
                train_rmse: Some(vec![train]),
                test_rmse: None,
                cv_rmse: cv.map(|cv| vec![cv]),
            },
            left_out_squares: Vec::new(),
        };
        let scale = MeasureScale { axes: vec![Axis::Fz], full_scale: vec![4.0] };
        let grid = ThresholdGrid::new(vec![0.0, 1.5], vec![2.0]).unwrap();
        let conventional = point(3.0, None);
        let mut map = ThresholdMap::new(grid, Distance::Force, scale, conventional, vec![5]);
        map.set_row(1, vec![point(1.0, Some(2.0))]);
        let mut out = Vec::new();
        write_threshold_csv(&map, &mut out).unwrap();
        assert_eq!(
            String::from_utf8(out).unwrap(),
            "f_th,t_th,set,Fz [N],forces [N],all axes [% FS]\n\
             ,,train,3,3,75\n1.5,2,train,1,1,25\n1.5,2,cross-validation,2,2,50\n"
        );
    }
}
