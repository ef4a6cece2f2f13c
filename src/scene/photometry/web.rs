//! The luminous intensity distribution of a luminaire: a table over two angles, bilinear between its entries.

use glam::DVec3;

use super::zones::sine_moments;

/// Tolerance in degrees at the edge of a table. A direction in f64 returns its angles to some 1e-14 rad, so a direction on the edge may
/// appear outside.
const EDGE_TOLERANCE_DEG: f64 = 1e-9;

/// Step in degrees of the search for beam angles, if the table's own angles do not lie in the requested plane.
const PROFILE_STEP_DEG: f64 = 0.125;

/// The goniometer of a table: it determines the axis about which the planes turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PhotometricType {
    /// Planes turn about the vertical; (0°, 0°) is the horizontal direction C0, γ = 90°. Headlamps.
    A,
    /// Planes turn about the horizontal axis C90–C270; (0°, 0°) is the axis γ = 0. Floodlights.
    B,
    /// Planes turn about the axis γ = 0. Nearly all luminaires have it, and every EULUMDAT file.
    C,
}

/// Luminous intensity in cd over the whole sphere, bilinear in the two angles of its goniometer.
///
/// Type C: planes run from C = 0° to C = 360° (the last repeats the first), γ from 0° (the luminaire's axis) to 180°. Types A and B keep
/// their own angles, so nothing is resampled. Their planes and angles need not go all the way round. [`IntensityWeb::intensity_cd`] takes
/// (C, γ) for every type. Directions outside the table have 0 cd.
#[derive(Clone, Debug, PartialEq)]
pub struct IntensityWeb {
    /// Angles of the planes in degrees, strictly increasing: C for type C (first 0, last 360),
    /// 180° − horizontal for type A, 180° + vertical for type B.
    pub c_deg: Vec<f64>,
    /// Angles within a plane in degrees, strictly increasing: γ for type C, 90° + vertical for A, 90° + horizontal for B.
    pub gamma_deg: Vec<f64>,
    /// Intensity in cd: `intensity_cd[plane * gamma_deg.len() + i]`.
    pub intensity_cd: Vec<f64>,
    goniometer: PhotometricType,
}

/// Why a table is not a valid intensity distribution.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{field}[{index}] is {got}, expected {expected}")]
pub struct WebError {
    /// `c_deg`, `gamma_deg` or `intensity_cd`.
    pub field: &'static str,
    /// Index of the entry.
    pub index: usize,
    /// The invalid value (a length if the length is wrong).
    pub got: f64,
    /// What is expected instead.
    pub expected: &'static str,
}

impl IntensityWeb {
    /// Makes a distribution from a table in type C angles, after checking it.
    ///
    /// # Errors
    /// Angles that are not strictly increasing, C that does not run from 0 to 360, γ outside of 0 to 180, a table of another size than
    /// planes × angles, and intensities that are negative or not finite.
    pub fn new(c_deg: Vec<f64>, gamma_deg: Vec<f64>, intensity_cd: Vec<f64>) -> Result<Self, WebError> {
        Self::on_goniometer(PhotometricType::C, c_deg, gamma_deg, intensity_cd)
    }

    /// Makes a distribution from a table in the angles of its goniometer, after checking it. The public fields describe these angles.
    ///
    /// # Errors
    /// As [`IntensityWeb::new`], except that only type C must go all the way round.
    pub fn on_goniometer(
        goniometer: PhotometricType,
        c_deg: Vec<f64>,
        gamma_deg: Vec<f64>,
        intensity_cd: Vec<f64>,
    ) -> Result<Self, WebError> {
        check_angles("c_deg", &c_deg, 360.0)?;
        check_angles("gamma_deg", &gamma_deg, 180.0)?;
        if goniometer == PhotometricType::C {
            let last = c_deg.len() - 1;
            for (index, wanted, expected) in [(0, 0.0, "0 (the first plane)"), (last, 360.0, "360 (the last plane)")] {
                if c_deg[index] != wanted {
                    return Err(WebError { field: "c_deg", index, got: c_deg[index], expected });
                }
            }
        }
        if Some(intensity_cd.len()) != c_deg.len().checked_mul(gamma_deg.len()) {
            let got = intensity_cd.len() as f64;
            let expected = "as many intensities as planes × angles";
            return Err(WebError { field: "intensity_cd", index: 0, got, expected });
        }
        if let Some(index) = intensity_cd.iter().position(|&cd| !(cd.is_finite() && cd >= 0.0)) {
            let expected = "a finite intensity of 0 cd or more";
            return Err(WebError { field: "intensity_cd", index, got: intensity_cd[index], expected });
        }
        Ok(IntensityWeb { c_deg, gamma_deg, intensity_cd, goniometer })
    }

