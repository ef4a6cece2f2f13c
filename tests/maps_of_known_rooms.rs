use glam::DVec3;
use luxmc::scene::*;
use luxmc::solver::*;

struct Silent;
impl Observer for Silent {
    fn progress(&self, _: &Progress) {}
    fn is_interrupted(&self) -> bool {
        false
    }
    fn wall_s(&self) -> f64 {
        0.0
    }
}

fn cube(reflectance: f64, divisions: u32) -> Scene {
    let v: Vec<DVec3> =
        (0..8).map(|i| DVec3::new((i & 1) as f64, ((i >> 1) & 1) as f64, ((i >> 2) & 1) as f64) * 4.0).collect();
    let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let mut triangles = vec![];
    for q in quads {
        triangles.push([q[0], q[1], q[2]]);
        triangles.push([q[0], q[2], q[3]]);
    }
    let scene = Scene {
        title: String::new(),
        path: None,
        materials: vec![Material { name: "m".into(), law: ReflectionLaw::Diffuse { reflectance } }],
        vertices_m: v,
        divisions: vec![divisions; 12],
        triangle_surfaces: vec![0; 12],
        triangles,
        surfaces: vec![Surface {
            name: "cube".into(),
            geometry: "cube".into(),
            material: 0,
            two_sided: false,
            triangles: 0..12,
        }],
        luminaires: vec![Luminaire {
            name: "l".into(),
            luminous_flux_lm: 10000.0,
            dimming: 1.0,
            maintenance_factor: 1.0,
            power_w: None,
            emission: Emission::Isotropic {
                position_m: DVec3::splat(2.0),
                intensity_cd: 10000.0 / (4.0 * std::f64::consts::PI),
            },
        }],
        receivers: vec![ReceiverSet {
            name: "p".into(),
            layout: ReceiverLayout::Points,
            points: vec![ReceiverPoint {
                position_m: DVec3::new(2.0, 2.0, 0.0),
                normal: DVec3::Z,
                weight: 1.0,
                inside: false,
            }],
        }],
        warnings: vec![],
    };
    scene
}

#[test]
fn cube_() {
    for rho in [0.5, 0.8, 0.95] {
        let scene = cube(rho, 16);
        let t = std::time::Instant::now();
        let s = solve(
            &scene,
            &Settings {
                seed: 0,
                target_error: Some(0.05),
                chains: None,
                time_limit_s: None,
                maps: MapSelection::All,
                threads: None,
            },
            &Silent,
        );
        println!(
            "{rho} chains {} rays {} err {} met {:?} k {:?} t {:?} {:?}",
            s.chains,
            s.rays,
            s.estimated_error,
            s.target_met,
            s.maps[0].error,
            t.elapsed(),
            s.map_check
        );
        for m in &s.maps {
            for r in &m.tables {
                println!(
                    "{} avg {:?} min {:?} max {} u0 {:?}",
                    r.name, r.average_lx, r.minimum_lx, r.maximum_lx, r.uniformity_u0
                );
            }
        }
        println!("{:?}", s.convergence.last());
        println!(
            "direct {} indirect {} expected ind {}",
            s.maps[1].values.direct_lx[0],
            s.maps[1].values.indirect_lx[0],
            rho * 10000. / (96. * (1. - rho))
        );
        let m = &s.maps[0].values;
        println!(
            "mean direct {} mean ind {}",
            m.direct_lx.iter().sum::<f64>() / 3072.0,
            m.indirect_lx.iter().sum::<f64>() / 3072.
        );
    }
}
#[test]
fn escapes() {
    use luxmc::geometry::*;
    let scene = cube(0.5, 1);
    let tracer = Tracer::new(&scene);
    let o = tracer.free_origin(DVec3::splat(2.0));
    let mut n = 0;
    let mut esc = 0;
    for i in 0..1000 {
        for j in 0..100 {
            let z = 1.0 - 2.0 * (i as f64 + 0.5) / 1000.0;
            let p = (j as f64) * 0.0628;
            let r = (1.0 - z * z).sqrt();
            n += 1;
            if tracer.first_hit(&o, DVec3::new(r * p.cos(), r * p.sin(), z)) == Meeting::Nothing {
                esc += 1;
            }
        }
    }
    println!("{n} {esc}");
    let m = tracer.first_hit(&o, DVec3::new(0.1, 0.2, -0.9746794344808963));
    println!("{m:?}");
}
#[test]
fn speed() {
    let scene = cube(0.8, 16);
    let t = std::time::Instant::now();
    let s = solve(
        &scene,
        &Settings {
            seed: 0,
            target_error: None,
            chains: Some(2_000_000),
            time_limit_s: None,
            maps: MapSelection::Elements,
            threads: None,
        },
        &Silent,
    );
    println!(
        "chains {} rays {} compute {} M rays/s {} err {}",
        s.chains,
        s.rays,
        s.compute_s,
        s.rays as f64 / s.compute_s / 1e6,
        s.estimated_error
    );
    println!("{:?}", t.elapsed());
}
