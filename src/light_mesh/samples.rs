//! The luminaires as sample points. Each sample point is one bit in the data of a mesh point.

use std::f64::consts::PI;

use glam::DVec3;

use crate::base::quadrature::GOLDEN;
use crate::estimators::receiver::Receiver;
use crate::geometry::{Origin, Tracer};
use crate::sampling::emitter::Emitter;
use crate::sampling::opening::OpeningPoint;
use crate::sampling::random::{Purpose, Stream};
use crate::transport::{Traced, World};

/// Bits per word.
const WORD: usize = u64::BITS as usize;
/// Sample points along each edge of the square that stratifies an area: for few area luminaires, and for many.
const EDGES: [usize; 2] = [8, 4];
/// Largest number of areas and openings that each get the larger number of sample points.
const FEW: usize = 8;
/// Map number of the random streams that position the sample points.
const PLACING: u32 = u32::MAX;

/// Sample points of all emitters.
pub struct Samples {
    /// Words for all bits.
    pub words: usize,
    /// First word of the bits for sample points that are seen only through panes; `None` without panes.
    panes_from: Option<usize>,
    groups: Vec<EmitterSamples>,
    points: Vec<EmitterPoint>,
}

/// The sample points of one emitter.
#[derive(Clone, Copy, Debug)]
struct EmitterSamples {
    word: usize,
    /// First bit in the word.
    shift: u32,
    count: u32,
    mask: u64,
    /// Index of its first sample point.
    first: usize,
    /// Whether every sample point contributes its own share, as parts of an opening do. Otherwise the whole emitter has a closed formula.
    in_parts: bool,
}

#[derive(Clone, Copy)]
enum EmitterPoint {
    Fixed {
        origin: Origin,
        point: OpeningPoint,
    },
    /// A point on the disk that a receiver point sees of a ball.
    OnBall([f64; 2]),
}

/// Placing of the sample points on an area.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SamplePlacing {
    /// Enough sample points for soft shadows, fewer where there are many areas.
    Stratified,
    /// This many on every triangle, ball and opening; a single one lies in the middle.
    Count(usize),
}

impl Samples {
    /// Positions sample points on every emitter. The seed moves them within their strata.
    pub fn of(world: &World, placing: SamplePlacing, seed: u64) -> Samples {
        let list = world.emitters.list();
        let extended = list.iter().filter(|emitter| !emitter.is_single_point()).count();
        let stratified = EDGES[usize::from(extended > FEW)].pow(2);
        let count_of_extended = if let SamplePlacing::Count(count) = placing { count } else { stratified };
        let mut samples =
            Samples { words: 0, panes_from: None, groups: Vec::with_capacity(list.len()), points: Vec::new() };
        let mut next_bit = 0;
        for (index, emitter) in list.iter().enumerate() {
            let is_extended = !emitter.is_single_point();
            let count = if is_extended { count_of_extended } else { 1 };
            if next_bit % WORD + count > WORD {
                next_bit = next_bit.next_multiple_of(WORD);
            }
            let shift = (next_bit % WORD) as u32;
            let ones = if count >= WORD { u64::MAX } else { (1 << count) - 1 };
            samples.groups.push(EmitterSamples {
                word: next_bit / WORD,
                shift,
                count: count as u32,
                mask: ones << shift,
                first: samples.points.len(),
                in_parts: emitter.has_opening(),
            });
            let mut stream = Stream::new(seed, Purpose::LightMesh, PLACING, index as u32);
            for number in 0..count {
                let variates = stratum(number, count, &mut stream);
                samples.points.push(point_of(world, emitter, variates, &mut stream));
            }
            next_bit += count;
        }
        samples.words = next_bit.div_ceil(WORD);
        if world.has_panes() {
            samples.panes_from = Some(samples.words);
            samples.words *= 2;
        }
        samples
    }

    /// Returns the number of sample points of all emitters: the rays of one receiver point that sees all of them.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there is no emitter.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Tests the visibility of every sample point from one position and writes the words. Returns the number of rays.
    pub fn test_visibility(&self, world: &World, sees: Sees, from: &Origin, place_m: DVec3, words: &mut [u64]) -> u64 {
        words.fill(0);
        for (emitter, group) in world.emitters.list().iter().zip(&self.groups) {
            for number in 0..group.count as usize {
                let Some(origin) = self.origin_of(world, place_m, emitter, group.first + number) else { continue };
                let bit = 1 << (group.shift as usize + number);
                if sees(&world.tracer, from, &origin) {
                    words[group.word] |= bit;
                } else if let Some(panes_from) = self.panes_from
                    && world.transmittance(from, &origin) > 0.0
                {
                    words[panes_from + group.word] |= bit;
                }
            }
        }
        self.points.len() as u64
    }

