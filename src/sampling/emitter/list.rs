//! All emitters of a scene: which one a packet leaves, and which one a point samples.

use glam::DVec3;

use super::light::Light;
use super::web::SharedWebs;
use super::{Emitted, Emitter, EmitterShape, Place, lights_of, of_light};
use crate::base::sky::Sky;
use crate::base::sun::Sun;
use crate::sampling::emitter_tree::{BeaconMask, Cut, EmitterTree};
use crate::sampling::importance::Beacon;
use crate::sampling::opening::OpeningPoint;
use crate::sampling::random::Stream;
use crate::scene::{Scene, Side};

/// All emitters of a scene that give light.
#[derive(Clone, Debug)]
pub struct Emitters {
    list: Vec<Emitter>,
    /// Emitting sides of triangles with their emitters, in order.
    on_surfaces: Vec<((u32, Side), u32)>,
    /// Cumulative flux of the emitters, each included, in lm.
    cumulative_flux_lm: Vec<f64>,
    tree: Option<EmitterTree>,
}

impl Emitters {
    /// Lists the emitters of a scene; luminaires without flux have none.
    pub fn of(scene: &Scene) -> Emitters {
        // Most luminaires are one emitter.
        let mut list = Vec::with_capacity(scene.luminaires.len());
        let mut webs = SharedWebs::default();
        for (luminaire, source) in (0u32..).zip(&scene.luminaires) {
            lights_of(scene, luminaire, source, &mut webs, &mut |luminous_flux_lm, shape| {
                if luminous_flux_lm > 0.0 {
                    let beacon = of_light!(&shape, light => light.beacon());
                    list.push(Emitter { luminaire, luminous_flux_lm, shape, beacon });
                }
            });
        }
        let cumulative_flux_lm = list
            .iter()
            .scan(0.0, |sum, emitter: &Emitter| {
                *sum += emitter.luminous_flux_lm;
                Some(*sum)
            })
            .collect();
        let beacons: Vec<&Beacon> = list.iter().map(|emitter| &emitter.beacon).collect();
        let tree = EmitterTree::of(&beacons);
        let mut on_surfaces: Vec<((u32, Side), u32)> =
            list.iter().enumerate().filter_map(|(index, emitter)| Some((emitter.side()?, index as u32))).collect();
        on_surfaces.sort_unstable();
        Emitters { list, on_surfaces, cumulative_flux_lm, tree }
    }

    /// Returns the point-like emitters alone, if there are any.
    pub fn points(&self) -> Option<PointEmitters> {
        let numbered = self.list.iter().zip(0u32..).filter(|(emitter, _)| emitter.is_met_by_no_ray());
        let (list, numbers): (Vec<Emitter>, Vec<u32>) =
            numbered.map(|(emitter, number)| (emitter.clone(), number)).unzip();
        let beacons: Vec<&Beacon> = list.iter().map(|emitter| &emitter.beacon).collect();
        let tree = EmitterTree::of(&beacons)?;
        Some(PointEmitters { list, numbers, tree })
    }

