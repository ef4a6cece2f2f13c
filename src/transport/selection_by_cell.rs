//! Light selection by cell: how much of each luminaire is visible, cell by cell.
//!
//! Among shelves and machines most strong luminaires are hidden, and light samples of them find nothing. So before a long run some chains
//! show where light meets surfaces. In cells that contain several of these points, light samples from them estimate the visible share of
//! each emitter. A light sample from such a cell chooses an emitter with a probability in proportion to E √v. E is its unshadowed
//! illuminance and v the share that was seen. This minimises the variance where an emitter is hidden at random. Every emitter keeps a
//! probability, and the mean is right whatever the probabilities are. A cell near an emitter keeps the choice point by point.

use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::World;
use crate::geometry::Origin;
use crate::sampling::emitter::Emitter;
use crate::sampling::random::{Purpose, Stream};
use crate::sampling::reflection::LobeKind;

/// Minimum and maximum number of emitters for which cells are worth their memory.
const FEWEST_EMITTERS: usize = 4;
const MOST_EMITTERS: usize = 8192;
/// Number of emitters up to which there is memory for nearly all cells that rays meet, and maximum share of all surfaces that may shine:
/// cells near shining surfaces keep the choice point by point.
const MOST_SERVED: usize = 512;
const MOST_SHINING: f64 = 0.1;
/// Maximum number of values that all cells together hold: 16 MB.
const MOST_NUMBERS: usize = 4_000_000;
/// Mean share of the unshadowed light that must be hidden for the survey to pay off.
const LEAST_HIDDEN: f64 = 0.25;
/// Share of a run's rays that the survey may take, number of rays below which it is not begun, and maximum number of rays.
const SHARE_OF_RUN: f64 = 0.1;
const LEAST_RAYS: f64 = 50_000.0;
const MOST_RAYS: f64 = 4e6;
/// Share of these rays that chains take, to find where light meets surfaces.
const SHARE_OF_CHAINS: f64 = 0.1;
/// Approximate number of points in a cell, and fewest points from which a cell is surveyed.
const PLACES: f64 = 8.0;
const FEWEST_PLACES: usize = 3;
/// Iterations towards the cell size that gives this number.
const SIZE_STEPS: usize = 5;
/// Light samples of an emitter that brings all the light, and least number for any emitter.
const SAMPLES_OF_ALL_LIGHT: f64 = 100.0;
const FEWEST_SAMPLES_OF_EMITTER: usize = 2;
/// A cell's survey ends when the emitters left could bring at most this share of what was seen.
const REST: f64 = 0.1;
/// Number of light samples for which each outcome, seen and hidden, counts before the first one (a prior).
const PRIOR: f64 = 0.5;
/// Share of the light of all emitters from which on an uneven emitter matters.
const STRONG: f64 = 0.02;
/// Share of the choices that goes to any emitter.
const ANY: f64 = 0.01;
/// Share of the bound of an emitter's illuminance that is added to its unshadowed illuminance.
const SHARE_OF_BOUND: f64 = 0.5;
/// Distance from the centre of a cell, in edges, within which no emitter may stand; the second value is for a single point emitter.
const NEAR_EXTENDED: f64 = 0.5;
const NEAR_POINT: f64 = 1.2;
/// Ratio of an emitter's bound at a point to its mean in the cell from which on the cell is too near.
const UNEVEN: f64 = 3.0;
/// Least weight of an emitter, as a share of the most that it may bring to a corner of a cell, whatever it may bring to the points; and
/// maximum total that this adds, over what all emitters may bring to the points.
const SHARE_OF_CORNER: f64 = 0.1;
const MOST_EXTRA: f64 = 0.2;
/// The survey affects results only through probabilities, so its random numbers are the same for all seeds.
const SEED: u64 = 0x51_6875;

/// Units of probability 1: probabilities are stored as multiples of 1/`CERTAIN`.
const CERTAIN: f64 = 2_147_483_648.0;

/// Probabilities of emitters, cell by cell. A cell is a cube of space and one of six directions that surfaces face.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct SelectionByCell {
    low_m: DVec3,
    cell_m: f64,
    counts: [usize; 3],
    /// Number of every cell among those that were surveyed.
    numbers: Vec<u32>,
    /// For each surveyed cell, the cumulative probability up to and including every emitter, in units of 1/[`CERTAIN`].
    cumulative: Vec<u32>,
    emitters: usize,
    rays: u64,
}

