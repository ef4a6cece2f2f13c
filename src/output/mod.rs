//! The results of a run: files as bytes, and the directory that receives all of them or none.

pub mod axes;
mod checkpoint_file;
pub mod color;
mod contour;
mod convergence_plot;
pub mod date;
mod daylight;
mod daylight_factors;
mod daylight_plot;
mod directory;
mod energy;
mod error;
mod flat;
pub mod font;
mod glare_plot;
mod glb;
mod halves_plot;
pub mod html;
mod intensity;
mod leaving_light;
mod lines;
mod luminance_plot;
mod map_plot;
mod map_words;
mod maps;
pub mod numbers;
mod observers;
mod pdf;
mod photometric_writer;
pub mod picture;
mod plan;
mod plots;
mod polar_plot;
mod radiance_grids;
mod raster;
mod report;
mod report_observers;
mod report_words;
mod scale;
mod schedule;
mod sealed;
mod share_file;
mod sheet;
mod streamed;
mod summary;
pub mod texts;
mod ugr_table;
mod verdicts;
mod view;
mod view_columns;
mod vtk;
mod year;
mod year_plot;
mod zlib;

pub use checkpoint_file::{CheckpointFile, CheckpointHeader, prove_checkpoint, read_checkpoint, write_checkpoint};
pub use daylight_factors::daylight_factors;
pub use directory::{ResultDirectory, StagedFiles, remove_unfinished_results, write_files};
pub use error::OutputError;
pub use glb::glb_file;
pub use leaving_light::{LeavingLight, leaving_light};
pub use plots::{MOST_SURFACES, Plot, PlotKind, photometric_plot, plots, plotted_sets, scene_plots};
pub use report::{ReportContext, report_files};
pub use report_observers::observer_words;
pub use sealed::SealedError;
pub use share_file::{SHARE_FILE, ShareFile, ShareHeader, read_share, share_file};
pub use sheet::shortest;
pub use streamed::StreamedFile;
pub use summary::{PartOfRun, RunRecord, summary_file};
pub use texts::{Language, in_language};
pub use ugr_table::{UgrTableHeading, range_text, ugr_table_files};
pub use verdicts::{finding_words, requirement_words};
pub use vtk::vtk_file;
pub use year::{AUTONOMY_WANTED, HourlyFiles, sunlight_file, year_rows, year_summary, year_tables};
pub use year_plot::year_plots;

use crate::scene::Scene;
use crate::solver::Solution;

/// Makes files of a run's results: none if the results have nothing for them.
///
/// # Errors
///
/// A number that is not finite; no table may hold one.
type FilesOfRun = for<'a> fn(&'a Scene, &'a Solution) -> Result<Vec<StreamedFile<'a>>, OutputError>;

/// The tables of a run, in the order in which they are written: names, and the function that makes them.
///
/// Only `convergence.csv` contains times, so that equal maps give equal bytes in all other tables.
const TABLES: [(&[&str], FilesOfRun); 9] = [
    (&[maps::ELEMENTS], maps::element_file),
    (&[maps::RECEIVERS], maps::receiver_file),
    (&[radiance_grids::GRIDS_INFO], radiance_grids::grid_files),
    (&["daylight.csv"], daylight::daylight_file),
    (&[observers::LUMINANCES, "ugr.csv"], observers::observer_files),
    (&["intensity.csv"], intensity::intensity_files),
    (&["tables.csv"], maps::table_file),
    (&["verdicts.csv"], verdicts::verdict_file),
    (&["convergence.csv"], maps::convergence_file),
];

/// Names of other result files: plots, models, reports, shares, and tables of a year.
const OTHER_NAMES: [&str; 10] = [
    "convergence.svg",
    "convergence.png",
    "scene.vtp",
    "scene.glb",
    "share.luxmc",
    "report.html",
    "report.pdf",
    "year.csv",
    "year-points.csv",
    "year-hours.csv",
];

/// Beginnings and ends of the names of files of which there may be several: plots, sensor grids, hours of a year, distributions of intensity.
/// A part made by [`file_name_part`] stands between them.
const SERIES: [(&str, &[&str]); 7] = [
    ("map-", &[".svg", ".png"]),
    ("halves-", &[".svg", ".png"]),
    ("luminaire-", &[".svg", ".png"]),
    ("year-", &[".svg", ".png"]),
    ("grid-", &[".pts", ".res"]),
    ("hourly-", &[".csv"]),
    ("intensity-", &[".ies", ".ldt"]),
];

/// Fixed names of result files. Those of [`SERIES`] come in addition.
fn fixed_names() -> impl Iterator<Item = &'static str> {
    TABLES.iter().flat_map(|(names, _)| *names).copied().chain(OTHER_NAMES)
}

/// All tables of a run for which there is a map: a map that was not requested has no file.
///
/// # Errors
///
/// A number that is not finite; no table may hold one.
pub fn result_files(scene: &Scene, solution: &Solution) -> Result<Vec<ResultFile>, OutputError> {
    streamed_files(scene, solution)?.into_iter().map(StreamedFile::made).collect()
}

/// The same. Files whose length grows with a map are made while they are written.
///
/// # Errors
///
/// A number that is not finite.
pub fn streamed_files<'a>(scene: &'a Scene, solution: &'a Solution) -> Result<Vec<StreamedFile<'a>>, OutputError> {
    let made: Vec<Vec<StreamedFile>> =
        TABLES.iter().map(|(_, make)| make(scene, solution)).collect::<Result<_, OutputError>>()?;
    Ok(made.into_iter().flatten().collect())
}

/// A result file before it is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ResultFile {
    /// Plain file name.
    pub name: String,
    /// Its whole content.
    pub bytes: Vec<u8>,
}

/// Turns a name of the scene into a part of a file name: any character outside `A–Z a–z 0–9 _ -` becomes `-`.
pub fn file_name_part(name: &str) -> String {
    let allowed = |letter: &char| letter.is_ascii_alphanumeric() || "_-".contains(*letter);
    name.chars().map(|letter| if allowed(&letter) { letter } else { '-' }).collect()
}

#[cfg(test)]
mod tests {
    use super::file_name_part;

    #[test]
    fn only_plain_letters_get_into_file_names() {
        assert_eq!(file_name_part("work plane/0.8 m_A-1"), "work-plane-0-8-m_A-1");
        assert_eq!(file_name_part("../Büro"), "---B-ro");
    }
}
