//! Local estimation: every vertex of a chain scores at every receiver, Q f K V. K = R(ω) cos θ′/d² is the response of the receiver to light
//! from the vertex. For luminance the receiver is the sub-point of a line of sight (double local estimation).
//!
//! K has no bound: 1/d² in corners. So chains score only min(K, c). The part that this cuts off, the near field, comes from walks that
//! start at the receiver. They count what they meet with the share (1 − c/K)⁺ (docs/methods.md (22), (23)). Both parts have finite variance
//! wherever the receiver lies, and their sum is exact whatever c is. The bound c may depend on the vertex: c = β E_c (docs/methods.md
//! (24)), with E_c the approximate illuminance there. Chains often visit bright places, and walks do better in dark ones.

use std::f64::consts::PI;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::anchor_blocks::{AnchorBlocks, Choice, PlaneAnchor, ScoringVertex};
use super::receiver::Receiver;
use super::reception::sample_share_of_reflected_lx;
use super::sight::{Seen, SubPoint, trace_sight};
use super::small_body::SmallBody;
use crate::geometry::Origin;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::sampling::reflection::{Bsdf, LobeKind, Pair};
use crate::scene::{Quantity, ReceiverSet};
use crate::transport::{Arrival, Traced, World};

/// Branches of a line of sight below this share are followed by chance, once and for all. No sample draws them again, so they must be
/// negligible.
const FAINT_BRANCH: f64 = 1e-4;

/// The number of walks is inverse to an entry's level, within this many doublings or halvings of the usual number.
const MOST_DOUBLINGS: f64 = 2.0;
/// Branches of a chain after its first arrival. Most light is near the luminaires, and a single packet seldom leaves from there towards a
/// receiver.
pub const BRANCHES: u32 = 4;
/// Factor on the bounds for light that was reflected before, since branches bring it more often.
const BRANCHES_COUNT: f64 = 2.0;
/// With more emitters than this, the level is assumed to be the same everywhere.
const MOST_EMITTERS: usize = 32;
/// Direct levels reach at most this factor above indirect ones: the kernel must stay bounded near a luminaire.
const MOST_LEVELS: f64 = 1e3;

/// Response of an anchor to light from a direction.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
enum PlaceResponse {
    /// The cosine.
    Plane,
    /// That of a small body.
    Body(SmallBody),
    /// The cosine times π/ρ of the part of the BSDF outside the lobe.
    Gloss { triangle: u32, leaving: DVec3 },
}

/// A point at which vertices of chains score (an anchor).
#[derive(Clone, Debug, Serialize, Deserialize)]
struct ScorePlace {
    /// Entry of the map.
    entry: u32,
    point_m: DVec3,
    normal: DVec3,
    origin: Origin,
    /// Value of a full response: 1 for illuminances; for luminance, the luminance at the eye for each lx.
    scale: f64,
    response: PlaceResponse,
}

/// All anchors of a receiver set, stored for fast access.
#[derive(Serialize, Deserialize)]
pub struct Anchors {
    list: Vec<ScorePlace>,
    /// Range of anchors of every entry.
    of_entry: Vec<std::ops::Range<u32>>,
    sub_points: Vec<Vec<SubPoint>>,
    planes: bool,
    /// Approximate indirect illuminance of the surfaces that receivers see, in lx.
    indirect_level_lx: f64,
    /// Corners of the bounding box of all anchors, in m.
    box_m: [DVec3; 2],
    /// The common normal of all planes, if they have one.
    common_normal: Option<DVec3>,
    /// The anchors in blocks, once their levels and bounds are known. Used where all are planes.
    blocks: AnchorBlocks,
    /// Approximate level of every anchor itself, in units of the map.
    own_levels: Vec<f64>,
    /// Ratio of an anchor's bound to the usual bound: with fewer walks the bound is higher.
    bound_factors: Vec<f64>,
    /// Ratio of an entry's number of walks to the usual number: a power of 2.
    walk_rates: Vec<f64>,
}

/// A vertex of a chain: a surface that a packet met.
#[derive(Clone, Copy, Debug)]
pub struct ChainVertex {
    /// The arrival.
    pub arrival: Arrival,
    /// Unit normal of the side that it arrived at.
    pub normal: DVec3,
    point_m: DVec3,
    /// Share of the chain's flux that arrives.
    share: f64,
    /// Approximate illuminance of the point in lx by light of the same kind (direct or reflected), times how often chains meet it.
    pub level_lx: f64,
}

