//! Reduces plotted paths, such as hysteresis loops, to points that can be drawn fast. If the points are too many, it draws
//! their density.
//!
//! Guarantees: no drawn point is farther than a pixel from the measured path, and no measured sample is farther than a pixel
//! from the drawing. The number of drawn points is limited by the width and height in pixels, not by the number of samples.

/// Number of grid cells per pixel in each direction. With this number, a cell's diagonal plus the distance [`REACH`] of
/// skipped samples is below a pixel.
const CELLS_PER_PIXEL: f64 = 2.0;
/// Distance from the last kept sample within which samples are skipped, in cells.
const REACH: f64 = 0.4;
/// Mean number of lines over each touched pixel, above which the density is drawn instead of lines. One line more would no
/// longer be visible.
const MAX_PASSES: f64 = 4.0;
/// Maximum number of grid cells in each direction, which limits the memory.
const MAX_CELLS: f64 = 16_384.0;

/// Rectangle of loads (horizontal) and outputs (vertical) that a plot shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Minimum and maximum load.
    pub loads: (f64, f64),
    /// Minimum and maximum output.
    pub outputs: (f64, f64),
}

/// Part of a branch, in which the load rises or falls, as points `[load, output]`.
#[derive(Debug)]
pub struct Stroke {
    pub rising: bool,
    /// Points `[load, output]` in the order of time.
    pub points: Vec<[f64; 2]>,
}

/// Density of paths: number of samples in each cell of half a pixel, on a logarithmic scale.
#[derive(Debug, PartialEq)]
pub struct Density {
    /// Rectangle that the cells cover.
    pub frame: Frame,
    /// Number of cells horizontally and vertically.
    pub cells: [usize; 2],
    /// Density level of each cell, row by row from the minimum output up. Level 0 means that no path touches the cell, 1 that
    /// a path crosses it between samples. Level 2 means one sample, 3 two or three samples, and so on with each doubling.
    pub levels: Vec<u8>,
}

/// Drawing of paths, reduced to lines with few points or to a density.
#[derive(Debug, PartialEq)]
pub enum Outline {
    /// Paths as lines.
    Lines(Vec<Vec<[f64; 2]>>),
    /// Density of the paths, if the lines are too many.
    Density(Density),
}

/// Returns the reduced drawing of paths in `frame`, on a plot with this width and height in pixels.
///
/// A path is straight between samples, ends at values that are not finite, and is clipped at the frame. Samples within a fifth
/// of a pixel of the last kept sample are skipped. The result is a density if there are more samples than touched pixels and
/// several lines cross each pixel. It is also a density if more than `most` points remain, because drawing them would be slow.
pub fn outline<P: IntoIterator<Item = [f64; 2]>>(
    paths: impl IntoIterator<Item = P>,
    frame: Frame,
    pixels: [f64; 2],
    most: usize,
) -> Outline {
    let grid = Grid::of(frame, pixels);
    let n = grid.cells.map(|cells| cells as usize);
    let mut drawn = Drawn {
        raster: Raster::new(n),
        counts: vec![0; n[0] * n[1]],
        all: Lines::default(),
        length: 0.0,
        grid,
        most,
    };
    for path in paths {
        drawn.add(path);
    }
    if drawn.all.n_points <= most && !drawn.hides_itself() {
        Outline::Lines(drawn.all.lines)
    } else {
        Outline::Density(drawn.density(frame))
    }
}

#[derive(Clone, Copy, Debug)]
struct Grid {
    low: [f64; 2],
    size: [f64; 2],
    /// Number of grid cells in each direction, a whole number.
    cells: [f64; 2],
}

impl Grid {
    fn of(frame: Frame, pixels: [f64; 2]) -> Self {
        let cells = pixels.map(|pixels| (CELLS_PER_PIXEL * pixels).ceil().clamp(1.0, MAX_CELLS));
        let ranges = [frame.loads, frame.outputs];
        Self {
            low: ranges.map(|(low, _)| low),
            size: [0, 1].map(|i| (ranges[i].1 - ranges[i].0) / cells[i]),
            cells,
        }
    }

    fn cell_of(&self, point: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| (point[i] - self.low[i]) / self.size[i])
    }

    fn point_at(&self, cell: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| self.low[i] + cell[i] * self.size[i])
    }
}

