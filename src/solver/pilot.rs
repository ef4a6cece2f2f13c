//! A short pilot before the run. It measures the cost of a sample of each part of a map and the scatter of its values.
//! Its samples enter no result. Let a sample have variance v and cost c (in counted rays). Two independent parts of a sum are best sampled
//! in the ratio √(v₁c₂ / v₂c₁), and reach an error ε with (√(v₁c₁) + √(v₂c₂))²/ε² rays.

mod walks;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::adapt::Adaptive;
use super::context::Context;
use crate::base::scattered::scattered;
use crate::estimators::control_variate::ControlVariates;
use crate::estimators::direct::DirectPass;
use crate::estimators::element::Element;
use crate::estimators::neighbours::Sharing;
use crate::estimators::receiver::Receiver;
use crate::estimators::reception::DirectSampler;
use crate::estimators::walk::sample_indirect_lx;
use crate::maps::MapKind;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::scene::{Elements, IntensityTable};
use crate::transport::Traced;

/// Most points or elements that the pilot samples.
const MOST_SITES: usize = 256;
/// Direct passes at each of them.
const PASSES: u64 = 4;
/// Walks at each element or point.
const WALKS: u64 = 4;
/// Fewest passes, or walks, of all points together: a few points need more each to show their scatter.
const LEAST_SAMPLES: u64 = 512;
/// Fewest passes, or walks, of all sets together: with ten thousand sets of one point each, pilots would take seconds.
const LEAST_SAMPLES_OF_ALL: u64 = 64 * LEAST_SAMPLES;
/// Passes, or walks, of each point if the run has ended: there may be thousands of sets, each with a pilot.
const SAMPLES_IN_HASTE: u64 = 2;
/// Chains traced for elements.
const CHAINS: usize = 1024;
/// Chains traced for light that leaves the scene.
const LEAVING_CHAINS: usize = 4096;
/// Rays of chains or walks after which a pilot has enough: in nearly white rooms each chain or walk takes thousands of them.
pub const ENOUGH_RAYS: u64 = 1_000_000;
/// Fewest chains, or points from which walks start, in any case.
pub const FEWEST_SITES: usize = 16;
/// Rays at a site between two readings of the clock, and the fewest samples there.
const RAYS_BETWEEN_LOOKS: f64 = 10_000.0;
const FEWEST_SAMPLES: u64 = 2;
/// Survey samples of an emitter that brings all the light: the usual number, the fewest and the most.
const USUAL_SURVEY: f64 = 64.0;
const FEWEST_SURVEY: f64 = 16.0;
const MOST_SURVEY: f64 = 4096.0;
/// If the best number of survey samples differs by this factor or more, another pilot is worthwhile.
const WORTH_ANOTHER: f64 = 2.0;
/// Share of the squared error that direct light may have, for choosing that number.
const SHARE_OF_ERROR: f64 = 0.5;
/// Bounds of the rays that direct light takes, relative to those of indirect light. A pilot that saw no penumbra does not prove that there
/// is none.
const LEAST_RAY_SHARE: f64 = 0.02;
pub const MOST_RAY_SHARE: f64 = 8.0;

/// Lowest cost of a pass, in rays per entry. It takes time even if no visibility is uncertain or emitters bring nothing.
const LEAST_RAYS_PER_PASS: f64 = 0.1;

/// Luminaires, and groups of them, that light sampling evaluates in about the time of one ray: among ten thousand, a light sample takes the
/// time of ten rays. (Measured: 18 ns each, one thread, compared with 0.3 µs for a ray.)
pub const WEIGHED_PER_RAY: f64 = 16.0;

/// Approximate time of a ray between a point and a neighbour that shares it, relative to any other ray. (Measured: 0.037 µs compared with
/// 0.13 in an office. Five rooms to 1 %, two seeds: 0.3 and 0.8 take 1.02 and 1.00 of the time.)
const WORK_OF_A_SHARING_RAY: f64 = 0.55;