/// A point where light met a surface.
struct LitPlace {
    cell: usize,
    point_m: DVec3,
    normal: DVec3,
    origin: Origin,
}

/// Result of the light samples from one cell.
struct CellCounts {
    cell: usize,
    cumulative: Vec<u32>,
    rays: u64,
}

/// Whether nearly all choices in a run of about `planned_rays` rays would be by cells.
pub fn would_serve(world: &World, planned_rays: f64) -> bool {
    let emitters = world.emitters.list();
    let shining_m2 =
        |emitter: &Emitter| emitter.exitance_lm_m2().map_or(0.0, |exitance| emitter.luminous_flux_lm / exitance);
    emitters.len() <= MOST_SERVED
        && emitters.iter().map(shining_m2).sum::<f64>() <= MOST_SHINING * world.area_m2
        && rays_to_find_out(world, planned_rays).is_some()
}

/// Rays that the survey may take in a run of about `planned_rays` rays. `None` if it would not pay off.
fn rays_to_find_out(world: &World, planned_rays: f64) -> Option<f64> {
    let rays = (SHARE_OF_RUN * planned_rays).min(MOST_RAYS);
    let has_many = (FEWEST_EMITTERS..=MOST_EMITTERS).contains(&world.emitters.list().len());
    (has_many && rays >= LEAST_RAYS && world.selection_by_region.hidden_share() >= LEAST_HIDDEN).then_some(rays)
}

impl SelectionByCell {
    /// Surveys which emitters are visible from which cells, for a run of about `planned_rays` rays. `None` if that would not pay off.
    pub fn of(world: &World, planned_rays: f64) -> Option<SelectionByCell> {
        let rays = rays_to_find_out(world, planned_rays)?;
        let emitters = world.emitters.list().len();
        let (mut met, chain_rays) = meetings(world, (SHARE_OF_CHAINS * rays) as u64);
        let mut map = SelectionByCell { emitters, ..SelectionByCell::over(&met)? };
        for meeting in &mut met {
            meeting.cell = map.cell(meeting.point_m, meeting.normal)?;
        }
        met.sort_by_key(|meeting| meeting.cell);
        let mut cells: Vec<&[LitPlace]> = met.chunk_by(|a, b| a.cell == b.cell).collect();
        cells.retain(|cell| cell.len() >= FEWEST_PLACES);
        // The cells that most light meets come first, as far as the rays suffice.
        cells.sort_by_key(|cell| (usize::MAX - cell.len(), cell[0].cell));
        cells.truncate(MOST_NUMBERS / emitters);
        let mut left = rays - chain_rays as f64;
        map.rays = chain_rays;
        // Parts of fixed size make the result independent of the number of threads.
        for part in cells.chunks(64) {
            if left <= 0.0 {
                break;
            }
            let counted: Vec<CellCounts> = part
                .par_iter()
                .with_max_len(1)
                .filter_map(|cell| sample_from(world, map.center_m(cell[0].point_m), map.cell_m, cell))
                .collect();
            for cell in counted {
                map.numbers[cell.cell] = (map.cumulative.len() / emitters) as u32;
                map.cumulative.extend(cell.cumulative);
                map.rays += cell.rays;
                left -= cell.rays as f64;
            }
        }
        Some(map)
    }

