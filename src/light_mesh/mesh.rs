//! The light mesh: its points store which luminaires they see. It gives the direct light of receiver points among them.

use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};

use glam::DVec3;

use super::lattice::{Index, Lattice};
use super::options::{Accelerations, Options, Stop};
use super::samples::{DIGITS, Samples, SeenSamples, Sees, by_tree, one_by_one};
use super::solids::{Solids, Walls};
use super::sparse::{LEAF_POINTS, SparseTree};
use super::template::{Candidate, Templates, candidates_one_by_one, is_outer};
use crate::estimators::receiver::Receiver;
use crate::scene::Scene;
use crate::transport::World;

/// State of a mesh point that is not requested yet.
const EMPTY: u8 = 0;
/// State of a mesh point that a thread is computing.
const BUSY: u8 = 1;
/// State of a mesh point in free space.
const FREE: u8 = 2;
/// State of a mesh point inside a solid.
const INSIDE: u8 = 3;

/// Distance in steps within which mesh points are a receiver point's nearest. A mesh point straight above any receiver point is among them.
pub const NEAREST: f64 = 1.25;

/// Mesh points of a leaf: the state of each, and its words.
struct BitLeaf {
    states: [AtomicU8; LEAF_POINTS],
    words: Box<[AtomicU64]>,
}

impl BitLeaf {
    fn new(words: usize) -> BitLeaf {
        BitLeaf {
            states: std::array::from_fn(|_| AtomicU8::new(EMPTY)),
            words: std::iter::repeat_with(AtomicU64::default).take(LEAF_POINTS * words).collect(),
        }
    }
}

/// Counts of rays and points by purpose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Receiver points whose light was requested.
    pub places: u64,
    /// Mesh points whose visibility was computed.
    pub points: u64,
    /// Mesh points that lie inside of solids.
    pub points_inside: u64,
    /// Members of all sets together.
    pub members: u64,
    /// Rays from mesh points to luminaires.
    pub visibility_rays: u64,
    /// Rays that test whether a mesh point lies inside a solid.
    pub parity_rays: u64,
    /// Rays from receiver points to mesh points.
    pub local_rays: u64,
    /// Receiver points with an empty set.
    pub places_without_set: u64,
    /// Shadow rays from receiver points with an empty set.
    pub fallback_rays: u64,
    /// Rays from receiver points to luminaires that their sets see through panes.
    pub pane_rays: u64,
}

impl Counts {
    /// Returns the rays of all kinds.
    pub fn rays(&self) -> u64 {
        self.visibility_rays + self.parity_rays + self.local_rays + self.fallback_rays + self.pane_rays
    }
}

impl std::ops::AddAssign for Counts {
    fn add_assign(&mut self, other: Counts) {
        self.places += other.places;
        self.points += other.points;
        self.points_inside += other.points_inside;
        self.members += other.members;
        self.visibility_rays += other.visibility_rays;
        self.parity_rays += other.parity_rays;
        self.local_rays += other.local_rays;
        self.places_without_set += other.places_without_set;
        self.fallback_rays += other.fallback_rays;
        self.pane_rays += other.pane_rays;
    }
}

/// Working memory that a thread reuses for all its receiver points.
#[derive(Default)]
pub struct Workroom {
    candidates: Vec<Candidate>,
    members: Vec<u64>,
    words: Vec<u64>,
    seen: SeenSamples,
    /// Counts since it was created.
    pub counts: Counts,
}

/// Kind of the set of mesh points of a receiver point, from the most certain kind to the least.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum SetKind {
    /// All free mesh points of the half ball.
    #[default]
    Open,
    /// The set is empty: the receiver point uses shadow rays of its own.
    Alone,
    /// A solid or a thin wall is near. Some points of the half ball are left out, or may be, and shadows may begin at its foot.
    Near,
}

/// Direct light of a receiver point from the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshLight {
    /// Illuminance in lx.
    pub illuminance_lx: f64,
    /// Kind of the set.
    pub set: SetKind,
    /// Root of the sum of E_i² p_i (1 − p_i) over the luminaires, in lx, where p_i is the share of the set that sees luminaire i. It is 0
    /// where all members agree.
    pub disputed_lx: f64,
}

