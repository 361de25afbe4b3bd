//! Distances between drawings in pixels, for tests of reduced drawings.

/// Returns the distance from a point to the nearest of these line segments, in pixels.
pub fn distance(place: [f64; 2], steps: &[[[f64; 2]; 2]]) -> f64 {
    let from = |[a, b]: &[[f64; 2]; 2]| {
        let way = [b[0] - a[0], b[1] - a[1]];
        let off = [place[0] - a[0], place[1] - a[1]];
        let square = way[0] * way[0] + way[1] * way[1];
        let share = (off[0] * way[0] + off[1] * way[1]) / square.max(f64::MIN_POSITIVE);
        let share = share.clamp(0.0, 1.0);
        (off[0] - share * way[0]).hypot(off[1] - share * way[1])
    };
    steps.iter().map(from).fold(f64::INFINITY, f64::min)
}

/// Returns the largest distance from a point of one polyline to the other polyline, in pixels. Both have rising x.
pub fn farthest(of: &[[f64; 2]], to: &[[f64; 2]]) -> f64 {
    let mut worst = 0.0_f64;
    for step in of.windows(2) {
        let length = (step[1][0] - step[0][0]).hypot(step[1][1] - step[0][1]);
        let n = (2.0 * length).ceil().max(1.0);
        for k in 0..=n as usize {
            let share = k as f64 / n;
            let place = [0, 1].map(|i| step[0][i] + share * (step[1][i] - step[0][i]));
            // Only segments within two pixels of the point horizontally are tried.
            let first = to.partition_point(|other| other[0] < place[0] - 2.0).saturating_sub(1);
            let end = (to.partition_point(|other| other[0] <= place[0] + 2.0) + 1).min(to.len());
            let near: Vec<_> = to[first..end].windows(2).map(|w| [w[0], w[1]]).collect();
            worst = worst.max(distance(place, &near));
        }
    }
    worst
}
