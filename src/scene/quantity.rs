//! Quantities of receivers, their names, and how files give them.

use glam::DVec3;

use super::error::SceneError;
use super::reader::Fields;

/// The quantity that a receiver computes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Quantity {
    /// Illuminance on the plane of the point's own normal.
    #[default]
    Perpendicular,
    /// Illuminance on the curved surface of a small upright cylinder: E_z = 1/π ∫ L sin ε dω, ε from the vertical.
    Cylindrical,
    /// Illuminance on the curved face of half an upright cylinder: E_sc = 1/π ∫ L (1 + cos α) sin ε dω, α from `direction`.
    SemiCylindrical {
        /// Horizontal unit vector to which the curved face points.
        direction: DVec3,
    },
    /// Luminance in cd/m² that an eye at the point sees in the direction of its normal.
    Luminance,
    /// Unified glare rating of the set's observers. The map holds indirect illuminances in lx, π times the background luminance. It has
    /// one point per observer. If the background is that of walls, the points lie on the walls and their mean holds for all observers.
    Glare(Background),
    /// Far-field luminous intensity in cd, in the direction of the point's normal, of all light that leaves the scene. Its points have no
    /// position.
    Intensity {
        /// Axis about which one plane stands for all planes: the result is the mean over all planes.
        turned_about: Option<DVec3>,
    },
}

/// Where the indirect illuminance is taken from which the background luminance follows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Background {
    /// At the eye, on the plane perpendicular to the line of sight (CIE 117).
    #[default]
    Observer,
    /// On the walls between eye and luminaires, as a mean (CIE 190).
    Tabular,
}

impl Background {
    /// Name as in the scene file.
    pub fn name(self) -> &'static str {
        match self {
            Background::Observer => "observer",
            Background::Tabular => "tabular",
        }
    }
}

impl Quantity {
    /// Whether it is an illuminance at the points themselves.
    pub fn is_illuminance(self) -> bool {
        !matches!(self, Quantity::Luminance | Quantity::Glare(_) | Quantity::Intensity { .. })
    }

    /// Whether a point receives light only from the hemisphere above it. For cylinders the plane turns.
    pub fn has_one_hemisphere(self) -> bool {
        self == Quantity::Perpendicular
    }

    /// Name as in the scene file.
    pub fn name(self) -> &'static str {
        match self {
            Quantity::Perpendicular => "perpendicular",
            Quantity::Cylindrical => "cylindrical",
            Quantity::SemiCylindrical { .. } => "semi-cylindrical",
            Quantity::Luminance => "luminance",
            Quantity::Glare(_) => "ugr",
            Quantity::Intensity { .. } => "intensity",
        }
    }

    /// Unit of its values in maps and tables.
    pub fn unit(self) -> &'static str {
        match self {
            Quantity::Luminance => "cd/m²",
            Quantity::Intensity { .. } => "cd",
            _ => "lx",
        }
    }
}

/// Quantities of points and grids; names as in files.
pub(super) const QUANTITIES: [&str; 5] = ["perpendicular", "horizontal", "vertical", "cylindrical", "semi-cylindrical"];

/// Reads the quantity of points and grids, and the normal that replaces those of all points: for horizontal and vertical illuminance.
pub(super) fn read(fields: &Fields) -> Result<(Quantity, Option<DVec3>), SceneError> {
    let chosen = fields.get("quantity").map_or(Ok(0), |node| node.choice())?;
    let name = QUANTITIES[chosen];
    if let (Some(node), "perpendicular" | "horizontal" | "cylindrical") = (fields.get("direction"), name) {
        return Err(node.refuse_as(
            format!("a direction has no meaning for {name} illuminance"),
            "\"direction\"",
            "\"direction\" together with \"quantity\": \"vertical\" or \"semi-cylindrical\"",
            "remove it, or change \"quantity\"",
        ));
    }
    match name {
        "perpendicular" => Ok((Quantity::Perpendicular, None)),
        "horizontal" => Ok((Quantity::Perpendicular, Some(DVec3::Z))),
        "cylindrical" => Ok((Quantity::Cylindrical, None)),
        "vertical" => Ok((Quantity::Perpendicular, Some(read_front(fields, name)?))),
        _ => Ok((Quantity::SemiCylindrical { direction: read_front(fields, name)? }, None)),
    }
}

/// Reads the horizontal direction that an upright plane or half cylinder faces.
fn read_front(fields: &Fields, name: &str) -> Result<DVec3, SceneError> {
    let node = fields.need("direction")?;
    let direction = node.direction()?;
    if direction.z != 0.0 {
        let expected = "a horizontal direction: [x, y, 0]";
        return Err(node.refuse(
            format!("the direction of {name} illuminance must be horizontal"),
            expected,
            "set its z to 0",
        ));
    }
    Ok(direction)
}
