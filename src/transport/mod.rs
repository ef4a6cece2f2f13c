//! The life of one packet: emit → first_hit → arrive → scatter, until it is absorbed or leaves the scene.

mod choice;
mod glossy_facets;
mod mirrors;
mod near_emitters;
mod near_luminaires;
mod packets;
mod patience;
mod roulette;
mod selection_by_cell;
mod selection_by_region;
mod sides_by_area;
mod sight_lines;
mod traced;
mod unlit;

use std::sync::{Arc, OnceLock};

use glam::DVec3;

pub use glossy_facets::GlossyFacets;
pub use mirrors::Mirrors;
pub use near_luminaires::NearLuminaires;
pub use packets::{
    ConnectedFrom, ConnectingPoint, ConnectingSide, LaterLandings, MetFrom, PacketConnection, PointAndNormal,
    SampledPlace,
};
pub use patience::{Patience, SURFACES_BETWEEN_CLOCKS};
pub use roulette::Roulette;
pub use selection_by_cell::SelectionByCell;
pub use selection_by_region::{HIDDEN, LightInSight, SelectionByRegion};
pub use sides_by_area::TriangleSide;
pub use traced::Traced;

use crate::geometry::{Meeting, Origin, SurfaceHit, Tracer};
use crate::sampling::emitter::{Emitted, Emitters, Place};
use crate::sampling::random::Stream;
use crate::sampling::reflection::{Bsdf, LobeKind};
use crate::scene::{Body, Elements, Scene, Side, body_of};

/// A scene prepared for packets: tracer, elements, emitters, and for each triangle what a packet needs on arrival.
pub struct World {
    /// Ray tracer of the scene.
    pub tracer: Tracer,
    /// Numbering of element sides.
    pub elements: Elements,
    /// Area of all surfaces in m², with both sides of surfaces that count on both.
    pub area_m2: f64,
    /// Sources of light.
    pub emitters: Emitters,
    /// Flat mirrors in which walks search for luminaires. `None` if there is nothing to search for.
    pub mirrors: Option<Mirrors>,
    /// Flat glossy surfaces in which walks search for highlights, if there are any.
    pub gloss: Option<GlossyFacets>,
    /// Which luminaires are visible from which parts of the surfaces, where this changes a walk's choice: docs/methods.md (6).
    pub selection_by_region: SelectionByRegion,
    /// The same for many small cubes of space, after a run has found it worthwhile: docs/methods.md (41).
    selection_by_cell: OnceLock<Option<SelectionByCell>>,
    /// Luminaires close to surfaces, if there are any.
    pub near_luminaires: Option<NearLuminaires>,
    /// Decisions of walks that are left to chance.
    pub roulette: Roulette,
    /// Classes of paths that walks cannot find, in words. Chains find all of them.
    pub paths_not_found: Vec<String>,
    /// How long paths may continue.
    pub patience: Patience,
    triangles: Vec<TriangleOptics>,
    bodies: Vec<Arc<Body>>,
    bsdfs: Vec<Bsdf>,
    has_panes: bool,
    has_sheets: bool,
    has_lobes: bool,
}

#[derive(Clone, Copy)]
struct TriangleOptics {
    normal: DVec3,
    bsdf: u32,
    two_sided: bool,
    /// Whether no luminaire can light its front, and its back.
    unlit: [bool; 2],
}

/// A packet's arrival at a reflecting side of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Arrival {
    /// The surface point.
    pub hit: SurfaceHit,
    /// Unit direction of the packet.
    pub direction: DVec3,
    /// Surfaces met before this one, without panes that it only passed: 0 for direct light.
    pub bounces: u32,
}

/// A packet under way.
struct Packet {
    origin: Origin,
    /// Unit direction.
    direction: DVec3,
    /// Surfaces that scattered it.
    bounces: u32,
    /// Distance in m that it may still travel before a surface scatters it: see [`Emitted::reach_m`].
    reach_m: f64,
}

impl Packet {
    fn emitted(origin: Origin, emitted: &Emitted) -> Packet {
        Packet { origin, direction: emitted.direction, bounces: 0, reach_m: emitted.reach_m }
    }
}

