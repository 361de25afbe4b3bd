//! CSV file of a threshold map: one row for each pair of thresholds and each set of samples (train, test, cross-validation).

use std::io;

use super::MapWriter;
use crate::{
    export::FileFormat,
    features::Thresholds,
    questions::thresholds::{Along, Measure, ThresholdMap},
    report::{Cell, Column, Table},
    scoring::score_set::ScoreSet,
};

pub const FORMAT: FileFormat<MapWriter> = FileFormat {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::Scores;
    use crate::features::Distance;
    use crate::questions::thresholds::scorer::PointScores;
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
