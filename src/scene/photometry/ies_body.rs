//! The numbers of an IES file, in the order of the file.

use super::file::LARGEST_OPENING_M;
use super::text::{Comma, Tokens};
use super::{PhotometricError, PhotometricType};

/// Metres in a foot.
pub(super) const FOOT_M: f64 = 0.3048;

/// The numbers after the TILT line as in the file.
pub(super) struct IesNumbers {
    pub tilt: Option<Tilt>,
    pub lamps: f64,
    /// Negative in absolute photometry.
    pub lumens_per_lamp: f64,
    pub multiplier: f64,
    pub photometric_type: PhotometricType,
    pub feet: bool,
    /// Width, length, height in the file's unit, with their signs.
    pub dimensions: [f64; 3],
    pub ballast_factor: f64,
    /// Ballast-lamp factor (1986, 1991), future use (1995, 2002) or file generation type (2019).
    pub third_factor: f64,
    pub factor_line: usize,
    pub watts: f64,
    pub vertical_deg: Vec<f64>,
    pub horizontal_deg: Vec<f64>,
    pub horizontal_line: usize,
    /// `values[horizontal * vertical_deg.len() + vertical]`, without any factor.
    pub values: Vec<f64>,
}

/// Dependence of a lamp's output on its tilt.
pub(super) struct Tilt {
    angles_deg: Vec<f64>,
    factors: Vec<f64>,
}

impl Tilt {
    /// The factor at a tilt of 0°, linear between the file's angles.
    pub fn factor_untilted(&self) -> f64 {
        let above = self.angles_deg.partition_point(|&angle| angle < 0.0);
        if above == 0 || above == self.angles_deg.len() {
            return self.factors[above.min(self.factors.len() - 1)];
        }
        let (from, to) = (self.angles_deg[above - 1], self.angles_deg[above]);
        let share = (0.0 - from) / (to - from);
        (1.0 - share) * self.factors[above - 1] + share * self.factors[above]
    }
}

/// The numbers of a file, how its commas were read, and the number of tokens that follow.
pub(super) struct Tokenized {
    pub body: IesNumbers,
    pub comma: Comma,
    pub leftover: usize,
}

/// Reads the numbers, with commas as delimiters, as the standard defines them.
///
/// Commas are decimal only under these conditions: the numbers do not fit with commas as delimiters, no number has a point, every comma
/// has a digit on both sides, and the numbers fit with decimal commas.
pub(super) fn read_body(lines: &[String], first_line: usize, tilt: bool) -> Result<Tokenized, PhotometricError> {
    let read = |comma: Comma| {
        let mut tokens = Tokens::new(lines, first_line, comma);
        let body = body(&mut tokens, tilt)?;
        Ok(Tokenized { body, comma, leftover: tokens.left() })
    };
    let standard = read(Comma::Delimiter);
    let even = standard.as_ref().is_ok_and(|read| read.leftover == 0);
    if even || !commas_may_be_decimal(lines) {
        return standard;
    }
    match read(Comma::Decimal) {
        Ok(decimal) if decimal.leftover == 0 => Ok(decimal),
        _ => standard,
    }
}

/// Whether no number has a point and every comma lies between digits.
fn commas_may_be_decimal(lines: &[String]) -> bool {
    let between_digits = |line: &String| {
        let bytes = line.as_bytes();
        let digit = |index: Option<usize>| index.and_then(|i| bytes.get(i)).is_some_and(u8::is_ascii_digit);
        let holds = |(at, &byte): (usize, &u8)| byte != b',' || (digit(at.checked_sub(1)) && digit(Some(at + 1)));
        bytes.iter().enumerate().all(holds)
    };
    let any = |wanted: char| lines.iter().any(|line| line.contains(wanted));
    any(',') && !any('.') && lines.iter().all(between_digits)
}

/// Reads lamp geometry, angles and factors.
pub(super) fn read_tilt(tokens: &mut Tokens) -> Result<Tilt, PhotometricError> {
    let geometry = "a lamp-to-luminaire geometry: 1 (lamp vertical), 2 or 3 (lamp horizontal)";
    tokens.checked(geometry, "write 1 where it is not known", |value| [1.0, 2.0, 3.0].contains(&value))?;
    let count = tokens.count("the number of tilt angles", 1)?;
    let angles_deg = tokens.angles(count, "tilt angles", -180.0..=180.0)?;
    let factors = tokens.list(count, "a tilt factor of 0 or more", "check the tilt factors", |value| value >= 0.0)?;
    Ok(Tilt { angles_deg, factors })
}

