//! Rays per second on one thread: luxmc's tracer and the standard tree of obvhs (CWBVH, very slow build), on the same triangles and the
//! same incoherent diffuse rays.
//!
//! `cargo bench --bench rays`. Both run in turns over short pieces of the work, and each keeps its best time for each piece. Other work on
//! the machine therefore hardly matters.

use std::hint::black_box;
use std::time::{Duration, Instant};

use glam::{DVec3, Vec3A};
use luxmc::geometry::{Meeting, Origin, SurfaceHit, Tracer};
use luxmc::sampling::random::{Purpose, Stream};
use luxmc::sampling::warp::uniform_sphere;
use luxmc::scene::{BsdfParameters, Material, Scene, Side, Surface};
use obvhs::BvhBuildParams;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::{Ray, RayHit};
use obvhs::triangle::Triangle;

const RAYS: usize = 400_000;
/// Rays timed at once: some milliseconds.
const PIECE: usize = 20_000;
const ROUNDS: usize = 15;
/// Distance from the surface at which the stock tree's rays start, in units of the scene's half-extent.
const STOCK_LIFT: f32 = 1e-6;

fn main() {
    println!("Mrays/s, one thread                luxmc    stock    ratio");
    let asked = std::env::args().skip(1).find(|argument| !argument.starts_with('-')).unwrap_or_default();
    for (name, scene) in [("office", office()), ("hall", hall())] {
        if !name.contains(&asked) {
            continue;
        }
        let rivals = Rivals::new(&scene);
        let triangles = scene.triangles.len();
        let (chains, segments) = rivals.workload();
        let title = |kind: &str| format!("{name} ({triangles}), {kind}");
        report(&title("closest"), &chains, |rays| rivals.closest(rays), |rays| rivals.stock_closest(rays));
        report(&title("occlusion"), &segments, |rays| rivals.occlusion(rays), |rays| rivals.stock_occlusion(rays));
    }
}

/// Runs both in turns over short pieces of the work and prints the rates from the sum of each piece's best time.
fn report<R>(name: &str, work: &[R], luxmc: impl Fn(&[R]) -> u64, stock: impl Fn(&[R]) -> u64) {
    let seconds = |run: &dyn Fn(&[R]) -> u64, piece: &[R]| {
        let start = Instant::now();
        black_box(run(piece));
        start.elapsed().as_secs_f64()
    };
    let mut best = vec![[f64::INFINITY; 2]; work.len().div_ceil(PIECE)];
    for _ in 0..ROUNDS {
        for (piece, best) in work.chunks(PIECE).zip(&mut best) {
            best[0] = best[0].min(seconds(&luxmc, piece));
            best[1] = best[1].min(seconds(&stock, piece));
        }
    }
    let rate = |which: usize| work.len() as f64 / best.iter().map(|best| best[which]).sum::<f64>() * 1e-6;
    println!("{name:<32} {:>7.2}  {:>7.2}  {:>7.2}", rate(0), rate(1), rate(0) / rate(1));
}

struct Rivals {
    tracer: Tracer,
    stock: CwBvh,
    /// Triangles in the order of the stock tree's leaves.
    stock_triangles: Vec<Triangle>,
    /// Front normals of the scene's triangles.
    normals: Vec<DVec3>,
    /// Corners of the scene's triangles in m.
    corners_m: Vec<[DVec3; 3]>,
    scene_center: DVec3,
    scene_scale: f64,
}

/// A ray for both. The stock tree uses coordinates scaled to the scene's half-extent, as f32.
struct Diffuse {
    origin: Origin,
    direction: DVec3,
    stock: Ray,
}

struct Segment {
    from: Origin,
    to: Origin,
    stock: Ray,
}

impl Rivals {
    fn new(scene: &Scene) -> Rivals {
        let low = scene.vertices_m.iter().copied().reduce(DVec3::min).unwrap_or_default();
        let high = scene.vertices_m.iter().copied().reduce(DVec3::max).unwrap_or_default();
        let (scene_center, scene_scale) = (0.5 * (low + high), 2.0 / (high - low).max_element());
        let local = |vertex: u32| ((scene.vertices_m[vertex as usize] - scene_center) * scene_scale).as_vec3a();
        let triangles: Vec<Triangle> = scene
            .triangles
            .iter()
            .map(|corners| corners.map(local))
            .map(|[v0, v1, v2]| Triangle { v0, v1, v2 })
            .collect();
        let stock = build_cwbvh_from_tris(&triangles, BvhBuildParams::very_slow_build(), &mut Duration::default());
        let stock_triangles = stock.primitive_indices.iter().map(|index| triangles[*index as usize]).collect();
        let normals = (0..scene.triangles.len() as u32).map(|triangle| scene.triangle_normal(triangle)).collect();
        let corners_m = (0..scene.triangles.len() as u32).map(|triangle| scene.corners_m(triangle)).collect();
        Rivals { tracer: Tracer::new(scene), stock, stock_triangles, normals, corners_m, scene_center, scene_scale }
    }

