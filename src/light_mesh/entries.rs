//! The entries of a map, and the points at which a mesh is evaluated for each: the receiver itself, points of an element, or the surface
//! points that an eye sees.

use glam::DVec3;

use super::exact::MeshPlace;
use super::lines_of_sight::LinesOfSight;
use super::mesh::Surroundings;
use crate::maps::MapKind;
use crate::sampling::random::Stream;
use crate::scene::{Quantity, ReceiverLayout};

/// Difference, as 1 minus the cosine, below which two normals count as one.
pub(super) const ONE_NORMAL: f64 = 1e-9;

/// Points of an element at which a mesh is evaluated. Their mean is exact for quadratic variation.
const PLACES_OF_ELEMENT: [[f64; 2]; 3] = [[1.0 / 6.0, 1.0 / 6.0], [2.0 / 3.0, 1.0 / 6.0], [1.0 / 6.0, 2.0 / 3.0]];

/// Largest number of normals that counts as few: a room's six sides.
const MOST_NORMALS: usize = 6;

/// The entries of a map: points of a receiver set, directions of view, or element sides.
pub struct Entries {
    /// The map.
    pub kind: MapKind,
    /// Weight of each entry in the map's error; 0 leaves it out.
    pub weights: Vec<f64>,
    /// Area in m² that the map stands for; `None` for loose points.
    pub area_m2: Option<f64>,
    /// Bounding box of all points, in m.
    pub bounds_m: [DVec3; 2],
    /// The normals of all points, if there are few.
    pub normals: Option<Vec<DVec3>>,
    /// What the eye sees, for a luminance set.
    pub lines_of_sight: Option<LinesOfSight>,
}

impl Entries {
    /// Creates the entries of a map. Faint branches of lines of sight are thinned by roulette from the seed. The number of rays along gloss
    /// follows the target, if there is one. `may_draw` allows every sample to trace gloss anew where this takes fewer rays.
    pub fn of(around: &Surroundings, kind: MapKind, seed: u64, target_error: Option<f64>, may_draw: bool) -> Entries {
        let mut bounds_m = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let mut include = |place_m: DVec3| bounds_m = [bounds_m[0].min(place_m), bounds_m[1].max(place_m)];
        let mut lines_of_sight = None;
        let (weights, area_m2) = match kind {
            MapKind::Receivers(number) => {
                let set = &around.scene.receivers[number];
                if set.quantity == Quantity::Luminance {
                    let found = LinesOfSight::of(around, set, [seed, number as u64], target_error, may_draw);
                    found.spots().for_each(|spot| include(spot.point_m));
                    lines_of_sight = Some(found);
                } else {
                    set.points.iter().filter(|point| !point.inside).for_each(|point| include(point.position_m));
                }
                let weights = set.points.iter().map(|point| if point.inside { 0.0 } else { point.weight });
                let area_m2 = match set.layout {
                    ReceiverLayout::Grid { area_m2, .. } => Some(area_m2),
                    _ => None,
                };
                (weights.collect(), area_m2)
            }
            MapKind::Elements => {
                around.scene.vertices_m.iter().for_each(|vertex_m| include(*vertex_m));
                let elements = &around.world.elements;
                let weights: Vec<f64> = (0..elements.len() as u32)
                    .map(|index| elements.area_m2(around.scene, elements.element(index)))
                    .collect();
                let area_m2 = weights.iter().sum();
                (weights, Some(area_m2))
            }
        };
        let mut entries = Entries { kind, weights, area_m2, bounds_m, normals: None, lines_of_sight };
        entries.normals = entries.few_normals(around);
        entries
    }

