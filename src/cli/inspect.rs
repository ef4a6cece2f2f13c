//! `luxmc inspect`: shows what was read from a scene or a photometric file.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use super::exit::{Exit, Failure};
use super::inspect_photometric::{photometric_json, photometric_text};
use super::memory::{limit_memory, needed_bytes};
use super::number_text::plain;
use super::proportions::warn_of_proportions;
use super::text_table::text_table;
use super::{Outcome, console, values};
use crate::check::{
    InspectedBody, InspectedLuminaire, InspectedReceivers, InspectedSurface, Inspection, MeshCheck, MeshFaults,
    read_and_inspect, skip_checks,
};
use crate::output::{Plot, ResultFile, photometric_plot, scene_plots, write_files};
use crate::scene::photometry::read_photometric_file;
use crate::scene::{Product, allow_large_files};
use crate::solver::Settings;

const EXAMPLES: &str = "\
Examples:
  luxmc inspect office.json             surfaces, luminaires, receivers, totals and warnings
  luxmc inspect office.json --json      the same for programs: metres, m², lm, cd
  luxmc inspect office.json --plots DIR plan and polar diagrams as SVG files
  luxmc inspect downlight.ldt           header, flux, light output ratio, symmetry, beam angles";

/// Arguments of `luxmc inspect`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct InspectArguments {
    /// Scene file (JSON), or a photometric file (.ies or .ldt)
    #[arg(value_name = "SCENE")]
    file: PathBuf,
    /// Print JSON instead of tables
    #[arg(long)]
    json: bool,
    /// Write pictures into this directory: polar diagrams of luminaires, and the plan of a scene (SVG)
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
    /// Read files of any size; without this option, files above 512 MiB (photometric files above 64 MiB) are refused as probable mistakes
    #[arg(long)]
    allow_large: bool,
    /// Checks of meshes to skip, separated by commas: faults, overlaps, advice, insides (then points inside of solids count). The
    /// warnings of the run list the skipped checks
    #[arg(long, value_name = "CHECKS", value_delimiter = ',', value_parser = values::mesh_check)]
    skip_check: Vec<MeshCheck>,
}

/// The description of a scene for programs.
#[derive(Serialize)]
struct Inspected {
    #[serde(flatten)]
    inspection: Inspection,
    /// Approximate bytes of memory of a run for all maps, without cells.
    memory_bytes: u64,
}

/// Shows a scene or a photometric file.
pub fn run(arguments: &InspectArguments) -> Outcome {
    limit_memory(None);
    if arguments.allow_large {
        allow_large_files();
    }
    skip_checks(&arguments.skip_check);
    let text = if is_photometric(&arguments.file) {
        let file = read_photometric_file(&arguments.file)?;
        if let Some(directory) = &arguments.plots {
            let stem = arguments.file.file_stem().unwrap_or_default().to_string_lossy();
            write_plots(directory, &[photometric_plot(&stem, &file.web)])?;
        }
        if arguments.json { as_text(&photometric_json(&file))? } else { photometric_text(&file) }
    } else {
        let (scene, inspection) = read_and_inspect(&arguments.file, warn_of_proportions)?;
        if let Some(directory) = &arguments.plots {
            write_plots(directory, &scene_plots(&scene))?;
        }
        let memory_bytes = needed_bytes(&scene, &Settings::default());
        if arguments.json {
            as_text(&Inspected { inspection, memory_bytes })?
        } else {
            scene_text(&inspection, memory_bytes)
        }
    };
    console::result(&text)?;
    Ok(Exit::Done)
}

fn write_plots(directory: &Path, plots: &[Plot]) -> Result<(), Failure> {
    let files: Vec<ResultFile> = plots.iter().map(Plot::svg_file).collect();
    Ok(write_files(directory, &files)?)
}

/// Serialises directly to text: a tree of JSON values would take many times the memory of its content.
fn as_text(value: &impl Serialize) -> Result<String, Failure> {
    let text = serde_json::to_string_pretty(value).map_err(|error| Failure::StandardOutput(error.into()))?;
    Ok(text + "\n")
}

fn is_photometric(path: &Path) -> bool {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    matches!(extension.as_deref(), Some("ies" | "ldt"))
}