    /// Rays of diffuse chains, and segments between vertices of the chains.
    fn workload(&self) -> (Vec<Diffuse>, Vec<Segment>) {
        let mut random = stream(1);
        let mut chains = Vec::with_capacity(RAYS);
        let mut places = Vec::with_capacity(2 * RAYS);
        while chains.len() < RAYS || places.len() < 2 * RAYS {
            let start = self.scene_center + DVec3::new(0.1, 0.2, 0.3);
            let mut origin = self.tracer.free_origin(start);
            let mut direction = uniform_sphere(random.pair());
            for _ in 0..20 {
                let Meeting::Surface(hit) = self.tracer.first_hit(&origin, direction) else { break };
                let normal = self.normal(hit.triangle, hit.side);
                origin = self.tracer.surface_origin(hit.triangle, hit.barycentric, hit.side);
                let place = self.stock_point(self.place_m(&hit)) + normal.as_vec3a() * STOCK_LIFT;
                direction = (normal + uniform_sphere(random.pair())).normalize();
                if chains.len() < RAYS {
                    let stock = Ray::new_inf(place, direction.as_vec3a());
                    chains.push(Diffuse { origin, direction, stock });
                }
                places.push((origin, place));
            }
        }
        let segments = (0..RAYS)
            .map(|index| {
                let [(from, start), (to, end)] = [places[index], places[(index * 7919 + 12345) % places.len()]];
                let stock = Ray::new(start, end - start, 0.0, 1.0 - 1e-5);
                Segment { from, to, stock }
            })
            .collect();
        (chains, segments)
    }

    fn stock_point(&self, point_m: DVec3) -> Vec3A {
        ((point_m - self.scene_center) * self.scene_scale).as_vec3a()
    }

    fn normal(&self, triangle: u32, side: Side) -> DVec3 {
        let normal = self.normals[triangle as usize];
        if side == Side::Front { normal } else { -normal }
    }

    fn place_m(&self, hit: &SurfaceHit) -> DVec3 {
        let [a, b, c] = self.corners_m[hit.triangle as usize];
        a + hit.barycentric[0] * (b - a) + hit.barycentric[1] * (c - a)
    }

    fn closest(&self, rays: &[Diffuse]) -> u64 {
        let met = |ray: &Diffuse| match self.tracer.first_hit(&ray.origin, ray.direction) {
            Meeting::Surface(hit) => u64::from(hit.triangle),
            _ => 0,
        };
        rays.iter().map(met).sum()
    }

    fn stock_closest(&self, rays: &[Diffuse]) -> u64 {
        let met = |ray: &Diffuse| {
            let mut hit = RayHit::none();
            self.stock.ray_traverse(ray.stock, &mut hit, |ray, slot| self.stock_triangles[slot].intersect(ray));
            self.stock.primitive_indices.get(hit.primitive_id as usize).map_or(0, |index| u64::from(*index))
        };
        rays.iter().map(met).sum()
    }

    fn occlusion(&self, segments: &[Segment]) -> u64 {
        segments.iter().filter(|segment| self.tracer.is_occluded(&segment.from, &segment.to)).count() as u64
    }

    fn stock_occlusion(&self, segments: &[Segment]) -> u64 {
        let blocked = |segment: &&Segment| {
            !self.stock.ray_traverse_miss(segment.stock, |ray, slot| self.stock_triangles[slot].intersect(ray))
        };
        segments.iter().filter(blocked).count() as u64
    }
}

