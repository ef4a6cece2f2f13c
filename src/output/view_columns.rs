//! Two-byte codes for the numbers of the view in space, and the columns that hold them.

use super::zlib::zlib;

use flate2::Compression;
use glam::DVec3;

/// Natural logarithm of the ratio of the largest illuminance to the smallest that is distinguished from 0: nine decades.
pub const SPAN: f64 = 20.7232658369464;
/// Steps between the codes of the smallest and of the largest illuminance.
const CODE_STEPS: f64 = 65_533.0;
/// The code for an unknown value.
const UNKNOWN_CODE: u16 = u16::MAX;

/// Largest number of bytes that are compressed at the best level. More would take seconds for a few percent.
const MOST_AT_BEST: usize = 2 << 20;

/// Codes illuminances in even steps of their logarithm; a step is 0.03 %.
pub struct LuxCode {
    /// The largest illuminance in lx.
    pub most_lx: f64,
}

impl LuxCode {
    /// The code of an illuminance: 0 for 0 and values below the smallest, 1 to 65,534 for most·exp(((code − 1)/65,533 − 1)·span),
    /// and 65,535 for no value.
    pub fn code(&self, illuminance_lx: Option<f64>) -> u16 {
        let Some(illuminance_lx) = illuminance_lx else { return UNKNOWN_CODE };
        if illuminance_lx <= self.most_lx * (-SPAN).exp() {
            return 0;
        }
        let share = 1.0 + (illuminance_lx / self.most_lx).ln() / SPAN;
        1 + (share.clamp(0.0, 1.0) * CODE_STEPS).round() as u16
    }
}

/// Codes positions in steps of one length, from the lowest corner of their bounding box.
pub struct PlaceCode {
    /// Lowest coordinates in m.
    pub low_m: DVec3,
    /// Length of a step in m.
    pub step_m: f64,
}

impl PlaceCode {
    /// A code that covers all of these positions.
    pub fn of(places_m: &[DVec3]) -> PlaceCode {
        let bound = |pick: fn(DVec3, DVec3) -> DVec3| places_m.iter().copied().reduce(pick).unwrap_or_default();
        let (low_m, high_m) = (bound(DVec3::min), bound(DVec3::max));
        let step_m = (high_m - low_m).max_element() / f64::from(u16::MAX);
        PlaceCode { low_m, step_m: step_m.max(f64::MIN_POSITIVE) }
    }

    /// Number of steps along an axis.
    pub fn code(&self, place_m: DVec3, axis: usize) -> u16 {
        ((place_m[axis] - self.low_m[axis]) / self.step_m).round().clamp(0.0, f64::from(u16::MAX)) as u16
    }
}

/// Columns one after another. Each holds the differences from entry to entry, modulo 65,536: first their low bytes, then their high
/// bytes. Neighbours are similar, so this compresses well.
#[derive(Default)]
pub struct Columns {
    bytes: Vec<u8>,
}

impl Columns {
    /// Appends a column.
    pub fn add(&mut self, codes: impl Iterator<Item = u16> + Clone) {
        let before = std::iter::once(0).chain(codes.clone());
        let differences: Vec<u16> = codes.zip(before).map(|(code, before)| code.wrapping_sub(before)).collect();
        for byte in [0, 1] {
            self.bytes.extend(differences.iter().map(|difference| difference.to_le_bytes()[byte]));
        }
    }

    /// All columns, compressed.
    pub fn compressed(&self) -> Vec<u8> {
        let level = if self.bytes.len() <= MOST_AT_BEST { Compression::best() } else { Compression::default() };
        zlib(&self.bytes, level)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(code: u16, most_lx: f64) -> f64 {
        most_lx * (((f64::from(code) - 1.0) / CODE_STEPS - 1.0) * SPAN).exp()
    }

    #[test]
    fn illuminances_come_back_within_half_a_step() {
        let lux = LuxCode { most_lx: 12_345.0 };
        assert!((SPAN - 1e9f64.ln()).abs() < 1e-12);
        for illuminance_lx in [2e-5, 0.013, 1.0, 499.5, 12_344.0, 12_345.0] {
            let back_lx = decoded(lux.code(Some(illuminance_lx)), lux.most_lx);
            assert!(
                (back_lx / illuminance_lx - 1.0).abs() < 0.51 * SPAN / CODE_STEPS,
                "{back_lx} for {illuminance_lx}"
            );
        }
        assert_eq!([Some(0.0), Some(-3.0), Some(1e-6), None].map(|lx| lux.code(lx)), [0, 0, 0, UNKNOWN_CODE]);
        assert_eq!(LuxCode { most_lx: 0.0 }.code(Some(0.0)), 0);
    }

    #[test]
    fn places_come_back_within_half_a_step_and_one_place_alone_is_one() {
        let corners_m = [DVec3::new(-2.0, 1.0, 0.0), DVec3::new(6.0, 4.0, 2.8)];
        let place = PlaceCode::of(&corners_m);
        let back_m = place.low_m.y + place.step_m * f64::from(place.code(DVec3::new(0.0, 3.21, 0.0), 1));
        assert!((back_m - 3.21).abs() < 0.51 * place.step_m && place.code(corners_m[1], 0) == u16::MAX);
        assert_eq!(PlaceCode::of(&[DVec3::ONE]).code(DVec3::ONE, 2), 0);
    }

    #[test]
    fn columns_hold_differences() {
        let mut columns = Columns::default();
        columns.add([3u16, 2, 258].into_iter());
        assert_eq!(columns.bytes, [3, 255, 0, 0, 255, 1]);
    }
}
