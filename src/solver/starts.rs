//! Where rays and walks of a map's entries start: anywhere in an element, or at a receiver.

use glam::DVec3;

use super::context::Context;
use crate::estimators::element::Element;
use crate::estimators::receiver::Receiver;
use crate::estimators::reception::one_plane;
use crate::geometry::Origin;
use crate::maps::MapKind;
use crate::sampling::random::Stream;
use crate::scene::{Elements, Quantity};

/// What rays and walks start from: elements or receivers.
#[derive(Clone, Copy)]
pub struct Starts<'a> {
    /// The run.
    pub context: &'a Context<'a>,
    /// Elements or a receiver set.
    pub kind: MapKind,
    /// The elements, if rays start from elements.
    pub elements: &'a Elements,
    /// Share of every element that is free of contact.
    pub contact_free: &'a [f64],
    /// Whether elements count as a whole, including what is hidden by contact.
    pub as_wholes: bool,
    /// Number of the streams. A map that starts anew uses new random numbers.
    pub number: u32,
}

impl Starts<'_> {
    /// Whether all rays of an entry are in one hemisphere, whose directions can be learned.
    pub fn has_one_hemisphere(&self) -> bool {
        match self.kind {
            MapKind::Elements => true,
            MapKind::Receivers(set) => self.context.scene.receivers[set].quantity.has_one_hemisphere(),
        }
    }

    /// Middle of an entry in m, and its unit normal.
    pub fn middle(&self, entry: usize) -> (DVec3, DVec3) {
        let world = self.context.world;
        match self.kind {
            MapKind::Elements => {
                let element = Element::of(world, self.context.scene, self.elements, entry as u32);
                element.middle(world)
            }
            MapKind::Receivers(set) => {
                let point = &self.context.scene.receivers[set].points[entry];
                (point.position_m, point.normal)
            }
        }
    }

    /// Where the rays of an entry start; `None` for a point inside a solid, and for an element that is hidden by contact.
    pub fn site(&self, entry: usize) -> Option<Site> {
        let world = self.context.world;
        match self.kind {
            MapKind::Elements => {
                let element = Element::of(world, self.context.scene, self.elements, entry as u32);
                let share = self.contact_free.get(entry).copied().unwrap_or(1.0);
                (share > 0.0).then(|| Site::Element(element.contact_free(share)))
            }
            MapKind::Receivers(set) => {
                let receivers = &self.context.scene.receivers[set];
                let point = &receivers.points[entry];
                let origin = world.tracer.side_origin(point.position_m, point.normal);
                let (point_m, normal, quantity) = (point.position_m, point.normal, receivers.quantity);
                (!point.inside).then_some(Site::Point { point_m, normal, origin, quantity })
            }
        }
    }

    /// Draws the start of one ray of an entry.
    #[inline]
    pub fn draw(&self, site: &Site, stream: &mut Stream) -> DrawnStart {
        let world = self.context.world;
        match site {
            Site::Element(element) => {
                let (at, rays) = if self.as_wholes {
                    element.draw_of_whole(world, stream)
                } else {
                    let (at, rays) = element.draw_contact_free(world, stream);
                    (Some(at), rays)
                };
                let (at, weight) = at.map_or(([0.0; 2], 0.0), |at| (at, 1.0));
                let origin = element.origin(world, at);
                let point_m = world.tracer.position_m(&origin);
                DrawnStart { at, point_m, normal: element.normal_at(world, at), origin, weight, rays }
            }
            Site::Point { point_m, normal, origin, quantity } => {
                let receiver = Receiver { point_m: *point_m, normal: *normal, origin };
                let (plane, weight) = one_plane(*quantity, &receiver, stream);
                DrawnStart { at: [0.0; 2], point_m: *point_m, normal: plane.normal, origin: *origin, weight, rays: 0 }
            }
        }
    }
}

/// Where one ray, or walk, starts.
pub struct DrawnStart {
    /// Point in its element: the weights of the second and third corner.
    pub at: [f64; 2],
    /// The point in m.
    pub point_m: DVec3,
    /// Unit normal of the plane that the ray is for.
    pub normal: DVec3,
    /// The point for the tracer.
    pub origin: Origin,
    /// Weight of the light that the ray brings; 0 if the point is hidden by contact and no ray starts.
    pub weight: f64,
    /// Rays that it took to find the point.
    pub rays: u64,
}

impl DrawnStart {
    /// The plane that the ray is for.
    #[inline]
    pub fn receiver(&self) -> Receiver<'_> {
        Receiver { point_m: self.point_m, normal: self.normal, origin: &self.origin }
    }
}

/// What rays of an entry start from.
pub enum Site {
    /// Anywhere in an element side.
    Element(Element),
    /// At a receiver.
    Point {
        /// Point in m.
        point_m: DVec3,
        /// Unit normal.
        normal: DVec3,
        /// The point for the tracer.
        origin: Origin,
        /// What the receiver measures.
        quantity: Quantity,
    },
}
