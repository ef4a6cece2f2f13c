//! Walks from a receiver back towards the luminaires: the simplest unbiased estimator of indirect illuminance with
//! finite variance.
//!
//! E_indirect(x) = ∫ ρ(r′)/π · E(r′) cos θ dω: a direction drawn with density cos θ/π leaves exactly ρ(r′) E(r′) to
//! score. The direct part of E(r′) is computed at r′; for the indirect part the walk goes on with probability ρ.
//! No score ever holds a 1/r² of two surfaces, so corners are harmless.

use crate::chain::Stage;
use crate::estimators::direct::{Receiver, one_look};
use crate::geometry::Meeting;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::Stream;
use crate::sampling::reflection;
use crate::sampling::warp::cosine_hemisphere;

/// One unbiased sample of the indirect illuminance at a receiver in lx, and the rays it took.
pub fn sample_indirect_lx(stage: &Stage, receiver: &Receiver, cut: &mut Cut, stream: &mut Stream) -> (f64, u64) {
    let mut origin = *receiver.origin;
    let mut direction = cosine_hemisphere(receiver.normal, stream.pair());
    let mut illuminance_lx = 0.0;
    let mut rays = 0;
    loop {
        rays += 1;
        let Meeting::Surface(hit) = stage.tracer.first_hit(&origin, direction) else {
            return (illuminance_lx, rays);
        };
        let law = stage.law(hit.triangle);
        let reflectance = reflection::total(law);
        if reflectance == 0.0 || !stage.receives(hit.triangle, hit.side) {
            return (illuminance_lx, rays);
        }
        origin = stage.tracer.surface_origin(hit.triangle, hit.barycentric, hit.side);
        let normal = stage.normal(hit.triangle, hit.side);
        let here = Receiver { point_m: stage.tracer.position_m(&origin), normal, origin: &origin };
        let (direct_lx, direct_rays) = one_look(stage, &here, cut, stream);
        illuminance_lx += reflectance * direct_lx;
        rays += direct_rays;
        match reflection::sample(law, normal, stream) {
            Some(scattered) => direction = scattered,
            None => return (illuminance_lx, rays),
        }
    }
}
