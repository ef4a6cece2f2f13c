//! The score sums of one map in each replica.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::children::{ChildElement, on_children};
use super::rare_scores::{RareScores, Spread};
use super::residuals::{half_squares, within_halves};
use super::{CellsError, HALF, Levels, MapValues, PACKETS_OF_A_BOUND, PartScores, REPLICAS, Residuals, ScoreEvidence};
use crate::estimators::basis::{Linear, SLOPES};

/// Sums of scores in every replica, with direct and indirect light separate. Entry `i` is the mean of site `i`, an element side or a point.
///
/// A map of elements may also have slopes, and then has more entries than sites. The entries after the means are the coefficients of the
/// first linear polynomial ([`crate::estimators::basis`]) of every element, followed by those of the second. The polynomials are orthonormal, so that
/// weighted sums of squares over all entries are integrals over the elements.
///
/// The value of a replica is `direct sum · direct_scale + indirect sum · indirect_scale[i]`. The scales turn sums over samples into
/// means, and counted flux into flux per area.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ReplicaMap {
    /// One slab per replica: sums of direct scores, in the unit of the map's quantity.
    pub direct: Vec<Vec<f64>>,
    /// One slab per replica: sums of indirect scores (in the same unit, or counts of packets).
    pub indirect: Vec<Vec<f64>>,
    /// Direct samples of each entry so far, the same in every replica.
    pub direct_samples: Tally,
    /// Chains or walks so far, the same in every replica.
    pub indirect_samples: Tally,
    /// Value of one unit of the indirect sum at entry `i` for a single sample: 1 for scores, Φ/A for packets (docs/methods.md (4)).
    pub indirect_unit: Unit,
    /// Residual walks, which measure the error of gathered light; `None` for other samples.
    pub residuals: Option<Residuals>,
    /// Remaining error of the cells in the indirect sums; `None` for other samples.
    pub cells_error: Option<CellsError>,
    /// Single scores of direct and of indirect light, over all replicas. Counted packets are not included.
    pub scores: [PartScores; 2],
    /// Levels from which these scores deviate.
    pub levels: [Levels; 2],
    /// Whether an entry without light may be hidden by contact, so that its 0 is exact. This is true for elements. It is false for points,
    /// because points hidden by contact do not count.
    pub may_be_in_contact: bool,
    sites: usize,
}

/// Number of samples of a map's entries. A pass over all entries may be incomplete.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tally {
    /// Samples that every entry has.
    pub complete: u64,
    /// Entries with a smaller number than this have one sample more.
    pub partial: usize,
}

impl Tally {
    /// Returns the number of samples of one entry.
    #[inline]
    pub fn of(self, entry: usize) -> u64 {
        self.complete + u64::from(entry < self.partial)
    }

    pub(super) fn inverse(self, entry: usize) -> f64 {
        let samples = self.of(entry);
        if samples == 0 { 0.0 } else { 1.0 / samples as f64 }
    }
}

/// Unit of an indirect sum.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Unit {
    /// The sums are in the unit of the map's quantity.
    Scores,
    /// The sums count packets. Each packet carries `luminous_flux_lm` divided by the number of samples; the areas in m² convert this to lx.
    Packets {
        /// Flux of all luminaires in lm.
        luminous_flux_lm: f64,
        /// Area of every entry in m².
        area_m2: Vec<f64>,
    },
}

impl ReplicaMap {
    /// Returns an empty map of `len` entries.
    pub fn new(len: usize, indirect_unit: Unit) -> ReplicaMap {
        ReplicaMap::with_entries(len, len, indirect_unit)
    }

    /// Returns an empty map of `len` elements with slopes.
    pub fn linear(len: usize, indirect_unit: Unit) -> ReplicaMap {
        ReplicaMap::with_entries(len, len * (1 + SLOPES), indirect_unit)
    }

    fn with_entries(sites: usize, entries: usize, indirect_unit: Unit) -> ReplicaMap {
        ReplicaMap {
            direct: vec![vec![0.0; entries]; REPLICAS],
            indirect: vec![vec![0.0; entries]; REPLICAS],
            direct_samples: Tally::default(),
            indirect_samples: Tally::default(),
            indirect_unit,
            residuals: None,
            cells_error: None,
            scores: Default::default(),
            levels: Default::default(),
            may_be_in_contact: false,
            sites,
        }
    }