/// Cost of one sample of one part of a map, and its scatter.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct PartCost {
    /// Variance of an entry's value in the squared unit of the map's values, weighted mean over the entries.
    pub variance: f64,
    /// Rays per entry.
    pub rays: f64,
    /// Those of `rays` that go between points and neighbours that share them (`estimators::neighbours`). They are short and similar, so
    /// they take less time.
    pub sharing_rays: f64,
    /// Cost of choosing among luminaires, in rays; not included in `rays`.
    pub choosing: f64,
    /// Weighted mean of the part, in the unit of the map's values.
    pub mean: f64,
    /// Rays that the pilot took for this.
    pub pilot_rays: u64,
}

impl PartCost {
    /// The cost for entries that show `numbers` numbers each.
    pub fn times(self, numbers: f64) -> PartCost {
        PartCost { variance: self.variance * numbers, ..self }
    }

    /// Work of an entry, in rays that take their full time, without choosing among luminaires.
    pub fn work(&self) -> f64 {
        self.rays - (1.0 - WORK_OF_A_SHARING_RAY) * self.sharing_rays
    }
}

/// Cost of a sample of indirect light.
#[derive(Clone, Copy, Debug)]
pub struct IndirectCost {
    /// If every entry counts only its own samples.
    pub alone: PartCost,
    /// If neighbours share what their walks meet, in the form that takes the least work.
    pub shared: PartCost,
    pub sharing: Sharing,
    /// Factor of work that sharing walks out among points will save, as far as groups of neighbours show it; 1 if none.
    pub gain_to_come: f64,
}

impl IndirectCost {
    /// Cost for entries that share nothing.
    pub fn alone(cost: PartCost) -> IndirectCost {
        IndirectCost { alone: cost, shared: cost, sharing: Sharing::default(), gain_to_come: 1.0 }
    }
}

/// How direct and indirect light share the work of a map.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct DirectShare {
    /// Passes over direct light for each chain (elements) or for each walk per point (receivers).
    pub passes_per_sample: f64,
    /// Rays of a pass over all entries.
    pub rays_per_pass: f64,
    /// Rays of a sample of indirect light.
    pub rays_per_indirect: f64,
}

impl DirectShare {
    /// The best share for the two parts of a map, each with its number of entries.
    pub fn of(direct: PartCost, indirect: PartCost, [direct_entries, indirect_entries]: [usize; 2]) -> DirectShare {
        let rays = direct.rays.max(LEAST_RAYS_PER_PASS);
        let rays_ratio = indirect.rays * indirect_entries as f64 / (rays * direct_entries.max(1) as f64);
        let best = (direct.variance / indirect.variance * rays_ratio).sqrt();
        let best = if best.is_nan() { 0.0 } else { best };
        let rays_ratio = if rays_ratio.is_nan() { 0.0 } else { rays_ratio };
        DirectShare {
            passes_per_sample: best.clamp(LEAST_RAY_SHARE * rays_ratio, MOST_RAY_SHARE * rays_ratio),
            rays_per_pass: rays * direct_entries as f64,
            rays_per_indirect: indirect.rays * indirect_entries as f64,
        }
    }
}

