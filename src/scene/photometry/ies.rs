//! IES LM-63: labels, the TILT line, and the meaning of the numbers after it.

use std::path::Path;

use super::file::FLUX_TOLERANCE;
use super::ies_body::{FOOT_M, IesNumbers, Tilt, Tokenized, read_body, read_tilt};
use super::planes::unfold;
use super::text::{Comma, Tokens, decode, lines_of, read_bytes};
use super::{
    IntensityWeb, LampSet, LateralSymmetry, Opening, PhotometricError, PhotometricFile, PhotometricFormat,
    PhotometricType,
};

/// Parses an IES LM-63 file of any edition (1986, 1991, 1995, 2002, 2019).
///
/// `folder` contains the tilt file that the text may name. Without `folder` no tilt file is read, and a warning says so.
///
/// # Errors
/// Any violation of the format, with line, token, expectation and remedy. Never panics.
pub fn parse_ies(bytes: &[u8], folder: Option<&Path>) -> Result<PhotometricFile, PhotometricError> {
    let lines = lines_of(&decode(bytes));
    let mut warnings = Vec::new();
    let Some(tilt_index) = tilt_line(&lines) else {
        let remedy = "an IES file needs one between its labels and its numbers; write TILT=NONE if the lamp's tilt does not matter";
        return Err(PhotometricError::malformed(lines.len().max(1), last_words(&lines), "a line TILT=…", remedy));
    };
    let (format, label_start) = edition(&lines[..tilt_index], &mut warnings);
    let keywords = labels(&lines[label_start..tilt_index]);

    // After the TILT line the file is one stream of numbers; line breaks have no meaning.
    let tilt_value = lines[tilt_index].split_once('=').map(|(_, value)| value.trim()).unwrap_or_default();
    let included = tilt_value.eq_ignore_ascii_case("INCLUDE");
    let Tokenized { mut body, comma, leftover } = read_body(&lines[tilt_index + 1..], tilt_index + 2, included)?;
    if comma == Comma::Decimal {
        warnings.push("numbers are written with decimal commas; they were read as such".to_string());
    }
    if leftover > 0 {
        warnings.push(format!("{leftover} values after the last intensity were ignored"));
    }
    if !included && !tilt_value.eq_ignore_ascii_case("NONE") {
        body.tilt = tilt_file(tilt_value, folder, tilt_index + 1, &mut warnings)?;
    }

    // cd = value × multiplier × ballast factor × ballast-lamp factor × tilt factor. Only the two oldest editions have the ballast-lamp
    // factor.
    let old = matches!(format, PhotometricFormat::Ies1986 | PhotometricFormat::Ies1991);
    let lamp_factor = if old { body.third_factor } else { 1.0 };
    if old && lamp_factor <= 0.0 {
        let remedy = "1986 and 1991 files multiply by it; write 1 if it is not known";
        let expected = "a ballast-lamp photometric factor above 0";
        return Err(PhotometricError::malformed(body.factor_line, &lamp_factor.to_string(), expected, remedy));
    }
    let tilt_factor = body.tilt.as_ref().map_or(1.0, Tilt::factor_untilted);
    if body.tilt.is_some() {
        warnings.push(format!(
            "lamp tilt factors are given for tilted mounting; they are not applied: intensities use the factor without tilt, {tilt_factor}"
        ));
    }
    let factor = body.multiplier * body.ballast_factor * lamp_factor * tilt_factor;
    let candela: Vec<f64> = body.values.iter().map(|value| value * factor).collect();
    if candela.iter().any(|cd| !cd.is_finite()) {
        let remedy = "check the multiplier and the ballast factors";
        return Err(PhotometricError::malformed(
            body.factor_line,
            &factor.to_string(),
            "factors that keep intensities finite",
            remedy,
        ));
    }
    let (web, symmetry) = web_of(&body, candela, &mut warnings)?;

    let keyword = |name: &str| {
        let found = keywords.iter().find(|(key, _)| key.eq_ignore_ascii_case(name));
        found.map(|(_, value)| value.clone()).unwrap_or_default()
    };
    let absolute = body.lumens_per_lamp < 0.0;
    let flux = web.luminous_flux_lm();
    let lamps_lm = body.lamps * body.lumens_per_lamp;
    let declared = (!absolute).then_some(lamps_lm);
    check_flux(&body, flux, &mut warnings);
    let power_w = (body.watts > 0.0).then_some(body.watts);
    Ok(PhotometricFile {
        format,
        manufacturer: keyword("MANUFAC"),
        luminaire: keyword("LUMINAIRE"),
        catalog_number: keyword("LUMCAT"),
        lamp: keyword("LAMP"),
        lamps: body.lamps,
        lumens_per_lamp: (!absolute).then_some(body.lumens_per_lamp),
        lamp_sets: vec![LampSet {
            lamps: body.lamps,
            flux_lm: declared,
            description: keyword("LAMP"),
            colour: keyword("COLORTEMP"),
            colour_rendering: keyword("CRI"),
            power_w,
        }],
        declared_flux_lm: declared,
        absolute,
        power_w,
        opening: opening(format, &body, &mut warnings),
        symmetry,
        photometric_type: body.photometric_type,
        light_output_ratio: declared.filter(|&lm| lm > 0.0).map(|lm| flux / lm),
        file_generation_type: (format == PhotometricFormat::Ies2019).then_some(body.third_factor),
        keywords,
        web,
        warnings,
    })
}

