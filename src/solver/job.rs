//! One map's work: what a sample is, and how sixteen replicas of it go forward together.

use rayon::prelude::*;

use super::pilot::DirectShare;
use crate::chain::{End, Stage};
use crate::estimators::direct::{DirectPass, Receiver};
use crate::estimators::walk::sample_indirect_lx;
use crate::geometry::Origin;
use crate::maps::{Judgement, MapKind, REPLICAS, ReplicaMap, Unit, judge};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::scene::{ReceiverSet, Scene};

/// Points of a receiver set that a thread takes at a time.
const POINTS_PER_CHUNK: usize = 64;
/// Bits of a stream's index that count samples; the bits above them tell the point or the element.
const SAMPLE_BITS: u32 = 32;

/// With 95% confidence fewer than 3/N of the flux goes where none of N packets went.
pub const PACKETS_OF_A_BOUND: f64 = 3.0;
/// A map that is dark after this many chains, over the target error, is left dark.
const CHAINS_FOR_DARKNESS: f64 = 100.0 * PACKETS_OF_A_BOUND;

/// Everything that a job needs to know of its run.
pub struct Context<'a> {
    /// The scene as read.
    pub scene: &'a Scene,
    /// The scene made ready for packets.
    pub stage: &'a Stage,
    /// Seed of the run.
    pub seed: u64,
}

/// How the packets of forward chains ended, counted.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ends {
    /// Absorbed by surfaces.
    pub absorbed: u64,
    /// Absorbed by panes of glass.
    pub panes: u64,
    /// Absorbed by bright balls.
    pub balls: u64,
    /// Absorbed by backs of one-sided surfaces.
    pub back_faces: u64,
    /// Left the scene.
    pub escaped: u64,
}

impl Ends {
    fn count(&mut self, end: End) {
        match end {
            End::Absorbed => self.absorbed += 1,
            End::Pane => self.panes += 1,
            End::Ball => self.balls += 1,
            End::BackFace => self.back_faces += 1,
            End::Escaped => self.escaped += 1,
        }
    }

    /// All packets.
    pub fn packets(&self) -> u64 {
        self.absorbed + self.panes + self.balls + self.back_faces + self.escaped
    }
}

impl std::ops::AddAssign for Ends {
    fn add_assign(&mut self, other: Ends) {
        self.absorbed += other.absorbed;
        self.panes += other.panes;
        self.balls += other.balls;
        self.back_faces += other.back_faces;
        self.escaped += other.escaped;
    }
}

/// One map in the making.
pub struct Job {
    /// `elements` or the receiver set's name.
    pub name: String,
    /// What it is about.
    pub kind: MapKind,
    /// The sums.
    pub map: ReplicaMap,
    /// Area or weight of every entry; 0 leaves it out of errors.
    pub weights: Vec<f64>,
    /// Whether the target binds it.
    pub bound: bool,
    /// Whether the stop rule accepted it.
    pub met: bool,
    /// Samples done in every replica: chains for elements, walks a point for receivers; passes in a black scene.
    pub samples: u64,
    /// Samples at which it is judged next.
    pub next_judgement: u64,
    /// Rays traced for it.
    pub rays: u64,
    /// Seconds of computing spent on it, for forecasts in seconds only.
    pub seconds: f64,
    /// Ends of its packets (elements only), replica by replica.
    pub ends: [Ends; REPLICAS],
    /// Latest judgement.
    pub judgement: Judgement,
    judged_samples: u64,
    share: DirectShare,
    number: u32,
    black: bool,
}

impl Job {
    /// A job for the element map.
    pub fn elements(context: &Context, bound: bool) -> Job {
        let elements = &context.stage.elements;
        let area_m2: Vec<f64> =
            (0..elements.len() as u32).map(|cell| elements.area_m2(context.scene, elements.cell(cell))).collect();
        let unit =
            Unit::Packets { luminous_flux_lm: context.stage.emitters.luminous_flux_lm(), area_m2: area_m2.clone() };
        let map = ReplicaMap::new(elements.len(), unit);
        Job::new(context, "elements".to_owned(), MapKind::Elements, 0, map, area_m2, bound)
    }

