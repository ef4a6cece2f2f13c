//! The truths of this room that need no large run.

use glam::DVec3;

use super::{Meeting, Tracer};
use crate::scene::{Material, ReflectionLaw, Scene, Side, Surface};

fn scene_of(vertices_m: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Scene {
    let count = triangles.len();
    Scene {
        title: String::new(),
        path: None,
        materials: vec![Material { name: "grey".into(), law: ReflectionLaw::Diffuse { reflectance: 0.5 } }],
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
        warnings: vec![],
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
