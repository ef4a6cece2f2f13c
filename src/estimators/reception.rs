//! What a receiver makes of the light around it: illuminance on its own plane or on an upright cylinder, or the
//! luminance that an eye sees.
//!
//! Cylindrical illuminance is the mean of the illuminances on all upright planes, E_z = 1/2π ∫ E_v(φ) dφ. So a plane
//! turned at random gives an unbiased sample of it. Semi-cylindrical illuminance weighs the same planes,
//! E_sc = 1/2π ∫ (1 + 4/π cos φ) E_v(φ) dφ with φ from the direction that it faces: the half cosine with which a plane
//! receives has the harmonics 1/π and ½, so that light from azimuth α at ε from the vertical counts (1 + cos α) sin ε/π.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::chain::Stage;
use crate::estimators::ahead::{Expectation, Views};
use crate::estimators::direct::{DirectPass, Receiver};
use crate::estimators::far_field::sample_intensity_cd;
use crate::estimators::luminance::{sample_interreflected_cd_m2, sample_seen_cd_m2};
use crate::estimators::walk::{sample_indirect_lx, sample_share_lx};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::Stream;
use crate::scene::Quantity;

/// Planes of one pass over direct light, evenly turned. The half cosine has no odd harmonic but the first, so that seven
/// planes leave but its fourteenth: 1% of a single source on a cylinder, some 4% on half a one.
const PLANES: u32 = 7;

/// One unbiased sample of the direct part in lx (cd/m² for luminance), and the rays it took.
pub fn sample_direct_lx(
    stage: &Stage,
    quantity: Quantity,
    receiver: &Receiver,
    pass: &mut DirectPass,
    stream: &mut Stream,
) -> (f64, u64) {
    match quantity {
        Quantity::Perpendicular => return pass.at_point(stage, receiver, stream),
        Quantity::Luminance => return sample_seen_cd_m2(stage, receiver, pass, stream),
        // What an observer sees of luminaires glares; it is no background.
        Quantity::Glare(_) => return (0.0, 0),
        Quantity::Intensity { turned_about } => {
            return sample_intensity_cd(stage, receiver.normal, turned_about, stream);
        }
        Quantity::Cylindrical | Quantity::SemiCylindrical { .. } => {}
    }
    let shift = stream.unit();
    let mut sum_lx = 0.0;
    let mut rays = 0;
    for plane in 0..PLANES {
        let turn = TAU * (f64::from(plane) + shift) / f64::from(PLANES);
        let (normal, weight) = turned_plane(quantity, turn);
        let (lx, plane_rays) = pass.at_point(stage, &Receiver { normal, ..*receiver }, stream);
        sum_lx += weight * lx;
        rays += plane_rays;
    }
    (sum_lx / f64::from(PLANES), rays)
}

/// Direct light at one place, for any number of samples.
pub struct DirectLook<'a> {
    quantity: Quantity,
    receiver: Receiver<'a>,
    stage: &'a Stage,
    pass: &'a mut DirectPass,
    expectation: &'a Expectation,
    views: Views<'a>,
}

impl<'a> DirectLook<'a> {
    /// What there is to expect at a place, by about so many looks; nothing for the turned planes of a cylinder, and for
    /// what eyes see.
    pub fn expect(
        stage: &Stage,
        quantity: Quantity,
        receiver: &Receiver,
        pass: &mut DirectPass,
        looks_ahead: f64,
    ) -> Expectation {
        match quantity {
            Quantity::Perpendicular => pass.expect(stage, receiver, looks_ahead),
            _ => Expectation::default(),
        }
    }

