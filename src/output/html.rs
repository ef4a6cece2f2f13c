//! Small pieces of a page: tables, figures, terms.

use super::picture::{Picture, escaped};

/// A table under construction. The caption is escaped later; headings and cells are markup already.
pub struct HtmlTable {
    head: Vec<Vec<Heading>>,
    /// Class of each column's cells; empty for numbers.
    classes: Vec<&'static str>,
    rows: Vec<(Vec<String>, bool)>,
    caption: String,
}

/// A heading of one column, of several, or of a row of headings.
pub struct Heading {
    pub markup: String,
    /// Columns that it spans.
    pub columns: usize,
    pub class: &'static str,
    /// What it is the heading of, as HTML names it: `col`, `colgroup` or `row`.
    pub scope: &'static str,
}

impl Heading {
    /// The heading of a column whose cells have a class.
    pub fn column(markup: impl Into<String>, class: &'static str) -> Heading {
        Heading { markup: markup.into(), columns: 1, class, scope: "col" }
    }
}

impl HtmlTable {
    /// A table with its columns: heading (markup), and whether the column holds text.
    pub fn new(caption: &str, head: &[(&str, bool)]) -> HtmlTable {
        let classes: Vec<&str> = head.iter().map(|(_, is_text)| if *is_text { "text" } else { "" }).collect();
        let head = head.iter().zip(&classes).map(|((markup, _), class)| Heading::column(*markup, class)).collect();
        HtmlTable { caption: caption.to_owned(), ..HtmlTable::with_head(vec![head], classes) }
    }

    /// A table with several rows of headings, and the class of each column's cells.
    pub fn with_head(head: Vec<Vec<Heading>>, classes: Vec<&'static str>) -> HtmlTable {
        HtmlTable { head, classes, rows: Vec::new(), caption: String::new() }
    }

    /// Adds a row of markup.
    pub fn row(&mut self, cells: Vec<String>) {
        self.rows.push((cells, false));
    }

    /// Adds a row of totals.
    pub fn total(&mut self, cells: Vec<String>) {
        self.rows.push((cells, true));
    }

    /// The table as markup. On a narrow screen it scrolls in its own box.
    pub fn markup(&self) -> String {
        let classed = |class: &str| if class.is_empty() { String::new() } else { format!(" class=\"{class}\"") };
        let spanning = |columns: usize| if columns == 1 { String::new() } else { format!(" colspan=\"{columns}\"") };
        let heading = |Heading { markup, columns, class, scope }: &Heading| {
            format!("<th{}{} scope=\"{scope}\">{markup}</th>", classed(class), spanning(*columns))
        };
        let head: Vec<String> =
            self.head.iter().map(|row| format!("<tr>{}</tr>", row.iter().map(heading).collect::<String>())).collect();
        let mut page = String::from("<div class=\"scroll\">\n<table>\n");
        if !self.caption.is_empty() {
            page += &format!("<caption>{}</caption>\n", escaped(&self.caption));
        }
        page += &format!("<thead>{}</thead>\n<tbody>\n", head.join("\n"));
        for (cells, is_total) in &self.rows {
            page.push_str(if *is_total { "<tr class=\"total\">" } else { "<tr>" });
            for (index, cell) in cells.iter().enumerate() {
                page += &format!("<td{}>{cell}</td>", classed(self.classes.get(index).copied().unwrap_or("")));
            }
            page.push_str("</tr>\n");
        }
        page.push_str("</tbody>\n</table>\n</div>\n");
        page
    }
}

/// A number and its standard error: `349 ± 2`.
pub fn with_error(number: &str, error: &str) -> String {
    format!("{number} <span class=\"pm\">± {error}</span>")
}

/// A picture with a caption below it.
pub fn figure(picture: &Picture, caption: &str) -> String {
    let caption =
        if caption.is_empty() { String::new() } else { format!("<figcaption>{}</figcaption>\n", escaped(caption)) };
    // A picture is shown at most 1.15 times as wide as it was drawn.
    let width = (1.15 * picture.width).round();
    format!("<figure style=\"max-width: {width}px\">\n{}{caption}</figure>\n", picture.inline_svg())
}

/// A list of terms and their meanings; both are markup.
pub fn terms(class: &str, terms: &[(String, String)]) -> String {
    let mut page = format!("<dl class=\"{class}\">\n");
    for (term, meaning) in terms {
        let item = format!("<dt>{term}</dt><dd>{meaning}</dd>");
        page += &if class == "facts" { format!("<div>{item}</div>\n") } else { format!("{item}\n") };
    }
    page.push_str("</dl>\n");
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_has_a_head_that_repeats_in_print() {
        let mut table = HtmlTable::new("A & B", &[("name", true), ("Ē", false)]);
        table.row(vec!["x".into(), with_error("5", "1")]);
        let markup = table.markup();
        assert!(markup.contains("<caption>A &amp; B</caption>") && markup.contains("<thead>"));
        assert!(markup.contains("<td class=\"text\">x</td><td>5 <span class=\"pm\">± 1</span></td>"));
    }
}