    fn few_normals(&self, around: &Surroundings) -> Option<Vec<DVec3>> {
        let mut normals: Vec<DVec3> = Vec::new();
        for entry in (0..self.weights.len()).filter(|entry| self.weights[*entry] > 0.0) {
            self.each_spot(around, entry, |spot, _| {
                let is_known = normals.iter().any(|known| 1.0 - known.dot(spot.normal) < 0.5 * ONE_NORMAL);
                if !is_known && normals.len() <= MOST_NORMALS {
                    normals.push(spot.normal);
                }
            });
            if normals.len() > MOST_NORMALS {
                return None;
            }
        }
        Some(normals)
    }

    /// Whether an entry is a mean over an area.
    pub fn are_means(&self) -> bool {
        self.kind == MapKind::Elements
    }

    /// Whether random decisions can affect what lines of sight show.
    pub fn have_chance(&self) -> bool {
        self.lines_of_sight.as_ref().is_some_and(|lines| lines.has_chance)
    }

    /// Returns the number of points at which the mesh is evaluated, over all entries.
    pub fn places(&self) -> usize {
        match &self.lines_of_sight {
            Some(lines) => lines.places(),
            None => self.weights.len() * if self.are_means() { PLACES_OF_ELEMENT.len() } else { 1 },
        }
    }

    /// Returns a unique number for a point of an entry.
    pub fn place_number(&self, entry: usize, number: usize) -> u64 {
        let most = self.lines_of_sight.as_ref().map_or(PLACES_OF_ELEMENT.len(), |lines| lines.most_places);
        (entry * most + number) as u64
    }

    /// Returns what an entry shows without light on surfaces: luminaires in an eye's line of sight, in cd/m².
    pub fn own_light_cd_m2(&self, entry: usize) -> f64 {
        self.lines_of_sight.as_ref().map_or(0.0, |lines| lines.luminaires_cd_m2(entry))
    }

    /// Whether an entry contains light on surfaces.
    pub fn has_places(&self, entry: usize) -> bool {
        self.lines_of_sight.as_ref().is_none_or(|lines| !lines.places_of(entry).is_empty() || lines.shows_gloss(entry))
    }

    /// Whether every sample of light traces new lines of sight.
    pub fn draw_lines_of_sight(&self) -> bool {
        self.lines_of_sight.as_ref().is_some_and(|lines| lines.are_drawn)
    }

    /// Whether lines of sight end on gloss, so that what they show has random error.
    pub fn show_gloss(&self) -> bool {
        self.lines_of_sight.as_ref().is_some_and(|lines| lines.gloss.is_some())
    }

    /// Calls `visit` for each point at which the mesh is evaluated, with the weight of its illuminance.
    pub fn each_spot(&self, around: &Surroundings, entry: usize, mut visit: impl FnMut(MeshPlace, f64)) {
        match (self.kind, &self.lines_of_sight) {
            (_, Some(lines)) => lines.places_of(entry).iter().for_each(|place| {
                visit(MeshPlace::at_origin(place.point_m, place.normal, place.origin), place.weight_per_sr);
            }),
            (MapKind::Receivers(set), None) => {
                visit(MeshPlace::of_point(&around.scene.receivers[set].points[entry]), 1.0)
            }
            (MapKind::Elements, None) => {
                let element = around.world.elements.element(entry as u32);
                let weight = 1.0 / PLACES_OF_ELEMENT.len() as f64;
                PLACES_OF_ELEMENT
                    .iter()
                    .for_each(|place| visit(MeshPlace::of_element(around, element, *place), weight));
            }
        }
    }

    /// Calls `visit` like [`Entries::each_spot`], but with one random point of an element instead of its fixed ones.
    pub fn each_drawn_spot(
        &self,
        around: &Surroundings,
        entry: usize,
        stream: &mut Stream,
        mut visit: impl FnMut(MeshPlace, f64, &mut Stream),
    ) {
        if self.are_means() {
            let element = around.world.elements.element(entry as u32);
            let spot = MeshPlace::drawn_in_element(around, element, stream);
            visit(spot, 1.0, stream);
            return;
        }
        self.each_spot(around, entry, |spot, weight| visit(spot, weight, stream));
    }
}
