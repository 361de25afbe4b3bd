//! Images of the density of samples along curves. The colour shows which curve, and the opacity shows the number of samples.

use std::io;
use std::sync::Arc;

use crate::scoring::loops::{Density, Frame};

/// Opacity of a cell that a curve only crosses without a sample, and of a cell with the fewest samples.
const WEAKEST: (f32, f32) = (0.2, 0.35);

/// A curve with so many samples that their density is drawn, and the colour of the curve.
#[derive(Clone, Debug)]
pub struct Cloud {
    /// Number of samples in each cell of the plot, on a logarithmic scale.
    pub density: Arc<Density>,
    /// Colour of the curve: red, green, blue.
    pub color: [u8; 3],
}

/// Image of the densities of one or more curves in one plot.
#[derive(Debug)]
pub struct CloudPicture {
    /// Range of the plot's two scales that the image covers.
    pub frame: Frame,
    /// Width and height of the image in pixels.
    pub size: [usize; 2],
    /// Red, green, blue and opacity of each pixel, row by row from the top.
    pub rgba: Vec<u8>,
}

impl CloudPicture {
    /// Returns the images of these clouds. Clouds with the same frame and cells share one image, in which overlapping colours
    /// are mixed by density. One pixel covers `cells_per_pixel` cells horizontally and vertically.
    pub fn of(clouds: &[Cloud], cells_per_pixel: usize) -> Vec<Self> {
        let mut groups: Vec<Vec<&Cloud>> = Vec::new();
        for cloud in clouds {
            let is_own = |group: &&mut Vec<&Cloud>| {
                let first = &group[0].density;
                (first.frame, first.cells) == (cloud.density.frame, cloud.density.cells)
            };
            match groups.iter_mut().find(is_own) {
                Some(group) => group.push(cloud),
                None => groups.push(vec![cloud]),
            }
        }
        let groups = groups.iter();
        groups.map(|group| Self::of_group(group, cells_per_pixel.max(1))).collect()
    }

    fn of_group(clouds: &[&Cloud], step: usize) -> Self {
        let Density { frame, cells, .. } = *clouds[0].density;
        let size = cells.map(|n| n.div_ceil(step));
        let levels = clouds.iter().flat_map(|cloud| &cloud.density.levels);
        let steps = f32::from(levels.copied().max().unwrap_or(0).saturating_sub(2)).max(1.0);
        let strength = |level: u8| match level {
            0 => 0.0,
            1 => WEAKEST.0,
            level => WEAKEST.1 + (1.0 - WEAKEST.1) * f32::from(level - 2) / steps,
        };
        let mut rgba = Vec::with_capacity(4 * size[0] * size[1]);
        for row in (0..size[1]).rev() {
            let rows = row * step..((row + 1) * step).min(cells[1]);
            for column in 0..size[0] {
                let columns = column * step..((column + 1) * step).min(cells[0]);
                let (mut mixed, mut sum, mut strongest) = ([0.0_f32; 3], 0.0_f32, 0.0_f32);
                for cloud in clouds {
                    let levels = &cloud.density.levels;
                    let rows =
                        rows.clone().flat_map(|row| &levels[row * cells[0]..][columns.clone()]);
                    let density = strength(rows.copied().max().unwrap_or(0));
                    (sum, strongest) = (sum + density, strongest.max(density));
                    for (mixed, part) in mixed.iter_mut().zip(cloud.color) {
                        *mixed += density * f32::from(part);
                    }
                }
                let share = if sum > 0.0 { sum.recip() } else { 0.0 };
                rgba.extend(mixed.map(|part| (part * share).round() as u8));
                rgba.push((255.0 * strongest).round() as u8);
            }
        }
        Self { frame, size, rgba }
    }

    /// Returns the image as the contents of a PNG file.
    ///
    /// # Errors
    /// The error of the encoder if the image is empty.
    pub fn png(&self) -> io::Result<Vec<u8>> {
        png(self.size, &self.rgba)
    }
}

/// Returns an image as the contents of a PNG file. `size` is its width and height, and `rgba` has four bytes for each pixel.
///
/// # Errors
/// The error of the encoder if the image is empty.
pub fn png(size: [usize; 2], rgba: &[u8]) -> io::Result<Vec<u8>> {
    let mut file = Vec::new();
    let [width, height] = size.map(|n| u32::try_from(n).unwrap_or(u32::MAX));
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    let written = encoder.write_header().and_then(|mut writer| {
        writer.write_image_data(rgba)?;
        writer.finish()
    });
    written.map_err(io::Error::other)?;
    Ok(file)
}

/// Returns these bytes as text in base64 (RFC 4648, section 4).
pub fn base64(bytes: &[u8]) -> String {
    const SIGNS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let byte = |at: usize| u32::from(three.get(at).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for at in 0..4 {
            let sign = SIGNS[(bits >> (18 - 6 * at)) as usize & 63];
            text.push(if at <= three.len() { sign.into() } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scoring::loops::{Outline, outline};

    const FRAME: Frame = Frame { loads: (0.0, 4.0), outputs: (0.0, 2.0) };

    fn cloud(points: &[[f64; 2]], color: [u8; 3]) -> Cloud {
        match outline([points.to_vec()], FRAME, [4.0, 2.0], 0) {
            Outline::Density(density) => Cloud { density: Arc::new(density), color },
            Outline::Lines(_) => panic!("no point is allowed"),
        }
    }

    /// Eight by four cells: one path along the lowest row, and another with most of its samples at the upper right.
    #[test]
    fn the_image_shows_the_measured_cells_and_no_others() {
        let low = cloud(&[[0.1, 0.1], [3.9, 0.1]], [200, 0, 0]);
        let mut there = vec![[3.9, 0.1]];
        there.extend([[3.9, 1.9]; 9]);
        let high = cloud(&there, [0, 0, 200]);
        let pictures = CloudPicture::of(&[low, high], 1);
        let [picture] = &pictures[..] else { panic!("one frame is one picture") };
        assert_eq!(picture.size, [8, 4]);
        let at = |column: usize, row: usize| &picture.rgba[4 * (8 * row + column)..][..4];
        assert_eq!(at(3, 3), [200, 0, 0, 51], "a path only crosses the cell");
        assert_eq!(at(7, 0), [0, 0, 200, 255], "the cell has nine samples");
        assert_eq!(at(7, 2), [0, 0, 200, 51]);
        assert_eq!(at(7, 3), [100, 0, 100, 89], "the cell has one sample of each colour");
        assert!((0..3).all(|row| (0..7).all(|column| at(column, row)[3] == 0)));
        let pixels = &CloudPicture::of(&[cloud(&there, [0, 0, 200])], 2)[0];
        assert_eq!(pixels.size, [4, 2]);
        let touched: Vec<u8> = pixels.rgba.chunks(4).map(|pixel| u8::from(pixel[3] > 0)).collect();
        assert_eq!(touched, [0, 0, 0, 1, 0, 0, 0, 1]);
        assert!(picture.png().unwrap().starts_with(b"\x89PNG"));
        assert!(CloudPicture::of(&[], 1).is_empty());
    }

    #[test]
    fn base64_is_that_of_the_rfc() {
        for (text, expected) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")]
        {
            assert_eq!(base64(text.as_bytes()), expected);
        }
    }
}
