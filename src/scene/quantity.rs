//! What receivers ask for: quantities, their names, and how files ask for them.

use glam::DVec3;
use schemars::JsonSchema;

use super::error::SceneError;
use super::reader::Fields;

/// What a receiver asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Quantity {
    /// On the plane of the point's own normal.
    #[default]
    Perpendicular,
    /// On the mantle of a small upright cylinder: E_z = 1/π ∫ L sin ε dω, ε from the vertical.
    Cylindrical,
    /// On the curved face of half an upright cylinder: E_sc = 1/π ∫ L (1 + cos α) sin ε dω, α from `direction`.
    SemiCylindrical {
        /// Horizontal unit vector to which the curved face looks.
        direction: DVec3,
    },
    /// Luminance in cd/m² that an eye at the point sees in the direction of its normal. What maps and tables call
    /// illuminance in lx is then this.
    Luminance,
    /// Unified glare rating of the set's observers. The map holds indirect illuminances in lx, π times the background
    /// luminance: a point an observer, or where it is that of walls points on these, which tell it for all in the mean.
    Glare(Background),
    /// Far-field luminous intensity in cd, in the direction of the point's normal, of all light that leaves the scene. What maps and
    /// tables call illuminance in lx is then this; points are no places.
    Intensity {
        /// Axis about which one plane stands for all: the mean over all planes is asked for.
        turned_about: Option<DVec3>,
    },
}

/// Where the indirect illuminance is taken that tells the background luminance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Background {
    /// At the eye, on the plane across the line of sight (CIE 117).
    #[default]
    Observer,
    /// On the walls between eye and luminaires, in the mean (CIE 190).
    Tabular,
}

impl Background {
    /// Name as the scene file writes it.
    pub fn name(self) -> &'static str {
        match self {
            Background::Observer => "observer",
            Background::Tabular => "tabular",
        }
    }
}

impl Quantity {
    /// Whether it is an illuminance of the points themselves.
    pub fn is_illuminance(self) -> bool {
        !matches!(self, Quantity::Luminance | Quantity::Glare(_) | Quantity::Intensity { .. })
    }

    /// Whether all that a point receives comes from the hemisphere above it: cylinders turn their planes.
    pub fn has_one_hemisphere(self) -> bool {
        self == Quantity::Perpendicular
    }

    /// Name as the scene file writes it.
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
}

/// What can be asked for at points and grids, as files name it.
pub(super) const QUANTITIES: [&str; 5] = ["perpendicular", "horizontal", "vertical", "cylindrical", "semi-cylindrical"];

/// What illuminance receivers ask for.
#[derive(JsonSchema)]
#[schemars(rename_all = "kebab-case")]
#[expect(dead_code, reason = "only its shape is used")]
pub(super) enum QuantityName {
    Perpendicular,
    Horizontal,
    Vertical,
    Cylindrical,
    SemiCylindrical,
}

/// What is asked for at points and grids, and the normal to which it turns them all: horizontal and vertical illuminance do.
pub(super) fn read(fields: &Fields) -> Result<(Quantity, Option<DVec3>), SceneError> {
    let chosen = fields.get("quantity").map_or(Ok(0), |node| node.choice(&QUANTITIES))?;
    let name = QUANTITIES[chosen];
    if let (Some(node), "perpendicular" | "horizontal" | "cylindrical") = (fields.get("direction"), name) {
        return Err(node.refuse_as(
            format!("a direction has no meaning for {name} illuminance"),
            "\"direction\"",
            "\"direction\" beside \"quantity\": \"vertical\" or \"semi-cylindrical\"",
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

/// Where something upright looks to.
fn read_front(fields: &Fields, name: &str) -> Result<DVec3, SceneError> {
    let node = fields.need("direction", "[1, 0, 0]: to where the plane or half cylinder looks")?;
    let direction = node.direction()?;
    if direction.z != 0.0 {
        let expected = "a horizontal direction: [x, y, 0]";
        return Err(node.refuse(format!("{name} illuminance looks sideways"), expected, "set its z to 0"));
    }
    Ok(direction)
}
