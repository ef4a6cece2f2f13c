//! Direct light by shadow rays from the receiver. A mesh is checked against it, and it completes a run where it is cheaper.

use glam::DVec3;

use super::mesh::Surroundings;
use crate::estimators::receiver::Receiver;
use crate::geometry::Origin;
use crate::sampling::random::Stream;
use crate::sampling::warp::uniform_triangle;
use crate::scene::{ElementSide, ReceiverPoint};
use crate::transport::{Traced, World};

/// Returns one unbiased sample of the direct illuminance in lx, from a light sample of every emitter, and the number of rays. It is exact
/// if all emitters are points.
pub fn sample_all_emitters(world: &World, receiver: &Receiver, stream: &mut Stream) -> Traced {
    let mut sum = Traced::default();
    for emitter in world.emitters.list() {
        let Some(sample) = emitter.light_sample(receiver.point_m, receiver.normal, stream) else { continue };
        sum.rays += 1;
        if let Some(place) = sample.place {
            sum.value += sample.unshadowed_lx * world.transmittance(receiver.origin, &world.origin(&place));
        }
    }
    sum
}

/// Whether light samples of all emitters have no random error.
pub fn light_samples_are_exact(world: &World) -> bool {
    world.emitters.list().iter().all(|emitter| emitter.is_single_point())
}

/// A point of a map at which light is computed.
#[derive(Clone, Copy)]
pub struct MeshPlace {
    /// Position in m.
    pub point_m: DVec3,
    /// Unit normal.
    pub normal: DVec3,
    /// Where its rays start.
    start: RayStart,
}

/// Origin of the rays of a point.
#[derive(Clone, Copy)]
enum RayStart {
    /// On the surface that it lies on, on the side that its normal points to.
    Side,
    /// On an element side, at these weights of the triangle's second and third corner.
    Element(ElementSide, [f64; 2]),
    /// Known from the ray that met the surface.
    At(Origin),
}

impl MeshPlace {
    /// Creates the point of a receiver.
    pub fn of_point(point: &ReceiverPoint) -> MeshPlace {
        MeshPlace { point_m: point.position_m, normal: point.normal, start: RayStart::Side }
    }

    /// Creates a point on a surface that a ray has met.
    pub fn at_origin(point_m: DVec3, normal: DVec3, origin: Origin) -> MeshPlace {
        MeshPlace { point_m, normal, start: RayStart::At(origin) }
    }

    /// Creates a point of an element side from the weights of the element's second and third corner.
    pub fn of_element(around: &Surroundings, element: ElementSide, [u, v]: [f64; 2]) -> MeshPlace {
        let part = around.world.elements.corners(&element);
        let inner = [0, 1].map(|k| part[0][k] + u * (part[1][k] - part[0][k]) + v * (part[2][k] - part[0][k]));
        let [a, b, c] = around.scene.corners_m(element.triangle);
        MeshPlace {
            point_m: a + inner[0] * (b - a) + inner[1] * (c - a),
            normal: around.world.normal(element.triangle, element.side),
            start: RayStart::Element(element, inner),
        }
    }

    /// Creates a random point of an element side, uniform over its area.
    pub fn drawn_in_element(around: &Surroundings, element: ElementSide, stream: &mut Stream) -> MeshPlace {
        MeshPlace::of_element(around, element, uniform_triangle(stream.pair()))
    }

    /// Calls `then` with the point as a receiver.
    #[inline]
    pub fn with_receiver<T>(&self, world: &World, then: impl FnOnce(&Receiver) -> T) -> T {
        let origin = match self.start {
            RayStart::Side => world.tracer.side_origin(self.point_m, self.normal),
            RayStart::Element(element, inner) => world.tracer.surface_origin(element.triangle, inner, element.side),
            RayStart::At(origin) => origin,
        };
        then(&Receiver { point_m: self.point_m, normal: self.normal, origin: &origin })
    }
}
