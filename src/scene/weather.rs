//! Weather of a year: EnergyPlus files (EPW), or CSV with site and hours.
//!
//! Of an EPW file only location, time and two irradiances are read: direct normal and diffuse horizontal. Each line describes the hour
//! that ends at the given time. The sun's position is taken in the middle of that hour.

use std::ops::Range;
use std::path::Path;

use super::error::SceneError;
use super::plain_file::read_plain_file;
use super::reader::{Source, shortened};
use crate::base::solar_position::DAYS_OF_MONTHS;

/// Largest weather file in bytes: ten times the size of hourly ones.
const MOST_BYTES: u64 = 20_000_000;
/// Number of lines before the hours of an EPW file.
const EPW_HEADERS: usize = 8;
/// Value that marks a missing irradiance in an EPW file; greater values do too.
const MISSING_W_M2: f64 = 9999.0;
/// Most hours that a file may have: those of a leap year.
const MOST_HOURS: usize = 8784;
/// Largest irradiance in W/m² and illuminance in lx. The sun cannot give more.
const LARGEST: [f64; 2] = [1500.0, 200_000.0];
/// Columns of a CSV file. The last two are these or the two of illuminances.
const COLUMNS: [&str; 5] =
    ["month", "day", "hour", "direct_normal_irradiance_w_m2", "diffuse_horizontal_irradiance_w_m2"];
const ILLUMINANCES: [&str; 2] = ["direct_normal_illuminance_lx", "diffuse_horizontal_illuminance_lx"];
/// Site data of a CSV file before its columns.
const SITE: [&str; 3] = ["latitude_deg", "longitude_deg", "time_zone_hours"];
const SITE_LIMITS: [f64; 3] = [90.0, 180.0, 14.0];

/// Weather of the hours of a year at a location.
#[derive(Clone, Debug, PartialEq)]
pub struct Weather {
    /// Name of the location; may be empty.
    pub place: String,
    /// Latitude in degrees; positive north of the equator.
    pub latitude_deg: f64,
    /// Longitude in degrees; positive east of Greenwich.
    pub longitude_deg: f64,
    /// Hours by which the location's standard time is ahead of universal time.
    pub time_zone_hours: f64,
    /// The hours, in the order of the file.
    pub hours: Vec<WeatherHour>,
}

/// One hour of weather.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeatherHour {
    /// Month from 1.
    pub month: u32,
    /// Day of the month from 1.
    pub day: u32,
    /// Middle of the hour in standard time, 0 to 24.
    pub middle_hours: f64,
    /// Light from the sun and from the sky.
    pub light: WeatherLight,
}

/// Light of an hour: from the sun on a plane perpendicular to its rays, and from the sky on an open horizontal plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WeatherLight {
    /// Irradiances in W/m².
    Irradiance([f64; 2]),
    /// Illuminances in lx.
    Illuminance([f64; 2]),
}

/// Reads a weather file: EPW by its name, otherwise CSV.
///
/// # Errors
///
/// A file that cannot be read or has another form, and numbers that are missing or out of range. The error gives line and column.
pub fn read_weather(path: &Path) -> Result<Weather, SceneError> {
    let whole = |got: String, remedy: &str| {
        let what = "the weather file cannot be read".to_owned();
        SceneError::of_file(path, what, got, "an EPW file, or CSV with site and hours", remedy)
    };
    let bytes = read_plain_file(path, MOST_BYTES).map_err(|error| whole(error.to_string(), "check the file's name"))?;
    // Names of locations may have any encoding. The numbers are ASCII.
    let text = String::from_utf8_lossy(&bytes);
    let is_epw = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("epw"));
    weather_from_text(&text, path, is_epw)
}

/// As `read_weather`, from the text of a file. Errors show `path`.
///
/// # Errors
///
/// As [`read_weather`].
pub fn weather_from_text(text: &str, path: &Path, is_epw: bool) -> Result<Weather, SceneError> {
    let rows = Rows::of(Source { text, path });
    if is_epw { rows.epw() } else { rows.csv() }
}

/// The fields of a line, as ranges of the text.
type LineFields = Vec<Range<usize>>;

struct Rows<'a> {
    source: Source<'a>,
    lines: Vec<LineFields>,
}

impl<'a> Rows<'a> {
    fn of(source: Source<'a>) -> Rows<'a> {
        let mut lines = Vec::new();
        let mut start = 0;
        for line in source.text.split('\n') {
            let mut fields = Vec::new();
            let mut at = start;
            for field in line.split(',') {
                let begin = at + field.len() - field.trim_start().len();
                fields.push(begin..begin + field.trim().len());
                at += field.len() + 1;
            }
            if !line.trim().is_empty() {
                lines.push(fields);
            }
            start += line.len() + 1;
        }
        Rows { source, lines }
    }

    fn text(&self, field: &Range<usize>) -> &'a str {
        self.source.text[field.clone()].trim_start_matches('\u{feff}')
    }

