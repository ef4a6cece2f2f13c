//! The results of a run: stages files in one order, and reports on the terminal.

use std::path::Path;

use super::console;
use super::exit::{Exit, Failure};
use super::method::Plots;
use super::number_text::{percent, significant, time};
use super::result_table::result_table;
use crate::maps::{MapKind, TableKind, TableRow};
use crate::output::{
    Language, ReportContext, ResultDirectory, StagedFiles, StreamedFile, glb_file, in_language, plots, plotted_sets,
    report_files, streamed_files, vtk_file,
};
use crate::scene::Scene;
use crate::solver::{Solution, StopReason};

/// Stages tables, plots, the report with the plots, and the elements for ParaView and glTF viewers.
pub fn stage_results(
    scene: &Scene,
    solution: &Solution,
    context: &ReportContext,
    formats: Option<Plots>,
    directory: &mut ResultDirectory,
) -> Result<(), Failure> {
    let tables = streamed_files(scene, solution)?;
    let models: Vec<StreamedFile> =
        [vtk_file(scene, solution), glb_file(scene, solution)].into_iter().flatten().collect();
    let to = &*directory;
    let drawing = || {
        let formats = formats.unwrap_or(Plots { svg: true, png: false });
        write_pages(scene, solution, context, formats, to)
    };
    let (tables, (models, pages)) =
        rayon::join(|| to.written(&tables), || rayon::join(|| to.written(&models), drawing));
    for files in [tables?, pages?, models?] {
        directory.take(files);
    }
    Ok(())
}

/// Writes plots, and the report that shows them.
fn write_pages(
    scene: &Scene,
    solution: &Solution,
    context: &ReportContext,
    formats: Plots,
    directory: &ResultDirectory,
) -> Result<StagedFiles, Failure> {
    let drawn = match formats.any() {
        true => in_language(context.language, || plots(scene, solution)),
        false => Vec::new(),
    };
    let mut files: Vec<StreamedFile> = Vec::new();
    for plot in &drawn {
        files.extend(formats.svg.then(|| plot.svg()));
        files.extend(formats.png.then(|| plot.png()));
    }
    let (page, pdf) = report_files(scene, solution, &drawn, context);
    files.push(page.into());
    match pdf {
        Some(pdf) => files.push(pdf.into()),
        None => console::message(
            "warning: report.pdf is left out, since its text cannot be laid out; report.html has all of it",
        ),
    }
    Ok(directory.written(&files)?)
}

/// Prints the table in a language, the surfaces hidden by contact, and the warnings.
pub fn tell_results(
    scene: &Scene,
    solution: &Solution,
    language: Language,
    tell: impl Fn(&str),
) -> Result<(), Failure> {
    console::result(&in_language(language, || result_table(scene, solution)))?;
    if let Some(line) = covered_line(scene, solution) {
        tell(&line);
    }
    if let Some(line) = unreported_line(scene, solution) {
        tell(&line);
    }
    if let Some(line) = unplotted_line(solution) {
        tell(&line);
    }
    for warning in &solution.warnings {
        console::message(&format!("warning: {warning}"));
    }
    Ok(())
}

/// A file name quoted for a shell.
pub fn quoted(name: &Path) -> String {
    let text = name.display().to_string();
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "._-/,".contains(letter);
    if !text.is_empty() && text.chars().all(is_plain) { text } else { format!("'{}'", text.replace('\'', "'\\''")) }
}

/// A count with its noun: `1 thread`, `2 threads`.
pub fn counted(count: usize, thing: &str) -> String {
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}

