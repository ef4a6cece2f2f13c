//! Closed rooms are closed: of millions of rays in diffuse chains, many aimed at edges and corners, none escapes and none meets a back.
//!
//! The counts are exact zeros, not statistics: α does not apply. A room with one corner moved by 1e-4 of its size is the planted fault that
//! the same harness must find. `LUXMC_SLOW_TESTS=1` traces 1e8 rays in all instead of 4 million.

use glam::{DQuat, DVec3};
use luxmc::geometry::{Meeting, Tracer};
use luxmc::scene::{BsdfParameters, Material, Scene, Side, Surface};

/// Rays per room and position in the fast tests.
const RAYS: u64 = 40_000;
/// Rays per room and position in the slow tests.
const SLOW_RAYS: u64 = 1_500_000;
/// Smallest cosine at which a ray is aimed off its surface. A flatter ray starts inside the surface as rounded to f32.
const LEAST_COSINE: f64 = 1e-4;

fn rays() -> u64 {
    if std::env::var_os("LUXMC_SLOW_TESTS").is_some_and(|value| value == "1") { SLOW_RAYS } else { RAYS }
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Tally {
    escapes: u64,
    backs: u64,
    /// Hits of triangles that belong to another room.
    strangers: u64,
}

const CLOSED: Tally = Tally { escapes: 0, backs: 0, strangers: 0 };

/// Follows diffuse chains from a point inside. Every second ray is aimed at a corner or an edge of the scene.
fn chains(mesh: &Mesh, inside_m: DVec3, room: std::ops::Range<u32>, rays: u64, seed: u64) -> Tally {
    let scene = mesh.scene();
    let tracer = Tracer::new(&scene);
    let workers = std::thread::available_parallelism().map_or(1, usize::from).min(16) as u64;
    let tallies = std::thread::scope(|scope| {
        let (scene, tracer, room) = (&scene, &tracer, &room);
        let run = |worker: u64| {
            scope
                .spawn(move || chains_of_one(scene, tracer, inside_m, room, rays.div_ceil(workers), seed << 8 | worker))
        };
        let handles: Vec<_> = (0..workers).map(run).collect();
        handles.into_iter().map(|handle| handle.join().expect("a worker failed")).collect::<Vec<_>>()
    });
    tallies.iter().fold(Tally::default(), |sum, one| Tally {
        escapes: sum.escapes + one.escapes,
        backs: sum.backs + one.backs,
        strangers: sum.strangers + one.strangers,
    })
}

fn chains_of_one(
    scene: &Scene,
    tracer: &Tracer,
    inside_m: DVec3,
    room: &std::ops::Range<u32>,
    rays: u64,
    seed: u64,
) -> Tally {
    let mut random = Random(seed);
    let mut tally = Tally::default();
    let restart = |random: &mut Random| (tracer.free_origin(inside_m), aim(scene, inside_m, random));
    let (mut origin, mut direction) = restart(&mut random);
    for ray in 0..rays {
        let meeting = tracer.first_hit(&origin, direction);
        let Meeting::Surface(hit) = meeting else {
            tally.escapes += 1;
            (origin, direction) = restart(&mut random);
            continue;
        };
        tally.backs += u64::from(hit.side == Side::Back);
        tally.strangers += u64::from(!room.contains(&hit.triangle));
        if ray % 64 == 63 || hit.side == Side::Back || !room.contains(&hit.triangle) {
            (origin, direction) = restart(&mut random);
            continue;
        }
        let [a, b, c] = scene.corners_m(hit.triangle);
        let normal = scene.triangle_normal(hit.triangle);
        let place_m = a + hit.barycentric[0] * (b - a) + hit.barycentric[1] * (c - a);
        origin = tracer.surface_origin(hit.triangle, hit.barycentric, hit.side);
        direction = aim(scene, place_m, &mut random);
        if random.uniform() < 0.5 || direction.dot(normal) < LEAST_COSINE {
            direction = (normal + random.unit()).normalize();
            if direction.dot(normal) < LEAST_COSINE {
                direction = normal;
            }
        }
    }
    tally
}

/// Direction to a corner of the scene, or to some point on an edge.
fn aim(scene: &Scene, from_m: DVec3, random: &mut Random) -> DVec3 {
    let triangle = (random.uniform() * scene.triangles.len() as f64) as u32;
    let [a, b, c] = scene.corners_m(triangle);
    let (start, end) = [(a, b), (b, c), (c, a)][(random.uniform() * 3.0) as usize];
    let share = if random.uniform() < 0.3 { 0.0 } else { random.uniform() };
    (start + share * (end - start) - from_m).try_normalize().unwrap_or_else(|| random.unit())
}

#[test]
fn nothing_leaks_from_closed_rooms_wherever_and_however_large_they_are() {
    for (name, mesh, inside_m) in rooms() {
        for (place, moved) in places() {
            let mut room = mesh.clone();
            room.vertices_m.iter_mut().for_each(|vertex_m| *vertex_m = moved(*vertex_m));
            let triangles = 0..room.triangles.len() as u32;
            let tally = chains(&room, moved(inside_m), triangles, rays(), 1);
            assert_eq!(tally, CLOSED, "{name} {place}");
        }
    }
}

type Motion = fn(DVec3) -> DVec3;

fn places() -> Vec<(&'static str, Motion)> {
    vec![
        ("as it is", |point| point),
        ("turned", |point| DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 0.7, 1.1) * point),
        ("1000 km along x", |point| point + DVec3::X * 1e6),
        ("1000 km along y", |point| point + DVec3::Y * 1e6),
        ("1000 km along z", |point| point - DVec3::Z * 1e6),
        ("a millimetre large", |point| point * 1e-3),
        ("100 km large, turned", |point| DQuat::from_euler(glam::EulerRot::XYZ, 2.0, -0.4, 0.6) * point * 1e5),
    ]
}

