//! Points of a luminous opening. The light of a direction leaves the parts that face that direction, in proportion to projected area: I(ω)
//! (n·ω)⁺ dA/A_projected(ω). Then the far field equals the photometric file, and a box sends no light through itself (docs/methods.md
//! (17)).

mod seen;
#[cfg(test)]
mod tests;

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::random::Stream;
use super::triangle::RisenTriangle;
use super::warp::{sin_cos_of_turns, tangents, uniform_sphere};
use crate::base::polygon::triangle_illuminance_factor;
use crate::scene::photometry::Opening;

/// Steps of the sum that gives the perimeter of an ellipse. For a periodic function this is more than exact enough.
const PERIMETER_STEPS: usize = 256;
/// Largest number of draws of a rejection loop. For an ellipse or an ellipsoid with sides 1 : 100, at least 1 draw in 64 is kept on
/// average.
const MOST_DRAWS: u32 = 20_000;
/// For a rectangle nearer than this, over half its diagonal, light samples are drawn by solid angle as well as by area.
const NEAR_HALF_DIAGONALS: f64 = 6.0;
/// Share of these light samples that are drawn by solid angle.
const BY_SOLID_ANGLE: f64 = 0.9;

/// A point of a luminous opening.
#[derive(Clone, Copy, Debug)]
pub struct OpeningPoint {
    /// Position in m.
    pub position_m: DVec3,
    /// Outward unit normal of a solid's surface at the point. `None` for a flat opening, which shows either all of itself or nothing.
    pub face: Option<DVec3>,
}

/// A luminous opening at its position in the scene.
#[derive(Clone, Debug)]
pub struct Aperture {
    center_m: DVec3,
    shape: ApertureShape,
    /// Area of its surface in m².
    surface_m2: f64,
}

/// Shapes by their vectors from the centre to the rim, in m.
#[derive(Clone, Copy, Debug)]
enum ApertureShape {
    /// A parallelogram.
    Flat([DVec3; 2]),
    /// A flat ellipse.
    Ellipse([DVec3; 2]),
    /// A box, all six faces.
    Box([DVec3; 3]),
    /// An elliptic cylinder with both ends: two half axes across, half its length.
    Cylinder { half_axes_m: [DVec3; 3], barrel_share: f64 },
    /// An ellipsoid by its half axes.
    Ellipsoid([DVec3; 3]),
}

impl Aperture {
    /// Places an opening in the scene. `frame` holds the unit vectors of C0, C90 and γ = 0. `None` for an opening without extent.
    pub fn new(opening: &Opening, center_m: DVec3, frame: &[DVec3; 3]) -> Option<Aperture> {
        let [c0, c90, axis] = *frame;
        let half = |extent_m: f64, along: DVec3| 0.5 * extent_m * along;
        let shape = match *opening {
            Opening::Point => return None,
            Opening::Rectangle { c0_m, c90_m } => ApertureShape::Flat([half(c0_m, c0), half(c90_m, c90)]),
            Opening::Box { c0_m, c90_m, height_m } => {
                ApertureShape::Box([half(c0_m, c0), half(c90_m, c90), half(height_m, axis)])
            }
            Opening::Disk { diameter_m } => ApertureShape::Ellipse([half(diameter_m, c0), half(diameter_m, c90)]),
            Opening::Ellipse { c0_m, c90_m, height_m: 0.0 } => {
                ApertureShape::Ellipse([half(c0_m, c0), half(c90_m, c90)])
            }
            Opening::UprightEllipse { width_m, height_m } => {
                ApertureShape::Ellipse([half(width_m, c90), half(height_m, axis)])
            }
            Opening::Ellipse { c0_m, c90_m, height_m } => {
                cylinder([half(c0_m, c0), half(c90_m, c90), half(height_m, axis)])
            }
            Opening::VerticalCylinder { diameter_m, height_m } => {
                cylinder([half(diameter_m, c0), half(diameter_m, c90), half(height_m, axis)])
            }
            Opening::HorizontalCylinder { along_c0: true, length_m, width_m, height_m } => {
                cylinder([half(width_m, c90), half(height_m, axis), half(length_m, c0)])
            }
            Opening::HorizontalCylinder { along_c0: false, length_m, width_m, height_m } => {
                cylinder([half(width_m, c0), half(height_m, axis), half(length_m, c90)])
            }
            Opening::Sphere { diameter_m } => {
                ApertureShape::Ellipsoid([half(diameter_m, c0), half(diameter_m, c90), half(diameter_m, axis)])
            }
            Opening::Ellipsoid { c0_m, c90_m, height_m } => {
                ApertureShape::Ellipsoid([half(c0_m, c0), half(c90_m, c90), half(height_m, axis)])
            }
        };
        let aperture = Aperture { center_m, surface_m2: surface_m2(&shape), shape };
        (aperture.radius_m() > 0.0).then_some(aperture)
    }