    /// A job for a receiver set.
    pub fn receivers(context: &Context, set: usize, bound: bool) -> Job {
        let receivers = &context.scene.receivers[set];
        let weights = receivers.points.iter().map(|point| if point.inside { 0.0 } else { point.weight }).collect();
        let map = ReplicaMap::new(receivers.points.len(), Unit::Lux);
        Job::new(context, receivers.name.clone(), MapKind::Receivers(set), set as u32 + 1, map, weights, bound)
    }

    fn new(
        context: &Context,
        name: String,
        kind: MapKind,
        number: u32,
        map: ReplicaMap,
        weights: Vec<f64>,
        bound: bool,
    ) -> Job {
        Job {
            name,
            kind,
            map,
            weights,
            bound,
            met: false,
            samples: 0,
            next_judgement: 0,
            rays: 0,
            seconds: 0.0,
            ends: [Ends::default(); REPLICAS],
            judgement: Judgement::default(),
            judged_samples: 0,
            share: DirectShare::of(context, kind, number),
            number,
            black: !context.stage.reflects(),
        }
    }

    /// Chains that a number of samples a replica stands for, all replicas; 0 in a black scene.
    pub fn chains(&self) -> u64 {
        let per_sample = match self.kind {
            MapKind::Elements => 1,
            MapKind::Receivers(_) => self.map.len() as u64,
        };
        if self.black { 0 } else { self.samples * per_sample * REPLICAS as u64 }
    }

    /// Samples a replica that fill at least `chains` chains.
    pub fn samples_for(&self, chains: u64) -> u64 {
        let per_sample = match self.kind {
            MapKind::Elements => REPLICAS as u64,
            MapKind::Receivers(_) => (REPLICAS * self.map.len().max(1)) as u64,
        };
        if self.black { 1 } else { chains.div_ceil(per_sample).max(1) }
    }

    /// Samples at which the error is judged for the first time.
    pub fn first_samples(&self) -> u64 {
        match self.kind {
            _ if self.black => 1,
            MapKind::Elements => 256,
            MapKind::Receivers(_) => 4,
        }
    }

    /// Rays that one sample of all replicas takes, as the pilot counted them.
    pub fn rays_per_sample(&self) -> f64 {
        let direct = self.share.rays_per_pass * if self.black { 1.0 } else { self.share.passes_per_sample };
        (direct + self.share.rays_per_indirect).max(1.0) * REPLICAS as f64
    }

    /// Rays that the next `samples` samples take, the first pass over direct light included.
    pub fn rays_for_next(&self, samples: u64) -> f64 {
        let passes = self.passes_at(self.samples + samples) - self.map.direct_samples;
        let direct = passes as f64 * self.share.rays_per_pass;
        (direct + samples as f64 * self.share.rays_per_indirect) * REPLICAS as f64
    }

    /// Whether the error will never be anything but 0.
    pub fn is_exact(&self) -> bool {
        self.black && self.map.direct_samples > 0 && self.judgement.expected_error == 0.0
    }

    /// Nothing of it ever bounces: the scene is black.
    pub fn is_black(&self) -> bool {
        self.black
    }

    fn passes_at(&self, samples: u64) -> u64 {
        if self.black {
            return samples;
        }
        ((samples as f64 * self.share.passes_per_sample).ceil() as u64).max(1)
    }

    /// Goes forward to a number of samples in every replica.
    pub fn advance(&mut self, context: &Context, samples: u64) {
        let passes = self.map.direct_samples..self.passes_at(samples);
        let indirect = if self.black { 0..0 } else { self.samples..samples };
        match self.kind {
            MapKind::Elements => self.advance_elements(context, passes.clone(), indirect.clone()),
            MapKind::Receivers(set) => {
                self.advance_receivers(context, &context.scene.receivers[set], passes.clone(), indirect.clone());
            }
        }
        self.map.direct_samples = passes.end.max(passes.start);
        self.map.indirect_samples = if self.black { 0 } else { samples };
        self.samples = samples;
    }

