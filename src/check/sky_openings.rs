//! Finds the openings through which the sky's light enters a scene: panes, and holes in the surfaces around a room.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::box_tree::Budget;
use super::faults::{MeshFaults, RimEdge};
use super::insides::SolidLookup;
use super::mesh_faults::{lies_in_a_plane, lines_of};
use super::shells::{Shell, one_vertex_a_place, plain_shells_over, sorted_edges};
use super::straight::first_met;
use super::t_junctions::closed_at_t_junctions;
use crate::base::solid_angle::signed_triangle_solid_angle_sr;
use crate::sampling::sky_openings::crossed_at_m;
use crate::scene::openings::{FLAT, area_m2, normal};
use crate::scene::{BsdfParameters, Emission, Openings, Scene, triangulate};

/// Largest number of openings, because each light sample tests them all. The sky behind further openings is sampled as for the open air.
const MOST_OPENINGS: usize = 256;
/// Largest and least number of directions that are tested to find which way an opening faces.
const DIRECTIONS: u64 = 64;
const FEWEST_DIRECTIONS: u64 = 4;
/// Largest number of triangle tests for these directions, and in the search for light past the openings: one second's work each.
const MOST_TRIES: u64 = 200_000_000;
const MOST_SOLID_ANGLES: u64 = 20_000_000;
/// Steps of the search for holes, and additional steps per triangle.
const STEPS: u64 = 20_000_000;
const STEPS_A_TRIANGLE: u64 = 100;
/// Around a point in a closed room the solid angles add up to the whole sphere within this share.
const CLOSED_WITHIN: f64 = 1e-6;
/// Points where each side of a triangle is tested, as weights of its corners.
const PLACES: [[f64; 3]; 4] = [[1.0 / 3.0; 3], [0.98, 0.01, 0.01], [0.01, 0.98, 0.01], [0.01, 0.01, 0.98]];

/// Returns the openings of a scene.
fn openings_of(scene: &Scene, solids: &[Shell]) -> Openings {
    let [low_m, high_m] = scene.bounds_m();
    let points = || scene.receivers.iter().flat_map(|set| set.placed_points().iter().map(|point| point.position_m));
    let (low_m, high_m) = points().fold((low_m, high_m), |(low, high), point| (low.min(point), high.max(point)));
    let size_m = low_m.distance(high_m);
    let (center_m, radius_m) = (0.5 * (low_m + high_m), 0.5005 * size_m);
    let pieces = Pieces::of(scene, size_m);
    let panes = (0..scene.triangles.len() as u32).filter(|triangle| is_pane(scene, *triangle));
    let mut candidates: Vec<[DVec3; 3]> = panes.map(|triangle| scene.corners_m(triangle)).collect();
    candidates.extend(&pieces.holes_m);
    candidates.sort_by(|one, other| area_m2(other).total_cmp(&area_m2(one)));
    candidates.truncate(MOST_OPENINGS);
    let tries = MOST_TRIES / (2 * scene.triangles.len() as u64 * candidates.len().max(1) as u64);
    let fronts_m: Vec<[DVec3; 3]> = match tries.min(DIRECTIONS) {
        directions @ FEWEST_DIRECTIONS.. => {
            candidates.par_iter().filter_map(|corners_m| turned_in(scene, *corners_m, size_m, directions)).collect()
        }
        _ => Vec::new(),
    };
    let are_all = pieces.shut_in(scene, &fronts_m, FLAT * size_m, &SolidLookup::of(solids, size_m));
    Openings { fronts_m, are_all, center_m, radius_m }
}

/// Finds the openings of a scene with a sky, and the flux through them. `solids` are the scene's closed shells.
pub(super) fn find_openings(scene: &mut Scene, solids: &[Shell]) {
    if !scene.luminaires.iter().any(|luminaire| luminaire.emission.is_daylight()) {
        return;
    }
    let found = Arc::new(openings_of(scene, solids));
    for luminaire in &mut scene.luminaires {
        let is_lit = luminaire.luminous_flux_lm > 0.0;
        let flux_lm = match &mut luminaire.emission {
            Emission::Sky { sky, openings, .. } => {
                *openings = found.clone();
                found.fluxes_lm(|normal| sky.illuminance_lx(normal)).sum::<f64>()
                    + found.open_flux_lm(sky.total_cd_sr_m2())
            }
            Emission::Sun { sun, openings } => {
                *openings = found.clone();
                found.fluxes_lm(|normal| sun.illuminance_lx(normal)).sum::<f64>()
                    + found.open_flux_lm(sun.total_cd_sr_m2())
            }
            _ => continue,
        };
        luminaire.luminous_flux_lm = if is_lit { flux_lm } else { 0.0 };
    }
}

