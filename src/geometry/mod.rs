//! Brute-force stand-in.
use crate::scene::{Scene, Side};
use glam::DVec3;
pub struct Tracer {
    corners: Vec<[DVec3; 3]>,
}
#[derive(Clone, Copy)]
pub struct Origin {
    p: DVec3,
    tri: u32,
}
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    pub triangle: u32,
    pub barycentric: [f64; 2],
    pub side: Side,
    pub distance_m: f64,
}
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Meeting {
    Surface(SurfaceHit),
    Ball(u32),
    Nothing,
}
impl Tracer {
    pub fn new(scene: &Scene) -> Tracer {
        Tracer { corners: (0..scene.triangles.len()).map(|t| scene.corners_m(t as u32)).collect() }
    }
    pub fn free_origin(&self, p: DVec3) -> Origin {
        Origin { p, tri: u32::MAX }
    }
    pub fn side_origin(&self, p: DVec3, n: DVec3) -> Origin {
        Origin { p: p + n * 1e-6, tri: u32::MAX }
    }
    pub fn surface_origin(&self, t: u32, [u, v]: [f64; 2], side: Side) -> Origin {
        let [a, b, c] = self.corners[t as usize];
        let n = (b - a).cross(c - a).normalize() * if side == Side::Front { 1e-6 } else { -1e-6 };
        Origin { p: a + (b - a) * u + (c - a) * v + n, tri: t }
    }
    pub fn ball_origin(&self, _l: u32, p: DVec3) -> Origin {
        self.free_origin(p)
    }
    pub fn position_m(&self, o: &Origin) -> DVec3 {
        o.p
    }
    fn hit(&self, o: &Origin, d: DVec3, tmax: f64) -> Option<SurfaceHit> {
        let mut best: Option<SurfaceHit> = None;
        for (t, [a, b, c]) in self.corners.iter().enumerate() {
            if t as u32 == o.tri {
                continue;
            }
            let (e1, e2) = (*b - *a, *c - *a);
            let h = d.cross(e2);
            let det = e1.dot(h);
            if det == 0.0 {
                continue;
            }
            let s = o.p - *a;
            let u = s.dot(h) / det;
            if !(0.0..=1.0).contains(&u) {
                continue;
            }
            let q = s.cross(e1);
            let v = d.dot(q) / det;
            if v < 0.0 || u + v > 1.0 {
                continue;
            }
            let dist = e2.dot(q) / det;
            if dist > 0.0 && dist < best.map_or(tmax, |b| b.distance_m) {
                best = Some(SurfaceHit {
                    triangle: t as u32,
                    barycentric: [u, v],
                    side: if det > 0.0 { Side::Front } else { Side::Back },
                    distance_m: dist,
                });
            }
        }
        best
    }
    pub fn first_hit(&self, o: &Origin, d: DVec3) -> Meeting {
        self.hit(o, d, f64::INFINITY).map_or(Meeting::Nothing, Meeting::Surface)
    }
    pub fn is_occluded(&self, a: &Origin, b: &Origin) -> bool {
        let d = b.p - a.p;
        let l = d.length();
        self.hit(a, d / l, l * (1.0 - 1e-6)).is_some_and(|h| h.triangle != b.tri)
    }
}