/// A room of 8 × 6 × 3 m with desks, screens and cupboards: 300 triangles.
fn office() -> Scene {
    let mut mesh = Mesh::default();
    mesh.cuboid(DVec3::ZERO, DVec3::new(8.0, 6.0, 3.0), true);
    for row in 0..3 {
        for column in 0..2 {
            let corner = DVec3::new(0.8 + 2.4 * f64::from(row), 0.9 + 2.6 * f64::from(column), 0.0);
            let mut part = |low: [f64; 3], high: [f64; 3]| {
                mesh.cuboid(corner + DVec3::from(low), corner + DVec3::from(high), false);
            };
            part([0.0, 0.0, 0.70], [1.6, 0.8, 0.74]);
            part([0.05, 0.05, 0.0], [0.10, 0.75, 0.70]);
            part([1.50, 0.05, 0.0], [1.55, 0.75, 0.70]);
            part([0.5, 0.25, 0.80], [1.1, 0.28, 1.15]);
        }
    }
    mesh.scene()
}

/// Random numbers that follow from a seed.
fn stream(seed: u64) -> Stream {
    Stream::new(seed, Purpose::Pilot, 0, 0)
}

/// A hall of 60 × 40 × 12 m with columns, beams and rows of round machines: some 199,000 triangles.
fn hall() -> Scene {
    let mut mesh = Mesh::default();
    mesh.cuboid(DVec3::ZERO, DVec3::new(60.0, 40.0, 12.0), true);
    let mut random = stream(7);
    for row in 0..23 {
        for column in 0..16 {
            let place = DVec3::new(3.0 + 2.3 * f64::from(row), 2.5 + 2.3 * f64::from(column), 0.0);
            let height = 0.6 + 1.2 * random.fine_unit();
            mesh.cuboid(place - DVec3::new(0.9, 0.7, 0.0), place + DVec3::new(0.9, 0.7, height), false);
            let radius = 0.3 + 0.4 * random.fine_unit();
            mesh.ball(place + DVec3::Z * (height + 1.05 * radius), radius, 12);
        }
    }
    for beam in 0..20 {
        let x = 1.5 + 3.0 * f64::from(beam);
        mesh.cuboid(DVec3::new(x, 0.1, 10.5), DVec3::new(x + 0.3, 39.9, 11.2), false);
    }
    mesh.scene()
}

#[derive(Default)]
struct Mesh {
    vertices_m: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    fn cuboid(&mut self, low: DVec3, high: DVec3, inward: bool) {
        let first = self.vertices_m.len() as u32;
        for corner in 0..8 {
            let pick = |axis: usize| if corner >> axis & 1 == 1 { high[axis] } else { low[axis] };
            self.vertices_m.push(DVec3::new(pick(0), pick(1), pick(2)));
        }
        for [a, b, c, d] in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            for [a, b, c] in [[a, b, c], [a, c, d]] {
                let [a, b, c] = if inward { [a, c, b] } else { [a, b, c] };
                self.triangles.push([a, b, c].map(|corner| first + corner));
            }
        }
    }

    /// A ball of rings: `rings` from pole to pole and twice as many around.
    fn ball(&mut self, center: DVec3, radius: f64, rings: u32) {
        let first = self.vertices_m.len() as u32;
        let around = 2 * rings;
        let index = |ring: u32, step: u32| match ring {
            0 => first,
            _ if ring == rings => first + 1,
            _ => first + 2 + (ring - 1) * around + step % around,
        };
        self.vertices_m.extend([center + DVec3::Z * radius, center - DVec3::Z * radius]);
        for ring in 1..rings {
            let (sine, cosine) = (std::f64::consts::PI * f64::from(ring) / f64::from(rings)).sin_cos();
            for step in 0..around {
                let (y, x) = (std::f64::consts::TAU * f64::from(step) / f64::from(around)).sin_cos();
                self.vertices_m.push(center + radius * DVec3::new(sine * x, sine * y, cosine));
            }
        }
        for ring in 0..rings {
            for step in 0..around {
                let [a, b, c, d] =
                    [index(ring, step), index(ring + 1, step), index(ring + 1, step + 1), index(ring, step + 1)];
                if ring + 1 < rings {
                    self.triangles.push([a, b, c]);
                }
                if ring > 0 {
                    self.triangles.push([a, c, d]);
                }
            }
        }
    }

    fn scene(self) -> Scene {
        let triangles = self.triangles.len();
        Scene {
            title: String::new(),
            path: None,
            materials: vec![Material { name: "grey".into(), bsdf: BsdfParameters::Diffuse { reflectance: 0.5 } }],
            vertices_m: self.vertices_m,
            triangles: self.triangles,
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
