//! Reads receivers of type `intensity`: the far-field intensity distribution of all light that leaves a scene, in C planes.

use glam::DVec3;

use super::error::SceneError;
use super::grid_frame::refuse_too_many;
use super::intensity_table::IntensityTable;
use super::keys::{Form, NUMBER, TYPE, VECTOR, ValueShape, form, from_to, optional};
use super::model::{ReceiverLayout, ReceiverPoint};
use super::photometry::LARGEST_OPENING_M;
use super::quantity::Quantity;
use super::reader::{Fields, Node};
use super::unique_names::name;
use super::units::LengthUnit;
use super::vectors::photometric_frame;

/// Defaults for the number of C planes and for the step of γ.
const USUAL_PLANES: u32 = 24;
const USUAL_STEP_DEG: f64 = 5.0;
/// Least and greatest number of steps of γ from 0 to 180°.
const FEWEST_STEPS: f64 = 4.0;
const MOST_STEPS: f64 = 360.0;
/// Greatest number of C planes.
const MOST_PLANES: u32 = 720;
/// Tolerance with which 180° must be a whole number of steps.
const STEP_TOLERANCE: f64 = 1e-9;

/// A receiver of intensities.
#[rustfmt::skip]
pub(super) const FORM: Form = form("intensity",
    "Far-field intensity distribution of all light that leaves the scene, in C planes, as a table and as photometric files.", &[&[
    name("Name of the receiver."),
    TYPE,
    optional("aim", VECTOR, "Direction of γ = 0; [0, 0, -1] by default."),
    optional("rotation_deg", NUMBER, "Rotation of C0 towards C90 about this direction, in degrees."),
    optional("c_planes", ValueShape::Count(MOST_PLANES), "Number of C planes, evenly spaced (default 24); a single one is the mean over all."),
    optional("gamma_step_deg", from_to(180.0 / MOST_STEPS, 180.0 / FEWEST_STEPS), "Step of γ in degrees (default 5): 180 divided by a whole number."),
    optional("luminous_opening", ValueShape::List(&NUMBER, [3, 3]),
        "Luminous opening that the files name: extents along C0–C180, along C90–C270, and its height; a point by default."),
]]);

/// Returns the quantity of an `intensity` receiver, its directions, and one point per direction. `most` limits the number of points.
pub(super) fn read(
    fields: &Fields,
    unit: LengthUnit,
    most: u64,
) -> Result<(Quantity, ReceiverLayout, Vec<ReceiverPoint>), SceneError> {
    let aim = fields.get("aim").map_or(Ok(-DVec3::Z), |node| node.direction())?;
    let rotation_deg = fields.get("rotation_deg").map_or(Ok(0.0), |node| node.number())?;
    let planes_node = fields.get("c_planes");
    let planes = planes_node.as_ref().map_or(Ok(USUAL_PLANES), |node| node.count("the number of C planes"))?;
    if let Some(node) = planes_node.as_ref().filter(|_| planes > MOST_PLANES) {
        return Err(node.refuse("too many C planes", format!("at most {MOST_PLANES}"), "24 are usual"));
    }
    let steps = fields.get("gamma_step_deg").map_or(Ok((180.0 / USUAL_STEP_DEG) as u32), |node| read_steps(&node))?;
    let opening_m = fields.get("luminous_opening").map_or(Ok([0.0; 3]), |node| read_opening(&node, unit))?;
    let table = IntensityTable { planes, steps, frame: photometric_frame(aim, rotation_deg), opening_m };
    if table.entries() as u64 > most {
        return Err(refuse_too_many(fields.node(), table.entries() as u64));
    }
    let point = |(plane, step): (u32, u32)| ReceiverPoint {
        position_m: DVec3::ZERO,
        normal: table.direction(plane, step),
        weight: table.solid_angle_sr(step),
        inside: false,
    };
    let points = table.places().map(point).collect();
    Ok((Quantity::Intensity { turned_about: table.turned_about() }, ReceiverLayout::Intensity(table), points))
}

fn read_steps(node: &Node) -> Result<u32, SceneError> {
    let step_deg = node.above_zero("the step of gamma")?;
    let steps = 180.0 / step_deg;
    if (steps - steps.round()).abs() > STEP_TOLERANCE * steps || !(FEWEST_STEPS..=MOST_STEPS).contains(&steps.round()) {
        let expected =
            format!("180° divided by a whole number, from {} to {}", 180.0 / MOST_STEPS, 180.0 / FEWEST_STEPS);
        return Err(node.refuse(
            "this step of gamma is not possible",
            expected,
            "5 is usual, 2.5 or 1 for narrow beams",
        ));
    }
    Ok(steps.round() as u32)
}

fn read_opening(node: &Node, unit: LengthUnit) -> Result<[f64; 3], SceneError> {
    let extents = node.items("extents")?;
    let [c0, c90, height] = &extents[..] else {
        let expected = "three extents: along C0–C180, along C90–C270, and the height";
        return Err(node.refuse_as(
            "a luminous opening",
            format!("{} numbers", extents.len()),
            expected,
            "[0.6, 0.3, 0]",
        ));
    };
    let extent_m = |node: &Node| {
        let extent_m = unit.length_m(node.at_least_zero("an extent")?);
        if extent_m > LARGEST_OPENING_M {
            let expected = format!("at most {LARGEST_OPENING_M} m");
            return Err(node.refuse("an opening that photometric files cannot have", expected, "check the unit"));
        }
        Ok(extent_m)
    };
    Ok([extent_m(c0)?, extent_m(c90)?, extent_m(height)?])
}