    fn advance_elements(&mut self, context: &Context, passes: std::ops::Range<u64>, chains: std::ops::Range<u64>) {
        let (stage, number) = (context.stage, self.number);
        let results: Vec<(u64, Ends)> = self
            .map
            .direct
            .par_iter_mut()
            .zip(self.map.indirect.par_iter_mut())
            .enumerate()
            .map(|(replica, (direct, indirect))| {
                let mut rays = direct_passes_over_cells(context, number, replica as u32, passes.clone(), direct);
                let mut ends = Ends::default();
                let mut stream = Stream::new(context.seed, Purpose::Chains, number, replica as u32);
                let shift = emission_shift(&mut stream);
                for chain in chains.clone() {
                    stream.seek(chain);
                    let choice = spread_choice(chain, shift);
                    let (end, chain_rays) = stage.trace_chain(choice, &mut stream, |arrival| {
                        if arrival.bounces == 0 {
                            return;
                        }
                        let hit = &arrival.hit;
                        if let Some(cell) = stage.elements.cell_at(hit.triangle, hit.barycentric, hit.side) {
                            indirect[cell as usize] += 1.0;
                        }
                    });
                    ends.count(end);
                    rays += chain_rays;
                }
                (rays, ends)
            })
            .collect();
        for (replica, (rays, ends)) in results.into_iter().enumerate() {
            self.rays += rays;
            self.ends[replica] += ends;
        }
    }

    fn advance_receivers(
        &mut self,
        context: &Context,
        set: &ReceiverSet,
        passes: std::ops::Range<u64>,
        walks: std::ops::Range<u64>,
    ) {
        let (stage, number) = (context.stage, self.number);
        let origins: Vec<Origin> =
            set.points.iter().map(|point| stage.tracer.side_origin(point.position_m, point.normal)).collect();
        let rays: Vec<u64> = self
            .map
            .direct
            .par_iter_mut()
            .zip(self.map.indirect.par_iter_mut())
            .enumerate()
            .flat_map(|(replica, (direct, indirect))| {
                let chunks = direct.par_chunks_mut(POINTS_PER_CHUNK).zip(indirect.par_chunks_mut(POINTS_PER_CHUNK));
                chunks.enumerate().map(move |(chunk, sums)| (replica as u32, chunk, sums))
            })
            .map(|(replica, chunk, (direct, indirect))| {
                let mut rays = 0;
                let mut pass_room = DirectPass::default();
                let mut cut = Cut::default();
                let mut direct_stream = Stream::new(context.seed, Purpose::Direct, number, replica);
                let mut walk_stream = Stream::new(context.seed, Purpose::Walks, number, replica);
                for (offset, (direct_lx, indirect_lx)) in direct.iter_mut().zip(indirect.iter_mut()).enumerate() {
                    let index = chunk * POINTS_PER_CHUNK + offset;
                    let point = &set.points[index];
                    if point.inside {
                        continue;
                    }
                    let receiver =
                        Receiver { point_m: point.position_m, normal: point.normal, origin: &origins[index] };
                    for pass in passes.clone() {
                        direct_stream.seek(((index as u64) << SAMPLE_BITS) | pass);
                        let (lx, pass_rays) = pass_room.at_point(stage, &receiver, &mut direct_stream);
                        *direct_lx += lx;
                        rays += pass_rays;
                    }
                    for walk in walks.clone() {
                        walk_stream.seek(((index as u64) << SAMPLE_BITS) | walk);
                        let (lx, walk_rays) = sample_indirect_lx(stage, &receiver, &mut cut, &mut walk_stream);
                        *indirect_lx += lx;
                        rays += walk_rays;
                    }
                }
                rays
            })
            .collect();
        self.rays += rays.iter().sum::<u64>();
    }

