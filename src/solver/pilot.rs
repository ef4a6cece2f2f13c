//! A short pilot before the run: how much of a map's work should go to direct light.
//!
//! Its samples enter no result. With variance v and cost c (in counted rays) a sample, two independent parts of a
//! sum are best sampled in the ratio √(v₁c₂ / v₂c₁).

use super::job::Context;
use crate::estimators::direct::{DirectPass, Receiver};
use crate::estimators::reception::{sample_direct_lx, sample_reflected_lx};
use crate::maps::MapKind;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};

/// Points or elements that the pilot looks at, at most.
const MOST_SITES: usize = 256;
/// Direct passes at each of them.
const PASSES: u64 = 4;
/// Walks at each point.
const WALKS: u64 = 4;
/// Chains traced for elements.
const CHAINS: u64 = 1024;
/// Bounds of the rays that direct light takes, over those of indirect light: a pilot that saw no penumbra does not
/// prove that there is none.
const LEAST_RAY_SHARE: f64 = 0.02;
const MOST_RAY_SHARE: f64 = 8.0;

/// A pass costs at least this, in rays an entry: asking emitters that turn out to bring nothing takes time as well.
const LEAST_RAYS_PER_PASS: f64 = 0.1;

/// How direct light shares in the work of a map.
#[derive(Clone, Copy, Debug)]
pub struct DirectShare {
    /// Passes over direct light for each chain (elements) or each walk a point (receivers).
    pub passes_per_sample: f64,
    /// Rays of a pass over all entries.
    pub rays_per_pass: f64,
    /// Rays of a sample of indirect light.
    pub rays_per_indirect: f64,
}

impl DirectShare {
    /// Measures a map's share.
    pub fn of(context: &Context, kind: MapKind, number: u32) -> DirectShare {
        match kind {
            MapKind::Elements => of_elements(context, number),
            MapKind::Receivers(set) => of_receivers(context, set, number),
        }
    }

    /// The share beside samples of indirect light that serve a whole set at once: their weighted variance, summed over
    /// the set, and their rays.
    pub fn beside(
        context: &Context,
        set: usize,
        number: u32,
        indirect_variance: f64,
        rays_per_indirect: f64,
    ) -> DirectShare {
        let (direct, _) = costs_at_points(context, set, number, false);
        let points = context.scene.receivers[set].points.len() as f64;
        let scaled = Cost { variance: direct.variance * points / direct.sites.max(1.0), ..direct };
        share(&scaled, indirect_variance, rays_per_indirect / points, points)
    }
}

/// Sum and sum of squares of the scores at one site.
#[derive(Default)]
struct Spread {
    count: f64,
    sum: f64,
    squares: f64,
}

impl Spread {
    fn add(&mut self, score: f64) {
        self.count += 1.0;
        self.sum += score;
        self.squares += score * score;
    }

    fn variance(&self) -> f64 {
        ((self.squares - self.sum * self.sum / self.count) / (self.count - 1.0)).max(0.0)
    }
}

/// Weighted variance and cost of direct and of indirect light at some of a set's points; a walk's indirect light only
/// where asked for.
fn costs_at_points(context: &Context, set: usize, number: u32, walk: bool) -> (Cost, Cost) {
    let (stage, points) = (context.stage, &context.scene.receivers[set].points);
    let quantity = context.scene.receivers[set].quantity;
    let stride = points.len().div_ceil(MOST_SITES).max(1);
    let (mut room, mut cut) = (DirectPass::default(), Cut::default());
    let mut stream = Stream::new(context.seed, Purpose::Pilot, number, 0);
    let (mut direct, mut indirect) = (Cost::default(), Cost::default());
    for (index, point) in points.iter().enumerate().step_by(stride).filter(|(_, point)| !point.inside) {
        stream.seek(index as u64);
        let origin = stage.tracer.side_origin(point.position_m, point.normal);
        let receiver = Receiver { point_m: point.position_m, normal: point.normal, origin: &origin };
        direct.site(point.weight, PASSES, || sample_direct_lx(stage, quantity, &receiver, &mut room, &mut stream));
        if walk {
            indirect
                .site(point.weight, WALKS, || sample_reflected_lx(stage, quantity, &receiver, &mut cut, &mut stream));
        }
    }
    (direct, indirect)
}

