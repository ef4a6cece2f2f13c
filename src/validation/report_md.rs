//! The report as Markdown, and every compared number as CSV.

use super::outcome::CaseOutcome;
use super::report::{HOW_TO_READ, Table, Validation, costs, deviations, numbers, sources, subject};

/// Writes the report as Markdown.
pub fn report_md(validation: &Validation) -> String {
    let mut page =
        format!("# luxmc validation report\n\n{}\n\n**{}**\n\n", validation.circumstances(), validation.verdict());
    for group in &validation.empty_groups {
        page.push_str(&format!("The group \"{group}\" has no cases yet.\n\n"));
    }
    page.push_str(&table(&validation.overview()));
    page.push_str("\n## How to read this report\n\n");
    for paragraph in HOW_TO_READ {
        page.push_str(&format!("{paragraph}\n\n"));
    }
    for case in &validation.cases {
        section(&mut page, case);
    }
    page
}

fn section(page: &mut String, case: &CaseOutcome) {
    let verdict = if case.passes() { "pass" } else { "FAIL" };
    page.push_str(&format!("## {}: {} ({verdict})\n\n{}\n\n", case.name, case.title, case.physics));
    for remark in &case.remarks {
        page.push_str(&format!("{remark}\n\n"));
    }
    page.push_str(&table(&deviations(case)));
    page.push('\n');
    for comparison in &case.comparisons {
        page.push_str(&format!("### {}\n\n{}\n\n", comparison.heading(), subject(comparison)));
        for check in &comparison.checks {
            let word = if check.holds { "holds" } else { "**FAILS**" };
            page.push_str(&format!("- {}: {}: {word}\n", check.condition, check.found));
        }
        page.push('\n');
        if let Some(numbers) = numbers(comparison) {
            page.push_str(&table(&numbers));
            page.push('\n');
        }
    }
    page.push_str("### Where the deviation comes from\n\n");
    page.push_str(&table(&sources(case)));
    page.push_str("\n### Cost\n\n");
    page.push_str(&table(&costs(case)));
    if !case.sources.is_empty() {
        page.push_str(&format!("\nSources: {}\n", case.sources.join("; ")));
    }
    page.push('\n');
}

/// A Markdown table.
pub(super) fn table(table: &Table) -> String {
    let line = |cells: &mut dyn Iterator<Item = String>| format!("| {} |\n", cells.collect::<Vec<_>>().join(" | "));
    let mut text = line(&mut table.header.iter().map(|heading| (*heading).to_owned()));
    text.push_str(&line(
        &mut (0..table.header.len())
            .map(|index| if table.text_columns.contains(&index) { "---".to_owned() } else { "---:".to_owned() }),
    ));
    for row in &table.rows {
        text.push_str(&line(&mut row.iter().map(|cell| cell.replace('|', "\\|"))));
    }
    text
}

/// Every compared number of a case as CSV, one row each.
pub fn case_csv(case: &CaseOutcome) -> String {
    let mut text = String::from(
        "comparison,light,run,where,exact_lx,measured_lx,standard_error_lx,deviation_lx,deviation_percent,deviation_in_standard_errors,uncertainty_of_exact_lx,discretisation_lx,truncation_lx,published_lx\n",
    );
    for comparison in &case.comparisons {
        for entry in &comparison.set.entries {
            let optional = |number: Option<f64>| number.map_or_else(String::new, |number| format!("{number:?}"));
            let exact = &entry.exact;
            let percent = (exact.value > 0.0).then(|| 100.0 * entry.deviation() / exact.value);
            let cells = [
                quoted(&comparison.comparison.name),
                comparison.comparison.light.name().to_owned(),
                quoted(&entry.run),
                quoted(&entry.label),
                format!("{:?}", exact.value),
                format!("{:?}", entry.measured),
                format!("{:?}", entry.standard_error),
                format!("{:?}", entry.deviation()),
                percent.map_or_else(|| "0".to_owned(), |percent| format!("{percent:?}")),
                entry.z().map_or_else(|| "0".to_owned(), |z| format!("{z:?}")),
                format!("{:?}", exact.uncertainty),
                format!("{:?}", exact.discretisation),
                format!("{:?}", exact.truncation),
                optional(entry.beside),
            ];
            text.push_str(&cells.join(","));
            text.push('\n');
        }
    }
    text
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}
