//! Colours of figures in files and in the window, as red, green, blue. They are distinguishable with any colour vision.

// Blue, purple and sky are colours from Okabe and Ito (2008).
pub const BLUE: [u8; 3] = [0, 114, 178];
pub const PURPLE: [u8; 3] = [204, 121, 167];
pub const SKY: [u8; 3] = [86, 180, 233];

/// Colour of the reference load on a light background.
pub const CALCULATED: [u8; 3] = [60, 60, 60];
/// Colour of the uncompensated load on a light background.
pub const CONVENTIONAL: [u8; 3] = [184, 78, 0];
/// Colour of the compensated load on a light background.
pub const COMPENSATED: [u8; 3] = BLUE;
/// Colour of the look-back and of raw gauge readings on a light background.
pub const LOOK_BACK: [u8; 3] = [0, 120, 90];
/// Colour of guide lines on a light background.
pub const GUIDE: [u8; 3] = [100, 100, 100];
/// Colour of the factory calibration's load on a light background.
pub const FACTORY: [u8; 3] = [160, 70, 120];

/// Colour of all curves of errors against a threshold, on a light background. These curves differ by their dashes, because
/// colours distinguish loads.
pub const SCORE: [u8; 3] = [60, 60, 60];

/// Returns the colour of loop branches with falling load: halfway between the colour of the rising branches and that of text
/// (`ink`).
pub fn falling(color: [u8; 3], ink: [u8; 3]) -> [u8; 3] {
    [0, 1, 2].map(|at| color[at].midpoint(ink[at]))
}

/// Number of steps of [`shade`].
pub const SHADES: usize = 8;
/// Colours of errors that are larger than those without compensation, on a dark and on a light background.
const WORSE: [[u8; 3]; 2] = [[120, 84, 54], [226, 205, 176]];

/// Returns the colour of an error: blue, deepest for the lowest error (share 0) on a light background and brightest on a dark
/// one, in eight steps up to the error without compensation (share 1), and brown beyond it.
pub fn shade(share: f64, is_dark: bool) -> [u8; 3] {
    if share > 1.0 + 1e-9 {
        return WORSE[usize::from(!is_dark)];
    }
    let step = (share.max(0.0) * SHADES as f64).floor().min(SHADES as f64 - 1.0);
    let middle = (step + 0.5) / SHADES as f64;
    colorous::BLUES.eval_continuous(if is_dark { middle } else { 1.0 - middle }).as_array()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_have_eight_steps_of_lightness_and_end_where_compensation_makes_worse() {
        for is_dark in [true, false] {
            let light = |share: f64| {
                let [r, g, b] = shade(share, is_dark).map(f64::from);
                0.3 * r + 0.6 * g + 0.1 * b
            };
            let mut lights: Vec<f64> = (0..=100).map(|at| light(f64::from(at) / 100.0)).collect();
            assert!(lights.is_sorted_by(|a, b| if is_dark { a >= b } else { a <= b }));
            lights.dedup();
            assert_eq!(lights.len(), SHADES);
            assert_eq!(shade(-1.0, is_dark), shade(0.0, is_dark));
            assert_eq!(shade(1.1, is_dark), shade(7.0, is_dark));
            assert_ne!(shade(1.1, is_dark), shade(1.0, is_dark));
        }
    }
}