    /// Judges the error as it stands.
    pub fn judge(&mut self, context: &Context) {
        self.judged_samples = self.samples;
        self.judgement = judge(&self.map, self.weights.iter().copied().enumerate());
        if self.judgement.unseen && !self.judgement.dark {
            // Direct light is known but nothing has bounced yet: what N chains have not found is below 3/N.
            let bound = PACKETS_OF_A_BOUND / self.chains() as f64 * self.flux_over_map(context);
            self.judgement.halves_error = self.judgement.halves_error.max(bound);
            self.judgement.expected_error = self.judgement.expected_error.max(bound);
            self.judgement.unseen = false;
        }
    }

    /// Flux of all luminaires over the flux that the map shows: 1 / (Σ E A / Φ) for elements, 1 for receivers.
    fn flux_over_map(&self, context: &Context) -> f64 {
        match self.kind {
            MapKind::Elements => {
                let area_m2: f64 = self.weights.iter().sum();
                context.stage.emitters.luminous_flux_lm() / (area_m2 * self.judgement.mean_lx)
            }
            MapKind::Receivers(_) => 1.0,
        }
    }

    /// Whether it is dark after so many chains that it no longer holds up a run.
    pub fn stays_dark(&self, target_error: f64) -> bool {
        self.judged_samples > 0
            && self.judgement.dark
            && (self.black || self.chains() as f64 * target_error > CHAINS_FOR_DARKNESS)
    }
}

impl Job {
    /// Samples at the latest judgement.
    pub fn judged_samples(&self) -> u64 {
        self.judged_samples
    }
}

fn direct_passes_over_cells(
    context: &Context,
    number: u32,
    replica: u32,
    passes: std::ops::Range<u64>,
    direct: &mut [f64],
) -> u64 {
    let mut rays = 0;
    let mut room = DirectPass::default();
    let mut stream = Stream::new(context.seed, Purpose::Direct, number, replica);
    for (index, direct_lx) in direct.iter_mut().enumerate() {
        if passes.is_empty() {
            break;
        }
        let cell = context.stage.elements.cell(index as u32);
        for pass in passes.clone() {
            stream.seek(((index as u64) << SAMPLE_BITS) | pass);
            let (lx, pass_rays) = room.over_cell(context.stage, context.scene, cell, &mut stream);
            *direct_lx += lx;
            rays += pass_rays;
        }
    }
    rays
}

/// Index of the stream that shifts a replica's choices of emitters: the last one, which no chain reaches.
const SHIFT_INDEX: u64 = u64::MAX >> 32;

/// The random shift of a replica's emitter choices.
fn emission_shift(stream: &mut Stream) -> f64 {
    stream.seek(SHIFT_INDEX << 32);
    stream.fine_unit()
}

/// Choice of the emitter for a chain: the van der Corput sequence, shifted at random for every replica, so that any
/// run of chains shares itself out among the luminaires in proportion to flux, and each choice alone is uniform.
fn spread_choice(chain: u64, shift: f64) -> f64 {
    let van_der_corput = (chain.reverse_bits() >> 11) as f64 / (1u64 << 53) as f64;
    let choice = van_der_corput + shift;
    if choice >= 1.0 { choice - 1.0 } else { choice }
}

#[cfg(test)]
mod tests {
    use super::spread_choice;

    #[test]
    fn choices_spread_evenly_and_stay_below_one() {
        for shift in [0.0, 0.3, 1.0 - 2f64.powi(-53)] {
            let mut counts = [0; 8];
            for chain in 0..64 {
                let choice = spread_choice(chain, shift);
                assert!((0.0..1.0).contains(&choice));
                counts[(choice * 8.0) as usize] += 1;
            }
            assert!(counts.iter().all(|count| (7..=9).contains(count)), "{counts:?}");
        }
    }
}
