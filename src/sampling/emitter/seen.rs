//! Emitters as an observer sees them: openings on a line of sight, and the parts of a source that may cause glare.

use glam::DVec3;

use super::light::{Light, SeenPart};
use super::{Emitter, EmitterShape, of_light};
use crate::sampling::random::Stream;

/// Smallest projected area of a source in m². A smaller source counts with this area and the matching luminance (CIE 147:2002, small
/// sources).
pub const SMALLEST_SOURCE_M2: f64 = 0.005;
impl Emitter {
    /// Returns the distance in m at which a line of sight meets a luminous opening, and its luminance I/A_projected in cd/m².
    pub fn opening_on_sight(&self, eye_m: DVec3, direction: DVec3) -> Option<(f64, f64)> {
        let met = of_light!(&self.shape, light => light.opening_on_sight(eye_m, direction));
        met.filter(|(_, luminance_cd_m2)| *luminance_cd_m2 > 0.0 && luminance_cd_m2.is_finite())
    }

    /// Returns the distance in m at which a line of sight meets the emitter's ball; the line must meet it. Infinite for other emitters.
    pub fn ball_at_m(&self, eye_m: DVec3, direction: DVec3) -> f64 {
        of_light!(&self.shape, light => light.ball_at_m(eye_m, direction)).unwrap_or(f64::INFINITY)
    }

    /// Shows the parts of the emitter that an eye would see, each with a randomly drawn point of it.
    ///
    /// A point-like luminaire is one part: its intensity towards the eye over its projected area, both from the middle of the opening. A
    /// ball is one part too. Triangles are cut into parts of a few degrees. Glare of sky and sun is rated by other formulas.
    pub fn show_parts(&self, eye_m: DVec3, stream: &mut Stream, mut show: impl FnMut(SeenPart)) {
        of_light!(&self.shape, light => light.show_parts(eye_m, stream, &mut show));
    }
}

/// Shows one part of intensity I, represented by its middle: L²ω = I²/(A d²).
pub(super) fn show_point(
    light: &impl Light,
    middle_m: DVec3,
    point_m: DVec3,
    area_m2: f64,
    eye_m: DVec3,
    show: &mut dyn FnMut(SeenPart),
) {
    let offset_m = middle_m - eye_m;
    let square_m2 = offset_m.length_squared();
    let towards = offset_m.normalize_or_zero();
    let intensity_cd = light.intensity_cd(-towards);
    if square_m2 > 0.0 && intensity_cd > 0.0 {
        let squared_luminance_sr = intensity_cd * intensity_cd / (area_m2.max(SMALLEST_SOURCE_M2) * square_m2);
        show(SeenPart { towards, squared_luminance_sr, place: light.place_of_point(point_m) });
    }
}
