//! The UGR table of a luminaire, computed by the formulas of CIE 190:2010.

use glam::DVec3;

use super::error::{AnalyticError, require};
use crate::base::standard_rooms::{
    RatedRoom, RoomGlare, STANDARD_ROOMS, SpacingCorrection, StandardRoom, UgrTable, Viewing, ZONES,
};
use crate::sampling::opening::Aperture;
use crate::scene::photometry::{LateralSymmetry, Opening, PhotometricFile, PhotometricFormat};

/// Minimum spacing over H: 240,000 luminaires in the largest room.
const LEAST_SPACING_H: f64 = 0.02;
/// Spacings over H for which corrections are given, besides the table's own.
const OTHER_SPACINGS_H: [f64; 3] = [0.5, 1.0, 2.0];
/// Luminous openings whose largest face is below this are small sources (CIE 147), which the tables do not cover, in m².
const SMALL_M2: f64 = 0.005;

/// Ratings of a luminaire in the standard rooms, with the flux and dimensions from its file.
///
/// The luminance of a luminaire is its intensity over the projected area of its opening. In crosswise view the line of sight is
/// perpendicular to the luminaire's length: along C0–C180 in EULUMDAT files, along C90–C270 in IES files.
///
/// Accuracy: that of the standard's formulas. Intensities are interpolated linearly between the file's angles, the position index
/// between the entries of its table.
///
/// # Errors
///
/// A luminaire without an opening, of a goniometer other than type C, or without light; a reflectance of 1; a spacing that does not
/// divide H.
pub fn ugr_table(file: &PhotometricFile, reflectances: &[[f64; 3]], spacing_h: f64) -> Result<UgrTable, AnalyticError> {
    let seen = TableLuminaire::of(file)?;
    for set in reflectances {
        for (what, reflectance) in ["ceiling", "walls", "reference plane"].into_iter().zip(set) {
            let remedy = "give ceiling, walls and reference plane in percent, such as 70/50/20";
            let what = format!("the reflectance of the {what}");
            require((0.0..1.0).contains(reflectance), &what, *reflectance, "0 to below 1", remedy)?;
        }
    }
    if spacing_h < LEAST_SPACING_H {
        return Err(unfit(spacing_h));
    }
    let rooms = STANDARD_ROOMS.iter().map(|room| {
        let glare = Viewing::BOTH.map(|viewing| seen.glare(room, spacing_h, viewing));
        let [Some(crosswise), Some(endwise)] = glare else {
            return Err(unfit(spacing_h));
        };
        let background = |set: &[f64; 3]| room.background_cd_m2(crosswise.luminaires, &seen.zone_fluxes_lm, *set);
        Ok(RatedRoom {
            size_h: room.size_h,
            backgrounds_cd_m2: reflectances.iter().map(background).collect(),
            glare: [crosswise, endwise],
        })
    });
    Ok(UgrTable { spacing_h, reflectances: reflectances.to_vec(), rooms: rooms.collect::<Result<_, _>>()? })
}

/// Changes of a table's ratings at other spacings. They are the same for all reflectances, because the background is the same.
///
/// # Errors
///
/// As [`ugr_table`].
pub fn spacing_corrections(file: &PhotometricFile, table: &UgrTable) -> Result<Vec<SpacingCorrection>, AnalyticError> {
    let seen = TableLuminaire::of(file)?;
    let corrections = OTHER_SPACINGS_H.iter().filter(|spacing_h| **spacing_h != table.spacing_h).map(|&spacing_h| {
        let rooms = STANDARD_ROOMS.iter().zip(&table.rooms).filter(|(room, _)| room.fits(spacing_h));
        let rooms = rooms.map(|(room, rated)| {
            let change = Viewing::BOTH.map(|viewing| {
                let own = rated.glare[viewing as usize];
                let other = seen.glare(room, spacing_h, viewing)?;
                let [from, to] = [own, other].map(|glare| glare.sum / f64::from(glare.luminaires));
                (from > 0.0 && to > 0.0).then(|| 8.0 * (to / from).log10())
            });
            (room.size_h, change)
        });
        SpacingCorrection { spacing_h, rooms: rooms.collect() }
    });
    Ok(corrections.collect())
}