    /// Empty cells around all points, of a size that puts about [`PLACES`] points in one.
    fn over(met: &[LitPlace]) -> Option<SelectionByCell> {
        let (low_m, high_m) = met.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), at| {
            (low.min(at.point_m), high.max(at.point_m))
        });
        let extent_m = high_m - low_m;
        let wanted = met.len() as f64 / PLACES;
        let mut cell_m = extent_m.max_element() / 8.0;
        let mut map = SelectionByCell::default();
        for _ in 0..SIZE_STEPS {
            // One extra cell contains the outermost points.
            let counts: [usize; 3] = std::array::from_fn(|axis| (extent_m[axis] / cell_m) as usize + 1);
            if !(cell_m > 0.0 && cell_m.is_finite()) || counts.iter().product::<usize>() > MOST_NUMBERS {
                return None;
            }
            map = SelectionByCell { low_m, cell_m, counts, ..SelectionByCell::default() };
            let mut occupied: Vec<usize> = met.iter().filter_map(|at| map.cell(at.point_m, at.normal)).collect();
            occupied.sort_unstable();
            occupied.dedup();
            cell_m *= (occupied.len() as f64 / wanted).sqrt();
        }
        map.numbers = vec![u32::MAX; 6 * map.counts.iter().product::<usize>()];
        Some(map)
    }

    /// Rays that the survey took.
    pub fn rays(&self) -> u64 {
        self.rays
    }

    #[inline]
    fn cell(&self, point_m: DVec3, normal: DVec3) -> Option<usize> {
        let at = (point_m - self.low_m) / self.cell_m;
        let mut cell = 0;
        for axis in 0..3 {
            if !(at[axis] >= 0.0 && at[axis] < self.counts[axis] as f64) {
                return None;
            }
            cell = cell * self.counts[axis] + at[axis] as usize;
        }
        let axis = normal.abs().max_position();
        Some(6 * cell + 2 * axis + usize::from(normal[axis] < 0.0))
    }

    fn center_m(&self, point_m: DVec3) -> DVec3 {
        self.low_m + (((point_m - self.low_m) / self.cell_m).floor() + 0.5) * self.cell_m
    }

    /// Choice among emitters at a point with a unit normal. `None` if its cell was not surveyed.
    #[inline]
    pub(super) fn of_place(&self, point_m: DVec3, normal: DVec3) -> Option<CellChoice<'_>> {
        let number = self.numbers[self.cell(point_m, normal)?];
        (number != u32::MAX).then(|| CellChoice(&self.cumulative[number as usize * self.emitters..][..self.emitters]))
    }
}

/// Probabilities of all emitters in one cell, as running sums.
#[derive(Clone, Copy)]
pub(super) struct CellChoice<'a>(&'a [u32]);

impl CellChoice<'_> {
    /// The emitter that a variate in [0, 1) chooses, and the probability of that choice.
    #[inline]
    pub fn choose(self, variate: f64) -> (u32, f64) {
        let aim = (variate * CERTAIN) as u32;
        let emitter = self.0.partition_point(|sum| *sum <= aim).min(self.0.len() - 1) as u32;
        (emitter, self.probability(emitter))
    }

    /// Probability of an emitter.
    #[inline]
    pub fn probability(self, emitter: u32) -> f64 {
        let place = emitter as usize;
        let before = if place == 0 { 0 } else { self.0[place - 1] };
        f64::from(self.0[place] - before) / CERTAIN
    }
}

/// Points where chains of about `most_rays` rays meet surfaces that scatter, and the number of rays traced.
fn meetings(world: &World, most_rays: u64) -> (Vec<LitPlace>, u64) {
    let mut stream = Stream::new(SEED, Purpose::Pilot, 0, 0);
    let (mut met, mut rays) = (Vec::new(), 0);
    for chain in 0.. {
        if rays >= most_rays {
            break;
        }
        stream.seek_quasi(chain, 0, chain);
        let choice = stream.fine_unit();
        let arrive = |arrival: &super::Arrival| {
            let hit = &arrival.hit;
            if world.bsdf(hit.triangle).scatters() {
                let origin = world.leave(hit, LobeKind::Spread);
                let (point_m, normal) = (world.tracer.position_m(&origin), world.normal_at(hit));
                met.push(LitPlace { cell: 0, point_m, normal, origin });
            }
        };
        rays += world.trace_chain(choice, &mut stream, arrive).1;
    }
    (met, rays)
}

/// Upper bounds of what each emitter may bring to the points of a cell, in lx.
struct Bounds {
    /// Means over the points.
    means: Vec<f64>,
    /// The means, raised by a share of what the emitter may bring to the cell's corners.
    with_corners: Vec<f64>,
}

