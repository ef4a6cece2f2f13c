//! Contribution of luminaires to the glare of an observer: Σ L²ω/p², each luminaire as far as it is seen.

use crate::base::position_index::{Outside, position_index};
use crate::estimators::receiver::Receiver;
use crate::sampling::random::Stream;
use crate::transport::World;

/// Number of luminaire parts without a position index that take as long as one ray.
const PARTS_OF_A_RAY: u64 = 8;

/// Adds one unbiased sample of L²ω/p² in cd²·sr/m⁴ of every luminaire to its entry in `sums`, for an eye that looks along its normal.
/// Returns the work in rays.
///
/// A part of a luminaire counts if it has a position index and if a random point of it is seen. Panes reduce it by the square of their
/// transmittance, as they do with L².
pub fn sample_glare(world: &World, eye: &Receiver, stream: &mut Stream, sums: &mut [f64]) -> u64 {
    let (mut rays, mut parts) = (0, 0u64);
    for emitter in world.emitters.list() {
        let sum = &mut sums[emitter.luminaire as usize];
        emitter.show_parts(eye.point_m, stream, |part| {
            parts += 1;
            let Ok(index) = position_index(eye.normal, part.towards) else {
                return;
            };
            rays += 1;
            let transmittance = world.transmittance(eye.origin, &world.origin(&part.place));
            *sum += part.squared_luminance_sr * (transmittance / index).powi(2);
        });
    }
    rays.max(parts / PARTS_OF_A_RAY)
}

/// For each luminaire, returns why it does not count for the eye: the greatest of the reasons of its visible parts. `None` for luminaires
/// of which a part has an index, and for luminaires that are behind or hidden.
pub fn outside_of_table(world: &World, eye: &Receiver, stream: &mut Stream, luminaires: usize) -> Vec<Option<Outside>> {
    let mut reasons = vec![None; luminaires];
    let mut counts = vec![false; luminaires];
    for emitter in world.emitters.list() {
        let luminaire = emitter.luminaire as usize;
        emitter.show_parts(eye.point_m, stream, |part| match position_index(eye.normal, part.towards) {
            Ok(_) => counts[luminaire] = true,
            Err(Outside::Behind) => {}
            Err(reason) if !counts[luminaire] && reasons[luminaire].is_none_or(|known| reason > known) => {
                if world.transmittance(eye.origin, &world.origin(&part.place)) > 0.0 {
                    reasons[luminaire] = Some(reason);
                }
            }
            Err(_) => {}
        });
    }
    reasons.into_iter().zip(counts).map(|(reason, counts)| reason.filter(|_| !counts)).collect()
}
