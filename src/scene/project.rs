//! Reads `project`: whose work a scene is, for reports.

use super::error::SceneError;
use super::reader::Node;

/// Whose work a scene is; what is not told is empty.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Project {
    /// For whom.
    pub client: String,
    /// By whom.
    pub author: String,
    /// When, in the author's own words.
    pub date: String,
    /// What else the client is to read.
    pub notes: String,
}

/// Keys of `project`.
pub(super) const KEYS: [&str; 4] = ["client", "author", "date", "notes"];

pub(super) fn read(node: &Node) -> Result<Project, SceneError> {
    let fields = node.fields("a project")?;
    fields.only(&KEYS)?;
    let text = |key: &str| fields.get(key).map_or(Ok(String::new()), |node| node.text().map(str::to_owned));
    Ok(Project { client: text("client")?, author: text("author")?, date: text("date")?, notes: text("notes")? })
}