    /// Sets the levels of direct light, from which scores deviate, for entries with samples and without a level.
    pub fn fix_direct_levels(&mut self, entries: Range<usize>) {
        let count = self.entries();
        let (slabs, tally) = (&self.direct, self.direct_samples);
        self.levels[0].fix(entries, count, |entry| {
            (tally.of(entry) > 0).then(|| mean(slabs.iter().map(|slab| slab[entry])) * tally.inverse(entry))
        });
    }

    /// Sets the levels of indirect light in the same way.
    pub fn fix_indirect_levels(&mut self, entries: Range<usize>) {
        let count = self.entries();
        let (slabs, tally) = (&self.indirect, self.indirect_samples);
        self.levels[1].fix(entries, count, |entry| {
            (tally.of(entry) > 0).then(|| mean(slabs.iter().map(|slab| slab[entry])) * tally.inverse(entry))
        });
    }

    /// Clears direct light: it begins anew.
    pub fn forget_direct(&mut self) {
        self.direct.iter_mut().for_each(|slab| slab.fill(0.0));
        self.direct_samples = Tally::default();
        self.scores[0] = PartScores::default();
        self.levels[0] = Levels::default();
    }

    /// Returns the variance of a replica's direct light of one entry, from the even and from the odd half.
    pub fn direct_variances_of(&self, entry: usize) -> [f64; 2] {
        let inverse = self.direct_samples.inverse(self.site_of(entry));
        half_squares(|replica| inverse * self.direct[replica][entry]).map(|squares| squares / (HALF - 1) as f64)
    }

    /// Clears the single scores of indirect light and their levels: they begin anew.
    pub fn forget_indirect_scores(&mut self) {
        self.scores[1] = PartScores::default();
        self.levels[1] = Levels::default();
    }

    /// Returns what single scores of direct and of indirect light show of the map's error.
    pub fn score_evidence(&self) -> [ScoreEvidence; 2] {
        let samples = |tally: Tally| tally.complete as f64 * REPLICAS as f64;
        let part =
            |part: usize, tally: Tally| self.scores[part].evidence(samples(tally), samples(tally) * self.len() as f64);
        let direct = part(0, self.direct_samples);
        let Unit::Packets { luminous_flux_lm, area_m2 } = &self.indirect_unit else {
            return [direct, part(1, self.indirect_samples)];
        };
        // Each packet counted in an element is a score of Φ/A, and no score is larger: the tail is bounded.
        let flux_per_packet_lm = luminous_flux_lm / samples(self.indirect_samples).max(1.0);
        let (mut variance, mut fourth) = (0.0, 0.0);
        for (entry, area_m2) in area_m2.iter().enumerate() {
            let square = flux_per_packet_lm * flux_per_packet_lm / area_m2;
            variance += square * self.indirect_sum(entry);
            fourth += square * square * self.indirect_sum(entry);
        }
        [direct, ScoreEvidence { weighted_variance: variance, fourth, ..ScoreEvidence::default() }]
    }

    /// Returns the number of elements or points of the map.
    pub fn len(&self) -> usize {
        self.sites
    }

    /// Returns the number of entries: one per site, or three where elements have slopes.
    pub fn entries(&self) -> usize {
        self.direct[0].len()
    }

    /// Whether elements have slopes.
    pub fn is_linear(&self) -> bool {
        self.entries() > self.sites
    }

    /// Returns the element or point of an entry.
    #[inline]
    pub(super) fn site_of(&self, entry: usize) -> usize {
        // Most entries are means: a division takes longer than the branch.
        if entry < self.sites { entry } else { entry % self.sites }
    }

    /// Returns the values of one unit of the direct and of the indirect sums, at an element or a point.
    pub fn scales(&self, site: usize) -> (f64, f64) {
        (self.direct_samples.inverse(site), self.indirect_scale(site))
    }

