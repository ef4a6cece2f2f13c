//! Position of the sun by location and time.
//!
//! Source: J. Meeus, Astronomical Algorithms, 2nd edition, chapters 7, 12, 13, 22 and 25 (lower accuracy); refraction by chapter 16.
//! Accuracy: 0.01° in both angles from 1950 to 2050 and beyond. The difference between universal time and uniform time is neglected.

use glam::DVec3;

/// Julian date of noon on 1 January 2000.
const J2000_DAYS: f64 = 2_451_545.0;
/// Parallax of the sun at the horizon in degrees: 8.794″.
const PARALLAX_DEG: f64 = 8.794 / 3600.0;
/// Pressure in hPa and temperature in °C for which the refraction by the air is computed.
const AIR: [f64; 2] = [1010.0, 10.0];
/// Below this elevation of its centre in degrees, refraction no longer lifts the sun above the horizon.
const SET_DEG: f64 = -0.8333;

/// A moment, as days since the Julian era began.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    julian_days: f64,
}

/// Days of the months of a common year.
pub const DAYS_OF_MONTHS: [u32; 12] = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];

impl Moment {
    /// Makes a moment from a date of the Gregorian calendar and a time in hours of universal time. The time may lie outside that day.
    pub fn of_date(year: i32, month: u32, day: u32, hours: f64) -> Moment {
        let (year, month) = if month > 2 { (f64::from(year), month) } else { (f64::from(year) - 1.0, month + 12) };
        let century = (year / 100.0).floor();
        let leap_days = 2.0 - century + (century / 4.0).floor();
        let days = (365.25 * (year + 4716.0)).floor() + (30.6001 * f64::from(month + 1)).floor();
        Moment { julian_days: days + f64::from(day) + hours / 24.0 + leap_days - 1524.5 }
    }

    /// Returns Julian centuries since 2000.
    fn centuries(self) -> f64 {
        (self.julian_days - J2000_DAYS) / 36525.0
    }
}

/// Position of the sun among the stars, in degrees.
#[derive(Clone, Copy, Debug)]
struct Apparent {
    right_ascension_deg: f64,
    declination_deg: f64,
    /// Apparent sidereal time in Greenwich.
    sidereal_deg: f64,
}

impl Apparent {
    fn at(moment: Moment) -> Apparent {
        let t = moment.centuries();
        let mean_longitude_deg = 280.46646 + 36_000.769_83 * t + 0.000_303_2 * t * t;
        let anomaly = (357.52911 + 35_999.050_29 * t - 0.000_153_7 * t * t).to_radians();
        let center_deg = (1.914_602 - 0.004_817 * t - 0.000_014 * t * t) * anomaly.sin()
            + (0.019_993 - 0.000_101 * t) * (2.0 * anomaly).sin()
            + 0.000_289 * (3.0 * anomaly).sin();
        let node = (125.04 - 1934.136 * t).to_radians();
        // Aberration and nutation in longitude.
        let longitude_deg = mean_longitude_deg + center_deg - 0.00569 - 0.00478 * node.sin();
        let mean_obliquity_deg =
            23.0 + (26.0 + (21.448 - 46.8150 * t - 0.00059 * t * t + 0.001_813 * t * t * t) / 60.0) / 60.0;
        let obliquity = (mean_obliquity_deg + 0.00256 * node.cos()).to_radians();
        let longitude = longitude_deg.to_radians();
        let right_ascension = (obliquity.cos() * longitude.sin()).atan2(longitude.cos());
        let days = moment.julian_days - J2000_DAYS;
        let mean_sidereal_deg =
            280.460_618_37 + 360.985_647_366_29 * days + 0.000_387_933 * t * t - t * t * t / 38_710_000.0;
        Apparent {
            right_ascension_deg: right_ascension.to_degrees().rem_euclid(360.0),
            declination_deg: (obliquity.sin() * longitude.sin()).asin().to_degrees(),
            sidereal_deg: (mean_sidereal_deg - 0.00478 * node.sin() * obliquity.cos()).rem_euclid(360.0),
        }
    }
}

/// Returns elevation and azimuth of the sun in degrees, without refraction. The azimuth counts from north towards east.
fn without_air_deg(latitude_deg: f64, longitude_deg: f64, moment: Moment) -> [f64; 2] {
    let sun = Apparent::at(moment);
    let hour_angle = (sun.sidereal_deg + longitude_deg - sun.right_ascension_deg).to_radians();
    let (latitude, declination) = (latitude_deg.to_radians(), sun.declination_deg.to_radians());
    let up = latitude.sin() * declination.sin() + latitude.cos() * declination.cos() * hour_angle.cos();
    let north = latitude.cos() * declination.sin() - latitude.sin() * declination.cos() * hour_angle.cos();
    let east = -declination.cos() * hour_angle.sin();
    let elevation_deg = up.atan2(north.hypot(east)).to_degrees();
    [elevation_deg - PARALLAX_DEG * elevation_deg.to_radians().cos(), east.atan2(north).to_degrees().rem_euclid(360.0)]
}

