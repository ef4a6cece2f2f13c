//! The scene file as a whole: text → syntax tree → one valid [`Scene`].

use std::path::{Path, PathBuf};

use super::error::SceneError;
use super::keys::{ANY_LENGTH, Form, NOT_EMPTY, TEXT, ValueShape, form, needed, optional};
use super::model::Scene;
use super::project::Project;
use super::reader::{Node, Source};
use super::reported::unreported;
use super::surfaces::Surfaces;
use super::units::{LengthUnit, UNIT_NAMES};
use super::{daylight, emission, energy, luminaires, materials, parse, project, receivers, surfaces, under_way};

/// The version of the file format that this program reads.
const VERSION: u32 = 1;

/// Keys of the file.
#[rustfmt::skip]
pub(super) const FORM: Form = form("luxmc scene",
    "A lighting scene for luxmc. Lengths are in `length_unit`; photometric quantities in lm, cd and lm/m². File names are relative to the scene file.", &[&[
    needed("version", ValueShape::Only(VERSION), "1", "Version of the file format."),
    optional("title", TEXT, "Title of the scene in results."),
    optional("project", ValueShape::Object(&project::FORM), "Client, author and date, for the report's first page."),
    optional("energy", ValueShape::Object(&energy::FORM), "Data for the yearly lighting energy (LENI) by the quick method of EN 15193."),
    optional("length_unit", ValueShape::Choice(&UNIT_NAMES), "Unit of all lengths, also of those in OBJ and points files."),
    needed("materials", ValueShape::Map(&ValueShape::Kinds(&materials::KINDS)), "{ \"plaster\": { \"type\": \"diffuse\", \"reflectance\": 0.7 } }",
        "Materials by name."),
    needed("geometry", ValueShape::List(&ValueShape::Kinds(&surfaces::KINDS), NOT_EMPTY), "[ … ]: the scene has no geometry", "Surfaces; their names are unique."),
    needed("luminaires", ValueShape::List(&ValueShape::Kinds(&emission::KINDS), NOT_EMPTY), "[ … ]: the scene has no luminaire",
        "Light sources; their names are unique."),
    optional("receivers", ValueShape::List(&ValueShape::Kinds(&receivers::KINDS), ANY_LENGTH), "Points for which results are computed; their names are unique."),
]]);

/// Reads a scene file and the mesh, points and photometric files that it names. `complete` checks the whole scene, refuses what cannot be
/// computed, and adds derived data.
///
/// # Errors
///
/// Anything that the file format refuses. The error gives the position, what was expected and a remedy.
pub(crate) fn read_with(
    path: &Path,
    complete: impl FnOnce(&mut Scene, &WrittenGeometry) -> Result<(), SceneError>,
) -> Result<Scene, SceneError> {
    let text = parse::read_text(path, "the scene file")?;
    let base_dir = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
    from_json_with(&text, Some(path), &base_dir, complete)
}

/// Information of the file on the scene's geometry as a whole.
pub(crate) struct WrittenGeometry<'a> {
    /// The list of geometries, for the positions of refusals.
    pub geometry: Node<'a>,
    /// The unit of all lengths in the file.
    pub unit: LengthUnit,
}

/// As `read_with`, from the text of a scene file. File names in it are relative to `base_dir`.
///
/// # Errors
///
/// As [`read_with`].
pub(crate) fn from_json_with(
    text: &str,
    path: Option<&Path>,
    base_dir: &Path,
    complete: impl FnOnce(&mut Scene, &WrittenGeometry) -> Result<(), SceneError>,
) -> Result<Scene, SceneError> {
    // Editors on Windows often begin a text with a byte-order mark.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    under_way::begin("the scene file", 0);
    let source = Source { text, path: path.unwrap_or(Path::new("scene")) };
    let value = parse::parse(&source)?;
    let root = Node::root(&source, &value);
    let fields = root.fields("a scene file")?;

    // The version comes first: other errors are irrelevant in a file of another version.
    let version = fields.need_as("version", "1")?;
    if version.number()? != f64::from(VERSION) {
        let what = "a scene file of another version";
        return Err(version.refuse(
            what,
            "version 1",
            "write 1, or use the version of luxmc that the file was made for",
        ));
    }
    let fields = fields.of(&FORM)?;
    let title = fields.get("title").map_or(Ok(""), |node| node.text())?.to_string();
    let project = fields.get("project").map_or(Ok(Project::default()), |node| project::read(&node))?;
    let energy = fields.get("energy").map(|node| energy::read(&node)).transpose()?;
    let unit = LengthUnit::of(fields.get("length_unit").map_or(Ok(0), |node| node.choice())?);

    let mut warnings = Vec::new();
    let materials = materials::read(&fields.need("materials")?)?;
    let geometry_node = fields.need("geometry")?;
    let around = surfaces::GeometryContext::of(unit, base_dir, &materials);
    let surfaces = Surfaces::read(&geometry_node, &around, &mut warnings)?;
    let luminaires_node = fields.need("luminaires")?;
    let around = luminaires::LuminaireContext { unit, base_dir, surfaces: &surfaces };
    let luminaires = luminaires::read(&luminaires_node, &around, &mut warnings)?;
    under_way::begin("receivers", 0);
    let receivers = match fields.get("receivers") {
        Some(node) => receivers::read(&node, &receivers::ReceiverContext { unit, base_dir, surfaces: &surfaces })?,
        None => Vec::new(),
    };

    daylight::refuse_glare(&root, &luminaires, &receivers)?;
    let mut scene = Scene {
        title,
        project,
        energy,
        unreported: unreported(&surfaces.surfaces, &surfaces.reporting, &luminaires),
        path: path.map(Path::to_path_buf),
        materials,
        vertices_m: surfaces.vertices_m,
        triangles: surfaces.triangles,
        divisions: surfaces.divisions,
        triangle_surfaces: surfaces.triangle_surfaces,
        surfaces: surfaces.surfaces,
        bodies: surfaces.bodies,
        luminaires,
        receivers,
        warnings,
    };
    complete(&mut scene, &WrittenGeometry { geometry: geometry_node, unit })?;
    Ok(scene)
}