/// Parameters of the connections.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Connecting {
    /// Bound β of the kernel over the level, in 1/(m²·lx). Infinite for the naive kernel.
    pub bound: f64,
    /// Scores for one lm below this share of the anchor's own level are left to chance, stratified. 0: none is.
    pub threshold: f64,
}

impl Anchors {
    /// The anchors of a receiver set.
    pub fn of(world: &World, receivers: &ReceiverSet, seed: u64, number: u32) -> Anchors {
        let mut anchors = Anchors {
            list: Vec::new(),
            of_entry: Vec::new(),
            sub_points: Vec::new(),
            planes: true,
            indirect_level_lx: 1.0,
            box_m: [DVec3::INFINITY, DVec3::NEG_INFINITY],
            common_normal: None,
            blocks: AnchorBlocks::default(),
            own_levels: Vec::new(),
            bound_factors: Vec::new(),
            walk_rates: vec![1.0; receivers.points.len()],
        };
        let mut stream = Stream::new(seed, Purpose::Pilot, number, 2);
        for (entry, point) in receivers.points.iter().enumerate() {
            let first = anchors.list.len() as u32;
            let origin = world.tracer.side_origin(point.position_m, point.normal);
            let mut ends = Vec::new();
            if receivers.quantity == Quantity::Luminance && !point.inside {
                stream.seek(entry as u64);
                trace_sight(world, &origin, point.normal, FAINT_BRANCH, &mut stream, |seen| {
                    if let Seen::Surface(end) = seen {
                        ends.push(end);
                    }
                });
                ends.iter().for_each(|end| anchors.add_sub_point(world, entry as u32, end));
            } else if !point.inside {
                let response = SmallBody::of(receivers.quantity).map_or(PlaceResponse::Plane, PlaceResponse::Body);
                anchors.planes &= matches!(response, PlaceResponse::Plane);
                anchors.list.push(ScorePlace {
                    entry: entry as u32,
                    point_m: point.position_m,
                    normal: point.normal,
                    origin,
                    scale: 1.0,
                    response,
                });
            }
            anchors.sub_points.push(ends);
            anchors.of_entry.push(first..anchors.list.len() as u32);
        }
        anchors.bound_factors = vec![1.0; anchors.list.len()];
        for anchor in &anchors.list {
            anchors.box_m = [anchors.box_m[0].min(anchor.point_m), anchors.box_m[1].max(anchor.point_m)];
        }
        let shared = |normal: &DVec3| anchors.planes && anchors.list.iter().all(|anchor| anchor.normal == *normal);
        anchors.common_normal = anchors.list.first().map(|anchor| anchor.normal).filter(shared);
        anchors
    }

    fn add_sub_point(&mut self, world: &World, entry: u32, end: &SubPoint) {
        let front = ScorePlace {
            entry,
            point_m: end.point_m,
            normal: end.normal,
            origin: end.origin,
            scale: 0.0,
            response: PlaceResponse::Plane,
        };
        match world.bsdf(end.hit.triangle) {
            Bsdf::Diffuse(bsdf) => self.list.push(ScorePlace { scale: end.share * bsdf.reflectance / PI, ..front }),
            Bsdf::Translucent(bsdf) => {
                let behind = ScorePlace { normal: -end.normal, origin: end.behind(world), ..front.clone() };
                self.list.push(ScorePlace { scale: end.share * bsdf.reflectance / PI, ..front });
                self.list.push(ScorePlace { scale: end.share * bsdf.transmittance / PI, ..behind });
            }
            bsdf if bsdf.is_specular() => {}
            bsdf => {
                self.planes = false;
                let response = PlaceResponse::Gloss { triangle: end.hit.triangle, leaving: -end.direction };
                self.list.push(ScorePlace { scale: end.share * bsdf.total(1.0) / PI, response, ..front });
            }
        }
    }

    /// Sets the level of indirect light and the anchors' own levels, which follow from it.
    pub fn set_levels(&mut self, world: &World, indirect_level_lx: f64) {
        self.indirect_level_lx = indirect_level_lx.max(f64::MIN_POSITIVE);
        let levels = self.list.iter().map(|anchor| {
            let [direct_lx, indirect_lx] = self.levels_lx(world, anchor.point_m, anchor.normal);
            anchor.scale * (direct_lx + indirect_lx)
        });
        self.own_levels = levels.collect();
    }