/// Index of the line that ends the labels: `TILT=…`, in any case and with any spaces.
pub(super) fn tilt_line(lines: &[String]) -> Option<usize> {
    lines.iter().position(|line| {
        let before = line.split_once('=').map(|(before, _)| before.trim());
        before.is_some_and(|word| word.eq_ignore_ascii_case("TILT"))
    })
}

fn last_words(lines: &[String]) -> &str {
    lines.iter().rev().map(|line| line.trim()).find(|line| !line.is_empty()).unwrap_or_default()
}

/// Returns the edition from the first line, and the line where the labels begin. A file without an identification line is of 1986.
fn edition(labels: &[String], warnings: &mut Vec<String>) -> (PhotometricFormat, usize) {
    let Some(index) = labels.iter().position(|line| !line.trim().is_empty()) else {
        return (PhotometricFormat::Ies1986, labels.len());
    };
    let id: String = labels[index].to_uppercase().split_whitespace().collect();
    let known = [
        ("IESNA91", PhotometricFormat::Ies1991),
        ("IESNA:LM-63-1986", PhotometricFormat::Ies1986),
        ("IESNA:LM-63-1991", PhotometricFormat::Ies1991),
        ("IESNA:LM-63-1995", PhotometricFormat::Ies1995),
        ("IESNA:LM-63-2002", PhotometricFormat::Ies2002),
        ("IES:LM-63-2019", PhotometricFormat::Ies2019),
        ("IESNA:LM-63-2019", PhotometricFormat::Ies2019),
    ];
    if let Some(&(_, format)) = known.iter().find(|(name, _)| id.starts_with(name)) {
        return (format, index + 1);
    }
    if id.starts_with("IESNA") || id.starts_with("IES:") {
        warnings.push(format!("the edition `{}` is unknown; read as LM-63-2002", labels[index].trim()));
        return (PhotometricFormat::Ies2002, index + 1);
    }
    (PhotometricFormat::Ies1986, index)
}

/// Returns keywords with their values. `[MORE]` continues the previous value. A line without a keyword is an entry of its own.
fn labels(lines: &[String]) -> Vec<(String, String)> {
    let mut found: Vec<(String, String)> = Vec::new();
    for line in lines.iter().map(|line| line.trim()).filter(|line| !line.is_empty()) {
        let parts = line.strip_prefix('[').and_then(|rest| rest.split_once(']'));
        let (key, value) = parts.map_or(("", line), |(key, value)| (key.trim(), value.trim()));
        match found.last_mut() {
            Some((_, before)) if key.eq_ignore_ascii_case("MORE") => {
                before.push('\n');
                before.push_str(value);
            }
            _ => found.push((key.to_uppercase(), value.to_string())),
        }
    }
    found
}

/// Reads tilt factors from the file that the TILT line names.
fn tilt_file(
    name: &str,
    folder: Option<&Path>,
    line: usize,
    warnings: &mut Vec<String>,
) -> Result<Option<Tilt>, PhotometricError> {
    if name.is_empty() {
        let remedy = "write TILT=NONE if the lamp's tilt does not matter";
        return Err(PhotometricError::malformed(line, "TILT=", "NONE, INCLUDE or the name of a tilt file", remedy));
    }
    let Some(folder) = folder else {
        warnings.push(format!("the tilt file `{name}` was not read; its factor without tilt is taken as 1"));
        return Ok(None);
    };
    let path = folder.join(name);
    let bytes = read_bytes(&path).map_err(|error| match error {
        PhotometricError::Unreadable { path, reason, .. } => {
            let remedy = "line TILT= names it as the lamp's tilt file: put it beside the IES file, or write TILT=NONE";
            PhotometricError::Unreadable { path, reason, remedy: remedy.to_owned() }
        }
        other => other,
    })?;
    let lines = lines_of(&decode(&bytes));
    let mut tokens = Tokens::new(&lines, 1, Comma::Delimiter);
    read_tilt(&mut tokens).map(Some).map_err(|error| error.in_file(&path))
}

