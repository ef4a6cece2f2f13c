//! `luxmc ugr-table`: the UGR ratings of a luminaire in the standard rooms.

use std::path::PathBuf;

use clap::Args;

use super::exit::Exit;
use super::number_text::plain;
use super::text_table::text_table;
use super::values::{self, Reflectances};
use super::{Outcome, console};
use crate::analytic::ugr_table::{spacing_corrections, table_warnings, ugr_table};
use crate::base::glare::rating_text;
use crate::base::standard_rooms::{SpacingCorrection, TABLE_REFLECTANCES, TABLE_SPACING_H, UgrTable, Viewing};
use crate::output::texts::{decimal, say, words};
use crate::output::{
    Language, UgrTableHeading, in_language, photometric_plot, range_text, ugr_table_files, write_files,
};
use crate::scene::photometry::{PhotometricFile, read_photometric_file};

/// Long help text of the command.
pub const ABOUT: &str = "\
UGR table of a luminaire after CIE 190:2010: nineteen rooms of 2H × 2H to 12H × 8H, viewed crosswise and endwise, for
five sets of reflectances, by the standard's formulas. H is 2 m from the eye to the luminaires, which stand 0.25 H
apart as in makers' tables (--spacing 1: as in the standard's own); the background luminance is that of the tabular
method. Ratings hold for the flux and the dimensions of the
file; ratings below 10 are shown as < 10.

Standard output carries the table; --out writes it as ugr-table.csv, ugr-corrections.csv and ugr-table.html.";

const EXAMPLES: &str = "\
Examples:
  luxmc ugr-table downlight.ldt
  luxmc ugr-table panel.ies --reflectances 80/50/20,70/50/20 --out out/panel
  luxmc ugr-table panel.ies --out out/panel --language de
  luxmc ugr-table panel.ies --spacing 1";

/// Arguments of `luxmc ugr-table`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct UgrTableArguments {
    /// Photometric file (.ies or .ldt)
    #[arg(value_name = "LUMINAIRE")]
    file: PathBuf,
    /// Reflectances of ceiling, walls and reference plane in percent, sets separated by commas [default: the five sets of the standard]
    #[arg(long, value_name = "C/W/R,…", value_parser = values::reflectances)]
    reflectances: Option<Reflectances>,
    /// Distance between luminaires over H: 1, or 1 divided by a whole number
    #[arg(long, value_name = "S", default_value_t = TABLE_SPACING_H, allow_negative_numbers = true)]
    spacing: f64,
    /// Write the table into this directory: CSV and HTML
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Language of the page and of the table on the terminal: en or de
    #[arg(long, value_name = "CODE", default_value = "en", value_parser = Language::of_code)]
    language: Language,
}

/// Prints the table, and writes its files if requested.
pub fn run(arguments: &UgrTableArguments) -> Outcome {
    let file = read_photometric_file(&arguments.file)?;
    let sets = arguments.reflectances.as_ref().map_or(TABLE_REFLECTANCES.to_vec(), |Reflectances(sets)| sets.clone());
    let table = ugr_table(&file, &sets, arguments.spacing)?;
    let corrections = spacing_corrections(&file, &table)?;
    let mut warnings = file.warnings.clone();
    warnings.extend(table_warnings(&file));
    for warning in &warnings {
        console::message(&format!("luxmc: warning: {warning}"));
    }
    let stem = arguments.file.file_stem().unwrap_or_default().to_string_lossy();
    let luminaire = name_of(&file, &stem);
    if let Some(directory) = &arguments.out {
        let files = in_language(arguments.language, || {
            let polar = photometric_plot(&luminaire, &file.web).picture;
            let heading =
                UgrTableHeading { luminaire: luminaire.clone(), facts: facts(&file, &table), warnings, polar };
            ugr_table_files(&heading, &table, &corrections)
        });
        write_files(directory, &files?)?;
    }
    console::result(&in_language(arguments.language, || table_text(&luminaire, &file, &table, &corrections)))?;
    Ok(Exit::Done)
}

fn name_of(file: &PhotometricFile, stem: &str) -> String {
    let parts: Vec<&str> = [&file.manufacturer, &file.luminaire]
        .map(|part| part.trim())
        .into_iter()
        .filter(|part| !part.is_empty())
        .collect();
    if parts.is_empty() { stem.to_owned() } else { parts.join(" ") }
}

fn facts(file: &PhotometricFile, table: &UgrTable) -> Vec<(&'static str, String)> {
    let number = |value: f64| decimal(plain(value, 4));
    let extents: Vec<String> = file.opening.extents_m().iter().map(|extent_m| number(*extent_m)).collect();
    let mut facts = vec![
        (words!("Luminous flux"), format!("{} lm", number(file.luminous_flux_lm()))),
        (words!("Luminous opening: along C0, along C90, height"), format!("{} m", extents.join(" × "))),
        (words!("Spacing of luminaires"), format!("{} H", number(table.spacing_h))),
    ];
    if !file.catalog_number.trim().is_empty() {
        facts.push((words!("Catalogue number"), file.catalog_number.trim().to_owned()));
    }
    facts
}

/// The table as text: columns are sets of reflectances; crosswise ratings come first.
fn table_text(luminaire: &str, file: &PhotometricFile, table: &UgrTable, corrections: &[SpacingCorrection]) -> String {
    let sets: Vec<String> =
        table.reflectances.iter().map(|set| set.map(|reflectance| plain(100.0 * reflectance, 3)).join("/")).collect();
    let mut text = say!(
        "UGR of {}, {} lm, luminaires {} H apart (CIE 190:2010)",
        luminaire,
        decimal(plain(file.luminous_flux_lm(), 4)),
        decimal(plain(table.spacing_h, 4))
    ) + "\n";
    for viewing in Viewing::BOTH {
        let mut header = vec!["X", "Y"];
        header.extend(sets.iter().map(String::as_str));
        let rows = table.rooms.iter().map(|room| {
            let mut cells: Vec<String> = room.size_h.map(|side_h| format!("{side_h}H")).to_vec();
            cells.extend((0..sets.len()).map(|place| decimal(rating_text(room.ugr(viewing, place)))));
            cells
        });
        let viewed = match viewing {
            Viewing::Crosswise => say!("viewed crosswise"),
            Viewing::Endwise => say!("viewed endwise"),
        };
        text += &format!("\n{viewed}\n{}", text_table(&header, &[], rows));
    }
    if !corrections.is_empty() {
        let rows = corrections.iter().map(|correction| {
            let mut cells = vec![decimal(format!("{} H", correction.spacing_h)), correction.rooms.len().to_string()];
            cells.extend(Viewing::BOTH.map(|viewing| range_text(correction.range(viewing))));
            cells
        });
        let header = [say!("spacing"), say!("rooms"), say!("crosswise"), say!("endwise")];
        text +=
            &format!("\n{}\n{}", say!("corrections for spacing, least and greatest"), text_table(&header, &[], rows));
    }
    text
}