    /// Gives dark entries more walks and bright ones fewer. Chains visit bright places, so they leave a larger relative error at darker
    /// ones.
    pub fn set_walk_rates(&mut self) {
        let level = |entry: &std::ops::Range<u32>| {
            self.own_levels[entry.start as usize..entry.end as usize].iter().sum::<f64>()
        };
        let logs: Vec<f64> = self.of_entry.iter().map(|entry| level(entry).log2()).collect();
        let lit = || logs.iter().filter(|log| log.is_finite());
        let usual = lit().sum::<f64>() / lit().count().max(1) as f64;
        for (rate, log) in self.walk_rates.iter_mut().zip(&logs).filter(|(_, log)| log.is_finite()) {
            *rate = (usual - log).round().clamp(-MOST_DOUBLINGS, MOST_DOUBLINGS).exp2();
        }
        for (factor, anchor) in self.bound_factors.iter_mut().zip(&self.list) {
            *factor = 1.0 / self.walk_rates[anchor.entry as usize];
        }
        if !self.planes {
            return;
        }
        let stored = |((anchor, level), factor): ((&ScorePlace, &f64), &f64)| PlaneAnchor {
            point_m: anchor.point_m,
            normal: anchor.normal,
            relative_scale: if *level > 0.0 { anchor.scale / level } else { 0.0 },
            bound_factor: *factor,
        };
        let with_levels = self.list.iter().zip(&self.own_levels).zip(&self.bound_factors);
        self.blocks = AnchorBlocks::of(&with_levels.map(stored).collect::<Vec<PlaneAnchor>>());
    }

    /// Ratio of an entry's number of walks to the usual number: a power of 2.
    pub fn walk_rate(&self, entry: usize) -> f64 {
        self.walk_rates[entry]
    }

    /// Ratio of an anchor's bound to the usual bound.
    pub fn bound_factor(&self, anchor: usize) -> f64 {
        self.bound_factors[anchor]
    }

    /// Level of an anchor itself, in units of the map.
    pub fn own_level(&self, anchor: usize) -> f64 {
        self.own_levels[anchor]
    }

    /// Anchors of an entry of the map.
    pub fn of_entry(&self, entry: usize) -> std::ops::Range<usize> {
        self.of_entry[entry].start as usize..self.of_entry[entry].end as usize
    }

    /// Value of a full response of an anchor.
    pub fn scale(&self, anchor: usize) -> f64 {
        self.list[anchor].scale
    }

    /// Mean value of a full response over the anchors.
    pub fn mean_scale(&self) -> f64 {
        self.list.iter().map(|anchor| anchor.scale).sum::<f64>() / self.list.len().max(1) as f64
    }

    /// Vertex for an arrival of a chain. `None` if the surface scatters nothing that connections could find. `share` is the share of the
    /// chain's flux that arrives.
    pub fn vertex(&self, world: &World, arrival: &Arrival, share: f64) -> Option<ChainVertex> {
        let bsdf = world.bsdf(arrival.hit.triangle);
        if bsdf.is_black() || bsdf.is_specular() {
            return None;
        }
        let point_m = world.tracer.position_m(&world.leave(&arrival.hit, LobeKind::Spread));
        let normal = world.normal_at(&arrival.hit);
        let scatters_through = matches!(bsdf, Bsdf::Translucent(_));
        if !scatters_through && self.is_out_of_reach(point_m, normal) {
            return None;
        }
        let level_lx =
            if arrival.bounces == 0 { self.direct_level_lx(world, point_m, normal) } else { self.reflected_level_lx() };
        Some(ChainVertex { arrival: *arrival, normal, point_m, share, level_lx })
    }

    /// Whether no anchor lies in front of a surface, or none faces it. Nothing that it scatters then reaches an anchor.
    fn is_out_of_reach(&self, point_m: DVec3, normal: DVec3) -> bool {
        let foremost_m = DVec3::select(normal.cmpgt(DVec3::ZERO), self.box_m[1], self.box_m[0]);
        let is_behind_all = || {
            self.common_normal.is_some_and(|facing| {
                let lowest_m = DVec3::select(facing.cmpgt(DVec3::ZERO), self.box_m[0], self.box_m[1]);
                (point_m - lowest_m).dot(facing) <= 0.0
            })
        };
        (foremost_m - point_m).dot(normal) <= 0.0 || is_behind_all()
    }

    /// Approximate illuminances of a point in lx, by luminaires and by reflections. Any function of the point gives correct results; a good
    /// one saves work.
    fn levels_lx(&self, world: &World, point_m: DVec3, normal: DVec3) -> [f64; 2] {
        [self.direct_level_lx(world, point_m, normal), self.reflected_level_lx()]
    }

    fn direct_level_lx(&self, world: &World, point_m: DVec3, normal: DVec3) -> f64 {
        let emitters = world.emitters.list();
        if emitters.len() > MOST_EMITTERS {
            return self.indirect_level_lx;
        }
        let direct_lx: f64 = emitters.iter().map(|emitter| emitter.importance_lx(point_m, normal)).sum();
        direct_lx.min(MOST_LEVELS * self.indirect_level_lx)
    }

