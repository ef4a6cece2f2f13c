//! EULUMDAT: one value per line, intensities in cd per 1000 lm of lamps.

use super::file::{FLUX_TOLERANCE, LARGEST_OPENING_M};
use super::planes::unfold;
use super::text::{Comma, Tokens, decode, lines_of, number};
use super::{
    IntensityWeb, LampSet, LateralSymmetry, Opening, PhotometricError, PhotometricFile, PhotometricFormat,
    PhotometricType,
};

/// Number of lines before the sets of lamps. The last of them gives the number of sets.
const HEADER_LINES: usize = 26;
/// Number of lines of one set of lamps.
const LINES_PER_SET: usize = 6;
/// Number of direct ratios between the sets of lamps and the angles.
pub(crate) const DIRECT_RATIOS: usize = 10;
/// Metres in a millimetre.
const MILLIMETRE_M: f64 = 1e-3;

/// Parses an EULUMDAT file.
///
/// # Errors
/// Any violation of the format, with line, token, expectation and remedy. Never panics.
pub fn parse_eulumdat(bytes: &[u8]) -> Result<PhotometricFile, PhotometricError> {
    let lines = lines_of(&decode(bytes));
    let fields = HeaderLines { lines: &lines };
    let mut warnings = Vec::new();

    let symmetry = symmetry(&fields)?;
    let plane_count = fields.count(4, "Mc, the number of C planes", 1)?;
    let angle_count = fields.count(6, "Ng, the number of angles in a plane", 2)?;
    let mut sizes_m = [0.0; 6];
    for (size, line) in sizes_m.iter_mut().zip(16..=21) {
        let what = "a dimension of the luminous area in mm, 0 to 100000";
        let most_mm = LARGEST_OPENING_M / MILLIMETRE_M;
        *size = fields.optional(line, what, |mm| (0.0..=most_mm).contains(&mm))? * MILLIMETRE_M;
    }
    let downward_percent = fields.optional(22, "DFF, the downward flux fraction in percent", |_| true)?;
    let output_ratio_percent = fields.optional(23, "LORL, the light output ratio in percent", |_| true)?;
    let conversion = fields.number(24, "the conversion factor for intensities, above 0", |value| value > 0.0)?;
    let set_count = fields.count(HEADER_LINES, "the number of sets of lamps", 1)?;

    let sets = lamp_sets(&fields, set_count)?;
    let (set, absolute) = sets[0].clone();
    if sets.len() > 1 {
        warnings.push(format!(
            "the file contains {} sets of lamps; the first, {}, is taken",
            sets.len(),
            describe(&set)
        ));
    }
    let lamp_flux_lm = set.flux_lm.unwrap_or(0.0);

    let stored = stored_planes(symmetry, plane_count, &fields)?;
    let first_line = HEADER_LINES + set_count * LINES_PER_SET;
    let numbers = StoredNumbers::read(&lines, first_line, [plane_count, angle_count, stored], &mut warnings)?;
    let web = numbers.web(symmetry, conversion * lamp_flux_lm / 1000.0, &mut warnings)?;

    let flux = web.luminous_flux_lm();
    let header = Header { lamp_flux_lm, output_ratio_percent, downward_percent, absolute };
    header.compare(&web, flux, &mut warnings);
    let texts = [(1, "COMPANY"), (8, "REPORT"), (9, "LUMINAIRE"), (10, "NUMBER"), (11, "FILE"), (12, "DATE")];
    let keywords = texts.map(|(line, name)| (name.to_string(), fields.text(line).to_string()));
    Ok(PhotometricFile {
        format: PhotometricFormat::Eulumdat,
        manufacturer: fields.text(1).to_string(),
        luminaire: fields.text(9).to_string(),
        catalog_number: fields.text(10).to_string(),
        lamp: set.description.clone(),
        keywords: keywords.to_vec(),
        lamps: set.lamps,
        lumens_per_lamp: (!absolute && set.lamps > 0.0).then(|| lamp_flux_lm / set.lamps),
        declared_flux_lm: set.flux_lm,
        absolute,
        power_w: set.power_w,
        opening: opening(sizes_m),
        symmetry,
        photometric_type: PhotometricType::C,
        light_output_ratio: (!absolute && lamp_flux_lm > 0.0).then(|| flux / lamp_flux_lm),
        file_generation_type: None,
        lamp_sets: sets.into_iter().map(|(set, _)| set).collect(),
        web,
        warnings,
    })
}

