//! Far-field luminous intensity of the light that leaves a scene without having met anything but panes.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use crate::sampling::random::Stream;
use crate::transport::{Traced, World};

/// Maximum number of emitters that one sample evaluates. Of more emitters, this number is chosen by flux.
const MOST_EMITTERS: usize = 16;

/// One unbiased sample of the intensity in cd that luminaires send out of the scene in a unit direction, and the number of rays. If an axis
/// is given, the result is the mean over all turns about it.
pub fn sample_intensity_cd(
    world: &World,
    direction: DVec3,
    turned_about: Option<DVec3>,
    stream: &mut Stream,
) -> Traced {
    let direction = match turned_about {
        Some(axis) => (DQuat::from_axis_angle(axis, TAU * stream.unit()) * direction).normalize(),
        None => direction,
    };
    let emitters = world.emitters.list();
    let mut sum = Traced::default();
    let mut sample = |index: usize, weight: f64, stream: &mut Stream| {
        if let Some((intensity_cd, place)) = emitters[index].seen_from_afar(direction, stream) {
            sum += weight * intensity_cd * world.transmittance_out(&world.origin(&place), direction);
        }
    };
    if emitters.len() <= MOST_EMITTERS {
        (0..emitters.len()).for_each(|index| sample(index, 1.0, stream));
        return sum;
    }
    let flux_lm = world.emitters.luminous_flux_lm();
    for number in 0..MOST_EMITTERS {
        let choice = (number as f64 + stream.fine_unit()) / MOST_EMITTERS as f64;
        let index = world.emitters.index_at(choice) as usize;
        let probability = emitters[index].luminous_flux_lm / flux_lm;
        sample(index, 1.0 / (probability * MOST_EMITTERS as f64), stream);
    }
    sum
}