    fn reflected_level_lx(&self) -> f64 {
        BRANCHES_COUNT * self.indirect_level_lx
    }

    /// Score of an anchor for one lm at a vertex without occlusion, with the kernel bounded.
    fn score(&self, world: &World, vertex: &ChainVertex, bound: f64, anchor: usize) -> f64 {
        let bound_per_m2 = bound * vertex.level_lx * self.bound_factors[anchor];
        let [kernel_per_m2, spread_per_sr] = self.kernel_and_spread(world, anchor, vertex);
        spread_per_sr * self.list[anchor].scale * kernel_per_m2.min(bound_per_m2)
    }

    /// The kernel of an anchor and a vertex in 1/m², and the share that the vertex scatters in that direction, in 1/sr.
    pub fn kernel_and_spread(&self, world: &World, anchor: usize, vertex: &ChainVertex) -> [f64; 2] {
        let anchor = &self.list[anchor];
        let offset_m = anchor.point_m - vertex.point_m;
        [
            self.kernel_per_m2(world, anchor, vertex.point_m, vertex.normal),
            vertex.share * spread_per_sr(world.bsdf(vertex.arrival.hit.triangle), vertex, offset_m),
        ]
    }

    /// For the pilot: transmittance between an anchor and a vertex, 0 to 1.
    pub fn transmittance(&self, world: &World, anchor: usize, vertex: &ChainVertex) -> f64 {
        let anchor = &self.list[anchor];
        let is_behind = (anchor.point_m - vertex.point_m).dot(vertex.normal) < 0.0;
        let lobe = if is_behind { LobeKind::SpreadThrough } else { LobeKind::Spread };
        world.transmittance(&anchor.origin, &world.leave(&vertex.arrival.hit, lobe))
    }

    /// R(ω) cos θ′/d² of an anchor and a surface point with a normal, in 1/m². For surfaces that scatter to both sides, the side that faces
    /// the anchor counts.
    fn kernel_per_m2(&self, world: &World, anchor: &ScorePlace, point_m: DVec3, normal: DVec3) -> f64 {
        let offset_m = point_m - anchor.point_m;
        let square = offset_m.length_squared();
        // With R d and d cos θ_y, a plane needs no square root.
        let response_m = anchor.response.times_distance_m(world, anchor.normal, offset_m);
        response_m * normal.dot(offset_m).abs() / (square * square).max(f64::MIN_POSITIVE)
    }

    /// Lets a vertex score: calls `add(entry, score)` for one lm with the visible part of each score. Returns the number of rays.
    ///
    /// The threshold t applies to scores divided by the anchor's own level. Scores at or above t count in full. The others are chosen in
    /// proportion, by equal steps of t through their running sum, and count by the inverse of the probability: about t. Each score is
    /// unbiased. The number of rays for them is their sum divided by t.
    pub fn connect(
        &self,
        world: &World,
        vertex: &ChainVertex,
        connecting: &Connecting,
        variate: f64,
        chosen: &mut Vec<Choice>,
        mut add: impl FnMut(usize, f64),
    ) -> u64 {
        self.choose(world, vertex, connecting, variate, chosen);
        let hit = &vertex.arrival.hit;
        let sides = [world.leave(hit, LobeKind::Spread), world.leave(hit, LobeKind::SpreadThrough)];
        let mut rays = 0;
        for (number, probability) in chosen.iter() {
            let score = self.score(world, vertex, connecting.bound, *number);
            if score <= 0.0 {
                continue;
            }
            let anchor = &self.list[*number];
            let is_behind = (anchor.point_m - vertex.point_m).dot(vertex.normal) < 0.0;
            rays += 1;
            let transmittance = world.transmittance(&anchor.origin, &sides[usize::from(is_behind)]);
            if transmittance > 0.0 {
                add(anchor.entry as usize, score / probability * transmittance);
            }
        }
        rays
    }