/// How the run ended, where its flux went, and where the results are.
pub fn closing_lines(solution: &Solution, directory: &str, wall_s: f64) -> String {
    let stated = solution.stated_error().map_or(String::new(), |error| format!("; stated error {}", percent(error)));
    let end = match (solution.stop_reason, solution.target_met) {
        (StopReason::Exact, _) => "exact: no random error",
        (StopReason::Interrupted, _) => "interrupted",
        (StopReason::VerdictsDecided, _) => "verdicts decided",
        (StopReason::Undecided, _) => {
            "verdicts undecided: values are closer to their limits than the smallest error can resolve \
             (--target-error sets it)"
        }
        (_, Some(true)) => "target met",
        (StopReason::FinestMesh, Some(false)) => "target not met by the finest mesh",
        (StopReason::FinestMesh, None) => "finest mesh reached",
        (StopReason::Chains, Some(false)) if solution.is_unlit() => {
            "target not met: no light was found in a map that it binds"
        }
        (StopReason::Shares, Some(false)) => "target not met by these shares",
        (StopReason::Shares, None) => "shares merged",
        (StopReason::TimeLimit, Some(false)) => "target not met: the time limit came first",
        (_, Some(false)) => "target not met: the chains are used up",
        (StopReason::TimeLimit, None) => "time limit reached",
        (_, None) => "chains done",
    };
    let why = solution.why_unmet().map_or(String::new(), |why| format!(": {why}"));
    let balance = match &solution.flux_balance {
        Ok(balance) => format!(
            "flux: {} lm emitted = {} absorbed + {} escaped + {} on back faces + {} truncated",
            significant(balance.emitted_lm, 5),
            significant(balance.absorbed_lm, 5),
            significant(balance.escaped_lm, 5),
            significant(balance.back_face_lm, 5),
            significant(balance.truncated_lm, 5)
        ),
        Err(note) => format!("flux: no balance, since {note}"),
    };
    let unbound: Vec<String> = solution
        .maps
        .iter()
        .filter(|map| !map.bound && solution.target_error.is_some_and(|target| map.error.estimated > target))
        .map(|map| format!("{} {}", map.name, percent(map.error.estimated)))
        .collect();
    let unbound = if unbound.is_empty() {
        String::new()
    } else {
        format!("\nnot bound by the target: {} (--maps all binds every map)", unbound.join(", "))
    };
    let chains = if solution.chains > 0 { format!(" after {} chains", solution.chains) } else { String::new() };
    format!("{end}{stated}{chains} in {}{why}{unbound}\n{balance}\nresults in {directory}", time(wall_s))
}

/// The note on surfaces that are partly hidden by contact.
fn covered_line(scene: &Scene, solution: &Solution) -> Option<String> {
    /// Largest number of names; more would not help.
    const MOST_COVERED: usize = 8;
    let rows = solution.maps.iter().flat_map(|map| &map.tables);
    let mut rows: Vec<&TableRow> =
        rows.filter(|row| row.covered_area_m2 > 0.0 && scene.is_reported(&row.name)).collect();
    rows.sort_by(|one, other| other.covered_area_m2.total_cmp(&one.covered_area_m2));
    let parts: Vec<String> = rows
        .iter()
        .take(MOST_COVERED)
        .map(|row| format!("{} {} m²", row.name, significant(row.covered_area_m2, 2)))
        .collect();
    let more =
        if rows.len() > MOST_COVERED { format!(" and of {} more", rows.len() - MOST_COVERED) } else { String::new() };
    (!rows.is_empty()).then(|| format!("note: hidden by contact, and not in these tables: {}{more}", parts.join(", ")))
}

/// The note on surfaces that are listed in files only.
fn unreported_line(scene: &Scene, solution: &Solution) -> Option<String> {
    let rows = solution.maps.iter().flat_map(|map| &map.tables);
    let count = rows.filter(|row| row.kind == TableKind::Surface && !scene.is_reported(&row.name)).count();
    (count > 0).then(|| {
        format!(
            "note: only in tables.csv, and not in this table: {} of luminaires or with \"report\": false",
            counted(count, "surface")
        )
    })
}

/// The note if there are more receiver sets than are plotted.
fn unplotted_line(solution: &Solution) -> Option<String> {
    let sets = solution.maps.iter().filter(|map| map.kind != MapKind::Elements).count();
    let plotted = plotted_sets(sets);
    (sets > plotted).then(|| {
        format!(
            "note: plots and sensor grids show the first {plotted} of {sets} receiver sets; tables and \
             receivers.csv contain all"
        )
    })
}

/// The exit code for a solution.
pub fn exit_of(solution: &Solution) -> Exit {
    match (solution.stop_reason, solution.target_met) {
        (StopReason::Interrupted, _) => Exit::Interrupted,
        (_, Some(false)) => Exit::TargetMissed,
        _ => Exit::Done,
    }
}