    /// The goniometer of the table's angles.
    pub fn goniometer(&self) -> PhotometricType {
        self.goniometer
    }

    /// Intensity in cd at (C, γ) in degrees; C may be any angle, γ outside of 0 to 180 gives 0.
    ///
    /// Accuracy: exact for the bilinear interpolant.
    pub fn intensity_cd(&self, c_deg: f64, gamma_deg: f64) -> f64 {
        if self.goniometer == PhotometricType::C {
            return self.table_cd(c_deg.rem_euclid(360.0), gamma_deg);
        }
        if !(0.0..=180.0).contains(&gamma_deg) {
            return 0.0;
        }
        self.intensity_along_cd(direction_of(c_deg.to_radians(), gamma_deg.to_radians()))
    }

    /// Intensity in cd towards a direction of any length. `frame` holds the unit vectors of C0, C90 (both at γ = 90°) and γ = 0 in the
    /// same coordinates.
    pub fn intensity_towards_cd(&self, frame: &[DVec3; 3], direction: DVec3) -> f64 {
        let [c0, c90, axis] = *frame;
        self.intensity_along_cd(DVec3::new(direction.dot(c0), direction.dot(c90), direction.dot(axis)))
    }

    /// Intensity in cd along a direction of any length, with coordinates along C0, C90 and γ = 0.
    pub fn intensity_along_cd(&self, local: DVec3) -> f64 {
        let (plane_rad, angle_rad) = self.table_angles(local);
        self.table_cd(plane_rad.to_degrees(), angle_rad.to_degrees())
    }

    /// Luminous flux in lm: the exact integral of the interpolant over the sphere.
    ///
    /// Accuracy: rounding only. Sums of zonal lumens differ by some 0.1%, because they hold the intensity constant over a zone.
    pub fn luminous_flux_lm(&self) -> f64 {
        let planes: Vec<f64> = (0..self.c_deg.len()).map(|plane| self.plane_flux_lm_rad(plane)).collect();
        let columns = self.c_deg.windows(2).zip(planes.windows(2));
        columns.map(|(c, flux)| (c[1] - c[0]).to_radians() * 0.5 * (flux[0] + flux[1])).sum()
    }

    /// Flux in lm below the horizontal plane (γ < 90°, first) and above it, exact for type C tables.
    ///
    /// `None` for types A and B.
    pub fn hemisphere_fluxes_lm(&self) -> Option<[f64; 2]> {
        let below_lm = self.flux_within_lm(90.0)?;
        Some([below_lm, (self.luminous_flux_lm() - below_lm).max(0.0)])
    }

    /// Flux in lm within a cone about the axis, exact for type C tables; `None` for types A and B.
    ///
    /// A zone that crosses the edge of the cone is split there.
    pub fn flux_within_lm(&self, gamma_deg: f64) -> Option<f64> {
        if self.goniometer != PhotometricType::C {
            return None;
        }
        let mut within = self.clone();
        let keep = self.gamma_deg.iter().filter(|&&own| own < gamma_deg).count();
        if keep == 0 {
            return Some(0.0);
        }
        within.gamma_deg.truncate(keep);
        let crosses = self.gamma_deg.len() > keep;
        if crosses {
            within.gamma_deg.push(gamma_deg);
        }
        let column = |&c: &f64| within.gamma_deg.iter().map(move |&gamma| (c, gamma)).collect::<Vec<_>>();
        within.intensity_cd = self.c_deg.iter().flat_map(column).map(|(c, gamma)| self.table_cd(c, gamma)).collect();
        Some(within.luminous_flux_lm())
    }

    /// Whether no light goes to γ > 90°. Always false for types A and B.
    pub fn shines_ahead_only(&self) -> bool {
        let angles = self.gamma_deg.len();
        let ahead = self.gamma_deg.partition_point(|&gamma| gamma <= 90.0);
        // Between the last angle up to 90° and the first beyond it, the table interpolates. So the last angle up to 90° must be dark too.
        let first_to_be_dark = ahead.saturating_sub(1);
        let is_dark = |(entry, cd): (usize, &f64)| entry % angles < first_to_be_dark || *cd == 0.0;
        let is_dark_behind = || ahead == angles || self.intensity_cd.iter().enumerate().all(is_dark);
        self.goniometer == PhotometricType::C && is_dark_behind()
    }

    /// Greatest intensity in cd.
    pub fn maximum_intensity_cd(&self) -> f64 {
        self.intensity_cd.iter().copied().fold(0.0, f64::max)
    }

    /// Full angle in degrees, in the plane through `c_deg` and `c_deg` + 180°, within which the
    /// intensity is at least half of that plane's maximum; 0 for a dark plane.
    pub fn beam_angle_deg(&self, c_deg: f64) -> f64 {
        self.angle_above_deg(c_deg, 0.5)
    }

