//! Candela calculated by hand for every symmetry and goniometer, fluxes integrated independently, and malformed files.

use std::path::{Path, PathBuf};

use glam::DVec3;
use luxmc::scene::photometry::*;
use proptest::prelude::*;

#[allow(dead_code)]
#[path = "../../examples/make_luminaire_files.rs"]
mod make_luminaire_files;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn read(name: &str) -> PhotometricFile {
    read_photometric_file(&root().join("tests/data/photometric").join(name)).unwrap_or_else(|error| panic!("{error}"))
}

/// Asserts intensities at (C, γ) in degrees.
fn assert_candela(file: &PhotometricFile, expected: &[(f64, f64, f64)]) {
    for &(c, gamma, cd) in expected {
        let found = file.web.intensity_cd(c, gamma);
        assert!((found - cd).abs() <= 1e-9 * cd.max(1.0), "C {c}, gamma {gamma}: {found} cd, by hand {cd} cd");
    }
}

/// Independent of the closed form: midpoints in (C, cos γ), each looked up by its direction.
fn flux_by_quadrature_lm(web: &IntensityWeb, planes: usize, rings: usize) -> f64 {
    let frame = [DVec3::X, DVec3::Y, DVec3::Z];
    let solid_angle_sr = 4.0 * std::f64::consts::PI / (planes * rings) as f64;
    let ring = |i: usize| {
        let z = 1.0 - 2.0 * (i as f64 + 0.5) / rings as f64;
        let radius = (1.0 - z * z).sqrt();
        let at = |j: usize| {
            let c = std::f64::consts::TAU * (j as f64 + 0.5) / planes as f64;
            web.intensity_towards_cd(&frame, DVec3::new(radius * c.cos(), radius * c.sin(), z) * 3.0)
        };
        (0..planes).map(at).sum::<f64>()
    };
    (0..rings).map(ring).sum::<f64>() * solid_angle_sr
}

#[test]
fn quadrant_file_of_2002_ignores_the_third_factor() {
    // 1.8 = multiplier 2 × ballast 0.9. The 0.5 after it is "future use".
    let file = read("quadrant_2002.ies");
    assert_candela(
        &file,
        &[
            (0.0, 0.0, 180.0),
            (0.0, 45.0, 144.0),
            (180.0, 45.0, 144.0),
            (90.0, 45.0, 72.0),
            (270.0, 45.0, 72.0),
            (45.0, 45.0, 108.0),
            (315.0, 45.0, 108.0),
            (-30.0, 45.0, 120.0),
            (0.0, 22.5, 162.0),
            (90.0, 67.5, 36.0),
            (10.0, 100.0, 0.0),
        ],
    );
    assert_eq!(file.symmetry, LateralSymmetry::Quadrant);
    // Width 0.3 lies along C90–C270, length 1.2 along C0–C180.
    assert_eq!(file.opening, Opening::Box { c0_m: 1.2, c90_m: 0.3, height_m: 0.1 });
    assert_eq!((file.manufacturer.as_str(), file.luminaire.as_str()), ("luxmc\nconformity", "three angles"));
    assert_eq!((file.lamps, file.lumens_per_lamp, file.declared_flux_lm), (1.0, Some(1000.0), Some(1000.0)));
    assert_eq!((file.power_w, file.absolute), (Some(20.0), false));
}

#[test]
fn half_file_of_1995_mirrors_at_c0_and_measures_in_feet() {
    let file = read("half_1995.ies");
    let expected =
        [(0.0, 45.0, 50.0), (90.0, 45.0, 40.0), (270.0, 45.0, 40.0), (180.0, 45.0, 30.0), (225.0, 45.0, 35.0)];
    assert_candela(&file, &expected);
    assert_eq!(file.symmetry, LateralSymmetry::AboutC0);
    assert_eq!(file.opening, Opening::Disk { diameter_m: 0.3048 });
    assert_eq!(file.declared_flux_lm, Some(1000.0));
}

