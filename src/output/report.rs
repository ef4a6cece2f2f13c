//! `report.html`: the run as one page for a client.

mod first_page;
mod luminaires;
mod method;

use std::collections::HashMap;

use super::daylight::daylight_table;
use super::html::{HtmlTable, figure, terms, with_error};
use super::lines::line_item;
use super::numbers::{UNKNOWN, lux_with_error, percent, ratio, uniformity_with_error};
use super::pdf::{About, pdf};
use super::picture::escaped;
use super::plots::{Plot, PlotKind, maintenance_note};
use super::report_observers::observer_tables;
use super::report_words::explanations;
use super::schedule::Schedule;
use super::texts::{Language, in_language, said, say};
use super::view::view_section;
use super::{ResultFile, date::utc_date};
use crate::check::{InspectedSurface, inspect_surfaces};
use crate::maps::{Estimate, TableKind, TableRow};
use crate::scene::{Quantity, Scene};
use crate::solver::Solution;

pub(super) const STYLE: &str = include_str!("report.css");
/// Largest number of surface plots in a report.
const MOST_SURFACE_PLOTS: usize = 8;
/// Smallest number of elements of a plotted surface side; fewer show next to nothing.
const FEWEST_ELEMENTS: usize = 32;
/// If there are many surfaces, those below this share of the total area are listed in `tables.csv` only.
const SMALL_SHARE: f64 = 0.005;
/// Largest number of receiver sets that a report lists. A page cannot usefully show thousands, and the layout of a PDF of them
/// takes seconds.
const MOST_SETS_LISTED: usize = 200;
/// Up to this many surfaces, all are listed.
const FEW_SURFACES: usize = 16;

/// Facts on a run for its report that are neither in the scene nor in the solution.
#[derive(Clone, Debug)]
pub struct ReportContext {
    /// Scene file as the user named it.
    pub scene: String,
    /// The command that reproduces this report.
    pub command: String,
    /// Whether that command reproduces every digit, since it fixes the chains.
    pub repeats_digits: bool,
    /// Seconds since 1970 at which the run ended, UTC.
    pub unix_time_s: u64,
    /// Seconds from process start to the end of computing.
    pub wall_s: f64,
    /// Worker threads.
    pub threads: usize,
    /// Language of the page. Plots are in the language in which they were [drawn](in_language).
    pub language: Language,
}

/// The report of a run: the illuminances and luminances, the luminaires, the errors, and the command that reproduces it. Returns a
/// page for browsers, and a PDF on A4 pages; `None` if the markup cannot be laid out.
pub fn report_files(
    scene: &Scene,
    solution: &Solution,
    plots: &[Plot],
    context: &ReportContext,
) -> (ResultFile, Option<ResultFile>) {
    let report = Report { scene, solution, plots, context, schedule: Schedule::of(scene) };
    let about = About {
        title: report.title(),
        author: &scene.project.author,
        language: context.language.code(),
        unix_time_s: context.unix_time_s,
    };
    in_language(context.language, || {
        let body = report.body();
        let page = ResultFile { name: "report.html".to_owned(), bytes: report.page(&body).into_bytes() };
        let pdf = pdf(&body.concat(), &about).map(|bytes| ResultFile { name: "report.pdf".to_owned(), bytes });
        (page, pdf)
    })
}

struct Report<'a> {
    scene: &'a Scene,
    solution: &'a Solution,
    plots: &'a [Plot],
    context: &'a ReportContext,
    schedule: Schedule,
}