    /// Radius of a ball about the centre that holds the opening, in m.
    pub fn radius_m(&self) -> f64 {
        match &self.shape {
            ApertureShape::Flat(half) => half.iter().map(|h| h.length_squared()).sum::<f64>().sqrt(),
            ApertureShape::Box(half) | ApertureShape::Cylinder { half_axes_m: half, .. } => {
                half.iter().map(|h| h.length_squared()).sum::<f64>().sqrt()
            }
            ApertureShape::Ellipse(half) => half.iter().map(|h| h.length()).fold(0.0, f64::max),
            ApertureShape::Ellipsoid(half) => half.iter().map(|h| h.length()).fold(0.0, f64::max),
        }
    }

    /// Returns half of the length along a unit direction that contains the opening, about its centre, in m.
    pub fn half_extent_m(&self, along: DVec3) -> f64 {
        let reach_m = |half: &[DVec3]| half.iter().map(|half| half.dot(along).abs()).sum();
        match &self.shape {
            ApertureShape::Flat(half) | ApertureShape::Ellipse(half) => reach_m(half),
            ApertureShape::Box(half)
            | ApertureShape::Ellipsoid(half)
            | ApertureShape::Cylinder { half_axes_m: half, .. } => reach_m(half),
        }
    }

    /// Draws a point uniformly over the opening's surface.
    pub fn draw(&self, stream: &mut Stream) -> OpeningPoint {
        match &self.shape {
            ApertureShape::Flat(half) => self.flat(draw_flat(half, stream)),
            ApertureShape::Ellipse(half) => self.flat(draw_disk(half, stream)),
            ApertureShape::Box(half) => {
                let [a, b, c] = half.map(DVec3::length);
                let fixed = pick([b * c, c * a, a * b], stream);
                let end = if stream.unit() < 0.5 { -1.0 } else { 1.0 };
                self.on_face(half, fixed, end, stream)
            }
            ApertureShape::Cylinder { half_axes_m: half @ [a, b, along], barrel_share } => {
                if stream.unit() < *barrel_share {
                    let turn = draw_rim_rad(a, b, stream);
                    self.on_barrel(half, turn, stream)
                } else {
                    let end = if stream.unit() < 0.5 { -1.0 } else { 1.0 };
                    self.solid(draw_disk(&[*a, *b], stream) + end * *along, end * *along)
                }
            }
            ApertureShape::Ellipsoid(half) => self.on_ellipsoid(half, draw_ellipsoid(half, stream)),
        }
    }

    /// Draws a point uniformly over the projected area that the opening shows in a direction of emission.
    pub fn draw_towards(&self, direction: DVec3, stream: &mut Stream) -> OpeningPoint {
        let facing = |axis: DVec3| if axis.dot(direction) < 0.0 { -1.0 } else { 1.0 };
        match &self.shape {
            ApertureShape::Flat(_) | ApertureShape::Ellipse(_) => self.draw(stream),
            ApertureShape::Box(half @ [a, b, c]) => {
                let shown = [b.cross(*c), c.cross(*a), a.cross(*b)].map(|face| face.dot(direction).abs());
                let fixed = pick(shown, stream);
                // Where an axis has zero length, its faces lie in the plane of the other two axes.
                let normal = half[(fixed + 1) % 3].cross(half[(fixed + 2) % 3]);
                let outward = if normal.dot(half[fixed]) < 0.0 { -normal } else { normal };
                self.on_face(half, fixed, facing(outward), stream)
            }
            ApertureShape::Cylinder { half_axes_m: half @ [a, b, along], .. } => {
                let ends = PI * a.cross(*b).dot(direction).abs();
                let [across_a, across_b] = barrel_faces(half).map(|face| face.dot(direction));
                let barrel = 4.0 * across_a.hypot(across_b);
                if stream.unit() * (ends + barrel) < barrel {
                    // (n·ω)⁺ follows the cosine of the turn, counted from where the barrel faces the direction most.
                    let [u, v] = stream.pair();
                    let turn = across_b.atan2(across_a) + (2.0 * u - 1.0).asin();
                    self.on_barrel_at(half, turn, v)
                } else {
                    let end = facing(*along) * *along;
                    self.solid(draw_disk(&[*a, *b], stream) + end, end)
                }
            }
            ApertureShape::Ellipsoid(half) => {
                // In units of the half axes the ellipsoid is a ball. One half of it is visible and is drawn by its disk.
                let scaled = half.map(|axis| axis.dot(direction) / axis.length_squared().max(f64::MIN_POSITIVE));
                let towards = DVec3::from(scaled).normalize_or(DVec3::Z);
                let [one, other] = tangents(towards);
                let [u, v] = stream.pair();
                let (sin, cos) = sin_cos_of_turns(v);
                let on_ball = u.sqrt() * (cos * one + sin * other) + (1.0 - u).sqrt() * towards;
                self.on_ellipsoid(half, on_ball)
            }
        }
    }