#[test]
fn ninety_file_of_1991_mirrors_at_c90_and_takes_the_ballast_lamp_factor() {
    // 0.4 = ballast 0.8 × ballast-lamp 0.5. C0 is the mirror image of C180. C300 is that of C240, a third of the way from C270 to C180.
    let file = read("ninety_1991.ies");
    let expected =
        [(90.0, 45.0, 20.0), (0.0, 45.0, 16.0), (180.0, 45.0, 16.0), (45.0, 45.0, 18.0), (300.0, 45.0, 40.0 / 3.0)];
    assert_candela(&file, &expected);
    assert_eq!((file.symmetry, file.format), (LateralSymmetry::AboutC90, PhotometricFormat::Ies1991));
    assert_eq!(file.opening, Opening::Sphere { diameter_m: 0.2 });
}

#[test]
fn full_file_of_2019_keeps_its_generation_type_out_of_the_candela() {
    let file = read("full_2019.ies");
    assert_candela(&file, &[(0.0, 90.0, 10.0), (90.0, 90.0, 20.0), (135.0, 90.0, 25.0), (315.0, 90.0, 25.0)]);
    // C 400° is C 40°: 10 + 10 · 40/90 at γ = 90°, half way to the 7 at 180°.
    assert_candela(&file, &[(400.0, 135.0, 0.5 * (10.0 + 400.0 / 90.0 + 7.0))]);
    assert_eq!(file.file_generation_type, Some(1.0001));
    assert!(file.absolute && file.declared_flux_lm.is_none() && file.light_output_ratio.is_none());
    assert_eq!(file.opening, Opening::Disk { diameter_m: 0.1 });
    assert!(file.warnings.is_empty(), "{:?}", file.warnings);
}

#[test]
fn rotational_file_of_1986_has_free_labels() {
    let file = read("rotational_1986.ies");
    assert_candela(&file, &[(0.0, 0.0, 50.0), (123.0, 30.0, 45.0), (359.0, 45.0, 32.5), (1.0, 75.0, 10.0)]);
    assert_eq!(file.format, PhotometricFormat::Ies1986);
    assert_eq!(file.keywords[0].1, "OLD LABORATORY REPORT 17");
}

#[test]
fn type_a_looks_towards_c0_and_turns_clockwise() {
    // Rows are horizontal −45, 0, 45; values vertical −45, 0, 45. γ = 90° + vertical, C = −horizontal.
    let file = read("type_a.ies");
    let expected = [
        (0.0, 90.0, 5.0),
        (0.0, 135.0, 6.0),
        (0.0, 45.0, 4.0),
        (315.0, 90.0, 8.0),
        (45.0, 90.0, 2.0),
        (45.0, 135.0, 3.0),
        (337.5, 112.5, 7.0),
    ];
    assert_candela(&file, &expected);
    assert_candela(&file, &[(0.0, 0.0, 0.0), (180.0, 90.0, 0.0), (50.0, 90.0, 0.0)]);
}

#[test]
fn type_b_turns_about_the_horizontal_axis() {
    // Rows are horizontal 0 and 45 (mirrored), values vertical −45, 0, 45. Vertical angles tilt the axis towards C0, the horizontal 45°
    // towards C270 (clockwise). The corner (45, 45) lies at x = z = 1/2, y = −√½.
    let file = read("type_b_half.ies");
    let corner = (360.0 - 2.0_f64.sqrt().atan().to_degrees(), 60.0, 6.0);
    assert_candela(
        &file,
        &[(0.0, 0.0, 20.0), (0.0, 45.0, 30.0), (180.0, 45.0, 10.0), (270.0, 45.0, 5.0), (90.0, 45.0, 5.0), corner],
    );
    assert_candela(&file, &[(0.0, 46.0, 0.0), (270.0, 50.0, 0.0)]);
    let full = read("type_b_full.ies");
    assert_candela(
        &full,
        &[(0.0, 0.0, 5.0), (270.0, 45.0, 6.5), (90.0, 45.0, 3.5), (0.0, 89.9999, 6.0 - 0.0001 / 90.0)],
    );
}

