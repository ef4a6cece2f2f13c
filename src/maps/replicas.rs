//! The sums of one map, replica by replica.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::basis::{Linear, SLOPES};
use super::children::{ChildElement, on_children};
use super::rare_scores::{RareScores, Spread};
use super::residuals::within_halves;
use super::{CellsError, HALF, Levels, MapValues, PartScores, REPLICAS, Residuals, ScoreEvidence};

/// Sums of scores in every replica, direct and indirect apart; entry `i` is the mean of site `i`, an element side or a point.
///
/// A map of elements may show slopes too, and has more entries than sites: then the entries behind those of the means are the coefficients of the first
/// linear polynomial ([`super::basis`]) of every element, and behind these those of the second. The polynomials are
/// orthonormal, so that weighted sums of squares over all entries are integrals over the elements.
///
/// A replica's illuminance is `direct sum · direct_scale + indirect sum · indirect_scale[i]`: the scales turn sums
/// over samples into means, and counted flux into flux over area.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ReplicaMap {
    /// One slab a replica: sums of direct scores in lx.
    pub direct: Vec<Vec<f64>>,
    /// One slab a replica: sums of indirect scores (lx, or counts of packets).
    pub indirect: Vec<Vec<f64>>,
    /// Direct samples of each entry so far, in every replica alike.
    pub direct_samples: Tally,
    /// Chains or walks so far, in every replica alike.
    pub indirect_samples: Tally,
    /// What one unit of the indirect sum is worth at entry `i` for a single sample (1 for lx; Φ/A for packets: docs/methods.md (4)).
    pub indirect_unit_lx: Unit,
    /// What walks say of light that cells told; `None` for other samples.
    pub residuals: Option<Residuals>,
    /// What is left of the cells' error in the indirect sums; `None` for other samples.
    pub cells_error: Option<CellsError>,
    /// Single scores of direct and of indirect light, all replicas together; packets that are counted are not among them.
    pub scores: [PartScores; 2],
    /// What these scores deviate from.
    pub levels: [Levels; 2],
    /// Whether an entry without light may be covered, and its 0 exact: so it is with elements, but not with points, of which covered
    /// ones count for nothing.
    pub may_be_covered: bool,
    sites: usize,
}

/// How many samples the entries of a map have: a sweep over all entries may stand in the middle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tally {
    /// Samples of every entry.
    pub complete: u64,
    /// Entries before this one have one sample more.
    pub ahead: usize,
}

impl Tally {
    /// Samples of one entry.
    #[inline]
    pub fn of(self, entry: usize) -> u64 {
        self.complete + u64::from(entry < self.ahead)
    }

    pub(super) fn inverse(self, entry: usize) -> f64 {
        let samples = self.of(entry);
        if samples == 0 { 0.0 } else { 1.0 / samples as f64 }
    }
}

/// What one unit of an indirect sum is worth.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Unit {
    /// Sums are in lx already.
    Lux,
    /// Sums count packets that each carry `luminous_flux_lm` over all samples: the areas in m² turn them into lx.
    Packets {
        /// Flux of all luminaires in lm.
        luminous_flux_lm: f64,
        /// Area of every entry in m².
        area_m2: Vec<f64>,
    },
}

impl ReplicaMap {
    /// An empty map of `len` entries.
    pub fn new(len: usize, indirect_unit_lx: Unit) -> ReplicaMap {
        ReplicaMap::with_entries(len, len, indirect_unit_lx)
    }

    /// An empty map of `len` elements that show slopes.
    pub fn linear(len: usize, indirect_unit_lx: Unit) -> ReplicaMap {
        ReplicaMap::with_entries(len, len * (1 + SLOPES), indirect_unit_lx)
    }

    fn with_entries(sites: usize, entries: usize, indirect_unit_lx: Unit) -> ReplicaMap {
        ReplicaMap {
            direct: vec![vec![0.0; entries]; REPLICAS],
            indirect: vec![vec![0.0; entries]; REPLICAS],
            direct_samples: Tally::default(),
            indirect_samples: Tally::default(),
            indirect_unit_lx,
            residuals: None,
            cells_error: None,
            scores: Default::default(),
            levels: Default::default(),
            may_be_covered: false,
            sites,
        }
    }

