//! Reads `project`: client, author and date of a scene, for reports.

use super::error::SceneError;
use super::keys::{Form, TEXT, form, optional};
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
#[rustfmt::skip]
pub(super) const FORM: Form = form("Project", "Client, author and date of the work.", &[&[
    optional("client", TEXT, "Client."),
    optional("author", TEXT, "Author."),
    optional("date", TEXT, "Date."),
    optional("notes", TEXT, "Further text for the client."),
]]);

pub(super) fn read(node: &Node) -> Result<Project, SceneError> {
    let fields = node.object("a project", &FORM)?;
    let text = |key: &str| fields.get(key).map_or(Ok(String::new()), |node| node.text().map(str::to_owned));
    Ok(Project { client: text("client")?, author: text("author")?, date: text("date")?, notes: text("notes")? })
}