impl Report<'_> {
    /// The page for browsers, whose body has a view that the PDF lacks.
    fn page(&self, [above, below]: &[String; 2]) -> String {
        let view = if self.plots.is_empty() { String::new() } else { view_section(self.scene, self.solution) };
        format!("{}<body>\n{above}{view}{below}</body>\n</html>\n", self.head())
    }

    /// The content above the view in space, and below it.
    fn body(&self) -> [String; 2] {
        let above = self.first_page() + &self.luminaires() + &self.warnings() + &self.results();
        let mut page = self.map_figures();
        page += &self.surfaces();
        page += &self.method();
        page += &self.evidence();
        page += &format!(
            "<div class=\"together\">\n<h2>{}</h2>\n{}</div>\n",
            say!("What the words mean"),
            terms("words", &explanations())
        );
        page += &format!(
            "<footer>luxmc {}; {}. {}</footer>\n",
            env!("CARGO_PKG_VERSION"),
            utc_date(self.context.unix_time_s),
            say!("All lengths in metres.")
        );
        [above, page]
    }

    fn rows(&self, is_wanted: impl Fn(TableKind) -> bool) -> Vec<&TableRow> {
        self.solution.maps.iter().flat_map(|map| &map.tables).filter(|row| is_wanted(row.kind)).collect()
    }

    fn warnings(&self) -> String {
        let warnings = self.scene.warnings.iter().chain(&self.solution.warnings);
        let items: String = warnings.map(|line| line_item(line)).collect();
        if items.is_empty() {
            return items;
        }
        format!("<div class=\"warning\">\n<p><b>{}</b></p>\n<ul>\n{items}</ul>\n</div>\n", say!("Please note"))
    }

    fn results(&self) -> String {
        let rows = self.rows(|kind| matches!(kind, TableKind::Grid | TableKind::Points));
        if rows.is_empty() {
            return self.observers();
        }
        let mut table = result_table();
        let sets = self.scene.receivers.iter().rev();
        let quantities: HashMap<&str, Quantity> = sets.map(|set| (set.name.as_str(), set.quantity)).collect();
        for row in rows.iter().take(MOST_SETS_LISTED) {
            let kind = match quantities.get(row.name.as_str()).copied() {
                None | Some(Quantity::Perpendicular) => String::new(),
                Some(quantity) => format!(" ({})", said(quantity.name())),
            };
            table.row(result_cells(row, format!("{}{kind}", escaped(&row.name))));
        }
        let rest = match rows.len().saturating_sub(MOST_SETS_LISTED) {
            0 => String::new(),
            n => format!(
                "<p class=\"soft small\">{}</p>\n",
                say!("Not listed: {} more receiver sets; tables.csv contains all.", n)
            ),
        };
        format!(
            "<h2>{}</h2>\n{}{rest}<p class=\"soft small\">{} {}</p>\n",
            say!("Results"),
            table.markup(),
            say!(
                "Each ± is one standard error: the exact value lies within it in two cases of three, and within \
                 twice of it in nineteen of twenty."
            ),
            escaped(&maintenance_note(self.scene))
        ) + &self.observers()
    }

    /// The section for observers: daylight factors, luminances and glare ratings.
    fn observers(&self) -> String {
        daylight_table(self.scene, self.solution) + &observer_tables(self.scene, self.solution)
    }

    fn map_figures(&self) -> String {
        let mut page = String::new();
        for plot in self.plots {
            match plot.kind {
                PlotKind::Grid => {
                    page += &format!("<h2 class=\"page\">{}</h2>\n", escaped(&plot.subject));
                    page += &figure(
                        &plot.picture,
                        say!("Colours show every point's own value; lines join equal illuminance."),
                    );
                }
                PlotKind::Luminance => {
                    page += &format!("<h2 class=\"page\">{}</h2>\n", escaped(&plot.subject));
                    page += &figure(&plot.picture, say!("What an eye sees there, in cd/m² on a logarithmic scale."));
                }
                PlotKind::Intensity => {
                    page += &format!("<h2 class=\"page\">{}</h2>\n", escaped(&plot.subject));
                    page += &figure(
                        &plot.picture,
                        say!(
                            "Luminous intensity of all light that leaves the scene, as seen from afar; the IES and LDT files beside this page contain the same data."
                        ),
                    );
                }
                PlotKind::Values => page += &figure(&plot.picture, ""),
                PlotKind::Daylight => {
                    let words = say!(
                        "Illuminance divided by that of an open horizontal plane under the same sky; lines at 0.5, 1, 2, 3, 5 and 10 %."
                    );
                    page += &figure(&plot.picture, words);
                }
                PlotKind::SkyComponent => {
                    let words = say!(
                        "The part that comes straight from the sky (SC). With the parts reflected outside (ERC) and inside (IRC) it makes up the daylight factor."
                    );
                    page += &figure(&plot.picture, words);
                }
                _ => {}
            }
        }
        page
    }

    fn surfaces(&self) -> String {
        let rows = self.rows(|kind| kind == TableKind::Surface);
        let mut surfaces = inspect_surfaces(self.scene);
        let all = surfaces.len();
        surfaces.retain(|surface| self.scene.is_reported(&surface.name));
        let all_m2: f64 = surfaces.iter().map(|surface| surface.area_m2).sum();
        let is_listed =
            |surface: &InspectedSurface| surfaces.len() <= FEW_SURFACES || surface.area_m2 >= SMALL_SHARE * all_m2;
        let listed: HashMap<&str, Vec<&TableRow>> = surfaces
            .iter()
            .filter(|surface| is_listed(surface))
            .map(|surface| (surface.name.as_str(), Vec::new()))
            .collect();
        let listed = rows.iter().filter(|row| row.shows()).fold(listed, |mut listed, row| {
            if let Some(of_surface) = listed.get_mut(row.name.as_str()) {
                of_surface.push(row);
            }
            listed
        });
        let mut head = vec![
            (say!("Surface"), true),
            (say!("Material"), true),
            (say!("Reflec-<br>tance"), false),
            (say!("Area<small>m²</small>"), false),
        ];
        let light = [
            ("Ē<small>lx</small>", false),
            ("E<sub>min</sub><small>lx</small>", false),
            ("E<sub>max</sub><small>lx</small>", false),
            ("U<sub>0</sub>", false),
            (say!("Stated<br>error"), false),
        ];
        if !rows.is_empty() {
            head.extend(light);
        }
        let mut table = HtmlTable::new("", &head);
        for surface in surfaces.iter().filter(|surface| is_listed(surface)) {
            let facts = |side: &str| {
                let back = if side == "back" { say!(", back") } else { "" };
                vec![
                    format!("{}{back}", escaped(&surface.name)),
                    escaped(&surface.material),
                    ratio(surface.reflectance),
                    ratio(surface.area_m2),
                ]
            };
            let of_surface = &listed[surface.name.as_str()];
            if of_surface.is_empty() {
                let mut cells = facts("");
                cells.resize(head.len(), UNKNOWN.to_owned());
                table.row(cells);
            }
            for row in of_surface {
                let mut cells = facts(row.side);
                cells.push(lux_markup(row.average, with_error));
                let stated = if row.average.is_known() { percent(row.estimated_error) } else { UNKNOWN.to_owned() };
                cells.extend([
                    extreme_markup(row.least(), alone),
                    extreme_markup(row.greatest(), alone),
                    uniformity_with_error(row.u0(), alone),
                    stated,
                ]);
                table.row(cells);
            }
        }
        let hidden = all - surfaces.iter().filter(|surface| is_listed(surface)).count();
        let rest = match hidden {
            0 => String::new(),
            n => format!(
                "<p class=\"soft small\">{}</p>\n",
                say!("Not listed: {} surfaces that are small, belong to luminaires or are excluded from reports.", n)
            ),
        };
        let mut page = format!("<h2 class=\"page\">{}</h2>\n{}{rest}", say!("Surfaces"), table.markup());

        let mut shown: Vec<&Plot> = self
            .plots
            .iter()
            .filter(|plot| matches!(plot.kind, PlotKind::Surface(elements) if elements >= FEWEST_ELEMENTS))
            .filter(|plot| listed.contains_key(plot.subject.as_str()))
            .collect();
        let is_large = |plot: &&Plot| {
            surfaces.iter().any(|surface| surface.name == plot.subject && surface.area_m2 >= SMALL_SHARE * all_m2)
        };
        shown.retain(is_large);
        shown.truncate(MOST_SURFACE_PLOTS);
        for plot in shown {
            page += &figure(&plot.picture, "");
        }
        page
    }
}

