//! Gathering: rays from receivers and elements look up what the forward stage left, with checks of what they were told.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::broad::Shape;
use super::forward::{Forward, Recollection};
use super::job::Context;
use super::sweep::stream_index;
use crate::estimators::direct::Receiver;
use crate::estimators::element::Element;
use crate::estimators::reception::one_plane;
use crate::estimators::walk::gather_indirect_lx;
use crate::geometry::Origin;
use crate::maps::basis::{BENDS, Linear, PARTS, SLOPES, bends_at, part_of};
use crate::maps::{ENTRIES_PER_BLOCK, HALF, HalfChecks, HalfScores, MapKind, PartScores, ReplicaMap};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::scene::{Elements, Quantity};

/// What gathering needs besides the map that it fills.
pub struct Gatherer<'a> {
    /// The run.
    pub context: &'a Context<'a>,
    /// What chains left.
    pub forward: &'a Forward,
    /// Elements or a receiver set.
    pub kind: MapKind,
    /// The elements, where they are what gathers.
    pub elements: &'a Elements,
    /// Share of every element that is exposed; empty where elements count as they are.
    pub exposed: &'a [f64],
    /// Share of the look-ups that are checked.
    pub checked_share: f64,
}

impl Gatherer<'_> {
    /// Samples of a range of elements or points in every replica, added to the map; returns the rays traced.
    ///
    /// Elements that adapt have a shape, which takes what they need beside their means.
    pub fn gather(
        &self,
        map: &mut ReplicaMap,
        mut shape: Option<&mut Shape>,
        entries: Range<usize>,
        samples: Range<u64>,
    ) -> u64 {
        map.fix_indirect_levels(entries.clone());
        let parts: Vec<(usize, Range<usize>)> =
            parts_of(entries).flat_map(|part| [(0, part.clone()), (1, part)]).collect();
        let before: &ReplicaMap = map;
        let gathered: Vec<(Vec<SiteScores>, HalfChecks, u64, PartScores)> = parts
            .par_iter()
            .with_max_len(1)
            .map(|(parity, part)| self.gather_part(before, *parity, shape.as_deref(), part.clone(), samples.clone()))
            .collect();
        let mut rays = 0;
        let (sites, numbers) = (map.len(), map.entries() / map.len().max(1));
        for ((parity, part), (scores, checks, part_rays, single)) in parts.into_iter().zip(gathered) {
            let block = part.start / ENTRIES_PER_BLOCK;
            for (site, scores) in part.clone().zip(&scores) {
                for (number, scores) in scores.numbers[..numbers].iter().enumerate() {
                    let entry = number * sites + site;
                    for (row, sum_lx) in scores.rows_lx.iter().enumerate() {
                        map.indirect[2 * row + parity][entry] += sum_lx;
                    }
                    if let Some(crossing) = &mut map.crossing {
                        crossing.add(parity, entry, scores);
                    }
                }
                if let Some(shape) = shape.as_deref_mut() {
                    for (row, (bends_lx, parts_lx)) in scores.bends_lx.iter().zip(&scores.parts_lx).enumerate() {
                        let sums = &mut shape.detail.bends_lx[2 * row + parity][site];
                        sums.iter_mut().zip(bends_lx).for_each(|(sum, lx)| *sum += lx);
                        if let Some(sums) = shape.detail.parts_lx[2 * row + parity].get_mut(site) {
                            sums.iter_mut().zip(parts_lx).for_each(|(sum, lx)| *sum += lx);
                        }
                    }
                }
            }
            if let Some(crossing) = &mut map.crossing {
                crossing.correct(parity, block, &checks);
                if parity == 0 {
                    // Points inside of solids and covered elements ask nothing, and nothing is checked there.
                    let asking = scores.iter().filter(|scores| scores.asks).count() as u64;
                    crossing.count(block, asking * (samples.end - samples.start));
                }
            }
            map.scores[1].merge(single);
            rays += part_rays;
        }
        rays
    }

    /// The eight replicas of a half, from entries that lie in one block.
    fn gather_part(
        &self,
        before: &ReplicaMap,
        parity: usize,
        shape: Option<&Shape>,
        entries: Range<usize>,
        samples: Range<u64>,
    ) -> (Vec<SiteScores>, HalfChecks, u64, PartScores) {
        let number = shape.map_or(self.kind.number(), Shape::stream_number);
        let seed = self.context.seed;
        let mut streams: [Stream; HALF] = std::array::from_fn(|row| {
            let replica = (2 * row + parity) as u32;
            match before.crossing.as_ref().and_then(|crossing| crossing.sharing_of(row)) {
                Some((group, sharer)) => {
                    let group = (2 * group + parity) as u32;
                    Stream::sharing(seed, Purpose::Gathering, number, replica, group, sharer)
                }
                None => Stream::new(seed, Purpose::Gathering, number, replica),
            }
        });
        let mut memory = Recollection::new(self.context, self.forward, parity, self.checked_share);
        let mut cut = Cut::default();
        let mut rays = 0;
        let mut single = PartScores::for_task(&before.scores[1]);
        let scores = entries.map(|entry| {
            let mut found = SiteScores::default();
            memory.scores = HalfScores::default();
            let Some(site) = self.site(entry) else {
                return found;
            };
            found.asks = true;
            let reference = shape.map(|shape| &shape.references_lx[entry]);
            for (row, stream) in streams.iter_mut().enumerate() {
                memory.row = row;
                let before_lx = if reference.is_some() {
                    found.numbers.map(|number| number.columns_lx)
                } else {
                    [memory.scores.columns_lx; 1 + SLOPES]
                };
                let mut entry_scores = single.of_entry(self.weight(entry), before.levels[1].of(entry));
                for number in samples.clone() {
                    stream.seek_quasi(stream_index(entry, number), entry as u64, number);
                    let (at, (lx, sample_rays)) = self.sample(&site, &mut memory, &mut cut, stream);
                    memory.scores.rows_lx[row] += lx;
                    entry_scores.add(lx);
                    rays += sample_rays;
                    if let Some(reference) = reference {
                        let scores = std::mem::take(&mut memory.scores);
                        found.add(row, at, &scores, reference);
                    }
                }
                if reference.is_some() {
                    found.numbers.iter_mut().zip(&before_lx).for_each(|(number, before)| number.contrast(row, before));
                } else {
                    memory.scores.contrast(row, &before_lx[0]);
                }
            }
            if reference.is_none() {
                found.numbers[0] = memory.scores;
            }
            found
        });
        let scores = scores.collect();
        (scores, memory.checks, rays, single)
    }

    /// Area of an element side in m², or weight of a receiver.
    fn weight(&self, entry: usize) -> f64 {
        match self.kind {
            MapKind::Elements => self.elements.area_m2(self.context.scene, self.elements.cell(entry as u32)),
            MapKind::Receivers(set) => self.context.scene.receivers[set].points[entry].weight,
        }
    }

    /// Where the rays of an entry start; `None` for a point inside a solid, and for an element that is covered.
    pub fn site(&self, entry: usize) -> Option<Site> {
        let stage = self.context.stage;
        match self.kind {
            MapKind::Elements => {
                let element = Element::of(stage, self.context.scene, self.elements, entry as u32);
                let share = self.exposed.get(entry).copied().unwrap_or(1.0);
                (share > 0.0).then(|| Site::Element(element.exposed(share)))
            }
            MapKind::Receivers(set) => {
                let receivers = &self.context.scene.receivers[set];
                let point = &receivers.points[entry];
                let origin = stage.tracer.side_origin(point.position_m, point.normal);
                let (point_m, normal, quantity) = (point.position_m, point.normal, receivers.quantity);
                (!point.inside).then_some(Site::Point { point_m, normal, origin, quantity })
            }
        }
    }

    /// One sample of the indirect illuminance at a site in lx, and the rays it took; before them where in an element it
    /// was taken.
    #[inline]
    pub fn sample(
        &self,
        site: &Site,
        memory: &mut Recollection,
        cut: &mut Cut,
        stream: &mut Stream,
    ) -> ([f64; 2], (f64, u64)) {
        let start = self.start(site, stream);
        memory.weight = start.weight;
        let (lx, rays) = gather_indirect_lx(self.context.stage, &start.receiver(), memory, cut, stream);
        (start.at, (start.weight * lx, start.rays + rays))
    }

    /// Where one ray starts.
    #[inline]
    pub fn start(&self, site: &Site, stream: &mut Stream) -> Start {
        let stage = self.context.stage;
        match site {
            Site::Element(element) => {
                let (at, rays) = element.draw_exposed(stage, stream);
                let origin = element.origin(stage, at);
                let point_m = stage.tracer.position_m(&origin);
                Start { at, point_m, normal: element.normal, origin, weight: 1.0, rays }
            }
            Site::Point { point_m, normal, origin, quantity } => {
                let receiver = Receiver { point_m: *point_m, normal: *normal, origin };
                let (plane, weight) = one_plane(*quantity, &receiver, stream);
                Start { at: [0.0; 2], point_m: *point_m, normal: plane.normal, origin: *origin, weight, rays: 0 }
            }
        }
    }
}