    /// Returns how much a uniformly drawn surface point sends in a direction, relative to the mean of all points.
    pub fn share_towards(&self, point: &OpeningPoint, direction: DVec3) -> f64 {
        let Some(face) = point.face else {
            return 1.0;
        };
        let shown = face.dot(direction).max(0.0);
        if shown > 0.0 { self.surface_m2 * shown / self.projected_area_m2(direction) } else { 0.0 }
    }

    fn flat(&self, offset_m: DVec3) -> OpeningPoint {
        OpeningPoint { position_m: self.center_m + offset_m, face: None }
    }

    fn solid(&self, offset_m: DVec3, outward: DVec3) -> OpeningPoint {
        OpeningPoint { position_m: self.center_m + offset_m, face: outward.try_normalize() }
    }

    /// Draws a point on one face of a box. `fixed` is the axis of the face and `end` is −1 or 1.
    fn on_face(&self, half: &[DVec3; 3], fixed: usize, end: f64, stream: &mut Stream) -> OpeningPoint {
        let (one, other) = (half[(fixed + 1) % 3], half[(fixed + 2) % 3]);
        let normal = one.cross(other);
        let outward = if normal.dot(half[fixed]) < 0.0 { -normal } else { normal };
        self.solid(end * half[fixed] + draw_flat(&[one, other], stream), end * outward)
    }

    fn on_barrel(&self, half: &[DVec3; 3], turn: f64, stream: &mut Stream) -> OpeningPoint {
        let along = stream.unit();
        self.on_barrel_at(half, turn, along)
    }

    /// Returns the point of a barrel at a turn in radians from its first axis and at a share of its length.
    fn on_barrel_at(&self, half: &[DVec3; 3], turn: f64, along: f64) -> OpeningPoint {
        let [a, b, axis] = *half;
        let (sin, cos) = turn.sin_cos();
        let [across_a, across_b] = barrel_faces(half);
        self.solid(cos * a + sin * b + (2.0 * along - 1.0) * axis, cos * across_a + sin * across_b)
    }

    /// Returns the point of an ellipsoid that corresponds to a point of the unit ball, in units of the half axes.
    fn on_ellipsoid(&self, half: &[DVec3; 3], on_ball: DVec3) -> OpeningPoint {
        let shares = on_ball.to_array();
        let offset_m = (0..3).map(|axis| shares[axis] * half[axis]).sum();
        let outward = (0..3).map(|axis| shares[axis] * half[axis] / half[axis].length_squared()).sum();
        self.solid(offset_m, outward)
    }