fn rooms() -> Vec<(&'static str, Mesh, DVec3)> {
    let high = DVec3::new(1.0, 0.8, 0.37);
    let middle = 0.4 * high;
    let mut furnished = Mesh::cuboid(DVec3::ZERO, high, 1, true);
    furnished.add(Mesh::cuboid(DVec3::new(0.1, 0.1, 0.0), DVec3::new(0.3, 0.2, 0.2), 1, false));
    furnished.add(Mesh::cuboid(DVec3::new(0.5, 0.3, 0.0), DVec3::new(0.9, 0.7, 0.1), 2, false));
    furnished.add(Mesh::cuboid(DVec3::new(0.6, 0.4, 0.1), DVec3::new(0.7, 0.5, 0.3), 1, false));
    furnished.add(Mesh::cuboid(DVec3::new(0.6001, 0.5001, 0.1), DVec3::new(0.7, 0.6, 0.3), 1, false));
    let mut turned = Mesh::cuboid(DVec3::new(-0.1, -0.15, 0.0), DVec3::new(0.1, 0.15, 0.2), 1, false);
    turned
        .vertices_m
        .iter_mut()
        .for_each(|vertex| *vertex = DQuat::from_rotation_z(0.4) * *vertex + 0.35 * DVec3::ONE.with_z(0.0));
    let mut with_turned = Mesh::cuboid(DVec3::ZERO, high, 3, true);
    with_turned.add(turned);
    let mut with_pyramid = Mesh::cuboid(DVec3::ZERO, high, 1, true);
    with_pyramid.add(Mesh::overhang());
    vec![
        ("a box of 12 triangles", Mesh::cuboid(DVec3::ZERO, high, 1, true), middle),
        ("a box with divided faces", Mesh::cuboid(DVec3::ZERO, high, 7, true), middle),
        ("a box of 20,000 triangles", Mesh::cuboid(DVec3::ZERO, high, 41, true), middle),
        ("a sphere of 1,280 triangles", Mesh::icosphere(3), DVec3::new(0.1, 0.2, 0.05)),
        ("a sphere of 20,480 triangles", Mesh::icosphere(5), DVec3::new(0.1, 0.2, 0.05)),
        ("a room with boxes on its floor", furnished, DVec3::new(0.4, 0.25, 0.3)),
        ("a room with a turned box", with_turned, DVec3::new(0.05, 0.05, 0.3)),
        ("a room with an overhanging solid", with_pyramid, DVec3::new(0.05, 0.05, 0.3)),
        ("a wedge of 10 degrees", Mesh::wedge(10.0), DVec3::new(0.6, 0.5, 0.05)),
        ("a wedge of 45 degrees", Mesh::wedge(45.0), DVec3::new(0.6, 0.5, 0.05)),
    ]
}