/// Where one gathering ray starts.
pub struct Start {
    /// Place in its element.
    at: [f64; 2],
    point_m: DVec3,
    /// Unit normal of the plane that it is for.
    normal: DVec3,
    origin: Origin,
    /// Weight of what it brings.
    weight: f64,
    /// Rays that it took to find the place.
    pub rays: u64,
}

impl Start {
    /// The plane that the ray is for.
    #[inline]
    pub fn receiver(&self) -> Receiver<'_> {
        Receiver { point_m: self.point_m, normal: self.normal, origin: &self.origin }
    }
}

/// Where gathering rays start.
pub enum Site {
    /// Anywhere in an element side.
    Element(Element),
    /// At a receiver.
    Point {
        /// Place in m.
        point_m: DVec3,
        /// Unit normal.
        normal: DVec3,
        /// The same place for the tracer.
        origin: Origin,
        /// What the receiver measures.
        quantity: Quantity,
    },
}

/// What the rays of one half found in one element or at one point.
#[derive(Clone, Copy, Debug, Default)]
struct SiteScores {
    /// Whether any rays started there.
    asks: bool,
    /// Of the mean, and of the slopes where the element adapts.
    numbers: [HalfScores; 1 + SLOPES],
    /// Of the polynomials, row by row, for what the element cannot show.
    bends_lx: [[f64; BENDS]; HALF],
    /// What goes beyond the reference in each part, row by row.
    parts_lx: [[f64; PARTS]; HALF],
}

