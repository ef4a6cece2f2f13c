//! A cheap measure of how much an emitter matters at a point. A choice among many emitters evaluates it for all of them.

use std::sync::Arc;

use glam::DVec3;

use crate::scene::photometry::IntensityWeb;

/// Steps of cos γ in the table of a photometric distribution.
const PROFILE_STEPS: usize = 64;
/// Directions that are evaluated within each step of cos γ: this number of γ values in this number of planes.
const SAMPLES_IN_GAMMA: usize = 5;
const SAMPLES_IN_C: usize = 72;

/// A beacon is near if its radius is more than this share of its distance.
pub const NEAR_RADIUS_PER_DISTANCE: f64 = 0.25;
/// Two emitters aim alike if the cosine between their axes is above this.
const ALIKE: f64 = 0.999;

/// An emitter reduced to a ball with an axis. It bounds the illuminance at a point from above, within a small factor.
#[derive(Clone, Debug)]
pub(super) struct Beacon {
    pub center_m: DVec3,
    pub radius_m: f64,
    pub axis: DVec3,
    /// Intensity in cd that the profile multiplies.
    pub intensity_cd: f64,
    pub profile: Profile,
    /// Smaller beacons that replace this one at near points. Used for an emitter that fills little of its ball, where the ball alone is a
    /// poor bound.
    pub parts: Arc<[Beacon]>,
}

/// How intensity depends on the angle from the axis.
#[derive(Clone, Debug)]
pub(super) enum Profile {
    /// Intensity does not depend on the angle.
    Uniform,
    /// Intensity follows the cosine, raised to allow for the emitter's own extent.
    Cosine,
    /// The same for an emitter that lies in the plane through its centre. It gives no light behind that plane and little near it.
    Flat,
    /// A table over equal steps of cos γ from −1 to 1. Each entry is the largest value over all planes.
    Table(Arc<[f64; PROFILE_STEPS]>),
}

impl Profile {
    /// Makes the table of a distribution: its largest intensity in each step of cos γ, in cd.
    pub fn of(web: &IntensityWeb) -> Profile {
        let local = [DVec3::X, DVec3::Y, DVec3::Z];
        let mut table = [0.0f64; PROFILE_STEPS];
        for (step, largest) in table.iter_mut().enumerate() {
            for i in 0..=SAMPLES_IN_GAMMA {
                let cos_gamma = -1.0 + 2.0 * (step as f64 + i as f64 / SAMPLES_IN_GAMMA as f64) / PROFILE_STEPS as f64;
                let sin_gamma = (1.0 - cos_gamma * cos_gamma).max(0.0).sqrt();
                for j in 0..SAMPLES_IN_C {
                    let (sin, cos) = (std::f64::consts::TAU * j as f64 / SAMPLES_IN_C as f64).sin_cos();
                    let direction = DVec3::new(sin_gamma * cos, sin_gamma * sin, cos_gamma);
                    *largest = largest.max(web.intensity_towards_cd(&local, direction));
                }
            }
        }
        // A floor for directions between the evaluated ones: they become rare instead of impossible.
        let floor = 1e-3 * table.iter().copied().fold(0.0, f64::max);
        table.iter_mut().for_each(|intensity| *intensity = intensity.max(floor));
        Profile::Table(Arc::new(table))
    }

    /// Returns the factor on the intensity at a cosine from the axis. The caller has raised the cosine, up to 1, for the emitter's extent.
    #[inline]
    pub fn at(&self, cosine: f64) -> f64 {
        match self {
            Profile::Uniform => 1.0,
            Profile::Cosine | Profile::Flat => cosine.max(0.0),
            Profile::Table(table) => {
                table[((0.5 * (cosine + 1.0) * PROFILE_STEPS as f64) as usize).min(PROFILE_STEPS - 1)]
            }
        }
    }
}

impl Beacon {
    /// Largest intensity in any direction, in cd.
    pub fn largest_intensity_cd(&self) -> f64 {
        match &self.profile {
            Profile::Uniform | Profile::Cosine | Profile::Flat => self.intensity_cd,
            Profile::Table(table) => self.intensity_cd * table.iter().copied().fold(0.0, f64::max),
        }
    }

    /// Whether a point is near relative to the beacon's size, so that the importance of the whole ball is a poor measure there.
    #[inline]
    pub fn is_near(&self, point_m: DVec3) -> bool {
        self.spans(point_m, NEAR_RADIUS_PER_DISTANCE)
    }

    /// Whether the radius is more than this share of the distance to a point.
    #[inline]
    pub fn spans(&self, point_m: DVec3, share: f64) -> bool {
        self.center_m.distance_squared(point_m) * share * share < self.radius_m * self.radius_m
    }

    /// Returns intensity and profile of one beacon that replaces this and another one, if both aim alike and have the same kind of profile.
    pub fn profile_with(&self, other: &Beacon) -> Option<(f64, Profile)> {
        if self.axis.dot(other.axis) < ALIKE {
            return None;
        }
        let sum = self.intensity_cd + other.intensity_cd;
        match (&self.profile, &other.profile) {
            (Profile::Cosine | Profile::Flat, Profile::Cosine | Profile::Flat) => Some((sum, Profile::Cosine)),
            (Profile::Uniform, Profile::Uniform) => Some((sum, Profile::Uniform)),
            (Profile::Table(own), Profile::Table(others)) => {
                let mixed = std::array::from_fn(|step| {
                    (self.intensity_cd * own[step] + other.intensity_cd * others[step]) / sum
                });
                Some((sum, Profile::Table(Arc::new(mixed))))
            }
            _ => None,
        }
    }

    /// Returns the importance at a point with a unit normal, in lx. It is 0 only where the emitter gives no light.
    #[inline]
    pub fn importance_lx(&self, point_m: DVec3, normal: DVec3) -> f64 {
        if self.parts.is_empty() || !self.is_near(point_m) {
            return self.importance_of_ball(point_m, normal);
        }
        self.parts.iter().map(|part| part.importance_of_ball(point_m, normal)).sum()
    }

    #[inline]
    fn importance_of_ball(&self, point_m: DVec3, normal: DVec3) -> f64 {
        let offset = self.center_m - point_m;
        let distance_squared = offset.length_squared().max(f64::MIN_POSITIVE);
        let inverse = 1.0 / distance_squared.sqrt();
        // Tilting by the angle that the radius covers raises a cosine by at most radius/distance.
        let spread = (self.radius_m * inverse).min(1.0);
        // For a point inside the ball, the emitter can be anywhere above the horizon.
        let is_within = spread >= 1.0;
        let at_receiver = if is_within { 1.0 } else { (offset.dot(normal) * inverse + spread).min(1.0) };
        if at_receiver <= 0.0 {
            return 0.0;
        }
        let height_m = -offset.dot(self.axis);
        let profile = match &self.profile {
            Profile::Flat if height_m <= 0.0 => return 0.0,
            // All points of the emitter are at this height. None of them is nearer than it, nor than the surface of the ball.
            Profile::Flat => height_m / height_m.max(distance_squared * inverse - self.radius_m),
            Profile::Cosine if is_within => 1.0,
            profile => profile.at((height_m * inverse + spread).min(1.0)),
        };
        self.intensity_cd * profile * at_receiver / distance_squared.max(self.radius_m * self.radius_m)
    }
}