    /// Fixes the levels of direct light from which scores deviate, where entries have samples and none yet.
    pub fn fix_direct_levels(&mut self, entries: Range<usize>) {
        let count = self.entries();
        let (slabs, tally) = (&self.direct, self.direct_samples);
        self.levels[0].fix(entries, count, |entry| {
            (tally.of(entry) > 0).then(|| mean(slabs.iter().map(|slab| slab[entry])) * tally.inverse(entry))
        });
    }

    /// The same of indirect light in lx.
    pub fn fix_indirect_levels(&mut self, entries: Range<usize>) {
        let count = self.entries();
        let (slabs, tally) = (&self.indirect, self.indirect_samples);
        self.levels[1].fix(entries, count, |entry| {
            (tally.of(entry) > 0).then(|| mean(slabs.iter().map(|slab| slab[entry])) * tally.inverse(entry))
        });
    }

    /// Forgets what single scores of indirect light have said: they begin anew.
    pub fn forget_indirect_scores(&mut self) {
        self.scores[1] = PartScores::default();
        self.levels[1] = Levels::default();
    }

    /// What single scores of direct and of indirect light say of the map's error.
    pub fn score_evidence(&self) -> [ScoreEvidence; 2] {
        let samples = |tally: Tally| tally.complete as f64 * REPLICAS as f64;
        let part =
            |part: usize, tally: Tally| self.scores[part].evidence(samples(tally), samples(tally) * self.len() as f64);
        let direct = part(0, self.direct_samples);
        let Unit::Packets { luminous_flux_lm, area_m2 } = &self.indirect_unit_lx else {
            return [direct, part(1, self.indirect_samples)];
        };
        // Each packet that an element counts is a score of Φ/A, and none is larger: the tail has an end.
        let flux_per_packet_lm = luminous_flux_lm / samples(self.indirect_samples).max(1.0);
        let (mut variance, mut fourth) = (0.0, 0.0);
        for (entry, area_m2) in area_m2.iter().enumerate() {
            let square = flux_per_packet_lm * flux_per_packet_lm / area_m2;
            variance += square * self.indirect_sum(entry);
            fourth += square * square * self.indirect_sum(entry);
        }
        [direct, ScoreEvidence { variance, fourth, ..ScoreEvidence::default() }]
    }

    /// Elements or points of the map.
    pub fn len(&self) -> usize {
        self.sites
    }

    /// Entries of the map: as many, or three times as many where elements show slopes.
    pub fn entries(&self) -> usize {
        self.direct[0].len()
    }

    /// Whether elements show slopes.
    pub fn is_linear(&self) -> bool {
        self.entries() > self.sites
    }

    /// The element that an entry belongs to.
    #[inline]
    pub(super) fn site_of(&self, entry: usize) -> usize {
        // Most entries are means: a division would take longer than the branch.
        if entry < self.sites { entry } else { entry % self.sites }
    }

    /// What one unit of the direct and of the indirect sums is worth in an element or at a point, in lx.
    pub fn scales(&self, site: usize) -> (f64, f64) {
        (self.direct_samples.inverse(site), self.indirect_scale(site))
    }

