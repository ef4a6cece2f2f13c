//! Indirect light at the points of a coarse mesh. It is gathered over the whole sphere, stored as one number or as spherical harmonics, and
//! converted to the illuminance of nearby surfaces.

use std::f64::consts::PI;
use std::sync::OnceLock;

use glam::DVec3;

use super::entries::{Entries, ONE_NORMAL};
use super::fit::Fit;
use super::harmonics::{COEFFICIENTS, Harmonics};
use super::lattice::{Index, Lattice};
use super::mesh::{NEAREST, SetKind, Surroundings};
use super::options::{IndirectForm, Stop};
use super::solids::Walls;
use super::sparse::{LEAF_POINTS, SparseTree};
use super::template::{Candidate, Templates};
use super::walks::{HALVES, images_at_place_lx, sample_along_lx, sample_at_place_lx, walks_at_place_lx};
use crate::estimators::receiver::Receiver;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::sampling::warp::{cosine_hemisphere, uniform_sphere};

/// Map number of the random streams of a mesh's walks.
const GATHERING: u32 = u32::MAX - 1;
/// Walks of a mesh point for each sample of mirror images from a receiver point.
const WALKS_PER_MIRROR_SAMPLE: u32 = 32;
/// Largest number of samples of mirror images from a receiver point in each half.
const MOST_MIRROR_SAMPLES: u32 = 64;
/// Walks from mesh points that are requested after the run has been ended. Every receiver point then gets a value, even if it is rough.
pub(super) const HURRIED_WALKS: u32 = 32;
/// Number of walks from a mesh point after which the clock is checked.
const WALKS_BETWEEN_LOOKS: u64 = 1024;
/// Map number of the random streams of walks towards the first normal. The number of the normal is subtracted from it.
const TOWARDS_NORMALS: u32 = u32::MAX - 16;

/// Coefficients of the light that arrives at a mesh point, from each half of its walks.
type HalfCoefficients = [[f64; COEFFICIENTS]; HALVES];

/// Data stored at the mesh points. Each is computed when a receiver point requests it.
enum Kept {
    /// Light from all directions.
    Field { harmonics: Box<Harmonics>, tree: SparseTree<[OnceLock<Option<Box<HalfCoefficients>>>; LEAF_POINTS]> },
    /// Illuminance of planes with a few normals, from each half of the walks. It is used if all receiver points of a map have one of these
    /// normals.
    Planes(Vec<PlaneIlluminances>),
}

/// Illuminance at the mesh points on planes of one normal; `None` inside solids.
struct PlaneIlluminances {
    normal: DVec3,
    tree: SparseTree<[OnceLock<Option<[f64; HALVES]>>; LEAF_POINTS]>,
}

/// Settings for gathering indirect light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gathering {
    /// Distance between neighbouring mesh points in m.
    pub step_m: f64,
    /// Radius of the averaged sets, in m.
    pub radius_m: f64,
    /// Walks from every mesh point.
    pub walks: u32,
    /// Form in which mesh points store the light.
    pub form: IndirectForm,
}

/// Counts of rays and points for gathering.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GatherCounts {
    /// Mesh points at which light was gathered.
    pub points: u64,
    /// Rays of their walks.
    pub walk_rays: u64,
    /// Rays for inside flags and local visibility.
    pub other_rays: u64,
    /// Receiver points with an empty set.
    pub places_without_set: u64,
}

impl GatherCounts {
    /// Returns the rays of all kinds.
    pub fn rays(&self) -> u64 {
        self.walk_rays + self.other_rays
    }
}

impl std::ops::AddAssign for GatherCounts {
    fn add_assign(&mut self, other: GatherCounts) {
        self.points += other.points;
        self.walk_rays += other.walk_rays;
        self.other_rays += other.other_rays;
        self.places_without_set += other.places_without_set;
    }
}

/// Working memory that a thread reuses.
#[derive(Default)]
pub struct GatherRoom {
    candidates: Vec<Candidate>,
    /// Cut of the emitter tree, for choosing luminaires on walks.
    pub cut: Cut,
    /// Counts since it was created.
    pub counts: GatherCounts,
}

/// A mesh of points that gather indirect light when it is first requested.
pub struct IndirectMesh<'a> {
    around: Surroundings<'a>,
    /// Settings for gathering.
    pub gathering: Gathering,
    lattice: Lattice,
    templates: Templates,
    walls: Walls,
    kept: Kept,
    least_height_m: f64,
    seed: u64,
    stop: Stop<'a>,
}

