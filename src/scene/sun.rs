//! Reads luminaires that are the sun, and the position of a sky's sun.

use glam::DVec3;

use super::error::SceneError;
use super::keys::{FROM_ZERO, Form, Key, NUMBER, TEXT, form, from_to, optional};
use super::luminaire_reading::COMMON;
use super::reader::{Fields, Node};
use crate::base::solar_position::{Moment, direction_of, solar_position_deg};
use crate::base::sun::Sun;

/// Keys for the position of the sun.
pub(super) const POSITION_KEYS: [&str; 5] =
    ["sun_elevation_deg", "sun_azimuth_deg", "latitude_deg", "longitude_deg", "date_time"];

/// Keys of place and time.
#[rustfmt::skip]
pub(super) const PLACE_AND_TIME: &[Key] = &[
    optional("latitude_deg", from_to(-90.0, 90.0), "Latitude, north positive.").such_as("51.5"),
    optional("longitude_deg", from_to(-180.0, 180.0), "Longitude, east positive.").such_as("-0.1"),
    optional("date_time", TEXT, "Date, time and zone, such as \"2026-06-21T12:30:00+02:00\".").such_as("\"2026-03-20T12:00:00Z\""),
];

/// A sun.
#[rustfmt::skip]
pub(super) const FORM: Form = form("sun",
    "The disk of the sun; either `normal_illuminance_lx` or `horizontal_illuminance_lx`.", &[COMMON, &[
    optional("sun_elevation_deg", from_to(-90.0, 90.0), "Elevation in degrees; or place and time.").such_as("35"),
    optional("sun_azimuth_deg", NUMBER, "Azimuth from +y (north) towards +x (east); 180 by default."),
], PLACE_AND_TIME, &[
    optional("normal_illuminance_lx", FROM_ZERO, "Illuminance in lx from the sun alone on a plane perpendicular to its rays."),
    optional("horizontal_illuminance_lx", FROM_ZERO, "Illuminance in lx from the sun alone on an open horizontal plane."),
]]).either(&[&["normal_illuminance_lx"], &["horizontal_illuminance_lx"]]);

/// Reads a sun. Openings and flux follow once the whole scene is read.
pub(super) fn read(fields: &Fields, maintained: f64) -> Result<(f64, Sun), SceneError> {
    let towards = direction(fields)?;
    let (which, node) = fields.one_of(["normal_illuminance_lx", "horizontal_illuminance_lx"])?;
    let given_lx = maintained * node.amount(["the normal illuminance", "the horizontal illuminance"][which])?;
    let sun = match which {
        0 => Some(Sun::of_normal(towards, given_lx)),
        _ => Sun::of_horizontal(towards, given_lx),
    };
    let Some(sun) = sun else {
        return Err(node.refuse(
            "the sun is below the horizon and gives no horizontal illuminance",
            "a sun above the horizon",
            "give normal_illuminance_lx, or choose another time",
        ));
    };
    // The returned luminous flux is a placeholder: it only shows whether there is light.
    let lit_lx = if sun.is_up() { sun.normal_lx() } else { 0.0 };
    Ok((lit_lx, sun))
}

/// Unit direction of the sun, from its angles or from location and time. The azimuth counts from +y (north) towards +x (east).
pub(super) fn direction(fields: &Fields) -> Result<DVec3, SceneError> {
    if let Some(elevation) = fields.get("sun_elevation_deg") {
        for key in ["latitude_deg", "longitude_deg", "date_time"] {
            if let Some(node) = fields.get(key) {
                let remedy = "leave out sun_elevation_deg, or place and time";
                return Err(node.refuse("the sun's position is given twice", "angles, or place and time", remedy));
            }
        }
        let elevation_deg = within(&elevation, "the sun's elevation")?;
        let azimuth_deg = fields.get("sun_azimuth_deg").map_or(Ok(180.0), |node| node.number())?;
        return Ok(direction_of(elevation_deg, azimuth_deg));
    }
    if !["latitude_deg", "longitude_deg", "date_time"].iter().any(|key| fields.get(key).is_some()) {
        fields.need("sun_elevation_deg")?;
    }
    if let Some(node) = fields.get("sun_azimuth_deg") {
        let expected = "an azimuth together with an elevation";
        return Err(node.refuse("place and time determine the azimuth", expected, "leave the key out"));
    }
    let latitude_deg = within(&fields.need("latitude_deg")?, "the latitude")?;
    let longitude_deg = within(&fields.need("longitude_deg")?, "the longitude")?;
    let node = fields.need("date_time")?;
    let moment = moment_of(node.text()?).ok_or_else(|| {
        node.refuse(
            "a date and time that cannot be read",
            "a date, a time and its zone as \"2026-06-21T12:30:00+02:00\" or \"…Z\", in the years 1900 to 2100",
            "write the zone: how far local time is ahead of universal time, including summer time",
        )
    })?;
    let [elevation_deg, azimuth_deg] = solar_position_deg(latitude_deg, longitude_deg, moment);
    Ok(direction_of(elevation_deg, azimuth_deg))
}