#[test]
fn a_corner_moved_by_a_ten_thousandth_is_found() {
    let mut mesh = Mesh::cuboid(DVec3::ZERO, DVec3::ONE, 4, true);
    // The corner of one triangle is detached and lifted a little to the inside.
    let loose = mesh.triangles[20][0];
    let moved_m = mesh.vertices_m[loose as usize] + 1e-4 * DVec3::new(0.3, 0.5, 0.8);
    mesh.triangles[20][0] = mesh.vertices_m.len() as u32;
    mesh.vertices_m.push(moved_m);
    let triangles = 0..mesh.triangles.len() as u32;
    let tally = chains(&mesh, DVec3::splat(0.4), triangles, 3 * RAYS, 2);
    assert!(tally.escapes > 0, "{tally:?}");
}

#[test]
fn nothing_passes_between_rooms_that_share_a_wall() {
    for (place, moved) in places() {
        // The shared wall consists of two layers back to back with different divisions.
        let mut both = Mesh::cuboid(DVec3::new(-1.0, 0.0, 0.0), DVec3::new(0.0, 0.8, 0.6), 3, true);
        let first = both.triangles.len() as u32;
        both.add(Mesh::cuboid(DVec3::new(0.0, -0.2, 0.0), DVec3::new(0.9, 0.7, 0.6), 4, true));
        both.vertices_m.iter_mut().for_each(|vertex_m| *vertex_m = moved(*vertex_m));
        let all = both.triangles.len() as u32;
        assert_eq!(chains(&both, moved(DVec3::new(-0.5, 0.3, 0.3)), 0..first, 3 * rays(), 3), CLOSED, "{place}");
        assert_eq!(chains(&both, moved(DVec3::new(0.5, 0.3, 0.3)), first..all, 3 * rays(), 4), CLOSED, "{place}");
    }
}

#[derive(Clone, Default)]
struct Mesh {
    vertices_m: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    fn add(&mut self, other: Mesh) {
        let first = self.vertices_m.len() as u32;
        self.vertices_m.extend(other.vertices_m);
        self.triangles.extend(other.triangles.iter().map(|corners| corners.map(|corner| corner + first)));
    }

    /// Number of a vertex. Vertices at exactly the same position share one.
    fn vertex(&mut self, point_m: DVec3) -> u32 {
        let known = self.vertices_m.iter().position(|vertex_m| *vertex_m == point_m);
        known.unwrap_or_else(|| {
            self.vertices_m.push(point_m);
            self.vertices_m.len() - 1
        }) as u32
    }