/// Makes the table in the angles of its goniometer. For type C the planes go all the way round.
fn web_of(
    body: &IesNumbers,
    candela: Vec<f64>,
    warnings: &mut Vec<String>,
) -> Result<(IntensityWeb, LateralSymmetry), PhotometricError> {
    let (vertical, horizontal) = (&body.vertical_deg, &body.horizontal_deg);
    let row = vertical.len();
    let (first, last) = (horizontal[0], horizontal[horizontal.len() - 1]);
    let (planes, angles, table, symmetry) = match body.photometric_type {
        PhotometricType::C => {
            let symmetry = lateral_symmetry(first, last, horizontal.len(), body.horizontal_line)?;
            let turn = unfold(horizontal, &candela, row, symmetry);
            if turn.disagreement > FLUX_TOLERANCE {
                let percent = 100.0 * turn.disagreement;
                warnings.push(format!(
                    "planes given twice differ by up to {percent:.1} % of the maximum; the first was taken"
                ));
            }
            if symmetry == LateralSymmetry::None && horizontal.len() > 1 && last - first < 360.0 {
                let gap = 360.0 - (last - first);
                if gap > 1.5 * (last - first) / (horizontal.len() - 1) as f64 {
                    warnings.push(format!(
                        "no plane lies within the last {gap:.1} degrees of the full turn; intensities there are interpolated"
                    ));
                }
            }
            (turn.c_deg, vertical.clone(), turn.intensity, symmetry)
        }
        // Horizontal angles of types A and B run clockwise. A list that starts at 0 holds for both sides.
        PhotometricType::A | PhotometricType::B => {
            let mirrored = first == 0.0;
            let symmetry = if mirrored { LateralSymmetry::AboutC0 } else { LateralSymmetry::None };
            let mut sides: Vec<(f64, usize)> = horizontal.iter().copied().zip(0..).collect();
            if mirrored {
                sides.extend(horizontal.iter().zip(0..).skip(1).map(|(angle, index)| (-angle, index)));
            }
            sides.sort_by(|a, b| a.0.total_cmp(&b.0));
            let level: Vec<f64> = vertical.iter().map(|angle| 90.0 + angle).collect();
            if body.photometric_type == PhotometricType::A {
                sides.reverse();
                let planes = sides.iter().map(|side| 180.0 - side.0).collect();
                let table = sides.iter().flat_map(|side| candela[side.1 * row..][..row].iter().copied()).collect();
                (planes, level, table, symmetry)
            } else {
                let planes = vertical.iter().map(|angle| 180.0 + angle).collect();
                let angles = sides.iter().map(|side| 90.0 + side.0).collect();
                let table = (0..row).flat_map(|v| sides.iter().map(move |side| (side.1, v)));
                (planes, angles, table.map(|(h, v)| candela[h * row + v]).collect(), symmetry)
            }
        }
    };
    let (lowest, highest) = (vertical[0], vertical[row - 1]);
    let ends = match body.photometric_type {
        PhotometricType::C => [lowest == 0.0 || lowest == 90.0, highest == 90.0 || highest == 180.0],
        _ => [lowest == -90.0 || lowest == 0.0, highest == 90.0],
    };
    if ends != [true, true] {
        warnings.push(format!(
            "vertical angles run from {lowest} to {highest} degrees; outside of them the intensity is 0"
        ));
    }
    let web = IntensityWeb::on_goniometer(body.photometric_type, planes, angles, table).map_err(|error| {
        let remedy = "check the angles and the intensities of the file";
        PhotometricError::malformed(body.horizontal_line, &error.to_string(), "a table of intensities", remedy)
    })?;
    Ok((web, symmetry))
}

/// The symmetry that the first and last horizontal angle of a type C file imply for the missing planes.
fn lateral_symmetry(first: f64, last: f64, count: usize, line: usize) -> Result<LateralSymmetry, PhotometricError> {
    if count == 1 {
        return Ok(LateralSymmetry::Rotational);
    }
    match (first, last) {
        (0.0, 90.0) => Ok(LateralSymmetry::Quadrant),
        (0.0, 180.0) | (180.0, 360.0) | (-180.0, 0.0) => Ok(LateralSymmetry::AboutC0),
        (90.0, 270.0) | (-90.0, 90.0) => Ok(LateralSymmetry::AboutC90),
        (first, last) if last - first > 180.0 && last - first <= 360.0 => Ok(LateralSymmetry::None),
        _ => {
            let expected = "horizontal angles 0, 0 to 90, 0 to 180, 90 to 270 or 0 to 360";
            let remedy = "planes can be completed only from these; add the missing ones";
            Err(PhotometricError::malformed(line, &format!("{first} to {last}"), expected, remedy))
        }
    }
}

