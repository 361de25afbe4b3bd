use super::{plan::PosePlan, two_clocks::Table, warning::Cause};
use crate::{
    import::{
        assemble,
        error::ReadError,
        map::WeightMap,
        pose::{self, Pose},
    },
    min_max::MinMax,
    recording::{
        Axis, full_scale_of,
        kinetics::{Rotation, Weight},
    },
};

/// Share of full scale above which the load from the acceleration of the weight is reported.
const INERTIA_SHARE: f64 = 0.01;

/// Computes the reference loads of a known weight from the poses in the rows of a table. A table without poses is not
/// changed.
pub fn weigh(table: &mut Table, map: Option<&WeightMap>) -> Result<(), ReadError> {
    let (Some(map), Some(plan)) = (map, table.plan.pose.clone()) else {
        return Ok(());
    };
    let rotations = rotations(table, &plan, map);
    if rotations.is_empty() {
        let rows = std::mem::take(&mut table.rows);
        return Err(assemble::no_usable_row(&table.path, &table.plan, rows));
    }
    let weights = weights(table, &plan, map)?;
    let rows = &mut table.rows;
    let poses: Vec<Pose> = rotations
        .into_iter()
        .zip(rows.poses.chunks_exact(plan.width))
        .map(|(rotation, numbers)| Pose {
            rotation,
            position_m: match plan.position {
                Some(at) => [numbers[at], numbers[at + 1], numbers[at + 2]],
                None => [0.0; 3],
            },
        })
        .collect();
    let accelerations = pose::accelerations(&rows.times, &poses, &weights, map.smoothing_secs);
    let mut inertia = [0.0_f64; 6];
    let mut range = [MinMax::NONE; 6];
    rows.loads.clear();
    rows.loads.reserve_exact(6 * poses.len());
    for ((pose, weight), acceleration) in poses.iter().zip(&weights).zip(accelerations) {
        let at_rest = pose::load(pose, weight, map.gravity, [0.0; 3]);
        let moving = pose::load(pose, weight, map.gravity, acceleration);
        for axis in 0..6 {
            inertia[axis] = inertia[axis].max((moving[axis] - at_rest[axis]).abs());
            range[axis] = range[axis].with(at_rest[axis]);
        }
        rows.loads.extend(if map.inertia { moving } else { at_rest });
    }
    rows.poses = Vec::new();
    let share = |axis: usize| {
        let full_scale = full_scale_of(range[axis]);
        // If there is no load on an axis, its full scale is zero.
        if full_scale > 1e-9 { inertia[axis] / full_scale } else { 0.0 }
    };
    let worst = (0..6).max_by(|&a, &b| share(a).total_cmp(&share(b))).unwrap_or(0);
    if share(worst) > INERTIA_SHARE {
        let cause = Cause::Inertia {
            axis: Axis::ALL[worst],
            percent: 100.0 * share(worst),
            is_counted: map.inertia,
        };
        rows.findings.note(table.plan.line, cause);
    }
    table.plan.axes = Axis::ALL.to_vec();
    Ok(())
}

/// Returns the orientation of the sensor in each row. Rows whose numbers do not describe a rotation are removed.
pub fn rotations(table: &mut Table, plan: &PosePlan, map: &WeightMap) -> Vec<Rotation> {
    let rows = &mut table.rows;
    let n_turns = plan.attitude.parts().len();
    let all: Vec<Option<Rotation>> = rows
        .poses
        .chunks_exact(plan.width)
        .map(|numbers| pose::rotation(plan.attitude, map.angles, &numbers[..n_turns]))
        .collect();
    rows.leave_out(|row| all[row].is_some(), Cause::NotARotation);
    all.into_iter().flatten().collect()
}