    /// Whether the map has no entry.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn indirect_scale(&self, site: usize) -> f64 {
        let unit_lx = match &self.indirect_unit_lx {
            Unit::Lux => 1.0,
            Unit::Packets { luminous_flux_lm, area_m2 } => luminous_flux_lm / area_m2[site],
        };
        unit_lx * self.indirect_samples.inverse(site)
    }

    /// Illuminance of one entry in one replica, in lx.
    #[inline]
    pub fn illuminance_lx(&self, replica: usize, entry: usize) -> f64 {
        let site = self.site_of(entry);
        self.direct[replica][entry] * self.direct_samples.inverse(site)
            + self.indirect[replica][entry] * self.indirect_scale(site)
    }

    /// What an element shows at a point of it in one replica, in lx.
    pub fn shown_lx(&self, replica: usize, site: usize, at: [f64; 2]) -> f64 {
        let mean_lx = self.illuminance_lx(replica, site);
        if !self.is_linear() {
            return mean_lx;
        }
        let slope_lx = |number: usize| self.illuminance_lx(replica, (1 + number) * self.sites + site);
        Linear([mean_lx, slope_lx(0), slope_lx(1)]).at(at)
    }

    /// Direct and indirect light of an element, each as the coefficients in lx of what it shows.
    pub fn parts_lx(&self, site: usize) -> [[f64; 1 + SLOPES]; 2] {
        let (direct_scale, indirect_scale) = self.scales(site);
        [(&self.direct, direct_scale), (&self.indirect, indirect_scale)].map(|(slabs, scale)| {
            std::array::from_fn(|number| {
                let entry = number * self.sites + site;
                if entry < self.entries() { mean(slabs.iter().map(|slab| slab[entry])) * scale } else { 0.0 }
            })
        })
    }

    /// Coefficients in lx of the two linear polynomials of an element, mean over the replicas; 0 where none are kept.
    pub fn slopes_lx(&self, site: usize) -> [f64; SLOPES] {
        std::array::from_fn(|k| {
            let entry = (1 + k) * self.sites + site;
            if entry < self.entries() {
                mean((0..REPLICAS).map(|replica| self.illuminance_lx(replica, entry)))
            } else {
                0.0
            }
        })
    }

    /// Direct illuminance of one entry, mean over the replicas, in lx.
    pub fn direct_lx(&self, entry: usize) -> f64 {
        mean(self.direct.iter().map(|slab| slab[entry])) * self.direct_samples.inverse(entry)
    }

    /// Indirect illuminance of one entry, mean over the replicas, in lx.
    pub fn indirect_lx(&self, entry: usize) -> f64 {
        mean(self.indirect.iter().map(|slab| slab[entry])) * self.indirect_scale(entry)
    }

    /// Variance in lx² of the direct light of a replica, weighted mean over elements or points.
    pub fn direct_variance(&self, weights: &[f64]) -> f64 {
        let (mut sum, mut weight_sum) = (0.0, 0.0);
        for (entry, weight) in weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
            let inverse = self.direct_samples.inverse(self.site_of(entry));
            sum += weight * (inverse * standard_error(|replica| self.direct[replica][entry])).powi(2);
            if entry < self.sites {
                weight_sum += weight;
            }
        }
        REPLICAS as f64 * sum / weight_sum.max(f64::MIN_POSITIVE)
    }

    /// Squared standard error of the mean over the replicas of a quantity given replica by replica. What the replicas of a half share
    /// through their cells is not in it: that is judged by itself.
    pub fn squared_error(&self, value: impl Fn(usize) -> f64) -> f64 {
        if self.cells_error.is_some() { within_halves(value) } else { squared_error(value) }
    }

    /// Takes off what walks know of the cells' error, for entries that count with these weights; to be called once the sums are those of
    /// cells alone.
    pub fn take_residuals(&mut self, weights: &[f64]) {
        let Some(residuals) = &mut self.residuals else {
            return;
        };
        residuals.settle(weights);
        for (replica, slab) in self.indirect.iter_mut().enumerate() {
            for (entry, sum_lx) in slab.iter_mut().enumerate() {
                let samples = self.indirect_samples.of(entry % self.sites);
                *sum_lx += samples as f64 * residuals.correction_lx(replica, entry);
            }
        }
        self.cells_error = Some(residuals.cells_error());
    }

    /// Forgets what was gathered, and what walks said of it.
    pub fn forget_gathered(&mut self) {
        self.indirect.iter_mut().for_each(|slab| slab.fill(0.0));
        self.indirect_samples = Tally::default();
        (self.residuals, self.cells_error) = (None, None);
    }

    /// Takes the indirect light of coarser elements, of which this map's are children.
    pub fn take_indirect(&mut self, coarse: &ReplicaMap, sloped: &[bool], children: &[ChildElement]) {
        self.indirect_samples = coarse.indirect_samples;
        self.indirect = coarse.indirect.iter().map(|slab| on_children(slab, sloped, children)).collect();
        self.cells_error = coarse.cells_error.as_ref().map(|error| CellsError {
            by_site_lx: children.iter().map(|child| error.by_site_lx[child.parent as usize]).collect(),
            ..*error
        });
    }

    /// Indirect scores of one entry over all replicas (packets, where packets are counted).
    pub fn indirect_sum(&self, entry: usize) -> f64 {
        self.indirect.iter().map(|slab| slab[entry]).sum()
    }

    /// Bound in lx of the mean over entries that packets could have met and none has: that of three packets, which stands
    /// for its error, since 0 would claim that it is exact. 0 where one has.
    pub fn unseen_bound_lx(&self, entries: impl Iterator<Item = usize> + Clone) -> f64 {
        let Unit::Packets { luminous_flux_lm, area_m2 } = &self.indirect_unit_lx else {
            return 0.0;
        };
        let packets = self.indirect_samples.complete as f64 * REPLICAS as f64;
        let entries_area_m2: f64 = entries.clone().map(|entry| area_m2[entry]).sum();
        if packets == 0.0 || entries_area_m2 == 0.0 || entries.into_iter().any(|entry| self.indirect_sum(entry) > 0.0) {
            return 0.0;
        }
        3.0 * luminous_flux_lm / (packets * entries_area_m2)
    }

    /// What it knows of scores that are rare: see [`RareScores`].
    pub fn rare_scores(&self) -> RareScores {
        let spreads = (0..self.sites).map(|entry| {
            let indirect_lx = |replica: usize| self.indirect[replica][entry] * self.indirect_scale(entry);
            Spread::of(|replica| self.illuminance_lx(replica, entry), indirect_lx)
        });
        let spreads: Vec<Spread> = spreads.collect();
        let of_those_seen = RareScores::of(&spreads);
        match self.indirect_unit_lx {
            Unit::Lux if self.indirect_samples.complete > 0 => {
                of_those_seen.with_missing(&spreads, !self.may_be_covered)
            }
            _ => of_those_seen,
        }
    }

    /// Lengthens the error bars of entries whose light a few scores bring.
    fn widen_bars(&self, values: &mut MapValues) {
        let rare = self.rare_scores();
        for (error_lx, indirect_lx) in values.standard_error_lx.iter_mut().zip(&values.indirect_lx) {
            *error_lx = rare.bar_lx(*error_lx, *indirect_lx);
        }
    }

    /// Means over the replicas and the standard errors that their spread gives, with 15 degrees of freedom.
    ///
    /// An entry that chains could have reached but none has gets the bound of three packets as its error, a point that no walk has brought
    /// light that of its map's scores, since 0 would claim that it is exact.
    pub fn values(&self) -> MapValues {
        let mut values = MapValues::with_capacity(self.len());
        for entry in 0..self.len() {
            let (direct_lx, indirect_lx) = (self.direct_lx(entry), self.indirect_lx(entry));
            let value_lx = |replica: usize| self.illuminance_lx(replica, entry);
            values.halves_lx.push(half_means(value_lx));
            let spread_lx = self.squared_error(value_lx).sqrt();
            let unseen = matches!(self.indirect_unit_lx, Unit::Packets { .. })
                && self.indirect_samples.complete > 0
                && self.indirect_sum(entry) == 0.0;
            let bound_lx = if unseen { 3.0 * self.indirect_scale(entry) / REPLICAS as f64 } else { 0.0 };
            let direct_scale = self.direct_samples.inverse(self.site_of(entry));
            let of_replica_lx = |replica: usize| direct_scale * self.direct[replica][entry];
            values.direct_standard_error_lx.push(standard_error(of_replica_lx));
            values.direct_lx.push(direct_lx);
            values.indirect_lx.push(indirect_lx);
            values.illuminance_lx.push(direct_lx + indirect_lx);
            values.standard_error_lx.push(spread_lx.max(bound_lx));
        }
        self.widen_bars(&mut values);
        if let Some(error) = &self.cells_error {
            let errors_lx = values.standard_error_lx.iter_mut().zip(&error.by_site_lx);
            errors_lx.for_each(|(error_lx, left_lx)| *error_lx = error_lx.hypot(*left_lx));
        }
        values
    }
}

/// Means over the even and over the odd replicas.
pub(super) fn half_means(value: impl Fn(usize) -> f64) -> [f64; 2] {
    [0, 1].map(|parity| (parity..REPLICAS).step_by(2).map(&value).sum::<f64>() / HALF as f64)
}

fn mean(numbers: impl Iterator<Item = f64>) -> f64 {
    numbers.sum::<f64>() / REPLICAS as f64
}

/// Standard error of the mean over the replicas of a quantity given replica by replica.
pub fn standard_error(value: impl Fn(usize) -> f64) -> f64 {
    squared_error(value).sqrt()
}

fn squared_error(value: impl Fn(usize) -> f64) -> f64 {
    let mean = (0..REPLICAS).map(&value).sum::<f64>() / REPLICAS as f64;
    let squares: f64 = (0..REPLICAS).map(|replica| (value(replica) - mean).powi(2)).sum();
    squares / (REPLICAS * (REPLICAS - 1)) as f64
}