    /// Returns the origin of an emitter's sample point, for rays from a receiver point; `None` if the receiver point is inside the ball.
    fn origin_of(&self, world: &World, place_m: DVec3, emitter: &Emitter, number: usize) -> Option<Origin> {
        match self.points[number] {
            EmitterPoint::Fixed { origin, .. } => Some(origin),
            EmitterPoint::OnBall(variates) => {
                emitter.point_seen_from(place_m, variates).map(|place| world.origin(&place))
            }
        }
    }

    /// Returns the illuminance at a receiver from shares of visibility, Σ (share seen) × (unshadowed illuminance), with its disputed part
    /// and the rays used.
    ///
    /// `any` holds the bits that at least one of `members` points sees, and `all` the bits that all see. `planes[word·depth + b]` holds the
    /// binary digits, lowest first, of the number of points that see each partly seen bit. Light seen through panes by any of them depends
    /// on the angle at the pane. The receiver traces rays of its own for it.
    pub fn illuminance_lx(&self, world: &World, receiver: &Receiver, seen: &SeenSamples) -> SharedLight {
        let (mut sum_lx, mut disputed_squared, mut rays) = (0.0, 0.0, 0);
        for (emitter, group) in world.emitters.list().iter().zip(&self.groups) {
            if let Some(panes_from) = self.panes_from
                && seen.any[panes_from + group.word] & group.mask != 0
            {
                let Traced { value: lx, rays: more } = self.through_panes_lx(world, emitter, group, receiver);
                sum_lx += lx;
                // The receiver has rays of its own: the disputed part is at most the step of one sample point.
                disputed_squared += lx * lx / f64::from(group.count * group.count);
                rays += more;
                continue;
            }
            let any = seen.any[group.word] & group.mask;
            if any == 0 {
                continue;
            }
            let all = seen.all[group.word] & group.mask;
            let share = if all == group.mask {
                1.0
            } else {
                let some = seen.count_of(group.word, any & !all);
                (f64::from(all.count_ones()) + some as f64 / seen.members as f64) / f64::from(group.count)
            };
            let lx = if group.in_parts {
                self.parts_lx(emitter, group, receiver, seen)
            } else {
                emitter.unshadowed_lx(receiver.point_m, receiver.normal) * share
            };
            sum_lx += lx;
            if any != all {
                // E² p (1 − p), computed from the known E p.
                disputed_squared += lx * lx * (1.0 - share) / share;
            }
        }
        SharedLight { lx: sum_lx, disputed_lx: disputed_squared.sqrt(), rays }
    }

    /// Returns the illuminance from one emitter in lx, and the number of rays. Each of its sample points gets a ray, weighted by the
    /// transmittance of panes.
    fn through_panes_lx(
        &self,
        world: &World,
        emitter: &Emitter,
        group: &EmitterSamples,
        receiver: &Receiver,
    ) -> Traced {
        let mut sum_lx = 0.0;
        let whole_lx = if group.in_parts { 0.0 } else { emitter.unshadowed_lx(receiver.point_m, receiver.normal) };
        for number in group.first..group.first + group.count as usize {
            let Some(origin) = self.origin_of(world, receiver.point_m, emitter, number) else { continue };
            let lx = match self.points[number] {
                EmitterPoint::Fixed { point, .. } if group.in_parts => point_lx(emitter, &point, receiver),
                _ => whole_lx,
            };
            sum_lx += lx * world.transmittance(receiver.origin, &origin);
        }
        Traced { value: sum_lx / f64::from(group.count), rays: u64::from(group.count) }
    }

    /// Returns the illuminance from an opening, whose parts count as sample points of their own.
    fn parts_lx(&self, emitter: &Emitter, group: &EmitterSamples, receiver: &Receiver, seen: &SeenSamples) -> f64 {
        let mut sum_lx = 0.0;
        for number in 0..group.count {
            let bit = 1u64 << (group.shift + number);
            if seen.any[group.word] & bit == 0 {
                continue;
            }
            let share = if seen.all[group.word] & bit != 0 {
                1.0
            } else {
                seen.count_of(group.word, bit) as f64 / seen.members as f64
            };
            if let EmitterPoint::Fixed { point, .. } = self.points[group.first + number as usize] {
                sum_lx += share * point_lx(emitter, &point, receiver);
            }
        }
        sum_lx / f64::from(group.count)
    }

