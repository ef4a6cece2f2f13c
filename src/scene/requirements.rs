//! Reads `requirements` of receivers: least or greatest values, or an entry of a standard with its values.

use super::error::SceneError;
use super::keys::{Form, NumberRange, TEXT, form, needed};
use super::names::{listed, nearest};
use super::quantity::Quantity;
use super::reader::{Fields, Node};
use super::standard::{
    AREA, AREAS, Area, FLUX_FACTOR, IS_MODIFIED, KEYS, MODIFIED, Measure, Requirement, STANDARDS, Standard,
    StandardEntry, background_lx, limit_about, surroundings_lx,
};
use super::standard_entries::ENTRIES;

/// Requirements of receivers.
#[rustfmt::skip]
pub(super) const FORM: Form = form("Requirements",
    "Requirements of receivers: numbers, or an entry of EN 12464-1; numbers given together with an entry replace those of the entry. `ugr` \
     applies to observers, the others to grids and points.", &[&KEYS]);

/// Requirements of a room.
#[rustfmt::skip]
pub(super) const ROOM_FORM: Form = form("RoomRequirements", "Requirements of a room.", &[&[
    needed("en_12464_1", TEXT, "\"34.2\"", "Reference of an entry of EN 12464-1, such as \"34.2\" (2021) or \"5.26.2\" (2011)."),
    IS_MODIFIED,
]]);

/// Reads the requirements of a receiver with a quantity. Numbers given together with an entry replace the entry's numbers.
pub(super) fn read(receiver: &Fields, quantity: Quantity) -> Result<Vec<Requirement>, SceneError> {
    let Some(node) = receiver.get("requirements") else { return Ok(Vec::new()) };
    let fields = node.object("the requirements of a receiver", &FORM)?;
    let is_glare = matches!(quantity, Quantity::Glare(_));
    let entry = read_entry(&fields, quantity)?;
    let flux_factor = read_flux_factor(&fields, entry)?;
    let area = read_area(&fields, quantity, entry)?;
    let task_lx = read_task_lx(&fields, quantity, area, entry)?;
    let mut requirements = Vec::new();
    for measure in Measure::ALL {
        let is_of_glare = measure == Measure::Ugr;
        let flux_factor = if measure.is_direct() { flux_factor } else { 1.0 };
        if let Some(node) = fields.get(measure.key()) {
            if is_of_glare != is_glare {
                return Err(refuse_measure(&node, measure));
            }
            requirements.push(Requirement {
                measure,
                area,
                limit: read_limit(&node, measure)?,
                entry: None,
                flux_factor,
            });
        } else if let Some(entry) = entry.filter(|_| is_of_glare == is_glare)
            && let Some(limit) = entry.limit_of(area, measure, task_lx)
        {
            requirements.push(Requirement { measure, area, limit, entry: Some(entry), flux_factor });
        }
    }
    if requirements.is_empty() {
        let example = if is_glare { "\"ugr\": 19" } else { "\"average_lx\": 500" };
        let expected = format!("one or more of {}", listed(FORM.names()));
        return Err(node.refuse(
            "these requirements set no limit",
            expected,
            format!("write {example}, or remove \"requirements\""),
        ));
    }
    Ok(requirements)
}

/// An entry for a whole room, with the average in lx that the task area must have.
#[derive(Clone, Copy)]
pub(super) struct RoomEntry {
    entry: &'static StandardEntry,
    task_lx: Option<f64>,
}

impl RoomEntry {
    /// Reads the entry that a room's receiver names.
    pub fn read(receiver: &Fields) -> Result<RoomEntry, SceneError> {
        let fields = receiver.need("requirements")?.object("the requirements of a room", &ROOM_FORM)?;
        fields.need("en_12464_1")?;
        let Some(entry) = read_entry(&fields, Quantity::Perpendicular)? else {
            unreachable!("an entry is named");
        };
        let task_lx = read_task_lx(&fields, Quantity::Perpendicular, Area::Task, Some(entry))?;
        Ok(RoomEntry { entry, task_lx })
    }

