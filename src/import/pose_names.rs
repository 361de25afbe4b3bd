//! Names by which robots and their tools call the parts of a pose.

use super::map::PosePart;
use crate::formats::column_name::ColumnName;

/// Endings of names of poses, in lower case and with `_` between words, with the part of the pose and its unit if the name says
/// it.
const PARTS: [(&str, PosePart, Option<&str>); 19] = {
    use PosePart::{Pitch, Qw, Qx, Qy, Qz, Roll, Rx, Ry, Rz, X, Y, Yaw, Z};
    [
        ("qw", Qw, None),
        ("qx", Qx, None),
        ("qy", Qy, None),
        ("qz", Qz, None),
        ("roll", Roll, None),
        ("pitch", Pitch, None),
        ("yaw", Yaw, None),
        ("rx", Rx, None),
        ("ry", Ry, None),
        ("rz", Rz, None),
        // The controllers of UR number the parts of the pose.
        ("tcp_pose_0", X, Some("m")),
        ("tcp_pose_1", Y, Some("m")),
        ("tcp_pose_2", Z, Some("m")),
        ("tcp_pose_3", Rx, Some("rad")),
        ("tcp_pose_4", Ry, Some("rad")),
        ("tcp_pose_5", Rz, Some("rad")),
        // KUKA turns by A about z, then by B about y, then by C about x.
        ("a", Yaw, Some("deg")),
        ("b", Pitch, Some("deg")),
        ("c", Roll, Some("deg")),
    ]
};

/// Words that make the letters x, y, z, w parts of an orientation, and those that make x, y, z parts of a position.
const ORIENTATIONS: [&str; 6] = ["orientation", "quaternion", "quat", "rotation", "ori", "q"];
const POSITIONS: [&str; 8] =
    ["position", "translation", "pos", "pose", "tcp", "p", "tool", "location"];
/// Words of names that hold the speed of a pose, its target, or another quantity.
const OTHERS: [&str; 16] = [
    "velocity",
    "vel",
    "speed",
    "twist",
    "acceleration",
    "acc",
    "accel",
    "angular",
    "linear",
    "target",
    "goal",
    "desired",
    "force",
    "torque",
    "gyro",
    "magnet",
];

/// Returns the part of a pose that a column with this name holds, and its unit if the name says it.
pub fn pose_part(name: &ColumnName) -> Option<(PosePart, Option<&'static str>)> {
    use PosePart::{Qw, Qx, Qy, Qz, X, Y, Z};
    if name.kind.is_some() || name.name.len() > 64 {
        return None;
    }
    let plain = name.name.to_lowercase().replace(['.', '/', ' ', '-', '[', ']'], "_");
    let plain = plain.trim_matches('_').replace("__", "_");
    let words: Vec<&str> = plain.split('_').filter(|word| !word.is_empty()).collect();
    if words.iter().any(|word| OTHERS.contains(word)) {
        return None;
    }
    let (last, before) = words.split_last()?;
    let has = |list: &[&str]| before.iter().any(|word| list.contains(word));
    let letters = ["x", "y", "z", "w"];
    if let Some(at) = letters.iter().position(|letter| letter == last) {
        if has(&ORIENTATIONS) {
            return Some(([Qx, Qy, Qz, Qw][at], None));
        }
        let is_position = before.is_empty() || has(&POSITIONS);
        return [X, Y, Z].get(at).filter(|_| is_position).map(|part| (*part, None));
    }
    let found = PARTS.iter().find(|(ending, ..)| {
        let is_alone = plain == *ending;
        let is_ending = ending.len() > 1
            && plain.strip_suffix(ending).is_some_and(|start| start.ends_with('_'));
        is_alone || is_ending
    });
    found.map(|(_, part, unit)| (*part, *unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_robots_give_the_parts_of_a_pose() {
        use PosePart::{Pitch, Qw, Qx, Roll, Rx, X, Y, Yaw};
        for (names, part) in [
            ("qw|pose.orientation.w|/tool/pose/orientation/w|quat_w|q_w|pose_qw", Qw),
            ("qx|field.pose.orientation.x|quaternion_x|ee_qx", Qx),
            ("roll|Roll [deg]|tcp_roll|C", Roll),
            ("pitch|B", Pitch),
            ("yaw|A|pose_yaw", Yaw),
            ("rx|Rx [rad]|actual_TCP_pose_3|tcp_rx", Rx),
            ("x|pose.position.x|actual_TCP_pose_0|tcp_x|X [mm]", X),
            ("pos_y", Y),
        ] {
            for name in names.split('|') {
                let found = pose_part(&ColumnName::parse(name)).map(|(part, _)| part);
                assert_eq!(found, Some(part), "{name}");
            }
        }
        for name in
            "S1|target_qw|actual_TCP_speed_3|imu.angular_velocity.x|Fx|accel_x|voltage|d".split('|')
        {
            assert_eq!(pose_part(&ColumnName::parse(name)), None, "{name}");
        }
    }
}