/// How a packet ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Absorbed by a surface.
    Absorbed,
    /// Absorbed by a pane of glass, whose absorptance depends on the angle.
    Pane,
    /// Absorbed by a luminaire's bright ball.
    Ball,
    /// Absorbed by the back of a one-sided surface.
    BackFace,
    /// Left the scene.
    Escaped,
    /// Cut off after very many surfaces, or after many and long after the time of a run.
    CutOff,
}

/// Rays after which a packet is cut off: twenty times the number in the whitest room that is accepted. A packet reaches it only in a white
/// space whose openings were not recognised as openings, since they belong to no room.
pub const MOST_RAYS_OF_A_CHAIN: u64 = 200_000;

impl World {
    /// Prepares a scene: builds the tracer and the lists.
    pub fn new(scene: &Scene) -> World {
        // The tracer comes first: building it takes the most memory, for a while.
        let tracer = Tracer::new(scene);
        let triangles: Vec<TriangleOptics> = (0..scene.triangles.len() as u32)
            .map(|triangle| {
                let surface = scene.surface_of(triangle);
                TriangleOptics {
                    normal: scene.triangle_normal(triangle),
                    bsdf: surface.material,
                    two_sided: surface.two_sided,
                    unlit: [false; 2],
                }
            })
            .collect();
        let bsdfs: Vec<Bsdf> = scene.materials.iter().map(|material| Bsdf::new(&material.bsdf)).collect();
        let is_used = |bsdf: &dyn Fn(&Bsdf) -> bool| {
            triangles.iter().any(|triangle: &TriangleOptics| bsdf(&bsdfs[triangle.bsdf as usize]))
        };
        let has_panes = is_used(&|bsdf| matches!(bsdf, Bsdf::Glass(_)));
        let has_sheets = is_used(&|bsdf| matches!(bsdf, Bsdf::Translucent(_)));
        let has_lobes = triangles.iter().any(|triangle| scene.materials[triangle.bsdf as usize].bsdf.has_lobe());
        let emitters = Emitters::of(scene);
        let (mirrors, left_out) = mirrors::mirrors_of(scene, &triangles, &bsdfs, &emitters);
        let mut world = World {
            tracer,
            elements: Elements::of(scene),
            area_m2: scene.area_m2(),
            emitters,
            mirrors,
            gloss: None,
            selection_by_region: SelectionByRegion::default(),
            selection_by_cell: OnceLock::new(),
            near_luminaires: None,
            roulette: Roulette::default(),
            paths_not_found: mirrors::not_found(&left_out),
            patience: Patience::default(),
            triangles,
            bodies: scene.bodies.clone(),
            bsdfs,
            has_panes,
            has_sheets,
            has_lobes,
        };
        let sight_lines = sight_lines::sight_lines(scene, &world);
        world.tracer.find_clear_boxes(sight_lines);
        unlit::mark_unlit(scene, &mut world);
        world.gloss = GlossyFacets::of(scene, &world);
        world.selection_by_region = SelectionByRegion::of(scene, &world);
        world.near_luminaires = NearLuminaires::of(scene, &world);
        world
    }

    /// Finds out which luminaires are visible from which cells, if this pays off in a run of about `planned_rays` rays. Only the first call
    /// has an effect.
    pub fn learn_selection_by_cell(&self, planned_rays: f64) {
        self.selection_by_cell.get_or_init(|| SelectionByCell::of(self, planned_rays));
    }

    /// Takes over the selection that an earlier part of the run has found, if any. Only the first call of this or of
    /// `learn_selection_by_cell` has an effect.
    pub fn take_selection_by_cell(&self, found: Option<SelectionByCell>) {
        self.selection_by_cell.get_or_init(|| found);
    }

    /// Whether a run of about `planned_rays` rays would learn the selection for nearly all points. The choice of luminaires then costs
    /// little.
    pub fn would_learn_selection_by_cell(&self, planned_rays: f64) -> bool {
        selection_by_cell::would_serve(self, planned_rays)
    }

    /// The selection by cell, if a run has learned one.
    #[inline]
    pub fn selection_by_cell(&self) -> Option<&SelectionByCell> {
        self.selection_by_cell.get()?.as_ref()
    }

