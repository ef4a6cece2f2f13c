//! Indirect light at the points of a coarse mesh: gathered over the whole sphere, kept as one number or as spherical
//! harmonics, and turned into the illuminance of surfaces near by.

use std::f64::consts::PI;
use std::sync::OnceLock;

use glam::DVec3;

use super::fit::Fit;
use super::lattice::{Index, Lattice};
use super::mesh::{NEAREST, Surroundings};
use super::options::IndirectForm;
use super::solids::Walls;
use super::sparse::{LEAF_POINTS, SparseTree};
use super::template::{Candidate, Templates};
use super::walks::{HALVES, images_at_place_lx, sample_along_lx, walks_at_place_lx};
use crate::estimators::direct::Receiver;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::sampling::warp::uniform_sphere;

/// Coefficients of spherical harmonics up to order 2.
const COEFFICIENTS: usize = 9;
/// The map number of the streams of a mesh's walks, less the level of refinement.
const GATHERING: u32 = u32::MAX - 1;
/// Walks of a mesh point for each look into mirrors from a place.
const WALKS_PER_LOOK: u32 = 32;
/// Looks into mirrors from a place in each half, at most.
const MOST_LOOKS: u32 = 64;
/// Walks from points that are asked for after the run has been ended: every place gets a value, if a rough one.
const HURRIED_WALKS: u32 = 32;

/// Coefficients of the light that arrives at a point, from each half of its walks.
type Field = [[f64; COEFFICIENTS]; HALVES];

/// Real spherical harmonics up to order 2 of a unit vector.
fn harmonics(d: DVec3) -> [f64; COEFFICIENTS] {
    let band = |l: f64| (l / PI).sqrt();
    let (linear, quadratic) = (0.5 * band(3.0), 0.5 * band(15.0));
    [
        0.5 * band(1.0),
        linear * d.y,
        linear * d.z,
        linear * d.x,
        quadratic * d.x * d.y,
        quadratic * d.y * d.z,
        0.25 * band(5.0) * (3.0 * d.z * d.z - 1.0),
        quadratic * d.z * d.x,
        0.5 * quadratic * (d.x * d.x - d.y * d.y),
    ]
}

/// What the clamped cosine leaves of each order, over π: 1, 2/3, 1/4 (Ramamoorthi and Hanrahan 2001, "An efficient
/// representation for irradiance environment maps").
const COSINE: [f64; COEFFICIENTS] = [1.0, 2.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0, 0.25, 0.25, 0.25, 0.25, 0.25];

/// Illuminance of a surface with this normal, in the unit of π times luminance that the field has.
fn illuminance(field: &[f64; COEFFICIENTS], normal: DVec3, form: IndirectForm) -> f64 {
    let y = harmonics(normal);
    match form {
        IndirectForm::Scalar => field[0] * y[0],
        IndirectForm::Directional => (0..COEFFICIENTS).map(|i| COSINE[i] * field[i] * y[i]).sum::<f64>(),
    }
}

/// Whether a limit or the user has ended the run.
pub type Stop<'a> = &'a (dyn Fn() -> bool + Sync);

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
    tree: SparseTree<[OnceLock<Option<Box<Field>>>; LEAF_POINTS]>,
    least_height_m: f64,
    seed: u64,
    stop: Stop<'a>,
}

