//! Containment: points in solids, luminaires in rooms. Shells are found by their boxes, and every search counts its steps.

use glam::DVec3;
use rayon::prelude::*;

use super::box_tree::{Box3, BoxTree, Budget};
use super::shells::{Shell, reflects_on_both_sides, shells_of_scene, size_m};
use crate::scene::{Emission, Scene};

/// A point this near to a shell, as a fraction of the scene's size, lies on it and not inside. This is far above the rounding of
/// coordinates and far below the details of a drawing.
pub(super) const ON_SURFACE: f64 = 1e-9;
/// Distance in front of a surface at which its light is assumed to begin, as a fraction of the scene's size.
const IN_FRONT: f64 = 1e-6;
/// Steps of a search over all points, and additional steps per point: a few seconds' work. A point in a room among furniture takes about
/// ten, because a result for a box that no surface cuts holds for all points in it.
const STEPS: u64 = 100_000_000;
const STEPS_A_POINT: u64 = 20;
/// Number of parts of a list of points that are processed in parallel, and the largest number of points in a part.
const PARTS_AT_A_TIME: usize = 64;
const PART: usize = 8192;

/// Closed shells with a tree of their boxes, the smallest volumes first.
struct ByPlace<'s> {
    shells: Vec<&'s Shell>,
    boxes: BoxTree,
}

impl<'s> ByPlace<'s> {
    fn of(shells: impl Iterator<Item = &'s Shell>) -> ByPlace<'s> {
        let mut shells: Vec<&Shell> = shells.collect();
        // Of two shells with the same volume, the one that faces inward comes first.
        shells.sort_by(|one, other| {
            let volumes = one.volume_m3.abs().total_cmp(&other.volume_m3.abs());
            volumes.then(one.volume_m3.total_cmp(&other.volume_m3))
        });
        let boxes = BoxTree::of(shells.iter().map(|shell| shell.bounds_m()));
        ByPlace { shells, boxes }
    }

    /// Returns the shells whose boxes contain a point, smallest first.
    fn about(&self, point_m: DVec3, budget: &mut Budget) -> Vec<&'s Shell> {
        self.meeting([point_m; 2], budget)
    }

    /// Returns the shells whose boxes meet a box, smallest first.
    fn meeting(&self, box_m: Box3, budget: &mut Budget) -> Vec<&'s Shell> {
        let mut numbers: Vec<u32> = Vec::new();
        self.boxes.meeting(box_m, budget, |number| numbers.push(number));
        numbers.sort_unstable();
        numbers.into_iter().map(|number| self.shells[number as usize]).collect()
    }
}

/// The closed solids and rooms of a scene, prepared for the question which points lie inside of solids.
pub(super) struct SolidLookup<'s> {
    by_place: ByPlace<'s>,
    tolerance_m: f64,
}

impl<'s> SolidLookup<'s> {
    /// `shells` must be closed.
    pub fn of(shells: &'s [Shell], scene_size_m: f64) -> SolidLookup<'s> {
        SolidLookup { by_place: ByPlace::of(shells.iter()), tolerance_m: ON_SURFACE * scene_size_m }
    }

    /// Returns for each point whether it lies inside of a closed solid, and the number of steps that this took. If the budget ends, as with
    /// very many points on the surfaces of very many shells, the result covers only the first points.
    ///
    /// A point lies inside if the smallest closed shell around it faces outward. A point in a room is therefore not inside, even if a
    /// larger solid stands around the room. A point in a table is.
    pub fn holding(&self, points_m: &[DVec3]) -> (Vec<bool>, u64) {
        let given = STEPS + STEPS_A_POINT * points_m.len() as u64;
        let mut left = given;
        let mut inside: Vec<bool> = Vec::with_capacity(points_m.len());
        let part = points_m.len().div_ceil(PARTS_AT_A_TIME).clamp(1, PART);
        for parts in points_m.chunks(part * PARTS_AT_A_TIME) {
            let parts: Vec<&[DVec3]> = parts.chunks(part).collect();
            let share = left / (2 * parts.len() as u64);
            let parts_held: Vec<(Vec<bool>, Budget)> = parts.par_iter().map(|part| self.hold(part, share)).collect();
            left -= parts_held.iter().map(|(_, budget)| budget.taken()).sum::<u64>();
            for ((mut held, mut budget), part) in parts_held.into_iter().zip(parts) {
                // A part whose share of the steps was too small gets all that are left.
                if budget.is_spent() {
                    (held, budget) = self.hold(part, left);
                    left -= budget.taken();
                }
                if budget.is_spent() {
                    return (inside, given - left);
                }
                inside.extend(held);
            }
        }
        (inside, given - left)
    }

    /// Tests one part of the points. The answers are valid only if the budget was not spent.
    fn hold(&self, points_m: &[DVec3], steps: u64) -> (Vec<bool>, Budget) {
        let mut budget = Budget::of_steps(steps);
        let mut places: Vec<(DVec3, usize)> = points_m.iter().copied().zip(0..).collect();
        let mut inside = vec![false; places.len()];
        let shells = self.by_place.meeting(bounds_of(&places), &mut budget);
        self.hold_among(&shells, false, &mut places, &mut inside, &mut budget);
        (inside, budget)
    }

    /// Marks which of some numbered points lie inside. It halves the set of points as long as a shell may separate two of them. `shells`
    /// may lie around the points, smallest first. If none does, the answer is `else_inside`.
    fn hold_among(
        &self,
        shells: &[&Shell],
        else_inside: bool,
        places: &mut [(DVec3, usize)],
        inside: &mut [bool],
        budget: &mut Budget,
    ) {
        let box_m @ [low_m, high_m] = bounds_of(places);
        let is_one_place = low_m == high_m;
        let mut else_inside = else_inside;
        let mut cutting: Vec<&Shell> = Vec::new();
        for shell in shells {
            if !budget.take(1) {
                return;
            }
            if !is_one_place && shell.may_cut(box_m, self.tolerance_m, budget) {
                cutting.push(shell);
                continue;
            }
            let is_around = match is_one_place {
                true => shell.encloses(low_m, self.tolerance_m, budget),
                false => shell.winding_within(low_m.midpoint(high_m), budget).abs() > 0.5,
            };
            // A shell around all of the points hides the larger ones.
            if is_around {
                else_inside = shell.volume_m3 > 0.0;
                break;
            }
        }
        if cutting.is_empty() {
            places.iter().for_each(|(_, number)| inside[*number] = else_inside);
            return;
        }
        let axis = (high_m - low_m).max_position();
        let half = places.len() / 2;
        places.select_nth_unstable_by(half, |one, other| one.0[axis].total_cmp(&other.0[axis]));
        let (first, second) = places.split_at_mut(half);
        self.hold_among(&cutting, else_inside, first, inside, budget);
        self.hold_among(&cutting, else_inside, second, inside, budget);
    }
}

/// Returns the bounding box of some points.
fn bounds_of(places: &[(DVec3, usize)]) -> Box3 {
    let low_m = places.iter().fold(DVec3::INFINITY, |low_m, (place_m, _)| low_m.min(*place_m));
    [low_m, places.iter().fold(DVec3::NEG_INFINITY, |high_m, (place_m, _)| high_m.max(*place_m))]
}

/// The closed shells of a scene that let no light out, determined once for all its luminaires.
pub(super) struct Enclosures<'s> {
    scene: &'s Scene,
    step_m: f64,
    /// Closed shells through which no light passes.
    by_place: ByPlace<'s>,
}