    /// A conforming box whose faces are divided into n × n squares.
    fn cuboid(low: DVec3, high: DVec3, n: u32, inward: bool) -> Mesh {
        let mut mesh = Mesh::default();
        let mut known = std::collections::HashMap::new();
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            for top in [false, true] {
                for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                    let mut corner = |i: u32, j: u32| {
                        let mut step = [0; 3];
                        step[axis] = if top { n } else { 0 };
                        (step[u], step[v]) = (i, j);
                        *known.entry(step).or_insert_with(|| {
                            let share = DVec3::from(step.map(|step| f64::from(step) / f64::from(n)));
                            mesh.vertices_m.push(low + share * (high - low));
                            mesh.vertices_m.len() as u32 - 1
                        })
                    };
                    let square = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
                    for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
                        let [a, b, c] = if top == inward { [a, c, b] } else { [a, b, c] };
                        mesh.triangles.push([square[a], square[b], square[c]]);
                    }
                }
            }
        }
        mesh
    }

    /// A unit sphere seen from inside.
    fn icosphere(divisions: u32) -> Mesh {
        let golden = 0.5 * (1.0 + 5f64.sqrt());
        let mut mesh = Mesh::default();
        for (a, b) in [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)] {
            mesh.vertices_m.extend([DVec3::new(a, b, 0.0), DVec3::new(0.0, a, b), DVec3::new(b, 0.0, a)]);
        }
        mesh.vertices_m.iter_mut().for_each(|vertex| *vertex = vertex.normalize());
        let vertices = mesh.vertices_m.clone();
        // Faces of the icosahedron: all triples of nearest neighbours.
        let near = |a: usize, b: usize| vertices[a].distance(vertices[b]) < 1.2;
        for (a, b, c) in (0..12).flat_map(|a| (0..a).flat_map(move |b| (0..b).map(move |c| (a, b, c)))) {
            if near(a, b) && near(b, c) && near(c, a) {
                let outward = (vertices[b] - vertices[a]).cross(vertices[c] - vertices[a]).dot(vertices[a]) > 0.0;
                mesh.triangles.push(if outward { [a, c, b] } else { [a, b, c] }.map(|corner| corner as u32));
            }
        }
        assert_eq!(mesh.triangles.len(), 20);
        for _ in 0..divisions {
            let mut middles = std::collections::HashMap::new();
            let vertices_m = &mut mesh.vertices_m;
            let mut middle = |a: u32, b: u32| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    vertices_m.push((vertices_m[a as usize] + vertices_m[b as usize]).normalize());
                    vertices_m.len() as u32 - 1
                })
            };
            let divide = |[a, b, c]: &[u32; 3]| {
                let [ab, bc, ca] = [middle(*a, *b), middle(*b, *c), middle(*c, *a)];
                [[*a, ab, ca], [ab, *b, bc], [ca, bc, *c], [ab, bc, ca]]
            };
            mesh.triangles = mesh.triangles.iter().flat_map(divide).collect();
        }
        mesh
    }

    /// A closed prism over a triangle with one sharp angle.
    fn wedge(angle_deg: f64) -> Mesh {
        let rise = angle_deg.to_radians().tan();
        let outline = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 0.0, rise)];
        let mut mesh = Mesh::default();
        let [a, b, c] = outline.map(|point| mesh.vertex(point));
        let [d, e, f] = outline.map(|point| mesh.vertex(point + DVec3::Y));
        mesh.triangles = vec![[a, c, b], [d, e, f], [a, b, e], [a, e, d], [b, c, f], [b, f, e], [c, a, d], [c, d, f]];
        // Turn all fronts to the centre.
        let middle = mesh.vertices_m.iter().sum::<DVec3>() / 6.0;
        let vertices_m = &mesh.vertices_m;
        for corners in &mut mesh.triangles {
            let [a, b, c] = corners.map(|corner| vertices_m[corner as usize]);
            if (b - a).cross(c - a).dot(middle - a) < 0.0 {
                corners.swap(1, 2);
            }
        }
        mesh
    }

    /// A convex solid on the plane z = 0 that overhangs on all sides by 45 degrees and more.
    fn overhang() -> Mesh {
        let mut mesh = Mesh::cuboid(DVec3::new(0.3, 0.3, 0.0), DVec3::new(0.5, 0.45, 0.15), 1, false);
        for vertex_m in &mut mesh.vertices_m {
            if vertex_m.z > 0.0 {
                let middle = DVec3::new(0.4, 0.375, vertex_m.z);
                *vertex_m = middle + 2.4 * (*vertex_m - middle);
            }
        }
        mesh
    }

    fn scene(&self) -> Scene {
        let triangles = self.triangles.len();
        Scene {
            title: String::new(),
            path: None,
            materials: vec![Material { name: "grey".into(), bsdf: BsdfParameters::Diffuse { reflectance: 0.5 } }],
            vertices_m: self.vertices_m.clone(),
            triangles: self.triangles.clone(),
            divisions: vec![1; triangles],
            triangle_surfaces: vec![0; triangles],
            surfaces: vec![Surface {
                name: "all".into(),
                geometry: "all".into(),
                material: 0,
                two_sided: false,
                triangles: 0..triangles as u32,
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
}

/// SplitMix64 (Steele, Lea and Flood 2014, "Fast Splittable Pseudorandom Number Generators").
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut word = self.0;
        word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((word ^ (word >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn unit(&mut self) -> DVec3 {
        let z = 2.0 * self.uniform() - 1.0;
        let (sine, cosine) = (std::f64::consts::TAU * self.uniform()).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        DVec3::new(radius * cosine, radius * sine, z)
    }
}
