//! All plots of a run.

use std::collections::HashSet;
use std::sync::Arc;

use rayon::prelude::*;

use super::convergence_plot::convergence_picture;
use super::daylight_factors::daylight_factors;
use super::daylight_plot::{daylight_picture, sky_component_map, sky_component_picture};
use super::flat::{FlatMap, RowsOfSides, grid_map, surface_maps};
use super::halves_plot::{deviations, difference_picture, histogram_picture};
use super::leaving_light::leaving_light;
use super::luminance_plot::luminance_picture;
use super::map_plot::{map_picture, value_chart};
use super::numbers::{percent, ratio};
use super::observers::maps_of;
use super::picture::Picture;
use super::plan::plan_picture;
use super::polar_plot::{INITIAL, LEAVING, polar_picture};
use super::schedule::Schedule;
use super::texts::{in_language, language, say};
use super::{ResultFile, StreamedFile, file_name_part, raster};
use crate::maps::MapKind;
use crate::scene::photometry::IntensityWeb;
use crate::scene::{Emission, Quantity, Scene};
use crate::solver::Solution;

/// Largest number of surfaces that are plotted: those with the most elements, if there are more.
pub const MOST_SURFACES: usize = 200;
/// Largest number of receiver sets that are all plotted and written as grids, and the number of the first ones otherwise. Nobody
/// reads more pages. A page takes as long to write as fifty rows of a table, and a time limit waits for neither.
const MOST_SETS_PLOTTED: usize = 200;
const SETS_OF_MANY: usize = 50;

/// A surface side with a larger stated error is not plotted: its colours would show noise.
const MOST_ERROR_SHOWN: f64 = 0.3;

/// The content of a plot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlotKind {
    /// False colours and isolux lines of a grid.
    Grid,
    /// Luminance in false colours, or over the angle of a fan.
    Luminance,
    /// Intensity of the light that leaves the scene.
    Intensity,
    /// Values of a grid as numbers.
    Values,
    /// False colours and lines of daylight factors of a grid.
    Daylight,
    /// False colours and lines of the sky component on a grid.
    SkyComponent,
    /// Differences between the two halves of a grid.
    Halves,
    /// Histogram of these differences.
    HalvesHistogram,
    /// False colours and isolux lines of a surface side with this many elements.
    Surface(usize),
    /// Error against time.
    Convergence,
    /// The scene from above.
    Plan,
    /// Intensity of a luminaire.
    Luminaire,
}

/// A plot, its content and its file name.
#[derive(Clone, Debug)]
pub struct Plot {
    /// File name without its ending.
    pub stem: String,
    /// Content.
    pub kind: PlotKind,
    /// Name of the grid, surface or luminaire; empty for the run itself.
    pub subject: String,
    /// The picture.
    pub picture: Picture,
}

impl Plot {
    /// The plot as an SVG file, which is made when it is written.
    pub fn svg(&self) -> StreamedFile<'_> {
        StreamedFile::later(format!("{}.svg", self.stem), || self.svg_file())
    }

    /// The plot as a PNG file, which is made when it is written.
    pub fn png(&self) -> StreamedFile<'_> {
        StreamedFile::later(format!("{}.png", self.stem), || self.png_file())
    }

    /// The plot as an SVG file.
    pub fn svg_file(&self) -> ResultFile {
        ResultFile { name: format!("{}.svg", self.stem), bytes: self.picture.svg().into_bytes() }
    }

    /// The plot as a PNG file.
    pub fn png_file(&self) -> ResultFile {
        ResultFile { name: format!("{}.png", self.stem), bytes: raster::png(&self.picture) }
    }
}

/// Number of the first receiver sets that are plotted and written as grids; the tables have all.
pub fn plotted_sets(sets: usize) -> usize {
    if sets <= MOST_SETS_PLOTTED { sets } else { SETS_OF_MANY }
}