/// Returns the start and the end of the part of a line that lies between the lowest and the highest corner of a rectangle, as
/// shares of the line, by Liang and Barsky (1984); `None` if the line is outside.
pub fn inside([low, high]: [[f64; 2]; 2], from: [f64; 2], to: [f64; 2]) -> Option<(f64, f64)> {
    let (mut start, mut end) = (0.0_f64, 1.0_f64);
    for i in [0, 1] {
        let way = to[i] - from[i];
        if way != 0.0 {
            let shares = [low[i], high[i]].map(|limit| (limit - from[i]) / way);
            start = start.max(shares[0].min(shares[1]));
            end = end.min(shares[0].max(shares[1]));
        } else if !(low[i]..=high[i]).contains(&from[i]) {
            return None;
        }
    }
    (start <= end).then_some((start, end))
}

/// Sample and its position on the plot in cells.
#[derive(Clone, Copy, Debug)]
struct Place {
    point: [f64; 2],
    cell: [f64; 2],
}

impl Place {
    fn is_near(&self, other: &Self) -> bool {
        (0..2).all(|i| (other.cell[i] - self.cell[i]).abs() <= REACH)
    }

    /// Returns the place on the straight line to the other sample, at this share of the distance.
    fn towards(&self, other: &Self, share: f64) -> Self {
        let between = |a: [f64; 2], b: [f64; 2]| [0, 1].map(|i| a[i] + share * (b[i] - a[i]));
        match share {
            0.0 => *self,
            1.0 => *other,
            _ => Self {
                point: between(self.point, other.point),
                cell: between(self.cell, other.cell),
            },
        }
    }
}

/// Lines of a drawing, to which steps between samples are added.
#[derive(Debug, Default)]
struct Lines {
    lines: Vec<Vec<[f64; 2]>>,
    n_points: usize,
    /// True if the next step may continue the last line.
    open: bool,
}

impl Lines {
    fn step(&mut self, from: [f64; 2], to: [f64; 2]) {
        match self.lines.last_mut() {
            Some(line) if self.open && line.last() == Some(&from) => {
                line.push(to);
                self.n_points += 1;
            }
            _ => {
                self.lines.push(vec![from, to]);
                self.n_points += 2;
            }
        }
        self.open = true;
    }
}

/// Drawing of the steps between samples that have been added so far.
#[derive(Debug)]
struct Drawn {
    grid: Grid,
    raster: Raster,
    /// Number of samples in each cell, limited to the largest `u16`.
    counts: Vec<u16>,
    /// Lines of all steps so far, unless their points are too many.
    all: Lines,
    /// Total length of all steps so far, in pixels.
    length: f64,
    most: usize,
}

impl Drawn {
    fn add(&mut self, path: impl IntoIterator<Item = [f64; 2]>) {
        self.all.open = false;
        // `kept` is the last sample that was drawn, with true if a step led to it. `passed` is the last skipped sample after
        // it.
        let mut kept: Option<(Place, bool)> = None;
        let mut passed: Option<Place> = None;
        for point in path {
            let cell = self.grid.cell_of(point);
            if !cell.iter().all(|value| value.is_finite()) {
                self.end(kept.take(), passed.take());
                continue;
            }
            self.count(cell);
            let place = Place { point, cell };
            match kept {
                Some((last, _)) if last.is_near(&place) => passed = Some(place),
                Some((last, _)) => {
                    self.step(&last, &place);
                    (kept, passed) = (Some((place, true)), None);
                }
                None => kept = Some((place, false)),
            }
        }
        self.end(kept, passed);
    }

    fn count(&mut self, cell: [f64; 2]) {
        let [across, up] = self.grid.cells;
        let inside = |at: f64, n: f64| (0.0..=n).contains(&at).then_some(at.min(n - 1.0) as usize);
        if let (Some(column), Some(row)) = (inside(cell[0], across), inside(cell[1], up)) {
            let count = &mut self.counts[row * across as usize + column];
            *count = count.saturating_add(1);
        }
    }

    /// Draws the step to the last sample of a path. A path that stays within a fraction of a pixel becomes a dash of one
    /// pixel.
    fn end(&mut self, kept: Option<(Place, bool)>, passed: Option<Place>) {
        match (kept, passed) {
            (Some((last, true)), Some(end)) => self.step(&last, &end),
            (Some((still, false)), _) => {
                let half = 0.5 * CELLS_PER_PIXEL;
                let [across, up] = still.cell;
                let [from, to] = [across - half, across + half].map(|across| Place {
                    point: self.grid.point_at([across, up]),
                    cell: [across, up],
                });
                self.step(&from, &to);
            }
            _ => {}
        }
        self.all.open = false;
    }