impl<'a> IndirectMesh<'a> {
    /// An empty mesh for places within a box; `None` where it would be out of proportion.
    pub fn new(
        around: Surroundings<'a>,
        bounds_m: [DVec3; 2],
        gathering: Gathering,
        seed: u64,
        stop: Stop<'a>,
    ) -> Option<IndirectMesh<'a>> {
        let Gathering { step_m, radius_m, .. } = gathering;
        let lattice = Lattice::over(bounds_m, step_m, radius_m)?;
        Some(IndirectMesh {
            templates: Templates::new(radius_m / step_m),
            walls: Walls::of(around.solids, around.stage, around.scene, &lattice, radius_m),
            tree: SparseTree::over(&lattice)?,
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
    pub fn indirect_lx(&self, receiver: &Receiver, place_number: u64, room: &mut GatherRoom) -> [f64; HALVES] {
        let walks = self.gathering.walks;
        let gathered_lx = self.gathered_lx(receiver, room);
        let GatherRoom { cut, counts, .. } = room;
        let (lx, rays) = match gathered_lx {
            // Walks look into mirrors themselves.
            None => walks_at_place_lx(&self.around, receiver, place_number, [0, walks], self.seed, cut),
            Some(gathered_lx) => {
                let looks = walks.div_ceil(WALKS_PER_LOOK).min(MOST_LOOKS);
                let (images_lx, rays) = images_at_place_lx(&self.around, receiver, place_number, looks, self.seed, cut);
                ([0, 1].map(|half| gathered_lx[half] + images_lx[half]), rays)
            }
        };
        counts.walk_rays += rays;
        lx
    }

    /// What the set of a place says; `None` where the set is empty.
    fn gathered_lx(&self, receiver: &Receiver, room: &mut GatherRoom) -> Option<[f64; HALVES]> {
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
                let (leaf, place) = self.tree.leaf(candidate.index, || std::array::from_fn(|_| OnceLock::new()));
                let Some(field) = leaf[place].get_or_init(|| self.field_at(candidate.index, cut, counts)) else {
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
                let lx = [0, 1].map(|half| illuminance(&field[half], normal, self.gathering.form));
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
            return Some(match self.gathering.form {
                IndirectForm::Scalar => fit.mean(),
                IndirectForm::Directional => fit.at_place(),
            });
        }
    }

    /// Light that arrives at a mesh point from all sides; `None` inside of a solid.
    fn field_at(&self, index: Index, cut: &mut Cut, counts: &mut GatherCounts) -> Option<Box<Field>> {
        let position_m = self.lattice.position_m(index);
        let (inside, rays) = self.around.solids.holds(&self.around.stage.tracer, position_m);
        counts.other_rays += rays;
        if inside {
            return None;
        }
        counts.points += 1;
        let origin = self.around.stage.tracer.free_origin(position_m);
        let walks = if (self.stop)() { HURRIED_WALKS.min(self.gathering.walks) } else { self.gathering.walks };
        let mut field = Box::new([[0.0; COEFFICIENTS]; HALVES]);
        // Half the key in the replica's number, half in the index: no two points share a stream.
        let key = self.lattice.key(index);
        let mut stream = Stream::new(self.seed, Purpose::LightMesh, GATHERING, (key >> 32) as u32);
        for (half, field) in field.iter_mut().enumerate() {
            for walk in 0..u64::from(walks) / HALVES as u64 {
                let number = (walk * HALVES as u64) + half as u64;
                // Each half of each point has a sequence of its own, scrambled apart from all others.
                stream.seek_quasi((key << 32) | number, 2 * (key & 0xFFFF_FFFF) + half as u64, walk);
                let direction = uniform_sphere(stream.pair());
                let (arriving, rays) = sample_along_lx(&self.around, origin, direction, cut, &mut stream);
                counts.walk_rays += rays;
                let y = harmonics(direction);
                (0..COEFFICIENTS).for_each(|i| field[i] += arriving * y[i]);
            }
        }
        // ∫ f Y dω = 4π · mean, for each half of the walks.
        let scale = 4.0 * PI * HALVES as f64 / f64::from(walks);
        field.iter_mut().flatten().for_each(|coefficient| *coefficient *= scale);
        Some(field)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1/φ: steps of it cover a turn evenly.
    const GOLDEN: f64 = 0.618_033_988_749_894_9;

    /// ∫ Y_i Y_j dω = δ_ij over a spiral of 20,000 directions.
    #[test]
    fn harmonics_are_orthonormal() {
        const N: u32 = 20_000;
        let mut products = [[0.0; COEFFICIENTS]; COEFFICIENTS];
        for step in 0..N {
            let direction =
                uniform_sphere([(f64::from(step) + 0.5) / f64::from(N), (f64::from(step) * GOLDEN).fract()]);
            let y = harmonics(direction);
            for (row, left) in products.iter_mut().zip(y) {
                row.iter_mut().zip(y).for_each(|(sum, right)| *sum += left * right * 4.0 * PI / f64::from(N));
            }
        }
        for (i, row) in products.iter().enumerate() {
            for (j, product) in row.iter().enumerate() {
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-3, "{i} {j} {product}");
            }
        }
    }

    /// π L = 1 from above the plane z = 0 and nothing from below: a plane whose normal makes the angle θ with the z axis
    /// receives (1 + cos θ)/2 exactly, and so say the harmonics up to order 2, whose next term has order 3.
    #[test]
    fn a_half_lit_sphere_gives_its_exact_illuminance() {
        const N: u32 = 200_000;
        let mut field = [0.0; COEFFICIENTS];
        for step in 0..N {
            let direction =
                uniform_sphere([(f64::from(step) + 0.5) / f64::from(N), (f64::from(step) * GOLDEN).fract()]);
            if direction.z > 0.0 {
                let y = harmonics(direction);
                (0..COEFFICIENTS).for_each(|i| field[i] += y[i] * 4.0 * PI / f64::from(N));
            }
        }
        for cosine in [-1.0, -0.5, 0.0, 0.3, 1.0f64] {
            let normal = DVec3::new(0.6 * (1.0 - cosine * cosine).sqrt(), 0.8 * (1.0 - cosine * cosine).sqrt(), cosine);
            let exact = 0.5 * (1.0 + cosine);
            let found = illuminance(&field, normal, IndirectForm::Directional);
            assert!((found - exact).abs() < 1e-4, "{cosine}: {found} {exact}");
            // A scalar gives half to every surface, whichever way it looks.
            assert!((illuminance(&field, normal, IndirectForm::Scalar) - 0.5).abs() < 1e-4);
        }
    }
}