impl<'s> Enclosures<'s> {
    /// Selects them among the shells of a scene.
    pub fn of(scene: &'s Scene, shells: &'s [Shell]) -> Enclosures<'s> {
        let tight = shells.iter().filter(|shell| shell.closed && !lets_light_through(scene, shell));
        Enclosures { scene, step_m: IN_FRONT * size_m(scene), by_place: ByPlace::of(tight) }
    }

    /// Whether no light of any luminaire can leave the scene, because a closed shell that reflects on its inside lies around each. If this
    /// takes too many steps, the answer is that light can leave.
    pub fn shut_in_all(&self) -> bool {
        let luminaires = &self.scene.luminaires;
        let mut budget = Budget::of_steps(STEPS + STEPS_A_POINT * luminaires.len() as u64);
        // The answer at a point holds for all points nearer than the nearest shell. Rows of luminaires therefore need only a few tests.
        let (mut tested_at_m, mut clear_m) = (DVec3::ZERO, 0.0);
        let starts = luminaires.iter().flat_map(|luminaire| self.starts_m(&luminaire.emission));
        for start_m in starts {
            if start_m.distance(tested_at_m) >= clear_m {
                if !self.is_shut_in(start_m, &mut budget) {
                    return false;
                }
                let shells = self.by_place.shells.iter();
                clear_m = shells.map(|shell| shell.clear_m(start_m, &mut budget)).fold(f64::INFINITY, f64::min);
                tested_at_m = start_m;
            }
        }
        true
    }

    fn is_shut_in(&self, start_m: DVec3, budget: &mut Budget) -> bool {
        let mut about = self.by_place.about(start_m, budget).into_iter();
        let is_shut = about.any(|shell| {
            let winding = shell.winding_within(start_m, budget);
            winding < -0.5 || winding > 0.5 && reflects_on_both_sides(self.scene, shell)
        });
        is_shut && !budget.is_spent()
    }

    /// Returns the smallest closed shell around a point that lets no light out.
    pub fn smallest_around(&self, point_m: DVec3, budget: &mut Budget) -> Option<&'s Shell> {
        let about = self.by_place.about(point_m, budget);
        about.into_iter().find(|shell| shell.winding_within(point_m, budget).abs() > 0.5)
    }

    /// Returns how far in front of a surface a point is placed, in m.
    pub fn step_m(&self) -> f64 {
        self.step_m
    }

    /// Returns the points where a luminaire's light begins, one step in front of the emitting parts.
    pub fn starts_m(&self, emission: &Emission) -> Vec<DVec3> {
        let (scene, step_m) = (self.scene, self.step_m);
        if let Some(place_m) = emission.place_m() {
            return vec![emission.aim().map_or(place_m, |aim| place_m + step_m * aim)];
        }
        if let Some(openings) = emission.openings() {
            // Far away, in no room.
            return vec![openings.outside_m()];
        }
        let Emission::Area { surfaces, front, back, .. } = emission else { return Vec::new() };
        surfaces
            .iter()
            .flat_map(|id| {
                let triangle = scene.surfaces[*id as usize].triangles.start;
                let middle_m = scene.corners_m(triangle).iter().sum::<DVec3>() / 3.0;
                let step = step_m * scene.triangle_normal(triangle);
                [front.then_some(middle_m + step), back.then_some(middle_m - step)]
            })
            .flatten()
            .collect()
    }
}

/// Whether no light of any luminaire can leave the scene.
pub fn all_luminaires_are_shut_in(scene: &Scene) -> bool {
    let shells = shells_of_scene(scene);
    Enclosures::of(scene, &shells).shut_in_all()
}

/// Whether light passes through any triangle of a shell.
fn lets_light_through(scene: &Scene, shell: &Shell) -> bool {
    shell.triangles.iter().any(|triangle| {
        let material = scene.surface_of(*triangle).material;
        scene.materials[material as usize].bsdf.lets_through()
    })
}
