//! Measures counted over the hours of a year.

use crate::base::half_samples::{PARTED, PARTINGS, mean_and_halves, standard_error};
use crate::maps::Estimate;

/// Illuminance of daylight autonomy in lx. Its companion is `SDA_SHARE`, the share of occupied hours that must reach it (IES
/// LM-83).
pub const AUTONOMY_LX: f64 = 300.0;
/// Share of the occupied hours with `AUTONOMY_LX` or more from which a point counts as daylit (IES LM-83).
pub const SDA_SHARE: f64 = 0.5;
/// Limits of useful daylight in lx: daylight is supplementary from the first, useful from the second, and too much above the third
/// (Mardaljevic and others, 2012).
pub const UDI_LIMITS_LX: [f64; 3] = [100.0, 300.0, 3000.0];
/// Illuminance in lx by direct sunlight alone for annual sunlight exposure (IES LM-83).
pub const ASE_LX: f64 = 1000.0;
/// Number of occupied hours with `ASE_LX` that must be exceeded to count for annual sunlight exposure (IES LM-83).
pub const ASE_HOURS: f64 = 250.0;
/// Share of the area with annual sunlight exposure below which it counts as acceptable (IES LM-83).
pub const ASE_SHARE: f64 = 0.1;
/// Blinds close when direct sunlight reaches `ASE_LX` at more than this share of the points (IES LM-83).
pub const BLINDS_SHARE: f64 = 0.02;

/// A measure counted at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum YearMeasure {
    /// Share of the occupied hours with at least 300 lx.
    Autonomy,
    /// Share of the occupied hours below 100 lx.
    TooLittle,
    /// Share from 100 lx up to 300 lx.
    Supplementary,
    /// Share from 300 lx to 3000 lx.
    Useful,
    /// Share above 3000 lx.
    TooMuch,
    /// Occupied hours in which the sun alone gives 1000 lx or more.
    Sunlit,
    /// Annual light exposure in lx h.
    Exposure,
    /// Sky component of the daylight factor under the overcast sky, in %.
    SkyComponent,
    /// Externally reflected component of the daylight factor in %, including the light from the ground.
    FromOutside,
    /// Internally reflected component of the daylight factor in %.
    FromInside,
}

/// All measures, in the order of [`YearMeasure`].
pub const MEASURES: [YearMeasure; 10] = [
    YearMeasure::Autonomy,
    YearMeasure::TooLittle,
    YearMeasure::Supplementary,
    YearMeasure::Useful,
    YearMeasure::TooMuch,
    YearMeasure::Sunlit,
    YearMeasure::Exposure,
    YearMeasure::SkyComponent,
    YearMeasure::FromOutside,
    YearMeasure::FromInside,
];

/// A counted value, with the same value from both halves of each partition of the replicas.
#[derive(Clone, Debug, Default)]
pub(super) struct Counted {
    pub value: f64,
    pub halves: [[f64; 2]; PARTINGS],
}

impl Counted {
    /// The mean over the replicas, with the means of the halves.
    pub fn of(replicas: &[f64; PARTED]) -> Counted {
        let (value, off) = mean_and_halves(replicas);
        Counted { value, halves: off.map(|off| [value + off, value - off]) }
    }

    pub fn estimate(&self) -> Estimate {
        Estimate { value: self.value, standard_error: standard_error(self.halves.iter().copied()) }
    }

    /// Adds `make(value)` times a weight, for the whole value and for each half.
    pub fn add(&mut self, of: &Counted, weight: f64, make: impl Fn(f64) -> f64) {
        self.value += weight * make(of.value);
        for (sums, halves) in self.halves.iter_mut().zip(&of.halves) {
            for (sum, half) in sums.iter_mut().zip(halves) {
                *sum += weight * make(*half);
            }
        }
    }

    /// Divides the value and its halves by `all`.
    pub fn over(mut self, all: f64) -> Counted {
        self.value /= all;
        self.halves.iter_mut().flatten().for_each(|half| *half /= all);
        self
    }
}

/// Counts of one point while the hours are added.
#[derive(Clone, Debug, Default)]
pub(super) struct HourCounts {
    pub of: [Counted; MEASURES.len()],
}