/// Scene data around a mesh, shared by meshes of different steps.
#[derive(Clone, Copy)]
pub struct Surroundings<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The scene prepared for ray tracing.
    pub world: &'a World,
    /// Its closed solids.
    pub solids: &'a Solids,
    /// Sample points of its luminaires.
    pub samples: &'a Samples,
    /// Whether a limit or the user ended the run so long ago that the remaining work is abandoned.
    pub give_up: Stop<'a>,
}

impl Surroundings<'_> {
    /// Whether no flat mirror shows an image of a luminaire for light samples.
    pub fn has_no_images(&self) -> bool {
        self.world.mirrors.is_none()
    }

    /// Whether walks sample images of ball and area luminaires. They then leave out these luminaires where they meet them by way of any
    /// mirror.
    pub fn samples_area_images(&self) -> bool {
        self.world.mirrors.as_ref().is_some_and(|mirrors| mirrors.are_all && !mirrors.areas.is_empty())
    }
}

/// A mesh of points over a scene. Each point is computed when it is first requested.
pub struct LightMesh<'a> {
    around: Surroundings<'a>,
    /// Options with which it was made.
    pub options: Options,
    /// Positions of its points.
    pub lattice: Lattice,
    templates: Option<Templates>,
    walls: Option<Walls>,
    tree: SparseTree<BitLeaf>,
    sees: Sees,
    least_height_m: f64,
}