fn body(tokens: &mut Tokens, included_tilt: bool) -> Result<IesNumbers, PhotometricError> {
    let tilt = if included_tilt { Some(read_tilt(tokens)?) } else { None };
    let not_negative = |value: f64| value >= 0.0;
    let lamps = tokens.checked("a number of lamps of 0 or more", "write 1 if it is not known", not_negative)?;
    let lumens_per_lamp = tokens.number("the lumens per lamp (-1 for absolute photometry)")?;
    let multiplier = tokens.checked("a candela multiplier of 0 or more", "write 1 where none applies", not_negative)?;
    let verticals = tokens.count("the number of vertical angles", 2)?;
    let horizontals = tokens.count("the number of horizontal angles", 1)?;
    let types = [PhotometricType::C, PhotometricType::B, PhotometricType::A];
    let code = "a photometric type: 1 (C), 2 (B) or 3 (A)";
    let type_code =
        tokens.checked(code, "most luminaires are of type C: 1", |value| [1.0, 2.0, 3.0].contains(&value))?;
    let photometric_type = types[type_code as usize - 1];
    let unit = "a unit: 1 (feet) or 2 (metres)";
    let feet = tokens.checked(unit, "write 2 for metres", |value| [1.0, 2.0].contains(&value))? == 1.0;
    let unit_m = if feet { FOOT_M } else { 1.0 };
    let mut dimensions = [0.0; 3];
    for (size, what) in dimensions.iter_mut().zip(["the width", "the length", "the height"]) {
        let expected = format!("{what} of the luminous opening, at most {LARGEST_OPENING_M} m");
        *size = tokens.checked(&expected, "check the dimensions and their unit", |size| {
            size.abs() * unit_m <= LARGEST_OPENING_M
        })?;
    }
    let factor_line = tokens.line();
    let ballast = "a ballast factor above 0";
    let ballast_factor =
        tokens.checked(ballast, "it multiplies every intensity; write 1 if it is not known", |value| value > 0.0)?;
    let third_factor = tokens.number("the ballast-lamp factor (1 where unused)")?;
    let watts = tokens.checked("input watts of 0 or more", "write 0 if they are not known", not_negative)?;

    // The size of the table is compared with the rest of the file before memory of that size is allocated.
    let promised = verticals.checked_mul(horizontals).and_then(|cells| cells.checked_add(verticals + horizontals));
    if promised.is_none_or(|promised| promised > tokens.left()) {
        let expected = format!(
            "{verticals} vertical and {horizontals} horizontal angles and an intensity for each pair, but only {} values are there",
            tokens.left()
        );
        return Err(PhotometricError::ended(tokens.line(), expected));
    }
    let vertical_range = if photometric_type == PhotometricType::C { 0.0..=180.0 } else { -90.0..=90.0 };
    let horizontal_range = match photometric_type {
        PhotometricType::C => -180.0..=360.0,
        PhotometricType::A | PhotometricType::B => -90.0..=90.0,
    };
    let vertical_deg = tokens.angles(verticals, "vertical angles", vertical_range)?;
    let horizontal_line = tokens.line();
    let horizontal_deg = tokens.angles(horizontals, "horizontal angles", horizontal_range)?;
    if photometric_type != PhotometricType::C && horizontals < 2 {
        let remedy = "only type C allows a single plane, with rotational symmetry";
        return Err(tokens.refuse_last("two horizontal angles or more for types A and B", remedy));
    }
    let intensity = "an intensity of 0 or more";
    let remedy = "no light source has a negative intensity; check the counts of angles and that no value is missing";
    let values = tokens.list(verticals * horizontals, intensity, remedy, not_negative)?;
    Ok(IesNumbers {
        tilt,
        lamps,
        lumens_per_lamp,
        multiplier,
        photometric_type,
        feet,
        dimensions,
        ballast_factor,
        third_factor,
        factor_line,
        watts,
        vertical_deg,
        horizontal_deg,
        horizontal_line,
        values,
    })
}
