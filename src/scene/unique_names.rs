//! Names of luminaires and receivers, each given once.

use std::collections::HashMap;
use std::rc::Rc;

use super::error::SceneError;
use super::reader::Fields;

/// Names with the places where they were given; those of an array share theirs.
pub(super) type Names = HashMap<String, Rc<str>>;

/// Refuses a name that has been given before to something of the same sort.
pub(super) fn unique_name(fields: &Fields, names: &mut Names) -> Result<String, SceneError> {
    let node = fields.need("name", "\"…\"")?;
    let name = node.name()?;
    if let Some(first) = names.insert(name.to_string(), node.json_path().into()) {
        return Err(node.refuse_as(
            format!("the name {name:?} is given twice"),
            format!("{name:?} again; {first} has it already"),
            "a name of its own",
            "rename one of the two",
        ));
    }
    Ok(name.to_string())
}