    /// Makes ready, with what there is to expect.
    pub fn new(
        stage: &'a Stage,
        quantity: Quantity,
        receiver: &Receiver<'a>,
        pass: &'a mut DirectPass,
        expectation: &'a Expectation,
    ) -> DirectLook<'a> {
        DirectLook { quantity, receiver: *receiver, stage, pass, expectation, views: Views::default() }
    }

    /// One unbiased sample of the direct part in lx, and the rays it took.
    pub fn sample(&mut self, stream: &mut Stream) -> (f64, u64) {
        if self.quantity == Quantity::Perpendicular {
            return self.expectation.sample(self.stage, &self.receiver, &mut self.views, stream);
        }
        sample_direct_lx(self.stage, self.quantity, &self.receiver, self.pass, stream)
    }
}

/// One unbiased sample of the indirect part in lx (cd/m² for luminance), and the rays it took.
pub fn sample_reflected_lx(
    stage: &Stage,
    quantity: Quantity,
    receiver: &Receiver,
    cut: &mut Cut,
    stream: &mut Stream,
) -> (f64, u64) {
    if quantity == Quantity::Luminance {
        return sample_interreflected_cd_m2(stage, receiver, cut, stream);
    }
    let (plane, weight) = one_plane(quantity, receiver, stream);
    let (lx, rays) = sample_indirect_lx(stage, &plane, cut, stream);
    (weight * lx, rays)
}

/// The same for illuminances and a part of the light: see [`sample_share_lx`].
pub fn sample_share_of_reflected_lx(
    stage: &Stage,
    quantity: Quantity,
    receiver: &Receiver,
    share_of: impl Fn(DVec3, DVec3) -> [f64; 2],
    cut: &mut Cut,
    stream: &mut Stream,
) -> (f64, u64) {
    let (plane, weight) = one_plane(quantity, receiver, stream);
    let (lx, rays) = sample_share_lx(stage, &plane, share_of, cut, stream);
    (weight * lx, rays)
}

/// The plane on which one sample of indirect light is taken, and the sample's weight.
pub fn one_plane<'a>(quantity: Quantity, receiver: &Receiver<'a>, stream: &mut Stream) -> (Receiver<'a>, f64) {
    if !matches!(quantity, Quantity::Cylindrical | Quantity::SemiCylindrical { .. }) {
        return (*receiver, 1.0);
    }
    let (normal, weight) = turned_plane(quantity, TAU * stream.unit());
    (Receiver { normal, ..*receiver }, weight)
}

/// The normal of an upright plane turned by an angle from the cylinder's front, and its weight.
fn turned_plane(quantity: Quantity, turn: f64) -> (DVec3, f64) {
    let (front, lopsidedness) = match quantity {
        Quantity::SemiCylindrical { direction } => (direction, 4.0 / PI),
        _ => (DVec3::X, 0.0),
    };
    let (sine, cosine) = turn.sin_cos();
    (cosine * front + sine * DVec3::Z.cross(front), 1.0 + lopsidedness * cosine)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light from azimuth α at ε from the vertical gives 1/π sin ε on a cylinder, (1 + cos α)/π sin ε on half a one.
    #[test]
    fn the_weighted_planes_make_up_both_cylinders() {
        const STEPS: u32 = 20_000;
        let (azimuth, from_vertical) = (0.7f64, 1.1f64);
        let direction = DVec3::new(0.6, 0.8, 0.0);
        let towards = from_vertical.sin() * (azimuth.cos() * direction + azimuth.sin() * DVec3::Z.cross(direction))
            + from_vertical.cos() * DVec3::Z;
        let mean = |quantity: Quantity| {
            let sample = |step: u32| {
                let (normal, weight) = turned_plane(quantity, TAU * f64::from(step) / f64::from(STEPS));
                weight * normal.dot(towards).max(0.0)
            };
            (0..STEPS).map(sample).sum::<f64>() / f64::from(STEPS)
        };
        let whole = from_vertical.sin() / PI;
        assert!((mean(Quantity::Cylindrical) - whole).abs() < 1e-7);
        let half = whole * (1.0 + azimuth.cos());
        assert!((mean(Quantity::SemiCylindrical { direction }) - half).abs() < 1e-7);
    }
}