/// The sets of lamps, each with whether its photometry is absolute.
fn lamp_sets(fields: &HeaderLines, count: usize) -> Result<Vec<(LampSet, bool)>, PhotometricError> {
    let end = count.checked_mul(LINES_PER_SET).map(|lines| lines.saturating_add(HEADER_LINES));
    if end.is_none_or(|end| end > fields.lines.len()) {
        return Err(PhotometricError::ended(
            fields.lines.len(),
            format!("{count} sets of lamps of {LINES_PER_SET} lines each"),
        ));
    }
    (0..count).map(|set| lamp_set(fields, HEADER_LINES + 1 + set * LINES_PER_SET)).collect()
}

/// The numbers after the sets of lamps: direct ratios (unused), C angles, γ angles and intensities.
struct StoredNumbers {
    c_deg: Vec<f64>,
    gamma_deg: Vec<f64>,
    /// Number of planes with intensities.
    stored: usize,
    /// Intensities in cd per 1000 lm over the conversion factor, plane by plane.
    values_cd_per_klm: Vec<f64>,
}

impl StoredNumbers {
    /// Reads them from `first_line` (from 0) on, for numbers of C planes, of γ angles and of planes with intensities.
    fn read(
        lines: &[String],
        first_line: usize,
        [plane_count, angle_count, stored]: [usize; 3],
        warnings: &mut Vec<String>,
    ) -> Result<StoredNumbers, PhotometricError> {
        let mut tokens = Tokens::new(&lines[first_line..], first_line + 1, Comma::Decimal);
        let promised = stored.checked_mul(angle_count).and_then(|cells| cells.checked_add(plane_count));
        let promised = promised.and_then(|sum| sum.checked_add(angle_count + DIRECT_RATIOS));
        if promised.is_none_or(|promised| promised > tokens.left()) {
            let have = tokens.left();
            let expected = format!(
                "{DIRECT_RATIOS} direct ratios, {plane_count} C angles, {angle_count} gamma angles and {stored} planes of intensities, but only {have} values are there"
            );
            return Err(PhotometricError::ended(lines.len(), expected));
        }
        tokens.list(DIRECT_RATIOS, "a direct ratio", "write 0 where none is known", |_| true)?;
        let c_deg = tokens.angles(plane_count, "C angles", -180.0..=360.0)?;
        let gamma_deg = tokens.angles(angle_count, "gamma angles", 0.0..=180.0)?;
        let remedy = "no light source has a negative intensity; check Mc, Ng and that no value is missing";
        let values_cd_per_klm =
            tokens.list(stored * angle_count, "an intensity of 0 or more", remedy, |value| value >= 0.0)?;
        if tokens.left() > 0 {
            warnings.push(format!("{} values after the last intensity were ignored", tokens.left()));
        }
        Ok(StoredNumbers { c_deg, gamma_deg, stored, values_cd_per_klm })
    }

    /// The table of intensities all around, in cd. `per_value` is the intensity of a stored value of 1.
    fn web(
        self,
        symmetry: LateralSymmetry,
        per_value: f64,
        warnings: &mut Vec<String>,
    ) -> Result<IntensityWeb, PhotometricError> {
        let angle_count = self.gamma_deg.len();
        let planes = plane_angles(&self.c_deg, symmetry, self.stored)?;
        let turn = unfold(&planes, &self.values_cd_per_klm, angle_count, symmetry);
        if turn.disagreement > FLUX_TOLERANCE {
            let percent = 100.0 * turn.disagreement;
            warnings
                .push(format!("planes given twice differ by up to {percent:.1} % of the maximum; the first was taken"));
        }
        let (lowest, highest) = (self.gamma_deg[0], self.gamma_deg[angle_count - 1]);
        if !([0.0, 90.0].contains(&lowest) && [90.0, 180.0].contains(&highest)) {
            warnings.push(format!("gamma runs from {lowest} to {highest} degrees; outside of it the intensity is 0"));
        }
        let candela = turn.intensity.iter().map(|value| value * per_value).collect();
        IntensityWeb::new(turn.c_deg, self.gamma_deg, candela).map_err(|error| {
            let remedy = "check the conversion factor, the flux of the lamps and the angles";
            PhotometricError::malformed(24, &error.to_string(), "a table of intensities", remedy)
        })
    }
}