#[test]
fn tilt_factors_are_stepped_over_and_the_untilted_one_applies() {
    // Thirteen pairs over four lines. The factor at 0° is 0.98, and the file is of 1991 with both factors 1.
    let file = read("tilt_include.ies");
    assert_candela(&file, &[(0.0, 0.0, 98.0), (0.0, 45.0, 49.0)]);
    assert!(file.warnings.iter().any(|warning| warning.contains("tilt")));
    // −10°: 1, 10°: 0.9, therefore 0.95 at 0°.
    assert_candela(&read("tilt_file.ies"), &[(0.0, 0.0, 95.0)]);
}

#[test]
fn eulumdat_symmetries() {
    // Values are cd/klm. With 2000 lm each counts twice.
    assert_candela(
        &read("isym0.ldt"),
        &[(0.0, 45.0, 20.0), (90.0, 45.0, 40.0), (270.0, 45.0, 80.0), (315.0, 45.0, 50.0)],
    );
    // 500 lm and a conversion factor of 2: each counts once.
    assert_candela(&read("isym1.ldt"), &[(0.0, 0.0, 5.0), (77.0, 45.0, 10.0), (200.0, 67.5, 5.0)]);
    assert_candela(
        &read("isym2.ldt"),
        &[(0.0, 45.0, 20.0), (90.0, 45.0, 40.0), (270.0, 45.0, 40.0), (180.0, 45.0, 60.0)],
    );
    // Isym 3 stores C270, C0, C90.
    assert_candela(
        &read("isym3.ldt"),
        &[(270.0, 45.0, 20.0), (0.0, 45.0, 40.0), (180.0, 45.0, 40.0), (90.0, 45.0, 60.0)],
    );
    let file = read("isym4.ldt");
    assert_candela(
        &file,
        &[(0.0, 0.0, 5.5), (0.0, 45.0, 10.25), (45.0, 45.0, 20.0), (135.0, 45.0, 20.0), (270.0, 45.0, 30.0)],
    );
    assert!(file.absolute && file.lumens_per_lamp.is_none());
    assert_eq!(file.opening, Opening::Rectangle { c0_m: 0.29, c90_m: 0.59 });
    assert_eq!(read("isym1.ldt").lumens_per_lamp, Some(250.0));
}

#[test]
fn fluxes_agree_with_dense_quadrature() {
    for name in [
        "quadrant_2002.ies",
        "ninety_1991.ies",
        "full_2019.ies",
        "type_a.ies",
        "type_b_full.ies",
        "isym0.ldt",
        "isym3.ldt",
    ] {
        let web = read(name).web;
        let (exact, dense) = (web.luminous_flux_lm(), flux_by_quadrature_lm(&web, 1440, 1440));
        // The table of type A ends in steps. There, midpoints are off by up to half a cell of 1440.
        let tolerance = if name == "type_a.ies" { 1e-3 } else { 1e-4 };
        assert!((exact / dense - 1.0).abs() < tolerance, "{name}: {exact} lm, quadrature {dense} lm");
    }
}

