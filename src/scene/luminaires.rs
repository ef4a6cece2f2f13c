//! Reads `luminaires` and converts everything to maintained lumens and candelas.

use std::ops::RangeInclusive;

use super::arrays;
use super::bodies::body_of;
use super::daylight;
use super::emission::{KINDS, Shining};
use super::error::SceneError;
use super::keys::Form;
use super::limits::MOST_LUMINAIRES;
pub(super) use super::luminaire_reading::LuminaireContext;
use super::luminaire_reading::{LuminaireReading, NamedSurfaces};
use super::model::Luminaire;
use super::photometric_luminaire::PhotometricFiles;
use super::reader::Node;
use super::surfaces::Surfaces;
use super::under_way;
use super::unique_names::{Names, unique_name};

/// Range of the luminous fluxes in lm that are computed: from far less than one photon per hour (7e-20 lm at 555 nm) to more than the
/// sun's. Checks sum the fourth powers of the resulting illuminances. These stay well within 64-bit floats.
const FLUXES_LM: RangeInclusive<f64> = 1e-24..=1e30;

impl NamedSurfaces for Surfaces {
    fn named(&self, node: &Node) -> Result<Vec<u32>, SceneError> {
        self.named(node)
    }

    fn area_m2(&self, surface: u32) -> f64 {
        self.area_m2(surface)
    }

    fn is_body(&self, surface: u32) -> bool {
        body_of(&self.bodies, self.surfaces[surface as usize].triangles.start).is_some()
    }
}

/// Data gathered from the luminaires read so far.
#[derive(Default)]
struct LuminairesSoFar {
    /// Their names.
    names: Names,
    /// Photometric files.
    files: PhotometricFiles,
}

/// Reads all luminaires.
pub(super) fn read(
    node: &Node,
    around: &LuminaireContext,
    warnings: &mut Vec<String>,
) -> Result<Vec<Luminaire>, SceneError> {
    let items = node.items("luminaires")?;
    if items.is_empty() {
        let remedy = "add at least one, such as { \"name\": \"lamp\", \"type\": \"point\", \"position\": [4, 3, 2.5], \"intensity_cd\": 800 }";
        return Err(node.refuse("the scene has no luminaire", "at least one luminaire", remedy));
    }
    let mut known = LuminairesSoFar::default();
    let mut maintained = false;
    let mut luminaires = Vec::with_capacity(items.len());
    under_way::begin("luminaires", items.len());
    for (number, item) in items.into_iter().enumerate() {
        under_way::reached(number);
        let fields = item.fields("a luminaire")?;
        maintained |= fields.get("maintenance_factor").is_some();
        let kind = fields.kind(&KINDS)?;
        let form = &KINDS.forms[kind];
        let luminaire = read_one(&item, kind, form, around, &mut known, warnings)?;
        let fields = fields.of(form)?;
        match arrays::read(&fields, around.unit)? {
            Some(array) if luminaires.len() as u64 + array.len() > MOST_LUMINAIRES => {
                let expected = format!("at most {} luminaires in a scene with arrays", MOST_LUMINAIRES);
                return Err(item.refuse("the arrays have too many luminaires", expected, "ask for fewer"));
            }
            Some(array) => array.fill(&fields, &luminaire, &mut known.names, &mut luminaires)?,
            None => luminaires.push(luminaire),
        }
    }
    daylight::only_one_each(node, &luminaires)?;
    if luminaires.iter().all(|luminaire| luminaire.luminous_flux_lm == 0.0) {
        warnings.push(
            "no luminaire gives light, so that everything is dark: all have a flux, a dimming or a factor of 0"
                .to_owned(),
        );
    }
    if !maintained && !luminaires.iter().all(|luminaire| luminaire.emission.is_daylight()) {
        warnings.push("no luminaire has a maintenance_factor: results are those of a new installation".into());
    }
    Ok(luminaires)
}

fn read_one(
    node: &Node,
    kind: usize,
    form: &Form,
    around: &LuminaireContext,
    known: &mut LuminairesSoFar,
    warnings: &mut Vec<String>,
) -> Result<Luminaire, SceneError> {
    let article = if form.name.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
    let fields = node.object(&format!("{article} {} luminaire", form.name), form)?;
    let name = unique_name(&fields, &mut known.names)?;
    let dimming = fields.get("dimming").map_or(Ok(1.0), |node| node.amount("dimming"))?;
    let maintenance_factor =
        fields.get("maintenance_factor").map_or(Ok(1.0), |node| node.amount("the maintenance factor"))?;
    let maintained = dimming * maintenance_factor;

    let power_w = fields.get("power_w").map(|node| node.amount("the electric power")).transpose()?;
    let mut reading =
        LuminaireReading { fields: &fields, name: &name, around, maintained, files: &mut known.files, warnings };
    let Shining { luminous_flux_lm, emission, product, power_w: file_power_w } = reading.read(kind)?;
    let power_w = power_w.or(file_power_w);
    if luminous_flux_lm != 0.0 && !FLUXES_LM.contains(&luminous_flux_lm) {
        let given =
            ["luminous_flux_lm", "intensity_cd", "exitance_lm_m2", "file"].into_iter().find_map(|key| fields.get(key));
        return Err(given.unwrap_or_else(|| node.clone()).refuse_as(
            format!("the luminous flux of {name:?} is far out of range"),
            format!("{luminous_flux_lm:e} lm in total, including dimming and maintenance"),
            format!("0, or {:e} to {:e} lm", FLUXES_LM.start(), FLUXES_LM.end()),
            "check its numbers",
        ));
    }
    if luminous_flux_lm == 0.0 {
        warnings.push(format!("{name}: this luminaire gives no light"));
    }
    Ok(Luminaire { name, luminous_flux_lm, dimming, maintenance_factor, power_w, product, emission })
}