impl<'a> IndirectMesh<'a> {
    /// Creates an empty mesh for the receiver points of a map; `None` if it would be too large.
    pub fn new(
        around: Surroundings<'a>,
        entries: &Entries,
        gathering: Gathering,
        seed: u64,
        stop: Stop<'a>,
    ) -> Option<IndirectMesh<'a>> {
        let Gathering { step_m, radius_m, .. } = gathering;
        let lattice = Lattice::over(entries.bounds_m, step_m, radius_m)?;
        let kept = match (&entries.normals, gathering.form) {
            (Some(normals), IndirectForm::Directional) => {
                let planes = normals
                    .iter()
                    .map(|normal| Some(PlaneIlluminances { normal: *normal, tree: SparseTree::over(&lattice)? }));
                Kept::Planes(planes.collect::<Option<Vec<PlaneIlluminances>>>()?)
            }
            _ => Kept::Field { harmonics: Box::new(Harmonics::new()), tree: SparseTree::over(&lattice)? },
        };
        Some(IndirectMesh {
            kept,
            templates: Templates::new(radius_m / step_m),
            walls: Walls::of(around.solids, around.world, around.scene, &lattice, radius_m, around.give_up),
            least_height_m: around.world.tracer.position_accuracy_m(),
            lattice,
            gathering,
            around,
            seed,
            stop,
        })
    }

    /// Returns the indirect illuminance at a receiver point in lx, from each half of the walks. It is the light of the set's points on the
    /// receiver's plane (directional: their linear fit, scalar: their mean), plus the light of flat mirrors sampled at the receiver point
    /// itself.
    pub fn indirect_lx(
        &self,
        receiver: &Receiver,
        place_number: u64,
        room: &mut GatherRoom,
    ) -> ([f64; HALVES], SetKind) {
        let walks = self.walks();
        let gathered_lx = self.gathered_lx(receiver, room);
        let GatherRoom { cut, counts, .. } = room;
        let set = gathered_lx.map_or(SetKind::Alone, |(_, set)| set);
        let (lx, rays) = match gathered_lx {
            // These walks sample mirror images themselves.
            None => walks_at_place_lx(&self.around, receiver, place_number, [0, walks], self.seed, cut),
            Some((gathered_lx, _)) => {
                let samples = walks.div_ceil(WALKS_PER_MIRROR_SAMPLE).min(MOST_MIRROR_SAMPLES);
                let (images_lx, rays) =
                    images_at_place_lx(&self.around, receiver, place_number, samples, self.seed, cut);
                ([0, 1].map(|half| gathered_lx[half] + images_lx[half]), rays)
            }
        };
        counts.walk_rays += rays;
        (lx, set)
    }

    /// Returns the light gathered from the set of a receiver point, and the kind of the set; `None` if the set is empty.
    fn gathered_lx(&self, receiver: &Receiver, room: &mut GatherRoom) -> Option<([f64; HALVES], SetKind)> {
        match &self.kept {
            Kept::Field { harmonics, tree } => {
                let of_normal = harmonics.of(receiver.normal);
                self.fitted_lx(receiver, room, |index, cut, counts| {
                    let (leaf, place) = tree.leaf(index, || std::array::from_fn(|_| OnceLock::new()));
                    let field = leaf[place].get_or_init(|| self.field_at(harmonics, index, cut, counts)).as_ref()?;
                    Some([0, 1].map(|half| harmonics.illuminance(&field[half], &of_normal, self.gathering.form)))
                })
            }
            Kept::Planes(planes) => {
                let faces = |plane: &PlaneIlluminances| 1.0 - plane.normal.dot(receiver.normal) < ONE_NORMAL;
                let number = planes.iter().position(faces)?;
                let PlaneIlluminances { normal, tree } = &planes[number];
                self.fitted_lx(receiver, room, |index, cut, counts| {
                    let (leaf, place) = tree.leaf(index, || std::array::from_fn(|_| OnceLock::new()));
                    *leaf[place].get_or_init(|| self.plane_at_lx(number as u32, *normal, index, cut, counts))
                })
            }
        }
    }

    /// Returns the value at a receiver point that fits its set best. `at_point` returns a mesh point's light on the receiver's plane, or
    /// `None` inside solids. The result is `None` if the set is empty.
    fn fitted_lx(
        &self,
        receiver: &Receiver,
        room: &mut GatherRoom,
        at_point: impl Fn(Index, &mut Cut, &mut GatherCounts) -> Option<[f64; HALVES]>,
    ) -> Option<([f64; HALVES], SetKind)> {
        let GatherRoom { candidates, cut, counts } = room;
        let (place_m, normal) = (receiver.point_m, receiver.normal);
        self.templates.candidates(&self.lattice, place_m, normal, self.least_height_m, candidates);
        let (cell, _) = self.lattice.cell_of(place_m);
        let near_squared = (NEAREST * self.gathering.step_m).powi(2);
        let tracer = &self.around.world.tracer;
        let mut tests = self.walls.may_hide(&self.lattice, cell, place_m, normal, self.least_height_m);
        loop {
            let mut fit = Fit::empty();
            let mut open = true;
            for candidate in candidates.iter().filter(|candidate| self.lattice.contains(candidate.index)) {
                let Some(lx) = at_point(candidate.index, cut, counts) else {
                    open &= candidate.offset_m.length_squared() > near_squared;
                    continue;
                };
                if tests {
                    counts.other_rays += 1;
                    let point_m = self.lattice.position_m(candidate.index);
                    if tracer.is_occluded(receiver.origin, &tracer.free_origin(point_m)) {
                        continue;
                    }
                }
                fit.add(candidate.offset_m / self.gathering.radius_m, lx);
            }
            // If one of the nearest mesh points is inside a solid, the receiver point may lie under this solid. Then each point is tested.
            if !open && !tests {
                tests = true;
                continue;
            }
            if fit.members == 0.0 {
                counts.places_without_set += 1;
                return None;
            }
            let lx = match self.gathering.form {
                IndirectForm::Scalar => fit.mean(),
                IndirectForm::Directional => fit.at_place(),
            };
            return Some((lx, if tests { SetKind::Near } else { SetKind::Open }));
        }
    }

    /// Returns the position of a mesh point in m; `None` inside a solid.
    fn free_position_m(&self, index: Index, counts: &mut GatherCounts) -> Option<DVec3> {
        let position_m = self.lattice.position_m(index);
        let (inside, rays) = self.around.solids.holds(&self.around.world.tracer, position_m);
        counts.other_rays += rays;
        counts.points += u64::from(!inside);
        (!inside).then_some(position_m)
    }

    /// Returns the walks from a mesh point: fewer after the run has been ended.
    fn walks(&self) -> u32 {
        if (self.stop)() { HURRIED_WALKS.min(self.gathering.walks) } else { self.gathering.walks }
    }

    /// Whether the walks of a half stop here because the run has been ended. It is checked every `WALKS_BETWEEN_LOOKS` walks.
    fn ends_at(&self, done: u64) -> bool {
        done > 0 && done.is_multiple_of(WALKS_BETWEEN_LOOKS) && (self.stop)() || (self.around.give_up)()
    }

    /// Returns the illuminance in lx on a plane through a mesh point, from each half of the walks; `None` inside a solid.
    fn plane_at_lx(
        &self,
        number: u32,
        normal: DVec3,
        index: Index,
        cut: &mut Cut,
        counts: &mut GatherCounts,
    ) -> Option<[f64; HALVES]> {
        let position_m = self.free_position_m(index, counts)?;
        let origin = self.around.world.tracer.free_origin(position_m);
        let walks = self.walks();
        let key = self.lattice.key(index);
        let mut stream = Stream::new(self.seed, Purpose::LightMesh, TOWARDS_NORMALS - number, (key >> 32) as u32);
        let mut sum_lx = [0.0; HALVES];
        // Where there are mirrors, the receiver points sample them themselves.
        let connects_to_packets = self.around.world.near_luminaires.is_some() && self.around.has_no_images();
        for (half, sum_lx) in sum_lx.iter_mut().enumerate() {
            let mut done = 0;
            while done < u64::from(walks) / HALVES as u64 && !self.ends_at(done) {
                let walk = done;
                done += 1;
                let walk_number = (walk * HALVES as u64) + half as u64;
                stream.seek_quasi((key << 32) | walk_number, 2 * (key & 0xFFFF_FFFF) + half as u64, walk);
                let sampled = if connects_to_packets {
                    let plane = Receiver { point_m: position_m, normal, origin: &origin };
                    sample_at_place_lx(&self.around, &plane, cut, &mut stream)
                } else {
                    let direction = cosine_hemisphere(normal, stream.pair());
                    sample_along_lx(&self.around, origin, direction, cut, &mut stream)
                };
                counts.walk_rays += sampled.rays;
                *sum_lx += sampled.value;
            }
            *sum_lx /= done.max(1) as f64;
        }
        Some(sum_lx)
    }

    /// Returns the light that arrives at a mesh point from all sides; `None` inside a solid.
    fn field_at(
        &self,
        harmonics: &Harmonics,
        index: Index,
        cut: &mut Cut,
        counts: &mut GatherCounts,
    ) -> Option<Box<HalfCoefficients>> {
        let position_m = self.free_position_m(index, counts)?;
        let origin = self.around.world.tracer.free_origin(position_m);
        let walks = self.walks();
        let mut field = Box::new([[0.0; COEFFICIENTS]; HALVES]);
        // Half of the key is in the replica's number, half in the index: no two mesh points share a stream.
        let key = self.lattice.key(index);
        let mut stream = Stream::new(self.seed, Purpose::LightMesh, GATHERING, (key >> 32) as u32);
        for (half, field) in field.iter_mut().enumerate() {
            let mut done = 0;
            while done < u64::from(walks) / HALVES as u64 && !self.ends_at(done) {
                let walk = done;
                done += 1;
                let number = (walk * HALVES as u64) + half as u64;
                // Each half of each mesh point has its own sequence, scrambled independently of all others.
                stream.seek_quasi((key << 32) | number, 2 * (key & 0xFFFF_FFFF) + half as u64, walk);
                let direction = uniform_sphere(stream.pair());
                let arriving = sample_along_lx(&self.around, origin, direction, cut, &mut stream);
                counts.walk_rays += arriving.rays;
                let y = harmonics.of(direction);
                field.iter_mut().zip(y).for_each(|(sum, y)| *sum += arriving.value * y);
            }
            // ∫ f Y dω = 4π · mean, for each half of the walks.
            let scale = 4.0 * PI / done.max(1) as f64;
            field.iter_mut().for_each(|coefficient| *coefficient *= scale);
        }
        Some(field)
    }
}
