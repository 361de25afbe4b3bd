//! CSV file of a threshold map: one row for each pair of thresholds and each set of samples (train, test, cross-validation).

use std::io;

use super::MapWriter;
use crate::{
    calibration::Scores,
    export::FileFormat,
    formats::csv::CsvWriter,
    questions::thresholds::{Measure, ThresholdMap},
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
    let mut csv = CsvWriter::new(out);
    let groups: Vec<Measure> = (map.scale.measures().into_iter())
        .filter(|measure| !matches!(measure, Measure::Axis(_)))
        .collect();
    let mut head = ["f_th", "t_th", "set"].map(str::to_owned).to_vec();
    let axes = map.scale.axes.iter();
    head.extend(axes.map(|axis| axis.label()));
    head.extend(groups.iter().map(|group| {
        let (label, unit) = (group.label(&map.scale), group.unit(&map.scale));
        format!("{label} [{unit}]")
    }));
    csv.row(&head)?;
    let mut write = |thresholds: [String; 2], scores: &Scores| -> io::Result<()> {
        for set in ScoreSet::ALL {
            let Some(rmse) = set.rmse(scores) else {
                continue;
            };
            let mut record = thresholds.to_vec();
            record.push(set.label().to_owned());
            record.extend(rmse.iter().map(f64::to_string));
            record.extend(groups.iter().map(|group| {
                let value = group.of_rmse(&map.scale, rmse);
                value.map_or_else(String::new, |value| value.to_string())
            }));
            csv.row(&record)?;
        }
        Ok(())
    };
    write([String::new(), String::new()], &map.conventional.scores)?;
    for f_at in 0..map.grid.f_ths.len() {
        for t_at in 0..map.grid.t_ths_secs.len() {
            if let Some(point) = map.point(f_at, t_at) {
                let at = map.thresholds(f_at, t_at);
                write([at.f_th.to_string(), at.t_th_secs.to_string()], &point.scores)?;
            }
        }
    }
    csv.flush()
}

#[cfg(test)]
mod tests {
    use super::*;
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