    /// Returns the direct illuminance in lx with a shadow ray to every sample point, each as a point source, and the number of rays. It
    /// shows the cost of soft shadows without a mesh.
    pub fn as_point_sources_lx(&self, world: &World, receiver: &Receiver) -> Traced {
        let mut sum = Traced::default();
        for (emitter, group) in world.emitters.list().iter().zip(&self.groups) {
            let mut of_emitter_lx = 0.0;
            for number in group.first..group.first + group.count as usize {
                let lx = self.source_lx(emitter, number, receiver);
                if lx > 0.0 {
                    sum.rays += 1;
                    let origin = self.origin_of(world, receiver.point_m, emitter, number);
                    of_emitter_lx += origin.map_or(0.0, |origin| lx * world.transmittance(receiver.origin, &origin));
                }
            }
            sum.value += of_emitter_lx / f64::from(group.count);
        }
        sum
    }

    /// Returns the unshadowed illuminance in lx from an emitter that is concentrated at one of its sample points.
    fn source_lx(&self, emitter: &Emitter, number: usize, receiver: &Receiver) -> f64 {
        match self.points[number] {
            EmitterPoint::OnBall(_) => emitter.unshadowed_lx(receiver.point_m, receiver.normal),
            EmitterPoint::Fixed { point, .. } => match emitter.exitance_lm_m2() {
                Some(_) => {
                    let offset_m = point.position_m - receiver.point_m;
                    let distance_m = offset_m.length();
                    let direction = offset_m / distance_m;
                    let intensity_cd = emitter.luminous_flux_lm / PI * emitter.cosine_towards(-direction);
                    intensity_cd * receiver.normal.dot(direction).max(0.0) / (distance_m * distance_m)
                }
                None => point_lx(emitter, &point, receiver),
            },
        }
    }
}

/// Returns the illuminance from a point-like emitter at this position.
fn point_lx(emitter: &Emitter, point: &OpeningPoint, receiver: &Receiver) -> f64 {
    let offset_m = point.position_m - receiver.point_m;
    let distance_m = offset_m.length();
    let direction = offset_m / distance_m;
    let cosine = receiver.normal.dot(direction).max(0.0);
    emitter.intensity_from_cd(point, -direction) * cosine / (distance_m * distance_m)
}

/// Returns stratified variates. A count that is a power of two uses Sobol's net, which spreads them along every edge as evenly as over the
/// whole square. Another square number uses its grid, any other number a sequence. A single one lies in the middle.
fn stratum(number: usize, count: usize, stream: &mut Stream) -> [f64; 2] {
    let edge = count.isqrt();
    if count > 1 && count.is_power_of_two() {
        stream.seek_quasi(number as u64, 0, number as u64);
        let variates = stream.pair();
        // The code that draws points of openings itself must start from the same coordinates.
        stream.seek_quasi(number as u64, 0, number as u64);
        return variates;
    }
    stream.seek(number as u64);
    if count == 1 {
        // The centroid of the square's image on a triangle is at (4/9, ½).
        return [4.0 / 9.0, 0.5];
    }
    let jitter = stream.pair();
    if edge * edge == count {
        let cell = [number % edge, number / edge];
        return [0, 1].map(|axis| (cell[axis] as f64 + jitter[axis]) / edge as f64);
    }
    [(number as f64 + jitter[0]) / count as f64, (number as f64 * GOLDEN + 0.5).fract()]
}

fn point_of(world: &World, emitter: &Emitter, variates: [f64; 2], stream: &mut Stream) -> EmitterPoint {
    if let Some(point) = emitter.draw_point(stream) {
        return EmitterPoint::Fixed { origin: world.origin(&emitter.place_of_point(point.position_m)), point };
    }
    match emitter.point_seen_from(DVec3::ZERO, variates).filter(|_| !emitter.is_ball()) {
        Some(place) => {
            let origin = world.origin(&place);
            EmitterPoint::Fixed {
                origin,
                point: OpeningPoint { position_m: world.tracer.position_m(&origin), face: None },
            }
        }
        None => EmitterPoint::OnBall(variates),
    }
}

