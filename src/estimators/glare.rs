//! What luminaires add to the glare of an observer: Σ L²ω/p², each as far as it is seen.

use crate::base::glare::position_index;
use crate::chain::Stage;
use crate::estimators::direct::Receiver;
use crate::sampling::random::Stream;

/// One unbiased sample of Σ L²ω/p² in cd²·sr/m⁴ for an eye that looks along its normal, and the rays it took.
///
/// Every part of a luminaire counts if a point of it, drawn at random, is seen (through panes by what they let pass,
/// squared as luminance is).
pub fn sample_glare(stage: &Stage, eye: &Receiver, stream: &mut Stream) -> (f64, u64) {
    let mut sum = 0.0;
    let mut rays = 0;
    for emitter in stage.emitters.list() {
        emitter.show_parts(eye.point_m, stream, |part| {
            let Some(index) = position_index(eye.normal, part.towards) else {
                return;
            };
            rays += 1;
            let transmittance = stage.transmittance(eye.origin, &stage.origin(&part.place));
            sum += part.squared_luminance_sr * (transmittance / index).powi(2);
        });
    }
    (sum, rays)
}
