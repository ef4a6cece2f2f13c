//! Directions: tests for parallel vectors, and the frame of a rotated luminaire.

use glam::DVec3;

use super::placing::sin_cos_deg;

/// Sine of the smallest angle between vectors that span a plane. Below it rounding decides the normal.
const SMALLEST_SINE: f64 = 1e-9;
/// Largest |cosine| between directions that count as perpendicular: far above rounding, far below any intended angle.
const PERPENDICULAR_COSINE: f64 = 1e-9;

/// Unit vector along a vector of any length; 0 stays 0.
pub(super) fn direction(vector: DVec3) -> DVec3 {
    let largest = vector.abs().max_element();
    if largest == 0.0 { DVec3::ZERO } else { (vector / largest).normalize() }
}

/// Whether two vectors are neither 0 nor parallel.
pub(super) fn span_a_plane(u: DVec3, v: DVec3) -> bool {
    direction(u).cross(direction(v)).length() > SMALLEST_SINE
}

/// Whether two vectors are at right angles.
pub(super) fn are_perpendicular(u: DVec3, v: DVec3) -> bool {
    direction(u).dot(direction(v)).abs() <= PERPENDICULAR_COSINE
}

/// Unit vectors of C0, C90 and γ = 0 of a luminaire that aims along the unit vector `aim`.
///
/// C0 is +x, carried along by the smallest rotation from −z to `aim` (for aim = +z: +x itself). C90 = C0 × aim. A positive `rotation_deg`
/// turns C0 towards C90.
pub(super) fn photometric_frame(aim: DVec3, rotation_deg: f64) -> [DVec3; 3] {
    let c0 = unturned_c0(aim);
    let c90 = c0.cross(aim).normalize();
    let (sin, cos) = sin_cos_deg(rotation_deg);
    [cos * c0 + sin * c90, cos * c90 - sin * c0, aim]
}

/// Returns +x, carried along by the smallest rotation from −z to `aim`.
fn unturned_c0(aim: DVec3) -> DVec3 {
    /// Below this squared sine, aim equals +z up to rounding, and every half turn is a smallest rotation.
    const STRAIGHT_UP: f64 = 1e-24;
    let sine_squared = aim.x * aim.x + aim.y * aim.y;
    if aim.z > 0.0 && sine_squared < STRAIGHT_UP {
        return DVec3::X;
    }

    // Rodrigues' formula for the rotation from −z to aim, with 1 + cos(angle) = 1 − aim.z. Near +z that difference cancels, but (1 − z) =
    // sin²/(1 + z) does not.
    let one_plus_cos = if aim.z > 0.0 { sine_squared / (1.0 + aim.z) } else { 1.0 - aim.z };
    let c0 = DVec3::new(1.0 - aim.x * aim.x / one_plus_cos, -aim.x * aim.y / one_plus_cos, aim.x);

    // Make it exactly perpendicular to aim again.
    (c0 - aim * c0.dot(aim)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    #[test]
    fn a_downlight_has_c0_along_x_and_c90_along_y() {
        let [c0, c90, axis] = photometric_frame(-DVec3::Z, 0.0);
        // C90 = C0 × aim = x × (−z) = y.
        assert_eq!((c0, c90, axis), (DVec3::X, DVec3::Y, -DVec3::Z));
        assert_eq!(photometric_frame(-DVec3::Z, 90.0)[0], DVec3::Y);
        let [c0, c90, _] = photometric_frame(DVec3::Z, 0.0);
        assert_eq!((c0, c90), (DVec3::X, -DVec3::Y));
    }

    #[test]
    fn c0_is_carried_by_the_smallest_rotation() {
        for aim in [
            DVec3::X,
            DVec3::Y,
            DVec3::new(-1.0, 0.0, 0.0),
            DVec3::new(1.0, 2.0, 3.0),
            DVec3::new(-0.3, 0.2, -5.0),
            DVec3::new(1e-6, -2e-6, 1.0),
        ] {
            let aim = aim.normalize();
            let expected = DQuat::from_rotation_arc(-DVec3::Z, aim) * DVec3::X;
            let [c0, c90, _] = photometric_frame(aim, 0.0);
            assert!(c0.distance(expected) < 1e-9, "{aim}: {c0} {expected}");
            assert!(c90.distance(c0.cross(aim)) < 1e-15 && c0.dot(aim).abs() < 1e-15);
        }
        // For an aim along +x, the former +x points up.
        assert!(photometric_frame(DVec3::X, 0.0)[0].distance(DVec3::Z) < 1e-15);
    }

    #[test]
    fn a_turn_goes_from_c0_to_c90() {
        let aim = DVec3::new(0.3, -0.4, -0.5).normalize();
        let [c0, c90, _] = photometric_frame(aim, 0.0);
        let [turned, across, _] = photometric_frame(aim, 90.0);
        assert!(turned.distance(c90) < 1e-15 && across.distance(-c0) < 1e-15);
        let [turned, ..] = photometric_frame(aim, 30.0);
        assert!((turned.dot(c90) - 0.5).abs() < 1e-15);
    }
}