#[test]
fn sample_luminaires_hold_their_formulas() {
    for formula in make_luminaire_files::formulas() {
        let path = root().join("scenes/luminaires").join(formula.file);
        let stored = std::fs::read_to_string(&path).unwrap();
        assert_eq!(stored, make_luminaire_files::file_text(&formula), "run the example make_luminaire_files");
        let file = read_photometric_file(&path).unwrap();
        assert!(file.warnings.is_empty(), "{}: {:?}", formula.file, file.warnings);

        let flux = file.luminous_flux_lm();
        let dense = flux_by_quadrature_lm(&file.web, 720, 2000);
        assert!((flux / dense - 1.0).abs() < 1e-4, "{}: {flux} lm, quadrature {dense} lm", formula.file);
        // The table's chords lie below the curve by some steps²/12 of its curvature.
        assert!((flux / formula.flux_lm - 1.0).abs() < 5e-4, "{}: {flux} lm of {}", formula.file, formula.flux_lm);
        for (c, gamma) in [(0.0, 0.0), (30.0, 20.0), (150.0, 45.0), (180.0, 75.0), (90.0, 10.0)] {
            let wanted = (formula.intensity_cd)(f64::to_radians(c), f64::to_radians(gamma));
            let found = file.web.intensity_cd(c, gamma);
            assert!(
                (found - wanted).abs() < 2e-3 + 1e-6 * wanted,
                "{} C{c} gamma {gamma}: {found} {wanted}",
                formula.file
            );
        }
    }
}

#[test]
fn decimal_commas_are_taken_only_where_nothing_else_fits() {
    let text = "IESNA91\nTILT=NONE\n1 1000 1 2 1 1 2 0 0 0\n1 1 20\n0 90\n0\n10,5 0\n";
    let file = parse_ies(text.as_bytes(), None).unwrap();
    assert_candela(&file, &[(0.0, 0.0, 10.5)]);
    assert!(file.warnings.iter().any(|warning| warning.contains("decimal commas")));
    let delimited = parse_ies(text.replace("10,5 0", "10,5").as_bytes(), None).unwrap();
    assert_candela(&delimited, &[(0.0, 0.0, 10.0), (0.0, 90.0, 5.0)]);
}

#[test]
fn a_header_that_promises_too_little_flux_is_a_warning() {
    let text = std::fs::read_to_string(root().join("scenes/luminaires/troffer.ies")).unwrap();
    let file = parse_ies(text.replace("4 1000 1 91", "1 60 1 91").as_bytes(), None).unwrap();
    assert!(file.warnings.iter().any(|warning| warning.contains("add up to 3599")), "{:?}", file.warnings);
    assert!((file.luminous_flux_lm() - 3600.0).abs() < 1.0);
    let ldt = std::fs::read_to_string(root().join("scenes/luminaires/downlight.ldt")).unwrap();
    let wrong =
        parse_eulumdat(ldt.replacen("\r\n80\r\n1\r\n0\r\n1\r\n", "\r\n70\r\n1\r\n0\r\n1\r\n", 1).as_bytes()).unwrap();
    assert!(wrong.warnings.iter().any(|warning| warning.contains("states 70 %")), "{:?}", wrong.warnings);
}

#[test]
fn bytes_of_any_machine_read_the_same() {
    let text = std::fs::read_to_string(root().join("tests/data/photometric/quadrant_2002.ies")).unwrap();
    let plain = parse_ies(text.as_bytes(), None).unwrap();
    let marked = [b"\xEF\xBB\xBF".as_slice(), text.as_bytes()].concat();
    let latin =
        [text.replace("luxmc", "M\u{FC}ller").chars().map(|c| c as u32 as u8).collect::<Vec<u8>>(), b"\x1A".to_vec()]
            .concat();
    let wide: Vec<u8> = [0xFEFF].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    for bytes in [marked, text.replace('\n', "\r").into_bytes(), text.replace('\n', "\r\n").into_bytes(), wide] {
        assert_eq!(parse_ies(&bytes, None).unwrap(), plain);
    }
    assert_eq!(parse_ies(&latin, None).unwrap().manufacturer, "Müller\nconformity");
}

/// The message for a text that must be refused.
fn refused(bytes: &[u8], ies: bool) -> String {
    let read = if ies { parse_ies(bytes, None) } else { parse_eulumdat(bytes) };
    read.map(|_| ()).unwrap_err().to_string()
}

