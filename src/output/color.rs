//! Inks of all plots: one perceptual scale for illuminances, and a few inks that everyone can distinguish.

/// An opaque sRGB colour.
pub type Ink = [u8; 3];

/// Ink of text and axes.
pub const BLACK: Ink = [26, 26, 26];
/// Ink of secondary text.
pub const SOFT: Ink = [89, 89, 89];
/// Ink of rules and grid lines.
pub const FAINT: Ink = [217, 217, 217];
/// Ink of areas without a computed value.
pub const GREY: Ink = [200, 200, 200];
/// Colour of the paper.
pub const WHITE: Ink = [255, 255, 255];
/// Blue of computed values (Okabe and Ito, "Color universal design", 2008).
pub const BLUE: Ink = [0, 114, 178];
/// Vermilion of targets and true values (same source).
pub const VERMILION: Ink = [213, 94, 0];
/// Sky blue, green and purple of parts of computed values (same source).
pub const SKY: Ink = [86, 180, 233];
pub const GREEN: Ink = [0, 158, 115];
pub const PURPLE: Ink = [204, 121, 167];
/// Amber of luminaires (adapted from the same source).
pub const AMBER: Ink = [240, 170, 20];

/// Number of colours of a scale of illuminances or luminances: more could not be distinguished.
pub const SHADES: usize = 128;

/// Viridis at 33 even steps. Lightness rises evenly for every reader and in print (van der Walt and Smith, "A better default
/// colormap for Matplotlib", 2015; placed in the public domain).
const VIRIDIS: [Ink; 33] = [
    [68, 1, 84],
    [71, 13, 96],
    [72, 24, 106],
    [72, 35, 116],
    [71, 45, 123],
    [69, 55, 129],
    [66, 64, 134],
    [62, 73, 137],
    [59, 82, 139],
    [55, 91, 141],
    [51, 99, 141],
    [47, 107, 142],
    [44, 114, 142],
    [41, 122, 142],
    [38, 130, 142],
    [35, 137, 142],
    [33, 145, 140],
    [31, 152, 139],
    [31, 160, 136],
    [34, 167, 133],
    [40, 174, 128],
    [50, 182, 122],
    [63, 188, 115],
    [78, 195, 107],
    [94, 201, 98],
    [112, 207, 87],
    [132, 212, 75],
    [152, 216, 62],
    [173, 220, 48],
    [194, 223, 35],
    [216, 226, 25],
    [236, 229, 27],
    [253, 231, 37],
];

/// The perceptual scale from 0 (dark violet) to 1 (yellow).
pub fn perceptual(share: f64) -> Ink {
    let place = share.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let index = (place.floor() as usize).min(VIRIDIS.len() - 2);
    mixed(VIRIDIS[index], VIRIDIS[index + 1], place - index as f64)
}

/// A mixture of two inks, with the given share of the second.
pub fn mixed(first: Ink, second: Ink, share: f64) -> Ink {
    std::array::from_fn(|i| (f64::from(first[i]) + share * (f64::from(second[i]) - f64::from(first[i]))).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE lightness of an sRGB colour, from 0 to 100.
    fn lightness(ink: Ink) -> f64 {
        let linear = ink.map(|channel| {
            let c = f64::from(channel) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        });
        let y = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
        if y > 0.008856 { 116.0 * y.cbrt() - 16.0 } else { 903.3 * y }
    }

    #[test]
    fn lightness_rises_all_along_the_scale() {
        let lightnesses: Vec<f64> = (0..=64).map(|i| lightness(perceptual(f64::from(i) / 64.0))).collect();
        let steps: Vec<f64> = lightnesses.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(steps.iter().all(|step| *step > 0.3 && *step < 2.5), "{steps:?}");
        assert_eq!([perceptual(-1.0), perceptual(2.0)], [VIRIDIS[0], VIRIDIS[32]]);
    }
}
