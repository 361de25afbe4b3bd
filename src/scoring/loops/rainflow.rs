//! Rainflow counting: finds the cycles of a load, also those that contain smaller cycles.
//!
//! Guarantees: the counts are those of ASTM E1049 5.4.4, including the half cycles that remain (residue). A large cycle does
//! not depend on the small cycles within it. Each sample is read about twice.

use crate::{min_max::MinMax, scoring::loops::turns::Branch};

/// Closed cycles of one recording, and the half cycles that are left over.
#[derive(Debug, Default)]
pub struct Counted {
    /// The two branches of each closed cycle. The second branch ends where the load is back at the start of the first.
    pub closed: Vec<[Branch; 2]>,
    /// Half cycles in the order of time. Their ranges first grow and then shrink.
    pub residue: Vec<Branch>,
}

/// Counts the cycles of a recording from its branches.
///
/// **Source** ASTM E1049-85, 5.4.4, in the form with four reversals: the middle of three ranges is a cycle if neither
/// neighbour is smaller. The half cycles that are left over are the same as in the standard. If three ranges are equal, the
/// middle one is not taken as a cycle. Equal half cycles are later paired in the order of time, so the counts are the same.
pub fn count(branches: Vec<Branch>, loads: &[f64]) -> Counted {
    let mut counted = Counted::default();
    let residue = &mut counted.residue;
    for branch in branches {
        residue.push(branch);
        while let [.., before, middle, after] = &residue[..] {
            let (span, beside) = (middle.span(), [before.span(), after.span()]);
            let closes = beside.iter().all(|other| span <= *other);
            if !closes || beside == [span; 2] {
                break;
            }
            let three = <[Branch; 3]>::try_from(residue.split_off(residue.len() - 3));
            let [before, middle, mut after] = three.expect("three branches were taken");
            let back = closing_sample(&middle, &after, loads);
            let n_within = (after.nested).partition_point(|nested| nested.end <= back);
            let rest = after.nested.split_off(n_within);
            let end = middle.samples.end - 1;
            let mut nested = before.nested;
            nested.push(before.samples.end..back);
            nested.extend(rest);
            residue.push(Branch {
                samples: before.samples.start..after.samples.end,
                rising: before.rising,
                loads: before.loads.joined(after.loads),
                nested,
            });
            let mut second = Branch {
                samples: end..back + 1,
                rising: after.rising,
                nested: after.nested,
                ..middle
            };
            second.loads = second.loads.with(loads[back]);
            counted.closed.push([middle, second]);
        }
    }
    counted
}

/// Returns the first sample of the branch `after` at which the load is back at the start of the branch `first`.
fn closing_sample(first: &Branch, after: &Branch, loads: &[f64]) -> usize {
    let is_back = |k: &usize| {
        if after.rising { loads[*k] >= first.loads.max } else { loads[*k] <= first.loads.min }
    };
    let last = after.samples.end - 1;
    after.kept().find(is_back).unwrap_or(last)
}