    /// Returns the numbers of the emitters on a side of a triangle.
    pub fn on_surface(&self, triangle: u32, side: Side) -> impl Iterator<Item = u32> + '_ {
        let first = self.on_surfaces.partition_point(|(place, _)| *place < (triangle, side));
        let here = self.on_surfaces[first..].iter().take_while(move |(place, _)| *place == (triangle, side));
        here.map(|(_, emitter)| *emitter)
    }

    /// Returns the number of the emitter that is a luminaire's ball.
    pub fn of_ball(&self, luminaire: u32) -> Option<u32> {
        let first = self.list.partition_point(|emitter| emitter.luminaire < luminaire);
        self.list.get(first).filter(|emitter| emitter.luminaire == luminaire).map(|_| first as u32)
    }

    /// Returns the sky, if there is one that gives light.
    pub fn sky(&self) -> Option<&Sky> {
        self.list.iter().find_map(Emitter::sky)
    }

    /// Returns the sun, if there is one that gives light.
    pub fn sun(&self) -> Option<&Sun> {
        self.list.iter().find_map(Emitter::sun)
    }

    /// The emitters.
    pub fn list(&self) -> &[Emitter] {
        &self.list
    }

    /// Flux of all emitters in lm.
    pub fn luminous_flux_lm(&self) -> f64 {
        self.cumulative_flux_lm.last().copied().unwrap_or(0.0)
    }

    /// Prepares `cut` for any number of choices at a point with a unit normal.
    #[inline]
    pub fn open(&self, point_m: DVec3, normal: DVec3, cut: &mut Cut) {
        if let Some(tree) = &self.tree {
            tree.open(point_m, normal, cut);
        }
    }

    /// Returns the mask of the emitters that `is_in` accepts; `None` if emitters are too many to be weighed one by one.
    pub fn mask(&self, is_in: impl Fn(u32) -> bool) -> Option<BeaconMask> {
        self.tree.as_ref()?.mask(is_in)
    }

    /// Chooses one emitter, approximately in proportion to its unshadowed contribution at the point and normal for which `cut` was opened.
    /// Returns its number with the probability of the choice. `None`: this choice gives no light.
    #[inline]
    pub fn choose(&self, point_m: DVec3, normal: DVec3, variate: f64, cut: &Cut) -> Option<(u32, f64)> {
        self.tree.as_ref()?.choose(point_m, normal, variate, cut)
    }

    /// Returns the probability with which [`Emitters::choose`] chooses an emitter.
    pub fn probability(&self, emitter: u32, point_m: DVec3, normal: DVec3, cut: &Cut) -> f64 {
        self.tree.as_ref().map_or(0.0, |tree| tree.probability(emitter, point_m, normal, cut))
    }

    /// Shows the emitters that may light a point with a unit normal, roughly the strongest first, until `show` returns `false`. Each comes
    /// with its importance and the importance of all that have not been shown.
    pub fn strongest_first(&self, point_m: DVec3, normal: DVec3, show: impl FnMut(u32, f64, f64) -> bool) {
        if let Some(tree) = &self.tree {
            tree.strongest_first(point_m, normal, show);
        }
    }

    /// Draws a packet: the emitter in proportion to flux by `choice` in [0, 1), then its point and direction.
    pub fn emit(&self, choice: f64, stream: &mut Stream) -> Emitted {
        self.list[self.index_at(choice) as usize].emit(stream)
    }

    /// Returns the number of the emitter for a choice in [0, 1), in proportion to flux.
    pub fn index_at(&self, choice: f64) -> u32 {
        let aim = choice * self.luminous_flux_lm();
        self.cumulative_flux_lm.partition_point(|sum| *sum <= aim).min(self.list.len() - 1) as u32
    }
}

/// The emitters that no ray meets: points, openings and rings.
#[derive(Clone, Debug)]
pub struct PointEmitters {
    list: Vec<Emitter>,
    /// Their numbers among all emitters, in order.
    numbers: Vec<u32>,
    tree: EmitterTree,
}

/// A point of a point-like emitter.
#[derive(Clone, Copy, Debug)]
pub struct PointSample<'a> {
    /// The emitter.
    pub emitter: &'a Emitter,
    /// The point.
    pub point: OpeningPoint,
    /// The same point for the geometry.
    pub place: Place,
}

impl PointEmitters {
    /// Chooses a point-like emitter as [`Emitters::choose`] does, and a point of it; returns both with the
    /// probability of the choice.
    pub fn choose(
        &self,
        point_m: DVec3,
        normal: DVec3,
        variate: f64,
        cut: &mut Cut,
        stream: &mut Stream,
    ) -> Option<(PointSample<'_>, f64)> {
        let (index, probability) = self.choose_index(point_m, normal, variate, cut)?;
        let emitter = &self.list[index];
        let point = emitter.draw_point(stream)?;
        Some((PointSample { emitter, point, place: emitter.place_of_point(point.position_m) }, probability))
    }

    /// Chooses a point-like emitter in the same way. Returns its number among all emitters and the probability of the choice.
    pub fn choose_number(&self, point_m: DVec3, normal: DVec3, variate: f64, cut: &mut Cut) -> Option<(u32, f64)> {
        let (index, probability) = self.choose_index(point_m, normal, variate, cut)?;
        Some((self.numbers[index], probability))
    }

    fn choose_index(&self, point_m: DVec3, normal: DVec3, variate: f64, cut: &mut Cut) -> Option<(usize, f64)> {
        self.tree.open(point_m, normal, cut);
        let (index, probability) = self.tree.choose(point_m, normal, variate, cut)?;
        Some((index as usize, probability))
    }

    /// Returns the probability with which [`PointEmitters::choose_number`] chooses an emitter; `None` if it is not point-like.
    pub fn probability(&self, number: u32, point_m: DVec3, normal: DVec3, cut: &mut Cut) -> Option<f64> {
        let index = self.numbers.binary_search(&number).ok()?;
        self.tree.open(point_m, normal, cut);
        Some(self.tree.probability(index as u32, point_m, normal, cut))
    }
}