fn is_pane(scene: &Scene, triangle: u32) -> bool {
    let bsdf = &scene.materials[scene.surface_of(triangle).material as usize].bsdf;
    matches!(bsdf, BsdfParameters::Glass { .. }) && bsdf.lets_through()
}

/// Returns the triangle turned so that its front faces away from the side that sees more of the sky; `None` if neither side sees any.
fn turned_in(scene: &Scene, corners_m: [DVec3; 3], size_m: f64, directions: u64) -> Option<[DVec3; 3]> {
    let [a, b, c] = corners_m;
    let front = normal(&corners_m);
    let middle_m = (a + b + c) / 3.0;
    let seen = [front, -front].map(|outward| {
        let tangent = outward.any_orthonormal_vector();
        let sees = |number: u64| {
            // Uniform over the disk below the hemisphere, by a spiral of golden angles.
            let share = (number as f64 + 0.5) / directions as f64;
            let (sine, cosine) = (number as f64 * PI * (3.0 - 5f64.sqrt())).sin_cos();
            let flat = cosine * tangent + sine * outward.cross(tangent);
            let towards = share.sqrt() * flat + (1.0 - share).sqrt() * outward;
            let is_free = first_met(scene, middle_m + FLAT * size_m * outward, towards).is_none();
            u32::from(is_free) * if towards.z > 0.0 { 2 } else { 1 }
        };
        (0..directions).map(sees).sum::<u32>()
    });
    match seen {
        [0, 0] => None,
        [ahead, behind] if ahead > behind => Some([a, c, b]),
        _ => Some(corners_m),
    }
}

/// Pieces of surface and their holes.
struct Pieces {
    /// For each triangle, whether it belongs to an isolated flat sheet, which encloses nothing.
    is_sheet: Vec<bool>,
    /// Triangles that fill the holes.
    holes_m: Vec<[DVec3; 3]>,
}

impl Pieces {
    fn of(scene: &Scene, size_m: f64) -> Pieces {
        let all: Vec<u32> = (0..scene.triangles.len() as u32).collect();
        let vertex_of = one_vertex_a_place(scene);
        let corners = |triangle: u32| scene.triangles[triangle as usize].map(|vertex| vertex_of[vertex as usize]);
        let edges = sorted_edges(&all, corners);
        let rim = edges.chunk_by(|one, other| one.0 == other.0).filter(|same| same.len() % 2 == 1);
        let rim: Vec<RimEdge> = rim.map(|same| RimEdge { ends: same[0].0, triangle: same[0].2 }).collect();
        let mut budget = Budget::of_steps(STEPS + STEPS_A_TRIANGLE * all.len() as u64);
        let closed = closed_at_t_junctions(scene, rim, &mut budget, &mut MeshFaults::default());
        let shells = plain_shells_over(scene, &vertex_of);
        let is_sheet = sheets(scene, &shells, &closed.joined);
        let mut holes_m = Vec::new();
        for (vertices, line) in lines_of(&closed.open) {
            if vertices.first() != vertices.last()
                || line.iter().all(|edge| is_sheet[closed.open[*edge].triangle as usize])
            {
                continue;
            }
            holes_m.extend(filled(scene, &vertices[1..], FLAT * size_m));
        }
        Pieces { is_sheet, holes_m }
    }