/// A test of mutual visibility between two origins.
pub type Sees = fn(&Tracer, &Origin, &Origin) -> bool;

/// Tests visibility by the tree (MU1).
pub fn by_tree(tracer: &Tracer, from: &Origin, to: &Origin) -> bool {
    !tracer.is_occluded(from, to)
}

/// Tests visibility against every triangle.
pub fn one_by_one(tracer: &Tracer, from: &Origin, to: &Origin) -> bool {
    !tracer.is_occluded_one_by_one(from, to)
}

/// Binary digits for the count of a set's members.
pub const DIGITS: usize = 13;

/// Light computed from shares of visibility.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharedLight {
    /// Illuminance in lx.
    pub lx: f64,
    /// Root of the sum of E_i² p_i (1 − p_i) over the emitters on which the set disagrees, in lx; p_i is the share of the set that sees
    /// emitter i.
    pub disputed_lx: f64,
    /// Rays used.
    pub rays: u64,
}

/// Visibility of the sample points from a set of mesh points.
#[derive(Clone, Debug, Default)]
pub struct SeenSamples {
    /// Bits that at least one point sees.
    pub any: Vec<u64>,
    /// Bits that all points see.
    pub all: Vec<u64>,
    /// Digits of the counts, [`DIGITS`] per word, for words with bits that some but not all points see.
    pub planes: Vec<u64>,
    /// Number of points of the set.
    pub members: usize,
    /// Number of binary digits of `members`.
    pub digits: usize,
}

impl SeenSamples {
    /// Returns how many points see the bits of a mask, summed over the bits.
    #[inline]
    fn count_of(&self, word: usize, mask: u64) -> u64 {
        // A receiver point with shadow rays of its own has no counts.
        if mask == 0 {
            return 0;
        }
        let planes = &self.planes[word * DIGITS..word * DIGITS + self.digits];
        planes.iter().enumerate().map(|(digit, plane)| u64::from((plane & mask).count_ones()) << digit).sum()
    }

    /// Adds one point's word to the counts: a ripple of carries for all 64 bits at once.
    #[inline]
    pub fn add(&mut self, word: usize, bits: u64) {
        let mut carry = bits;
        for plane in &mut self.planes[word * DIGITS..(word + 1) * DIGITS] {
            if carry == 0 {
                return;
            }
            (*plane, carry) = (*plane ^ carry, *plane & carry);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_counted_as_numbers_are() {
        let mut stream = Stream::new(5, Purpose::Pilot, 0, 0);
        stream.seek(0);
        let mut seen =
            SeenSamples { any: vec![0; 2], all: vec![0; 2], planes: vec![0; 2 * DIGITS], members: 0, digits: DIGITS };
        let mut counts = [0u64; 64];
        for _ in 0..4000 {
            let bits = (stream.fine_unit() * (1u64 << 53) as f64) as u64;
            seen.add(1, bits);
            (0..64).for_each(|bit| counts[bit] += bits >> bit & 1);
        }
        assert!((0..64).all(|bit| seen.count_of(1, 1 << bit) == counts[bit]));
        assert_eq!(seen.count_of(1, 0xff), counts[..8].iter().sum::<u64>());
        assert!(seen.planes[..DIGITS].iter().all(|plane| *plane == 0));
    }

    #[test]
    fn a_place_with_samples_of_its_own_needs_no_counts() {
        let seen = SeenSamples { any: vec![0b11], all: vec![0b11], planes: Vec::new(), members: 1, digits: 0 };
        assert_eq!(seen.count_of(0, seen.any[0] & !seen.all[0]), 0);
    }

    #[test]
    fn strata_cover_the_square() {
        let mut stream = Stream::new(1, Purpose::Pilot, 0, 0);
        stream.seek(0);
        let mut cells = [0; 16];
        for number in 0..16 {
            let [u, v] = stratum(number, 16, &mut stream);
            cells[(v * 4.0) as usize * 4 + (u * 4.0) as usize] += 1;
        }
        assert_eq!(cells, [1; 16]);
        // The single point of a triangle is its centroid.
        let [u, v] = crate::sampling::warp::uniform_triangle(stratum(0, 1, &mut stream));
        assert!((u - 1.0 / 3.0).abs() < 1e-12 && (v - 1.0 / 3.0).abs() < 1e-12);
    }
}
