//! Converts a report's markup to a PDF on A4, with the bundled fonts. It has the same words and pictures as the page for browsers.

mod drawing;
mod ink;
mod layout;
mod markup;

use layout::Layout;

/// Metadata of a file.
pub(super) struct About<'a> {
    /// Title.
    pub title: &'a str,
    /// Author; empty if none is given.
    pub author: &'a str,
    /// Code of the language.
    pub language: &'a str,
    /// When the file was made, in seconds since 1970.
    pub unix_time_s: u64,
}

/// The PDF of a page's markup, which must be well-formed except for `<br>`. `None` if it is not, so that no result is lost for a
/// missing page.
pub(super) fn pdf(markup: &str, about: &About) -> Option<Vec<u8>> {
    // XML forbids these two characters, which a name may contain.
    let markup = markup.replace("<br>", "<br/>").replace(['\u{fffe}', '\u{ffff}'], "\u{fffd}");
    let text = format!("<body>{markup}</body>");
    let tree = roxmltree::Document::parse(&text).ok()?;
    let mut layout = Layout::new();
    layout.place(&markup::blocks(tree.root_element()));
    Some(layout.finish(about.title, about.author, about.language, about.unix_time_s))
}

#[cfg(test)]
mod tests {
    use super::{About, pdf};
    use crate::output::html::{HtmlTable, figure, terms};
    use crate::output::picture::{Pen, Picture, Words, escaped};

    const ABOUT: About<'static> = About { title: "A & B", author: "", language: "en", unix_time_s: 0 };

    fn pages(markup: &str) -> usize {
        let bytes = pdf(markup, &ABOUT).expect("well-formed");
        let text = String::from_utf8_lossy(&bytes);
        assert!(text.starts_with("%PDF-") && text.trim_end().ends_with("%%EOF"));
        text.matches("/Type /Page\n").count()
    }

    #[test]
    fn a_table_longer_than_a_page_goes_on_and_nothing_makes_it_fall() {
        let mut table = HtmlTable::new("long", &[("Name<small>of it</small>", true), ("Reflec-<br>tance", false)]);
        (0..100).for_each(|row| table.row(vec![escaped(&format!("row <{row}> \u{ffff}")), "0.50".to_owned()]));
        assert_eq!(pages("<p>short</p>"), 1);
        assert!(pdf("<p>< 0.1 %</p>", &ABOUT).is_none(), "a sign that opens no element");
        assert_eq!(pages(&table.markup()), 3, "some 45 rows a page");
        assert_eq!(pages(&format!("<h2>One</h2>{}<h2 class=\"page\">Two</h2>", terms("words", &[]))), 1);
    }

    #[test]
    fn a_picture_goes_whole_to_the_next_page() {
        let mut picture = Picture::new(600.0, 500.0, "a square");
        picture.ring(vec![[0.0, 0.0], [600.0, 0.0], [600.0, 500.0]], Pen::new([0, 0, 0], 1.0).dashed(3.0, 2.0));
        picture.words(Words::new("Ē ≥ 5 ✓ \u{1f600}", [10.0, 20.0], 12.0).turned(-90.0).rimmed(1.0));
        let one = figure(&picture, "below");
        assert_eq!([1, 2, 3, 4].map(|count| pages(&one.repeat(count))), [1, 1, 2, 2]);
        // Two pictures fill a page. If few words follow before the next heading, the pictures are reduced.
        let with_items = |count: usize| one.repeat(2) + &"<li>a line</li>".repeat(count);
        assert_eq!([4, 10, 14].map(|count| pages(&with_items(count))), [1, 1, 2]);
        assert_eq!(pages(&format!("{}<h2>Next</h2>", with_items(4))), 2, "a heading is not asked to stay");
    }
}