    fn step(&mut self, from: &Place, to: &Place) {
        let Some((start, end)) = inside([[0.0; 2], self.grid.cells], from.cell, to.cell) else {
            self.all.open = false;
            return;
        };
        let [from, to] = [start, end].map(|share| from.towards(to, share));
        if self.all.n_points <= self.most {
            self.all.step(from.point, to.point);
        }
        let way = [0, 1].map(|i| (to.cell[i] - from.cell[i]).abs());
        self.length += way[0].max(way[1]) / CELLS_PER_PIXEL;
        self.raster.touch(from.cell, to.cell);
    }

    /// Returns true if the lines hide each other: there are more points than touched pixels, and too many lines over each
    /// pixel.
    fn hides_itself(&self) -> bool {
        let n_pixels = self.raster.n_touched_squares();
        self.all.n_points > n_pixels && self.length > MAX_PASSES * n_pixels as f64
    }

    fn density(self, frame: Frame) -> Density {
        let cells = self.grid.cells.map(|cells| cells as usize);
        let level = |(at, count): (usize, u16)| match count.checked_ilog2() {
            Some(doublings) => doublings as u8 + 2,
            None => u8::from(self.raster.is_touched([at % cells[0], at / cells[0]])),
        };
        Density {
            frame,
            cells,
            levels: self.counts.iter().copied().enumerate().map(level).collect(),
        }
    }
}

impl Density {
    /// Returns the centres `[load, output]` of the touched cells with their density levels.
    pub fn touched(&self) -> impl Iterator<Item = ([f64; 2], u8)> {
        let Frame { loads, outputs } = self.frame;
        let [across, up] = self.cells;
        let middle = move |(low, high): (f64, f64), at: usize, n: usize| {
            low + (high - low) * (at as f64 + 0.5) / n as f64
        };
        let levels = self.levels.iter().copied().enumerate();
        levels.filter(|(_, level)| *level > 0).map(move |(at, level)| {
            let place = [middle(loads, at % across, across), middle(outputs, at / across, up)];
            (place, level)
        })
    }
}

/// Number of cells along each side of a block, and of blocks along each side of a larger block. The cells of a block fit into
/// the bits of one word.
const SIDE: usize = 8;
const LEVELS: usize = 4;

/// Cells of a plot that lines have touched so far.
#[derive(Debug)]
pub struct Raster {
    /// Levels of the grid: cells, blocks of cells, blocks of blocks, and so on.
    levels: [Level; LEVELS],
    /// Number of squares of 2 × 2 cells beyond the plot. They count as touched, so that blocks at the edge can become full.
    n_beyond: usize,
}

/// Level of the grid: one bit for each cell or block of this level, and one word for each block of the next level.
#[derive(Debug)]
struct Level {
    /// Number of cells or blocks horizontally and vertically.
    n: [usize; 2],
    words: Vec<u64>,
}

impl Level {
    pub(crate) fn new(n: [usize; 2]) -> Self {
        let [across, up] = n.map(|n| n.div_ceil(SIDE));
        let mut level = Self { n, words: vec![0; across * up] };
        // Cells beyond the plot count as touched, so that blocks at the edge can become full.
        for y in 0..up * SIDE {
            for x in 0..across * SIDE {
                if x >= n[0] || y >= n[1] {
                    level.set([x, y]);
                }
            }
        }
        level
    }

    fn place(&self, [x, y]: [usize; 2]) -> (usize, u64) {
        let word = y / SIDE * self.n[0].div_ceil(SIDE) + x / SIDE;
        (word, 1 << (y % SIDE * SIDE + x % SIDE))
    }

    fn has(&self, at: [usize; 2]) -> bool {
        let (word, bit) = self.place(at);
        self.words[word] & bit != 0
    }

    /// Sets the bit of a cell or block. Returns true if all bits in its word are set now.
    fn set(&mut self, at: [usize; 2]) -> bool {
        let (word, bit) = self.place(at);
        self.words[word] |= bit;
        self.words[word] == u64::MAX
    }
}

#[derive(Clone, Copy, Debug)]
struct Step {
    from: [f64; 2],
    way: [f64; 2],
}

