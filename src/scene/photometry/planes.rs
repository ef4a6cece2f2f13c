//! Completes the stored planes of a file to a full turn.

use super::LateralSymmetry;

/// Largest difference in degrees between angles of the same plane. Files have at most a few decimals.
const SAME_PLANE_DEG: f64 = 1e-6;

/// Planes from C = 0° to 360° with their intensities, and their inconsistency.
pub(super) struct FullTurn {
    pub c_deg: Vec<f64>,
    pub intensity: Vec<f64>,
    /// Largest relative difference between two values of a file for the same direction.
    pub disagreement: f64,
}

/// Mirrors the stored planes by the symmetry and closes the turn.
///
/// `stored_c_deg` holds the angles of the planes in degrees (any turn). `values` holds their intensities plane by plane, `row` values
/// each.
pub(super) fn unfold(stored_c_deg: &[f64], values: &[f64], row: usize, symmetry: LateralSymmetry) -> FullTurn {
    let plane = |index: usize| &values[index * row..][..row];
    if symmetry == LateralSymmetry::Rotational {
        let intensity = [plane(0), plane(0)].concat();
        return FullTurn { c_deg: vec![0.0, 360.0], intensity, disagreement: 0.0 };
    }

    // Every stored plane gives itself and its mirror images. The stored planes come first, so they take precedence.
    let images = |c: f64| match symmetry {
        LateralSymmetry::None | LateralSymmetry::Rotational => vec![c],
        LateralSymmetry::AboutC0 => vec![c, -c],
        LateralSymmetry::AboutC90 => vec![c, 180.0 - c],
        LateralSymmetry::Quadrant => vec![c, -c, 180.0 - c, 180.0 + c],
    };
    let mut turn: Vec<(f64, usize)> = Vec::new();
    for (index, &c) in stored_c_deg.iter().enumerate() {
        for image in images(c) {
            let inside = image.rem_euclid(360.0);
            turn.push((if 360.0 - inside < SAME_PLANE_DEG { 0.0 } else { inside }, index));
        }
    }
    turn.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));

    // Of coincident planes the one stored first is kept.
    let mut disagreement: f64 = 0.0;
    let scale = values.iter().copied().fold(0.0, f64::max);
    let mut kept: Vec<(f64, usize)> = Vec::with_capacity(turn.len() + 1);
    for (c, index) in turn {
        match kept.last() {
            Some(&(before, other)) if c - before < SAME_PLANE_DEG => {
                let apart = |(a, b): (&f64, &f64)| if scale > 0.0 { (a - b).abs() / scale } else { 0.0 };
                disagreement = plane(index).iter().zip(plane(other)).map(apart).fold(disagreement, f64::max);
            }
            _ => kept.push((c, index)),
        }
    }

    // A turn that does not start at 0 is closed by interpolation between its last and first plane.
    let (first, last) = (kept[0], kept[kept.len() - 1]);
    let mut c_deg: Vec<f64> = kept.iter().map(|&(c, _)| c).collect();
    let mut intensity: Vec<f64> = kept.iter().flat_map(|&(_, index)| plane(index).iter().copied()).collect();
    let seam: Vec<f64> = match first.0 < SAME_PLANE_DEG {
        true => plane(first.1).to_vec(),
        false => {
            let share = (360.0 - last.0) / (first.0 + 360.0 - last.0);
            plane(last.1).iter().zip(plane(first.1)).map(|(a, b)| a + (b - a) * share).collect()
        }
    };
    if first.0 < SAME_PLANE_DEG {
        c_deg[0] = 0.0;
    } else {
        c_deg.insert(0, 0.0);
        intensity.splice(0..0, seam.iter().copied());
    }
    c_deg.push(360.0);
    intensity.extend(seam);
    FullTurn { c_deg, intensity, disagreement }
}