    /// Draws one light sample from a point with a unit normal: illuminance in lx and the point of the opening. The mean over all samples is
    /// the unshadowed illuminance from the opening. `intensity_cd` returns the intensity towards a direction.
    ///
    /// For a flat opening sampled by area, the score is I cos θ/d². For a solid opening, points are drawn by how they face the receiver's
    /// direction from the centre. They are weighted by how they face the receiver itself. A near rectangle is sampled by projected solid
    /// angle as well. The two are combined by their densities (Veach and Guibas 1995). Then near a Lambertian rectangle no score is far
    /// from the mean.
    pub fn light_sample(
        &self,
        point_m: DVec3,
        normal: DVec3,
        intensity_cd: impl Fn(DVec3) -> f64,
        stream: &mut Stream,
    ) -> Option<(f64, DVec3)> {
        let score = |at_m: DVec3, shown: &dyn Fn(DVec3) -> f64| {
            let offset_m = at_m - point_m;
            let distance_squared = offset_m.length_squared();
            let height_m = offset_m.dot(normal);
            if height_m <= 0.0 {
                return None;
            }
            let shown = shown(-offset_m / distance_squared.sqrt());
            if shown <= 0.0 {
                return None;
            }
            let lx = shown * intensity_cd(-offset_m) * height_m / (distance_squared * distance_squared.sqrt());
            (lx > 0.0).then_some((lx, at_m))
        };
        let Some(near) = self.near_rectangle(point_m, normal) else {
            let towards = (point_m - self.center_m).normalize_or(normal);
            let at = self.draw_towards(towards, stream);
            let Some(face) = at.face else {
                return score(at.position_m, &|_| 1.0);
            };
            // A part that faces the receiver itself also faces the receiver's direction from the centre.
            let density = face.dot(towards) / self.projected_area_m2(towards);
            return score(at.position_m, &|shining| {
                face.dot(shining).max(0.0) / (density * self.projected_area_m2(shining))
            });
        };
        let by_area = |stream: &mut Stream| self.draw(stream).position_m;
        let at_m = if stream.unit() < BY_SOLID_ANGLE { near.draw(normal, stream)? } else { by_area(stream) };
        let (lx, at_m) = score(at_m, &|_| 1.0)?;
        // Density by solid angle divided by the density by area: A cos θ cos θ′/(d² F), with F the projected solid angle.
        let offset_m = at_m - point_m;
        let cosines = offset_m.dot(normal) * offset_m.dot(near.face).abs();
        let ratio = near.area_m2 * cosines / (offset_m.length_squared().powi(2) * near.projected_sr);
        Some((lx / (1.0 - BY_SOLID_ANGLE + BY_SOLID_ANGLE * ratio), at_m))
    }

    /// Returns a rectangle that is near and at least partly above the horizon, as two triangles.
    fn near_rectangle(&self, point_m: DVec3, normal: DVec3) -> Option<NearRectangle> {
        let ApertureShape::Flat([a, b]) = self.shape else {
            return None;
        };
        let twice_quarter = a.cross(b);
        let offset_m = self.center_m - point_m;
        let reach_m = NEAR_HALF_DIAGONALS * self.radius_m();
        if twice_quarter == DVec3::ZERO || offset_m.length_squared() > reach_m * reach_m {
            return None;
        }
        // The corners run counter-clockwise as seen from the point.
        let b = if offset_m.dot(twice_quarter) < 0.0 { b } else { -b };
        let corners_m = [-a - b, a - b, a + b, b - a].map(|corner| self.center_m + corner);
        let triangles_m = [[corners_m[0], corners_m[1], corners_m[2]], [corners_m[0], corners_m[2], corners_m[3]]];
        let projected = triangles_m.map(|corners_m| PI * triangle_illuminance_factor(point_m, normal, corners_m));
        let projected_sr = projected[0] + projected[1];
        (projected_sr > 0.0).then(|| NearRectangle {
            triangles: triangles_m.map(|corners_m| corners_m.map(|corner_m| corner_m - point_m)),
            first_share: projected[0] / projected_sr,
            projected_sr,
            area_m2: 4.0 * twice_quarter.length(),
            face: twice_quarter.normalize(),
            point_m,
        })
    }
}

/// A rectangle as seen from a near point.
struct NearRectangle {
    triangles: [[DVec3; 3]; 2],
    first_share: f64,
    projected_sr: f64,
    area_m2: f64,
    face: DVec3,
    point_m: DVec3,
}

impl NearRectangle {
    /// Draws a point in proportion to projected solid angle.
    fn draw(&self, normal: DVec3, stream: &mut Stream) -> Option<DVec3> {
        let corners = self.triangles[usize::from(stream.unit() >= self.first_share)];
        let (_, [u, v]) = RisenTriangle::new(corners, normal)?.draw(stream)?;
        let [a, b, c] = corners;
        Some(self.point_m + a + u * (b - a) + v * (c - a))
    }
}

fn cylinder(half_axes_m: [DVec3; 3]) -> ApertureShape {
    let [a, b, along] = half_axes_m;
    let speed = |step: usize| {
        let (sin, cos) = (TAU * (step as f64 + 0.5) / PERIMETER_STEPS as f64).sin_cos();
        (cos * b - sin * a).length()
    };
    let perimeter_m = (0..PERIMETER_STEPS).map(speed).sum::<f64>() * TAU / PERIMETER_STEPS as f64;
    let barrel_m2 = perimeter_m * 2.0 * along.length();
    let ends_m2 = TAU * a.length() * b.length();
    let barrel_share = if barrel_m2 + ends_m2 > 0.0 { barrel_m2 / (barrel_m2 + ends_m2) } else { 1.0 };
    ApertureShape::Cylinder { half_axes_m, barrel_share }
}

