//! Names of luminaires and receivers. Each name may be given once.

use std::collections::HashMap;
use std::rc::Rc;

use super::error::SceneError;
use super::keys::{Key, TEXT, needed};
use super::reader::{Fields, Node};

/// Names with the paths of the values that gave them. The names of an array share one path.
pub(super) type Names = HashMap<String, Rc<str>>;

/// The key of a name.
pub(super) const fn name(doc: &'static str) -> Key {
    needed("name", TEXT, "\"…\"", doc)
}

/// Reads a name. It refuses a name that another item of the same kind already has.
pub(super) fn unique_name(fields: &Fields, names: &mut Names) -> Result<String, SceneError> {
    let node = fields.need("name")?;
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

/// Reserves the name of a set that another set's keys generate. It refuses a name that is already in use.
pub(super) fn made_name(name: String, node: &Node, names: &mut Names) -> Result<String, SceneError> {
    if let Some(first) = names.insert(name.clone(), node.json_path().into()) {
        return Err(node.refuse_as(
            format!("the name {name:?} of a receiver set that luxmc adds is already in use"),
            format!("{name:?} again; {first} has it already"),
            "a name of its own",
            "rename the other one",
        ));
    }
    Ok(name)
}
