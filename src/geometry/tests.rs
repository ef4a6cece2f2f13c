//! Tests of the geometry that need no large run.

use glam::DVec3;
use rand::RngExt;
use rand_philox::Philox;

use super::triangle::Ray;
use super::{Meeting, SurfaceHit, Tracer};
use crate::scene::{BsdfParameters, Emission, Luminaire, Material, Scene, Side, Surface};

fn scene_of(vertices_m: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Scene {
    let count = triangles.len();
    Scene {
        title: String::new(),
        path: None,
        materials: vec![Material { name: "grey".into(), bsdf: BsdfParameters::Diffuse { reflectance: 0.5 } }],
        vertices_m,
        triangles,
        divisions: vec![1; count],
        triangle_surfaces: vec![0; count],
        surfaces: vec![Surface {
            name: "all".into(),
            geometry: "all".into(),
            material: 0,
            two_sided: false,
            triangles: 0..count as u32,
        }],
        luminaires: vec![],
        receivers: vec![],
        bodies: vec![],
        warnings: vec![],
        project: Default::default(),
        energy: None,
        unreported: Default::default(),
    }
}

#[test]
fn a_triangle_seen_counter_clockwise_shows_its_front() {
    let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
    let tracer = Tracer::new(&scene_of(corners, vec![[0, 1, 2]]));
    let target = DVec3::new(0.2, 0.3, 0.0);
    for start in [DVec3::Z, DVec3::new(3.0, 1.0, 0.5), DVec3::new(-1.0, 4.0, 0.3), DVec3::new(-3.0, -4.0, 0.3)] {
        for (start, side) in [(start, Side::Front), (-start, Side::Back)] {
            let toward = target - start;
            let Meeting::Surface(hit) = tracer.first_hit(&tracer.free_origin(start), toward.normalize()) else {
                panic!("the triangle was missed from {start}")
            };
            assert_eq!((hit.triangle, hit.side), (0, side), "from {start}");
            assert!((hit.barycentric[0] - 0.2).abs() < 1e-5 && (hit.barycentric[1] - 0.3).abs() < 1e-5, "{hit:?}");
            assert!((hit.distance_m - toward.length()).abs() < 1e-5, "{hit:?}");
        }
    }
}

/// Random numbers from a seed.
struct Random(Philox);

impl Random {
    fn of(seed: u64) -> Random {
        Random(Philox::from_u64_seed(seed))
    }

    fn uniform(&mut self) -> f64 {
        self.0.random()
    }

    fn point(&mut self) -> DVec3 {
        DVec3::new(self.uniform(), self.uniform(), self.uniform())
    }

    fn unit(&mut self) -> DVec3 {
        let z = 2.0 * self.uniform() - 1.0;
        let (sine, cosine) = (std::f64::consts::TAU * self.uniform()).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        DVec3::new(radius * cosine, radius * sine, z)
    }
}

/// Triangles of all sizes scattered over 10 m.
fn soup(count: usize, seed: u64) -> Scene {
    let mut random = Random::of(seed);
    let mut vertices_m = Vec::new();
    for _ in 0..count {
        let (place, size) = (10.0 * random.point(), 6.0 * random.uniform().powi(3) + 0.01);
        vertices_m.extend((0..3).map(|_| place + size * random.point()));
    }
    let triangles = (0..count as u32).map(|triangle| [0, 1, 2].map(|corner| 3 * triangle + corner)).collect();
    scene_of(vertices_m, triangles)
}

fn with_ball(mut scene: Scene, center_m: DVec3, radius_m: f64) -> Scene {
    scene.luminaires.push(Luminaire {
        name: "globe".into(),
        luminous_flux_lm: 1.0,
        dimming: 1.0,
        maintenance_factor: 1.0,
        power_w: None,
        product: None,
        emission: Emission::Sphere { center_m, radius_m, exitance_lm_m2: 1.0 },
    });
    scene
}

/// A box seen from inside.
fn room(size_m: DVec3) -> Scene {
    let corner = |index: u32| size_m * DVec3::from([0, 1, 2].map(|axis| f64::from(index >> axis & 1)));
    let squares = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let triangles = squares.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    scene_of((0..8).map(corner).collect(), triangles)
}

/// Returns all crossings of a line with the triangles in f64 (Möller and Trumbore 1997), nearest first: distance, triangle and how far
/// inside its edges.
fn crossings_f64(scene: &Scene, from_m: DVec3, direction: DVec3) -> Vec<(f64, u32, f64)> {
    let mut all = Vec::new();
    for triangle in 0..scene.triangles.len() as u32 {
        let [a, b, c] = scene.corners_m(triangle);
        let (e, f, s) = (b - a, c - a, from_m - a);
        let determinant = e.dot(direction.cross(f));
        let u = s.dot(direction.cross(f)) / determinant;
        let v = direction.dot(s.cross(e)) / determinant;
        let t = f.dot(s.cross(e)) / determinant;
        let inside = u.min(v).min(1.0 - u - v);
        if inside > -1e-3 && t > -1e-3 {
            all.push((t, triangle, inside));
        }
    }
    all.sort_by(|one, other| one.0.total_cmp(&other.0));
    all
}

#[test]
fn first_hits_agree_with_all_triangles_tried_in_f64() {
    let scene = soup(400, 3);
    let tracer = Tracer::new(&scene);
    let mut random = Random::of(4);
    let (mut hits, mut misses) = (0, 0);
    for _ in 0..20_000 {
        let (from_m, direction) = (12.0 * random.point() - 1.0, random.unit());
        let crossings = crossings_f64(&scene, from_m, direction);
        // Results for rays that graze an edge or start on a triangle depend on f32 rounding, so they are skipped.
        if crossings.iter().any(|(t, _, inside)| inside.abs() < 1e-3 || t.abs() < 1e-3) {
            continue;
        }
        match (tracer.first_hit(&tracer.free_origin(from_m), direction), crossings.first()) {
            (Meeting::Surface(hit), Some((distance_m, triangle, _))) => {
                assert_eq!(hit.triangle, *triangle, "{hit:?} is not at {distance_m} m");
                assert!((hit.distance_m - distance_m).abs() < 1e-4, "{hit:?} is not at {distance_m} m");
                let from_front = scene.triangle_normal(*triangle).dot(direction) < 0.0;
                assert_eq!(hit.side, if from_front { Side::Front } else { Side::Back });
                hits += 1;
            }
            (Meeting::Nothing, None) => misses += 1,
            (met, expected) => panic!("{met:?} instead of {expected:?}"),
        }
    }
    assert!(hits > 5_000 && misses > 1_000, "{hits} hits and {misses} misses are no test");
}

#[cfg(target_arch = "x86_64")]
#[test]
fn the_portable_walk_gives_the_same_bits() {
    for (scene, seed) in [(soup(3_000, 5), 6), (room(DVec3::new(4.0, 3.0, 2.5)), 7)] {
        let tracer = Tracer::new(&with_ball(scene, DVec3::new(2.0, 1.5, 1.2), 0.3));
        if !tracer.tree.has_avx2 {
            return;
        }
        let mut random = Random::of(seed);
        let mut origin = tracer.free_origin(DVec3::new(1.0, 1.0, 1.0));
        for _ in 0..200_000 {
            let direction = random.unit().as_vec3a();
            let ray = Ray::new(origin.point, direction);
            let bits = |found: Option<super::tree::Found>| {
                found.map(|found| {
                    let crossing = found.crossing;
                    (found.primitive, crossing.t.to_bits(), crossing.weights.to_array().map(f32::to_bits))
                })
            };
            let portable = tracer.tree.closest_portable(&ray, &origin);
            assert_eq!(bits(portable), bits(tracer.tree.closest(&ray, &origin)));
            let to = tracer.free_origin(4.0 * random.point());
            let segment = Ray::new(origin.point, to.point - origin.point);
            assert_eq!(tracer.tree.blocks_portable(&segment, &origin, &to), tracer.tree.blocks(&segment, &origin, &to));
            origin = match tracer.first_hit(&origin, direction.as_dvec3()) {
                Meeting::Surface(hit) => tracer.surface_origin(hit.triangle, hit.barycentric, hit.side),
                _ => tracer.free_origin(4.0 * random.point()),
            };
        }
    }
}

#[test]
fn two_points_see_each_other_where_the_first_hit_lies_behind_the_second() {
    let scene = soup(150, 8);
    let tracer = Tracer::new(&scene);
    let mut random = Random::of(9);
    let (mut occluded, mut free) = (0, 0);
    for _ in 0..50_000 {
        let (from_m, to_m) = (10.0 * random.point(), 10.0 * random.point());
        let (from, to) = (tracer.free_origin(from_m), tracer.free_origin(to_m));
        let distance_m = from_m.distance(to_m);
        let direction = (to_m - from_m) / distance_m;
        let nearest_m = match tracer.first_hit(&from, direction) {
            Meeting::Surface(hit) => hit.distance_m,
            _ => f64::INFINITY,
        };
        if (nearest_m - distance_m).abs() < 10.0 * tracer.position_accuracy_m() {
            continue;
        }
        let expected = nearest_m < distance_m;
        assert_eq!(tracer.is_occluded(&from, &to), expected, "{nearest_m} of {distance_m} m");
        assert_eq!(tracer.is_occluded(&to, &from), expected, "and back");
        assert_eq!(tracer.is_occluded_towards(&from, direction, distance_m), expected, "and by direction");
        *(if expected { &mut occluded } else { &mut free }) += 1;
    }
    assert!(occluded > 5_000 && free > 5_000, "{occluded} and {free} are no test");
}

#[test]
fn all_points_of_an_empty_room_see_each_other() {
    let size_m = DVec3::new(4.0, 3.0, 2.5);
    let scene = room(size_m);
    let tracer = Tracer::new(&scene);
    let mut random = Random::of(10);
    for trial in 0..200_000 {
        let place = |random: &mut Random| {
            // Every third point lies on an edge, every ninth in a corner of its triangle.
            let (u, v) = (random.uniform(), random.uniform());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let barycentric = [if trial % 3 == 0 { 0.0 } else { u }, if trial % 9 == 0 { 0.0 } else { v }];
            let triangle = (12.0 * random.uniform()) as u32;
            (tracer.surface_origin(triangle, barycentric, Side::Front), triangle / 2)
        };
        let ((from, one), (to, other)) = (place(&mut random), place(&mut random));
        if one == other {
            continue;
        }
        assert!(!tracer.is_occluded(&from, &to), "{from:?} to {to:?}");
        let receiver_m = size_m * random.point().with_z(0.0);
        let receiver = tracer.side_origin(receiver_m, DVec3::Z);
        let lamp = tracer.side_origin(size_m * random.point().with_z(1.0), -DVec3::Z);
        assert!(!tracer.is_occluded(&receiver, &lamp), "{receiver_m}");
    }
}

#[test]
fn a_point_on_a_sheet_belongs_to_the_side_its_normal_points_to() {
    // A slanted sheet between two points.
    let corners = [[0.0, 0.0, 0.1], [3.0, 0.2, 0.4], [2.5, 3.0, 0.3], [0.1, 2.8, 0.0]].map(DVec3::from);
    let scene = scene_of(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
    let tracer = Tracer::new(&scene);
    let (above, below) = (DVec3::new(1.0, 1.5, 3.0), DVec3::new(1.5, 1.0, -3.0));
    let mut random = Random::of(11);
    for _ in 0..20_000 {
        let triangle = u32::from(random.uniform() < 0.5);
        let [a, b, c] = scene.corners_m(triangle);
        let (u, v) = (0.5 * random.uniform(), 0.5 * random.uniform());
        let point_m = a + u * (b - a) + v * (c - a);
        let normal = (scene.triangle_normal(triangle) + 0.8 * random.unit()).normalize();
        for normal in [normal, -normal] {
            let faces_up = normal.dot(scene.triangle_normal(triangle)) > 0.0;
            let receiver = tracer.side_origin(point_m, normal);
            for (lamp_m, is_above) in [(above, true), (below, false)] {
                let lamp = tracer.free_origin(lamp_m);
                assert_eq!(tracer.is_occluded(&receiver, &lamp), faces_up != is_above, "{point_m} {normal}");
                assert_eq!(tracer.is_occluded(&lamp, &receiver), faces_up != is_above, "{point_m} {normal}");
            }
        }
    }
}

#[test]
fn a_wall_that_nearly_touches_stops_the_ray() {
    // Half-extent 1 m: a gap of 1e-4 of the size, and one of 2e-6 m just above the stated accuracy.
    for gap_m in [1e-4, 1e-5, 2e-6] {
        let square = |z: f64| [[-1.0, -1.0, z], [1.0, -1.0, z], [1.0, 1.0, z], [-1.0, 1.0, z]].map(DVec3::from);
        let vertices_m = [square(0.0), square(gap_m)].concat();
        let tracer = Tracer::new(&scene_of(vertices_m, vec![[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 7, 6]]));
        assert!(gap_m > tracer.position_accuracy_m());
        let mut random = Random::of(12);
        for _ in 0..20_000 {
            let (u, v) = (0.45 * random.uniform() + 0.02, 0.45 * random.uniform() + 0.02);
            let origin = tracer.surface_origin(0, [u, v], Side::Front);
            let direction = (DVec3::Z + 0.99 * random.unit()).normalize();
            let Meeting::Surface(hit) = tracer.first_hit(&origin, direction) else { panic!("{gap_m}: passed") };
            assert!(hit.triangle >= 2 && hit.side == Side::Front, "{gap_m} {hit:?}");
            let expected_m = gap_m / direction.z;
            assert!((hit.distance_m - expected_m).abs() * direction.z < tracer.position_accuracy_m(), "{hit:?}");
        }
    }
}

#[test]
fn light_does_not_pass_thin_sheets_of_two_sides() {
    let mut scene = room(DVec3::new(2.0, 1.0, 1.0));
    let first = scene.triangles.len() as u32;
    // A sheet across the whole room, ending in its walls but without shared corners.
    let sheet = [[0.9, 0.0, 0.0], [0.9, 1.0, 0.0], [0.9, 1.0, 1.0], [0.9, 0.0, 1.0]].map(DVec3::from);
    scene.vertices_m.extend(sheet);
    scene.triangles.extend([[8, 9, 10], [8, 10, 11]]);
    scene.divisions = vec![1; scene.triangles.len()];
    scene.triangle_surfaces = [vec![0; first as usize], vec![1; 2]].concat();
    scene.surfaces.push(Surface {
        name: "sheet".into(),
        two_sided: true,
        triangles: first..first + 2,
        ..scene.surfaces[0].clone()
    });
    scene.surfaces[0].triangles = 0..first;
    let tracer = Tracer::new(&scene);
    for (start_m, side) in [(DVec3::new(0.3, 0.5, 0.5), Side::Back), (DVec3::new(1.5, 0.5, 0.5), Side::Front)] {
        let mut random = Random::of(13);
        let (mut origin, mut normal) = (tracer.free_origin(start_m), DVec3::ZERO);
        for _ in 0..300_000 {
            let direction = (normal + random.unit()).normalize();
            let Meeting::Surface(hit) = tracer.first_hit(&origin, direction) else { panic!("escaped") };
            let expected = if hit.triangle >= first { side } else { Side::Front };
            assert_eq!(hit.side, expected, "{hit:?}");
            normal = scene.triangle_normal(hit.triangle) * if hit.side == Side::Front { 1.0 } else { -1.0 };
            origin = tracer.surface_origin(hit.triangle, hit.barycentric, hit.side);
        }
    }
}

#[test]
fn balls_are_met_exactly_and_do_not_shadow_themselves() {
    let (center_m, radius_m) = (DVec3::new(1.0, 1.2, 1.1), 0.25);
    let scene = with_ball(room(DVec3::new(3.0, 2.0, 2.5)), center_m, radius_m);
    let tracer = Tracer::new(&scene);
    let mut random = Random::of(14);
    for _ in 0..50_000 {
        let from_m = DVec3::new(3.0, 2.0, 2.5) * random.point();
        let towards = center_m - from_m;
        if towards.length() < radius_m {
            continue;
        }
        // Results for rays that pass the rim within 1e-5 m depend on f32 rounding, so they are skipped.
        let aim = (towards + 0.6 * random.unit()).normalize();
        let miss_m = (towards - towards.dot(aim) * aim).length();
        if (miss_m - radius_m).abs() > 1e-5 && towards.dot(aim) > 0.0 {
            let met = tracer.first_hit(&tracer.free_origin(from_m), aim);
            assert_eq!(met == Meeting::Ball(0), miss_m < radius_m, "{met:?}");
        }
        let outward = random.unit();
        let on_ball = tracer.ball_origin(0, center_m + radius_m * outward);
        let height = outward.dot(from_m - center_m) - radius_m;
        if height.abs() > 1e-5 {
            let from = tracer.free_origin(from_m);
            assert_eq!(tracer.is_occluded(&from, &on_ball), height < 0.0);
            assert_eq!(tracer.is_occluded(&on_ball, &from), height < 0.0);
        }
        let away = (outward + random.unit()).normalize();
        assert!(matches!(tracer.first_hit(&on_ball, away), Meeting::Surface(SurfaceHit { side: Side::Front, .. })));
    }
}

#[test]
fn many_triangles_in_one_place_do_not_overflow_the_walk() {
    let mut vertices_m = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
    let mut triangles = vec![[0, 1, 2]; 2_000];
    // Adds triangles one behind another, each half as large.
    for level in 0..60 {
        let size = 0.5f64.powi(level);
        let first = vertices_m.len() as u32;
        vertices_m.extend([DVec3::Z, DVec3::X, DVec3::Y].map(|corner| size * corner - 2.0 * size * DVec3::ONE));
        triangles.push([first, first + 1, first + 2]);
    }
    let tracer = Tracer::new(&scene_of(vertices_m, triangles));
    let met = tracer.first_hit(&tracer.free_origin(DVec3::new(0.3, 0.3, 1.0)), -DVec3::Z);
    assert!(matches!(met, Meeting::Surface(SurfaceHit { triangle: 0, .. })), "the lowest number wins: {met:?}");
}

#[test]
fn an_empty_scene_is_met_nowhere() {
    let tracer = Tracer::new(&scene_of(vec![], vec![]));
    let (one, other) = (tracer.free_origin(DVec3::ZERO), tracer.free_origin(DVec3::ONE));
    assert_eq!(tracer.first_hit(&one, DVec3::X), Meeting::Nothing);
    assert!(!tracer.is_occluded(&one, &other) && !tracer.is_occluded(&one, &one));
}

#[test]
fn in_a_convex_room_the_planes_say_what_the_tree_says() {
    // Points in a room, on its surfaces, on lifted sides and outside: 20,000 pairs.
    let scene = room(DVec3::new(4.0, 3.0, 2.5));
    let tracer = Tracer::new(&scene);
    let hull = tracer.hull.as_ref().expect("an empty room is convex");
    let mut random = Random::of(21);
    let mut origin = |kind: f64| {
        let place = DVec3::new(4.0, 3.0, 2.5) * random.point();
        match (kind * 5.0) as u32 {
            0 => tracer.free_origin(place),
            1 => tracer.free_origin(place + DVec3::new(0.0, 0.0, 3.0)),
            2 => tracer.side_origin(DVec3::new(place.x, place.y, 0.0), DVec3::Z),
            3 => tracer.side_origin(DVec3::new(place.x, place.y, 0.0), -DVec3::Z),
            _ => tracer.surface_origin(
                (kind * 60.0) as u32 % 12,
                [0.5 * place.x / 4.0, 0.5 * place.y / 3.0],
                Side::Front,
            ),
        }
    };
    let mut kinds = Random::of(22);
    let (mut known, mut hidden) = (0, 0);
    for _ in 0..20_000 {
        let (from, to) = (origin(kinds.uniform()), origin(kinds.uniform()));
        let difference = to.point - from.point;
        if from.has_below(difference) || to.has_below(-difference) {
            continue;
        }
        let blocks = tracer.tree.blocks(&Ray::new(from.point, difference), &from, &to);
        if hull.holds(&from) && hull.holds(&to) {
            known += 1;
            assert!(!blocks, "{from:?} {to:?}");
        }
        hidden += usize::from(blocks);
        assert_eq!(tracer.is_occluded(&from, &to), blocks);
    }
    assert!(known > 4_000 && hidden > 4_000, "{known} known and {hidden} hidden are no test");
}

#[test]
fn what_has_something_behind_a_plane_is_not_convex() {
    let mut with_plate = room(DVec3::new(4.0, 3.0, 2.5));
    let first = with_plate.vertices_m.len() as u32;
    with_plate.vertices_m.extend([DVec3::new(1.0, 1.0, 1.0), DVec3::new(2.0, 1.0, 1.0), DVec3::new(1.0, 2.0, 1.0)]);
    with_plate.triangles.push([first, first + 1, first + 2]);
    with_plate.divisions.push(1);
    with_plate.triangle_surfaces.push(0);
    assert!(Tracer::new(&with_plate).hull.is_none());
    assert!(Tracer::new(&soup(20, 5)).hull.is_none());
    assert!(Tracer::new(&with_ball(room(DVec3::ONE), DVec3::splat(0.5), 0.1)).hull.is_none());
}

/// Adds triangles as a surface of their own.
fn with_surface(mut scene: Scene, vertices_m: &[DVec3], triangles: &[[u32; 3]], two_sided: bool) -> Scene {
    let (vertex, first) = (scene.vertices_m.len() as u32, scene.triangles.len() as u32);
    scene.vertices_m.extend(vertices_m);
    scene.triangles.extend(triangles.iter().map(|corners| corners.map(|corner| vertex + corner)));
    scene.divisions.resize(scene.triangles.len(), 1);
    scene.triangle_surfaces.resize(scene.triangles.len(), scene.surfaces.len() as u32);
    let triangles = first..scene.triangles.len() as u32;
    scene.surfaces.push(Surface { name: "more".into(), two_sided, triangles, ..scene.surfaces[0].clone() });
    scene
}

/// A room of 4 × 3 × 2.5 m with a solid table in it.
fn room_with_table() -> Scene {
    let room = room(DVec3::new(4.0, 3.0, 2.5));
    let table = self::room(DVec3::new(1.6, 0.8, 0.75));
    let vertices_m: Vec<DVec3> = table.vertices_m.iter().map(|place| *place + DVec3::new(1.2, 1.0, 0.0)).collect();
    let outward: Vec<[u32; 3]> = table.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    with_surface(room, &vertices_m, &outward, false)
}

/// Makes the tracer of a scene, and finds its clear boxes by rays between surfaces.
fn tracer_with_boxes(scene: &Scene) -> Tracer {
    let mut tracer = Tracer::new(scene);
    let mut random = Random::of(26);
    let mut lines = Vec::new();
    for _ in 0..256 {
        let from = tracer.free_origin(DVec3::new(4.0, 3.0, 2.5) * random.point());
        let ends = [0, 1].map(|_| tracer.first_hit(&from, random.unit()));
        if let [Meeting::Surface(one), Meeting::Surface(other)] = ends {
            let [one, other] = [one, other].map(|hit| tracer.surface_origin(hit.triangle, hit.barycentric, hit.side));
            lines.push([one, other]);
        }
    }
    lines.retain(|[from, to]| !tracer.is_occluded(from, to));
    tracer.find_clear_boxes(lines);
    tracer
}

#[test]
fn points_in_a_clear_box_see_each_other() {
    // Points in a room, on its surfaces and on a table's, on lifted sides that face up and down: 40,000 pairs.
    let tracer = tracer_with_boxes(&room_with_table());
    assert!(tracer.hull.is_none());
    let (mut random, mut kinds) = (Random::of(23), Random::of(24));
    let mut origin = |kind: f64| {
        let place = DVec3::new(4.0, 3.0, 2.5) * random.point();
        match (kind * 4.0) as u32 {
            0 => tracer.free_origin(place),
            1 => tracer.side_origin(DVec3::new(place.x, place.y, 0.0), DVec3::Z),
            2 => tracer.side_origin(DVec3::new(place.x, place.y, 0.75), -DVec3::Z),
            _ => tracer.surface_origin(
                (kind * 96.0) as u32 % 24,
                [0.5 * place.x / 4.0, 0.5 * place.y / 3.0],
                Side::Front,
            ),
        }
    };
    let (mut known, mut hidden) = (0, 0);
    for _ in 0..40_000 {
        let (from, to) = (origin(kinds.uniform()), origin(kinds.uniform()));
        let difference = to.point - from.point;
        if from.has_below(difference) || to.has_below(-difference) {
            continue;
        }
        let blocks = tracer.tree.blocks(&Ray::new(from.point, difference), &from, &to);
        if tracer.clear.hold(&from, &to) {
            known += 1;
            assert!(!blocks, "{from:?} {to:?}");
        }
        hidden += usize::from(blocks);
        assert_eq!(tracer.is_occluded(&from, &to), blocks);
    }
    assert!(known > 8_000 && hidden > 8_000, "{known} known and {hidden} hidden are no test");
}

#[test]
fn a_floor_under_a_plate_is_in_no_clear_box() {
    // A plate over a whole floor, less high above it than points are lifted, in a room that is not convex.
    let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]].map(|[x, y]| DVec3::new(x, y, 0.6e-6));
    let tracer = tracer_with_boxes(&with_surface(room_with_table(), &corners, &[[0, 1, 2], [0, 2, 3]], true));
    let lamp = tracer.free_origin(DVec3::new(2.0, 1.5, 2.2));
    assert!(tracer.clear.hold(&lamp, &tracer.side_origin(DVec3::new(1.0, 1.0, 2.5), -DVec3::Z)));
    let mut random = Random::of(25);
    for place in 0..1_000 {
        let weights = [0.5 * random.uniform(), 0.5 * random.uniform()];
        // The first two triangles are the floor.
        let floor = tracer.surface_origin(place % 2, weights, Side::Front);
        assert!(!tracer.clear.hold(&floor, &lamp) && tracer.is_occluded(&floor, &lamp), "{floor:?}");
    }
}

#[test]
fn a_scene_far_larger_than_its_triangles_has_a_tracer() {
    // Rounding leaves one point of all triangles.
    let tracer = tracer_with_boxes(&with_ball(room(DVec3::ONE), DVec3::splat(1e30), 1.0));
    assert!(!tracer.clear.hold(&tracer.free_origin(DVec3::ZERO), &tracer.free_origin(DVec3::ONE)));
}
