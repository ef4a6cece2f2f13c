//! Writes the photometric files of `scenes/luminaires`, calculated from closed formulas whose flux is known exactly.
//!
//! `cargo run --release --example make_luminaire_files [FOLDER]`

use std::f64::consts::PI;
use std::fmt::Write;
use std::path::PathBuf;

/// A luminaire defined by a formula.
pub struct Formula {
    /// File name.
    pub file: &'static str,
    /// The formula, as the file's labels state it.
    pub text: &'static str,
    /// Flux of the formula in lm.
    pub flux_lm: f64,
    /// Intensity in cd at (C, γ) in rad, γ up to π/2.
    pub intensity_cd: fn(f64, f64) -> f64,
    /// C angles of the stored planes in degrees.
    pub c_deg: Vec<f64>,
    /// γ angles in degrees.
    pub gamma_deg: Vec<f64>,
}

const TROFFER_LM: f64 = 3600.0;
const DOWNLIGHT_LM: f64 = 1100.0;
const WALL_WASHER_LM: f64 = 1500.0;
const SPOTLIGHT_LM: f64 = 900.0;

/// Φ = π I₀: the part in cos 2C has the integral 0.
fn troffer_cd(c: f64, gamma: f64) -> f64 {
    TROFFER_LM / PI * gamma.cos() * (1.0 + 0.2 * gamma.sin().powi(2) * (2.0 * c).cos())
}

/// Φ = 2π I₀/5.
fn downlight_cd(_c: f64, gamma: f64) -> f64 {
    5.0 * DOWNLIGHT_LM / (2.0 * PI) * gamma.cos().powi(4)
}

/// Φ = π I₀ (1 + 1/4): the last term of the square contains ∫ cos γ sin³γ dγ = 1/4 and the mean 1/2 of cos² C.
fn wall_washer_cd(c: f64, gamma: f64) -> f64 {
    WALL_WASHER_LM / (1.25 * PI) * gamma.cos() * (1.0 + gamma.sin() * c.cos()).powi(2)
}

/// Φ = 2π I₀ (1/21 + 2 (1/21 − 1/23)).
fn spotlight_cd(c: f64, gamma: f64) -> f64 {
    let at_one_candela_lm = 2.0 * PI * (1.0 / 21.0 + 2.0 * (1.0 / 21.0 - 1.0 / 23.0));
    let throw = 1.0 + 2.0 * gamma.sin() * (c - PI / 6.0).cos();
    SPOTLIGHT_LM / at_one_candela_lm * gamma.cos().powi(20) * throw.powi(2)
}

/// `from`, `from + step`, … up to and including `to`.
fn steps(from: f64, to: f64, step: f64) -> Vec<f64> {
    (0..=((to - from) / step).round() as usize).map(|i| from + i as f64 * step).collect()
}

/// The formulas of all files.
pub fn formulas() -> [Formula; 4] {
    let fine_then_coarse = [steps(0.0, 29.5, 0.5), steps(30.0, 90.0, 1.0)].concat();
    [
        Formula {
            file: "troffer.ies",
            text: "I = I0 cos(gamma) (1 + 0.2 sin^2(gamma) cos(2C)), nothing above; flux pi I0 = 3600 lm",
            flux_lm: TROFFER_LM,
            intensity_cd: troffer_cd,
            c_deg: steps(0.0, 90.0, 7.5),
            gamma_deg: steps(0.0, 90.0, 1.0),
        },
        Formula {
            file: "downlight.ldt",
            text: "I = I0 cos^4(gamma), nothing above; flux 2 pi I0/5 = 1100 lm",
            flux_lm: DOWNLIGHT_LM,
            intensity_cd: downlight_cd,
            c_deg: vec![0.0],
            gamma_deg: steps(0.0, 90.0, 1.0),
        },
        Formula {
            file: "wall_washer.ldt",
            text: "I = I0 cos(gamma) (1 + sin(gamma) cos(C))^2, nothing above; 1.25 pi I0 = 1500 lm",
            flux_lm: WALL_WASHER_LM,
            intensity_cd: wall_washer_cd,
            c_deg: steps(0.0, 180.0, 5.0),
            gamma_deg: steps(0.0, 90.0, 1.0),
        },
        Formula {
            file: "spotlight.ies",
            text: "I = I0 cos^20(gamma) (1 + 2 sin(gamma) cos(C - 30 deg))^2, nothing above; flux 2 pi I0 (1/21 + 2 (1/21 - 1/23)) = 900 lm",
            flux_lm: SPOTLIGHT_LM,
            intensity_cd: spotlight_cd,
            c_deg: steps(0.0, 360.0, 10.0),
            gamma_deg: fine_then_coarse,
        },
    ]
}

