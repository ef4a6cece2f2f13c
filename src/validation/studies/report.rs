//! Studies as HTML, Markdown and CSV.

use super::Findings;
use crate::validation::report::Table;
use crate::validation::report_html::table as html_table;
use crate::validation::report_md::table as md_table;
use crate::validation::words::escaped;

/// Text for the page, with text between asterisks emphasised.
fn emphasised(text: &str) -> String {
    let text = escaped(text);
    if text.matches('*').count() % 2 == 1 {
        return text;
    }
    let part =
        |(number, part): (usize, &str)| if number % 2 == 1 { format!("<em>{part}</em>") } else { part.to_owned() };
    text.split('*').enumerate().map(part).collect()
}

/// A section of the page, including pictures.
pub fn study_section(findings: &Findings) -> String {
    let mut page = format!("<h2 id=\"{}\">{}</h2>\n", findings.name, escaped(findings.title));
    page += &format!("<p class=\"soft\">study {}</p>\n<p>{}</p>\n", findings.name, emphasised(&findings.setting));
    for sentence in &findings.results {
        page += &format!("<p>{}</p>\n", emphasised(sentence));
    }
    for (caption, picture) in &findings.pictures {
        page += &format!("<figure>\n{picture}\n<figcaption>{}</figcaption>\n</figure>\n", escaped(caption));
    }
    for (caption, table) in &findings.tables {
        page += &format!("<h3>{}</h3>\n{}", escaped(caption), html_table(table, false));
    }
    page
}

/// The section as Markdown, without pictures.
pub fn study_md(findings: &Findings) -> String {
    let mut page = format!("## {}\n\n{}\n\n", findings.title, findings.setting);
    for sentence in &findings.results {
        page += &format!("{sentence}\n\n");
    }
    for (caption, table) in &findings.tables {
        page += &format!("### {caption}\n\n{}\n", md_table(table));
    }
    page
}

/// The tables as CSV one after the other, separated by empty lines.
pub fn study_csv(findings: &Findings) -> String {
    let of_table = |table: &Table| {
        let quoted = |text: &str| {
            if text.contains([',', '"']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
        };
        let header = table.header.iter().map(|heading| quoted(heading)).collect::<Vec<_>>().join(",");
        let rows = table.rows.iter().map(|row| row.iter().map(|cell| quoted(cell)).collect::<Vec<_>>().join(","));
        std::iter::once(header).chain(rows).map(|line| format!("{line}\n")).collect::<String>()
    };
    findings.tables.iter().map(|(_, table)| of_table(table)).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::emphasised;

    #[test]
    fn what_stands_between_asterisks_is_emphasised() {
        assert_eq!(emphasised("*wedges*: a < b"), "<em>wedges</em>: a &lt; b");
        assert_eq!(emphasised("2 * 3"), "2 * 3");
    }
}