/// The lines of the header, by their number in the standard.
struct HeaderLines<'a> {
    lines: &'a [String],
}

impl HeaderLines<'_> {
    fn text(&self, line: usize) -> &str {
        self.lines.get(line - 1).map(|line| line.trim()).unwrap_or_default()
    }

    fn number(&self, line: usize, what: &str, holds: impl Fn(f64) -> bool) -> Result<f64, PhotometricError> {
        if line > self.lines.len() {
            return Err(PhotometricError::ended(self.lines.len(), what));
        }
        number(self.text(line), Comma::Decimal).filter(|&value| holds(value)).ok_or_else(|| {
            let remedy =
                "every field of EULUMDAT has its own line: check that none is missing or added before this one";
            PhotometricError::malformed(line, self.text(line), what, remedy)
        })
    }

    /// Reads a number that no result depends on. An empty line is 0.
    fn optional(&self, line: usize, what: &str, holds: impl Fn(f64) -> bool) -> Result<f64, PhotometricError> {
        if line <= self.lines.len() && self.text(line).is_empty() {
            return Ok(0.0);
        }
        self.number(line, what, holds)
    }

    /// Reads a whole number, at most the number of lines of the file. An absurd number therefore allocates nothing.
    fn count(&self, line: usize, what: &str, least: usize) -> Result<usize, PhotometricError> {
        let most = self.lines.len();
        let expected = format!("{what}: a whole number from {least} to the number of lines");
        let holds = |value: f64| value.fract() == 0.0 && value >= least as f64 && value <= most as f64;
        self.number(line, &expected, holds).map(|value| value as usize)
    }
}

fn symmetry(fields: &HeaderLines) -> Result<LateralSymmetry, PhotometricError> {
    let what = "Isym, the symmetry: 0, 1, 2, 3 or 4";
    let code = fields.number(3, what, |value| [0.0, 1.0, 2.0, 3.0, 4.0].contains(&value))?;
    let kinds = [
        LateralSymmetry::None,
        LateralSymmetry::Rotational,
        LateralSymmetry::AboutC0,
        LateralSymmetry::AboutC90,
        LateralSymmetry::Quadrant,
    ];
    Ok(kinds[code as usize])
}

/// Number of the Mc planes with intensities in the file.
fn stored_planes(symmetry: LateralSymmetry, planes: usize, fields: &HeaderLines) -> Result<usize, PhotometricError> {
    let (divisor, stored) = match symmetry {
        LateralSymmetry::None => (1, planes),
        LateralSymmetry::Rotational => (1, 1),
        LateralSymmetry::AboutC0 | LateralSymmetry::AboutC90 => (2, planes / 2 + 1),
        LateralSymmetry::Quadrant => (4, planes / 4 + 1),
    };
    if planes.is_multiple_of(divisor) {
        return Ok(stored);
    }
    let expected = format!("Mc divisible by {divisor}, as the symmetry on line 3 requires");
    Err(PhotometricError::malformed(4, fields.text(4), expected, "correct Isym or Mc"))
}

/// The C angles of the stored planes. The file lists all Mc angles. With Isym 3 it stores C270 … C0 … C90; otherwise the stored planes
/// begin at C0.
fn plane_angles(c_deg: &[f64], symmetry: LateralSymmetry, stored: usize) -> Result<Vec<f64>, PhotometricError> {
    let start = match symmetry {
        LateralSymmetry::AboutC90 => c_deg.iter().position(|&c| c == 270.0 || c == -90.0),
        _ => Some(0),
    };
    let chosen: Option<Vec<f64>> =
        start.map(|start| (0..stored).map(|index| c_deg[(start + index) % c_deg.len()]).collect());
    let ends = match symmetry {
        LateralSymmetry::None | LateralSymmetry::Rotational => None,
        LateralSymmetry::AboutC0 => Some((0.0, 180.0)),
        LateralSymmetry::AboutC90 => Some((270.0, 90.0)),
        LateralSymmetry::Quadrant => Some((0.0, 90.0)),
    };
    let turned = |c: f64| c.rem_euclid(360.0);
    let fits = |planes: &Vec<f64>| ends.is_none_or(|ends| (turned(planes[0]), turned(planes[stored - 1])) == ends);
    chosen.filter(fits).ok_or_else(|| {
        let (from, to) = ends.unwrap_or((0.0, 360.0));
        let expected = format!("C angles in which the {stored} stored planes run from C{from} to C{to}");
        let shown = format!("{} to {}", c_deg[0], c_deg[c_deg.len() - 1]);
        PhotometricError::malformed(4, &shown, expected, "correct Isym, Mc or the list of C angles")
    })
}