    /// Requirements of the entry for the illuminance of an area.
    pub fn of(&self, area: Area) -> Vec<Requirement> {
        self.required(area, |measure| measure != Measure::Ugr)
    }

    /// Requirements of the entry for observers.
    pub fn of_observers(&self) -> Vec<Requirement> {
        self.required(Area::Task, |measure| measure == Measure::Ugr)
    }

    fn required(&self, area: Area, is_meant: impl Fn(Measure) -> bool) -> Vec<Requirement> {
        let required = |measure: Measure| {
            let limit = self.entry.limit_of(area, measure, self.task_lx)?;
            Some(Requirement { measure, area, limit, entry: Some(self.entry), flux_factor: 1.0 })
        };
        Measure::ALL.into_iter().filter(|measure| is_meant(*measure)).filter_map(required).collect()
    }
}

/// Requirements of EN 12464-1 for the surroundings or background of a task area, from the task's average. `None` if the task requires no
/// average.
pub(super) fn about(task: &[Requirement], area: Area) -> Option<Vec<Requirement>> {
    let of_task = task.iter().find(|requirement| requirement.measure == Measure::AverageLx)?;
    let average_lx = match area {
        Area::Background => background_lx(of_task.limit),
        _ => surroundings_lx(of_task.limit),
    };
    let required = |measure: Measure| {
        let limit = limit_about(area, measure, average_lx)?;
        Some(Requirement { measure, area, limit, ..*of_task })
    };
    Some(Measure::ALL.into_iter().filter_map(required).collect())
}

/// Reads the area of the room that an entry refers to: the area in the file, or else the one that follows from the quantity.
fn read_area(fields: &Fields, quantity: Quantity, entry: Option<&StandardEntry>) -> Result<Area, SceneError> {
    let Some(node) = fields.get(AREA) else {
        return Ok(if quantity == Quantity::Cylindrical { Area::Cylinders } else { Area::Task });
    };
    let is_known = entry.is_some_and(|entry| entry.space.is_some());
    if !is_known || quantity != Quantity::Perpendicular {
        return Err(node.refuse(
            "\"area\" needs an entry of EN 12464-1 that requires the illuminance of a plane",
            "\"area\" together with \"en_12464_1\", in a receiver of type \"grid\" or \"points\" on a plane",
            "leave it out, or name an entry",
        ));
    }
    Ok(AREAS[node.choice()?])
}

/// Reads the average in lx that an entry requires of the task area. `None` if it requires none, as for an escape route.
fn read_task_lx(
    fields: &Fields,
    quantity: Quantity,
    area: Area,
    entry: Option<&StandardEntry>,
) -> Result<Option<f64>, SceneError> {
    let required_lx = entry.and_then(|entry| entry.limit(Measure::AverageLx));
    let Some(node) = fields.get(MODIFIED) else { return Ok(required_lx) };
    let modified_lx = entry.and_then(|entry| entry.space).and_then(|space| space.modified_lx);
    let is_of_task =
        quantity == Quantity::Perpendicular && matches!(area, Area::Task | Area::Surroundings | Area::Background);
    let Some(modified_lx) = modified_lx.filter(|_| is_of_task) else {
        return Err(node.refuse(
            "none of these requirements has a modified value",
            "\"modified\" together with an entry of EN 12464-1:2021, for a plane of the task, its surroundings or its background",
            "leave it out, or give \"average_lx\"",
        ));
    };
    Ok(if node.boolean()? { Some(modified_lx) } else { required_lx })
}

fn refuse_measure(node: &Node, measure: Measure) -> SceneError {
    match measure {
        Measure::Ugr => node.refuse(
            "a receiver of illuminance has no glare rating",
            "\"ugr\" in the requirements of a receiver of type \"ugr\" or \"ugr_grid\"",
            "require it of an observer",
        ),
        _ => node.refuse(
            format!("an observer has a glare rating, but no \"{}\"", measure.key()),
            "\"ugr\"",
            "require it of a receiver of type \"grid\" or \"points\"",
        ),
    }
}

