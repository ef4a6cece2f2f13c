//! Indirect light at the points of a coarse mesh: gathered over the whole sphere, kept as one number or as spherical
//! harmonics, and turned into the illuminance of surfaces near by.

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

/// The map number of the streams of a mesh's walks, less the level of refinement.
const GATHERING: u32 = u32::MAX - 1;
/// Walks of a mesh point for each look into mirrors from a place.
const WALKS_PER_LOOK: u32 = 32;
/// Looks into mirrors from a place in each half, at most.
const MOST_LOOKS: u32 = 64;
/// Walks from points that are asked for after the run has been ended: every place gets a value, if a rough one.
pub(super) const HURRIED_WALKS: u32 = 32;
/// Walks from a point after which the clock is looked at.
const WALKS_BETWEEN_LOOKS: u64 = 1024;
/// The map number of the streams of walks towards the first normal, less the number of the normal.
const TOWARDS_NORMALS: u32 = u32::MAX - 16;

/// Coefficients of the light that arrives at a point, from each half of its walks.
type HalfCoefficients = [[f64; COEFFICIENTS]; HALVES];

/// What the points of a mesh keep, each for the places that ask for it.
enum Kept {
    /// All directions.
    Field { harmonics: Box<Harmonics>, tree: SparseTree<[OnceLock<Option<Box<HalfCoefficients>>>; LEAF_POINTS]> },
    /// The illuminance of planes that face a few ways, by each half: what a map's places ask for where all of them face so.
    Planes(Vec<PlaneIlluminances>),
}

/// Illuminance at the points of a mesh on planes of one normal; `None` inside of solids.
struct PlaneIlluminances {
    normal: DVec3,
    tree: SparseTree<[OnceLock<Option<[f64; HALVES]>>; LEAF_POINTS]>,
}

/// How indirect light is gathered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gathering {
    /// Distance of neighbouring points in m.
    pub step_m: f64,
    /// Radius of the sets that are averaged, in m.
    pub radius_m: f64,
    /// Walks from every point.
    pub walks: u32,
    /// What the points keep.
    pub form: IndirectForm,
}

/// Rays and points of a gathering.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GatherCounts {
    /// Mesh points gathered at.
    pub points: u64,
    /// Rays of their walks.
    pub walk_rays: u64,
    /// Rays for flags and local visibility.
    pub other_rays: u64,
    /// Places whose set was empty.
    pub places_without_set: u64,
}