/// Returns the weight that hangs from the sensor in each row. If the map lists several weights, the mount column or the name
/// of the file selects one.
fn weights(table: &Table, plan: &PosePlan, map: &WeightMap) -> Result<Vec<Weight>, ReadError> {
    let known = map.weights();
    let all = |weight: Weight| vec![weight; table.rows.times.len()];
    if let Some(at) = plan.mount {
        let numbers = table.rows.poses.chunks_exact(plan.width);
        return Ok(numbers.map(|numbers| known[numbers[at] as usize].1).collect());
    }
    if map.mounts.is_empty() {
        return Ok(all(known[0].1));
    }
    let stem = table.path.file_stem().unwrap_or_default().to_string_lossy();
    let named = (known.iter()).filter(|(name, _)| stem.contains(name.as_str()));
    let longest = named.clone().map(|(name, _)| name.len()).max();
    let mut named = named.filter(|(name, _)| Some(name.len()) == longest);
    match (named.next(), named.next()) {
        (Some((_, weight)), None) => Ok(all(*weight)),
        _ => Err(ReadError::NoMount {
            path: table.path.clone(),
            mounts: known.into_iter().map(|(name, _)| name).collect(),
        }),
    }
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

    const QUATERNION: [(&str, &str); 7] = [
        ("t_s", "time"),
        ("S1", "gauge"),
        ("w", "pose_qw"),
        ("x", "pose_qx"),
        ("y", "pose_qy"),
        ("z", "pose_qz"),
        ("kind", "mount"),
    ];

    /// The sensor is upright, then rolled by 90° until its y axis points up. A weight `W = m g` with its centre at (x, y, z) has
    /// the loads [Fx Fy Fz Mx My Mz] of (0, 0, −W, −yW, xW, 0) upright and of (0, −W, 0, zW, 0, −xW) rolled.
    #[test]
    fn the_load_of_a_known_weight_follows_from_the_pose() {
        let weight = r#"{ "mounts": [{ "name": "a", "mass_kg": 2, "centre_m": [0.02, 0.01, 0.03] },
            { "name": "b", "mass_kg": 1, "centre_m": [0, 0, 0] }] }"#;
        let map = map(&QUATERNION, weight);
        let text = "t_s,S1,w,x,y,z,kind\n0,1,1,0,0,0,a\n1,2,1,1,0,0,a\n2,3,1,0,0,0,b\n3,4,0,0,0,0,a\n4,5,1,0,0,0,c\n";
        let (loaded, messages) = load(text, &map).unwrap();
        let recording = &loaded.recordings[0];
        assert_eq!(recording.axes(), Axis::ALL);
        let w = 2.0 * STANDARD_GRAVITY;
        let expected = [
            [0.0, 0.0, -w, -0.01 * w, 0.02 * w, 0.0],
            [0.0, -w, 0.0, 0.03 * w, 0.0, -0.02 * w],
            [0.0, 0.0, -w / 2.0, 0.0, 0.0, 0.0],
        ];
        assert_eq!(recording.n_samples(), 3);
        for (actual, expected) in recording.loads().iter().zip(expected.as_flattened()) {
            assert!((actual - expected).abs() < 1e-12, "{:?}", recording.loads());
        }
        assert!(
            messages.contains("run.csv, line 5: the orientation in the pose is not a rotation"),
            "{messages}"
        );
        assert!(
            messages
                .contains("run.csv, line 6: column 7 (kind) contains \"c\", which is not listed"),
            "{messages}"
        );
    }

    /// A separate file gives robot states at 0 s and 10 s, level and rolled by 90°: (0, 0, −W) and (0, −W, 0), else between.
    #[test]
    fn the_pose_may_be_in_a_file_with_another_clock() {
        let mut map = map(&QUATERNION[..6], r#"{ "mass_kg": 1, "centre_m": [0, 0, 0] }"#);
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
    fn a_mount_is_chosen_by_the_name_of_the_file() {
        let weight = |name: &str| {
            format!(
                r#"{{ "mass_kg": 1, "mounts": [{{ "name": "{name}", "centre_m": [0, 0, 0] }}] }}"#
            )
        };
        let columns = &QUATERNION[..6];
        let text = "t_s,S1,w,x,y,z\n0,1,1,0,0,0\n1,2,0,1,0,0\n";
        let (loaded, _) = load(text, &map(columns, &weight("run"))).unwrap();
        assert_eq!(loaded.recordings[0].loads()[2], -STANDARD_GRAVITY);
        let error = load(text, &map(columns, &weight("left"))).unwrap_err().to_string();
        assert!(error.contains("listed under \"mounts\" in the column map (left)"), "{error}");
    }

    /// A sensor swings by sin(2π t) rad about x with a weight at 1 m. At the ends the weight's own acceleration is 4π² m/s²,
    /// four times gravity, and reported with and without `inertia`.
    #[test]
    fn the_acceleration_of_a_swung_weight_is_reported() {
        let columns = [
            ("t_s", "time"),
            ("S1", "gauge"),
            ("r [rad]", "pose_roll"),
            ("p", "pose_pitch"),
            ("y", "pose_yaw"),
        ];
        let mut text = "t_s,S1,r [rad],p,y\n".to_owned();
        for k in 0..300 {
            let t = f64::from(k) / 100.0;
            text.push_str(&format!("{t},{k},{},0,0\n", (std::f64::consts::TAU * t).sin()));
        }
        for (inertia, word) in [
            ("false", "is not part of the reference load"),
            ("true", "only as accurate as the pose"),
        ] {
            let weight = format!(
                r#"{{ "mass_kg": 1, "centre_m": [0, 0, 1], "smoothing_secs": 0.05, "inertia": {inertia} }}"#
            );
            let (_, messages) = load(&text, &map(&columns, &weight)).unwrap();
            assert!(
                messages.contains("the force that accelerates the weight")
                    && messages.contains(word),
                "{messages}"
            );
        }
    }

    #[test]
    fn an_incomplete_weight_is_refused_with_a_way_out() {
        let whole = r#"{ "mass_kg": 1, "centre_m": [0, 0, 0] }"#;
        let text = "t_s,S1,w,x,y,z\n0,1,1,0,0,0\n1,2,0,1,0,0\n";
        let message = |map: &ColumnMap| load(text, map).unwrap_err().to_string();
        assert!(message(&map(&QUATERNION[..6], "{}")).contains("mass_kg or centre_m is missing"));
        let mut both = map(&QUATERNION[..6], whole);
        both.table.columns[1].is = ColumnRole::Load(Axis::Fz);
        assert!(message(&both).contains("but a column with the role Fz"));
        let mut part = map(&QUATERNION[..6], whole);
        part.table.columns.pop();
        assert!(message(&part).contains("one whole orientation"));
        let file = TestFile::new(text);
        let alone = map(&QUATERNION[..6], whole);
        let error = estimate_weight(&file.path, Some(&alone), &Progress::default()).unwrap_err();
        assert!(error.to_string().contains("needs the pose of the sensor and measured forces"));
    }
}