/// Returns an angle whose magnitude is at most the greatest of the key's range.
fn within(node: &Node, what: &str) -> Result<f64, SceneError> {
    let (number, limit) = (node.number()?, node.range().most);
    if number.abs() <= limit {
        return Ok(number);
    }
    let expected = format!("-{limit} to {limit} degrees");
    Err(node.refuse(format!("{what} is out of range"), expected, "check the number"))
}

/// Parses a moment of RFC 3339. The seconds are optional.
fn moment_of(text: &str) -> Option<Moment> {
    let (date, time) = text.split_once(['T', 't', ' '])?;
    let digits = |text: &str, count: usize| -> Option<u32> {
        (text.len() == count && text.bytes().all(|byte| byte.is_ascii_digit())).then(|| text.parse().ok())?
    };
    let mut parts = date.split('-');
    let (year, month, day) = (digits(parts.next()?, 4)?, digits(parts.next()?, 2)?, digits(parts.next()?, 2)?);
    let is_leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let days = match month {
        2 if is_leap => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        1..=12 => 31,
        _ => 0,
    };
    if parts.next().is_some() || !(1900..=2100).contains(&year) || !(1..=days).contains(&day) {
        return None;
    }
    let hours_of = |text: &str| -> Option<f64> {
        let mut parts = text.split(':');
        let (hours, minutes) = (digits(parts.next()?, 2)?, digits(parts.next()?, 2)?);
        let seconds = match parts.next() {
            None => 0.0,
            Some(text) => {
                let (whole, part) = text.split_once('.').map_or((text, None), |(whole, part)| (whole, Some(part)));
                let is_plain =
                    part.is_none_or(|part| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit()));
                digits(whole, 2)?;
                is_plain.then(|| text.parse::<f64>().ok())??
            }
        };
        let fits = parts.next().is_none() && hours < 24 && minutes < 60 && seconds < 61.0;
        fits.then_some(f64::from(hours) + f64::from(minutes) / 60.0 + seconds / 3600.0)
    };
    let (clock, ahead_hours) = match time.strip_suffix(['Z', 'z']) {
        Some(clock) => (clock, 0.0),
        None => {
            let sign_at = time.find(['+', '-'])?;
            let (clock, zone) = time.split_at(sign_at);
            let zone_hours = hours_of(&zone[1..])?;
            (clock, if zone.starts_with('-') { -zone_hours } else { zone_hours })
        }
    };
    Some(Moment::of_date(year as i32, month, day, hours_of(clock)? - ahead_hours))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_read_with_their_zone() {
        let noon = Some(Moment::of_date(2026, 6, 21, 12.0));
        for text in ["2026-06-21T12:00:00Z", "2026-06-21T14:00+02:00", "2026-06-21 06:30:00.0-05:30"] {
            assert_eq!(moment_of(text), noon, "{text}");
        }
        assert_ne!(moment_of("2026-06-21T12:00:01Z"), noon);
        for text in [
            "2026-06-21T12:00:00",
            "2026-06-31T12:00Z",
            "2025-02-29T12:00Z",
            "2026-6-21T12:00Z",
            "noon",
            "",
            "2026-06-21T24:00Z",
            "2026-06-21T12Z",
            "2026-06-21T12:00+2",
            "1600-01-01T12:00Z",
            "2026-06-21T12:00:1eZ",
            "2026-06-21T12:00:00é",
            "é+é",
        ] {
            assert_eq!(moment_of(text), None, "{text}");
        }
    }
}