impl GatherCounts {
    /// Rays of all kinds.
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

/// Room that a thread reuses.
#[derive(Default)]
pub struct GatherRoom {
    candidates: Vec<Candidate>,
    /// For choosing luminaires on walks.
    pub cut: Cut,
    /// What has been counted since it was made.
    pub counts: GatherCounts,
}

/// A mesh of points that gather indirect light when first asked for it.
pub struct IndirectMesh<'a> {
    around: Surroundings<'a>,
    /// How it gathers.
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
    /// An empty mesh for the places of a map; `None` where it would be out of proportion.
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
            walls: Walls::of(around.solids, around.stage, around.scene, &lattice, radius_m, around.give_up),
            least_height_m: around.stage.tracer.position_accuracy_m(),
            lattice,
            gathering,
            around,
            seed,
            stop,
        })
    }

    /// Indirect illuminance of a place in lx by each half of the walks: what the points of its set would bring to the
    /// place's plane (directional: their linear fit, scalar: their mean), and what the place itself finds in flat mirrors.
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
            // Walks look into mirrors themselves.
            None => walks_at_place_lx(&self.around, receiver, place_number, [0, walks], self.seed, cut),
            Some((gathered_lx, _)) => {
                let looks = walks.div_ceil(WALKS_PER_LOOK).min(MOST_LOOKS);
                let (images_lx, rays) = images_at_place_lx(&self.around, receiver, place_number, looks, self.seed, cut);
                ([0, 1].map(|half| gathered_lx[half] + images_lx[half]), rays)
            }
        };
        counts.walk_rays += rays;
        (lx, set)
    }

    /// What the set of a place says, and what it is like; `None` where the set is empty.
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
                    *leaf[place].get_or_init(|| self.plane_at(number as u32, *normal, index, cut, counts))
                })
            }
        }
    }

    /// The value at a place that fits its set best; `at_point` tells what a point would bring to the place's plane, `None`
    /// inside of solids. `None` where the set is empty.
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
        let tracer = &self.around.stage.tracer;
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
            // With one of the nearest points inside of a solid, the place may lie under it: each point is tested.
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

    /// Where a mesh point is, if it is not inside of a solid.
    fn free_position_m(&self, index: Index, counts: &mut GatherCounts) -> Option<DVec3> {
        let position_m = self.lattice.position_m(index);
        let (inside, rays) = self.around.solids.holds(&self.around.stage.tracer, position_m);
        counts.other_rays += rays;
        counts.points += u64::from(!inside);
        (!inside).then_some(position_m)
    }

    /// Walks from a mesh point: fewer after the run has been ended.
    fn walks(&self) -> u32 {
        if (self.stop)() { HURRIED_WALKS.min(self.gathering.walks) } else { self.gathering.walks }
    }

    /// Whether the walks of a half end here since the run has been ended: looked at every so many of them.
    fn ends_at(&self, done: u64) -> bool {
        done > 0 && done.is_multiple_of(WALKS_BETWEEN_LOOKS) && (self.stop)() || (self.around.give_up)()
    }

    /// Illuminance in lx on a plane through a mesh point, by each half of the walks; `None` inside of a solid.
    fn plane_at(
        &self,
        number: u32,
        normal: DVec3,
        index: Index,
        cut: &mut Cut,
        counts: &mut GatherCounts,
    ) -> Option<[f64; HALVES]> {
        let position_m = self.free_position_m(index, counts)?;
        let origin = self.around.stage.tracer.free_origin(position_m);
        let walks = self.walks();
        let key = self.lattice.key(index);
        let mut stream = Stream::new(self.seed, Purpose::LightMesh, TOWARDS_NORMALS - number, (key >> 32) as u32);
        let mut sum_lx = [0.0; HALVES];
        // Where mirrors are, places look into them by themselves.
        let looks_back = self.around.stage.near_lights.is_some() && self.around.has_no_images();
        for (half, sum_lx) in sum_lx.iter_mut().enumerate() {
            let mut done = 0;
            while done < u64::from(walks) / HALVES as u64 && !self.ends_at(done) {
                let walk = done;
                done += 1;
                let walk_number = (walk * HALVES as u64) + half as u64;
                stream.seek_quasi((key << 32) | walk_number, 2 * (key & 0xFFFF_FFFF) + half as u64, walk);
                let (lx, rays) = if looks_back {
                    let plane = Receiver { point_m: position_m, normal, origin: &origin };
                    sample_at_place_lx(&self.around, &plane, cut, &mut stream)
                } else {
                    let direction = cosine_hemisphere(normal, stream.pair());
                    sample_along_lx(&self.around, origin, direction, cut, &mut stream)
                };
                counts.walk_rays += rays;
                *sum_lx += lx;
            }
            *sum_lx /= done.max(1) as f64;
        }
        Some(sum_lx)
    }

    /// Light that arrives at a mesh point from all sides; `None` inside of a solid.
    fn field_at(
        &self,
        harmonics: &Harmonics,
        index: Index,
        cut: &mut Cut,
        counts: &mut GatherCounts,
    ) -> Option<Box<HalfCoefficients>> {
        let position_m = self.free_position_m(index, counts)?;
        let origin = self.around.stage.tracer.free_origin(position_m);
        let walks = self.walks();
        let mut field = Box::new([[0.0; COEFFICIENTS]; HALVES]);
        // Half the key in the replica's number, half in the index: no two points share a stream.
        let key = self.lattice.key(index);
        let mut stream = Stream::new(self.seed, Purpose::LightMesh, GATHERING, (key >> 32) as u32);
        for (half, field) in field.iter_mut().enumerate() {
            let mut done = 0;
            while done < u64::from(walks) / HALVES as u64 && !self.ends_at(done) {
                let walk = done;
                done += 1;
                let number = (walk * HALVES as u64) + half as u64;
                // Each half of each point has a sequence of its own, scrambled apart from all others.
                stream.seek_quasi((key << 32) | number, 2 * (key & 0xFFFF_FFFF) + half as u64, walk);
                let direction = uniform_sphere(stream.pair());
                let (arriving, rays) = sample_along_lx(&self.around, origin, direction, cut, &mut stream);
                counts.walk_rays += rays;
                let y = harmonics.of(direction);
                field.iter_mut().zip(y).for_each(|(sum, y)| *sum += arriving * y);
            }
            // ∫ f Y dω = 4π · mean, for each half of the walks.
            let scale = 4.0 * PI / done.max(1) as f64;
            field.iter_mut().for_each(|coefficient| *coefficient *= scale);
        }
        Some(field)
    }
}
