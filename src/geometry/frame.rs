//! The tracer's own coordinates: the scene's bounding box, centred and scaled to [−1, 1] in f64, and then rounded to f32.

use glam::{DVec3, Vec3};

use crate::scene::Scene;

/// Half-extent in m that is used where a scene has no extent.
const EXTENT_OF_A_POINT_M: f64 = 1.0;

/// Maps metres to the tracer's coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    center_m: DVec3,
    half_extent_m: f64,
}

impl Frame {
    /// Makes a frame around everything that rays start from or meet: vertices, balls, point luminaires and receivers.
    pub fn of(scene: &Scene) -> Frame {
        let mut low = DVec3::splat(f64::INFINITY);
        let mut high = DVec3::splat(f64::NEG_INFINITY);
        let mut include = |point_m: DVec3, radius_m: f64| {
            low = low.min(point_m - radius_m);
            high = high.max(point_m + radius_m);
        };
        scene.vertices_m.iter().for_each(|vertex_m| include(*vertex_m, 0.0));
        for luminaire in &scene.luminaires {
            if let Some(place_m) = luminaire.emission.place_m() {
                include(place_m, luminaire.emission.radius_m());
            }
        }
        scene.bodies.iter().for_each(|body| include(body.center_m, body.bounds.high));
        let receivers = scene.receivers.iter().flat_map(|set| set.placed_points());
        receivers.for_each(|point| include(point.position_m, 0.0));
        if !(low.is_finite() && high.is_finite()) {
            return Frame { center_m: DVec3::ZERO, half_extent_m: EXTENT_OF_A_POINT_M };
        }
        let half_extent_m = (0.5 * (high - low)).max_element();
        let half_extent_m = if half_extent_m > 0.0 { half_extent_m } else { EXTENT_OF_A_POINT_M };
        Frame { center_m: low + 0.5 * (high - low), half_extent_m }
    }

    /// Converts a point to the tracer's coordinates, without rounding to f32.
    #[inline]
    pub fn to_local(self, point_m: DVec3) -> DVec3 {
        (point_m - self.center_m) / self.half_extent_m
    }

    /// Converts a point to the tracer's coordinates, rounded to f32.
    #[inline]
    pub fn round(self, point_m: DVec3) -> Vec3 {
        self.to_local(point_m).as_vec3()
    }

    /// Converts a point from the tracer's coordinates to metres.
    #[inline]
    pub fn to_metres(self, point: DVec3) -> DVec3 {
        self.center_m + point * self.half_extent_m
    }

    /// Converts a length from the tracer's coordinates to metres.
    #[inline]
    pub fn metres(self, length: f64) -> f64 {
        length * self.half_extent_m
    }

    /// Converts a length from metres to the tracer's coordinates.
    #[inline]
    pub fn length(self, length_m: f64) -> f64 {
        length_m / self.half_extent_m
    }
}