#[test]
fn refusals_name_line_token_expectation_and_remedy() {
    let good = std::fs::read_to_string(root().join("tests/data/photometric/quadrant_2002.ies")).unwrap();
    let cases = [
        (
            "3 2 1 2 0.3",
            "1000000000 2 1 2 0.3",
            "line 9: found `1000000000`, expected the number of vertical angles: no more than",
        ),
        ("3 2 1 2 0.3", "3 12 1 2 0.3", "expected 3 vertical and 12 horizontal angles"),
        ("3 2 1 2 0.3", "3 2 7 2 0.3", "found `7`, expected a photometric type"),
        ("3 2 1 2 0.3", "2.5 2 1 2 0.3", "found `2.5`, expected the number of vertical angles: a whole number"),
        ("0 45 90\n", "0 45 45\n", "line 12: found `45`, expected vertical angles from 0 to 180"),
        ("0 90\n100", "0 80\n100", "found `0 to 80`, expected horizontal angles 0, 0 to 90"),
        ("100 80 0", "100 -80 0", "line 14: found `-80`, expected an intensity of 0 or more"),
        ("100 80 0", "100 nan 0", "line 14: found `nan`"),
        ("100 80 0", "100 8O 0", "line 14: found `8O`"),
        ("TILT=NONE", "", "expected a line TILT=…"),
        ("0.9 0.5 20", "0 0.5 20", "found `0`, expected a ballast factor above 0"),
        ("100 40 0", "100 40", "the end of the file"),
        ("1 1000 2", "1 1000 1e308", "expected factors that keep intensities finite"),
    ];
    for (from, to, message) in cases {
        let found = refused(good.replace(from, to).as_bytes(), true);
        assert!(found.contains(message), "{to}: {found}");
        assert!(found.contains("; "), "no remedy in: {found}");
    }
    let good = std::fs::read_to_string(root().join("tests/data/photometric/isym0.ldt")).unwrap();
    let line = |number: usize, text: &str| {
        let mut lines: Vec<&str> = good.lines().collect();
        lines[number - 1] = text;
        lines.join("\n")
    };
    let cases = [
        (line(3, "5"), "line 3: found `5`, expected Isym"),
        (line(4, "1000000000"), "line 4: found `1000000000`, expected Mc"),
        (line(4, "40"), "40 C angles"),
        (line(6, "x"), "line 6: found `x`, expected Ng"),
        (line(24, "0"), "line 24: found `0`, expected the conversion factor"),
        (line(26, "9"), "expected 9 sets of lamps"),
        (line(29, "-5"), "line 29: found `-5`, expected the total luminous flux"),
        (line(55, "-1"), "line 55: found `-1`, expected an intensity"),
        (good.lines().take(20).collect::<Vec<_>>().join("\n"), "the end of the file"),
        (String::new(), "the end of the file"),
    ];
    for (text, message) in cases {
        let found = refused(text.as_bytes(), false);
        assert!(found.contains(message), "{message}: {found}");
    }
    let missing = read_photometric_file(Path::new("no/such/file.ies")).unwrap_err().to_string();
    assert!(missing.starts_with("no/such/file.ies: "), "{missing}");
}

#[test]
fn beam_angles_of_known_distributions() {
    let downlight = read_photometric_file(&root().join("scenes/luminaires/downlight.ldt")).unwrap().web;
    // cos⁴γ = 1/2 and 1/10. The table's chords cause an error of some hundredths of a degree.
    let full = |share: f64| 2.0 * share.powf(0.25).acos().to_degrees();
    assert!((downlight.beam_angle_deg(0.0) - full(0.5)).abs() < 0.02, "{}", downlight.beam_angle_deg(0.0));
    assert!((downlight.field_angle_deg(33.0) - full(0.1)).abs() < 0.02, "{}", downlight.field_angle_deg(33.0));
    let half = read("isym0.ldt").web;
    // C90: 10 at the axis, 40 at 45°, 0 at 90°; C270: 80 at 45°. Half of 80 lies 19.29° inside and 22.5° outside.
    assert!((half.beam_angle_deg(90.0) - (45.0 * 40.0 / 70.0 + 22.5)).abs() < 1e-9, "{}", half.beam_angle_deg(90.0));
    assert_eq!(half.maximum_intensity_cd(), 80.0);
    let ball = IntensityWeb::new(vec![0.0, 360.0], vec![0.0, 180.0], vec![1.0; 4]).unwrap();
    assert_eq!(ball.beam_angle_deg(0.0), 360.0);
    assert!((ball.luminous_flux_lm() - 4.0 * std::f64::consts::PI).abs() < 1e-14);
    let [below, above] = ball.hemisphere_fluxes_lm().unwrap();
    assert!((below - above).abs() < 1e-14);
}