    /// Whether the map has no entry.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn indirect_scale(&self, site: usize) -> f64 {
        let unit = match &self.indirect_unit {
            Unit::Scores => 1.0,
            Unit::Packets { luminous_flux_lm, area_m2 } => luminous_flux_lm / area_m2[site],
        };
        unit * self.indirect_samples.inverse(site)
    }

    /// Returns the value of one entry in one replica, in the unit of the map's quantity.
    #[inline]
    pub fn value(&self, replica: usize, entry: usize) -> f64 {
        let site = self.site_of(entry);
        self.direct[replica][entry] * self.direct_samples.inverse(site)
            + self.indirect[replica][entry] * self.indirect_scale(site)
    }

    /// Returns the illuminance that an element shows at a point inside it in one replica, in lx.
    pub fn shown_lx(&self, replica: usize, site: usize, at: [f64; 2]) -> f64 {
        let mean_lx = self.value(replica, site);
        if !self.is_linear() {
            return mean_lx;
        }
        let slope_lx = |number: usize| self.value(replica, (1 + number) * self.sites + site);
        Linear([mean_lx, slope_lx(0), slope_lx(1)]).at(at)
    }

    /// Returns the direct and indirect light of an element, each as coefficients in lx of the function that it shows.
    pub fn parts_lx(&self, site: usize) -> [[f64; 1 + SLOPES]; 2] {
        let (direct_scale, indirect_scale) = self.scales(site);
        [(&self.direct, direct_scale), (&self.indirect, indirect_scale)].map(|(slabs, scale)| {
            std::array::from_fn(|number| {
                let entry = number * self.sites + site;
                if entry < self.entries() { mean(slabs.iter().map(|slab| slab[entry])) * scale } else { 0.0 }
            })
        })
    }

    /// Returns the coefficients in lx of an element's two linear polynomials, averaged over the replicas; 0 for a map without slopes.
    pub fn slopes_lx(&self, site: usize) -> [f64; SLOPES] {
        std::array::from_fn(|k| {
            let entry = (1 + k) * self.sites + site;
            if entry < self.entries() { mean((0..REPLICAS).map(|replica| self.value(replica, entry))) } else { 0.0 }
        })
    }

    /// Returns the direct part of one entry, averaged over the replicas.
    pub fn direct(&self, entry: usize) -> f64 {
        mean(self.direct.iter().map(|slab| slab[entry])) * self.direct_samples.inverse(entry)
    }

    /// Returns the indirect part of one entry, averaged over the replicas.
    pub fn indirect(&self, entry: usize) -> f64 {
        mean(self.indirect.iter().map(|slab| slab[entry])) * self.indirect_scale(entry)
    }

    /// Returns the variance of a replica's direct light in the square of the map's unit, as a weighted mean over elements or points.
    pub fn direct_variance(&self, weights: &[f64]) -> f64 {
        let (mut sum, mut weight_sum) = (0.0, 0.0);
        for (entry, weight) in weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
            sum += weight * self.direct_variance_of(entry);
            if entry < self.sites {
                weight_sum += weight;
            }
        }
        sum / weight_sum.max(f64::MIN_POSITIVE)
    }

    /// Returns the variance of a replica's direct light of one entry, in the square of the map's unit.
    pub fn direct_variance_of(&self, entry: usize) -> f64 {
        let inverse = self.direct_samples.inverse(self.site_of(entry));
        REPLICAS as f64 * (inverse * standard_error(|replica| self.direct[replica][entry])).powi(2)
    }

    /// Returns the squared standard error of the mean over the replicas of a quantity given per replica. It excludes the error that the
    /// replicas of a half share through their cells, which is estimated separately.
    pub fn squared_error(&self, value: impl Fn(usize) -> f64) -> f64 {
        if self.cells_error.is_some() { within_halves(value) } else { squared_error(value) }
    }

    /// Corrects the indirect sums by the cells' error that walks have measured, for entries with these weights. Call it when the sums hold
    /// light from cells alone.
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

    /// Clears the gathered light and the walks' measurement of it.
    pub fn forget_gathered(&mut self) {
        self.indirect.iter_mut().for_each(|slab| slab.fill(0.0));
        self.indirect_samples = Tally::default();
        (self.residuals, self.cells_error) = (None, None);
    }

    /// Takes over the indirect light of coarser elements, whose children this map's elements are.
    pub fn take_indirect(&mut self, coarse: &ReplicaMap, sloped: &[bool], children: &[ChildElement]) {
        self.indirect_samples = coarse.indirect_samples;
        self.indirect = coarse.indirect.iter().map(|slab| on_children(slab, sloped, children)).collect();
        self.cells_error = coarse.cells_error.as_ref().map(|error| CellsError {
            by_site: children.iter().map(|child| error.by_site[child.parent as usize]).collect(),
            ..*error
        });
    }

    /// Returns the indirect scores of one entry over all replicas (packets, where packets are counted).
    pub fn indirect_sum(&self, entry: usize) -> f64 {
        self.indirect.iter().map(|slab| slab[entry]).sum()
    }

    /// Returns an upper bound, in the unit of the map, of the mean over entries that packets could reach but none has: the light of three
    /// packets. The bound serves as their error, since 0 would mean exact. The result is 0 if a packet has reached one.
    pub fn unseen_bound(&self, entries: impl Iterator<Item = usize> + Clone) -> f64 {
        let Unit::Packets { luminous_flux_lm, area_m2 } = &self.indirect_unit else {
            return 0.0;
        };
        let packets = self.indirect_samples.complete as f64 * REPLICAS as f64;
        let entries_area_m2: f64 = entries.clone().map(|entry| area_m2[entry]).sum();
        if packets == 0.0 || entries_area_m2 == 0.0 || entries.into_iter().any(|entry| self.indirect_sum(entry) > 0.0) {
            return 0.0;
        }
        PACKETS_OF_A_BOUND * luminous_flux_lm / (packets * entries_area_m2)
    }

    /// Returns the statistics of rare scores: see [`RareScores`].
    pub fn rare_scores(&self) -> RareScores {
        let spreads = (0..self.sites).map(|entry| {
            let indirect = |replica: usize| self.indirect[replica][entry] * self.indirect_scale(entry);
            Spread::of(|replica| self.value(replica, entry), indirect)
        });
        let spreads: Vec<Spread> = spreads.collect();
        let of_those_seen = RareScores::of(&spreads);
        match self.indirect_unit {
            Unit::Scores if self.indirect_samples.complete > 0 => {
                of_those_seen.with_missing(&spreads, !self.may_be_in_contact)
            }
            _ => of_those_seen,
        }
    }

    /// Lengthens the error bars of entries whose light comes from few scores.
    fn widen_bars(&self, values: &mut MapValues) {
        let rare = self.rare_scores();
        for (error, indirect) in values.standard_error.iter_mut().zip(&values.indirect) {
            *error = rare.bar(*error, *indirect);
        }
    }

    /// Returns the means over the replicas, and the standard errors that their spread gives with 15 degrees of freedom.
    ///
    /// An error of 0 would mean exact. So an entry that chains could reach but none has gets the bound of three packets as its error. A
    /// point to which no walk has brought light gets the error from the map's scores elsewhere.
    pub fn values(&self) -> MapValues {
        let mut values = MapValues::with_capacity(self.len());
        for entry in 0..self.len() {
            let (direct, indirect) = (self.direct(entry), self.indirect(entry));
            let value = |replica: usize| self.value(replica, entry);
            values.halves.push(half_means(value));
            let spread = self.squared_error(value).sqrt();
            let unseen = matches!(self.indirect_unit, Unit::Packets { .. })
                && self.indirect_samples.complete > 0
                && self.indirect_sum(entry) == 0.0;
            let bound = if unseen { PACKETS_OF_A_BOUND * self.indirect_scale(entry) / REPLICAS as f64 } else { 0.0 };
            let direct_scale = self.direct_samples.inverse(self.site_of(entry));
            let of_replica = |replica: usize| direct_scale * self.direct[replica][entry];
            values.direct_standard_error.push(standard_error(of_replica));
            values.direct.push(direct);
            values.indirect.push(indirect);
            values.value.push(direct + indirect);
            values.standard_error.push(spread.max(bound));
        }
        self.widen_bars(&mut values);
        if let Some(error) = &self.cells_error {
            let errors = values.standard_error.iter_mut().zip(&error.by_site);
            errors.for_each(|(error, left)| *error = error.hypot(*left));
        }
        values
    }
}

/// Returns the means over the even and over the odd replicas.
pub(super) fn half_means(value: impl Fn(usize) -> f64) -> [f64; 2] {
    [0, 1].map(|parity| (parity..REPLICAS).step_by(2).map(&value).sum::<f64>() / HALF as f64)
}

fn mean(numbers: impl Iterator<Item = f64>) -> f64 {
    numbers.sum::<f64>() / REPLICAS as f64
}

/// Returns the standard error of the mean over the replicas of a quantity given per replica.
pub fn standard_error(value: impl Fn(usize) -> f64) -> f64 {
    squared_error(value).sqrt()
}

fn squared_error(value: impl Fn(usize) -> f64) -> f64 {
    let mean = (0..REPLICAS).map(&value).sum::<f64>() / REPLICAS as f64;
    let squares: f64 = (0..REPLICAS).map(|replica| (value(replica) - mean).powi(2)).sum();
    squares / (REPLICAS * (REPLICAS - 1)) as f64
}