/// Pairs neighbouring half cycles to cycles, and returns the index of the first half cycle of each pair. A half cycle is in
/// at most one pair. The pairs have the largest possible sum of squared common load ranges.
pub fn pairs(residue: &[Branch]) -> Vec<usize> {
    let common =
        |at: usize| MinMax::common(residue[at..at + 2].iter().map(|half| half.loads)).span();
    // Dynamic programming: for the first n half cycles, the largest sum of squares, and true if the last two of them form a
    // pair.
    let mut best = vec![(0.0, false); residue.len() + 1];
    for n in 2..=residue.len() {
        let paired = best[n - 2].0 + common(n - 2) * common(n - 2);
        let alone = best[n - 1].0;
        best[n] = (paired.max(alone), paired > alone);
    }
    let mut pairs = Vec::new();
    let mut n = residue.len();
    while n > 0 {
        let is_pair = best[n].1;
        n -= 1 + usize::from(is_pair);
        if is_pair {
            pairs.push(n);
        }
    }
    pairs.reverse();
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scoring::loops::turns::branches;

    fn counted(loads: &[f64]) -> Counted {
        count(branches(loads, 0.0), loads)
    }

    /// Returns the count of each range, largest first. A half cycle counts 0.5.
    fn counts(ranges: impl IntoIterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
        let mut ranges: Vec<_> = ranges.into_iter().collect();
        ranges.sort_by(|a, b| b.0.total_cmp(&a.0));
        let same = ranges.chunk_by(|a, b| (a.0 - b.0).abs() < 1e-9);
        same.map(|same| (same[0].0, same.iter().map(|one| one.1).sum())).collect()
    }

    fn counts_of(loads: &[f64]) -> Vec<(f64, f64)> {
        let found = counted(loads);
        let closed = found.closed.iter().map(|pair| (pair[0].span(), 1.0));
        counts(closed.chain(found.residue.iter().map(|half| (half.span(), 0.5))))
    }

    /// Counts step by step by the standard: counts and removes the first range that is at most as large as the next one. A
    /// range with the starting point counts 0.5.
    fn slowly(loads: &[f64]) -> Vec<(f64, f64)> {
        let mut points: Vec<f64> = loads.to_vec();
        points.dedup();
        let is_turn = |w: &[f64]| (w[1] - w[0]) * (w[2] - w[1]) < 0.0;
        let turns = points.windows(3).filter(|w| is_turn(w)).map(|w| w[1]);
        let mut points: Vec<f64> = (points.first().copied().into_iter())
            .chain(turns)
            .chain(points.last().copied())
            .collect();
        points.dedup();
        let mut found = Vec::new();
        'again: loop {
            for at in 2..points.len() {
                let range = |k: usize| (points[k] - points[k - 1]).abs();
                if range(at) >= range(at - 1) {
                    let holds_start = at == 2;
                    found.push((range(at - 1), if holds_start { 0.5 } else { 1.0 }));
                    points.drain(if holds_start { 0..1 } else { at - 2..at });
                    continue 'again;
                }
            }
            break;
        }
        found.extend(points.windows(2).map(|w| ((w[1] - w[0]).abs(), 0.5)));
        counts(found)
    }

    /// ASTM E1049-85, 5.4.4 and figure 6: ranges 3, 4, 6, 8, 9 occur 0.5, 1.5, 0.5, 1.0 and 0.5 times.
    #[test]
    fn the_example_of_the_standard_has_its_counts() {
        let loads = [-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0];
        let expected = [(9.0, 0.5), (8.0, 1.0), (6.0, 0.5), (4.0, 1.5), (3.0, 0.5)];
        assert_eq!(counts_of(&loads), expected);
        assert_eq!(slowly(&loads), expected);
    }

    #[test]
    fn counts_are_those_of_the_standards_words() {
        let mut state = 1_u64;
        let mut next = move |n: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            ((state >> 33) % n) as f64
        };
        for case in 0..300 {
            // With few levels many ranges are equal, with many levels hardly any.
            let levels = [3, 8, 1_000_000][case % 3];
            let loads: Vec<f64> = (0..2 + case).map(|_| next(levels)).collect();
            assert_eq!(counts_of(&loads), slowly(&loads), "{loads:?}");
        }
    }

    /// The load rises to 10, with a dip from 6 to 4 on the way, and falls again.
    #[test]
    fn a_small_cycle_is_left_out_of_the_large_one() {
        let loads = [0.0, 3.0, 6.0, 4.0, 5.0, 7.0, 10.0, 5.0, 0.0];
        let found = counted(&loads);
        let [dip] = &found.closed[..] else { panic!("one small cycle: {found:?}") };
        assert_eq!((dip[0].samples.clone(), dip[1].samples.clone()), (2..4, 3..6));
        let [up, down] = &found.residue[..] else { panic!("up and down: {found:?}") };
        assert_eq!(up.kept().collect::<Vec<_>>(), [0, 1, 2, 5, 6]);
        assert_eq!((up.loads.ends(), up.rising), (Some((0.0, 10.0)), true));
        assert_eq!(down.samples, 6..9);
        assert_eq!(pairs(&found.residue), [0]);
    }

    /// Small cycles lie within a cycle within another one; the outermost rises or falls.
    #[test]
    fn cycles_nest_to_any_depth() {
        let inwards: Vec<f64> =
            (0..40).map(|k| f64::from(40 - k) * if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let loads = [&inwards[..], &[41.0, -41.0]].concat();
        for loads in [loads.clone(), loads.iter().map(|load| -load).collect()] {
            let found = counted(&loads);
            assert_eq!(found.closed.len(), 19);
            for [first, second] in &found.closed {
                let common = MinMax::common([first.loads, second.loads].into_iter());
                assert_eq!(common.span(), first.span());
                assert_eq!(second.samples.start, first.samples.end - 1);
            }
            assert_eq!(counts_of(&loads), slowly(&loads));
        }
    }

    #[test]
    fn equal_half_cycles_pair_in_the_order_of_time_and_the_widest_are_not_torn() {
        let starts = |loads: &[f64]| pairs(&branches(loads, 0.0));
        assert_eq!(starts(&[0.0, 9.0, 0.0, 9.0, 0.0, 9.0]), [0, 2]);
        assert_eq!(starts(&[0.0, 3.0, -7.0, 7.0, 1.0]), [1]);
        assert_eq!(starts(&[0.0, 1.0]), [0_usize; 0]);
    }
}