/// Measures a pass over the direct light of a map. Elements that adapt are sampled point by point. Also returns the plan for the control
/// variates of points, none of which is computed yet.
pub fn direct_cost(
    context: &Context,
    kind: MapKind,
    elements: &Elements,
    adaptive: Option<&Adaptive>,
) -> (PartCost, ControlVariates) {
    let (world, scene) = (context.world, context.scene);
    if let MapKind::Receivers(set) = kind {
        return direct_cost_at_points(context, set);
    }
    let mut scratch = DirectPass::default();
    let mut stream = Stream::new(context.seed, Purpose::Pilot, kind.number(), 0);
    let mut sites = Sites::default();
    for index in (0..elements.len()).step_by(elements.len().div_ceil(MOST_SITES).max(1)) {
        stream.seek(index as u64);
        let contact_free = adaptive.map_or(1.0, |adaptive| adaptive.contact_free[index]);
        let element = Element::of(world, scene, elements, index as u32).contact_free(contact_free);
        if contact_free == 0.0 {
            continue;
        }
        if sites.samples >= (FEWEST_SITES as u64 * PASSES) as f64 && context.is_over() {
            break;
        }
        match adaptive.map(|adaptive| (adaptive, adaptive.references_lx[index][0], adaptive.direct_samples.of(index))) {
            Some((adaptive, reference, samples)) => sites.add(context, element.area_m2, PASSES, || {
                // The mean, from the reference, and the random error of the light that differs from the reference.
                let mut sum = Traced::default();
                for _ in 0..samples {
                    let seen = scratch.sample_twice(world, &element, &adaptive.expected[index], &mut stream);
                    let lx = 0.5 * (seen.samples_lx[0] + seen.samples_lx[1]);
                    sum += Traced { value: reference.0[0] + lx - reference.at(seen.at), rays: seen.rays };
                }
                sum / samples as f64
            }),
            None => sites.add(context, element.area_m2, PASSES, || scratch.over_element(world, &element, &mut stream)),
        }
    }
    (sites.cost(), ControlVariates::planned(USUAL_SURVEY))
}

/// Cost of direct light at points. A first pilot uses the usual number of survey samples. If the best number is far from that, a second
/// pilot uses as many rays for survey samples as for samples. This is best where the remaining variance of samples falls with the root of
/// the survey samples. Fewer survey samples are not tried where most surveys are already made.
fn direct_cost_at_points(context: &Context, set: usize) -> (PartCost, ControlVariates) {
    let (usual, made, survey_rays) = cost_of_surveyed(context, set, USUAL_SURVEY);
    let absolute_error = context.target_error * usual.mean;
    let rays_of_samples = usual.variance * usual.rays / (SHARE_OF_ERROR * absolute_error * absolute_error);
    let ratio = rays_of_samples / survey_rays;
    let can_save = made.rays_to_make > usual.pilot_rays as f64;
    if !ratio.is_finite() || ratio < WORTH_ANOTHER && !(ratio < 1.0 / WORTH_ANOTHER && can_save) {
        return (usual, made);
    }
    let survey_samples = (USUAL_SURVEY * ratio).clamp(FEWEST_SURVEY, MOST_SURVEY);
    let (cost, made, _) = cost_of_surveyed(context, set, survey_samples);
    (PartCost { pilot_rays: usual.pilot_rays + cost.pilot_rays, ..cost }, made)
}

/// Cost of direct light at points with `survey_samples` survey samples, the control variates of these points, which the run keeps, and the
/// survey rays per point.
fn cost_of_surveyed(context: &Context, set: usize, survey_samples: f64) -> (PartCost, ControlVariates, f64) {
    let (world, receivers) = (context.world, &context.scene.receivers[set]);
    let (quantity, points) = (receivers.quantity, receivers.points.len());
    let (mut survey_rays, mut surveyed) = (0, 0);
    let mut made = ControlVariates::planned(survey_samples);
    let passes = samples_of_a_site(context, sites_of(context, set), PASSES);
    let mut sites = Sites::default();
    let measure = |receiver: &Receiver, weight: f64, stream: &mut Stream| {
        let mut scratch = DirectPass::default();
        let control_variate = DirectSampler::control_variate(world, quantity, receiver, &mut scratch, survey_samples);
        let mut sampler = DirectSampler::new(world, quantity, receiver, &mut scratch, &control_variate);
        let mut site = Sites::default();
        site.add(context, weight, passes, || sampler.sample(stream));
        (site, control_variate)
    };
    over_receivers(context, set, 0, measure, |point, (site, control_variate)| {
        sites.merge(&site);
        survey_rays += control_variate.rays;
        surveyed += 1;
        made.keep(point, points, control_variate);
        true
    });
    let cost = sites.cost();
    let rays_per_point = survey_rays as f64 / surveyed.max(1) as f64;
    made.rays_to_make = rays_per_point * (points - surveyed) as f64;
    (PartCost { pilot_rays: cost.pilot_rays + survey_rays, ..cost }, made, rays_per_point)
}