impl Raster {
    pub fn new(n: [usize; 2]) -> Self {
        let of = |level: usize| Level::new(n.map(|n| n.div_ceil(SIDE.pow(level as u32))));
        let mut raster = Self { levels: std::array::from_fn(of), n_beyond: 0 };
        raster.n_beyond = raster.n_touched_squares();
        raster
    }

    /// Marks every cell between two points of the plot as touched.
    pub fn touch(&mut self, from: [f64; 2], to: [f64; 2]) {
        let way = [0, 1].map(|i| to[i] - from[i]);
        let all = self.levels[LEVELS - 1].n.map(|n| (0, n - 1));
        self.walk(LEVELS - 1, all, Step { from, way }, (0.0, 1.0));
    }

    pub fn is_touched(&self, cell: [usize; 2]) -> bool {
        self.levels[0].has(cell)
    }

    /// Returns the number of squares of 2 × 2 cells in which a cell is touched.
    pub fn n_touched_squares(&self) -> usize {
        // The bits of a block are stored row by row. First two rows are combined, then two columns.
        let squares = self.levels[0].words.iter().map(|word| {
            let rows = word | word >> SIDE;
            ((rows | rows >> 1) & 0x0055_0055_0055_0055).count_ones() as usize
        });
        squares.sum::<usize>() - self.n_beyond
    }

    /// Marks all blocks of a level that a part of a line touches. `limits` are the indices of the first and last block,
    /// horizontally and vertically. The last argument is the start and end of the part, as shares of the line.
    fn walk(
        &mut self,
        level: usize,
        limits: [(usize, usize); 2],
        step: Step,
        (mut share, end): (f64, f64),
    ) {
        let size = SIDE.pow(level as u32) as f64;
        let mut at = [0, 1].map(|i| {
            let block = ((step.from[i] + share * step.way[i]) / size).max(0.0) as usize;
            block.clamp(limits[i].0, limits[i].1)
        });
        loop {
            let leaves = [0, 1].map(|i| {
                let edge = size * (at[i] + usize::from(step.way[i] > 0.0)) as f64;
                match step.way[i] {
                    0.0 => f64::INFINITY,
                    way => (edge - step.from[i]) / way,
                }
            });
            let first = usize::from(leaves[1] < leaves[0]);
            let next = leaves[first].clamp(share, end);
            self.touch_block(level, at, step, (share, next));
            if leaves[first] >= end {
                return;
            }
            let (low, high) = limits[first];
            let forward = step.way[first] > 0.0;
            match at[first] {
                last if last == if forward { high } else { low } => return,
                _ if forward => at[first] += 1,
                _ => at[first] -= 1,
            }
            share = next;
        }
    }

