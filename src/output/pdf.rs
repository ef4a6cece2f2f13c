//! A report's markup as a PDF on A4, with the program's own fonts: the same words and pictures as the page for browsers.

mod drawing;
mod ink;
mod layout;
mod markup;

use layout::Layout;

/// What a file tells of itself.
pub(super) struct About<'a> {
    /// Title.
    pub title: &'a str,
    /// Author; empty where nobody is named.
    pub author: &'a str,
    /// Code of its language.
    pub language: &'a str,
    /// When it was made, in seconds since 1970.
    pub unix_time_s: u64,
}

/// The PDF of a page's markup, which is well-formed but for line breaks.
pub(super) fn pdf(markup: &str, about: &About) -> Vec<u8> {
    let text = format!("<body>{}</body>", markup.replace("<br>", "<br/>"));
    let tree = roxmltree::Document::parse(&text).expect("a report is well-formed");
    let mut layout = Layout::new();
    layout.place(&markup::blocks(tree.root_element()));
    layout.finish(about.title, about.author, about.language, about.unix_time_s)
}