/// Measures a sample of the indirect light of a map by chains (elements) or walks (receivers).
/// `direct_mean` is the mean of its direct light if the target binds the map. Then a pilot of walks takes its share of the work.
pub fn indirect_cost(context: &Context, kind: MapKind, elements: &Elements, direct_mean: Option<f64>) -> IndirectCost {
    let (world, scene) = (context.world, context.scene);
    if !world.reflects() {
        return IndirectCost::alone(PartCost::default());
    }
    match kind {
        MapKind::Elements => {
            let mut stream = Stream::new(context.seed, Purpose::Pilot, kind.number(), 1);
            IndirectCost::alone(chain_cost(context, elements, &mut stream))
        }
        MapKind::Receivers(set) => {
            if let Some(table) = scene.receivers[set].intensity_table() {
                return IndirectCost::alone(leaving_cost(context, set, table));
            }
            walks::cost(context, set, direct_mean)
        }
    }
}

/// Measures walks from random points of elements. `contact_free` is the contact-free share of each element (not hidden by contact); it is empty if
/// elements count as a whole.
pub fn walk_cost_in_elements(context: &Context, elements: &Elements, contact_free: &[f64]) -> PartCost {
    let (world, number) = (context.world, MapKind::Elements.number());
    let stride = elements.len().div_ceil(MOST_SITES).max(1);
    let indices =
        scattered(elements.len().div_ceil(stride)).map(|site| site * stride).filter(|index| *index < elements.len());
    let indices: Vec<usize> =
        indices.filter(|index| contact_free.get(*index).is_none_or(|share| *share > 0.0)).collect();
    let walk_from = |index: &usize| {
        let share = contact_free.get(*index).copied().unwrap_or(1.0);
        let element = Element::of(world, context.scene, elements, *index as u32).contact_free(share);
        let mut stream = Stream::new(context.seed, Purpose::Pilot, number, 4);
        stream.seek(*index as u64);
        let (mut cut, mut site) = (Cut::default(), Sites::default());
        site.add(context, element.area_m2 * share, WALKS, || {
            let (at, drawing_rays) = element.draw_contact_free(world, &mut stream);
            let origin = element.origin(world, at);
            let walked = sample_indirect_lx(world, &element.receiver(world, at, &origin), &mut cut, &mut stream);
            Traced { rays: drawing_rays + walked.rays, ..walked }
        });
        site.weighed = cut.weighed as f64;
        site
    };
    let mut sites = Sites::default();
    for some in indices.chunks(FEWEST_SITES) {
        // A single walk in a nearly white room takes long.
        let walk_in_time = |(place, index)| (place == 0 || !context.is_over()).then(|| walk_from(index));
        let found: Vec<Option<Sites>> = some.par_iter().with_max_len(1).enumerate().map(walk_in_time).collect();
        found.iter().flatten().for_each(|site| sites.merge(site));
        if sites.rays > ENOUGH_RAYS as f64 || context.is_over() {
            break;
        }
    }
    sites.cost()
}

/// Approximate number of points of a set that the pilot samples.
fn sites_of(context: &Context, set: usize) -> u64 {
    let points = context.scene.receivers[set].points.len();
    (points / points.div_ceil(MOST_SITES).max(1)).max(1) as u64
}

/// Passes, or walks, of each of `sites` points, if `usual` is the usual number.
fn samples_of_a_site(context: &Context, sites: u64, usual: u64) -> u64 {
    if context.is_over() {
        return SAMPLES_IN_HASTE;
    }
    let least = LEAST_SAMPLES.min(LEAST_SAMPLES_OF_ALL / context.scene.receivers.len() as u64);
    usual.max(least / sites)
}