/// Returns the area of a shape in m²; for a flat shape, the area of one side.
fn surface_m2(shape: &ApertureShape) -> f64 {
    match shape {
        ApertureShape::Flat([a, b]) => 4.0 * a.cross(*b).length(),
        ApertureShape::Ellipse([a, b]) => PI * a.cross(*b).length(),
        ApertureShape::Box([a, b, c]) => 8.0 * (a.cross(*b).length() + b.cross(*c).length() + c.cross(*a).length()),
        ApertureShape::Cylinder { half_axes_m: [a, b, _], barrel_share } => {
            TAU * a.cross(*b).length() / (1.0 - barrel_share).max(f64::MIN_POSITIVE)
        }
        ApertureShape::Ellipsoid(half) => ellipsoid_m2(half),
    }
}

/// Chooses one of three in proportion to their weights.
fn pick(weights: [f64; 3], stream: &mut Stream) -> usize {
    let mut aim = stream.unit() * weights.iter().sum::<f64>();
    let found = weights[..2].iter().position(|weight| {
        let found = aim < *weight;
        aim -= weight;
        found
    });
    found.unwrap_or(2)
}

fn draw_flat([a, b]: &[DVec3; 2], stream: &mut Stream) -> DVec3 {
    let [u, v] = stream.pair();
    (2.0 * u - 1.0) * *a + (2.0 * v - 1.0) * *b
}

fn draw_disk([a, b]: &[DVec3; 2], stream: &mut Stream) -> DVec3 {
    let [u, v] = stream.pair();
    let (sin, cos) = sin_cos_of_turns(v);
    u.sqrt() * (cos * *a + sin * *b)
}

/// Returns outward vectors of a barrel at its first and its second axis. Their lengths are the barrel's half width times its half length.
fn barrel_faces([a, b, along]: &[DVec3; 3]) -> [DVec3; 2] {
    let turned = if a.cross(*b).dot(*along) < 0.0 { -1.0 } else { 1.0 };
    [turned * b.cross(*along), -turned * a.cross(*along)]
}

/// Draws a turn in radians so that the point on an ellipse's rim is uniform along the rim. It draws the angle and rejects by the speed.
fn draw_rim_rad(a: &DVec3, b: &DVec3, stream: &mut Stream) -> f64 {
    let largest = a.length().max(b.length());
    let mut turn = 0.0;
    for _ in 0..MOST_DRAWS {
        turn = TAU * stream.unit();
        let (sin, cos) = turn.sin_cos();
        if stream.unit() * largest < (cos * *b - sin * *a).length() {
            break;
        }
    }
    turn
}

/// Returns the area of an ellipsoid in m²: the mean area stretch over the unit ball, in equal steps of height and turn.
fn ellipsoid_m2(half: &[DVec3; 3]) -> f64 {
    let [a, b, c] = half.map(DVec3::length);
    let stretches = DVec3::new(b * c, c * a, a * b);
    let steps = PERIMETER_STEPS as f64;
    let at = |row: usize, column: usize| {
        let height = 2.0 * (row as f64 + 0.5) / steps - 1.0;
        let (sin, cos) = (TAU * (column as f64 + 0.5) / steps).sin_cos();
        let across = (1.0 - height * height).sqrt();
        (DVec3::new(across * cos, across * sin, height) * stretches).length()
    };
    let sum: f64 = (0..PERIMETER_STEPS).flat_map(|row| (0..PERIMETER_STEPS).map(move |column| at(row, column))).sum();
    4.0 * PI * sum / (steps * steps)
}

/// Draws a point of the unit ball whose image on an ellipsoid is uniform over its area. It rejects by the local area stretch.
fn draw_ellipsoid(half: &[DVec3; 3], stream: &mut Stream) -> DVec3 {
    let [a, b, c] = half.map(DVec3::length);
    let stretches = DVec3::new(b * c, c * a, a * b);
    let largest = stretches.max_element();
    let mut on_sphere = DVec3::Z;
    for _ in 0..MOST_DRAWS {
        on_sphere = uniform_sphere(stream.pair());
        if largest <= 0.0 || stream.unit() * largest < (on_sphere * stretches).length() {
            break;
        }
    }
    on_sphere
}
