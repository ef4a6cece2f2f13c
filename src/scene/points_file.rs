//! Points files: CSV with the header `x,y,z,nx,ny,nz` and optionally `area`. A file whose name ends in `.pts` holds sensors of Radiance:
//! the same six numbers per line, with blanks between and no header.

use std::ops::Range;
use std::path::Path;

use glam::DVec3;

use super::error::SceneError;
use super::model::ReceiverPoint;
use super::reader::{Source, shortened};
use super::units::LengthUnit;
use super::vectors::direction;

const HEADER: [&str; 7] = ["x", "y", "z", "nx", "ny", "nz", "area"];
/// Number of columns that a file must have.
const NEEDED: usize = 6;

/// Reads the points of a file. Positions are in the file's unit, areas in its square. Empty lines are ignored.
///
/// # Errors
///
/// A wrong header, a row with too few or too many fields, a field that is no finite number, a normal of length 0, an area that is not
/// above 0, a file without a point. The error gives line and column.
pub(super) fn read(text: &str, path: &Path, unit: LengthUnit) -> Result<Vec<ReceiverPoint>, SceneError> {
    let source = Source { text, path };
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("pts")) {
        return read_sensors(&source, unit);
    }
    let mut lines = lines(text).filter(|line| !text[line.clone()].trim().is_empty());
    let Some(header) = lines.next() else {
        return Err(source.refuse(
            0..1,
            "",
            "an empty points file",
            "nothing",
            "the header x,y,z,nx,ny,nz",
            "write header and points",
        ));
    };

    // Spreadsheets often write a byte-order mark. It does not belong to the first name.
    let names: Vec<String> =
        text[header.clone()].trim_start_matches('\u{feff}').split(',').map(|name| name.trim().to_lowercase()).collect();
    let columns = names.len();
    if !(NEEDED..=HEADER.len()).contains(&columns) || names != HEADER[..columns] {
        let got = format!("{:?}", shortened(text[header.clone()].trim()));
        let what = "the points file has a wrong header";
        return Err(source.refuse(
            header,
            "",
            what,
            got,
            "x,y,z,nx,ny,nz or x,y,z,nx,ny,nz,area",
            "correct the first line",
        ));
    }

    let row = |line: Range<usize>| {
        let (fields, remedy) = (fields(text, &line), "write numbers with a decimal point, and a comma between fields");
        read_row(&source, (line, fields), columns, remedy, unit)
    };
    let points = lines.map(row).collect::<Result<Vec<_>, _>>()?;
    if points.is_empty() {
        return Err(source.refuse(
            header,
            "",
            "a points file without a point",
            "the header alone",
            "at least one point",
            "add a line x,y,z,nx,ny,nz",
        ));
    }
    Ok(points)
}

/// Reads sensors of Radiance, as honeybee writes them for its grids.
fn read_sensors(source: &Source, unit: LengthUnit) -> Result<Vec<ReceiverPoint>, SceneError> {
    let remedy = "write x y z dx dy dz with blanks between, one sensor per line";
    let row = |line: Range<usize>| {
        let words = words(source.text, &line);
        read_row(source, (line, words), NEEDED, remedy, unit)
    };
    let lines = lines(source.text).filter(|line| !source.text[line.clone()].trim().is_empty());
    let points = lines.map(row).collect::<Result<Vec<_>, _>>()?;
    if points.is_empty() {
        return Err(source.refuse(0..1, "", "an empty points file", "nothing", "one line for each sensor", remedy));
    }
    Ok(points)
}

fn read_row(
    source: &Source,
    (line, fields): (Range<usize>, Vec<Range<usize>>),
    columns: usize,
    remedy: &str,
    unit: LengthUnit,
) -> Result<ReceiverPoint, SceneError> {
    if fields.len() != columns {
        let (what, got) = ("a row has the wrong number of fields", format!("{} fields", fields.len()));
        let expected = format!("{columns}: {}", HEADER[..columns].join(","));
        return Err(source.refuse(line, "", what, got, expected, remedy));
    }
    let mut numbers = [0.0; 7];
    for (index, field) in fields.iter().enumerate() {
        let text = &source.text[field.clone()];
        numbers[index] = match text.parse::<f64>() {
            Ok(value) if value.is_finite() => value,
            _ => {
                let what = format!("{} is not a finite number", HEADER[index]);
                return Err(source.refuse(
                    field.clone(),
                    "",
                    what,
                    format!("{:?}", shortened(text)),
                    "a number",
                    "correct it",
                ));
            }
        };
    }
    let normal = direction(DVec3::new(numbers[3], numbers[4], numbers[5]));
    if normal == DVec3::ZERO {
        let place = fields[3].start..fields[5].end;
        return Err(source.refuse(
            place,
            "",
            "a normal of length 0",
            "0,0,0",
            "the direction that the point faces",
            "give nx, ny, nz",
        ));
    }
    if columns == HEADER.len() && numbers[6] <= 0.0 {
        let got = format!("{}", numbers[6]);
        return Err(source.refuse(
            fields[6].clone(),
            "",
            "an area is not above 0",
            got,
            "a number above 0",
            "correct or leave out the areas",
        ));
    }
    Ok(ReceiverPoint {
        position_m: unit.point_m(DVec3::new(numbers[0], numbers[1], numbers[2])),
        normal,
        weight: if columns == HEADER.len() { unit.area_m2(numbers[6]) } else { 1.0 },
        inside: false,
    })
}