    /// Full angle in degrees, in the plane through `c_deg` and `c_deg` + 180°, within which the
    /// intensity is at least a tenth of that plane's maximum; 0 for a dark plane.
    pub fn field_angle_deg(&self, c_deg: f64) -> f64 {
        self.angle_above_deg(c_deg, 0.1)
    }

    /// Searches from the plane's maximum to both sides until the intensity falls below `share` of it.
    fn angle_above_deg(&self, c_deg: f64, share: f64) -> f64 {
        let profile = self.profile(c_deg);
        let (start, peak) = profile
            .iter()
            .enumerate()
            .fold((0, (0.0, -1.0)), |best, (index, &point)| if point.1 > best.1.1 { (index, point) } else { best });
        if peak.1 <= 0.0 {
            return 0.0;
        }
        let threshold = share * peak.1;
        let count = profile.len();
        let walk = |forward: bool| {
            let mut last = (0.0, peak.1);
            for step in 1..=count {
                let index = if forward { start + step } else { start + count - step } % count;
                let away = if forward { profile[index].0 - peak.0 } else { peak.0 - profile[index].0 };
                let here = (if away < last.0 { away + 360.0 } else { away }, profile[index].1);
                if here.1 < threshold {
                    return last.0 + (here.0 - last.0) * (last.1 - threshold) / (last.1 - here.1);
                }
                last = here;
            }
            180.0
        };
        (walk(true) + walk(false)).min(360.0)
    }

    /// The intensity over −180° < γ ≤ 180° (negative: towards C + 180°), linear between its points.
    fn profile(&self, c_deg: f64) -> Vec<(f64, f64)> {
        let own_angles = self.goniometer == PhotometricType::C;
        let gammas: Vec<f64> = match own_angles {
            true => self.gamma_deg.clone(),
            false => (0..=(180.0 / PROFILE_STEP_DEG) as usize).map(|i| i as f64 * PROFILE_STEP_DEG).collect(),
        };
        let side = |c: f64| {
            let mut points: Vec<(f64, f64)> =
                gammas.iter().map(|&gamma| (gamma, self.intensity_cd(c, gamma))).collect();
            if gammas[0] > 0.0 {
                points.insert(0, (gammas[0], 0.0));
            }
            if gammas[gammas.len() - 1] < 180.0 {
                points.push((gammas[gammas.len() - 1], 0.0));
            }
            points
        };
        let behind = side(c_deg + 180.0).into_iter().rev().map(|(gamma, cd)| (-gamma, cd));
        behind.filter(|&(gamma, _)| gamma > -180.0 && gamma < 0.0).chain(side(c_deg)).collect()
    }

    /// ∫ I sin θ dθ over one plane, in lm per radian of the plane's angle.
    fn plane_flux_lm_rad(&self, plane: usize) -> f64 {
        let row = &self.intensity_cd[plane * self.gamma_deg.len()..][..self.gamma_deg.len()];
        let zone = |(gamma, cd): (&[f64], &[f64])| {
            let moments = sine_moments(gamma[0].to_radians(), (gamma[1] - gamma[0]).to_radians());
            cd[0] * moments.whole + (cd[1] - cd[0]) * moments.ramp
        };
        self.gamma_deg.windows(2).zip(row.windows(2)).map(zone).sum()
    }

    /// The table's two angles in radians of a direction along C0, C90 and γ = 0. The first is 0 to 2π, the second 0 to π.
    pub(crate) fn table_angles(&self, local: DVec3) -> (f64, f64) {
        let own = match self.goniometer {
            PhotometricType::C => local,
            PhotometricType::A => DVec3::new(-local.x, -local.y, local.z),
            PhotometricType::B => DVec3::new(-local.z, -local.x, local.y),
        };
        let plane = own.y.atan2(own.x);
        let turned = if plane < 0.0 { plane + std::f64::consts::TAU } else { plane };
        (turned, (own.x * own.x + own.y * own.y).sqrt().atan2(own.z))
    }

    /// The unit vector along C0, C90 and γ = 0, from the table's two angles in radians.
    pub(crate) fn direction_at(&self, plane_rad: f64, angle_rad: f64) -> DVec3 {
        let own = direction_of(plane_rad, angle_rad);
        match self.goniometer {
            PhotometricType::C => own,
            PhotometricType::A => DVec3::new(-own.x, -own.y, own.z),
            PhotometricType::B => DVec3::new(-own.y, own.z, -own.x),
        }
    }