fn scene_text(inspection: &Inspection, memory_bytes: u64) -> String {
    let totals = &inspection.totals;
    let mut text = String::new();
    if !inspection.title.is_empty() {
        text += &format!("{}\n", inspection.title);
    }
    let [low, high] = [inspection.bounds_min_m, inspection.bounds_max_m];
    let closed = if inspection.closed { "closed" } else { "open: light can leave it" };
    text += &format!("from {} to {} m; {closed}\n", place(low), place(high));
    text += &mesh_text(&inspection.mesh);

    text += &format!("\nSurfaces: {}, {} m²\n", totals.surfaces, plain(totals.area_m2, 4));
    text += &surface_table(&inspection.surfaces);
    if !inspection.bodies.is_empty() {
        text += &format!("\nSmooth bodies: {}\n", inspection.bodies.len());
        text += &body_table(&inspection.bodies);
    }

    text += &format!("\nLuminaires: {}, {} lm maintained\n", totals.luminaires, plain(totals.luminous_flux_lm, 5));
    text += &luminaire_table(&inspection.luminaires);
    text += &product_lines(&inspection.luminaires);

    if !inspection.receivers.is_empty() {
        text += &format!("\nReceivers: {} points\n", totals.receiver_points);
        text += &receiver_table(&inspection.receivers);
    }
    text += &format!("\nMaps: {} triangles, {} element sides\n", totals.triangles, totals.element_sides);
    text += &format!(
        "Memory: about {} MB for all maps, and up to an eighth of the machine's, or of --memory-limit, for cells\n",
        plain((memory_bytes as f64 / 1e6).max(1.0), 2)
    );
    for warning in inspection.warnings.iter().filter(|warning| !is_listed_above(warning)) {
        text += &format!("warning: {warning}\n");
    }
    text
}

/// Whether the lines on meshes already report this warning in more detail.
fn is_listed_above(warning: &str) -> bool {
    warning.starts_with("mesh: ") && !warning.contains("solids intersect")
}

fn place([x, y, z]: [f64; 3]) -> String {
    format!("({}, {}, {})", plain(x, 4), plain(y, 4), plain(z, 4))
}

/// Lines on the faults of meshes; empty if there are none.
fn mesh_text(mesh: &MeshFaults) -> String {
    /// Largest number of holes that are listed one by one.
    const MOST_HOLES: usize = 6;
    let mut text = String::new();
    for hole in mesh.holes.iter().take(MOST_HOLES) {
        text += &format!(
            "hole: {} m around, {} edges, between {} and {} m, along {}\n",
            plain(hole.length_m, 4),
            hole.edges,
            place(hole.min_m),
            place(hole.max_m),
            names(&hole.surfaces)
        );
    }
    if mesh.hole_count > MOST_HOLES {
        text += &format!("and {} more holes (see --json)\n", mesh.hole_count - MOST_HOLES);
    }
    for kind in mesh.kinds() {
        if let Some(first) = kind.faults.places_m.first() {
            let surfaces = names(&kind.faults.surfaces);
            text += &format!("{}; the first at {} m, on {surfaces}\n", kind.words(), place(*first));
        }
    }
    if !mesh.t_junctions_searched {
        text += "T-junctions were not searched for: the mesh has too many open edges\n";
    }
    if !mesh.overlaps_searched {
        text += "not all overlaps in one plane were searched for: too many triangles lie in it\n";
    }
    text
}

/// The first few of some names.
fn names(surfaces: &[String]) -> String {
    const FIRST_FEW: usize = 4;
    let more = if surfaces.len() > FIRST_FEW { ", …" } else { "" };
    format!("{}{more}", surfaces[..surfaces.len().min(FIRST_FEW)].join(", "))
}

/// The first rows of a table, and a line with the number of further rows.
fn table_of_first<T>(header: &[&str], left: &[usize], all: &[T], row: impl Fn(&T) -> Vec<String>) -> String {
    /// Largest number of rows that a person would read.
    const MOST_ROWS: usize = 1000;
    let mut text = text_table(header, left, all.iter().take(MOST_ROWS).map(row));
    if all.len() > MOST_ROWS {
        text += &format!("and {} more (see --json)\n", all.len() - MOST_ROWS);
    }
    text
}

fn surface_table(surfaces: &[InspectedSurface]) -> String {
    let row = |surface: &InspectedSurface| {
        vec![
            surface.name.clone(),
            surface.material.clone(),
            surface.sides.join(", "),
            plain(surface.reflectance, 3),
            plain(surface.area_m2, 4),
            surface.triangles.to_string(),
            surface.elements.to_string(),
        ]
    };
    let header = ["name", "material", "sides", "reflectance", "area/m²", "triangles", "elements"];
    table_of_first(&header, &[0, 1, 2], surfaces, row)
}