    /// Whether closed surfaces, including the openings, lie around everything that receives light.
    fn shut_in(&self, scene: &Scene, fronts_m: &[[DVec3; 3]], step_m: f64, solids: &SolidLookup) -> bool {
        // Each wall with the number of its triangle; openings have none.
        let mut walls: Vec<([DVec3; 3], Option<u32>)> = fronts_m.iter().map(|corners_m| (*corners_m, None)).collect();
        let mut places: Vec<(DVec3, Option<u32>)> = Vec::new();
        for triangle in 0..scene.triangles.len() as u32 {
            let corners_m = scene.corners_m(triangle);
            let is_pane = is_pane(scene, triangle);
            if !is_pane && !self.is_sheet[triangle as usize] {
                walls.push((corners_m, Some(triangle)));
            }
            let normal = scene.triangle_normal(triangle);
            let sides: &[f64] = match scene.surface_of(triangle).two_sided {
                _ if is_pane => &[],
                true => &[1.0, -1.0],
                false => &[1.0],
            };
            for side in sides {
                places.extend(PLACES.map(|weights| {
                    let place_m: DVec3 = weights.iter().zip(corners_m).map(|(weight, m)| *weight * m).sum();
                    (place_m + side * step_m * normal, Some(triangle))
                }));
            }
        }
        let points = scene.receivers.iter().flat_map(|set| set.placed_points().iter().filter(|point| !point.inside));
        places.extend(points.map(|point| (point.position_m + step_m * point.normal, None)));
        if fronts_m.is_empty() || (walls.len() as u64).saturating_mul(places.len() as u64) > MOST_SOLID_ANGLES {
            return false;
        }
        let (held, _) = solids.holding(&places.iter().map(|(place_m, _)| *place_m).collect::<Vec<_>>());
        let mut held = held.into_iter();
        places.retain(|_| !held.next().unwrap_or(false));
        // Fronts that face a point add up to +1 around it, backs to −1.
        let around = places.par_iter().map(|(place_m, _)| {
            let seen = walls.iter().map(|(corners_m, _)| {
                let [a, b, c] = corners_m.map(|corner_m| corner_m - *place_m);
                signed_triangle_solid_angle_sr(a, b, c)
            });
            seen.sum::<f64>() / (4.0 * PI)
        });
        let around: Vec<f64> = around.collect();
        let whole = around.first().copied().unwrap_or_default().round();
        // A point of a triangle that lies against a wall has stepped through the wall. It is dark.
        let lies_against = |place_m: DVec3, own: Option<u32>| {
            let before_m = 3.0 * step_m;
            walls.iter().filter(|(_, wall)| own.is_some() && *wall != own).any(|(corners_m, _)| {
                let normal = normal(corners_m);
                let at_m = crossed_at_m(corners_m, place_m + before_m * normal, -normal);
                at_m.is_some_and(|at_m| (0.0..before_m).contains(&at_m))
            })
        };
        let is_shut = |(share, (place_m, own)): (&f64, &(DVec3, Option<u32>))| {
            (share - whole).abs() < CLOSED_WITHIN || lies_against(*place_m, *own)
        };
        whole.abs() == 1.0 && around.iter().zip(&places).all(is_shut)
    }
}

/// Marks the triangles of flat pieces that are joined to nothing.
fn sheets(scene: &Scene, shells: &[Shell], joined: &[[u32; 2]]) -> Vec<bool> {
    let mut shell_of = vec![0; scene.triangles.len()];
    for (number, shell) in shells.iter().enumerate() {
        shell.triangles.iter().for_each(|triangle| shell_of[*triangle as usize] = number);
    }
    let mut is_alone: Vec<bool> = shells.iter().map(|shell| !shell.closed && lies_in_a_plane(scene, shell)).collect();
    for pair in joined {
        let [one, other] = pair.map(|triangle| shell_of[triangle as usize]);
        if one != other {
            is_alone[one] = false;
            is_alone[other] = false;
        }
    }
    shell_of.into_iter().map(|shell| is_alone[shell]).collect()
}

/// Returns triangles that fill a flat closed line; none if the line is not flat.
fn filled(scene: &Scene, vertices: &[u32], flat_m: f64) -> Vec<[DVec3; 3]> {
    let places_m: Vec<DVec3> = vertices.iter().map(|vertex| scene.vertices_m[*vertex as usize]).collect();
    let count = places_m.len();
    let is_corner = |place: usize| {
        let [before, here, after] = [count - 1, 0, 1].map(|step| places_m[(place + step) % count]);
        (here - before).cross(after - here).length() > flat_m * before.distance(after)
    };
    let corners_m: Vec<DVec3> = (0..count).filter(|place| is_corner(*place)).map(|place| places_m[place]).collect();
    let triangles: Vec<[DVec3; 3]> =
        triangulate(&corners_m).into_iter().map(|triangle| triangle.map(|corner| corners_m[corner])).collect();
    let largest = triangles.iter().max_by(|one, other| area_m2(one).total_cmp(&area_m2(other)));
    let Some(plane) = largest else {
        return Vec::new();
    };
    let normal = normal(plane);
    let is_flat = corners_m.iter().all(|corner_m| (*corner_m - plane[0]).dot(normal).abs() <= flat_m);
    if is_flat { triangles.into_iter().filter(|corners_m| area_m2(corners_m) > 0.0).collect() } else { Vec::new() }
}