    /// Rays spent on learning what is visible, before the run and in it.
    pub fn selection_rays(&self) -> u64 {
        let near_rays = self.near_luminaires.as_ref().map_or(0, NearLuminaires::rays);
        let by_cell_rays = self.selection_by_cell().map_or(0, SelectionByCell::rays);
        self.selection_by_region.rays() + by_cell_rays + near_rays + self.roulette.pilot_rays
    }

    /// Whether a side of a triangle reflects and is reported. The backs of one-sided surfaces only absorb.
    #[inline]
    pub fn receives(&self, triangle: u32, side: Side) -> bool {
        side == Side::Front || self.triangles[triangle as usize].two_sided
    }

    /// Unit normal of a side of a triangle. For a leaf of a smooth body, the normal of the flat triangle between its corners.
    #[inline]
    pub fn normal(&self, triangle: u32, side: Side) -> DVec3 {
        let front = self.triangles[triangle as usize].normal;
        if side == Side::Front { front } else { -front }
    }

    /// Unit normal of the side that a ray has met, at the point where it met it. On a smooth body it varies within a triangle.
    #[inline]
    pub fn normal_at(&self, hit: &SurfaceHit) -> DVec3 {
        self.normal_on(hit.triangle, hit.barycentric, hit.side)
    }

    /// Unit normal of a side of a triangle at a point on it.
    #[inline]
    pub fn normal_on(&self, triangle: u32, barycentric: [f64; 2], side: Side) -> DVec3 {
        let Some(body) = body_of(&self.bodies, triangle) else {
            return self.normal(triangle, side);
        };
        let front = body.place(triangle, barycentric).1;
        if side == Side::Front { front } else { -front }
    }

    /// Smooth bodies. Their leaves are among the triangles.
    pub fn bodies(&self) -> &[Arc<Body>] {
        &self.bodies
    }

    /// Whether certainly no luminaire can light a side of a triangle: all are behind its plane or shine away from it.
    #[inline]
    pub fn is_unlit(&self, (triangle, side): TriangleSide) -> bool {
        self.triangles[triangle as usize].unlit[side as usize]
    }

    /// BSDF of a triangle.
    #[inline]
    pub fn bsdf(&self, triangle: u32) -> &Bsdf {
        &self.bsdfs[self.triangles[triangle as usize].bsdf as usize]
    }

    /// Whether any light is reflected at all. In a black scene, or one without light, a chain finds nothing.
    pub fn reflects(&self) -> bool {
        !self.emitters.list().is_empty()
            && self.triangles.iter().any(|triangle| !self.bsdfs[triangle.bsdf as usize].is_black())
    }

    /// Whether every reflecting surface reflects diffusely and none transmits light.
    pub fn is_diffuse(&self) -> bool {
        self.triangles
            .iter()
            .map(|triangle| &self.bsdfs[triangle.bsdf as usize])
            .all(|bsdf| matches!(bsdf, Bsdf::Diffuse(_)))
    }

    /// Whether any surface scatters light in a lobe about a direction.
    pub fn has_lobes(&self) -> bool {
        self.has_lobes
    }

    /// Whether an emitter lights surfaces from nearby.
    #[inline]
    pub fn is_near(&self, emitter: u32) -> bool {
        self.near_luminaires.as_ref().is_some_and(|lights| lights.is_near(emitter))
    }

    /// Whether light passes panes of glass anywhere.
    pub fn has_panes(&self) -> bool {
        self.has_panes
    }

    /// Whether any surface scatters light to its other side.
    pub fn has_sheets(&self) -> bool {
        self.has_sheets
    }

    /// Whether any surface sends light on unscattered: mirrors and panes.
    pub fn has_specular(&self) -> bool {
        self.triangles.iter().any(|triangle| self.bsdfs[triangle.bsdf as usize].is_specular())
    }

    /// The tracer's origin for a point on a luminaire.
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