    /// Bilinear look-up in the table's own angles.
    fn table_cd(&self, plane_deg: f64, angle_deg: f64) -> f64 {
        let Some((i, s)) = bracket(&self.gamma_deg, angle_deg) else { return 0.0 };
        let Some((j, t)) = bracket(&self.c_deg, plane_deg) else { return 0.0 };
        let row = self.gamma_deg.len();
        let corner = |plane: usize, angle: usize| self.intensity_cd[plane * row + angle];
        let near = (1.0 - s) * corner(j, i) + s * corner(j, i + 1);
        let far = (1.0 - s) * corner(j + 1, i) + s * corner(j + 1, i + 1);
        (1.0 - t) * near + t * far
    }
}

/// Unit vector at polar angle `polar_rad` from the third axis, `azimuth_rad` from the first towards the second.
fn direction_of(azimuth_rad: f64, polar_rad: f64) -> DVec3 {
    let (sin_azimuth, cos_azimuth) = azimuth_rad.sin_cos();
    let (sin_polar, cos_polar) = polar_rad.sin_cos();
    DVec3::new(sin_polar * cos_azimuth, sin_polar * sin_azimuth, cos_polar)
}

/// Returns the interval of a strictly increasing list that contains an angle, and the angle's position in it (0 to 1).
///
/// The first guess is right for evenly spaced lists. Others need a binary search.
fn bracket(angles_deg: &[f64], angle_deg: f64) -> Option<(usize, f64)> {
    let last = angles_deg.len() - 1;
    let (from, to) = (angles_deg[0], angles_deg[last]);
    if !(angle_deg >= from - EDGE_TOLERANCE_DEG && angle_deg <= to + EDGE_TOLERANCE_DEG) {
        return None;
    }
    let angle = angle_deg.clamp(from, to);
    let guess = (((angle - from) / (to - from) * last as f64) as usize).min(last - 1);
    let holds = angles_deg[guess] <= angle && angle <= angles_deg[guess + 1];
    let index = match holds {
        true => guess,
        false => (angles_deg.partition_point(|&entry| entry <= angle) - 1).min(last - 1),
    };
    Some((index, (angle - angles_deg[index]) / (angles_deg[index + 1] - angles_deg[index])))
}

/// Refuses a list of angles unless it strictly increases within 0 to `limit_deg`.
fn check_angles(field: &'static str, angles_deg: &[f64], limit_deg: f64) -> Result<(), WebError> {
    if angles_deg.len() < 2 {
        return Err(WebError { field, index: 0, got: angles_deg.len() as f64, expected: "two angles or more" });
    }
    if let Some(index) = angles_deg.iter().position(|angle| !(0.0..=limit_deg).contains(angle)) {
        let expected = if limit_deg > 180.0 { "an angle from 0 to 360" } else { "an angle from 0 to 180" };
        return Err(WebError { field, index, got: angles_deg[index], expected });
    }
    match angles_deg.windows(2).position(|pair| pair[1] <= pair[0]) {
        None => Ok(()),
        Some(before) => {
            let index = before + 1;
            Err(WebError { field, index, got: angles_deg[index], expected: "an angle above the one before it" })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_shines_ahead_only_sends_nothing_past_ninety_degrees() {
        let web = |table: &[(f64, f64)]| {
            let (gamma_deg, cd): (Vec<f64>, Vec<f64>) = table.iter().copied().unzip();
            IntensityWeb::new(vec![0.0, 360.0], gamma_deg, [cd.clone(), cd].concat()).expect("a table")
        };
        for (table, expected) in [
            (vec![(0.0, 100.0), (85.0, 100.0), (95.0, 0.0), (180.0, 0.0)], false),
            (vec![(0.0, 100.0), (85.0, 100.0), (90.0, 0.0), (95.0, 0.0)], true),
            (vec![(0.0, 100.0), (90.0, 5.0)], true),
            (vec![(0.0, 100.0), (90.0, 5.0), (95.0, 0.0)], false),
            (vec![(0.0, 100.0), (85.0, 0.0), (95.0, 0.0)], true),
            (vec![(0.0, 0.0), (90.0, 0.0), (100.0, 3.0), (180.0, 0.0)], false),
            (vec![(120.0, 4.0), (150.0, 4.0)], false),
        ] {
            let web = web(&table);
            let behind_cd =
                (1..=900).map(|step| web.intensity_cd(10.0, 90.0 + 0.1 * f64::from(step))).fold(0.0, f64::max);
            assert_eq!(web.shines_ahead_only(), expected, "{table:?}");
            assert_eq!(behind_cd == 0.0, expected, "{table:?}");
        }
        let table = || (vec![90.0, 180.0, 270.0], vec![0.0, 90.0, 180.0], vec![1.0; 9]);
        for goniometer in [PhotometricType::A, PhotometricType::B] {
            let (planes, angles, cd) = table();
            let web = IntensityWeb::on_goniometer(goniometer, planes, angles, cd).expect("a table");
            assert!(!web.shines_ahead_only());
        }
    }
}
