//! Loads of a known weight, from the orientation of the sensor in each row.

use super::{two_clocks::Table, warning::Cause};
use crate::{
    import::{
        assemble,
        error::ReadError,
        map::{Attitude, WeightMap},
        pose,
    },
    recording::{
        Axis,
        kinetics::{Rotation, load_of_pull},
    },
};

/// Computes the reference loads of a known weight from the poses in the rows of a table. A table without poses is not
/// changed.
pub fn weigh(table: &mut Table, map: Option<&WeightMap>) -> Result<(), ReadError> {
    let of_map = map.and_then(|map| Some((map, map.weight()?)));
    let (Some((map, weight)), Some(attitude)) = (of_map, table.plan.attitude) else {
        return Ok(());
    };
    let rotations = rotations(table, attitude, map);
    let rows = &mut table.rows;
    if rotations.is_empty() {
        let rows = std::mem::take(rows);
        return Err(assemble::no_usable_row(&table.path, &table.plan, rows));
    }
    rows.poses = Vec::new();
    let load = |rotation: &Rotation| load_of_pull(rotation, &weight, map.gravity);
    rows.loads = rotations.iter().flat_map(load).collect();
    table.plan.axes = Axis::ALL.to_vec();
    Ok(())
}

/// Returns the orientation of the sensor in each row. Rows whose numbers do not describe a rotation are removed.
pub fn rotations(table: &mut Table, attitude: Attitude, map: &WeightMap) -> Vec<Rotation> {
    let rows = &mut table.rows;
    let numbers = rows.poses.chunks_exact(attitude.parts().len());
    let all: Vec<Option<Rotation>> =
        numbers.map(|numbers| pose::rotation(attitude, map.angles, numbers)).collect();
    rows.leave_out(|row| all[row].is_some(), Cause::NotARotation);
    all.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::TestFile;
    use super::*;
    use crate::import::estimate::estimate_weight;
    use crate::import::load::Loaded;
    use crate::import::map::{ColumnMap, ColumnRole, ReferenceFile};
    use crate::import::read::read;
    use crate::progress::Progress;
    use crate::recording::kinetics::STANDARD_GRAVITY;

    fn map(columns: &[(&str, &str)], weight: &str) -> ColumnMap {
        let rule = |(name, is): &(&str, &str)| format!(r#"{{ "column": "{name}", "is": "{is}" }}"#);
        let rules: Vec<String> = columns.iter().map(rule).collect();
        let json = format!(
            r#"{{ "format": "loopscope column map", "version": 1, "table": {{ "shape": {{ "columns": {} }},
                "text": {{ "header": true }}, "columns": [{}] }}, "weight": {weight} }}"#,
            columns.len(),
            rules.join(", ")
        );
        ColumnMap::from_json(json.as_bytes()).unwrap()
    }

    fn load(text: &str, map: &ColumnMap) -> Result<(Loaded, String), ReadError> {
        let file = TestFile::new(text);
        let loaded = read(&file.path, Some(map), &[], &Progress::default())?;
        let messages: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
        Ok((loaded, messages.join("\n")))
    }

    const QUATERNION: [(&str, &str); 6] = [
        ("t_s", "time"),
        ("S1", "gauge"),
        ("w", "pose_qw"),
        ("x", "pose_qx"),
        ("y", "pose_qy"),
        ("z", "pose_qz"),
    ];

    /// The sensor is upright, then rolled by 90° until its y axis points up. A weight `W = m g` with its centre at (x, y, z) has
    /// the loads [Fx Fy Fz Mx My Mz] of (0, 0, −W, −yW, xW, 0) upright and of (0, −W, 0, zW, 0, −xW) rolled.
    #[test]
    fn the_load_of_a_known_weight_follows_from_the_pose() {
        let map = map(&QUATERNION, r#"{ "mass_kg": 2, "centre_m": [0.02, 0.01, 0.03] }"#);
        let text = "t_s,S1,w,x,y,z\n0,1,1,0,0,0\n1,2,1,1,0,0\n3,4,0,0,0,0\n";
        let (loaded, messages) = load(text, &map).unwrap();
        let recording = &loaded.recordings[0];
        assert_eq!(recording.axes(), Axis::ALL);
        let w = 2.0 * STANDARD_GRAVITY;
        let expected =
            [[0.0, 0.0, -w, -0.01 * w, 0.02 * w, 0.0], [0.0, -w, 0.0, 0.03 * w, 0.0, -0.02 * w]];
        assert_eq!(recording.n_samples(), 2);
        for (actual, expected) in recording.loads().iter().zip(expected.as_flattened()) {
            assert!((actual - expected).abs() < 1e-12, "{:?}", recording.loads());
        }
        assert!(
            messages.contains("run.csv, line 4: the orientation in the pose is not a rotation"),
            "{messages}"
        );
    }

    /// A separate file gives robot states at 0 s and 10 s, level and rolled by 90°: (0, 0, −W) and (0, −W, 0), else between.
    #[test]
    fn the_pose_may_be_in_a_file_with_another_clock() {
        let mut map = map(&QUATERNION, r#"{ "mass_kg": 1, "centre_m": [0, 0, 0] }"#);
        let mut states = map.table.clone();
        states.columns.retain(|rule| rule.is != ColumnRole::Gauge);
        map.table.columns.truncate(2);
        map.reference = Some(ReferenceFile { file: "states.csv".to_owned(), table: states });
        let file = TestFile::new("t_s,S1,w,x,y,z\n0,1,,,,\n5,2,,,,\n10,3,,,,\n");
        let text = "t_s,S1,w,x,y,z\n0,,1,0,0,0\n10,,1,1,0,0\n";
        std::fs::write(file.path.with_file_name("states.csv"), text).unwrap();
        let loaded = read(&file.path, Some(&map), &[], &Progress::default()).unwrap();
        let loads = loaded.recordings[0].loads();
        let half = STANDARD_GRAVITY / 2.0;
        for (sample, force) in
            [(0, [0.0, -2.0 * half]), (1, [-half, -half]), (2, [-2.0 * half, 0.0])]
        {
            for axis in 0..2 {
                assert!((loads[6 * sample + 1 + axis] - force[axis]).abs() < 1e-12, "{loads:?}");
            }
        }
    }

    #[test]
    fn an_incomplete_weight_is_refused_with_a_way_out() {
        let whole = r#"{ "mass_kg": 1, "centre_m": [0, 0, 0] }"#;
        let text = "t_s,S1,w,x,y,z\n0,1,1,0,0,0\n1,2,0,1,0,0\n";
        let message = |map: &ColumnMap| load(text, map).unwrap_err().to_string();
        assert!(message(&map(&QUATERNION, "{}")).contains("mass_kg and centre_m"));
        let mut both = map(&QUATERNION, whole);
        both.table.columns[1].is = ColumnRole::Load(Axis::Fz);
        assert!(message(&both).contains("but a column with the role Fz"));
        let mut part = map(&QUATERNION, whole);
        part.table.columns.pop();
        assert!(message(&part).contains("one whole orientation"));
        let file = TestFile::new(text);
        let alone = map(&QUATERNION, whole);
        let error = estimate_weight(&file.path, Some(&alone), &Progress::default()).unwrap_err();
        assert!(error.to_string().contains("needs the pose of the sensor and measured forces"));
    }
}