fn of_receivers(context: &Context, set: usize, number: u32) -> DirectShare {
    let (direct, indirect) = costs_at_points(context, set, number, context.stage.reflects());
    let points = context.scene.receivers[set].points.len() as f64;
    share(&direct, indirect.variance, indirect.rays_per_sample(), points)
}

fn of_elements(context: &Context, number: u32) -> DirectShare {
    let (stage, scene) = (context.stage, context.scene);
    let cells = stage.elements.len();
    let stride = cells.div_ceil(MOST_SITES).max(1);
    let mut room = DirectPass::default();
    let mut stream = Stream::new(context.seed, Purpose::Pilot, number, 0);
    let mut direct = Cost::default();
    for index in (0..cells).step_by(stride) {
        stream.seek(index as u64);
        let cell = stage.elements.cell(index as u32);
        let area_m2 = stage.elements.area_m2(scene, cell);
        direct.site(area_m2, PASSES, || room.over_cell(stage, scene, cell, &mut stream));
    }
    // One chain scores Φ/A in every element that it meets: Σ A·var E is Φ² times its mean of Σ 1/A.
    let mut chain_variance = 0.0;
    let mut chain_rays = 0;
    if stage.reflects() {
        let flux_squared = stage.emitters.luminous_flux_lm().powi(2);
        for chain in 0..CHAINS {
            stream.seek((cells as u64) + chain);
            let choice = (chain as f64 + stream.fine_unit()) / CHAINS as f64;
            let (_, rays) = stage.trace_chain(choice, &mut stream, |arrival| {
                if arrival.bounces > 0
                    && let Some(cell) =
                        stage.elements.cell_at(arrival.hit.triangle, arrival.hit.barycentric, arrival.hit.side)
                {
                    chain_variance += flux_squared / stage.elements.area_m2(scene, stage.elements.cell(cell));
                }
            });
            chain_rays += rays;
        }
    }
    // Sites stand for all cells: their summed variance is scaled up, a chain's holds for the whole map already.
    let direct_variance = direct.variance * cells as f64 / direct.sites.max(1.0);
    let scaled = Cost { variance: direct_variance, ..direct };
    share(&scaled, chain_variance / CHAINS as f64, chain_rays as f64 / CHAINS as f64 / cells as f64, cells as f64)
}

/// Summed weighted variance and counted rays of some sites.
#[derive(Default)]
struct Cost {
    sites: f64,
    variance: f64,
    samples: f64,
    rays: f64,
}

impl Cost {
    fn site(&mut self, weight: f64, samples: u64, mut sample: impl FnMut() -> (f64, u64)) {
        let mut spread = Spread::default();
        for _ in 0..samples {
            let (lx, rays) = sample();
            spread.add(lx);
            self.rays += rays as f64;
        }
        self.sites += 1.0;
        self.samples += samples as f64;
        self.variance += weight * spread.variance();
    }

    fn rays_per_sample(&self) -> f64 {
        if self.samples > 0.0 { self.rays / self.samples } else { 0.0 }
    }
}

/// The best share, from variances summed over the same sites and rays per entry of the map.
fn share(direct: &Cost, indirect_variance: f64, indirect_rays_per_entry: f64, entries: f64) -> DirectShare {
    let direct_rays = direct.rays_per_sample();
    let rays_ratio = indirect_rays_per_entry / direct_rays.max(LEAST_RAYS_PER_PASS);
    let best = (direct.variance / indirect_variance * rays_ratio).sqrt();
    let best = if best.is_nan() { 0.0 } else { best };
    DirectShare {
        passes_per_sample: best.clamp(LEAST_RAY_SHARE * rays_ratio, MOST_RAY_SHARE * rays_ratio),
        rays_per_pass: direct_rays * entries,
        rays_per_indirect: indirect_rays_per_entry * entries,
    }
}