    /// Share of the light that leaves the scene from a point in a unit direction, and the number of rays traced for it. The share is 0 if
    /// anything but panes blocks the direction.
    pub fn transmittance_out(&self, from: &Origin, direction: DVec3) -> Traced {
        let mut here = *from;
        let mut product = 1.0;
        for rays in 1..=MOST_PANES {
            let hit = match self.tracer.first_hit(&here, direction) {
                Meeting::Nothing => return Traced { value: product, rays },
                Meeting::Ball(_) => return Traced { value: 0.0, rays },
                Meeting::Surface(hit) => hit,
            };
            let Bsdf::Glass(glass) = self.bsdf(hit.triangle) else {
                return Traced { value: 0.0, rays };
            };
            product *= glass.shares(self.normal_at(&hit).dot(direction))[1];
            here = self.leave(&hit, LobeKind::Passed);
        }
        Traced { value: 0.0, rays: MOST_PANES }
    }

    /// Follows one packet from a luminaire to its end. Returns the end and the number of rays. If the packet left the scene after a surface
    /// scattered it, also returns its direction.
    pub fn trace_out(&self, choice: f64, stream: &mut Stream) -> (End, u64, Option<DVec3>) {
        let emitted = self.emitters.emit(choice, stream);
        let (origin, rays) = match self.start(&emitted, stream) {
            (Some(origin), rays) => (origin, rays),
            (None, rays) => return (End::Escaped, rays, None),
        };
        let mut packet = Packet::emitted(origin, &emitted);
        let (end, more_rays) = self.follow(&mut packet, stream, |_| {});
        (end, rays + more_rays, (end == End::Escaped && packet.bounces > 0).then_some(packet.direction))
    }

    /// Follows one packet from a luminaire to its end and passes every arrival on its path to `arrive`. Returns the end and the number of
    /// rays traced.
    pub fn trace_chain(&self, choice: f64, stream: &mut Stream, arrive: impl FnMut(&Arrival)) -> (End, u64) {
        let emitted = self.emitters.emit(choice, stream);
        let (origin, rays) = match self.start(&emitted, stream) {
            (Some(origin), rays) => (origin, rays),
            (None, rays) => return (End::Escaped, rays),
        };
        let (end, more_rays) = self.follow(&mut Packet::emitted(origin, &emitted), stream, arrive);
        (end, rays + more_rays)
    }

    /// Start point of a packet, and the number of rays traced to determine it. `None` for a packet of the sky that does not get that far.
    #[inline]
    fn start(&self, emitted: &Emitted, stream: &mut Stream) -> (Option<Origin>, u64) {
        let origin = self.origin(&emitted.place);
        let Some(behind) = &emitted.behind else {
            return (Some(origin), 0);
        };
        let passed = self.transmittance(&origin, &self.origin(behind));
        let comes = passed >= 1.0 || passed > 0.0 && stream.happens(passed);
        (comes.then_some(origin), 1)
    }

    /// Follows one packet from a luminaire to its first arrival. From there it follows `branches` branches, each a packet of its own that
    /// carries its part of the flux. Branch `b` draws from the stream's index `first_index + b`. Returns the number of rays.
    pub fn trace_branches(
        &self,
        choice: f64,
        stream: &mut Stream,
        branches: u32,
        first_index: u64,
        mut arrive: impl FnMut(&Arrival),
    ) -> u64 {
        let emitted = self.emitters.emit(choice, stream);
        let direction = emitted.direction;
        let (Some(origin), mut rays) = self.start(&emitted, stream) else {
            return 1;
        };
        rays += 1;
        let Meeting::Surface(hit) = self.tracer.first_hit(&origin, direction) else {
            return rays;
        };
        if !self.receives(hit.triangle, hit.side) || self.is_touched(&origin, &hit) || hit.distance_m > emitted.reach_m
        {
            return rays;
        }
        arrive(&Arrival { hit, direction, bounces: 0 });
        let mark = stream.mark();
        for branch in 0..branches {
            stream.branch(&mark, first_index + u64::from(branch), branch);
            let scattered = self.bsdf(hit.triangle).sample(direction, self.normal_at(&hit), stream);
            if let Some(scattered) = scattered {
                let mut packet = Packet {
                    origin: self.leave(&hit, scattered.lobe),
                    direction: scattered.direction,
                    bounces: u32::from(scattered.lobe != LobeKind::Passed),
                    reach_m: emitted.reach_m - hit.distance_m,
                };
                rays += self.follow(&mut packet, stream, &mut arrive).1;
            }
        }
        rays
    }

