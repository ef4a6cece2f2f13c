//! The report as one self-contained HTML page.

use super::outcome::{CaseOutcome, ComparisonOutcome};
use super::plots::{comparison_plot, shows_entries};
use super::report::{HOW_TO_READ, Table, VERDICT, Validation, costs, deviations, numbers, sources, subject};
use super::words::escaped;
use crate::output::html;

const STYLE: &str = include_str!("style.css");

/// Writes the report as HTML.
pub fn report_html(validation: &Validation) -> String {
    let mut page = opening("luxmc validation report");
    page.push_str("<h1>luxmc validation report</h1>\n");
    page.push_str(&format!("<p class=\"soft\">{}</p>\n", escaped(&validation.circumstances())));
    let class = if validation.failures().is_empty() { "pass" } else { "fail" };
    page.push_str(&format!("<p class=\"{class}\">{}</p>\n", escaped(&validation.verdict())));
    for group in &validation.empty_groups {
        page.push_str(&format!("<p class=\"soft\">The group “{}” has no cases yet.</p>\n", escaped(group)));
    }
    if validation.cases.len() > 1 {
        page.push_str(&table(&validation.overview(), true));
    }
    page.push_str("<h3>How to read this report</h3>\n");
    for paragraph in HOW_TO_READ {
        page.push_str(&format!("<p>{}</p>\n", escaped(paragraph)));
    }
    for case in &validation.cases {
        section(&mut page, case);
    }
    page.push_str("</body>\n</html>\n");
    page
}

/// Head of a page with the project's typography.
pub(super) fn opening(title: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n",
        escaped(title)
    )
}

fn section(page: &mut String, case: &CaseOutcome) {
    let verdict = if case.passes() { "<span class=\"pass\">pass</span>" } else { "<span class=\"fail\">FAIL</span>" };
    page.push_str(&format!("<h2 id=\"{0}\">{1} — {verdict}</h2>\n", escaped(&case.name), escaped(&case.title)));
    page.push_str(&format!("<p class=\"soft\">case {}</p>\n<p>{}</p>\n", escaped(&case.name), escaped(&case.physics)));
    for remark in &case.remarks {
        page.push_str(&format!("<p>{}</p>\n", escaped(remark)));
    }
    page.push_str(&table(&deviations(case), false));
    for comparison in &case.comparisons {
        page.push_str(&format!(
            "<div class=\"together\">\n<h3>{}</h3>\n<p>{}</p>\n",
            escaped(&comparison.heading()),
            escaped(&subject(comparison))
        ));
        // One number needs no picture.
        let alone = comparison.set.entries.len() == 1;
        if !alone {
            let (picture, caption) = (comparison_plot(comparison), caption(comparison));
            page.push_str(&format!("<figure>\n{picture}\n<figcaption>{caption}</figcaption>\n</figure>\n"));
        }
        page.push_str("</div>\n<ul>\n");
        for check in &comparison.checks {
            let (class, word) = if check.holds { ("pass", "holds") } else { ("fail", "FAILS") };
            page.push_str(&format!(
                "<li>{}: {} — <span class=\"{class}\">{word}</span></li>\n",
                escaped(&capital(&check.condition)),
                escaped(&check.found)
            ));
        }
        page.push_str("</ul>\n");
        if let Some(numbers) = numbers(comparison) {
            let numbers = table(&numbers, false);
            if alone {
                page.push_str(&numbers);
            } else {
                page.push_str(&format!("<details><summary>All numbers</summary>\n{numbers}</details>\n"));
            }
        }
    }
    for (heading, rows) in [("Where the deviation comes from", sources(case)), ("Cost", costs(case))] {
        page.push_str(&format!("<div class=\"together\">\n<h3>{heading}</h3>\n{}</div>\n", table(&rows, false)));
    }
    if !case.sources.is_empty() {
        page.push_str(&format!("<p class=\"soft\">Sources: {}</p>\n", escaped(&case.sources.join("; "))));
    }
}

/// Caption that explains a plot.
fn caption(comparison: &ComparisonOutcome) -> String {
    if !shows_entries(comparison) {
        return "Bars: number of elements by their deviation in standard errors. Line: the distribution by chance alone if the error bars are right.".to_owned();
    }
    let band = if comparison.comparison.criterion.worst.is_some() {
        "; the green band shows what the criterion allows"
    } else {
        ""
    };
    format!("Above: computed and exact values. Below: deviation in per cent, with two standard errors{band}.")
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().collect::<String>() + letters.as_str())
}

/// An HTML table. With `linked` the first column links to the cases' sections.
pub(super) fn table(table: &Table, linked: bool) -> String {
    let headings: Vec<String> = table.header.iter().map(|heading| escaped(heading)).collect();
    let is_text = |index: usize| table.text_columns.contains(&index);
    let head: Vec<(&str, bool)> =
        headings.iter().enumerate().map(|(index, heading)| (heading.as_str(), is_text(index))).collect();
    let cell = |index: usize, cell: &String| {
        let text = escaped(cell);
        if table.header[index] == VERDICT {
            let class = if cell == "pass" { "pass" } else { "fail" };
            return format!("<span class=\"{class}\">{text}</span>");
        }
        if linked && index == 0 { format!("<a href=\"#{text}\">{text}</a>") } else { text }
    };
    let mut markup = html::HtmlTable::new("", &head);
    for row in &table.rows {
        markup.row(row.iter().enumerate().map(|(index, text)| cell(index, text)).collect());
    }
    markup.markup()
}