impl HourCounts {
    /// Adds an hour. Each pair has an illuminance in lx and the differences of the halves from it; `sun` has those of direct
    /// sunlight alone.
    #[inline]
    pub fn add_hour(
        &mut self,
        is_occupied: bool,
        (all_lx, all_off): (f64, &[f64; PARTINGS]),
        sun: Option<(f64, &[f64; PARTINGS])>,
    ) {
        let [exposure, sunlit] = [YearMeasure::Exposure, YearMeasure::Sunlit].map(|measure| measure as usize);
        add(&mut self.of[exposure], all_lx, all_off, |lx| lx);
        if !is_occupied {
            return;
        }
        let [low, middle, high] = UDI_LIMITS_LX;
        let one = |is_so: bool| f64::from(u8::from(is_so));
        add(&mut self.of[YearMeasure::Autonomy as usize], all_lx, all_off, |lx| one(lx >= AUTONOMY_LX));
        add(&mut self.of[YearMeasure::TooLittle as usize], all_lx, all_off, |lx| one(lx < low));
        add(&mut self.of[YearMeasure::Supplementary as usize], all_lx, all_off, |lx| one(low <= lx && lx < middle));
        add(&mut self.of[YearMeasure::Useful as usize], all_lx, all_off, |lx| one(middle <= lx && lx <= high));
        add(&mut self.of[YearMeasure::TooMuch as usize], all_lx, all_off, |lx| one(lx > high));
        if let Some((sun_lx, sun_off)) = sun {
            add(&mut self.of[sunlit], sun_lx, sun_off, |lx| one(lx >= ASE_LX));
        }
    }

    /// Adds occupied hours without light.
    pub fn add_dark(&mut self, occupied_hours: f64) {
        let dark = &mut self.of[YearMeasure::TooLittle as usize];
        dark.value += occupied_hours;
        dark.halves.iter_mut().flatten().for_each(|half| *half += occupied_hours);
    }

    /// Divides by the number of occupied hours those measures that are shares.
    pub fn finish(self, occupied_hours: f64) -> [Counted; MEASURES.len()] {
        let mut place = 0;
        self.of.map(|counted| {
            place += 1;
            match MEASURES[place - 1] {
                YearMeasure::Sunlit
                | YearMeasure::Exposure
                | YearMeasure::SkyComponent
                | YearMeasure::FromOutside
                | YearMeasure::FromInside => counted,
                _ => counted.over(occupied_hours.max(1.0)),
            }
        })
    }
}

#[inline]
fn add(to: &mut Counted, lx: f64, off: &[f64; PARTINGS], make: impl Fn(f64) -> f64) {
    to.value += make(lx);
    for (halves, off) in to.halves.iter_mut().zip(off) {
        halves[0] += make(lx + off);
        halves[1] += make(lx - off);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks ten occupied hours around 300 lx and two dark ones without errors against shares by hand. Then every hour has an
    /// error of 1 lx. One half of the replicas counts one more hour, the other half one less.
    #[test]
    fn hours_are_counted_by_their_limits() {
        let count = |off: f64| {
            let mut counts = HourCounts::default();
            for step in 0..10 {
                let all = (298.5 + f64::from(step), &[off; PARTINGS]);
                counts.add_hour(true, all, Some((990.0 + 2.0 * f64::from(step), &[0.0; PARTINGS])));
            }
            counts.add_hour(false, (1e5, &[0.0; PARTINGS]), None);
            counts.add_dark(2.0);
            counts.finish(12.0).map(|counted| counted.estimate())
        };
        let sure = count(0.0);
        let values = sure.map(|estimate| estimate.value);
        assert!((values[..5].iter().zip([8.0, 2.0, 2.0, 8.0, 0.0])).all(|(a, b)| (a - b / 12.0).abs() < 1e-12));
        assert!(values[1..5].iter().sum::<f64>() == 1.0 && sure.iter().all(|estimate| estimate.standard_error == 0.0));
        assert_eq!(values[5..], [5.0, 103_030.0, 0.0, 0.0, 0.0]);
        let unsure = count(1.0);
        assert!((unsure[0].standard_error - 1.0 / 12.0).abs() < 1e-12 && unsure[5].standard_error == 0.0);
        assert!((unsure[6].standard_error - 10.0).abs() < 1e-9, "{:?}", unsure[6]);
    }
}