fn read_limit(node: &Node, measure: Measure) -> Result<f64, SceneError> {
    match measure {
        Measure::UniformityU0 | Measure::UniformityUd | Measure::DirectUniformityUd => {
            node.amount("the least uniformity")
        }
        Measure::Ugr => {
            let (limit, NumberRange { least, most, .. }) =
                (node.above_zero("the greatest glare rating")?, node.range());
            if !(least..=most).contains(&limit) {
                return Err(node.refuse(
                    "the rating is outside of the scale of glare ratings",
                    format!("a rating from {least} to {most}"),
                    "write 19, for example",
                ));
            }
            Ok(limit)
        }
        Measure::AverageLx | Measure::MinimumLx | Measure::MaximumLx | Measure::DirectMinimumLx => {
            node.amount("the illuminance required")
        }
    }
}

/// Reads the share of the flux that remains on batteries, for requirements on direct light.
fn read_flux_factor(fields: &Fields, entry: Option<&StandardEntry>) -> Result<f64, SceneError> {
    let Some(node) = fields.get(FLUX_FACTOR) else { return Ok(1.0) };
    let is_asked = |measure: &Measure| {
        fields.get(measure.key()).is_some() || entry.is_some_and(|entry| entry.limit(*measure).is_some())
    };
    if !Measure::ALL.iter().filter(|measure| measure.is_direct()).any(is_asked) {
        return Err(node.refuse(
            "the share of the flux applies to direct light only, and no requirement concerns direct light",
            "\"flux_factor\" together with \"en_1838\", \"direct_minimum_lx\" or \"direct_uniformity_ud\"",
            "leave it out; \"dimming\" of a luminaire applies to all light",
        ));
    }
    node.amount("the share of the flux")
}

/// Reads the entry of a standard that requirements name. They may name one at most.
fn read_entry(fields: &Fields, quantity: Quantity) -> Result<Option<&'static StandardEntry>, SceneError> {
    let named: Vec<(&str, Standard, Node)> =
        STANDARDS.iter().filter_map(|(key, standard)| Some((*key, *standard, fields.get(key)?))).collect();
    if let [_, (key, _, node), ..] = &named[..] {
        return Err(node.refuse(
            format!("\"{key}\" is the second standard that these requirements name"),
            "one standard",
            "give the values of the other one as numbers",
        ));
    }
    let Some((key, standard, node)) = named.into_iter().next() else { return Ok(None) };
    let is_plane = quantity == Quantity::Perpendicular;
    let is_rated = matches!(quantity, Quantity::Glare(_) | Quantity::Cylindrical) && standard == Standard::WorkPlaces;
    if !is_plane && !is_rated {
        return Err(node.refuse(
            format!("entries require the illuminance of a plane, but this receiver computes another quantity: {}", quantity.name()),
            format!(
                "\"{key}\" together with \"quantity\": \"perpendicular\", \"horizontal\" or \"vertical\"; of EN 12464-1 \"cylindrical\" too, or of an observer"
            ),
            "give the number required by \"average_lx\"",
        ));
    }
    let reference = node.name()?;
    let entries = || ENTRIES.iter().filter(|entry| entry.standard == standard);
    entries().find(|entry| entry.reference == reference).map(Some).ok_or_else(|| {
        let near = match nearest(reference, entries().map(|entry| entry.reference)) {
            Some(near) => format!("if \"{near}\" is meant, write that; otherwise "),
            None => String::new(),
        };
        let what = match standard {
            Standard::WorkPlaces => "luxmc does not know this entry of EN 12464-1",
            Standard::Sports => "this is not a class of EN 12193",
            Standard::Emergency => "luxmc does not know this kind of emergency lighting of EN 1838",
        };
        node.refuse(
            what,
            format!("one of {}", entries().map(|entry| entry.reference).collect::<Vec<_>>().join(", ")),
            format!("{near}give the numbers themselves: \"average_lx\", \"uniformity\", \"ugr\""),
        )
    })
}