/// Bounds of what the emitters may bring to points of a cell, in lx. `None` if an emitter is so near that it differs between the points.
fn bounds_over(world: &World, (center_m, cell_m): (DVec3, f64), places: &[&LitPlace]) -> Option<Bounds> {
    let list = world.emitters.list();
    let near = |emitter: &Emitter| if emitter.is_single_point() { NEAR_POINT } else { NEAR_EXTENDED };
    if list.iter().any(|emitter| emitter.is_within(center_m, near(emitter) * cell_m)) {
        return None;
    }
    let bound_at = |emitter: &Emitter, place: &LitPlace| emitter.importance_lx(place.point_m, place.normal);
    let means: Vec<f64> = list.iter().map(|emitter| mean_over(places, |place| bound_at(emitter, place))).collect();
    let means_sum: f64 = means.iter().sum();
    let is_uneven = |(emitter, mean): (&Emitter, &f64)| {
        *mean > STRONG * means_sum && places.iter().any(|place| bound_at(emitter, place) > UNEVEN * mean)
    };
    if list.iter().zip(&means).any(is_uneven) {
        return None;
    }
    // An emitter that is behind all sampled points may be in front of others in the cell.
    let corners: [(DVec3, DVec3); 8] = std::array::from_fn(|corner| {
        let end = |axis: usize| if corner & (1 << axis) == 0 { -0.5 } else { 0.5 };
        (center_m + cell_m * DVec3::new(end(0), end(1), end(2)), places[corner % places.len()].normal)
    });
    let most = |emitter: &Emitter| {
        corners.iter().map(|(corner_m, normal)| emitter.importance_lx(*corner_m, *normal)).fold(0.0, f64::max)
    };
    let extra =
        |(emitter, mean): (&Emitter, &f64)| (SHARE_OF_CORNER * most(emitter) - mean).clamp(0.0, MOST_EXTRA * means_sum);
    let extras: Vec<f64> = list.iter().zip(&means).map(extra).collect();
    let scale = (MOST_EXTRA * means_sum / extras.iter().sum::<f64>().max(f64::MIN_POSITIVE)).min(1.0);
    let with_corners = means.iter().zip(&extras).map(|(mean, extra)| mean + scale * extra).collect();
    Some(Bounds { means, with_corners })
}

fn mean_over(places: &[&LitPlace], of: impl Fn(&LitPlace) -> f64) -> f64 {
    places.iter().map(|place| of(place)).sum::<f64>() / places.len() as f64
}

