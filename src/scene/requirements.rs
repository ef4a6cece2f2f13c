//! Reads `requirements` of receivers: least or greatest values, or an entry of EN 12464-1 that names them.

use super::error::SceneError;
use super::model::Quantity;
use super::names::{listed, nearest};
use super::reader::{Fields, Node};
use super::standard::{ENTRIES, KEYS, Measure, Requirement, STANDARD, StandardEntry};

/// What a receiver that asks for a quantity is to keep. Numbers that stand beside an entry take the place of its own.
pub(super) fn read(receiver: &Fields, quantity: Quantity) -> Result<Vec<Requirement>, SceneError> {
    let Some(node) = receiver.get("requirements") else { return Ok(Vec::new()) };
    let fields = node.fields("the requirements of a receiver")?;
    fields.only(&KEYS)?;
    let is_glare = matches!(quantity, Quantity::Glare(_));
    let entry = fields.get(STANDARD).map(|node| read_entry(&node, quantity)).transpose()?;
    let mut requirements = Vec::new();
    for measure in Measure::ALL {
        let is_of_glare = measure == Measure::Ugr;
        if let Some(node) = fields.get(measure.key()) {
            if is_of_glare != is_glare {
                return Err(refuse_measure(&node, measure));
            }
            requirements.push(Requirement { measure, limit: read_limit(&node, measure)?, entry: None });
        } else if let Some(entry) = entry.filter(|_| is_of_glare == is_glare)
            && let Some(limit) = entry.limit(measure)
        {
            requirements.push(Requirement { measure, limit, entry: Some(entry) });
        }
    }
    if requirements.is_empty() {
        let example = if is_glare { "\"ugr\": 19" } else { "\"average_lx\": 500" };
        let expected = format!("one or more of {}", listed(KEYS));
        return Err(node.refuse(
            "these requirements ask for nothing",
            expected,
            format!("write {example}, or remove \"requirements\""),
        ));
    }
    Ok(requirements)
}

fn refuse_measure(node: &Node, measure: Measure) -> SceneError {
    match measure {
        Measure::Ugr => node.refuse(
            "a receiver of illuminance has no glare rating",
            "\"ugr\" in the requirements of a receiver of type \"ugr\" or \"ugr_grid\"",
            "ask it of an observer",
        ),
        _ => node.refuse(
            format!("an observer has a glare rating, and no \"{}\"", measure.key()),
            "\"ugr\"",
            "ask it of a receiver of type \"grid\" or \"points\"",
        ),
    }
}

fn read_limit(node: &Node, measure: Measure) -> Result<f64, SceneError> {
    match measure {
        Measure::UniformityU0 | Measure::UniformityUd => {
            node.above_zero("the least uniformity")?;
            node.fraction("the least uniformity")
        }
        Measure::Ugr => {
            /// Least and greatest rating of the scale.
            const SCALE: [f64; 2] = [10.0, 40.0];
            let limit = node.above_zero("the greatest glare rating")?;
            if !(SCALE[0]..=SCALE[1]).contains(&limit) {
                let expected = format!("a rating from {} to {}", SCALE[0], SCALE[1]);
                return Err(node.refuse("the scale of glare ratings does not go there", expected, "write 19, say"));
            }
            Ok(limit)
        }
        Measure::AverageLx | Measure::MinimumLx | Measure::MaximumLx => node.above_zero("the illuminance required"),
    }
}

fn read_entry(node: &Node, quantity: Quantity) -> Result<&'static StandardEntry, SceneError> {
    if !matches!(quantity, Quantity::Perpendicular | Quantity::Glare(_)) {
        return Err(node.refuse(
            format!("entries ask for the illuminance of a plane, and this receiver for a {} one", quantity.name()),
            "\"en_12464_1\" beside \"quantity\": \"perpendicular\", \"horizontal\" or \"vertical\", or of an observer",
            "give the number required by \"average_lx\"",
        ));
    }
    let reference = node.name()?;
    ENTRIES.iter().find(|entry| entry.reference == reference).ok_or_else(|| {
        let near = match nearest(reference, ENTRIES.iter().map(|entry| entry.reference)) {
            Some(near) => format!("if \"{near}\" is meant, write that; else "),
            None => String::new(),
        };
        node.refuse(
            "no entry of EN 12464-1 that this program knows",
            format!("one of {}", ENTRIES.iter().map(|entry| entry.reference).collect::<Vec<_>>().join(", ")),
            format!("{near}give the numbers themselves: \"average_lx\", \"uniformity\", \"ugr\""),
        )
    })
}