    /// Follows a packet to its end and passes every arrival to `arrive`.
    fn follow(&self, packet: &mut Packet, stream: &mut Stream, mut arrive: impl FnMut(&Arrival)) -> (End, u64) {
        for rays in 1..=MOST_RAYS_OF_A_CHAIN {
            let hit = match self.tracer.first_hit(&packet.origin, packet.direction) {
                Meeting::Surface(hit) => hit,
                Meeting::Ball(_) => return (End::Ball, rays),
                Meeting::Nothing => return (End::Escaped, rays),
            };
            if packet.bounces == 0 && hit.distance_m > packet.reach_m {
                return (End::Escaped, rays);
            }
            packet.reach_m -= hit.distance_m;
            if !self.receives(hit.triangle, hit.side) {
                return (End::BackFace, rays);
            }
            if self.is_touched(&packet.origin, &hit) {
                return (End::Absorbed, rays);
            }
            arrive(&Arrival { hit, direction: packet.direction, bounces: packet.bounces });
            let bsdf = self.bsdf(hit.triangle);
            let Some(scattered) = bsdf.sample(packet.direction, self.normal_at(&hit), stream) else {
                return (if matches!(bsdf, Bsdf::Glass(_)) { End::Pane } else { End::Absorbed }, rays);
            };
            packet.direction = scattered.direction;
            packet.bounces += u32::from(scattered.lobe != LobeKind::Passed);
            packet.origin = self.leave(&hit, scattered.lobe);
            if self.patience.is_over(rays) {
                return (End::CutOff, rays);
            }
        }
        (End::CutOff, MOST_RAYS_OF_A_CHAIN)
    }

    /// Whether a point luminaire lies on the surface that its packet met. No light sample finds what it sends into that surface, so the
    /// packet ends there.
    #[inline]
    pub fn is_touched(&self, origin: &Origin, hit: &SurfaceHit) -> bool {
        origin.is_free() && hit.distance_m <= 2.0 * self.tracer.position_accuracy_m()
    }

    /// Start point of a packet's next ray after it met a surface: on the side from which it came, or on the other side.
    #[inline]
    pub fn leave(&self, hit: &SurfaceHit, lobe: LobeKind) -> Origin {
        let side = if lobe.leads_through() { hit.side.other() } else { hit.side };
        self.tracer.surface_origin(hit.triangle, hit.barycentric, side)
    }

    /// Share of the light that gets from one point to another. It is 0 if something opaque is in between, else what the panes in between
    /// transmit.
    #[inline]
    pub fn transmittance(&self, from: &Origin, to: &Origin) -> f64 {
        if !self.tracer.is_occluded(from, to) {
            return 1.0;
        }
        if self.has_panes { self.transmittance_of_panes(from, to) } else { 0.0 }
    }

    /// Transmittance from one point to another that is occluded: passes from pane to pane until nothing is in between.
    fn transmittance_of_panes(&self, from: &Origin, to: &Origin) -> f64 {
        let end_m = self.tracer.position_m(to);
        let mut here = *from;
        let mut product = 1.0;
        for _ in 0..MOST_PANES {
            let offset_m = end_m - self.tracer.position_m(&here);
            let distance_m = offset_m.length();
            let direction = offset_m / distance_m;
            let Meeting::Surface(hit) = self.tracer.first_hit(&here, direction) else {
                return 0.0;
            };
            let Bsdf::Glass(glass) = self.bsdf(hit.triangle) else {
                return 0.0;
            };
            if hit.distance_m > distance_m {
                return 0.0;
            }
            product *= glass.shares(self.normal_at(&hit).dot(direction))[1];
            here = self.leave(&hit, LobeKind::Passed);
            if !self.tracer.is_occluded(&here, to) {
                return product;
            }
        }
        0.0
    }
}

/// Maximum number of panes that a connection, or a ray to the sun, passes. This many panes of any real glass transmit nothing.
pub const MOST_PANES: u64 = 1000;
