//! Survey samples of one emitter from a receiver. An emitter that is seen partly gets more of them.

use super::{ControlVariate, SHARE_FOR_A_LIGHT_SAMPLE};
use crate::estimators::receiver::Receiver;
use crate::sampling::emitter::{Emitter, EmitterView};
use crate::sampling::random::{Square, Stream};
use crate::transport::World;

/// Number of light samples for which each outcome, visible and hidden, counts before the first one (a prior). It applies if the samples are
/// too few to be stratified.
const PRIOR: f64 = 0.4;
/// Sizes of the squares, in halvings of their side, that show what of an emitter is seen: the first squares, and those of an emitter that
/// is seen partly.
const QUARTERS: u32 = 1;
const SIXTEENTHS: u32 = 2;
/// Greatest number of halvings of squares at the edge of a shadow.
const DEEPEST: u32 = 6;

// Uncertainty as a share of the item's unshadowed illuminance: the root mean square difference of light samples from the expected illuminance, on
// the receivers of the office and the hall, rounded.
/// Uncertainty of an emitter that was not sampled.
const UNSAMPLED: f64 = 0.5;
/// Uncertainty of an emitter whose quarters are all alike, and of one whose sixteenths do.
const QUARTERS_ALIKE: f64 = 0.1;
const SIXTEENTHS_ALIKE: f64 = 0.03;
/// Uncertainty of a part at the edge of a shadow, of one whose own parts are nevertheless alike, and of one away from edges.
const AT_EDGE: f64 = 0.5;
const ALIKE_AT_EDGE: f64 = 0.25;
const OFF_EDGE: f64 = 0.2;

/// Survey of one emitter.
pub struct Survey<'a> {
    world: &'a World,
    receiver: &'a Receiver<'a>,
    emitter: &'a Emitter,
    number: u32,
    /// Illuminance that it may give, in lx.
    importance_lx: f64,
    stream: &'a mut Stream,
    view: Option<EmitterView<'a>>,
    /// Rays so far.
    pub rays: u64,
}