    fn refuse(&self, place: Range<usize>, what: &str, expected: &str, remedy: &str) -> SceneError {
        let got = match self.text(&place) {
            "" => "nothing".to_owned(),
            text => format!("{:?}", shortened(text)),
        };
        self.source.refuse(place, "", what, got, expected, remedy)
    }

    /// Reads a field of a line as a number within a range.
    fn number(&self, fields: &LineFields, place: usize, what: &str, range: [f64; 2]) -> Result<f64, SceneError> {
        let field = fields.get(place).cloned().unwrap_or_else(|| end_of(fields));
        let number = self.text(&field).parse::<f64>().ok().filter(|number| (range[0]..=range[1]).contains(number));
        let expected = || format!("{what}, from {} to {}", range[0], range[1]);
        number.ok_or_else(|| self.refuse(field, "a number is missing or out of range", &expected(), "correct it"))
    }

    fn hour_of(&self, fields: &LineFields, [month, day, hour]: [usize; 3]) -> Result<(u32, u32, f64), SceneError> {
        let month = self.number(fields, month, "a month", [1.0, 12.0])?;
        // The year may be a leap year.
        let days = DAYS_OF_MONTHS[month as usize - 1] + u32::from(month as usize == 2);
        let day = self.number(fields, day, "a day of the month", [1.0, f64::from(days)])?;
        Ok((month as u32, day as u32, self.number(fields, hour, "an hour of the day", [0.0, 24.0])?))
    }

    fn within_a_year(&self, hours: Vec<WeatherHour>, site: (String, [f64; 3])) -> Result<Weather, SceneError> {
        let (place, [latitude_deg, longitude_deg, time_zone_hours]) = site;
        if hours.is_empty() || hours.len() > MOST_HOURS {
            let what = if hours.is_empty() { "no hours of weather data" } else { "more hours than a year has" };
            let last = self.lines.last().map_or(0..0, end_of);
            return Err(self.refuse(last, what, "one hour per line, of one year at most", "choose another file"));
        }
        Ok(Weather { place, latitude_deg, longitude_deg, time_zone_hours, hours })
    }

    fn epw(&self) -> Result<Weather, SceneError> {
        let head = self.lines.first().filter(|fields| self.text(&fields[0]).eq_ignore_ascii_case("LOCATION"));
        let Some(head) = head else {
            let first = self.lines.first().map_or(0..0, |fields| fields[0].clone());
            let expected = "LOCATION, and then place, latitude, longitude and time zone";
            return Err(self.refuse(first, "this is not an EPW file", expected, "choose another file"));
        };
        let site = [6, 7, 8].map(|place| (place, SITE[place - 6], SITE_LIMITS[place - 6]));
        let mut numbers = [0.0; 3];
        for (number, (place, what, limit)) in numbers.iter_mut().zip(site) {
            *number = self.number(head, place, what, [-limit, limit])?;
        }
        let mut hours = Vec::new();
        for fields in self.lines.iter().skip(EPW_HEADERS) {
            let (month, day, hour) = self.hour_of(fields, [1, 2, 3])?;
            let mut light_w_m2 = [0.0; 2];
            for (w_m2, place) in light_w_m2.iter_mut().zip([14, 15]) {
                let given = self.number(fields, place, "a radiation in Wh/m²", [0.0, f64::MAX])?;
                *w_m2 = if given >= MISSING_W_M2 { 0.0 } else { given.min(LARGEST[0]) };
            }
            if hour < 1.0 {
                let remedy = "count hours from 1 to 24";
                return Err(self.refuse(
                    fields[3].clone(),
                    "an hour that ends before the day begins",
                    "1 to 24",
                    remedy,
                ));
            }
            let same = |last: &WeatherHour| (last.month, last.day, last.middle_hours) == (month, day, hour - 0.5);
            if hours.last().is_some_and(same) {
                let remedy = "choose a file with one hour per line";
                return Err(self.refuse(fields[3].clone(), "a second line for one hour", "one line per hour", remedy));
            }
            hours.push(WeatherHour {
                month,
                day,
                middle_hours: hour - 0.5,
                light: WeatherLight::Irradiance(light_w_m2),
            });
        }
        self.within_a_year(hours, (self.text(&head[1]).to_owned(), numbers))
    }

