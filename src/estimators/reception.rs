//! How a receiver evaluates the light around it: illuminance on its own plane or on a small body, or the luminance that an eye sees.

use std::f64::consts::TAU;

use glam::DVec3;

use super::small_body::SmallBody;
use crate::estimators::control_variate::{ControlVariate, Views};
use crate::estimators::direct::DirectPass;
use crate::estimators::far_field::sample_intensity_cd;
use crate::estimators::luminance::{sample_interreflected_cd_m2, sample_seen_cd_m2};
use crate::estimators::receiver::Receiver;
use crate::estimators::walk::{sample_indirect_lx, sample_share_lx};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::Stream;
use crate::scene::Quantity;
use crate::transport::{Traced, World};

/// Number of evenly turned planes in one pass over direct light. The half cosine has no odd harmonic except the first. So seven planes
/// leave only the fourteenth harmonic as an error: 1% of a single source on a cylinder, about 4% on a half cylinder.
const PLANES: u32 = 7;

/// One unbiased sample of the direct part in lx (cd/m² for luminance), and the number of rays.
pub fn sample_direct(
    world: &World,
    quantity: Quantity,
    receiver: &Receiver,
    pass: &mut DirectPass,
    stream: &mut Stream,
) -> Traced {
    let Some(body) = SmallBody::of(quantity) else {
        return match quantity {
            Quantity::Luminance => sample_seen_cd_m2(world, receiver, pass, stream),
            // What an observer sees of luminaires is glare, not background.
            Quantity::Glare(_) => Traced::default(),
            Quantity::Intensity { turned_about } => sample_intensity_cd(world, receiver.normal, turned_about, stream),
            _ => pass.at_point(world, receiver, stream),
        };
    };
    let shift = stream.unit();
    let mut sum = Traced::default();
    for plane in 0..PLANES {
        let turn = TAU * (f64::from(plane) + shift) / f64::from(PLANES);
        let (normal, weight) = body.turned_plane(turn);
        sum += weight * pass.at_point(world, &Receiver { normal, ..*receiver }, stream);
    }
    sum / f64::from(PLANES)
}

/// Direct light at one point, for any number of samples.
pub struct DirectSampler<'a> {
    quantity: Quantity,
    receiver: Receiver<'a>,
    world: &'a World,
    pass: &'a mut DirectPass,
    control_variate: &'a ControlVariate,
    views: Views<'a>,
}

impl<'a> DirectSampler<'a> {
    /// The control variate of a point, from about `survey_samples` light samples (L of docs/methods.md, section 2). It is empty for all
    /// quantities but the illuminance on the receiver's own plane.
    pub fn control_variate(
        world: &World,
        quantity: Quantity,
        receiver: &Receiver,
        pass: &mut DirectPass,
        survey_samples: f64,
    ) -> ControlVariate {
        match quantity {
            Quantity::Perpendicular => pass.control_variate(world, receiver, survey_samples),
            _ => ControlVariate::default(),
        }
    }

    /// Prepares the sampling with the point's control variate.
    pub fn new(
        world: &'a World,
        quantity: Quantity,
        receiver: &Receiver<'a>,
        pass: &'a mut DirectPass,
        control_variate: &'a ControlVariate,
    ) -> DirectSampler<'a> {
        DirectSampler { quantity, receiver: *receiver, world, pass, control_variate, views: Views::default() }
    }

    /// One unbiased sample of the direct part in the unit of the quantity, and the number of rays.
    pub fn sample(&mut self, stream: &mut Stream) -> Traced {
        if self.quantity == Quantity::Perpendicular {
            return self.control_variate.sample(self.world, &self.receiver, &mut self.views, stream);
        }
        sample_direct(self.world, self.quantity, &self.receiver, self.pass, stream)
    }
}

/// One unbiased sample of the indirect part in lx (cd/m² for luminance), and the number of rays.
pub fn sample_reflected(
    world: &World,
    quantity: Quantity,
    receiver: &Receiver,
    cut: &mut Cut,
    stream: &mut Stream,
) -> Traced {
    if quantity == Quantity::Luminance {
        return sample_interreflected_cd_m2(world, receiver, cut, stream);
    }
    let (plane, weight) = one_plane(quantity, receiver, stream);
    weight * sample_indirect_lx(world, &plane, cut, stream)
}

/// One unbiased sample of a part of the indirect illuminance: see [`sample_share_lx`]. Not for luminance.
pub fn sample_share_of_reflected_lx(
    world: &World,
    quantity: Quantity,
    receiver: &Receiver,
    share_of: impl Fn(DVec3, DVec3) -> [f64; 2],
    cut: &mut Cut,
    stream: &mut Stream,
) -> Traced {
    let (plane, weight) = one_plane(quantity, receiver, stream);
    weight * sample_share_lx(world, &plane, share_of, cut, stream)
}

/// The plane on which one sample of indirect light is taken, and the weight of the sample.
pub fn one_plane<'a>(quantity: Quantity, receiver: &Receiver<'a>, stream: &mut Stream) -> (Receiver<'a>, f64) {
    let Some(body) = SmallBody::of(quantity) else {
        return (*receiver, 1.0);
    };
    let (normal, weight) = body.turned_plane(TAU * stream.unit());
    (Receiver { normal, ..*receiver }, weight)
}