impl<'a> Survey<'a> {
    /// Prepares the survey of an emitter.
    pub fn new(
        world: &'a World,
        receiver: &'a Receiver<'a>,
        emitter: &'a Emitter,
        number: u32,
        importance_lx: f64,
        stream: &'a mut Stream,
    ) -> Survey<'a> {
        Survey { world, receiver, emitter, number, importance_lx, stream, view: None, rays: 0 }
    }

    /// Surveys an emitter and adds its expected illuminance to `found`. `total_lx` is the illuminance that all emitters may give, and `seen_lx` the
    /// part found so far (all, before the first light sample).
    pub fn take(&mut self, [total_lx, seen_lx]: [f64; 2], survey_samples: f64, found: &mut ControlVariate) {
        // One ray determines a point with certainty.
        if self.emitter.is_single_point() && self.importance_lx >= SHARE_FOR_A_LIGHT_SAMPLE * seen_lx {
            let lx = self.sample_lx(Square::WHOLE, 0);
            found.add(self.number, Square::WHOLE, lx, [0.0; 2], 0.0);
            return;
        }
        let share = self.importance_lx / total_lx;
        if share < SHARE_FOR_A_LIGHT_SAMPLE {
            found.add(self.number, Square::WHOLE, 0.0, [0.0; 2], UNSAMPLED * self.importance_lx);
            return;
        }
        let samples = (survey_samples * share).ceil();
        if samples < 4.0 {
            self.survey_few(samples as u64, found);
        } else if samples >= 16.0 || !self.survey_quarters(found) {
            self.survey_parts(samples, found);
        }
    }

    /// Takes a few light samples anywhere on the emitter.
    fn survey_few(&mut self, samples: u64, found: &mut ControlVariate) {
        let (mut sum_lx, mut seen) = (0.0, 0.0);
        for number in 0..samples {
            let lx = self.sample_lx(Square::WHOLE, number);
            sum_lx += lx;
            seen += f64::from(u8::from(lx > 0.0));
        }
        let samples = samples as f64;
        let share = (seen + PRIOR) / (samples + 2.0 * PRIOR);
        let uncertainty_lx = self.importance_lx * (share * (1.0 - share)).sqrt();
        found.add(self.number, Square::WHOLE, sum_lx / samples, [0.0; 2], uncertainty_lx);
    }

    /// Takes a light sample in each quarter. Returns whether they are alike, so that no more samples are needed.
    fn survey_quarters(&mut self, found: &mut ControlVariate) -> bool {
        let quarters: [f64; 4] = std::array::from_fn(|place| self.sample_lx(Square::of(QUARTERS, place), 0));
        let alike = quarters.iter().all(|lx| (*lx > 0.0) == (quarters[0] > 0.0));
        if alike {
            let mean_lx = quarters.iter().sum::<f64>() / 4.0;
            let scatter_lx = (quarters.iter().map(|lx| (lx - mean_lx).powi(2)).sum::<f64>() / 4.0).sqrt();
            let uncertainty_lx = (QUARTERS_ALIKE * self.importance_lx).max(scatter_lx);
            found.add(self.number, Square::WHOLE, mean_lx, [0.0; 2], uncertainty_lx);
        }
        alike
    }

    /// Takes a light sample in each of sixteen parts, and more where there is an edge of a shadow.
    fn survey_parts(&mut self, samples: f64, found: &mut ControlVariate) {
        const SIDE: usize = 1 << SIXTEENTHS;
        let parts: [f64; SIDE * SIDE] = std::array::from_fn(|place| self.sample_lx(Square::of(SIXTEENTHS, place), 0));
        let is_seen = |place: usize| parts[place] > 0.0;
        if (1..parts.len()).all(|place| is_seen(place) == is_seen(0)) {
            let (mean_lx, slopes_lx, scatter_lx) = fitted(&parts);
            let uncertainty_lx = (SIXTEENTHS_ALIKE * self.importance_lx).max(scatter_lx);
            found.add(self.number, Square::WHOLE, mean_lx, slopes_lx, uncertainty_lx);
            return;
        }
        for (place, lx) in parts.into_iter().enumerate() {
            let (column, row) = (place % SIDE, place / SIDE);
            let differs = |other: usize| is_seen(other) != is_seen(place);
            let at_edge = (column > 0 && differs(place - 1))
                || (column + 1 < SIDE && differs(place + 1))
                || (row > 0 && differs(place - SIDE))
                || (row + 1 < SIDE && differs(place + SIDE));
            let square = Square::of(SIXTEENTHS, place);
            if at_edge {
                self.survey_edge(square, lx, samples, found);
            } else {
                self.add_part(square, lx, OFF_EDGE, found);
            }
        }
    }

    /// Takes light samples in the quarters of a square at the edge of a shadow and in their quarters, as long as the samples suffice.
    fn survey_edge(&mut self, square: Square, lx: f64, samples: f64, found: &mut ControlVariate) {
        if samples * square.area() < 1.0 || square.level() >= DEEPEST {
            self.add_part(square, lx, AT_EDGE, found);
            return;
        }
        let quarters = square.quarters().map(|quarter| (quarter, self.sample_lx(quarter, 0)));
        let alike = quarters.iter().all(|(_, quarter_lx)| (*quarter_lx > 0.0) == (lx > 0.0));
        for (quarter, quarter_lx) in quarters {
            if alike {
                self.add_part(quarter, quarter_lx, ALIKE_AT_EDGE, found);
            } else {
                self.survey_edge(quarter, quarter_lx, samples, found);
            }
        }
    }

    fn add_part(&self, square: Square, lx: f64, uncertainty: f64, found: &mut ControlVariate) {
        let area = square.area();
        found.add(self.number, square, area * lx, [0.0; 2], uncertainty * area * self.importance_lx);
    }

    /// Illuminance in lx of a light sample whose first variates lie in a square, as if the whole emitter were like that.
    fn sample_lx(&mut self, square: Square, number: u64) -> f64 {
        self.stream.seek_quasi(u64::from(self.number), u64::from(self.number), number);
        self.stream.turn_to_square(square.code(), square);
        let Receiver { point_m, normal, .. } = *self.receiver;
        let view = self.view.get_or_insert_with(|| self.emitter.view(point_m, normal));
        let found = self.world.light_found(view.light_sample(self.stream), self.receiver.origin);
        self.rays += found.rays;
        found.value
    }
}

/// Fits a plane to values in sixteen parts of the unit square. Returns the mean, the slopes over both variates' range, and the standard
/// deviation from the plane.
fn fitted(parts: &[f64; 16]) -> (f64, [f64; 2], f64) {
    let at = |place: usize| [(place % 4) as f64, (place / 4) as f64].map(|step| (step - 1.5) / 4.0);
    let mean = parts.iter().sum::<f64>() / 16.0;
    // Σ (x − ½)² over the centres of sixteen parts is 5/4.
    let slope = |axis: usize| parts.iter().enumerate().map(|(place, lx)| lx * at(place)[axis]).sum::<f64>() / 1.25;
    let slopes = [slope(0), slope(1)];
    let beyond = |(place, lx): (usize, &f64)| lx - mean - slopes[0] * at(place)[0] - slopes[1] * at(place)[1];
    let squares: f64 = parts.iter().enumerate().map(|part| beyond(part).powi(2)).sum();
    (mean, slopes, (squares / 13.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::fitted;

    #[test]
    fn a_plane_is_fitted_without_rest() {
        let parts = std::array::from_fn(|place| 7.0 + 0.5 * (place % 4) as f64 - 0.25 * (place / 4) as f64);
        let (mean, slopes, scatter) = fitted(&parts);
        assert!((mean - 7.375).abs() < 1e-12 && scatter < 1e-12, "{mean} {scatter}");
        assert!((slopes[0] - 2.0).abs().max((slopes[1] + 1.0).abs()) < 1e-12, "{slopes:?}");
    }
}