    fn csv(&self) -> Result<Weather, SceneError> {
        let remedy = "begin with latitude_deg,51.5 and longitude_deg,-0.1 and time_zone_hours,0, one per line";
        let mut site = [None; 3];
        let mut place = String::new();
        let mut lines = self.lines.iter();
        let head = loop {
            let Some(fields) = lines.next() else {
                let last = self.lines.last().map_or(0..0, end_of);
                return Err(self.refuse(last, "the weather file has no columns", &COLUMNS.join(","), "add them"));
            };
            let name = self.text(&fields[0]);
            match SITE.iter().position(|of_site| *of_site == name) {
                Some(which) => {
                    let limit = SITE_LIMITS[which];
                    site[which] = Some(self.number(fields, 1, name, [-limit, limit])?);
                }
                None if name == "place" => place = fields.get(1).map_or("", |field| self.text(field)).to_owned(),
                None => break fields,
            }
        };
        let [Some(latitude), Some(longitude), Some(zone)] = site else {
            let what = "the weather file does not state its location";
            return Err(self.refuse(head[0].clone(), what, &SITE.join(", "), remedy));
        };
        let names: Vec<&str> = head.iter().map(|field| self.text(field)).collect();
        let is_light = names.get(3..) == Some(&ILLUMINANCES);
        if names.get(..3) != Some(&COLUMNS[..3]) || !is_light && names.get(3..) != Some(&COLUMNS[3..]) {
            let expected = format!("{}, or in place of the last two {}", COLUMNS.join(","), ILLUMINANCES.join(","));
            return Err(self.refuse(whole(head), "the weather file has other columns", &expected, "correct the line"));
        }
        let mut hours = Vec::new();
        for fields in lines {
            let (month, day, middle_hours) = self.hour_of(fields, [0, 1, 2])?;
            let largest = LARGEST[usize::from(is_light)];
            let direct = self.number(fields, 3, names[3], [0.0, largest])?;
            let diffuse = self.number(fields, 4, names[4], [0.0, largest])?;
            let light = match is_light {
                true => WeatherLight::Illuminance([direct, diffuse]),
                false => WeatherLight::Irradiance([direct, diffuse]),
            };
            hours.push(WeatherHour { month, day, middle_hours, light });
        }
        self.within_a_year(hours, (place, [latitude, longitude, zone]))
    }
}

fn whole(fields: &LineFields) -> Range<usize> {
    fields[0].start..fields[fields.len() - 1].end
}

fn end_of(fields: &LineFields) -> Range<usize> {
    let end = fields.last().map_or(0, |field| field.end);
    end..end
}

#[cfg(test)]
mod tests {
    use super::*;

    fn csv(text: &str) -> Result<Weather, SceneError> {
        weather_from_text(text, Path::new("weather.csv"), false)
    }

    const HEAD: &str = "place,Nowhere\nlatitude_deg,51.5\nlongitude_deg,-0.1\ntime_zone_hours,0\n";

    #[test]
    fn csv_is_read_with_its_site() {
        let hours = "month,day,hour,direct_normal_illuminance_lx,diffuse_horizontal_illuminance_lx\n6, 21, 11.5, 80000, 15000\n";
        let weather = csv(&format!("\u{feff}{HEAD}{hours}")).expect("weather");
        assert_eq!((weather.place.as_str(), weather.latitude_deg, weather.longitude_deg), ("Nowhere", 51.5, -0.1));
        let light = WeatherLight::Illuminance([80_000.0, 15_000.0]);
        assert_eq!(weather.hours, [WeatherHour { month: 6, day: 21, middle_hours: 11.5, light }]);
    }

    #[test]
    fn an_epw_line_tells_of_the_hour_before() {
        let mut text = "LOCATION,Nowhere,-,-,made up,0,51.5,-0.1,1.0,20\n".to_owned();
        text += &"X\n".repeat(EPW_HEADERS - 1);
        text += "2001,1,1,9,60,?,5,5,80,101325,0,0,300,100,9999,50,0,0,0,0\n";
        let weather = weather_from_text(&text, Path::new("a.epw"), true).expect("weather");
        assert_eq!((weather.time_zone_hours, weather.hours[0].middle_hours), (1.0, 8.5));
        assert_eq!(weather.hours[0].light, WeatherLight::Irradiance([0.0, 50.0]));
        let twice = format!("{text}2001,1,1,9,30,?,5,5,80,101325,0,0,300,100,0,50,0,0,0,0\n");
        let refused = weather_from_text(&twice, Path::new("a.epw"), true).expect_err("two lines of an hour");
        assert!(refused.to_string().contains("second line"), "{refused}");
    }

    #[test]
    fn what_is_no_weather_is_refused_with_its_place() {
        let columns = "month,day,hour,direct_normal_irradiance_w_m2,diffuse_horizontal_irradiance_w_m2\n";
        for (text, says) in [
            (String::new(), "no columns"),
            (columns.to_owned(), "does not state its location"),
            (HEAD.to_owned(), "no columns"),
            (format!("{HEAD}month,day\n"), "other columns"),
            (format!("{HEAD}{columns}"), "no hour"),
            (format!("{HEAD}{columns}2,30,1,0,0\n"), "out of range"),
            (format!("{HEAD}{columns}2,3,1,0\n"), "out of range"),
            (format!("{HEAD}{columns}2,3,1,0,-1\n"), "out of range"),
            (format!("{HEAD}{columns}2,3,1,NaN,1\n"), "out of range"),
            (format!("{HEAD}{columns}2,3,é,1,1\n"), "out of range"),
            (HEAD.replace("51.5", "95"), "out of range"),
        ] {
            let refused = csv(&text).expect_err(says).to_string();
            assert!(refused.contains(says), "{says}: {refused}");
        }
        let refused = weather_from_text("nothing", Path::new("a.epw"), true).expect_err("not an EPW");
        assert!(refused.to_string().contains("not an EPW file"), "{refused}");
    }
}
