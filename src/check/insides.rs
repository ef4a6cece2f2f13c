//! What lies inside of what: points in solids, luminaires in rooms. Shells are looked up by their boxes, and every search counts
//! its steps.

use glam::DVec3;
use rayon::prelude::*;

use super::box_tree::{BoxTree, Budget};
use super::shells::{Shell, reflects_on_both_sides, shells_of_scene, size_m};
use crate::scene::{Emission, Scene};

/// A point this near to a shell, as a fraction of the scene's size, lies on it and not inside: far above the rounding
/// of coordinates, far below what a drawing means.
const ON_SURFACE: f64 = 1e-9;
/// How far in front of a surface its light is taken to begin, as a fraction of the scene's size.
const IN_FRONT: f64 = 1e-6;
/// Steps of a search over all points, and what each point adds: some seconds' work. A point in a room among furniture takes
/// some fifty.
const STEPS: u64 = 100_000_000;
const STEPS_A_POINT: u64 = 200;
/// Points that are looked at side by side; none may take more than a sixteenth of what is left.
const BLOCK: usize = 64;
const SHARE_OF_ONE: u64 = 16;

/// Closed shells by their boxes, the smallest volumes first.
struct ByPlace<'s> {
    shells: Vec<&'s Shell>,
    boxes: BoxTree,
}

impl<'s> ByPlace<'s> {
    fn of(shells: impl Iterator<Item = &'s Shell>) -> ByPlace<'s> {
        let mut shells: Vec<&Shell> = shells.collect();
        // Of two of one volume the one that faces inward.
        shells.sort_by(|one, other| {
            let volumes = one.volume_m3.abs().total_cmp(&other.volume_m3.abs());
            volumes.then(one.volume_m3.total_cmp(&other.volume_m3))
        });
        let boxes = BoxTree::of(shells.iter().map(|shell| shell.bounds_m()));
        ByPlace { shells, boxes }
    }

    /// The shells whose boxes a point lies in, smallest first.
    fn about(&self, point_m: DVec3, budget: &mut Budget) -> Vec<&'s Shell> {
        let mut numbers: Vec<u32> = Vec::new();
        self.boxes.around(point_m, 0.0, budget, |number| numbers.push(number));
        numbers.sort_unstable();
        numbers.into_iter().map(|number| self.shells[number as usize]).collect()
    }
}

/// The closed solids and rooms of a scene, asked for what lies inside of solids.
pub(super) struct Solids<'s> {
    by_place: ByPlace<'s>,
    tolerance_m: f64,
}

impl<'s> Solids<'s> {
    /// `shells` are closed ones.
    pub fn of(shells: &'s [Shell], scene_size_m: f64) -> Solids<'s> {
        Solids { by_place: ByPlace::of(shells.iter()), tolerance_m: ON_SURFACE * scene_size_m }
    }

    /// Whether a point lies inside of a closed solid: the smallest closed shell around it faces outward.
    ///
    /// So a point in a room is not inside, even where a larger solid stands around the room; one in a table is.
    fn hold(&self, point_m: DVec3, budget: &mut Budget) -> bool {
        let around = self.by_place.about(point_m, budget);
        let smallest = around.into_iter().find(|shell| shell.encloses(point_m, self.tolerance_m, budget));
        !budget.is_spent() && smallest.is_some_and(|shell| shell.volume_m3 > 0.0)
    }

    /// Which of some points lie inside, as far as it was looked: of a great many points among a great many shells, that is
    /// the first ones. And the steps that this took.
    pub fn holding(&self, points_m: &[DVec3]) -> (Vec<bool>, u64) {
        let given = STEPS + STEPS_A_POINT * points_m.len() as u64;
        let (mut steps, mut taken) = (given, 0);
        let mut inside: Vec<bool> = Vec::with_capacity(points_m.len());
        for block in points_m.chunks(BLOCK) {
            let most = steps / SHARE_OF_ONE;
            let looks: Vec<(bool, Budget)> = block
                .par_iter()
                .map(|point_m| {
                    let mut budget = Budget::of_steps(most);
                    (self.hold(*point_m, &mut budget), budget)
                })
                .collect();
            taken += looks.iter().map(|(_, budget)| budget.taken()).sum::<u64>();
            for (is_inside, budget) in looks {
                if budget.is_spent() {
                    return (inside, taken);
                }
                inside.push(is_inside);
                steps = steps.saturating_sub(budget.taken());
            }
        }
        (inside, taken)
    }
}

/// The closed shells of a scene that let no light out, looked for once for all its luminaires.
pub(super) struct Enclosures<'s> {
    scene: &'s Scene,
    step_m: f64,
    /// Closed shells through which no light passes.
    by_place: ByPlace<'s>,
}

impl<'s> Enclosures<'s> {
    /// Those among the shells of a scene.
    pub fn of(scene: &'s Scene, shells: &'s [Shell]) -> Enclosures<'s> {
        let tight = shells.iter().filter(|shell| shell.closed && !lets_light_through(scene, shell));
        Enclosures { scene, step_m: IN_FRONT * size_m(scene), by_place: ByPlace::of(tight) }
    }

    /// Whether no light of any luminaire can get out of the scene: a closed shell whose inside reflects lies around each.
    /// Where that takes too many steps to tell, light is taken to get out.
    pub fn shut_in_all(&self) -> bool {
        let luminaires = &self.scene.luminaires;
        let mut budget = Budget::of_steps(STEPS + STEPS_A_POINT * luminaires.len() as u64);
        // What holds at a place holds as far about it as no shell lies: rows of luminaires are told by a few places.
        let (mut told_at_m, mut clear_m) = (DVec3::ZERO, 0.0);
        let starts = luminaires.iter().flat_map(|luminaire| self.starts_m(&luminaire.emission));
        for start_m in starts {
            if start_m.distance(told_at_m) >= clear_m {
                if !self.is_shut_in(start_m, &mut budget) {
                    return false;
                }
                let shells = self.by_place.shells.iter();
                clear_m = shells.map(|shell| shell.clear_m(start_m, &mut budget)).fold(f64::INFINITY, f64::min);
                told_at_m = start_m;
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

    /// The smallest closed shell around a point that lets no light out: its rank by volume, and itself.
    pub fn smallest_around(&self, point_m: DVec3, budget: &mut Budget) -> Option<&'s Shell> {
        let about = self.by_place.about(point_m, budget);
        about.into_iter().find(|shell| shell.winding_within(point_m, budget).abs() > 0.5)
    }

    /// How far in front of a surface a place is taken to lie, in m.
    pub fn step_m(&self) -> f64 {
        self.step_m
    }

    /// Where a luminaire's light begins, a step in front of what emits it.
    pub fn starts_m(&self, emission: &Emission) -> Vec<DVec3> {
        let (scene, step_m) = (self.scene, self.step_m);
        if let Some(place_m) = emission.place_m() {
            return vec![emission.aim().map_or(place_m, |aim| place_m + step_m * aim)];
        }
        if let Some(openings) = emission.openings() {
            // Far off, in no room.
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

/// Whether no light of any luminaire can get out of the scene.
pub fn all_luminaires_are_shut_in(scene: &Scene) -> bool {
    let shells = shells_of_scene(scene);
    Enclosures::of(scene, &shells).shut_in_all()
}

/// Whether light passes any triangle of a shell.
fn lets_light_through(scene: &Scene, shell: &Shell) -> bool {
    shell.triangles.iter().any(|triangle| {
        let material = scene.surface_of(*triangle).material;
        scene.materials[material as usize].law.lets_through()
    })
}
