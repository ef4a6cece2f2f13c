//! Direct light in a room without obstacles: at points, and as means over triangles and rectangles.

use glam::DVec3;

use super::faces::{RoomFace, triangle_rule};
use super::room::{BoxedRoom, Lamp};
use super::sources::RoomSource;

/// A quadrature subdivides its triangle until the mean changes by less than this relative amount.
const TOLERANCE: f64 = 1e-4;
/// Maximum number of halvings of a triangle's edges.
const MOST_HALVINGS: u32 = 4;

impl BoxedRoom {
    /// Direct illuminance in lx at a point with a unit normal, in the room's coordinates; exact. `own` is the face on which the
    /// point lies. Luminaires flush with this face contribute nothing.
    pub fn direct_at_lx(&self, position: DVec3, normal: DVec3, own: Option<RoomFace>) -> f64 {
        self.lamps.iter().map(|lamp| self.lamp_at_lx(lamp, position, normal, own)).sum()
    }

    fn lamp_at_lx(&self, lamp: &Lamp, position: DVec3, normal: DVec3, own: Option<RoomFace>) -> f64 {
        match lamp {
            Lamp::Source(source) if is_flush(source, own) => 0.0,
            Lamp::Source(source) => source.at_point_lx(self.size_m, position, normal),
            Lamp::Directed(_, face) if face.is_some() && *face == own => 0.0,
            Lamp::Directed(emitter, _) => emitter.unshadowed_lx(position + self.corner_m, normal),
        }
    }

    /// Mean direct illuminance in lx over a triangle of a face, and its estimated error. Exact for isotropic points.
    pub fn direct_over_triangle_lx(&self, face: RoomFace, corners: [DVec3; 3]) -> (f64, f64) {
        let area_m2 = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).length();
        let lamp_lx = |lamp: &Lamp| match lamp {
            Lamp::Source(source @ RoomSource::Point { .. }) => {
                (source.triangle_mean_lx(self.size_m, face, corners, area_m2), 0.0)
            }
            _ => self.integrated_lx(lamp, face, corners),
        };
        self.lamps.iter().map(lamp_lx).fold((0.0, 0.0), |sum, one| (sum.0 + one.0, sum.1 + one.1))
    }

    /// Mean direct illuminance in lx over a rectangle of a face. Exact for isotropic points and panels.
    pub fn direct_over_rectangle_lx(&self, face: RoomFace, stretches: [[f64; 2]; 2]) -> f64 {
        let lamp_lx = |lamp: &Lamp| match lamp {
            Lamp::Source(source) => source.rectangle_mean_lx(self.size_m, face, stretches),
            Lamp::Directed(..) => {
                let [a, b, c, d] = face.corners(self.size_m, stretches);
                let first_lx = self.integrated_lx(lamp, face, [a, b, c]).0;
                0.5 * (first_lx + self.integrated_lx(lamp, face, [a, c, d]).0)
            }
        };
        self.lamps.iter().map(lamp_lx).sum()
    }

    fn integrated_lx(&self, lamp: &Lamp, face: RoomFace, corners: [DVec3; 3]) -> (f64, f64) {
        let flush = match lamp {
            Lamp::Source(source) => is_flush(source, Some(face)),
            Lamp::Directed(_, own) => *own == Some(face),
        };
        if flush {
            return (0.0, 0.0);
        }
        let at = |position: DVec3| self.lamp_at_lx(lamp, position, face.normal(), Some(face));
        halved(corners, by_rule(corners, &at), MOST_HALVINGS, &at)
    }
}

fn is_flush(source: &RoomSource, own: Option<RoomFace>) -> bool {
    matches!(source, RoomSource::Panel { face, .. } if own == Some(*face))
}

fn by_rule([a, b, c]: [DVec3; 3], at: &impl Fn(DVec3) -> f64) -> f64 {
    let place = |[along, across]: [f64; 2]| a + (b + (c - b) * across - a) * along;
    triangle_rule().iter().map(|(node, weight)| weight * at(place(*node))).sum()
}

/// The mean over a triangle from its four quarters, and the difference between the quarters and the whole.
fn halved([a, b, c]: [DVec3; 3], whole: f64, halvings: u32, at: &impl Fn(DVec3) -> f64) -> (f64, f64) {
    let [ab, bc, ca] = [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)];
    let quarters = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]];
    let means = quarters.map(|quarter| by_rule(quarter, at));
    let mean = 0.25 * means.iter().sum::<f64>();
    let change = (mean - whole).abs();
    if change <= TOLERANCE * mean || halvings == 0 {
        return (mean, change);
    }
    let finer = [0, 1, 2, 3].map(|i| halved(quarters[i], means[i], halvings - 1, at));
    (0.25 * finer.iter().map(|f| f.0).sum::<f64>(), 0.25 * finer.iter().map(|f| f.1).sum::<f64>())
}