/// Warnings to the reader of a table about its luminaire.
pub fn table_warnings(file: &PhotometricFile) -> Vec<String> {
    let mut warnings = Vec::new();
    if !matches!(file.symmetry, LateralSymmetry::Rotational | LateralSymmetry::Quadrant) {
        warnings.push(
            "the luminaire is not symmetric about both its planes: tables of CIE 190 are not made for it; \
             here its C0 (crosswise) or C90 (endwise) side faces the observer"
                .to_owned(),
        );
    }
    let face_m2 = Aperture::new(&file.opening, DVec3::ZERO, &[DVec3::X, DVec3::Y, DVec3::Z]).map_or(0.0, |aperture| {
        [DVec3::X, DVec3::Y, DVec3::Z].map(|along| aperture.projected_area_m2(along)).into_iter().fold(0.0, f64::max)
    });
    if face_m2 < SMALL_M2 {
        warnings.push(format!(
            "the luminous opening has {face_m2:.5} m², below the {SMALL_M2} m² from which on UGR is defined (CIE 117): \
             tables overrate small sources"
        ));
    }
    warnings
}

fn unfit(spacing_h: f64) -> AnalyticError {
    AnalyticError {
        what: "the spacing over H".to_owned(),
        got: spacing_h.to_string(),
        expected: format!("H, or a whole part of it down to {LEAST_SPACING_H}: 1, 0.5, 0.25, 0.2, …"),
        remedy: "the rows of luminaires must fill rooms of 2H to 12H; 0.25 is what tables are made for".to_owned(),
    }
}

/// A luminaire in the form that tables use.
struct TableLuminaire<'a> {
    file: &'a PhotometricFile,
    aperture: Aperture,
    zone_fluxes_lm: [f64; ZONES],
}

impl TableLuminaire<'_> {
    fn of(file: &PhotometricFile) -> Result<TableLuminaire<'_>, AnalyticError> {
        let refuse = |what: &str, got: &str, expected: &str, remedy: &str| AnalyticError {
            what: what.to_owned(),
            got: got.to_owned(),
            expected: expected.to_owned(),
            remedy: remedy.to_owned(),
        };
        let aperture = (file.opening != Opening::Point)
            .then(|| Aperture::new(&file.opening, DVec3::ZERO, &[DVec3::X, DVec3::Y, DVec3::Z]))
            .flatten();
        let aperture = aperture.ok_or_else(|| {
            let remedy = "a point is endlessly bright; enter the dimensions of the luminous opening in the file";
            refuse("the luminous opening", "a point", "an opening with an extent", remedy)
        })?;
        let within_lm = |edge: usize| file.web.flux_within_lm(180.0 * edge as f64 / ZONES as f64);
        let mut zone_fluxes_lm = [0.0; ZONES];
        for (zone, flux_lm) in zone_fluxes_lm.iter_mut().enumerate() {
            let (Some(from_lm), Some(to_lm)) = (within_lm(zone), within_lm(zone + 1)) else {
                let remedy = "tables are made for indoor luminaires; convert the file to C planes";
                return Err(refuse("the goniometer of the file", "type A or B", "type C", remedy));
            };
            *flux_lm = to_lm - from_lm;
        }
        if zone_fluxes_lm.iter().sum::<f64>() <= 0.0 {
            let remedy = "check the file's intensities and multipliers";
            return Err(refuse("the luminous flux in lm", "0", "some light", remedy));
        }
        Ok(TableLuminaire { file, aperture, zone_fluxes_lm })
    }

    fn glare(&self, room: &StandardRoom, spacing_h: f64, viewing: Viewing) -> Option<RoomGlare> {
        // EULUMDAT's C0 is across the luminaire's length, C0 of IES files along it.
        let facing = match (self.file.format == PhotometricFormat::Eulumdat, viewing) {
            (true, viewing) => viewing,
            (false, Viewing::Crosswise) => Viewing::Endwise,
            (false, Viewing::Endwise) => Viewing::Crosswise,
        };
        room.glare(spacing_h, facing, |towards_eye| {
            let intensity_cd = self.file.web.intensity_along_cd(towards_eye);
            let area_m2 = self.aperture.projected_area_m2(towards_eye);
            // An opening seen edge on has no area. An intensity there is a rounding error of the file.
            if intensity_cd > 0.0 && area_m2 > 0.0 { intensity_cd * intensity_cd / area_m2 } else { 0.0 }
        })
    }
}
