//! An element side for ray tracing: start points of rays, and points and normals on it.

use glam::DVec3;

use super::contact::is_in_contact;
use super::receiver::Receiver;
use crate::geometry::Origin;
use crate::sampling::random::Stream;
use crate::sampling::warp::uniform_triangle;
use crate::scene::{ElementSide, Elements, Scene, body_of, positions_m};
use crate::transport::{TriangleSide, World};

/// An element side with all that its samples need.
#[derive(Clone, Copy, Debug)]
pub struct Element {
    /// Identity of the element side.
    pub id: ElementSide,
    /// Its corners in m, in the rotational order of its triangle's front.
    pub corners_m: [DVec3; 3],
    /// Barycentric coordinates of its corners in its triangle.
    corners: [[f64; 2]; 3],
    /// Unit normal of the side if it is the same everywhere on it.
    normal: DVec3,
    /// Whether it is a part of a leaf of a smooth body.
    curved: bool,
    /// Area in m².
    pub area_m2: f64,
    /// Whether a part of it is hidden by contact. Points in that part are then left out.
    in_partial_contact: bool,
}

/// Maximum number of points drawn in an element until one is not hidden by contact.
const MOST_DRAWN: u64 = 64;

impl Element {
    /// The element side with a number.
    pub fn of(world: &World, scene: &Scene, elements: &Elements, index: u32) -> Element {
        let id = elements.element(index);
        let corners = elements.corners(&id);
        Element {
            id,
            corners_m: positions_m(scene, id.triangle, corners),
            corners,
            normal: world.normal(id.triangle, id.side),
            curved: body_of(world.bodies(), id.triangle).is_some(),
            area_m2: elements.area_m2(scene, id),
            in_partial_contact: false,
        }
    }

    /// The same element with a given contact-free share. Below 1, points hidden by contact are left out.
    pub fn contact_free(self, share: f64) -> Element {
        Element { in_partial_contact: share < 1.0, ..self }
    }

    /// The side of a triangle that it lies on.
    pub fn spot(&self) -> TriangleSide {
        (self.id.triangle, self.id.side)
    }

    /// Whether it is a part of a leaf of a smooth body.
    pub fn is_curved(&self) -> bool {
        self.curved
    }

    /// A random point, uniform over the area: the weights of the second and third corner.
    #[inline]
    pub fn draw(&self, world: &World, stream: &mut Stream) -> [f64; 2] {
        let mut at = uniform_triangle(stream.pair());
        if self.curved
            && let Some(body) = body_of(world.bodies(), self.id.triangle)
        {
            while !stream.happens(body.keeping(self.id.triangle, self.inner(at))) {
                at = uniform_triangle(stream.pair());
            }
        }
        at
    }

    /// Weights of the triangle's second and third corner at a point.
    #[inline]
    fn inner(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let [a, b, c] = self.corners;
        [0, 1].map(|k| a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]))
    }

    /// Unit normal of the side at a point.
    #[inline]
    pub fn normal_at(&self, world: &World, at: [f64; 2]) -> DVec3 {
        if !self.curved {
            return self.normal;
        }
        world.normal_on(self.id.triangle, self.inner(at), self.id.side)
    }

    /// Its centre in m, and the unit normal there.
    pub fn middle(&self, world: &World) -> (DVec3, DVec3) {
        let at = [1.0 / 3.0; 2];
        if self.curved {
            return (self.point_m(world, at), self.normal_at(world, at));
        }
        (self.corners_m.iter().sum::<DVec3>() / 3.0, self.normal)
    }

    /// A random point of the whole element, `None` if that point is hidden by contact; and the number of rays.
    ///
    /// A hidden point sees nothing. But a ray that starts there within some millionths of the scene's size of an edge is assumed to have
    /// slipped below the edge, and continues outside.
    #[inline]
    pub fn draw_of_whole(&self, world: &World, stream: &mut Stream) -> (Option<[f64; 2]>, u64) {
        let at = self.draw(world, stream);
        if !self.in_partial_contact {
            return (Some(at), 0);
        }
        let (in_contact, rays) = self.is_in_contact(world, at, stream);
        ((!in_contact).then_some(at), rays)
    }

    /// A random point that is not hidden by contact, and the number of rays traced to find it.
    #[inline]
    pub fn draw_contact_free(&self, world: &World, stream: &mut Stream) -> ([f64; 2], u64) {
        let mut at = self.draw(world, stream);
        let mut rays = 0;
        if self.in_partial_contact {
            for _ in 0..MOST_DRAWN {
                let (in_contact, tested_rays) = self.is_in_contact(world, at, stream);
                rays += tested_rays;
                if !in_contact {
                    break;
                }
                at = self.draw(world, stream);
            }
        }
        (at, rays)
    }

    /// Whether a point of it is hidden by contact, and the number of rays traced to determine this.
    pub fn is_in_contact(&self, world: &World, at: [f64; 2], stream: &mut Stream) -> (bool, u64) {
        is_in_contact(world, &self.origin(world, at), self.normal_at(world, at), stream)
    }

    /// Start point of a ray that leaves the element.
    #[inline]
    pub fn origin(&self, world: &World, at: [f64; 2]) -> Origin {
        world.tracer.surface_origin(self.id.triangle, self.inner(at), self.id.side)
    }

    /// A point of it as a receiver, with the start point of its rays.
    #[inline]
    pub fn receiver<'a>(&self, world: &World, at: [f64; 2], origin: &'a Origin) -> Receiver<'a> {
        Receiver { point_m: self.point_m(world, at), normal: self.normal_at(world, at), origin }
    }

    /// The point in m.
    #[inline]
    pub fn point_m(&self, world: &World, [u, v]: [f64; 2]) -> DVec3 {
        if self.curved
            && let Some(body) = body_of(world.bodies(), self.id.triangle)
        {
            return body.place(self.id.triangle, self.inner([u, v])).0;
        }
        let [a, b, c] = self.corners_m;
        a + u * (b - a) + v * (c - a)
    }
}