/// Takes light samples of the emitters from points in a cell, starting with the emitters that may bring most. `None` if an emitter is so
/// near that its illuminance differs between points of the cell, or if no emitter has a weight.
fn sample_from(world: &World, center_m: DVec3, cell_m: f64, cell: &[LitPlace]) -> Option<CellCounts> {
    let list = world.emitters.list();
    let count = cell.len().min(PLACES as usize);
    let places: Vec<&LitPlace> = (0..count).map(|place| &cell[place * cell.len() / count]).collect();
    let Bounds { means, with_corners: bounds } = bounds_over(world, (center_m, cell_m), &places)?;
    let bounds_sum: f64 = bounds.iter().sum();
    let mut order: Vec<usize> = (0..list.len()).filter(|emitter| bounds[*emitter] > 0.0).collect();
    order.sort_by(|a, b| bounds[*b].total_cmp(&bounds[*a]).then(a.cmp(b)));

    let mut stream = Stream::new(SEED, Purpose::Pilot, 1, 0);
    let (mut weights, mut hidden) = (vec![0.0; list.len()], Vec::new());
    let mut rest = bounds_sum;
    let (mut sampled, mut seen, mut rays) = (0.0, 0.0, 0);
    for (rank, emitter) in order.iter().enumerate() {
        let bound = bounds[*emitter];
        if rest <= REST * seen {
            // Emitters that were not sampled are assumed visible as often as the sampled ones.
            let scale = (seen / sampled).sqrt();
            order[rank..].iter().for_each(|emitter| weights[*emitter] = scale * bounds[*emitter]);
            break;
        }
        if means[*emitter] == 0.0 {
            // The sampled points give no information on this emitter.
            weights[*emitter] = SHARE_OF_BOUND * bound * 0.5f64.sqrt();
            rest -= bound;
            continue;
        }
        let unshadowed_lx = mean_over(&places, |place| list[*emitter].unshadowed_lx(place.point_m, place.normal));
        let mut shares = 0.0;
        let samples = ((SAMPLES_OF_ALL_LIGHT * bound / bounds_sum).ceil() as usize)
            .clamp(FEWEST_SAMPLES_OF_EMITTER.min(count), count);
        for number in 0..samples {
            // The points take turns, so that weak emitters are not all sampled from the same point.
            let place = places[(number + rank) % count];
            stream.seek(((cell[0].cell as u64) << 28) | ((*emitter as u64) << 4) | number as u64);
            let Some(sample) = list[*emitter].light_sample(place.point_m, place.normal, &mut stream) else {
                continue;
            };
            rays += 1;
            shares += world.seen_share(&sample, &place.origin);
        }
        let samples = samples as f64;
        let share = (shares + PRIOR) / (samples + 2.0 * PRIOR);
        weights[*emitter] = (unshadowed_lx + SHARE_OF_BOUND * bound) * share.sqrt();
        if shares == 0.0 {
            hidden.push(*emitter);
        }
        rest -= bound;
        sampled += bound;
        seen += bound * shares / samples;
    }
    // Hidden emitters together get no more weight than all seen emitters, however bright they are.
    let of_hidden = |weights: &[f64]| hidden.iter().map(|emitter| weights[*emitter]).sum::<f64>();
    let others = weights.iter().sum::<f64>() - of_hidden(&weights);
    let scale = others / of_hidden(&weights);
    if scale < 1.0 {
        hidden.iter().for_each(|emitter| weights[*emitter] *= scale);
    }
    let total: f64 = weights.iter().sum();
    if total <= 0.0 {
        return None;
    }
    let any = ANY / list.len() as f64;
    let sums = weights.iter().scan(0.0, |sum, weight| {
        *sum += (1.0 - ANY) * weight / total + any;
        Some((*sum * CERTAIN) as u32)
    });
    let mut cumulative: Vec<u32> = sums.collect();
    *cumulative.last_mut()? = CERTAIN as u32;
    Some(CellCounts { cell: cell[0].cell, cumulative, rays })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::check::scene_from_json;

    /// Four lamps. The points of a cell of 1 m lie at x = 0.2 and face −x, and the last lamp is behind them at x = 0.5. A point at x = 0.9
    /// of the same cell has it in front. Its light samples must find it with more than the least chance that every lamp has (the planted
    /// fault).
    #[test]
    fn a_lamp_behind_all_sampled_places_is_still_found_from_others_of_the_cell() {
        let lamp = |name: &str, position: &str| {
            format!(r#"{{ "name": "{name}", "type": "point", "position": {position}, "luminous_flux_lm": 1000 }}"#)
        };
        let lamps = [lamp("a", "[-3,0,0]"), lamp("b", "[-3,1,0]"), lamp("c", "[-3,2,1]"), lamp("d", "[0.5,2.5,0.5]")];
        let text = format!(
            r#"{{ "version": 1, "materials": {{ "grey": {{ "type": "diffuse", "reflectance": 0.5 }} }},
            "geometry": [ {{ "name": "room", "type": "box", "min": [-5,-5,-5], "max": [5,5,5], "facing": "inward", "material": "grey" }} ],
            "luminaires": [ {} ] }}"#,
            lamps.join(", ")
        );
        let scene = scene_from_json(&text, None, Path::new(".")).expect("a scene");
        let world = World::new(&scene);
        let places: Vec<LitPlace> = (0..4)
            .map(|place| {
                let (point_m, normal) = (DVec3::new(0.2, 0.2 * f64::from(place), 0.5), DVec3::NEG_X);
                LitPlace { cell: 0, point_m, normal, origin: world.tracer.side_origin(point_m, normal) }
            })
            .collect();
        assert!(places.iter().all(|place| world.emitters.list()[3].importance_lx(place.point_m, place.normal) == 0.0));
        let cell = sample_from(&world, DVec3::splat(0.5), 1.0, &places).expect("a cell far enough from all lamps");
        let chance = CellChoice(&cell.cumulative).probability(3);
        assert!(chance > 10.0 * ANY / 4.0, "{chance}");
        let sum: f64 = (0..4).map(|lamp| CellChoice(&cell.cumulative).probability(lamp)).sum();
        assert!((sum - 1.0).abs() < 1e-9, "{sum}");
    }
}