impl<'a> LightMesh<'a> {
    /// Creates an empty mesh for receiver points within a box; `None` if it would have more points than can be numbered.
    pub fn new(around: Surroundings<'a>, bounds_m: [DVec3; 2], options: Options) -> Option<LightMesh<'a>> {
        let Options { step_m, radius_m, accelerations } = options;
        let lattice = Lattice::over(bounds_m, step_m, radius_m)?;
        let Accelerations { tree, templates, inside_flags, .. } = accelerations;
        Some(LightMesh {
            options,
            templates: templates.then(|| Templates::new(radius_m / step_m)),
            walls: inside_flags
                .then(|| Walls::of(around.solids, around.world, around.scene, &lattice, radius_m, around.give_up)),
            tree: SparseTree::over(&lattice)?,
            lattice,
            sees: if tree { by_tree } else { one_by_one },
            // Below this height, rounding may put a mesh point under the surface of the receiver point.
            least_height_m: around.world.tracer.position_accuracy_m(),
            around,
        })
    }

    /// Returns the memory of the mesh in bytes.
    pub fn bytes(&self) -> u64 {
        self.tree.bytes((LEAF_POINTS * self.around.samples.words * size_of::<u64>()) as u64)
    }

    /// Returns the memory in bytes of the mesh with every point stored: its words and its state.
    pub fn dense_bytes(&self) -> f64 {
        self.lattice.points() * (self.around.samples.words * size_of::<u64>() + size_of::<u8>()) as f64
    }

    /// Returns the direct illuminance at a receiver point: E = Σ_i (share of the set's points that see luminaire i) · E_i.
    ///
    /// Source: Debelov and Novikov (2009), eq. 6; docs/methods.md (18).
    pub fn direct(&self, receiver: &Receiver, room: &mut Workroom) -> MeshLight {
        room.counts.places += 1;
        let Samples { words, .. } = *self.around.samples;
        if words == 0 {
            return MeshLight { illuminance_lx: 0.0, set: SetKind::Open, disputed_lx: 0.0 };
        }
        let set = self.gather(receiver, room);
        let Workroom { members, words: visible, seen, counts, .. } = room;
        if members.is_empty() {
            visible.resize(words, 0);
            counts.places_without_set += 1;
            if self.lies_under_solid(receiver, counts) {
                return MeshLight { illuminance_lx: 0.0, set: SetKind::Alone, disputed_lx: 0.0 };
            }
            counts.fallback_rays += self.around.samples.test_visibility(
                self.around.world,
                self.sees,
                receiver.origin,
                receiver.point_m,
                visible,
            );
            seen.any.clone_from(visible);
            seen.all.clone_from(visible);
            seen.members = 1;
            let light = self.around.samples.illuminance_lx(self.around.world, receiver, seen);
            counts.fallback_rays += light.rays;
            return MeshLight { illuminance_lx: light.lx, set: SetKind::Alone, disputed_lx: 0.0 };
        }
        let count = members.len() / words;
        counts.members += count as u64;
        seen.members = count;
        seen.digits = (usize::BITS - count.leading_zeros()) as usize;
        seen.all.clear();
        seen.all.extend_from_slice(&members[..words]);
        seen.any.clear();
        seen.any.extend_from_slice(&members[..words]);
        for member in members.chunks_exact(words).skip(1) {
            for (word, bits) in member.iter().enumerate() {
                seen.all[word] &= bits;
                seen.any[word] |= bits;
            }
        }
        // Only bits on which the points disagree must be counted.
        seen.planes.resize(words * DIGITS, 0);
        for word in 0..words {
            let some = seen.any[word] & !seen.all[word];
            if some != 0 {
                seen.planes[word * DIGITS..word * DIGITS + seen.digits].fill(0);
                for member in 0..count {
                    seen.add(word, members[member * words + word] & some);
                }
            }
        }
        let light = self.around.samples.illuminance_lx(self.around.world, receiver, seen);
        counts.pane_rays += light.rays;
        MeshLight { illuminance_lx: light.lx, set, disputed_lx: light.disputed_lx }
    }

    /// Whether a solid is in contact with a receiver point, so that no light reaches it. The parity test just above the point then gives
    /// "inside".
    fn lies_under_solid(&self, receiver: &Receiver, counts: &mut Counts) -> bool {
        if !self.options.accelerations.inside_flags {
            return false;
        }
        // Twice the height that rounding may take. Rays test gaps wider than that.
        let over_m = receiver.point_m + 2.0 * self.least_height_m * receiver.normal;
        let (inside, rays) = self.around.solids.holds(&self.around.world.tracer, over_m);
        counts.parity_rays += rays;
        inside
    }

    /// Returns the mesh points of the set D of a receiver point, without their values. It is for tests and for measuring the cost.
    pub fn set_of(&self, receiver: &Receiver, room: &mut Workroom) -> Vec<Index> {
        self.gather(receiver, room);
        room.candidates.retain(|candidate| self.is_free(candidate.index, &mut room.words, &mut room.counts));
        room.candidates.iter().map(|candidate| candidate.index).collect()
    }

    fn list_candidates(&self, receiver: &Receiver, room: &mut Workroom) {
        let (place_m, normal) = (receiver.point_m, receiver.normal);
        let found = &mut room.candidates;
        match &self.templates {
            Some(templates) => templates.candidates(&self.lattice, place_m, normal, self.least_height_m, found),
            None => {
                let radius_m = self.options.radius_m;
                candidates_one_by_one(&self.lattice, radius_m, place_m, normal, self.least_height_m, found);
            }
        }
        found.retain(|candidate| self.lattice.contains(candidate.index));
    }

    /// Whether a thin wall near a receiver point may hide points of its set.
    fn has_walls_near(&self, receiver: &Receiver) -> bool {
        self.walls.as_ref().is_none_or(|walls| {
            let (cell, _) = self.lattice.cell_of(receiver.point_m);
            walls.may_hide(&self.lattice, cell, receiver.point_m, receiver.normal, self.least_height_m)
        })
    }

    /// Keeps only the candidates that the receiver point sees, tested by rays of its own.
    fn test_each(&self, receiver: &Receiver, room: &mut Workroom) {
        let Workroom { candidates, counts, words, .. } = room;
        if self.walls.is_some() {
            candidates.retain(|candidate| self.is_free(candidate.index, words, counts));
        }
        let Options { step_m, radius_m, accelerations } = self.options;
        let mut sees = |candidate: &Candidate| {
            counts.local_rays += 1;
            let tracer = &self.around.world.tracer;
            (self.sees)(tracer, receiver.origin, &tracer.free_origin(self.lattice.position_m(candidate.index)))
        };
        if !accelerations.outer_first {
            candidates.retain(|candidate| sees(candidate));
            return;
        }
        let outer = |candidate: &Candidate| is_outer(candidate.offset_m, step_m, radius_m);
        let listed = candidates.iter().filter(|candidate| outer(candidate)).count();
        candidates.retain(|candidate| !outer(candidate) || sees(candidate));
        let left = candidates.iter().filter(|candidate| outer(candidate)).count();
        if left < listed {
            candidates.retain(|candidate| outer(candidate) || sees(candidate));
        }
    }

    /// Fills `members` with the words of all points of a receiver point's set.
    ///
    /// With inside flags, points inside solids are left out. If no thin wall is near and none of the nearest points is inside a solid, no
    /// further test is needed. If one is inside, the receiver point may lie under a solid or in a crack beside it.
    fn gather(&self, receiver: &Receiver, room: &mut Workroom) -> SetKind {
        self.list_candidates(receiver, room);
        if !self.has_walls_near(receiver) && self.take_all(room) {
            return SetKind::Open;
        }
        self.test_each(receiver, room);
        self.take_all(room);
        SetKind::Near
    }

    /// Collects the words of all free candidates. Returns whether none of the nearest is inside a solid.
    fn take_all(&self, room: &mut Workroom) -> bool {
        let Workroom { candidates, members, words, counts, .. } = room;
        members.clear();
        let count = self.around.samples.words;
        let near_squared = (NEAREST * self.options.step_m).powi(2);
        let mut open = true;
        for candidate in candidates.iter() {
            let (leaf, place) = self.tree.leaf(candidate.index, || BitLeaf::new(count));
            if self.ensure(leaf, place, candidate.index, words, counts) == FREE {
                let first = place * count;
                members.extend(leaf.words[first..first + count].iter().map(|word| word.load(Ordering::Relaxed)));
            } else {
                open &= candidate.offset_m.length_squared() > near_squared;
            }
        }
        open
    }

    fn is_free(&self, index: Index, words: &mut Vec<u64>, counts: &mut Counts) -> bool {
        let (leaf, place) = self.tree.leaf(index, || BitLeaf::new(self.around.samples.words));
        self.ensure(leaf, place, index, words, counts) == FREE
    }

    /// Computes a mesh point unless this is already done, and returns its state. Its data depend only on its position.
    #[inline]
    fn ensure(&self, leaf: &BitLeaf, place: usize, index: Index, words: &mut Vec<u64>, counts: &mut Counts) -> u8 {
        let state = leaf.states[place].load(Ordering::Acquire);
        if state >= FREE { state } else { self.compute(leaf, place, index, words, counts) }
    }

    #[cold]
    fn compute(&self, leaf: &BitLeaf, place: usize, index: Index, words: &mut Vec<u64>, counts: &mut Counts) -> u8 {
        let state = &leaf.states[place];
        while let Err(found) = state.compare_exchange(EMPTY, BUSY, Ordering::Acquire, Ordering::Acquire) {
            if found >= FREE {
                return found;
            }
            std::thread::yield_now();
        }
        let Surroundings { world, solids, samples, .. } = self.around;
        let position_m = self.lattice.position_m(index);
        counts.points += 1;
        if self.options.accelerations.inside_flags {
            let (inside, rays) = solids.holds(&world.tracer, position_m);
            counts.parity_rays += rays;
            if inside {
                counts.points_inside += 1;
                state.store(INSIDE, Ordering::Release);
                return INSIDE;
            }
        }
        words.resize(samples.words, 0);
        counts.visibility_rays +=
            samples.test_visibility(world, self.sees, &world.tracer.free_origin(position_m), position_m, words);
        for (word, bits) in leaf.words[place * samples.words..].iter().zip(words.iter()) {
            word.store(*bits, Ordering::Relaxed);
        }
        state.store(FREE, Ordering::Release);
        FREE
    }
}
