//! Spectrum of one channel.

use realfft::RealFftPlanner;

use crate::progress::{Cancelled, Progress};

/// Minimum number of samples in a segment. The spectrum of fewer samples shows nothing.
const FEWEST: usize = 16;
/// Maximum number of samples in a segment, which limits the number of frequencies.
const MOST: usize = 1 << 14;
/// Number of segments without overlap that a signal of medium length is divided into.
const SEGMENTS: usize = 8;

/// Amplitude spectral density of a signal.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Points `[frequency (Hz, or 1 for each row), density (unit of the signal, by the root of Hz)]`, with rising frequencies.
    pub points: Vec<[f64; 2]>,
    /// Number of segments over which the spectrum is averaged.
    pub n_segments: usize,
}

impl Spectrum {
    /// Returns the spectrum of a signal that is sampled at this rate; `None` if there are too few samples.
    ///
    /// **Source** P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967): the squared spectra of segments that overlap by half
    /// are averaged. Each segment has its mean subtracted, and is weighted by a Hann window. Segments with a value that is not
    /// finite are left out.
    ///
    /// # Errors
    /// [`Cancelled`] if `progress` is cancelled.
    pub fn of(
        values: &[f64],
        rate_hz: f64,
        progress: &Progress,
    ) -> Result<Option<Self>, Cancelled> {
        let Some(n) = segment_length(values.len()) else {
            return Ok(None);
        };
        let angle = std::f64::consts::TAU / n as f64;
        let window: Vec<f64> = (0..n).map(|k| 0.5 - 0.5 * (angle * k as f64).cos()).collect();
        let transform = RealFftPlanner::<f64>::new().plan_fft_forward(n);
        let (mut segment, mut output) = (transform.make_input_vec(), transform.make_output_vec());
        let mut scratch = transform.make_scratch_vec();
        let (mut squares, mut n_segments) = (vec![0.0; output.len()], 0);
        for samples in values.windows(n).step_by(n / 2) {
            progress.check()?;
            let mean = samples.iter().sum::<f64>() / n as f64;
            if !mean.is_finite() {
                continue;
            }
            let weighted =
                samples.iter().zip(&window).map(|(value, weight)| (value - mean) * weight);
            segment.iter_mut().zip(weighted).for_each(|(place, value)| *place = value);
            transform
                .process_with_scratch(&mut segment, &mut output, &mut scratch)
                .expect("the lists have the lengths that the transform made");
            for (sum, value) in squares.iter_mut().zip(&output) {
                *sum += value.norm_sqr();
            }
            n_segments += 1;
        }
        let weights: f64 = window.iter().map(|weight| weight * weight).sum();
        let last = squares.len() - 1;
        let point = |(at, sum): (usize, &f64)| {
            // Except for the first and the last, each frequency also stands for its negative frequency.
            let sides = if at == 0 || at == last { 1.0 } else { 2.0 };
            let density = sides * sum / (n_segments as f64 * rate_hz * weights);
            [at as f64 * rate_hz / n as f64, density.sqrt()]
        };
        let points = squares.iter().enumerate().map(point).collect();
        Ok((n_segments > 0).then_some(Self { points, n_segments }))
    }
}

/// Returns the number of samples in a segment, a power of two; `None` for a signal that is too short.
fn segment_length(n: usize) -> Option<usize> {
    let wanted = (n / SEGMENTS).clamp(FEWEST, MOST);
    let length = 1 << wanted.ilog2();
    (n >= length).then_some(length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_signals_have_no_spectrum_and_gaps_are_left_out() {
        let of = |values: &[f64]| Spectrum::of(values, 100.0, &Progress::default()).unwrap();
        assert!(of(&[1.0; 15]).is_none());
        assert_eq!(of(&[1.0; 16]).unwrap().points.len(), 9);
        assert!(of(&[f64::NAN; 16]).is_none());
        let mut values: Vec<f64> = (0..320).map(|k| (f64::from(k) * 0.7).sin()).collect();
        let whole = of(&values).unwrap();
        values[100] = f64::NAN;
        assert_eq!((whole.n_segments, of(&values).unwrap().n_segments), (19, 17));
        let cancelled = Progress::default();
        cancelled.cancel();
        assert!(Spectrum::of(&values, 100.0, &cancelled).is_err());
    }

    /// The signal and the expected densities are those of `tests/golden/spectrum.py`, made by SciPy.
    #[test]
    fn spectrum_equals_that_of_scipy() {
        let golden: serde_json::Value =
            serde_json::from_str(include_str!("../../../tests/golden/spectrum.json")).unwrap();
        let list = |key: &str| -> Vec<f64> {
            let numbers = golden[key].as_array().unwrap().iter();
            numbers.map(|number| number.as_f64().unwrap()).collect()
        };
        let n = golden["n_samples"].as_u64().unwrap();
        let signal: Vec<f64> = (0..n)
            .map(|k| k as f64)
            .map(|k| 3.0 + 0.01 * k + (0.9 * k).sin() + 0.2 * (2.3 * k + 0.001 * k * k).cos())
            .collect();
        let found = Spectrum::of(&signal, 250.0, &Progress::default()).unwrap().unwrap();
        let (frequencies, densities) = (list("frequencies"), list("densities"));
        assert_eq!(found.points.len(), densities.len());
        for ([frequency, density], (expected_hz, expected)) in
            found.points.iter().zip(frequencies.iter().zip(&densities))
        {
            assert!((frequency - expected_hz).abs() < 1e-9);
            assert!(
                (density - expected).abs() < 1e-9 * (1e-3 + expected),
                "{frequency}: {density}"
            );
        }
    }
}