/// The text of a formula's file.
pub fn file_text(formula: &Formula) -> String {
    let cd = |c: f64, gamma: f64| (formula.intensity_cd)(c.to_radians(), gamma.to_radians());
    match formula.file {
        "troffer.ies" => ies(
            formula,
            ("IESNA:LM-63-2002", "LED TROFFER 600 x 600", "4 LED MODULES 1000 LM", "4 1000 1"),
            ("0.6 0.6 0", "1 1 32"),
            cd,
        ),
        "spotlight.ies" => ies(
            formula,
            ("IES:LM-63-2019", "TRACK SPOTLIGHT, OBLIQUE BEAM", "LED", "1 -1 1"),
            ("-0.08 -0.08 0", "1 1.00010 11"),
            cd,
        ),
        "downlight.ldt" => {
            let set = ["1", "LED module", "1375", "3000 K", "90", "13.5"];
            eulumdat(formula, ("1", "1", 1, "Round downlight"), ["150", "0", "80"], set, cd)
        }
        _ => {
            let set = ["-1", "LED", "1500", "3000 K", "90", "17"];
            eulumdat(formula, ("2", "2", 72, "Linear wall washer"), ["1200", "60", "100"], set, cd)
        }
    }
}

/// An LM-63 text. `titles` are standard, luminaire, lamp, and lamps with lumens and multiplier.
fn ies(
    formula: &Formula,
    titles: (&str, &str, &str, &str),
    (dimensions, factors): (&str, &str),
    cd: impl Fn(f64, f64) -> f64,
) -> String {
    let (standard, luminaire, lamp, lamps) = titles;
    let mut lines = vec![
        standard.to_string(),
        "[TEST] luxmc sample".to_string(),
        "[TESTLAB] computed from the formula under [OTHER], not measured".to_string(),
        "[ISSUEDATE] 01-JAN-2026".to_string(),
        "[MANUFAC] luxmc samples".to_string(),
        format!("[LUMCAT] {}", formula.file.trim_end_matches(".ies").to_uppercase()),
        format!("[LUMINAIRE] {luminaire}"),
        format!("[LAMP] {lamp}"),
        format!("[OTHER] {}", formula.text),
        "TILT=NONE".to_string(),
        format!("{lamps} {} {} 1 2 {dimensions}", formula.gamma_deg.len(), formula.c_deg.len()),
        factors.to_string(),
    ];
    lines.extend(wrapped(formula.gamma_deg.iter().map(|angle| format!("{angle}"))));
    lines.extend(wrapped(formula.c_deg.iter().map(|angle| format!("{angle}"))));
    for &c in &formula.c_deg {
        lines.extend(wrapped(formula.gamma_deg.iter().map(|&gamma| decimals(cd(c, gamma), 3))));
    }
    lines.join("\r\n") + "\r\n"
}

/// An EULUMDAT text. `kinds` are Ityp, Isym, Mc and the luminaire's name, `sizes` length, width, height in mm.
fn eulumdat(
    formula: &Formula,
    kinds: (&str, &str, usize, &str),
    sizes: [&str; 3],
    set: [&str; 6],
    cd: impl Fn(f64, f64) -> f64,
) -> String {
    let (kind, symmetry, planes, name) = kinds;
    let lamp_flux_lm: f64 = set[2].parse().unwrap_or(f64::NAN);
    let turn: Vec<f64> = (0..planes).map(|plane| plane as f64 * 360.0 / planes as f64).collect();
    let between = if planes == 1 { "0".to_string() } else { format!("{}", turn[1]) };
    let counts =
        [kind, symmetry, &planes.to_string(), &between, &formula.gamma_deg.len().to_string(), "1"].map(String::from);
    let mut lines = vec!["luxmc samples".to_string()];
    lines.extend(counts);
    lines.extend(["computed, not measured", name, formula.file, formula.file, formula.text].map(String::from));
    lines.extend(sizes.map(String::from));
    lines.extend([sizes[0], sizes[1], "0", "0", "0", "0", "100"].map(String::from));
    lines.push(format!("{}", 100.0 * formula.flux_lm / lamp_flux_lm));
    lines.extend(["1", "0", "1"].map(String::from));
    lines.extend(set.map(String::from));
    lines.extend((0..10).map(|_| "0".to_string()));
    lines.extend(turn.iter().chain(&formula.gamma_deg).map(|angle| format!("{angle}")));
    for &c in &formula.c_deg {
        lines.extend(formula.gamma_deg.iter().map(|&gamma| decimals(cd(c, gamma) * 1000.0 / lamp_flux_lm, 4)));
    }
    lines.join("\r\n") + "\r\n"
}

/// A number with `places` decimals. Zero has no sign.
fn decimals(value: f64, places: usize) -> String {
    let mut text = String::new();
    let _ = write!(text, "{:.places$}", value.max(0.0) + 0.0);
    text
}

/// Values in lines of at most 132 characters, the limit of LM-63.
fn wrapped(values: impl Iterator<Item = String>) -> Vec<String> {
    let mut lines = vec![String::new()];
    for value in values {
        let last = lines.len() - 1;
        if lines[last].is_empty() {
            lines[last] = value;
        } else if lines[last].len() + 1 + value.len() <= 130 {
            lines[last].push(' ');
            lines[last].push_str(&value);
        } else {
            lines.push(value);
        }
    }
    lines
}

fn main() -> std::io::Result<()> {
    let stored = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("scenes/luminaires");
    let folder = std::env::args_os().nth(1).map_or(stored, PathBuf::from);
    std::fs::create_dir_all(&folder)?;
    formulas().iter().try_for_each(|formula| std::fs::write(folder.join(formula.file), file_text(formula)))
}