/// Warns if header and integral disagree. The intensities count in any case.
fn check_flux(body: &IesNumbers, flux_lm: f64, warnings: &mut Vec<String>) {
    if flux_lm == 0.0 {
        warnings.push("all intensities are 0: the luminaire is dark".to_string());
    }
    if body.lumens_per_lamp < 0.0 {
        if body.lumens_per_lamp != -1.0 {
            warnings.push(format!("{} lumens per lamp: read as -1, absolute photometry", body.lumens_per_lamp));
        }
        return;
    }
    let lamps_lm = body.lamps * body.lumens_per_lamp;
    if flux_lm > (1.0 + FLUX_TOLERANCE) * lamps_lm {
        warnings.push(format!(
            "the intensities add up to {flux_lm:.1} lm, more than the {lamps_lm:.1} lm that the file states for {} {}; the flux from the intensities is used",
            body.lamps,
            if body.lamps == 1.0 { "lamp" } else { "lamps" }
        ));
    }
}

/// The luminous opening, from the signs of its dimensions. The editions from 2002 on have their own meaning of the signs.
fn opening(format: PhotometricFormat, body: &IesNumbers, warnings: &mut Vec<String>) -> Opening {
    let unit_m = if body.feet { FOOT_M } else { 1.0 };
    let [width, length, height] = body.dimensions.map(|size| size * unit_m);
    let (c90_m, c0_m, height_m) = (width.abs(), length.abs(), height.abs());
    let sign = |size: f64| {
        if size > 0.0 {
            1
        } else if size < 0.0 {
            -1
        } else {
            0
        }
    };
    let round = c0_m == c90_m;
    let newer = matches!(format, PhotometricFormat::Ies2002 | PhotometricFormat::Ies2019);
    match (sign(width), sign(length), sign(height)) {
        (0, 0, 0) => Opening::Point,
        (0 | 1, 0 | 1, 0) => Opening::Rectangle { c0_m, c90_m },
        (0 | 1, 0 | 1, 1) => Opening::Box { c0_m, c90_m, height_m },
        (-1, 0, 0) => Opening::Disk { diameter_m: c90_m },
        (0, -1, 0) => Opening::Disk { diameter_m: c0_m },
        (-1, -1, 0) if round => Opening::Disk { diameter_m: c90_m },
        (-1, 0, 1) => Opening::VerticalCylinder { diameter_m: c90_m, height_m },
        (0, -1, 1) => Opening::VerticalCylinder { diameter_m: c0_m, height_m },
        (-1, -1, 1) if round => Opening::VerticalCylinder { diameter_m: c90_m, height_m },
        (-1, 0, -1) if newer => Opening::UprightEllipse { width_m: c90_m, height_m },
        (-1, 0, -1) => Opening::Sphere { diameter_m: c90_m },
        (-1, -1, -1) if round && height_m == c0_m => Opening::Sphere { diameter_m: c90_m },
        (0, 1, -1) => Opening::HorizontalCylinder { along_c0: true, length_m: c0_m, width_m: height_m, height_m },
        (1, 0, -1) => Opening::HorizontalCylinder { along_c0: false, length_m: c90_m, width_m: height_m, height_m },
        (-1, 1, -1) if newer => {
            Opening::HorizontalCylinder { along_c0: true, length_m: c0_m, width_m: c90_m, height_m }
        }
        (1, -1, -1) if newer => {
            Opening::HorizontalCylinder { along_c0: false, length_m: c90_m, width_m: c0_m, height_m }
        }
        (-1, -1, -1) | (-1, 1, -1) | (1, -1, -1) => Opening::Ellipsoid { c0_m, c90_m, height_m },
        (-1, _, 0 | 1) | (_, -1, 0 | 1) => Opening::Ellipse { c0_m, c90_m, height_m },
        _ => {
            let [width, length, height] = body.dimensions;
            warnings.push(format!(
                "the dimensions {width}, {length}, {height} stand for no shape of opening; read as a box"
            ));
            Opening::Box { c0_m, c90_m, height_m }
        }
    }
}