impl SiteScores {
    /// Adds one sample of an element that adapts, taken at a point of it.
    #[inline]
    fn add(&mut self, row: usize, at: [f64; 2], scores: &HalfScores, reference: &Linear) {
        let beyond_lx = scores.rows_lx[row] - reference.at(at);
        let bends = bends_at(at);
        for (sum, bend) in self.bends_lx[row].iter_mut().zip(bends) {
            *sum += beyond_lx * bend;
        }
        self.parts_lx[row][part_of(at)] += beyond_lx;
        // The row is compared with its reference; columns and coarser patches tell of differences alone.
        let differences = HalfScores { rows_lx: [0.0; HALF], ..*scores };
        let factors = [1.0, bends[0], bends[1]];
        for ((number, factor), known_lx) in self.numbers.iter_mut().zip(factors).zip(reference.0) {
            number.add_times(&differences, factor);
            number.rows_lx[row] += known_lx + beyond_lx * factor;
        }
    }
}

/// Cuts a range of entries into parts that lie in one block each.
fn parts_of(entries: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let blocks = entries.start / ENTRIES_PER_BLOCK..entries.end.div_ceil(ENTRIES_PER_BLOCK);
    blocks.map(move |block| {
        (block * ENTRIES_PER_BLOCK).max(entries.start)..((block + 1) * ENTRIES_PER_BLOCK).min(entries.end)
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::chain::Stage;
    use crate::maps::Unit;
    use crate::scene::{Elements, scene_from_json};
    use crate::solver::Method;
    use crate::solver::job::TimeLeft;

    /// Points inside of a solid ask nothing: beside sixteen others they leave the pooled correction of these as it is, to the last bit,
    /// and it is not 0 (seed 4). Were they counted, it would be half of that.
    #[test]
    fn points_inside_of_solids_take_no_part_in_corrections() {
        let correction_lx = |rows: u32, first_m: f64| {
            let text = format!(
                r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.7 }} }},
                "geometry": [
                  {{ "name": "room", "type": "box", "min": [0,0,0], "max": [1,1,1], "facing": "inward", "material": "m" }},
                  {{ "name": "crate", "type": "box", "min": [0.1,0.7,0.05], "max": [0.9,0.9,0.4], "facing": "outward", "material": "m" }} ],
                "luminaires": [ {{ "name": "lamp", "type": "point", "position": [0.4,0.6,0.7], "luminous_flux_lm": 1000 }} ],
                "receivers": [ {{ "name": "rows", "type": "grid", "origin": [0.2,{first_m},0.1], "u": [0.6,0,0], "v": [0,0.4,0],
                  "columns": 16, "rows": {rows} }} ] }}"#
            );
            let scene = scene_from_json(&text, None, Path::new(".")).expect("a valid scene");
            let stage = Stage::new(&scene);
            let (method, time_left) = (Method::Gather, &|| TimeLeft::Enough);
            let context = Context {
                scene: &scene,
                stage: &stage,
                seed: 4,
                method,
                target_error: 0.01,
                adapt_to: None,
                time_left,
            };
            let mut forward = Forward::new(&context, 0.3);
            forward.trace_to(&context, 500);
            forward.settle(&context, f64::INFINITY);
            let points = &scene.receivers[0].points;
            let weights: Vec<f64> = points.iter().map(|point| if point.inside { 0.0 } else { 1.0 }).collect();
            let mut map = ReplicaMap::new(points.len(), Unit::Lux);
            map.cross(&weights);
            let elements = Elements::default();
            let kind = MapKind::Receivers(0);
            let gatherer = Gatherer {
                context: &context,
                forward: &forward,
                kind,
                elements: &elements,
                exposed: &[],
                checked_share: 0.5,
            };
            gatherer.gather(&mut map, None, 0..points.len(), 0..8);
            map.settle(&weights);
            map.crossing.map(|crossing| crossing.correction_lx()).expect("what gathers is crossed")
        };
        let (alone, beside) = (correction_lx(1, 0.2), correction_lx(2, 0.4));
        assert!(alone != 0.0 && alone == beside, "{alone} {beside}");
    }
}