/// All plots of a run: grids with their value charts, the flat surfaces that light reaches, the error against time, and the
/// distinct photometric luminaires.
pub fn plots(scene: &Scene, solution: &Solution) -> Vec<Plot> {
    let note = maintenance_note(scene);
    let mut stems = Stems::default();
    let mut plots = Vec::new();
    let mut has_halves = false;
    let factors = daylight_factors(scene, solution);
    let most_sets = plotted_sets(solution.maps.iter().filter(|map| map.kind != MapKind::Elements).count());
    let mut sets = 0;
    for map in &solution.maps {
        if let Some(flat) = grid_map(scene, map).filter(|_| sets < most_sets) {
            sets += 1;
            let mut add = |stem: String, kind: PlotKind, picture: Picture| {
                plots.push(Plot { stem: stems.fresh(&stem), kind, subject: map.name.clone(), picture });
            };
            let name = file_name_part(&map.name);
            add(format!("map-{name}"), PlotKind::Grid, map_picture(&flat, &note));
            add(format!("map-{name}-values"), PlotKind::Values, value_chart(&flat, &note));
            if let Some(factors) = factors.iter().find(|factors| factors.name == map.name) {
                add(format!("map-{name}-daylight"), PlotKind::Daylight, daylight_picture(&flat, factors, &note));
                let skies = sky_component_map(map, factors.outside_lx);
                if let (Some(skies), Some(means)) = (&skies, &factors.components)
                    && let Some(flat) = grid_map(scene, skies)
                {
                    let named: Vec<_> = ["SC", "ERC", "IRC"].into_iter().zip(means.percents).collect();
                    let picture = sky_component_picture(&flat, &named, &note);
                    add(format!("map-{name}-sky-component"), PlotKind::SkyComponent, picture);
                }
            }
            // Only the first set's halves are plotted: the others show nothing more.
            let deviations = deviations(map);
            if !has_halves && deviations.iter().any(Option::is_some) {
                has_halves = true;
                add(format!("halves-{name}"), PlotKind::Halves, difference_picture(flat, &deviations, &note));
                if let Some(picture) = histogram_picture(&map.name, &deviations) {
                    add(format!("halves-{name}-histogram"), PlotKind::HalvesHistogram, picture);
                }
            }
        }
    }
    for (map, set) in maps_of(scene, solution, |quantity| quantity == Quantity::Luminance).into_iter().take(most_sets) {
        if let Some(picture) = luminance_picture(&scene.receivers[set], map, &note) {
            let stem = stems.fresh(&format!("map-{}", file_name_part(&map.name)));
            plots.push(Plot { stem, kind: PlotKind::Luminance, subject: map.name.clone(), picture });
        }
    }
    for light in leaving_light(scene, solution).into_iter().take(most_sets) {
        plots.push(Plot {
            stem: stems.fresh(&format!("intensity-{}", file_name_part(&light.map.name))),
            kind: PlotKind::Intensity,
            subject: light.map.name.clone(),
            picture: polar_picture(&light.map.name, &light.web, LEAVING),
        });
    }
    // A map below its own error, or nearly so, makes no useful picture.
    let is_shown = |flat: &FlatMap| flat.row.average.is_known() && flat.estimated_error <= MOST_ERROR_SHOWN;
    let is_bound = solution.maps.iter().any(|map| map.kind == MapKind::Elements && map.bound);
    let unbound =
        if is_bound || solution.target_error.is_none() { "" } else { say!("The target does not apply to this map. ") };
    let surface_note = format!("{unbound}{note}");
    for flat in flat_surfaces(scene, solution).into_iter().filter(is_shown) {
        let back = if flat.row.side == "back" { "-back" } else { "" };
        plots.push(Plot {
            stem: stems.fresh(&format!("map-{}{back}", file_name_part(&flat.row.name))),
            kind: PlotKind::Surface(flat.cells.len()),
            subject: flat.row.name.clone(),
            picture: map_picture(&flat, &surface_note),
        });
    }
    plots.push(Plot {
        stem: "convergence".to_owned(),
        kind: PlotKind::Convergence,
        subject: String::new(),
        picture: convergence_picture(solution),
    });
    for (name, web) in distinct_webs(scene) {
        plots.push(luminaire_plot(name, web, &mut stems));
    }
    plots
}

/// The plots of a scene before it is solved: its plan and its luminaires' polar diagrams.
pub fn scene_plots(scene: &Scene) -> Vec<Plot> {
    let plan = Plot {
        stem: "plan".to_owned(),
        kind: PlotKind::Plan,
        subject: String::new(),
        picture: plan_picture(scene, &Schedule::of(scene)),
    };
    let mut stems = Stems::default();
    let luminaires = distinct_webs(scene).into_iter().map(|(name, web)| luminaire_plot(name, web, &mut stems));
    std::iter::once(plan).chain(luminaires).collect()
}

