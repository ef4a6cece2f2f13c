//! Converts findings of rays and walks to the sums of a map.

use rayon::prelude::*;

use super::records::Flight;
use super::{CellSets, GatheringProgress};
use crate::estimators::basis::{BENDS, Linear, PARTS, bends_at, part_of, slopes_at};
use crate::maps::{HALF, IndirectDetail, REPLICAS, ReplicaMap, Residuals, Tally, half_squares};
use crate::solver::coarse::Shape;
use crate::solver::guide::Guide;

impl GatheringProgress {
    /// Sums up all findings of complete passes, with the present light of cells. `shape` receives what elements show beside their means.
    /// While there is no complete pass of rays, the sums stay as they are.
    pub fn settle(&mut self, sets: &mut CellSets, map: &mut ReplicaMap, weights: &[f64], shape: Option<&mut Shape>) {
        let numbers = [self.filled, self.gathered, self.walks.done];
        let is_new = self.passes() > 0 && self.settled != numbers;
        let Some(residuals) = map.residuals.as_mut().filter(|_| is_new) else {
            return;
        };
        self.settled = numbers;
        self.put_unsampled(sets);
        sets.solve();
        let (sets, passes) = (&*sets, self.passes());
        let (rays, sites) = ((passes * self.order.rays_of_a_pass()) as usize, self.order.sites());
        let replicas = self.records.par_iter().with_max_len(1).enumerate();
        let gathered: Vec<Vec<f32>> =
            replicas.map(|(replica, records)| records.gathered_lx(sets.of(replica), rays)).collect();
        let references = shape.as_ref().map(|shape| &shape.references_lx[..]);
        let slabs = map.indirect.par_iter_mut().with_max_len(1).enumerate();
        let found: Vec<ReplicaFindings> = slabs
            .map(|(replica, rows)| self.sum_up(replica, &gathered[replica], (references, weights), rows))
            .collect();
        self.ray_variances_lx2 = ray_variances_lx2(&map.indirect, weights, sites, passes);
        if let Some(shape) = shape {
            shape.detail = IndirectDetail {
                passes_of_parts: passes_of_parts(&found),
                near_lx: near_lx(&found, sites, passes),
                ..IndirectDetail::default()
            };
            let parts = found.into_iter().map(|found| (found.bends_lx, found.parts_lx));
            (shape.detail.bends_lx, shape.detail.parts_lx) = parts.unzip();
        }
        let walked = self.sum_up_walks(sets, residuals);
        residuals.share_out(&self.unsure_lx2(sets, rays), weights);
        self.learn_directions(&gathered, &walked);
        map.indirect_samples = Tally { complete: passes, partial: 0 };
        map.take_residuals(weights);
    }

    /// Directs future rays to where light came from, and future walks to where cells had errors.
    fn learn_directions(&mut self, gathered: &[Vec<f32>], walked: &[Vec<f32>]) {
        let [of_rays, of_walks] = &mut self.guides;
        let [rays, walks] = self.learned;
        for (replica, records) in self.records.iter().enumerate() {
            let (gathered, walked) = (&gathered[replica], &walked[replica]);
            count(
                of_rays,
                self.order.entries(rays..gathered.len() as u64),
                &records.bins[rays as usize..],
                &gathered[rays as usize..],
            );
            let new = walks..walks + walked.len() as u64;
            count(of_walks, self.walks.entries(new), &records.walk_bins[walks as usize..], walked);
        }
        let lens = [gathered, walked].map(|found| found.first().map_or(0, |first| first.len() as u64));
        self.learned = [lens[0], self.learned[1] + lens[1]];
        self.guides.iter_mut().for_each(Guide::learn);
    }

    /// Sums of one replica's rays.
    fn sum_up(
        &self,
        replica: usize,
        gathered: &[f32],
        (references_lx, areas_m2): (Option<&[Linear]>, &[f64]),
        rows: &mut [f64],
    ) -> ReplicaFindings {
        let (sites, records) = (self.order.sites(), &self.records[replica]);
        rows.fill(0.0);
        let mut found = ReplicaFindings::default();
        if references_lx.is_some() {
            found.make_room(sites);
        }
        let rays = self.order.entries(0..gathered.len() as u64).zip(gathered);
        for (ray, ((_, entry), lx)) in rays.enumerate() {
            if !self.sees[entry] {
                continue;
            }
            // An entry's rays in a pass are parts of one sample.
            let share = 1.0 / self.order.allotment.of(entry) as f64;
            let lx = f64::from(*lx);
            let Some(reference_lx) = references_lx.map(|references| &references[entry]) else {
                rows[entry] += share * lx;
                continue;
            };
            // The part of the light in a reference has no random error.
            let Flight { at, length_m } = records.flights[ray];
            let at = at.map(f64::from);
            let (beyond_lx, bends) = (lx - reference_lx.at(at), bends_at(at));
            for (number, (known_lx, factor)) in reference_lx.0.iter().zip([1.0, bends[0], bends[1]]).enumerate() {
                rows[number * sites + entry] += share * (known_lx + beyond_lx * factor);
            }
            found.bends_lx[entry].iter_mut().zip(bends).for_each(|(sum, bend)| *sum += share * beyond_lx * bend);
            let nearness = (areas_m2[entry].sqrt() / f64::from(length_m).max(f64::MIN_POSITIVE)).min(1.0);
            found.near_lx[entry][0] += share * lx.abs() * nearness;
            found.near_lx[entry][1] += share * lx.abs() * nearness * nearness;
            if let Some(parts_lx) = found.parts_lx.get_mut(entry) {
                parts_lx[part_of(at)] += share * beyond_lx;
                found.passes_of_parts[entry][part_of(at)] += share;
            }
        }
        found
    }