    /// Lists the anchors that a vertex connects to.
    fn choose(
        &self,
        world: &World,
        vertex: &ChainVertex,
        connecting: &Connecting,
        variate: f64,
        chosen: &mut Vec<Choice>,
    ) {
        let Connecting { bound, threshold } = *connecting;
        if let (Bsdf::Diffuse(bsdf), true) = (world.bsdf(vertex.arrival.hit.triangle), self.planes && threshold > 0.0) {
            let (point_m, normal) = (vertex.point_m, vertex.normal);
            let factor = vertex.share * bsdf.reflectance / PI / threshold;
            let vertex = ScoringVertex { point_m, normal, factor, bound_per_m2: bound * vertex.level_lx };
            self.blocks.choose(&vertex, variate, chosen);
            return;
        }
        chosen.clear();
        let mut until_next = variate;
        for (anchor, own_level) in self.own_levels.iter().enumerate() {
            let (score, full) = (self.score(world, vertex, bound, anchor), threshold * own_level);
            if score >= full {
                chosen.push((anchor, 1.0));
                continue;
            }
            until_next -= score / full;
            if until_next < 0.0 {
                chosen.push((anchor, score / full));
                until_next += 1.0;
            }
        }
    }

    /// One unbiased sample of what connections omit at an entry, and the number of rays: the near field beyond the bound, lobes and
    /// mirrors.
    pub fn sample_rest(
        &self,
        world: &World,
        receivers: &ReceiverSet,
        entry: usize,
        bound: f64,
        cut: &mut Cut,
        stream: &mut Stream,
    ) -> Traced {
        let bound = bound / self.walk_rates[entry];
        let share_at = |anchor: &ScorePlace, point_m: DVec3, normal: DVec3| {
            let kernel_per_m2 = self.kernel_per_m2(world, anchor, point_m, normal);
            if kernel_per_m2 <= 0.0 {
                // A receiver in the plane of a surface: rounding lets walks meet the surface, and connections omit it.
                return [1.0; 2];
            }
            self.levels_lx(world, point_m, normal).map(|level_lx| {
                let bound_per_m2 = bound * level_lx;
                if kernel_per_m2 > bound_per_m2 { 1.0 - bound_per_m2 / kernel_per_m2 } else { 0.0 }
            })
        };
        let anchors = &self.list[self.of_entry(entry)];
        if receivers.quantity != Quantity::Luminance {
            let Some(anchor) = anchors.first() else {
                return Traced::default();
            };
            let receiver = Receiver { point_m: anchor.point_m, normal: anchor.normal, origin: &anchor.origin };
            let share_of = |point_m: DVec3, normal: DVec3| share_at(anchor, point_m, normal);
            return sample_share_of_reflected_lx(world, receivers.quantity, &receiver, share_of, cut, stream);
        }
        let mut sum = Traced::default();
        let mut next = anchors.iter();
        for end in &self.sub_points[entry] {
            let both_sides = matches!(world.bsdf(end.hit.triangle), Bsdf::Translucent(_));
            let (Some(front), behind) = (next.next(), if both_sides { next.next() } else { None }) else {
                break;
            };
            let share_of = |lobe: LobeKind, point_m: DVec3, normal: DVec3| match lobe {
                LobeKind::Glossy => [1.0; 2],
                LobeKind::SpreadThrough => share_at(behind.unwrap_or(front), point_m, normal),
                _ => share_at(front, point_m, normal),
            };
            sum += end.share * end.sample_rest_cd_m2(world, share_of, cut, stream);
        }
        sum
    }
}

impl PlaceResponse {
    /// Response to light from an offset in m, times its length. The response is 1 for a plane that faces it.
    fn times_distance_m(&self, world: &World, normal: DVec3, offset_m: DVec3) -> f64 {
        let distance_m = || offset_m.length();
        let towards = || offset_m.normalize_or_zero();
        match self {
            PlaceResponse::Plane => normal.dot(offset_m).max(0.0),
            PlaceResponse::Body(body) => distance_m() * body.response(towards()),
            PlaceResponse::Gloss { triangle, leaving } => {
                let bsdf = world.bsdf(*triangle);
                let spread_per_sr = bsdf.spread_per_sr(&Pair { normal, towards: towards(), leaving: *leaving });
                PI / bsdf.total(1.0) * spread_per_sr * normal.dot(offset_m).max(0.0)
            }
        }
    }
}

/// The part of a vertex' BSDF that connections find, towards a place at an offset in m, in 1/sr.
fn spread_per_sr(bsdf: &Bsdf, vertex: &ChainVertex, offset_m: DVec3) -> f64 {
    let is_behind = offset_m.dot(vertex.normal) < 0.0;
    match bsdf {
        Bsdf::Diffuse(bsdf) if !is_behind => bsdf.reflectance / PI,
        Bsdf::Translucent(bsdf) => (if is_behind { bsdf.transmittance } else { bsdf.reflectance }) / PI,
        Bsdf::Diffuse(_) => 0.0,
        bsdf => {
            let leaving = offset_m.normalize_or_zero();
            bsdf.spread_per_sr(&Pair { normal: vertex.normal, towards: -vertex.arrival.direction, leaving })
        }
    }
}