/// Samples some points of a set, spread over it, several at a time. Passes on the number and the findings of each in order, as long as more
/// are needed.
fn over_receivers<S: Send>(
    context: &Context,
    set: usize,
    part: u32,
    measure: impl Fn(&Receiver, f64, &mut Stream) -> S + Sync,
    mut needs_more_after: impl FnMut(usize, S) -> bool,
) {
    let points = &context.scene.receivers[set].points;
    let stride = points.len().div_ceil(MOST_SITES).max(1);
    let indices = scattered(points.len().div_ceil(stride)).map(|site| site * stride);
    let indices: Vec<usize> = indices.filter(|index| !points[*index].inside).collect();
    let number = MapKind::Receivers(set).number();
    let measured = |index: &usize| {
        let point = &points[*index];
        let mut stream = Stream::new(context.seed, Purpose::Pilot, number, part);
        stream.seek(*index as u64);
        let origin = context.world.tracer.side_origin(point.position_m, point.normal);
        let receiver = Receiver { point_m: point.position_m, normal: point.normal, origin: &origin };
        measure(&receiver, point.weight, &mut stream)
    };
    let mut done = 0;
    for some in indices.chunks(FEWEST_SITES) {
        // With a million luminaires a single point takes long.
        let measured_in_time =
            |(place, index): (usize, &usize)| (place == 0 || !context.is_over()).then(|| measured(index));
        let found: Vec<Option<S>> = some.par_iter().with_max_len(1).enumerate().map(measured_in_time).collect();
        for (index, site) in some.iter().zip(found).filter_map(|(index, site)| Some((*index, site?))) {
            done += 1;
            if !needs_more_after(index, site) && done >= FEWEST_SITES {
                return;
            }
        }
        if context.is_over() {
            return;
        }
    }
}

/// Cost of a chain. One chain scores Φ/A in every element that it meets: Σ A·var E is Φ² times its mean of Σ 1/A.
fn chain_cost(context: &Context, elements: &Elements, stream: &mut Stream) -> PartCost {
    let (world, scene) = (context.world, context.scene);
    let area_of = |index: u32| elements.area_m2(scene, elements.element(index));
    let flux_squared = world.emitters.luminous_flux_lm().powi(2);
    let count = elements.len();
    let area_m2: f64 = (0..count as u32).map(area_of).sum();
    let (mut variance, mut sum_lm) = (0.0, 0.0);
    let (mut chains, mut rays) = (0, 0);
    for chain in scattered(CHAINS) {
        stream.seek((count + chain) as u64);
        let choice = (chain as f64 + stream.fine_unit()) / CHAINS as f64;
        let (_, chain_rays) = world.trace_chain(choice, stream, |arrival| {
            let hit = &arrival.hit;
            if arrival.bounces > 0
                && let Some(element) = elements.element_at(hit.triangle, hit.barycentric, hit.side)
            {
                variance += flux_squared / area_of(element) / area_m2;
                sum_lm += world.emitters.luminous_flux_lm();
            }
        });
        rays += chain_rays;
        chains += 1;
        if chains >= FEWEST_SITES && rays > ENOUGH_RAYS || context.is_over() {
            break;
        }
    }
    let chains = chains as f64;
    PartCost {
        variance: variance / chains,
        rays: rays as f64 / chains / count as f64,
        sharing_rays: 0.0,
        choosing: 0.0,
        mean: sum_lm / chains / area_m2,
        pilot_rays: rays,
    }
}

