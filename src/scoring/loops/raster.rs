//! Marks the grid cells of a plot that lines touch. Blocks of cells that are already touched completely are skipped at once,
//! and so are blocks of such blocks.

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