    /// Sums up the findings of walks. Returns the result of each walk of every replica since directions were learned, in lx.
    fn sum_up_walks(&self, sets: &CellSets, residuals: &mut Residuals) -> Vec<Vec<f32>> {
        let order = self.order.order;
        let sites = order.sites();
        let (walkers, walks, walk_count) = self.walks.complete();
        residuals.walks = walks;
        residuals.walkers = vec![false; sites];
        (0..walkers).for_each(|place| residuals.walkers[order.entry(place)] = true);
        let sums = residuals.sums.par_iter_mut().zip(&mut residuals.first_steps);
        let replicas = self.records.par_iter().with_max_len(1).zip(sums).enumerate();
        let each = replicas.map(|(replica, (records, (walked, stepped)))| {
            let cells = sets.of(replica);
            walked.fill(0.0);
            stepped.fill(0.0);
            let known = self.learned[1] as usize;
            let mut new = Vec::with_capacity((walk_count as usize).saturating_sub(known));
            let mut first = 0;
            let walks = records.walks.iter().zip(self.walks.entries(0..walk_count)).enumerate();
            for (walk, (record, (_, entry))) in walks {
                let [lx, of_step_lx] = record.found_lx(&records.walk_terms[first as usize..record.end as usize], cells);
                walked[entry] += lx;
                stepped[entry] += of_step_lx;
                if walk >= known {
                    new.push(lx as f32);
                }
                if let Some(at) = records.walk_starts.get(walk) {
                    let slopes = slopes_at(at.map(f64::from)).into_iter().enumerate();
                    slopes.for_each(|(k, slope)| {
                        walked[(1 + k) * sites + entry] += lx * slope;
                        stepped[(1 + k) * sites + entry] += of_step_lx * slope;
                    });
                }
                first = record.end;
            }
            new
        });
        each.collect()
    }

    /// Uncertainty of the cells that each entry looks up, in lx², as sums over the passes of two replicas.
    fn unsure_lx2(&self, sets: &CellSets, rays: usize) -> Vec<f64> {
        let mut unsure_lx2 = vec![0.0; self.order.sites()];
        for (replica, records) in self.records.iter().enumerate().take(2) {
            let cells = sets.of(replica);
            for ((_, entry), term) in self.order.entries(0..rays as u64).zip(&records.terms) {
                let of_ray_lx2 = f64::from(term.factor * term.factor * cells.variance_lx2(term.cell));
                unsure_lx2[entry] += of_ray_lx2 / self.order.allotment.of(entry) as f64;
            }
        }
        unsure_lx2
    }
}

/// Counts the light in lx that samples from some entries found through their bins.
fn count(guide: &mut Guide, entries: impl Iterator<Item = (u64, usize)>, bins: &[u8], found_lx: &[f32]) {
    for (((_, entry), bin), lx) in entries.zip(bins).zip(found_lx) {
        guide.add_weighted(entry, usize::from(*bin), f64::from(*lx));
    }
}

/// Findings of the rays of one replica, in addition to its rows.
#[derive(Default)]
struct ReplicaFindings {
    /// For every element, sums of the difference to its reference times the polynomials, and in each part of the element, in lx.
    bends_lx: Vec<[f64; BENDS]>,
    parts_lx: Vec<[f64; PARTS]>,
    /// Rays that started in each part of the elements, as passes.
    passes_of_parts: Vec<[f64; PARTS]>,
    /// For every element, sums of the light times the first and the second power of its nearness, in lx.
    near_lx: Vec<[f64; 2]>,
}

impl ReplicaFindings {
    fn make_room(&mut self, sites: usize) {
        self.bends_lx = vec![[0.0; BENDS]; sites];
        self.near_lx = vec![[0.0; 2]; sites];
        let with_parts = IndirectDetail::with_parts(sites);
        self.parts_lx = vec![[0.0; PARTS]; with_parts];
        self.passes_of_parts = vec![[0.0; PARTS]; with_parts];
    }
}