/// The polar diagram of one photometric file.
pub fn photometric_plot(name: &str, web: &IntensityWeb) -> Plot {
    luminaire_plot(name, web, &mut Stems::default())
}

fn luminaire_plot(name: &str, web: &IntensityWeb, stems: &mut Stems) -> Plot {
    Plot {
        stem: stems.fresh(&format!("luminaire-{}", file_name_part(name))),
        kind: PlotKind::Luminaire,
        subject: name.to_owned(),
        picture: polar_picture(name, web, INITIAL),
    }
}

fn flat_surfaces<'a>(scene: &Scene, solution: &'a Solution) -> Vec<FlatMap<'a>> {
    let Some(map) = solution.maps.iter().find(|map| map.kind == MapKind::Elements) else { return Vec::new() };
    let (elements, rows) = (&solution.elements, RowsOfSides::of(map));
    let is_reported = |surface: &u32| scene.is_reported(&scene.surfaces[*surface as usize].name);
    let mut surfaces: Vec<u32> = (0..scene.surfaces.len() as u32).filter(is_reported).collect();
    surfaces.sort_by_key(|surface| std::cmp::Reverse(elements.of_surface(scene, *surface).len()));
    let spoken = language();
    let maps_of = |surface: &u32| in_language(spoken, || surface_maps(scene, elements, (map, &rows), *surface));
    let mut chosen: Vec<(u32, Vec<FlatMap>)> = Vec::new();
    for some in surfaces.chunks(MOST_SURFACES) {
        let maps: Vec<Vec<FlatMap>> = some.par_iter().with_max_len(1).map(maps_of).collect();
        chosen.extend(some.iter().copied().zip(maps).filter(|(_, maps)| !maps.is_empty()));
        if chosen.len() >= MOST_SURFACES {
            break;
        }
    }
    chosen.truncate(MOST_SURFACES);
    chosen.sort_by_key(|(surface, _)| *surface);
    chosen.into_iter().flat_map(|(_, maps)| maps).collect()
}

/// The photometric distributions of a scene, each once, with the name of the first luminaire that has it.
pub fn distinct_webs(scene: &Scene) -> Vec<(&str, &IntensityWeb)> {
    let mut webs: Vec<(&str, &Arc<IntensityWeb>)> = Vec::new();
    for luminaire in &scene.luminaires {
        if let Emission::Photometric { web, .. } = &luminaire.emission
            && !webs.iter().any(|(_, known)| Arc::ptr_eq(known, web) || *known == web)
        {
            webs.push((&luminaire.name, web));
        }
    }
    webs.into_iter().map(|(name, web)| (name, web.as_ref())).collect()
}

/// The note on maintenance and dimming for plots and pages.
pub fn maintenance_note(scene: &Scene) -> String {
    let span = |of: &dyn Fn(usize) -> f64| {
        let numbers = (0..scene.luminaires.len()).map(of);
        numbers.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
    };
    let (low, high) = span(&|index| scene.luminaires[index].maintenance_factor);
    let maintenance = if low == 1.0 {
        say!("Values of a new installation: maintenance factor 1.00").to_owned()
    } else if low == high {
        say!("Maintained values: maintenance factor {}", ratio(low))
    } else {
        say!("Maintained values: maintenance factors from {} to {}", ratio(low), ratio(high))
    };
    let (low, high) = span(&|index| scene.luminaires[index].dimming);
    let dimming = if low == 1.0 {
        say!("undimmed").to_owned()
    } else if low == high {
        say!("dimmed to {}", percent(low))
    } else {
        say!("dimmed to between {} and {}", percent(low), percent(high))
    };
    format!("{maintenance}, {dimming}.")
}

/// File names that are in use.
#[derive(Default)]
pub(super) struct Stems(HashSet<String>);

impl Stems {
    /// A name that no other file has: the wanted one, or the same with a number after it.
    pub fn fresh(&mut self, wanted: &str) -> String {
        let mut stem = wanted.to_owned();
        let mut number = 2;
        // Some file systems ignore the case of letters.
        while !self.0.insert(stem.to_lowercase()) {
            stem = format!("{wanted}-{number}");
            number += 1;
        }
        stem
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_very_many_sets_a_few_are_plotted() {
        assert_eq!([0, 1, 200, 201, 10_000].map(plotted_sets), [0, 1, 200, 50, 50]);
    }
}