/// Measures the cost of a chain and the scatter of its scores: Σ Ω·var I is Φ² times the mean of 1/Ω where it leaves the scene.
fn leaving_cost(context: &Context, set: usize, table: &IntensityTable) -> PartCost {
    let world = context.world;
    let points = &context.scene.receivers[set].points;
    let all_sr: f64 = points.iter().map(|point| point.weight).sum();
    let flux_lm = world.emitters.luminous_flux_lm();
    let mut stream = Stream::new(context.seed, Purpose::Pilot, MapKind::Receivers(set).number(), 1);
    let (mut variance, mut left, mut chains, mut rays) = (0.0, 0.0, 0, 0);
    for chain in scattered(LEAVING_CHAINS) {
        stream.seek(chain as u64);
        let choice = (chain as f64 + stream.fine_unit()) / LEAVING_CHAINS as f64;
        let (_, chain_rays, direction) = world.trace_out(choice, &mut stream);
        if let Some(direction) = direction {
            variance += flux_lm * flux_lm / (points[table.entry_towards(direction)].weight * all_sr);
            left += 1.0;
        }
        rays += chain_rays;
        chains += 1;
        if chains >= FEWEST_SITES && (rays > ENOUGH_RAYS || context.is_over()) {
            break;
        }
    }
    let chains = chains as f64;
    PartCost {
        variance: variance / chains,
        rays: rays as f64 / chains / points.len() as f64,
        sharing_rays: 0.0,
        choosing: 0.0,
        mean: flux_lm * left / chains / all_sr,
        pilot_rays: rays,
    }
}

/// Summed weighted variance and counted rays of some sites.
#[derive(Clone, Default)]
struct Sites {
    weight: f64,
    variance: f64,
    sum: f64,
    samples: f64,
    rays: f64,
    /// Those of `rays` that go between points and neighbours that share them.
    sharing_rays: f64,
    /// Luminaires and groups that light sampling evaluated.
    weighed: f64,
}

impl Sites {
    fn add(&mut self, context: &Context, weight: f64, samples: u64, mut sample: impl FnMut() -> Traced) {
        let (mut sum, mut squares) = (0.0, 0.0);
        let (mut taken, mut read_at) = (0, 0.0);
        while taken < samples {
            let Traced { value: lx, rays } = sample();
            sum += lx;
            squares += lx * lx;
            self.rays += rays as f64;
            taken += 1;
            // Walks may be long, so the clock is read every `RAYS_BETWEEN_LOOKS` rays.
            if self.rays - read_at > RAYS_BETWEEN_LOOKS && taken >= FEWEST_SAMPLES {
                read_at = self.rays;
                if context.is_over() {
                    break;
                }
            }
        }
        self.add_moments(weight, taken as f64, [sum, squares]);
    }

    /// Adds a site from the sum of its samples and the sum of their squares.
    fn add_moments(&mut self, weight: f64, count: f64, [sum, squares]: [f64; 2]) {
        self.weight += weight;
        self.samples += count;
        self.sum += weight * sum / count;
        self.variance += weight * ((squares - sum * sum / count) / (count - 1.0)).max(0.0);
    }

    fn merge(&mut self, other: &Sites) {
        self.weight += other.weight;
        self.variance += other.variance;
        self.sum += other.sum;
        self.samples += other.samples;
        self.rays += other.rays;
        self.sharing_rays += other.sharing_rays;
        self.weighed += other.weighed;
    }