fn result_table() -> HtmlTable {
    HtmlTable::new(
        "",
        &[
            (say!("Where"), true),
            (say!("Average Ē<small>lx</small>"), false),
            (say!("Minimum E<sub>min</sub><small>lx</small>"), false),
            (say!("Maximum E<sub>max</sub><small>lx</small>"), false),
            ("U<sub>0</sub><small>E<sub>min</sub>/Ē</small>", false),
            ("U<sub>d</sub><small>E<sub>min</sub>/E<sub>max</sub></small>", false),
            (say!("Stated<br>error"), false),
        ],
    )
}

/// An illuminance as markup: see [`lux_with_error`].
fn lux_markup(estimate: Estimate, join: impl Fn(&str, &str) -> String) -> String {
    let text = lux_with_error(estimate, join);
    if estimate.is_known() { text } else { escaped(&text) }
}

/// A least or greatest illuminance as markup; [`UNKNOWN`] if there is none.
fn extreme_markup(extreme: Option<Estimate>, join: impl Fn(&str, &str) -> String) -> String {
    extreme.map_or(UNKNOWN.to_owned(), |extreme| lux_markup(extreme, join))
}

/// The number without its error.
fn alone(number: &str, _: &str) -> String {
    number.to_owned()
}

fn result_cells(row: &TableRow, name: String) -> Vec<String> {
    let has_light = row.average.is_known();
    let where_lit = |number: String| if has_light { number } else { UNKNOWN.to_owned() };
    vec![
        name,
        lux_markup(row.average, with_error),
        extreme_markup(row.least(), with_error),
        extreme_markup(row.greatest(), with_error),
        uniformity_with_error(row.u0(), with_error),
        uniformity_with_error(row.ud(), with_error),
        where_lit(percent(row.estimated_error)),
    ]
}
