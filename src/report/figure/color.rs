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

/// Returns the colour that a colour scale gives to a share from 0 to 1. Lightness increases evenly with the share, so the
/// scale is readable in grey.
pub fn shade(share: f64) -> [u8; 3] {
    colorous::VIRIDIS.eval_continuous(share.clamp(0.0, 1.0)).as_array()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_grow_lighter_from_end_to_end() {
        let light = |share: f64| {
            let [r, g, b] = shade(share).map(f64::from);
            0.3 * r + 0.6 * g + 0.1 * b
        };
        let lights: Vec<f64> = (0..=20).map(|at| light(f64::from(at) / 20.0)).collect();
        assert!(lights.is_sorted());
        assert_eq!(shade(-1.0), shade(0.0));
        assert_eq!(shade(7.0), shade(1.0));
    }
}