#[test]
fn tables_that_are_no_distribution_are_refused() {
    let table = |c: &[f64], gamma: &[f64], cd: &[f64]| IntensityWeb::new(c.to_vec(), gamma.to_vec(), cd.to_vec());
    assert!(table(&[0.0, 360.0], &[0.0, 90.0], &[1.0; 4]).is_ok());
    assert!(table(&[0.0, 350.0], &[0.0, 90.0], &[1.0; 4]).is_err());
    assert!(table(&[0.0, 360.0], &[0.0, f64::NAN], &[1.0; 4]).is_err());
    assert!(table(&[0.0, 360.0], &[90.0, 0.0], &[1.0; 4]).is_err());
    assert!(table(&[0.0, 360.0], &[0.0, 90.0], &[1.0; 3]).is_err());
    assert!(table(&[0.0, 360.0], &[0.0, 90.0], &[1.0, -1.0, 1.0, 1.0]).is_err());
    assert!(table(&[], &[], &[]).is_err());
}

/// Every conformity file, as bytes.
fn conformity_files() -> Vec<Vec<u8>> {
    let folder = root().join("tests/data/photometric");
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths.iter().map(|path| std::fs::read(path).unwrap()).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    /// A file with bytes cut, inserted or changed gives an error or a usable distribution, never a panic.
    #[test]
    fn mutations_never_panic(
        which in 0..17_usize,
        edits in prop::collection::vec((any::<prop::sample::Index>(), 0..4_u8, any::<prop::sample::Index>(), "[-0-9., \r\ne+\u{FC}]{0,6}"), 1..5),
    ) {
        let files = conformity_files();
        let mut bytes = files[which % files.len()].clone();
        for (at, kind, length, text) in &edits {
            if bytes.is_empty() {
                break;
            }
            let start = at.index(bytes.len());
            let end = start + length.index(bytes.len() - start);
            match kind {
                0 => drop(bytes.drain(start..end)),
                1 => drop(bytes.splice(start..start, text.bytes())),
                2 => drop(bytes.splice(start..start + 1, text.bytes())),
                _ => bytes.truncate(start.max(bytes.len() / 2)),
            }
        }
        for read in [parse_ies(&bytes, None), parse_eulumdat(&bytes)].into_iter().flatten() {
            prop_assert!(read.web.luminous_flux_lm() >= 0.0);
            prop_assert!(read.web.intensity_cd(12.0, 34.0) >= 0.0);
            prop_assert!(read.web.beam_angle_deg(12.0) <= 360.0);
        }
    }
}

#[test]
fn pictures_and_documents_are_reported_for_what_they_are() {
    let folder = tempfile::tempdir().expect("a folder");
    for (start, kind) in [(&b"\x89PNG\r\n\x1a\n"[..], "a PNG picture"), (b"%PDF-1.7", "a PDF document")] {
        let path = folder.path().join("luminaire.ies");
        std::fs::write(&path, start).expect("written");
        let error = read_photometric_file(&path).expect_err("no photometric file").to_string();
        assert!(error.contains(kind) && error.contains("IES or LDT file"), "{error}");
    }
}
