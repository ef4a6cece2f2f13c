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
pub use maps::{result_files, streamed_files};
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