    fn touch_block(&mut self, level: usize, at: [usize; 2], step: Step, shares: (f64, f64)) {
        if self.levels[level].has(at) {
            return;
        }
        if level > 0 {
            let below = self.levels[level - 1].n;
            let limits = [0, 1].map(|i| (SIDE * at[i], (SIDE * at[i] + SIDE).min(below[i]) - 1));
            return self.walk(level - 1, limits, step, shares);
        }
        let mut filled = at;
        for level in &mut self.levels {
            if !level.set(filled) {
                break;
            }
            filled = filled.map(|at| at / SIDE);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scoring::pixels::distance;

    const FRAME: Frame = Frame { loads: (-1.0, 1.0), outputs: (-2.0, 2.0) };
    const PIXELS: [f64; 2] = [60.0, 40.0];

    /// Reproducible pseudo-random numbers in ±1.
    fn uniform(k: usize) -> f64 {
        let mixed = (k as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        (mixed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn path(n: usize, point: impl Fn(usize) -> [f64; 2]) -> Vec<[f64; 2]> {
        (0..n).map(point).collect()
    }

    fn kinds() -> Vec<(&'static str, Vec<Vec<[f64; 2]>>)> {
        let wave = |k: usize| (k as f64 * 0.01).sin();
        let walk = |seed: usize| {
            let steps = (0..3000).scan([0.0_f64; 2], move |at, k| {
                *at = [0, 1].map(|i| (at[i] + 0.06 * uniform(seed + 2 * k + i)).clamp(-1.0, 1.0));
                Some(*at)
            });
            steps.collect::<Vec<_>>()
        };
        let gaps = path(2000, |k| match k % 97 {
            0 => [f64::NAN, 0.0],
            1 => [0.0, f64::INFINITY],
            _ => [wave(k), 1.5 * uniform(k)],
        });
        vec![
            ("nothing", vec![vec![], vec![[f64::NAN; 2]]]),
            ("one sample", vec![vec![[0.3, 0.7]]]),
            ("two samples", vec![vec![[-0.9, -1.0], [0.8, 1.3]]]),
            ("constant", vec![vec![[0.5, -0.5]; 3000]]),
            ("noise", vec![path(3000, |k| [uniform(2 * k), 2.0 * uniform(2 * k + 1)])]),
            ("noise over a wave", vec![path(3000, |k| [wave(k), 0.6 * uniform(k)])]),
            ("noise that pulls", vec![path(3000, |k| [wave(k).max(0.0), uniform(k).abs()])]),
            (
                "steps",
                vec![path(3000, |k| [(k / 500) as f64 * 0.2 - 0.5, (k / 300) as f64 * 0.3 - 1.4])],
            ),
            ("random walks", vec![walk(0), walk(10_000)]),
            ("gaps", vec![gaps]),
            (
                "circles",
                (0..4)
                    .map(|at| {
                        path(800, move |k| {
                            let angle = k as f64 * std::f64::consts::TAU / 799.0;
                            [0.9 * angle.sin(), (1.9 - 0.01 * f64::from(at)) * angle.cos()]
                        })
                    })
                    .collect(),
            ),
            (
                "twice the frame",
                vec![path(2000, |k| [2.0 * uniform(2 * k), 4.0 * uniform(2 * k + 1)])],
            ),
            ("far outside", vec![vec![[-1e9, -2e9], [1e9, 2e9], [3.0, 3.0], [f64::MAX, f64::MIN]]]),
        ]
    }

    /// Returns the steps of paths in pixels, cut at values that are not finite. A single sample is a step of length zero.
    fn steps(paths: &[Vec<[f64; 2]>]) -> Vec<[[f64; 2]; 2]> {
        let place = |[load, output]: [f64; 2]| [30.0 * (load + 1.0), 10.0 * (output + 2.0)];
        let finite = |point: &[f64; 2]| point.iter().all(|value| value.is_finite());
        let runs = paths.iter().flat_map(|path| path.split(|point| !finite(point)));
        let runs = runs.filter(|run| !run.is_empty());
        let steps = runs.flat_map(|run| match run {
            [one] => vec![[*one; 2]],
            many => many.windows(2).map(|pair| [pair[0], pair[1]]).collect(),
        });
        steps.map(|step| step.map(place)).collect()
    }

    /// Returns the two diagonals of each cell of a density, in pixels.
    fn cells(density: &Density) -> Vec<[[f64; 2]; 2]> {
        let place = |[load, output]: [f64; 2]| [30.0 * (load + 1.0), 10.0 * (output + 2.0)];
        let touched = density.touched().map(|(middle, _)| place(middle));
        let diagonals = |[x, y]: [f64; 2]| {
            let half = 0.5 / CELLS_PER_PIXEL;
            [half, -half].map(|up| [[x - half, y - up], [x + half, y + up]])
        };
        touched.flat_map(diagonals).collect()
    }

    /// Returns points along the steps within the plot, a fifth of a pixel apart.
    fn places(steps: &[[[f64; 2]; 2]]) -> Vec<[f64; 2]> {
        let mut places = Vec::new();
        for [from, to] in steps {
            let length = (to[0] - from[0]).hypot(to[1] - from[1]);
            // A step from far outside is cut to the part near the plot.
            let n = (length / 0.2).ceil().clamp(1.0, 2e5);
            let all = (0..=n as usize).map(|k| k as f64 / n);
            let all = all.map(|share| [0, 1].map(|i| from[i] + share * (to[i] - from[i])));
            places.extend(all.filter(|at| (0..2).all(|i| (0.0..=PIXELS[i]).contains(&at[i]))));
        }
        places
    }

    #[test]
    fn nothing_drawn_or_measured_is_further_than_a_pixel_from_the_other() {
        for (name, paths) in kinds() {
            let measured = steps(&paths);
            for most in [0, 100, usize::MAX] {
                let all = paths.iter().map(|path| path.iter().copied());
                let drawn = match outline(all, FRAME, PIXELS, most) {
                    Outline::Lines(lines) => steps(&lines),
                    Outline::Density(density) => cells(&density),
                };
                let worst = |of: &[[[f64; 2]; 2]], to: &[[[f64; 2]; 2]]| {
                    let places = places(of);
                    let every = places.len().div_ceil(3000).max(1);
                    let far = places.into_iter().step_by(every).map(|at| distance(at, to));
                    far.fold(0.0, f64::max)
                };
                let (beside, missed) = (worst(&drawn, &measured), worst(&measured, &drawn));
                assert!(beside <= 1.0, "{name}, {most}: drawn {beside} pixels beside");
                assert!(missed <= 1.0, "{name}, {most}: {missed} pixels not drawn");
            }
        }
    }

    /// The number of samples changes neither the cells of the density nor the set of touched cells.
    #[test]
    fn the_size_of_a_density_depends_on_the_picture_and_its_levels_on_how_often() {
        for (name, paths) in kinds() {
            let density = |repeats: usize| {
                let again = paths.iter().flat_map(|path| vec![path; repeats]);
                let all = again.map(|path| path.iter().copied());
                match outline(all, FRAME, PIXELS, 0) {
                    Outline::Lines(lines) => {
                        assert!(lines.is_empty(), "{name}");
                        Vec::new()
                    }
                    Outline::Density(density) => {
                        assert_eq!(density.cells, [120, 80]);
                        density.levels
                    }
                }
            };
            let (once, often) = (density(1), density(4));
            assert_eq!(once.len(), often.len(), "{name}");
            for (one, four) in once.iter().zip(often) {
                // Four times the samples are two doublings.
                let expected = if *one > 1 { one + 2 } else { *one };
                assert_eq!(four, expected, "{name}");
            }
        }
    }

    /// One sample is in the lower left corner. A line leads from it to seven more in the middle.
    #[test]
    fn levels_count_samples() {
        let corner = [-0.999, -1.99];
        let path = std::iter::once(corner).chain(std::iter::repeat_n([0.001, 0.01], 7));
        let Outline::Density(density) = outline([path], FRAME, PIXELS, 0) else {
            panic!("no point is allowed")
        };
        let at = |column: usize, row: usize| density.levels[row * 120 + column];
        assert_eq!((at(0, 0), at(60, 40), at(30, 20)), (2, 4, 1));
        assert_eq!(at(119, 0), 0);
    }

    #[test]
    fn few_points_are_samples_and_keep_their_ends() {
        let circle = path(10_000, |k| {
            let angle = k as f64 * std::f64::consts::TAU / 10_000.0;
            [angle.sin(), angle.cos()]
        });
        let Outline::Lines(lines) = outline([circle.clone()], FRAME, PIXELS, 5000) else {
            panic!("few points are lines")
        };
        let [line] = &lines[..] else { panic!("one path is one line") };
        assert!((100..1000).contains(&line.len()), "{}", line.len());
        assert_eq!([line[0], line[line.len() - 1]], [circle[0], circle[9999]]);
        assert!(line.iter().all(|point| circle.contains(point)));
    }

    /// A circle is drawn as a line. The same circle twenty times, or noise that fills a spot, is drawn as a density. Twenty
    /// circles with few samples stay lines, because their density would be dots.
    #[test]
    fn paths_that_overlap_are_drawn_as_density_for_any_number_of_samples() {
        let circle = |n: usize, turns: usize| {
            path(n, |k| {
                let angle = (k * turns) as f64 * std::f64::consts::TAU / (n - 1) as f64;
                [0.9 * angle.sin(), 1.8 * angle.cos()]
            })
        };
        let spot = path(2000, |k| [0.1 * uniform(2 * k), 0.2 * uniform(2 * k + 1)]);
        for (what, path, is_density) in [
            ("one circle", circle(2000, 1), false),
            ("twenty", circle(2000, 20), true),
            ("twenty circles with few samples", circle(101, 20), false),
            ("a spot", spot, true),
        ] {
            let drawn = outline([path], FRAME, PIXELS, 8000);
            let found = matches!(drawn, Outline::Density(_));
            assert_eq!(found, is_density, "{what}");
        }
    }

    #[test]
    fn paths_are_clipped_at_the_frame() {
        let across = vec![[-9.0, 0.0], [9.0, 0.0], [9.0, 5.0], [9.0, 9.0]];
        let lines = outline([across], FRAME, PIXELS, 100);
        assert_eq!(lines, Outline::Lines(vec![vec![[-1.0, 0.0], [1.0, 0.0]]]));
    }
}
