//! Direct light by shadow rays from the receiver: what a mesh is checked against, and what completes a run where it is
//! the cheaper way.

use glam::DVec3;

use super::mesh::Surroundings;
use crate::chain::Stage;
use crate::estimators::receiver::Receiver;
use crate::geometry::Origin;
use crate::sampling::random::Stream;
use crate::sampling::warp::uniform_triangle;
use crate::scene::{ElementSide, ReceiverPoint};

/// One unbiased sample of direct illuminance by a look at every emitter, exact where all are points, and its rays.
pub fn look_at_all(stage: &Stage, receiver: &Receiver, stream: &mut Stream) -> (f64, u64) {
    let (mut sum_lx, mut rays) = (0.0, 0);
    for emitter in stage.emitters.list() {
        let Some(look) = emitter.light_sample(receiver.point_m, receiver.normal, stream) else { continue };
        rays += 1;
        if let Some(place) = look.place {
            sum_lx += look.unshadowed_lx * stage.transmittance(receiver.origin, &stage.origin(&place));
        }
    }
    (sum_lx, rays)
}

/// Whether looks at all emitters have no chance in them.
pub fn looks_are_exact(stage: &Stage) -> bool {
    stage.emitters.list().iter().all(|emitter| emitter.is_single_point())
}

/// A place of a map at which light is asked for.
#[derive(Clone, Copy)]
pub struct MeshPlace {
    /// Place in m.
    pub point_m: DVec3,
    /// Unit normal.
    pub normal: DVec3,
    /// Where its rays start.
    start: RayStart,
}

/// Where the rays of a spot start.
#[derive(Clone, Copy)]
enum RayStart {
    /// On the side of whatever surface it lies on that its normal points to.
    Side,
    /// On an element side, at these weights of the triangle's corners.
    Element(ElementSide, [f64; 2]),
    /// Known from the ray that met the surface.
    At(Origin),
}

impl MeshPlace {
    /// A receiver.
    pub fn of_point(point: &ReceiverPoint) -> MeshPlace {
        MeshPlace { point_m: point.position_m, normal: point.normal, start: RayStart::Side }
    }

    /// A place on a surface that a ray has met.
    pub fn at_origin(point_m: DVec3, normal: DVec3, origin: Origin) -> MeshPlace {
        MeshPlace { point_m, normal, start: RayStart::At(origin) }
    }

    /// A point of an element side by the weights of the element's second and third corner.
    pub fn of_element(around: &Surroundings, element: ElementSide, [u, v]: [f64; 2]) -> MeshPlace {
        let part = around.stage.elements.corners(&element);
        let inner = [0, 1].map(|k| part[0][k] + u * (part[1][k] - part[0][k]) + v * (part[2][k] - part[0][k]));
        let [a, b, c] = around.scene.corners_m(element.triangle);
        MeshPlace {
            point_m: a + inner[0] * (b - a) + inner[1] * (c - a),
            normal: around.stage.normal(element.triangle, element.side),
            start: RayStart::Element(element, inner),
        }
    }

    /// A random point of an element side, every part of its area alike.
    pub fn drawn_in_element(around: &Surroundings, element: ElementSide, stream: &mut Stream) -> MeshPlace {
        MeshPlace::of_element(around, element, uniform_triangle(stream.pair()))
    }

    /// Hands the spot to `ask` as a receiver.
    #[inline]
    pub fn ask<T>(&self, stage: &Stage, ask: impl FnOnce(&Receiver) -> T) -> T {
        let origin = match self.start {
            RayStart::Side => stage.tracer.side_origin(self.point_m, self.normal),
            RayStart::Element(element, inner) => stage.tracer.surface_origin(element.triangle, inner, element.side),
            RayStart::At(origin) => origin,
        };
        ask(&Receiver { point_m: self.point_m, normal: self.normal, origin: &origin })
    }
}
