//! Arithmetic on short rows of numbers, number by number. Each row length up to 8 has its own compiled loop, because the
//! set-up of a loop of unknown length takes longer than the arithmetic on six numbers.

/// Length of the longest row that has a compiled loop of its own. Longer rows are divided into rows of at most this length.
const LANES: usize = 8;

/// Sets each number of `out` to the result of the function `value` for the numbers at the same index in the rows `from`.
///
/// # Panics
/// If one of `from` is shorter than `out`.
#[inline(always)]
pub fn write<const N: usize>(
    mut out: &mut [f64],
    mut from: [&[f64]; N],
    value: impl Fn([f64; N]) -> f64 + Copy,
) {
    while out.len() > LANES {
        let (first, rest) = std::mem::take(&mut out).split_at_mut(LANES);
        row::<LANES, N>(first, from, value);
        out = rest;
        for own in &mut from {
            *own = &own[LANES..];
        }
    }
    match out.len() {
        1 => row::<1, N>(out, from, value),
        2 => row::<2, N>(out, from, value),
        3 => row::<3, N>(out, from, value),
        4 => row::<4, N>(out, from, value),
        5 => row::<5, N>(out, from, value),
        6 => row::<6, N>(out, from, value),
        7 => row::<7, N>(out, from, value),
        LANES => row::<LANES, N>(out, from, value),
        _ => {}
    }
}

/// Computes a row of known length. All inputs are read before the first write, so that the compiler need not check whether
/// inputs and output overlap.
#[inline(always)]
fn row<const WIDTH: usize, const N: usize>(
    out: &mut [f64],
    from: [&[f64]; N],
    value: impl Fn([f64; N]) -> f64,
) {
    // Loops are used here and below, because `array::map` is not always inlined.
    let mut columns = [[0.0; N]; WIDTH];
    for (i, own) in from.iter().enumerate() {
        let own: &[f64; WIDTH] = own[..WIDTH].try_into().expect("both rows have the same length");
        for (column, number) in columns.iter_mut().zip(own) {
            column[i] = *number;
        }
    }
    let mut made = [0.0; WIDTH];
    for (made, column) in made.iter_mut().zip(columns) {
        *made = value(column);
    }
    out.copy_from_slice(&made);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_any_length_are_written_whole() {
        for n in 0..20 {
            let a: Vec<f64> = (0..n + 3).map(|k| k as f64).collect();
            let b = vec![0.5; n];
            let mut out = vec![f64::NAN; n];
            write(&mut out, [&*a, &*b], |[a, b]| a - b);
            let expected: Vec<f64> = (0..n).map(|k| k as f64 - 0.5).collect();
            assert_eq!(out, expected);
        }
    }
}