/// Returns the angle in degrees by which the air lifts the sun, at a pressure in hPa and a temperature in °C.
fn refraction_deg(elevation_deg: f64, [pressure_hpa, temperature_c]: [f64; 2]) -> f64 {
    if elevation_deg < SET_DEG {
        return 0.0;
    }
    let angle = (elevation_deg + 10.3 / (elevation_deg + 5.11)).to_radians();
    (pressure_hpa / 1010.0) * (283.0 / (273.0 + temperature_c)) * 1.02 / (60.0 * angle.tan())
}

/// Returns elevation and azimuth in degrees at which the sun is seen, with refraction at 1010 hPa and 10 °C. The azimuth counts from north
/// towards east. Latitude is positive to the north of the equator, longitude to the east of Greenwich.
pub fn solar_position_deg(latitude_deg: f64, longitude_deg: f64, moment: Moment) -> [f64; 2] {
    let [elevation_deg, azimuth_deg] = without_air_deg(latitude_deg, longitude_deg, moment);
    [elevation_deg + refraction_deg(elevation_deg, AIR), azimuth_deg]
}

/// Returns the unit vector of an elevation and an azimuth in degrees: x is east, y north and z up.
pub fn direction_of(elevation_deg: f64, azimuth_deg: f64) -> DVec3 {
    let ((height, flat), (east, north)) = (elevation_deg.to_radians().sin_cos(), azimuth_deg.to_radians().sin_cos());
    DVec3::new(flat * east, flat * north, height)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares with Meeus, examples 7.a, 12.a and 25.a.
    #[test]
    fn days_sidereal_time_and_the_sun_are_those_of_the_book() {
        assert!((Moment::of_date(1957, 10, 4, 0.81 * 24.0).julian_days - 2_436_116.31).abs() < 1e-9);
        let sidereal = Moment::of_date(1987, 4, 10, 0.0);
        assert!((sidereal.julian_days - 2_446_895.5).abs() < 1e-9);
        // Apparent sidereal time, 13 h 10 min 46.1351 s.
        let apparent_deg = 15.0 * (13.0 + 10.0 / 60.0 + 46.1351 / 3600.0);
        assert!((Apparent::at(sidereal).sidereal_deg - apparent_deg).abs() < 2e-4);
        let sun = Apparent::at(Moment::of_date(1992, 10, 13, 0.0));
        assert!((sun.right_ascension_deg - 198.38083).abs() < 1e-4, "{sun:?}");
        assert!((sun.declination_deg + 7.78507).abs() < 1e-4, "{sun:?}");
    }

    /// The example of NREL's solar position algorithm (Reda and Andreas 2008, appendix A.5): Golden, 17 October 2003, 12:30:30 at UTC − 7
    /// h, zenith angle 50.11162° at 820 hPa and 11 °C, azimuth 194.34024°. One hour later, the planted fault, is detected.
    #[test]
    fn the_sun_stands_where_the_solar_position_algorithm_has_it() {
        let at = |hours: f64| {
            let moment = Moment::of_date(2003, 10, 17, hours);
            let [elevation_deg, azimuth_deg] = without_air_deg(39.742476, -105.1786, moment);
            [90.0 - elevation_deg - refraction_deg(elevation_deg, [820.0, 11.0]), azimuth_deg]
        };
        let is_close = |[zenith_deg, azimuth_deg]: [f64; 2]| {
            (zenith_deg - 50.11162).abs() < 0.01 && (azimuth_deg - 194.34024).abs() < 0.01
        };
        let hours = 19.0 + 30.5 / 60.0;
        assert!(is_close(at(hours)), "{:?}", at(hours));
        assert!(!is_close(at(hours + 1.0)), "the planted fault passed");
        assert!((refraction_deg(39.872046, [820.0, 11.0]) - 0.016332).abs() < 2e-6);
    }

    /// At the tropic the sun stands in the zenith at noon of the solstice. At the pole its elevation equals its declination all day. In
    /// polar night it stays below the horizon.
    #[test]
    fn solstices_and_poles() {
        let solstice = |hours: f64| Moment::of_date(2025, 6, 21, hours);
        let highest = (0..240).map(|step| solar_position_deg(23.44, 0.0, solstice(11.0 + f64::from(step) / 120.0))[0]);
        assert!(highest.fold(0.0, f64::max) > 89.9);
        for hours in [0.0, 5.0, 13.0, 21.0] {
            assert!((solar_position_deg(90.0, 0.0, solstice(hours))[0] - 23.45).abs() < 0.05);
            assert!(solar_position_deg(-80.0, 30.0, solstice(hours))[0] < -13.0);
        }
    }
}
