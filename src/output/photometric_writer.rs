//! Writes intensity distributions as IES LM-63-2002 and EULUMDAT files. Neither contains a date, so that equal runs give equal
//! bytes.

use super::leaving_light::LeavingLight;
use super::sheet::shortest;
use crate::scene::Scene;
use crate::scene::photometry::DIRECT_RATIOS;

/// Numbers on a line of an IES file.
const NUMBERS_PER_LINE: usize = 8;
/// Largest number of letters of a text field of an EULUMDAT file.
const LONGEST_FIELD: usize = 78;
/// Largest number of letters of a line of an IES file, without its keyword.
const LONGEST_LABEL: usize = 200;

/// An IES file. The luminaires' flux is given as that of one lamp; intensities are in cd.
pub(super) fn ies_text(scene: &Scene, light: &LeavingLight) -> String {
    let (web, [c0_m, c90_m, height_m]) = (&light.web, light.table.opening_m);
    let is_rotational = light.table.planes == 1;
    let planes = if is_rotational { 1 } else { web.c_deg.len() };
    let mut text = String::from("IESNA:LM-63-2002\n[TEST] computed\n");
    text += &format!("[TESTLAB] luxmc {}\n[ISSUEDATE] -\n[MANUFAC] -\n", env!("CARGO_PKG_VERSION"));
    text += &format!("[LUMINAIRE] {}\n", label(&scene.title, LONGEST_LABEL));
    text += &format!("[LUMCAT] {}\n", label(&light.map.name, LONGEST_LABEL));
    text += &format!("[OTHER] {}\n", label(&provenance(light), LONGEST_LABEL));
    text += "TILT=NONE\n";
    let lamps_lm = nine_digits(light.lamps_lm);
    text += &format!(
        "1 {lamps_lm} 1 {} {planes} 1 2 {} {} {}\n",
        web.gamma_deg.len(),
        nine_digits(c90_m),
        nine_digits(c0_m),
        nine_digits(height_m)
    );
    text += &format!("1 1 {}\n", nine_digits(light.power_w));
    text += &lines(&web.gamma_deg);
    text += &lines(&web.c_deg[..planes]);
    for plane in web.intensity_cd.chunks(web.gamma_deg.len()).take(planes) {
        text += &lines(plane);
    }
    text
}

/// An EULUMDAT file. The luminaires' flux is given as that of one set of lamps; intensities are for 1000 lm of it.
pub(super) fn eulumdat_text(scene: &Scene, light: &LeavingLight) -> String {
    let (web, table) = (&light.web, light.table);
    let is_rotational = table.planes == 1;
    let millimetres = light.table.opening_m.map(|extent_m| nine_digits(1000.0 * extent_m));
    let [c0_mm, c90_mm, height_mm] = &millimetres;
    let flux_lm = web.luminous_flux_lm();
    let downward = web.hemisphere_fluxes_lm().map_or(0.0, |[below_lm, _]| below_lm / flux_lm.max(f64::MIN_POSITIVE));
    // Without flux, intensities cannot be related to it.
    let per_klm = if light.lamps_lm > 0.0 { 1000.0 / light.lamps_lm } else { 1.0 };
    let mut fields: Vec<String> = Vec::new();
    let mut add = |field: &str| fields.push(field.to_owned());
    add("luxmc");
    add(if is_rotational { "1" } else { "3" });
    add(if is_rotational { "1" } else { "0" });
    add(&table.planes.to_string());
    add(&nine_digits(if is_rotational { 0.0 } else { 360.0 / f64::from(table.planes) }));
    add(&(table.steps + 1).to_string());
    add(&nine_digits(180.0 / f64::from(table.steps)));
    add(&label(&provenance(light), LONGEST_FIELD));
    add(&label(&scene.title, LONGEST_FIELD));
    add(&label(&light.map.name, LONGEST_FIELD));
    add("");
    add("");
    // Length, width and height of the luminaire, then of its luminous area. The length lies along C90–C270.
    [c90_mm, c0_mm, height_mm, c90_mm, c0_mm].into_iter().for_each(|size| add(size));
    (0..4).for_each(|_| add(height_mm));
    add(&nine_digits(100.0 * downward));
    add(&nine_digits(100.0 * light.light_output_ratio));
    ["1", "0", "1", "1", "all luminaires of the scene"].into_iter().for_each(&mut add);
    add(&nine_digits(light.lamps_lm));
    add("");
    add("");
    add(&nine_digits(light.power_w));
    (0..DIRECT_RATIOS).for_each(|_| add("0"));
    let planes = table.planes as usize;
    web.c_deg[..planes].iter().for_each(|angle| add(&nine_digits(*angle)));
    web.gamma_deg.iter().for_each(|angle| add(&nine_digits(*angle)));
    let stored = &web.intensity_cd[..planes * web.gamma_deg.len()];
    stored.iter().for_each(|intensity_cd| add(&nine_digits(intensity_cd * per_klm)));
    // The format's lines end with CR LF, as on the system where it was made.
    fields.join("\r\n") + "\r\n"
}

/// The origin of the distribution, in one line.
fn provenance(light: &LeavingLight) -> String {
    format!("computed, maintained values, stated error {:.2} %", 100.0 * light.map.error.estimated)
}

/// A text on one line, no longer than a field may be.
fn label(text: &str, most: usize) -> String {
    let text: String = text.chars().map(|letter| if letter.is_control() { ' ' } else { letter }).take(most).collect();
    let text = text.trim();
    if text.is_empty() { "-".to_owned() } else { text.to_owned() }
}

fn lines(numbers: &[f64]) -> String {
    let line = |numbers: &[f64]| numbers.iter().map(|number| nine_digits(*number)).collect::<Vec<_>>().join(" ") + "\n";
    numbers.chunks(NUMBERS_PER_LINE).map(line).collect()
}

/// A number with nine significant digits, without trailing zeros.
fn nine_digits(number: f64) -> String {
    let rounded = format!("{number:.8e}").parse().unwrap_or(number);
    shortest(rounded)
}