/// Rays of the even and of the odd replicas that started in each part of the elements, as passes.
fn passes_of_parts(found: &[ReplicaFindings]) -> Vec<[[f64; PARTS]; 2]> {
    let sites = found.first().map_or(0, |first| first.passes_of_parts.len());
    let of_half = |entry: usize, half: usize| {
        let replicas = || found.iter().skip(half).step_by(2);
        std::array::from_fn(|part| replicas().map(|found| found.passes_of_parts[entry][part]).sum())
    };
    (0..sites).map(|entry| [of_half(entry, 0), of_half(entry, 1)]).collect()
}

/// Light of every element times the first and the second power of its nearness: means over all its rays, in lx.
fn near_lx(found: &[ReplicaFindings], sites: usize, passes: u64) -> Vec<[f64; 2]> {
    let passes = (passes as usize * found.len()).max(1) as f64;
    let of_element =
        |entry: usize| [0, 1].map(|k| found.iter().map(|found| found.near_lx[entry][k]).sum::<f64>() / passes);
    (0..sites).map(of_element).collect()
}

/// For every element or point, from the even and the odd half: the variance of a replica's mean in lx² times the entry's weight, from the
/// random error of rays alone, since the replicas of a half look up the same cells. `rows` are the sums of each replica. Entries beyond the
/// elements are slopes; their variances add to those of the means.
fn ray_variances_lx2(rows: &[Vec<f64>], weights: &[f64], sites: usize, passes: u64) -> Vec<[f64; 2]> {
    let passes = passes.max(1) as f64;
    let mut variances = vec![[0.0; 2]; sites];
    for (entry, weight) in weights.iter().enumerate() {
        let squares = half_squares(|replica| rows[replica][entry] / passes);
        let of_entry = variances[entry % sites].iter_mut().zip(squares);
        of_entry.for_each(|(sum, square)| *sum += weight * square / (HALF - 1) as f64);
    }
    variances
}

/// Squared error in lx² of the mean over all replicas, from the variances of [`ray_variances_lx2`] of entries with these weights.
pub fn ray_squared_lx2(variances: &[[f64; 2]], weights: &[f64]) -> f64 {
    let weight_sum: f64 = weights[..variances.len()].iter().sum();
    let both: f64 = variances.iter().flatten().sum();
    0.5 * both / REPLICAS as f64 / weight_sum.max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::random::{Purpose, Stream};

    /// 512 entries, 24 rays of each replica by a scramble of its own, which bring 4 x y lx in the unit square (seed 5). The squared error
    /// that the replicas state is the true one of the means, which 512 entries determine within 6 %: it must agree within four times that.
    /// The planted fault, a difference between the first and the second half of each replica's rays, is more than 1.5 times as large.
    #[test]
    fn the_error_of_quasi_random_rays_is_the_spread_of_the_replicas() {
        const ENTRIES: usize = 512;
        const PASSES: u64 = 24;
        let (mut rows, mut of_halves_lx2) = (vec![vec![0.0; ENTRIES]; REPLICAS], 0.0);
        for (replica, row) in rows.iter_mut().enumerate() {
            let mut stream = Stream::new(5, Purpose::CellRays, 0, replica as u32);
            for (entry, sum_lx) in row.iter_mut().enumerate() {
                let mut halves_lx = [0.0; 2];
                for pass in 0..PASSES {
                    stream.seek_quasi(entry as u64, entry as u64, pass);
                    let [x, y] = stream.pair();
                    halves_lx[usize::from(pass >= PASSES / 2)] += 4.0 * x * y;
                }
                *sum_lx = halves_lx[0] + halves_lx[1];
                of_halves_lx2 += ((halves_lx[0] - halves_lx[1]) / PASSES as f64).powi(2) / (ENTRIES * REPLICAS) as f64;
            }
        }
        let weights = [1.0; ENTRIES];
        let error_lx =
            |entry: usize| rows.iter().map(|row| row[entry]).sum::<f64>() / (PASSES as usize * REPLICAS) as f64 - 1.0;
        let true_lx2 = (0..ENTRIES).map(|entry| error_lx(entry).powi(2)).sum::<f64>() / ENTRIES as f64;
        let stated = ray_squared_lx2(&ray_variances_lx2(&rows, &weights, ENTRIES, PASSES), &weights) / true_lx2;
        assert!((0.76..1.24).contains(&stated), "{stated}");
        let by_halves = of_halves_lx2 / REPLICAS as f64 / true_lx2;
        assert!(by_halves > 1.5, "the planted fault passed: {by_halves}");
    }
}
