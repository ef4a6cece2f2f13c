//! One packet's life: emit → first_hit → arrive → scatter, until it is absorbed or leaves.

use glam::DVec3;

use crate::geometry::{Meeting, Origin, SurfaceHit, Tracer};
use crate::sampling::emitter::{Emitters, Place};
use crate::sampling::random::Stream;
use crate::sampling::reflection;
use crate::scene::{Elements, ReflectionLaw, Scene, Side};

/// A scene made ready for packets: tracer, elements, emitters, and per triangle what a packet needs on arrival.
pub struct Stage {
    /// The rays' world.
    pub tracer: Tracer,
    /// Numbering of element sides.
    pub elements: Elements,
    /// Where light comes from.
    pub emitters: Emitters,
    triangles: Vec<TriangleOptics>,
    laws: Vec<ReflectionLaw>,
}

#[derive(Clone, Copy)]
struct TriangleOptics {
    normal: DVec3,
    law: u32,
    two_sided: bool,
}

/// A packet's arrival at a reflecting side of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Arrival {
    /// Where.
    pub hit: SurfaceHit,
    /// Surfaces met before this one: 0 for light that comes straight from a luminaire.
    pub bounces: u32,
}

/// How a packet ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Absorbed by a surface.
    Absorbed,
    /// Absorbed by a luminaire's bright ball.
    Ball,
    /// Absorbed by the back of a one-sided surface.
    BackFace,
    /// Left the scene.
    Escaped,
}

impl Stage {
    /// Makes a scene ready: builds the tracer and the lists.
    pub fn new(scene: &Scene) -> Stage {
        let triangles = (0..scene.triangles.len() as u32)
            .map(|triangle| {
                let surface = scene.surface_of(triangle);
                TriangleOptics {
                    normal: scene.triangle_normal(triangle),
                    law: surface.material,
                    two_sided: surface.two_sided,
                }
            })
            .collect();
        Stage {
            tracer: Tracer::new(scene),
            elements: Elements::of(scene),
            emitters: Emitters::of(scene),
            triangles,
            laws: scene.materials.iter().map(|material| material.law).collect(),
        }
    }

    /// Whether a side of a triangle reflects and is reported; the backs of one-sided surfaces only absorb.
    #[inline]
    pub fn receives(&self, triangle: u32, side: Side) -> bool {
        side == Side::Front || self.triangles[triangle as usize].two_sided
    }

    /// Unit normal of a side of a triangle.
    #[inline]
    pub fn normal(&self, triangle: u32, side: Side) -> DVec3 {
        let front = self.triangles[triangle as usize].normal;
        if side == Side::Front { front } else { -front }
    }

    /// Reflection law of a triangle.
    #[inline]
    pub fn law(&self, triangle: u32) -> &ReflectionLaw {
        &self.laws[self.triangles[triangle as usize].law as usize]
    }

    /// Whether any surface reflects at all; in a black scene there is nothing for a chain to find.
    pub fn reflects(&self) -> bool {
        self.triangles.iter().any(|triangle| reflection::total(&self.laws[triangle.law as usize]) > 0.0)
    }

    /// The tracer's origin for a place on a luminaire.
    #[inline]
    pub fn origin(&self, place: &Place) -> Origin {
        match place {
            Place::Free(position_m) => self.tracer.free_origin(*position_m),
            Place::Sided(position_m, normal) => self.tracer.side_origin(*position_m, *normal),
            Place::Surface { triangle, barycentric, side } => {
                self.tracer.surface_origin(*triangle, *barycentric, *side)
            }
            Place::Ball { luminaire, position_m } => self.tracer.ball_origin(*luminaire, *position_m),
        }
    }

    /// Follows one packet from a luminaire to its end and shows every arrival on its way; returns the end and the
    /// number of rays traced.
    pub fn trace_chain(&self, choice: f64, stream: &mut Stream, mut arrive: impl FnMut(&Arrival)) -> (End, u64) {
        let emitted = self.emitters.emit(choice, stream);
        let mut origin = self.origin(&emitted.place);
        let mut direction = emitted.direction;
        for bounces in 0.. {
            let rays = u64::from(bounces) + 1;
            let hit = match self.tracer.first_hit(&origin, direction) {
                Meeting::Surface(hit) => hit,
                Meeting::Ball(_) => return (End::Ball, rays),
                Meeting::Nothing => return (End::Escaped, rays),
            };
            if !self.receives(hit.triangle, hit.side) {
                return (End::BackFace, rays);
            }
            arrive(&Arrival { hit, bounces });
            let normal = self.normal(hit.triangle, hit.side);
            match reflection::sample(self.law(hit.triangle), normal, stream) {
                Some(scattered) => direction = scattered,
                None => return (End::Absorbed, rays),
            }
            origin = self.tracer.surface_origin(hit.triangle, hit.barycentric, hit.side);
        }
        unreachable!("a packet that never ends would need more bounces than a u32 counts")
    }
}
