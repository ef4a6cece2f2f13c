//! Whether rays are accurate enough for the contents of a scene. They are not for a small room in a far larger scene.

use std::f64::consts::TAU;

use glam::DVec3;

use super::straight::{ON_SURFACE_M, first_met_each};
use crate::base::quadrature::GOLDEN;
use crate::geometry::position_accuracy_m;
use crate::scene::{Emission, Scene};

/// Least and largest number of lines that are traced from luminaires, and as many again from receivers.
const FEWEST_WAYS: usize = 16;
const MOST_WAYS: usize = 256;
/// About the largest number of triangles times lines: some hundredths of a second.
const LINES_BY_TRIANGLES: usize = 1_000_000;
/// A scene is refused if the median distance over the accuracy of positions is below this. Rays start up to 16 times the accuracy off the
/// edges of triangles, an eighth of this distance.
const REFUSED_BELOW: f64 = 128.0;
/// A scene gets a warning if the same ratio is below this.
const DOUBTFUL_BELOW: f64 = 1024.0;

/// How far light travels in a scene, and how accurate the positions of rays are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proportions {
    /// Median distance in m from luminaires to the next surface, or from receivers if that is shorter.
    pub median_way_m: f64,
    /// Where these lines start.
    pub from: &'static str,
    /// Accuracy of positions in m.
    pub accuracy_m: f64,
}

/// The reliability of results that the proportions allow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trust {
    /// Results are valid.
    Sound,
    /// Results may be off by a percent.
    Doubtful,
    /// Results may be off by any amount.
    None,
}

impl Proportions {
    /// Traces straight lines from luminaires and from receivers, in f64 and triangle by triangle. `None` where nothing is met.
    ///
    /// Units: m. Accuracy: a median of 16 to 256 lines.
    pub fn of(scene: &Scene) -> Option<Proportions> {
        let ways = (LINES_BY_TRIANGLES / scene.triangles.len().max(1)).clamp(FEWEST_WAYS, MOST_WAYS);
        let starts = [("luminaires", starts_of_luminaires(scene)), ("receivers", starts_of_receivers(scene))];
        let medians = starts.into_iter().filter_map(|(from, starts)| Some((median_way_m(scene, &starts, ways)?, from)));
        let (median_way_m, from) = medians.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Proportions { median_way_m, from, accuracy_m: position_accuracy_m(scene) })
    }

    /// Returns whether rays are accurate enough.
    pub fn trust(&self) -> Trust {
        match self.median_way_m / self.accuracy_m {
            ratio if ratio >= DOUBTFUL_BELOW => Trust::Sound,
            ratio if ratio >= REFUSED_BELOW => Trust::Doubtful,
            _ => Trust::None,
        }
    }

    /// Whether most of this light meets a surface where it starts. The cause is then not the size: it shines into the surface on which it
    /// lies.
    pub fn starts_on_surfaces(&self) -> bool {
        self.median_way_m <= ON_SURFACE_M
    }

    /// Returns the accuracy in m at which results would be reliable.
    pub fn accuracy_wanted_m(&self) -> f64 {
        self.median_way_m / DOUBTFUL_BELOW
    }
}

/// A point, and the axis of the half-space that it looks into; zero if it looks in all directions.
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

/// Returns the median length of the lines that meet something, spread over the starts and over their directions.
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

/// Returns one of many directions that fill a sphere evenly, or the half of it around an axis.
fn direction(number: usize, middle: DVec3) -> DVec3 {
    /// The fraction for steps in z differs from the one for turns, so that even a few lines differ.
    const SILVER: f64 = 0.414_213_562_373_095_05;
    let azimuth = TAU * (number as f64 * GOLDEN).fract();
    let z = 1.0 - 2.0 * (0.5 + number as f64 * SILVER).fract();
    let (sine, cosine) = azimuth.sin_cos();
    let across = (1.0 - z * z).max(0.0).sqrt();
    let direction = DVec3::new(across * cosine, across * sine, z);
    if direction.dot(middle) < 0.0 { -direction } else { direction }
}
