//! Whether rays are exact enough for what a scene holds: a room that is lost in a far larger scene is not.

use std::f64::consts::TAU;

use glam::DVec3;

use super::straight::{ON_SURFACE_M, first_met_each};
use crate::geometry::position_accuracy_m;
use crate::scene::{Emission, Scene};

/// Ways that are looked at from luminaires, and as many from receivers, at least and at most.
const FEWEST_WAYS: usize = 16;
const MOST_WAYS: usize = 256;
/// Triangles times ways, about: some tenths of a second.
const LOOKS: usize = 20_000_000;
/// Median way over the accuracy of positions below which a scene is refused: rays start up to 16 times the accuracy off the
/// edges of triangles, an eighth of such a way.
const REFUSED_BELOW: f64 = 128.0;
/// The same below which it is warned of.
const DOUBTFUL_BELOW: f64 = 1024.0;

/// How far light goes in a scene, and how exactly rays know where they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proportions {
    /// Half of the way in m from luminaires, or from receivers where that is shorter, to the next surface is shorter than this.
    pub median_way_m: f64,
    /// Where such ways start.
    pub from: &'static str,
    /// Accuracy of positions in m.
    pub accuracy_m: f64,
}

/// What proportions allow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trust {
    /// Results hold.
    Sound,
    /// Results may be off by a percent.
    Doubtful,
    /// Results may be off by any amount.
    None,
}

impl Proportions {
    /// Looks along straight ways from luminaires and from receivers, in f64 and triangle by triangle; `None` where nothing is met.
    ///
    /// Units: m. Accuracy: a median of 16 to 256 ways.
    pub fn of(scene: &Scene) -> Option<Proportions> {
        let ways = (LOOKS / scene.triangles.len().max(1)).clamp(FEWEST_WAYS, MOST_WAYS);
        let starts = [("luminaires", starts_of_luminaires(scene)), ("receivers", starts_of_receivers(scene))];
        let medians = starts.into_iter().filter_map(|(from, starts)| Some((median_way_m(scene, &starts, ways)?, from)));
        let (median_way_m, from) = medians.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Proportions { median_way_m, from, accuracy_m: position_accuracy_m(scene) })
    }

    /// Whether rays are exact enough.
    pub fn trust(&self) -> Trust {
        match self.median_way_m / self.accuracy_m {
            ratio if ratio >= DOUBTFUL_BELOW => Trust::Sound,
            ratio if ratio >= REFUSED_BELOW => Trust::Doubtful,
            _ => Trust::None,
        }
    }

    /// Whether most of that light meets a surface where it starts, so that size has nothing to do with it: it shines into what it lies on.
    pub fn starts_on_surfaces(&self) -> bool {
        self.median_way_m <= ON_SURFACE_M
    }

    /// The accuracy in m that it takes for results to be trusted.
    pub fn accuracy_wanted_m(&self) -> f64 {
        self.median_way_m / DOUBTFUL_BELOW
    }
}

/// A place, and the middle of the half-space into which it looks; zero where it looks all around.
type WayStart = (DVec3, DVec3);

fn starts_of_luminaires(scene: &Scene) -> Vec<WayStart> {
    let lit = scene.luminaires.iter().filter(|luminaire| luminaire.luminous_flux_lm > 0.0);
    lit.filter_map(|luminaire| {
        let emission = &luminaire.emission;
        if let Some(place_m) = emission.place_m() {
            return Some((place_m, emission.aim().unwrap_or(DVec3::ZERO)));
        }
        let Emission::Area { surfaces, front, .. } = emission else { return None };
        let triangle = scene.surfaces[*surfaces.first()? as usize].triangles.start;
        let normal = scene.triangle_normal(triangle);
        let middle_m = scene.corners_m(triangle).iter().sum::<DVec3>() / 3.0;
        Some((middle_m, if *front { normal } else { -normal }))
    })
    .collect()
}

fn starts_of_receivers(scene: &Scene) -> Vec<WayStart> {
    let points = scene.receivers.iter().flat_map(|set| set.placed_points()).filter(|point| !point.inside);
    points.map(|point| (point.position_m, point.normal)).collect()
}

/// Median length of ways that meet something, spread over the starts and over their directions.
fn median_way_m(scene: &Scene, starts: &[WayStart], ways: usize) -> Option<f64> {
    if starts.is_empty() {
        return None;
    }
    let way = |number: usize| {
        let (start_m, middle) = starts[number * starts.len() / ways];
        (start_m, direction(number, middle))
    };
    let met = first_met_each(scene, &(0..ways).map(way).collect::<Vec<_>>());
    let mut ways_m: Vec<f64> = met.into_iter().flatten().map(|met| met.distance_m.max(0.0)).collect();
    let at = ways_m.len() / 2;
    (!ways_m.is_empty()).then(|| *ways_m.select_nth_unstable_by(at, f64::total_cmp).1)
}

/// A direction of many that fill a sphere evenly, or the half of it about a middle.
fn direction(number: usize, middle: DVec3) -> DVec3 {
    /// Turns of the golden angle, and steps of another irrational number, so that few ways of each start differ.
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    const SILVER: f64 = 0.414_213_562_373_095_05;
    let azimuth = TAU * (number as f64 * GOLDEN).fract();
    let z = 1.0 - 2.0 * (0.5 + number as f64 * SILVER).fract();
    let (sine, cosine) = azimuth.sin_cos();
    let across = (1.0 - z * z).max(0.0).sqrt();
    let direction = DVec3::new(across * cosine, across * sine, z);
    if direction.dot(middle) < 0.0 { -direction } else { direction }
}