/// Byte ranges of a text's lines.
fn lines(text: &str) -> impl Iterator<Item = Range<usize>> + '_ {
    text.split_inclusive('\n').scan(0, |start, line| {
        let range = *start..*start + line.trim_end_matches(['\r', '\n']).len();
        *start += line.len();
        Some(range)
    })
}

/// Byte ranges of a line's fields, without surrounding white space.
fn fields(text: &str, line: &Range<usize>) -> Vec<Range<usize>> {
    let mut start = line.start;
    text[line.clone()]
        .split(',')
        .map(|field| {
            let before = field.len() - field.trim_start().len();
            let range = start + before..start + before + field.trim().len();
            start += field.len() + 1;
            range
        })
        .collect()
}

/// Byte ranges of a line's words.
fn words(text: &str, line: &Range<usize>) -> Vec<Range<usize>> {
    let mut start = line.start;
    let mut words = Vec::new();
    for piece in text[line.clone()].split_inclusive(char::is_whitespace) {
        let word = piece.trim_end();
        if !word.is_empty() {
            words.push(start..start + word.len());
        }
        start += piece.len();
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_mm(text: &str) -> Result<Vec<ReceiverPoint>, SceneError> {
        read(text, Path::new("probes.csv"), LengthUnit::of(1))
    }

    #[test]
    fn places_areas_and_normals_become_si_and_unit() {
        let points =
            read_mm("x,y,z,nx,ny,nz,area\r\n1000, 2000,3000 ,0,0,5,1e6\r\n\r\n0,0,0,3,0,4,2e6\r\n").expect("valid");
        assert_eq!(points[0].position_m, DVec3::new(1.0, 2.0, 3.0));
        assert_eq!((points[0].normal, points[0].weight, points[1].weight), (DVec3::Z, 1.0, 2.0));
        assert!(points[1].normal.distance(DVec3::new(0.6, 0.0, 0.8)) < 1e-15);
        assert_eq!(read_mm("\u{feff}x,y,z,nx,ny,nz\n1,2,3,0,1,0").expect("valid")[0].weight, 1.0);
    }

    fn read_sensors_in_m(text: &str) -> Result<Vec<ReceiverPoint>, SceneError> {
        read(text, Path::new("grid/Room.PTS"), LengthUnit::of(0))
    }

    #[test]
    fn sensors_of_radiance_have_blanks_between_and_no_header() {
        let points = read_sensors_in_m(" 1.5\t2 0.8  0 0 1\r\n\n3 4 5 0 -2 0\n").expect("valid");
        assert_eq!(points.iter().map(|point| point.position_m.x).collect::<Vec<f64>>(), [1.5, 3.0]);
        assert_eq!((points[0].normal, points[1].normal, points[1].weight), (DVec3::Z, -DVec3::Y, 1.0));
        for (text, line, column) in [
            ("", 1, 1),
            ("1 2 3 0 0\n", 1, 1),
            ("1 2 3 0 0 1\n1 2  q 0 0 1", 2, 6),
            ("1,2,3,0,0,1", 1, 1),
            ("1 2 3 0 0 0", 1, 7),
        ] {
            let error = read_sensors_in_m(text).expect_err(text);
            let place = error.place.as_ref().expect("a place");
            assert_eq!((place.line, place.column), (line, column), "{error}");
        }
    }

    #[test]
    fn bad_rows_are_named_by_line_and_column() {
        for (text, line, column) in [
            ("", 1, 1),
            ("a,b\n", 1, 1),
            ("x,y,z,nx,ny,nz\n", 1, 1),
            ("x,y,z,nx,ny,nz\n1,2,3,0,0\n", 2, 1),
            ("x,y,z,nx,ny,nz\n1,2,3,0,0,1\n1,2, q,0,0,1", 3, 6),
            ("x,y,z,nx,ny,nz\n1,2,NaN,0,0,1", 2, 5),
            ("x,y,z,nx,ny,nz\n1,2,3,0,0,0", 2, 7),
            ("x,y,z,nx,ny,nz,area\n1,2,3,0,0,1,-1", 2, 13),
        ] {
            let error = read_mm(text).expect_err(text);
            let place = error.place.as_ref().expect("a place");
            assert_eq!((place.line, place.column), (line, column), "{error}");
        }
    }
}
