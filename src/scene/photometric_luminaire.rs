//! Content of a photometric file for the luminaires that name it.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::error::SceneError;
use super::photometry::{IntensityWeb, Opening, read_photometric_file};
use super::reader::Node;

/// Product data of a photometric file. Missing entries are empty.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Product {
    /// Name of the file.
    pub file: String,
    /// Manufacturer.
    pub manufacturer: String,
    /// Name of the luminaire.
    pub luminaire: String,
    /// Catalogue number.
    pub catalog_number: String,
}

impl Product {
    /// Joins manufacturer, luminaire and catalogue number, as far as given. A repeated name appears once.
    pub fn words(&self) -> String {
        let number = match self.catalog_number.trim() {
            "" => String::new(),
            number => format!("no. {number}"),
        };
        let mut parts: Vec<&str> = Vec::new();
        for part in [self.manufacturer.trim(), self.luminaire.trim(), number.as_str()] {
            if !part.is_empty() && !parts.contains(&part) {
                parts.push(part);
            }
        }
        parts.join(", ")
    }
}

/// Content of a photometric file, for every luminaire that names it.
pub(super) struct FileDistribution {
    pub product: Arc<Product>,
    pub web: Arc<IntensityWeb>,
    pub luminous_flux_lm: f64,
    pub opening: Opening,
    pub power_w: Option<f64>,
    pub warnings: Vec<String>,
}

/// The files read so far. Luminaires that name the same file share its content.
#[derive(Default)]
pub(super) struct PhotometricFiles(HashMap<PathBuf, FileDistribution>);

impl PhotometricFiles {
    /// Returns the content of the file that a node names.
    pub fn named(&mut self, node: &Node, base_dir: &Path) -> Result<&FileDistribution, SceneError> {
        Ok(match self.0.entry(base_dir.join(node.name()?)) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(unknown) => {
                let file = read_distribution(unknown.key()).map_err(|error| error.named_by(node.as_namer()))?;
                unknown.insert(file)
            }
        })
    }
}

fn read_distribution(path: &Path) -> Result<FileDistribution, SceneError> {
    let file = read_photometric_file(path).map_err(|error| {
        let expected = "a photometric file: IES LM-63 (.ies) or EULUMDAT (.ldt)";
        let what = "the photometric file cannot be read".to_string();
        let remedy = "check the file name, or get the file again from the manufacturer";
        SceneError::of_file(path, what, error.to_string(), expected, remedy)
    })?;
    let warnings = file.warnings.iter().map(|warning| format!("{}: {warning}", path.display())).collect();
    let luminous_flux_lm = file.web.luminous_flux_lm();
    let product = Product {
        file: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        manufacturer: file.manufacturer,
        luminaire: file.luminaire,
        catalog_number: file.catalog_number,
    };
    Ok(FileDistribution {
        product: Arc::new(product),
        luminous_flux_lm,
        opening: file.opening,
        power_w: file.power_w,
        warnings,
        web: Arc::new(file.web),
    })
}
