//! Exact numbers of a comparison, and their accuracy for its scene.

use std::path::Path;

use super::comparison::Comparison;
use super::error::CaseError;
use super::exact::{Exact, LightPart, TruthSite};
use super::reference::ReferenceTable;
use super::stored_run::StoredRun;
use super::truth_enclosure::{concentric, two_hemispheres, uniform_enclosure};
use super::truth_room::{RoomCache, room_truth};
use super::truth_sobolev::{sobolev_luminance, sobolev_truth};
use super::truth_spec::TruthSpec;
use crate::scene::{Quantity, ReceiverSet, Scene};

/// A truth prepared for one scene.
pub struct Truth<'a> {
    comparison: &'a Comparison,
    scene: &'a Scene,
    rooms: &'a RoomCache,
    reference: Option<ReferenceTable>,
    run: Option<StoredRun>,
}

impl<'a> Truth<'a> {
    /// Prepares a truth; reads its reference file or stored run if it has one.
    ///
    /// # Errors
    ///
    /// A reference or stored run that cannot be read or does not fit the scene.
    pub fn prepare(
        comparison: &'a Comparison,
        scene: &'a Scene,
        rooms: &'a RoomCache,
        folder: &Path,
    ) -> Result<Truth<'a>, CaseError> {
        let reference = match &comparison.truth {
            TruthSpec::Reference { file, set, .. } => Some(ReferenceTable::read(&folder.join(file), set.as_deref())?),
            _ => None,
        };
        let run = match &comparison.truth {
            TruthSpec::Run { folder: run } => Some(StoredRun::read(&folder.join(run), &comparison.map, scene)?),
            _ => None,
        };
        Ok(Truth { comparison, scene, rooms, reference, run })
    }

    /// Refuses a run that shares its random numbers with the truth.
    ///
    /// # Errors
    ///
    /// A stored run whose seed is among the run's seeds.
    pub fn check_seed(&self, seed: u64) -> Result<(), CaseError> {
        self.run.as_ref().map_or(Ok(()), |run| run.check_seed(seed))
    }

    /// Standard error in lx of the mean over the compared values, if the exact values are themselves random.
    pub fn average_error_lx(&self) -> Option<f64> {
        let geometry_of = |surface: &str| self.scene.surfaces.iter().find(|known| known.name == surface);
        let is_in = |surface: &str| {
            geometry_of(surface).is_some_and(|known| self.comparison.takes_in(surface, &known.geometry))
        };
        self.run.as_ref().map(|run| run.average_error_lx(is_in))
    }

    /// The exact value at a site.
    ///
    /// # Errors
    ///
    /// Describes in words what the truth cannot give.
    pub fn exact(&self, site: &TruthSite, light: LightPart) -> Result<Exact, String> {
        let mut exact = self.of_spec(site, light)?;
        if !(exact.value.is_finite() && exact.value >= 0.0) {
            return Err(format!("the exact value is {} lx", exact.value));
        }
        // Means over the mesh's own area account for everything. Single elements still have facets instead of a smooth shape.
        if matches!(site, TruthSite::Element { .. })
            && !matches!(self.comparison.truth, TruthSpec::BoxRoom(_) | TruthSpec::Run { .. })
        {
            exact.unaccounted = exact.discretisation;
        }
        Ok(exact)
    }

    /// Returns whether luminances are compared, in cd/m² instead of lx.
    fn is_luminance(&self) -> bool {
        let of_set = |set: &ReceiverSet| set.name == self.comparison.map && set.quantity == Quantity::Luminance;
        self.scene.receivers.iter().any(of_set)
    }

    fn of_spec(&self, site: &TruthSite, light: LightPart) -> Result<Exact, String> {
        match &self.comparison.truth {
            TruthSpec::Sobolev(truth) if self.is_luminance() => sobolev_luminance(truth, site, light),
            TruthSpec::Sobolev(truth) => sobolev_truth(truth, site, light),
            TruthSpec::UniformEnclosure { luminous_flux_lm, reflectance, ideal_area_m2 } => {
                uniform_enclosure(self.scene, *luminous_flux_lm, *reflectance, *ideal_area_m2, light)
            }
            TruthSpec::TwoHemispheres {
                luminous_flux_lm,
                radius_m,
                source_height_m,
                upper_reflectance,
                lower_reflectance,
            } => two_hemispheres(
                self.scene,
                *luminous_flux_lm,
                *radius_m,
                *source_height_m,
                [*upper_reflectance, *lower_reflectance],
                light,
            ),
            TruthSpec::ConcentricSpheres {
                luminous_flux_lm,
                inner_radius_m,
                outer_radius_m,
                inner_reflectance,
                outer_reflectance,
            } => concentric(
                self.scene,
                *luminous_flux_lm,
                [*inner_radius_m, *outer_radius_m],
                [*inner_reflectance, *outer_reflectance],
                site,
                light,
            ),
            TruthSpec::Isothermal { luminance_cd_m2 } => match light {
                LightPart::Total if self.is_luminance() => Ok(Exact { value: *luminance_cd_m2, ..Exact::default() }),
                LightPart::Total => Ok(Exact { value: std::f64::consts::PI * luminance_cd_m2, ..Exact::default() }),
                _ => Err("the isothermal rule gives only the total".to_owned()),
            },
            TruthSpec::BoxRoom(truth) => room_truth(truth, self.rooms, site, light),
            TruthSpec::Reference { column, uncertainty, .. } => {
                let Some(reference) = &self.reference else {
                    return Err("the reference was not read".to_owned());
                };
                let value_lx = reference.number(column, site)?.ok_or("a cell of the reference is empty")?;
                Ok(Exact { value: value_lx, uncertainty: uncertainty * value_lx.abs(), ..Exact::default() })
            }
            TruthSpec::Run { .. } => self.run.as_ref().ok_or("the stored run was not read")?.exact(site, light),
        }
    }

    /// A published number for comparison with the exact one, if the reference has it.
    ///
    /// # Errors
    ///
    /// A column that is missing or contains no number.
    pub fn beside(&self, column: &str, site: &TruthSite) -> Result<Option<f64>, String> {
        match &self.reference {
            Some(reference) => reference.number(column, site),
            None => Err("published numbers come from a reference file, but this truth is a formula".to_owned()),
        }
    }

    /// Source of the exact numbers, in words for a reader.
    pub fn in_words(&self) -> String {
        match &self.comparison.truth {
            TruthSpec::Sobolev(truth) => truth.in_words(),
            TruthSpec::UniformEnclosure { .. } => {
                "flux balance of a closed enclosure of one reflectance: E = Φ/(S(1−ρ)), S the mesh's own area".into()
            }
            TruthSpec::TwoHemispheres { .. } => {
                "closed form: light is exchanged equally between all parts of a sphere, so the indirect part is the same everywhere".into()
            }
            TruthSpec::ConcentricSpheres { .. } => "closed form of two concentric diffuse spheres".into(),
            TruthSpec::Isothermal { .. } => "Kirchhoff's law: in an isothermal enclosure E = πL₀ everywhere".into(),
            TruthSpec::BoxRoom(_) => {
                "radiosity of a rectangular room with exact form factors between its patches, extrapolated over three meshes".into()
            }
            TruthSpec::Reference { file, .. } => format!("{file}, written by the program beside it"),
            TruthSpec::Run { .. } => self.run.as_ref().map_or_else(String::new, StoredRun::in_words),
        }
    }
}