/// Reads a set of lamps, and whether the photometry is absolute. A negative number of lamps means absolute.
fn lamp_set(fields: &HeaderLines, line: usize) -> Result<(LampSet, bool), PhotometricError> {
    let lamps = fields.number(line, "the number of lamps (negative for absolute photometry)", |_| true)?;
    let flux = fields.number(line + 2, "the total luminous flux of the lamps in lm, 0 or more", |lm| lm >= 0.0)?;
    let watts = fields.optional(line + 5, "the power in W, 0 or more", |watts| watts >= 0.0)?;
    let set = LampSet {
        lamps: lamps.abs(),
        flux_lm: Some(flux),
        description: fields.text(line + 1).to_string(),
        colour: fields.text(line + 3).to_string(),
        colour_rendering: fields.text(line + 4).to_string(),
        power_w: (watts > 0.0).then_some(watts),
    };
    Ok((set, lamps < 0.0))
}

fn describe(set: &LampSet) -> String {
    let flux = set.flux_lm.map(|lm| format!(", {lm} lm")).unwrap_or_default();
    format!("{} × {}{flux}", set.lamps, if set.description.is_empty() { "lamp" } else { &set.description })
}

/// Statements of the header about the flux.
struct Header {
    lamp_flux_lm: f64,
    output_ratio_percent: f64,
    downward_percent: f64,
    absolute: bool,
}

impl Header {
    /// Warns if header and integral disagree. The intensities count in any case.
    fn compare(&self, web: &IntensityWeb, flux_lm: f64, warnings: &mut Vec<String>) {
        if flux_lm == 0.0 {
            warnings.push("all intensities or the lamps' flux are 0: the luminaire is dark".to_string());
            return;
        }
        let percent = 100.0 * flux_lm / self.lamp_flux_lm;
        let claimed = if self.absolute { 100.0 } else { self.output_ratio_percent };
        let over = percent > 100.0 * (1.0 + FLUX_TOLERANCE);
        let apart = claimed > 0.0 && (percent - claimed).abs() > FLUX_TOLERANCE * claimed;
        if over || apart {
            warnings.push(format!(
                "the intensities add up to {flux_lm:.1} lm, {percent:.1} % of the lamps' {:.1} lm, where the file states {claimed} %; the flux from the intensities is used",
                self.lamp_flux_lm
            ));
        }
        let downward = web.hemisphere_fluxes_lm().map(|[below, _]| 100.0 * below / flux_lm);
        if let Some(downward) = downward
            .filter(|down| self.downward_percent > 0.0 && (down - self.downward_percent).abs() > 100.0 * FLUX_TOLERANCE)
        {
            let claimed = self.downward_percent;
            warnings.push(format!("{downward:.1} % of the flux goes downward, where the header states {claimed} %"));
        }
    }
}

/// The luminous area: length (along C90–C270, the luminaire's length), width (0 for round), heights towards C0, C90, C180, C270.
fn opening([length_m, width_m, heights @ ..]: [f64; 6]) -> Opening {
    let height_m = heights.into_iter().fold(0.0, f64::max);
    match (length_m > 0.0, width_m > 0.0, height_m > 0.0) {
        (false, false, false) => Opening::Point,
        (true, false, false) => Opening::Disk { diameter_m: length_m },
        (true, false, true) => Opening::VerticalCylinder { diameter_m: length_m, height_m },
        (_, _, false) => Opening::Rectangle { c0_m: width_m, c90_m: length_m },
        (_, _, true) => Opening::Box { c0_m: width_m, c90_m: length_m, height_m },
    }
}
