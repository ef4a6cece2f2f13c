//! Reads `project`: client, author and date of a scene, for reports.

use super::error::SceneError;
use super::reader::Node;

/// Data of a project for reports. Missing entries are empty.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Project {
    /// Client.
    pub client: String,
    /// Author.
    pub author: String,
    /// Date in the author's own words.
    pub date: String,
    /// Notes for the client.
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