    fn cost(&self) -> PartCost {
        let weight = self.weight.max(f64::MIN_POSITIVE);
        PartCost {
            variance: self.variance / weight,
            rays: self.rays / self.samples.max(1.0),
            sharing_rays: self.sharing_rays / self.samples.max(1.0),
            choosing: self.weighed / WEIGHED_PER_RAY / self.samples.max(1.0),
            mean: self.sum / weight,
            pilot_rays: self.rays as u64,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::check::scene_from_json;
    use crate::scene::Scene;
    use crate::solver::pace::TimeLeft;
    use crate::transport::World;

    /// A room with a lamp and a grid of receivers.
    pub(super) fn room_with(grid: &str) -> Scene {
        let text = format!(
            r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.5 }} }},
            "geometry": [ {{ "name": "r", "type": "box", "min": [0,0,0], "max": [4,3,2], "facing": "inward", "material": "m" }} ],
            "luminaires": [ {{ "name": "a", "type": "point", "position": [1,1,1], "luminous_flux_lm": 100 }} ],
            "receivers": [ {{ "name": "p", "type": "grid", {grid} }} ] }}"#
        );
        scene_from_json(&text, None, Path::new(".")).expect("a valid scene")
    }

    /// The pilot of a set of one point takes hundreds of walks and passes, but few if the time is over. A scene may have thousands of sets,
    /// and each has a pilot.
    #[test]
    fn where_the_time_is_over_a_pilot_takes_few_rays() {
        let scene = room_with(r#""origin": [2,2,1], "u": [1,0,0], "v": [0,0.5,0], "columns": 1, "rows": 1"#);
        let world = World::new(&scene);
        let rays = |time_left: &(dyn Fn() -> TimeLeft + Sync)| {
            let context = Context { time_left, ..Context::of_a_test(&scene, &world, 3) };
            indirect_cost(&context, MapKind::Receivers(0), &Elements::default(), None).shared.pilot_rays
        };
        let [usual, in_haste] = [rays(&|| TimeLeft::Enough), rays(&|| TimeLeft::None)];
        assert!(usual > 500 && in_haste > 0 && 50 * in_haste < usual, "{usual}, {in_haste}");
    }

    /// Of 600 points beside a lamp of two triangles the pilot surveys every third one, and of 150 points all. The control variates that it
    /// passes on are those that a run would make. Planted fault: with another number of survey samples they are not.
    #[test]
    fn control_variates_of_a_pilot_are_those_of_the_run() {
        for (columns, rows, surveyed) in [(30, 20, 200), (15, 10, 150)] {
            let text = format!(
                r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.5 }} }},
                "geometry": [
                    {{ "name": "r", "type": "box", "min": [0,0,0], "max": [4,3,2], "facing": "inward", "material": "m" }},
                    {{ "name": "lamp", "type": "rectangle", "origin": [1,1,1.9], "u": [0,1,0], "v": [2,0,0], "material": "m" }},
                    {{ "name": "block", "type": "box", "min": [1.5,1,0.5], "max": [2,2,1], "material": "m" }} ],
                "luminaires": [ {{ "name": "a", "type": "area", "surface": "lamp", "exitance_lm_m2": 50 }} ],
                "receivers": [ {{ "name": "p", "type": "grid", "origin": [0.1,0.1,0.1], "u": [3.8,0,0], "v": [0,2.8,0],
                    "columns": {columns}, "rows": {rows} }} ] }}"#
            );
            let scene = scene_from_json(&text, None, Path::new(".")).expect("a valid scene");
            let world = World::new(&scene);
            let context = Context::of_a_test(&scene, &world, 3);
            let (_, made) = direct_cost_at_points(&context, 0);
            let (mut kept, mut rays, mut others) = (0, 0, 0);
            for (index, point) in scene.receivers[0].points.iter().enumerate() {
                let Some(found) = made.of(index) else { continue };
                let origin = world.tracer.side_origin(point.position_m, point.normal);
                let receiver = Receiver { point_m: point.position_m, normal: point.normal, origin: &origin };
                let of_run = |survey_samples: f64| {
                    let mut pass = DirectPass::default();
                    let quantity = scene.receivers[0].quantity;
                    let made = DirectSampler::control_variate(&world, quantity, &receiver, &mut pass, survey_samples);
                    format!("{made:?}")
                };
                assert_eq!(format!("{found:?}"), of_run(made.survey_samples), "point {index}");
                others += u32::from(format!("{found:?}") != of_run(2.0 * made.survey_samples));
                (kept, rays) = (kept + 1, rays + found.rays);
            }
            assert!(kept == surveyed && rays > 0 && others > 0, "{kept} {rays} {others}");
            let to_make = rays as f64 / surveyed as f64 * (columns * rows - surveyed) as f64;
            assert!((made.rays_to_make - to_make).abs() <= 1e-9 * to_make, "{} {to_make}", made.rays_to_make);
        }
    }
}
