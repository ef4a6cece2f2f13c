//! The polar diagram of a luminaire: intensity over γ in its two main planes.

use super::axes::TYPE;
use super::color::{BLACK, BLUE, FAINT, SOFT, VERMILION};
use super::numbers::{amount, round_step, tick};
use super::picture::{PagePoint, Pen, Picture, TextAnchor, Words};
use super::texts::{said, say, words};
use crate::scene::photometry::IntensityWeb;

const WIDTH: f64 = 560.0;
const RADIUS: f64 = 215.0;
const MIDDLE: PagePoint = [280.0, 300.0];
/// Left edge of the words, and type size of the facts on the intensities.
const LEFT: f64 = 24.0;
const FACTS: f64 = 13.0;
/// Largest number of rings of the diagram.
const MOST_RINGS: usize = 5;
/// Step of γ in degrees along a curve.
const STEP_DEG: f64 = 0.5;

/// Note on the values of a photometric file.
pub const INITIAL: &str = words!("Initial values, undimmed.");
/// Note on the light that leaves a scene.
pub const LEAVING: &str = words!("All light that leaves the scene, maintained values.");

/// Draws the intensity in the planes C0–C180 and C90–C270, with γ = 0 downward, as given by the distribution. `values` is a note on
/// the kind of values.
pub fn polar_picture(name: &str, web: &IntensityWeb, values: &'static str) -> Picture {
    let mut picture = Picture::new(WIDTH, 606.0, say!("Luminous intensity of {}", name));
    picture.words(Words::new(say!("Luminous intensity: {}", name), [24.0, 26.0], 17.0).bold());
    let flux_lm = web.luminous_flux_lm();
    let facts = say!("Φ = {} lm, greatest intensity {} cd", amount(flux_lm), amount(web.maximum_intensity_cd()));
    picture.words(Words::new(facts, [LEFT, 46.0], FACTS).ink(SOFT));
    picture.words(Words::new(said(values), [LEFT, 592.0], TYPE).ink(SOFT));
    if flux_lm > 0.0 {
        let per_klm = say!("For cd per 1000 lm of the luminaire, divide by {}.", tick_short(flux_lm / 1000.0));
        picture.words(Words::new(per_klm, [LEFT, 576.0], TYPE).ink(SOFT));
    }

    let curves = [(0.0, BLUE, None), (90.0, VERMILION, Some([7.0, 4.0]))];
    let most_cd = curves.iter().flat_map(|(c_deg, ..)| profile(web, *c_deg)).map(|(_, cd)| cd).fold(0.0, f64::max);
    let step_cd = if most_cd > 0.0 { round_step(most_cd, MOST_RINGS) } else { 1.0 };
    let rings = (most_cd / step_cd - 1e-9).ceil().max(1.0);
    let scale = RADIUS / (rings * step_cd);
    draw_rings(&mut picture, rings as u32, step_cd, scale);
    for (c_deg, ink, dash) in curves {
        let spots = profile(web, c_deg).map(|(gamma_deg, cd)| spot(gamma_deg, cd * scale)).collect();
        picture.line(spots, Pen { dash, ..Pen::new(ink, 2.0) });
    }
    for (index, (c_deg, ink, dash)) in curves.into_iter().enumerate() {
        let (x, y) = (24.0 + 170.0 * index as f64, 553.0);
        picture.line(vec![[x, y - 4.0], [x + 30.0, y - 4.0]], Pen { dash, ..Pen::new(ink, 2.0) });
        picture.words(Words::new(format!("C{c_deg:.0} – C{:.0}", c_deg + 180.0), [x + 38.0, y], TYPE));
    }
    picture
}

fn tick_short(number: f64) -> String {
    tick((number * 1e3).round() / 1e3)
}

/// Angles from −180° (on the opposite half plane) to 180°, with the intensity in cd.
fn profile(web: &IntensityWeb, c_deg: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
    let steps = (180.0 / STEP_DEG) as i32;
    (-steps..=steps).map(move |step| {
        let angle_deg = f64::from(step) * STEP_DEG;
        let plane_deg = if angle_deg < 0.0 { c_deg + 180.0 } else { c_deg };
        (angle_deg, web.intensity_cd(plane_deg, angle_deg.abs()))
    })
}

/// The point on the page: γ = 0 points down, C0 (C90) to the right.
fn spot(angle_deg: f64, radius: f64) -> PagePoint {
    let (sine, cosine) = angle_deg.to_radians().sin_cos();
    [MIDDLE[0] + radius * sine, MIDDLE[1] + radius * cosine]
}

fn draw_rings(picture: &mut Picture, rings: u32, step_cd: f64, scale: f64) {
    for ring in 1..=rings {
        picture.circle(MIDDLE, f64::from(ring) * step_cd * scale, Pen::new(FAINT, 1.0));
    }
    for step in -5..=6 {
        let angle_deg = 30.0 * f64::from(step);
        picture.line(vec![MIDDLE, spot(angle_deg, RADIUS)], Pen::new(FAINT, 1.0));
        let [x, y] = spot(angle_deg, RADIUS + 15.0);
        let words = Words::new(format!("{:.0}°", angle_deg.abs()), [x, y + 4.0], TYPE);
        picture.words(words.anchored(TextAnchor::Middle).ink(SOFT));
    }
    picture.circle(MIDDLE, RADIUS, Pen::new(BLACK, 0.8));
    for ring in 1..=rings {
        let cd = f64::from(ring) * step_cd;
        let unit = if ring == rings { " cd" } else { "" };
        let at = spot(15.0 + 30.0, cd * scale);
        let words = Words::new(format!("{}{unit}", amount(cd)), [at[0], at[1] + 4.0], 11.0);
        picture.words(words.anchored(TextAnchor::Middle).ink(SOFT).rimmed(2.0));
    }
}