fn body_table(bodies: &[InspectedBody]) -> String {
    let row = |body: &InspectedBody| {
        let [low_m, high_m] = body.radius_bounds_m;
        vec![
            body.name.clone(),
            body.degree.to_string(),
            body.harmonics.to_string(),
            plain(body.area_m2, 6),
            plain(body.volume_m3, 6),
            format!("{} – {}", plain(low_m, 4), plain(high_m, 4)),
            place(body.center_m),
        ]
    };
    let header = ["name", "degree", "harmonics", "area/m²", "volume/m³", "radius within/m", "centre/m"];
    table_of_first(&header, &[0], bodies, row)
}

fn luminaire_table(luminaires: &[InspectedLuminaire]) -> String {
    let maybe = |number: Option<f64>| number.map_or("-".to_owned(), |number| plain(number, 4));
    let row = |luminaire: &InspectedLuminaire| {
        vec![
            luminaire.name.clone(),
            luminaire.kind.to_owned(),
            place(luminaire.position_m),
            luminaire.aim.map_or("-".to_owned(), place),
            luminaire.c0.map_or("-".to_owned(), place),
            plain(luminaire.luminous_flux_lm, 5),
            maybe(luminaire.intensity_cd),
            maybe(luminaire.exitance_lm_m2),
            plain(luminaire.dimming, 3),
            plain(luminaire.maintenance_factor, 3),
            maybe(luminaire.power_w),
        ]
    };
    let header = [
        "name",
        "type",
        "position/m",
        "aim",
        "C0 towards",
        "flux/lm",
        "I0/cd",
        "M/(lm/m²)",
        "dimming",
        "maintenance",
        "power/W",
    ];
    table_of_first(&header, &[0, 1, 2, 3, 4], luminaires, row)
}

/// Lines on the products whose photometric files the luminaires use; empty if no luminaire has such a file.
fn product_lines(luminaires: &[InspectedLuminaire]) -> String {
    let mut products: Vec<(&Product, &InspectedLuminaire, usize)> = Vec::new();
    for luminaire in luminaires {
        let Some(product) = luminaire.product.as_deref() else { continue };
        match products.iter_mut().find(|(known, _, _)| *known == product) {
            Some((_, _, count)) => *count += 1,
            None => products.push((product, luminaire, 1)),
        }
    }
    let line = |(product, first, count): (&Product, &InspectedLuminaire, usize)| {
        let what = match product.words() {
            words if words.is_empty() => "names neither manufacturer nor catalogue number".to_owned(),
            words => words,
        };
        let opening = first.opening_m.map_or("a point".to_owned(), |[c0_m, c90_m, height_m]| {
            let height = if height_m > 0.0 { format!(", {} m high", plain(height_m, 3)) } else { String::new() };
            format!("opening {} m along C0, {} m along C90{height}", plain(c0_m, 3), plain(c90_m, 3))
        });
        format!("{}: {what}; {opening}; of {count} luminaire{}\n", product.file, if count == 1 { "" } else { "s" })
    };
    products.into_iter().map(line).collect()
}

fn receiver_table(receivers: &[InspectedReceivers]) -> String {
    let pair = |a: Option<String>, b: Option<String>| match (a, b) {
        (Some(a), Some(b)) => format!("{a} x {b}"),
        _ => "-".to_owned(),
    };
    let spacing = |spacing_m: Option<f64>| spacing_m.map(|spacing_m| plain(spacing_m, 3));
    let row = |set: &InspectedReceivers| {
        vec![
            set.name.clone(),
            set.kind.to_owned(),
            pair(set.columns.map(|n| n.to_string()), set.rows.map(|n| n.to_string())),
            pair(spacing(set.column_spacing_m), spacing(set.row_spacing_m)),
            set.points.to_string(),
            set.inside.to_string(),
            set.area_m2.map_or("-".to_owned(), |area_m2| plain(area_m2, 4)),
        ]
    };
    let header = ["name", "type", "columns x rows", "spacing/m", "points", "inside solids", "area/m²"];
    table_of_first(&header, &[0, 1, 2, 3], receivers, row)
}
