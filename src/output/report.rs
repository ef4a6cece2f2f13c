//! `report.html`: the run on one page for a client.

use std::collections::HashMap;

use super::daylight::daylight_table;
use super::html::{HtmlTable, figure, terms, with_error};
use super::numbers::{UNKNOWN, amount, count_tick, duration, lux_with_error, percent, ratio, uniformity_with_error};
use super::picture::escaped;
use super::plan::plan_picture;
use super::plots::{Plot, PlotKind, maintenance_note};
use super::report_observers::observer_tables;
use super::report_words::{explanations, stop_words, target_words};
use super::schedule::{Power, Schedule, floor_area_m2};
use super::verdicts::verdict_section;
use super::view::view_section;
use super::{ResultFile, date::utc_date};
use crate::check::{InspectedSurface, inspect_surfaces};
use crate::maps::{Estimate, TableKind, TableRow};
use crate::scene::photometry::Opening;
use crate::scene::{Emission, Luminaire, Quantity, Scene};
use crate::solver::{Activity, Solution, Spending};

pub(super) const STYLE: &str = include_str!("report.css");
/// Plots of surfaces that a report shows at most.
const MOST_SURFACE_PLOTS: usize = 8;
/// A surface side with fewer elements shows next to nothing.
const FEWEST_ELEMENTS: usize = 32;
/// Surfaces below this share of the whole area are left to `tables.csv`, where there are many.
const SMALL_SHARE: f64 = 0.005;
/// Up to this many surfaces all are listed.
const FEW_SURFACES: usize = 16;

/// What a report tells of a run that neither the scene nor the solution knows.
#[derive(Clone, Debug)]
pub struct ReportContext {
    /// Scene file as the user named it.
    pub scene: String,
    /// The command that makes this report again.
    pub command: String,
    /// Whether that command gives every digit again, since it fixes the chains.
    pub repeats_digits: bool,
    /// Seconds since 1970 at which the run ended, UTC.
    pub unix_time_s: u64,
    /// Seconds from process start to the end of computing.
    pub wall_s: f64,
    /// Worker threads.
    pub threads: usize,
}

/// The report of a run: what is lit how, by what, how exact that is, and how to compute it again.
pub fn report_file(scene: &Scene, solution: &Solution, plots: &[Plot], context: &ReportContext) -> ResultFile {
    let report = Report { scene, solution, plots, context, schedule: Schedule::of(scene) };
    ResultFile { name: "report.html".to_owned(), bytes: report.page().into_bytes() }
}

struct Report<'a> {
    scene: &'a Scene,
    solution: &'a Solution,
    plots: &'a [Plot],
    context: &'a ReportContext,
    schedule: Schedule,
}

impl Report<'_> {
    fn page(&self) -> String {
        let title = if self.scene.title.is_empty() { &self.context.scene } else { &self.scene.title };
        let mut page = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{0} – lighting report</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
             <header>\n<p class=\"kicker\">Lighting report</p>\n<h1>{0}</h1>\n<p class=\"soft\">{1}</p>\n</header>\n",
            escaped(title),
            self.subtitle()
        );
        page += &self.facts();
        page += &verdict_section(self.scene, self.solution);
        page += &self.warnings();
        page += &self.results();
        page += "<div class=\"plan\">\n<h2>Plan</h2>\n";
        page += &figure(
            &plan_picture(self.scene, &self.schedule),
            "Seen from above, to scale. Amber: luminaires, with the letter that the luminaire schedule gives them. \
             Blue: where illuminance is computed.",
        );
        page.push_str("</div>\n");
        if !self.plots.is_empty() {
            page += &view_section(self.scene, self.solution);
        }
        page += &self.map_figures();
        page += &self.surfaces();
        page += &self.luminaires();
        page += &self.accuracy();
        page += &format!(
            "<div class=\"together\">\n<h2>What the words mean</h2>\n{}</div>\n",
            terms("words", &explanations())
        );
        page += &format!(
            "<footer>luxmc {}; {}. All lengths in metres.</footer>\n</body>\n</html>\n",
            env!("CARGO_PKG_VERSION"),
            utc_date(self.context.unix_time_s)
        );
        page
    }

    fn subtitle(&self) -> String {
        format!("{} · {}", utc_date(self.context.unix_time_s), escaped(&maintenance_note(self.scene)))
    }

    fn rows(&self, is_wanted: impl Fn(TableKind) -> bool) -> Vec<&TableRow> {
        self.solution.maps.iter().flat_map(|map| &map.tables).filter(|row| is_wanted(row.kind)).collect()
    }

    fn facts(&self) -> String {
        let mut facts: Vec<(String, String)> = Vec::new();
        for row in self.rows(|kind| matches!(kind, TableKind::Grid | TableKind::Points)).into_iter().take(4) {
            let uniformity = format!(
                "<small>from {} to {} lx, uniformity U<sub>0</sub> {}</small>",
                extreme_markup(row, row.minimum_lx, alone),
                extreme_markup(row, row.maximum_lx, alone),
                uniformity_with_error(row, row.uniformity_u0, alone)
            );
            facts.push((
                format!("Average on {}", escaped(&row.name)),
                format!("{} lx{uniformity}", lux_markup(row.average_lx, alone)),
            ));
        }
        let count = self.scene.luminaires.len();
        let plural = if count == 1 { "luminaire" } else { "luminaires" };
        facts.push(match self.scene.daylight() {
            Some((outside_lx, _)) => (
                "Outside".to_owned(),
                format!("{} lx<small>on an open horizontal plane, from the sky</small>", amount(outside_lx)),
            ),
            None => (
                "Light in the room".to_owned(),
                format!("{} lm<small>maintained, from {count} {plural}</small>", amount(self.scene.luminous_flux_lm())),
            ),
        });
        let power = Power::of(self.scene);
        let floor_m2 = floor_area_m2(self.scene);
        if power.unknown == 0 && power.known_w > 0.0 && floor_m2 > 0.0 {
            let specific = format!("<small>{} W/m² of floor</small>", ratio(power.known_w / floor_m2));
            facts.push(("Electric power".to_owned(), format!("{} W{specific}", amount(power.known_w))));
        }
        let target = self.solution.target_error.map_or(String::new(), |target| {
            let met = if self.solution.target_met == Some(false) { "not met" } else { "met" };
            format!("<small>target of {} {met}</small>", percent(target))
        });
        facts.push(("Stated error".to_owned(), format!("{}{target}", percent(self.solution.estimated_error))));
        terms("facts", &facts)
    }

    fn warnings(&self) -> String {
        let warnings: Vec<&String> = self.scene.warnings.iter().chain(&self.solution.warnings).collect();
        let list = |class: &str, heading: &str, lines: &[&String]| {
            if lines.is_empty() {
                return String::new();
            }
            let items: String = lines.iter().map(|line| format!("<li>{}</li>\n", escaped(line))).collect();
            format!("<div class=\"{class}\">\n<p><b>{heading}</b></p>\n<ul>\n{items}</ul>\n</div>\n")
        };
        let notes: Vec<&String> = self.solution.notes.iter().collect();
        list("warning", "Please note", &warnings) + &list("notes", "How these results came about", &notes)
    }

    fn results(&self) -> String {
        let rows = self.rows(|kind| matches!(kind, TableKind::Grid | TableKind::Points));
        if rows.is_empty() {
            return self.observers();
        }
        let mut table = result_table();
        let sets = self.scene.receivers.iter().rev();
        let quantities: HashMap<&str, Quantity> = sets.map(|set| (set.name.as_str(), set.quantity)).collect();
        for row in rows {
            let kind = match quantities.get(row.name.as_str()).copied() {
                None | Some(Quantity::Perpendicular) => String::new(),
                Some(quantity) => format!(" ({})", quantity.name()),
            };
            table.row(result_cells(row, format!("{}{kind}", escaped(&row.name))));
        }
        format!(
            "<h2>Results</h2>\n{}<p class=\"soft small\">Behind each ± stands one standard error: the exact value lies within \
             it in two cases of three, within twice of it in nineteen of twenty. {}</p>\n",
            table.markup(),
            escaped(&maintenance_note(self.scene))
        ) + &self.observers()
    }

    /// What observers see: luminances and glare ratings.
    fn observers(&self) -> String {
        daylight_table(self.scene, self.solution) + &observer_tables(self.scene, self.solution)
    }

    fn map_figures(&self) -> String {
        let mut page = String::new();
        for plot in self.plots {
            match plot.kind {
                PlotKind::Grid => {
                    page += &format!("<h2 class=\"page\">{}</h2>\n", escaped(&plot.subject));
                    page +=
                        &figure(&plot.picture, "Colours show every point's own value; lines join equal illuminance.");
                }
                PlotKind::Luminance => {
                    page += &format!("<h2 class=\"page\">{}</h2>\n", escaped(&plot.subject));
                    page += &figure(&plot.picture, "What an eye sees there, in cd/m² on a logarithmic scale.");
                }
                PlotKind::Intensity => {
                    page += &format!("<h2 class=\"page\">{}</h2>\n", escaped(&plot.subject));
                    page += &figure(
                        &plot.picture,
                        "Luminous intensity of all light that leaves the scene, as seen from afar; the IES and LDT files beside this page hold the same.",
                    );
                }
                PlotKind::Values => page += &figure(&plot.picture, ""),
                PlotKind::Daylight => {
                    let words = "Illuminance over that of an open horizontal plane under the same sky; lines at 0.5, 1, 2, 3, 5 and 10 %.";
                    page += &figure(&plot.picture, words);
                }
                PlotKind::Halves => {
                    let words = "Two halves of the computation know nothing of each other: where they differ by chance alone, colours \
                                 are scattered without a pattern and pale; a pattern would be an error that the bars do not tell.";
                    page += &figure(&plot.picture, words);
                }
                PlotKind::HalvesHistogram => {
                    let words = "Bars as wide as the curve: the halves differ by what is stated. Narrower ones: the stated errors also hold what \
                                 both halves have wrong alike, or state too much. Wider ones: they state too little.";
                    page += &figure(&plot.picture, words);
                }
                _ => {}
            }
        }
        page
    }

    fn surfaces(&self) -> String {
        let rows = self.rows(|kind| kind == TableKind::Surface);
        let surfaces = inspect_surfaces(self.scene);
        let all_m2: f64 = surfaces.iter().map(|surface| surface.area_m2).sum();
        let is_listed =
            |surface: &InspectedSurface| surfaces.len() <= FEW_SURFACES || surface.area_m2 >= SMALL_SHARE * all_m2;
        let listed: HashMap<&str, Vec<&TableRow>> = surfaces
            .iter()
            .filter(|surface| is_listed(surface))
            .map(|surface| (surface.name.as_str(), Vec::new()))
            .collect();
        let listed = rows.iter().fold(listed, |mut listed, row| {
            if let Some(of_surface) = listed.get_mut(row.name.as_str()) {
                of_surface.push(row);
            }
            listed
        });
        let mut head =
            vec![("Surface", true), ("Material", true), ("Reflec-<br>tance", false), ("Area<small>m²</small>", false)];
        let light = [
            ("Ē<small>lx</small>", false),
            ("E<sub>min</sub><small>lx</small>", false),
            ("E<sub>max</sub><small>lx</small>", false),
            ("U<sub>0</sub>", false),
            ("Stated<br>error", false),
        ];
        if !rows.is_empty() {
            head.extend(light);
        }
        let mut table = HtmlTable::new("", &head);
        for surface in surfaces.iter().filter(|surface| is_listed(surface)) {
            let facts = |side: &str| {
                let back = if side == "back" { ", back" } else { "" };
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
                cells.resize(head.len(), String::new());
                table.row(cells);
            }
            for row in of_surface {
                let mut cells = facts(row.side);
                cells.push(lux_markup(row.average_lx, with_error));
                let stated = if row.average_lx.is_known() { percent(row.estimated_error) } else { UNKNOWN.to_owned() };
                cells.extend([
                    extreme_markup(row, row.minimum_lx, alone),
                    extreme_markup(row, row.maximum_lx, alone),
                    uniformity_with_error(row, row.uniformity_u0, alone),
                    stated,
                ]);
                table.row(cells);
            }
        }
        let hidden = surfaces.iter().filter(|surface| !is_listed(surface)).count();
        let rest = match hidden {
            0 => String::new(),
            n => format!("<p class=\"soft small\">{n} smaller surfaces stand in <code>tables.csv</code>.</p>\n"),
        };
        let mut page = format!("<h2 class=\"page\">Surfaces</h2>\n{}{rest}", table.markup());

        let mut shown: Vec<&Plot> = self
            .plots
            .iter()
            .filter(|plot| matches!(plot.kind, PlotKind::Surface(elements) if elements >= FEWEST_ELEMENTS))
            .filter(|plot| listed.contains_key(plot.subject.as_str()))
            .collect();
        shown.truncate(MOST_SURFACE_PLOTS);
        for plot in shown {
            page += &figure(&plot.picture, "");
        }
        page
    }

    fn luminaires(&self) -> String {
        let head = [
            ("Type", true),
            ("Luminaires", true),
            ("Light", true),
            ("Pieces", false),
            ("Flux each<small>lm, maintained</small>", false),
            ("Maintenance<br>factor", false),
            ("Dimmed<br>to", false),
            ("Power each<small>W</small>", false),
            ("Flux of all<small>lm</small>", false),
        ];
        let mut table = HtmlTable::new("", &head);
        for row in &self.schedule.rows {
            let luminaire = &self.scene.luminaires[row.members[0]];
            let count = row.members.len();
            let fluxes_lm = row.members.iter().map(|index| self.scene.luminaires[*index].luminous_flux_lm);
            let all_lm =
                if row.is_one_kind { luminaire.luminous_flux_lm * count as f64 } else { fluxes_lm.sum::<f64>() };
            // What differs from one to the other is not told.
            let of_each = |number: String| if row.is_one_kind { number } else { UNKNOWN.to_owned() };
            table.row(vec![
                format!("<b>{}</b>", row.letter),
                self.names(&row.members),
                match row.is_one_kind {
                    true => format!("{}{}{}", row.kind, product_markup(luminaire), self.mounting(&row.members)),
                    false => row.kind.to_owned(),
                },
                count.to_string(),
                of_each(amount(luminaire.luminous_flux_lm)),
                of_each(ratio(luminaire.maintenance_factor)),
                of_each(percent_whole(luminaire.dimming)),
                of_each(luminaire.power_w.map_or("unknown".to_owned(), amount)),
                amount(all_lm),
            ]);
        }
        let mut total = vec![String::new(); head.len()];
        (total[1], total[3]) = ("Together".to_owned(), self.scene.luminaires.len().to_string());
        total[8] = amount(self.scene.luminous_flux_lm());
        table.total(total);
        // Without plots of surfaces the schedule follows their table on the same page.
        let has_plots = self.plots.iter().any(|plot| matches!(plot.kind, PlotKind::Surface(_)));
        let class = if has_plots { " class=\"page\"" } else { "" };
        let mut page = format!("<h2{class}>Luminaire schedule</h2>\n{}{}", table.markup(), self.power_words());
        let polar: Vec<&Plot> = self.plots.iter().filter(|plot| plot.kind == PlotKind::Luminaire).collect();
        if !polar.is_empty() {
            page.push_str("<div class=\"row\">\n");
            for plot in polar {
                page += &figure(&plot.picture, "");
            }
            page.push_str("</div>\n");
        }
        page
    }

    fn names(&self, members: &[usize]) -> String {
        let name = |index: usize| escaped(&self.scene.luminaires[members[index]].name);
        match members.len() {
            0 => String::new(),
            1..=3 => (0..members.len()).map(name).collect::<Vec<_>>().join(", "),
            n => format!("{} … {}", name(0), name(n - 1)),
        }
    }

    /// How high luminaires hang, and how large their openings are; both small.
    fn mounting(&self, members: &[usize]) -> String {
        let heights_m =
            members.iter().filter_map(|index| place_m(&self.scene.luminaires[*index].emission)).map(|m| m.z);
        let (low_m, high_m) =
            heights_m.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z_m| (low.min(z_m), high.max(z_m)));
        let height = match () {
            () if low_m > high_m => String::new(),
            () if high_m - low_m < 0.005 => format!("at z = {} m", ratio(low_m)),
            () => format!("at z = {} to {} m", ratio(low_m), ratio(high_m)),
        };
        let size = match &self.scene.luminaires[members[0]].emission {
            Emission::Photometric { opening, .. } => opening_words(opening),
            _ => String::new(),
        };
        let parts: Vec<String> = [height, size].into_iter().filter(|part| !part.is_empty()).collect();
        if parts.is_empty() { String::new() } else { format!("<br><small class=\"soft\">{}</small>", parts.join(", ")) }
    }

    fn power_words(&self) -> String {
        let power = Power::of(self.scene);
        let floor_m2 = floor_area_m2(self.scene);
        if power.known_w == 0.0 && power.unknown == 0 {
            return String::new();
        }
        if power.known_w == 0.0 || floor_m2 <= 0.0 {
            return "<p class=\"soft small\">The electric power of the luminaires is unknown, so that no specific power can be given: \
                    the scene's luminaires take \"power_w\".</p>\n"
                .to_owned();
        }
        let per_m2 = power.known_w / floor_m2;
        let grids = self.rows(|kind| kind == TableKind::Grid);
        let per_100_lx: Vec<String> = grids
            .iter()
            .filter(|row| row.average_lx.value > 0.0)
            .map(|row| {
                let specific = per_m2 * 100.0 / row.average_lx.value;
                format!("{} W/m² for every 100 lx on {}", ratio(specific), escaped(&row.name))
            })
            .collect();
        let unknown = match power.unknown {
            0 => String::new(),
            n => format!(
                " The power of {n} of the {} luminaires is unknown and missing in these numbers.",
                self.scene.luminaires.len()
            ),
        };
        let by_light = if per_100_lx.is_empty() { String::new() } else { format!(", {}", per_100_lx.join(", ")) };
        format!(
            "<p>Electric power {} W (not dimmed) on {} m² of floor: {} W/m²{by_light}.{unknown}</p>\n",
            amount(power.known_w),
            ratio(floor_m2),
            ratio(per_m2)
        )
    }

    fn accuracy(&self) -> String {
        let solution = self.solution;
        let mut page = String::from("<h2 class=\"page\">How exact this is, and how to compute it again</h2>\n");
        page += &format!("<p>{}</p>\n<p>{}</p>\n", escaped(&target_words(solution)), escaped(&stop_words(solution)));
        page += &format!(
            "<p>Computed in {} with {} {}: {} light paths (chains), {} rays, seed {}.</p>\n",
            duration(self.context.wall_s),
            self.context.threads,
            if self.context.threads == 1 { "thread" } else { "threads" },
            solution.chains,
            count_tick(round_count(solution.rays)),
            solution.seed
        );
        page += &spending_table(&solution.spending);
        if let Ok(balance) = &solution.flux_balance {
            page += &format!(
                "<p>Of {} lm sent out, surfaces absorbed {} lm, {} lm left the scene, {} lm fell on the backs of one-sided \
                 surfaces and {} lm were cut off by choice.</p>\n",
                amount(balance.emitted_lm),
                amount(balance.absorbed_lm),
                amount(balance.escaped_lm),
                amount(balance.back_face_lm),
                amount(balance.truncated_lm)
            );
        }
        if let Some(plot) = self.plots.iter().find(|plot| plot.kind == PlotKind::Convergence) {
            page += &format!("<div class=\"tall\">\n{}</div>\n", figure(&plot.picture, ""));
        }
        page += &format!(
            "<h3>The same again</h3>\n<p>With luxmc {} and the scene file, {}:</p>\n<pre>{}</pre>\n",
            env!("CARGO_PKG_VERSION"),
            if self.context.repeats_digits {
                "this gives every digit again, on any number of threads"
            } else {
                "this gives results of the same quality again (every digit, where <code>--chains</code> fixes the light paths)"
            },
            escaped(&self.context.command)
        );
        page
    }
}

/// What a luminaire's photometric file says that it is, small.
fn product_markup(luminaire: &Luminaire) -> String {
    let words = luminaire.product.as_ref().map_or(String::new(), |product| product.words());
    if words.is_empty() { words } else { format!("<br><small>{}</small>", escaped(&words)) }
}

fn round_count(count: u64) -> f64 {
    let count = count as f64;
    if count < 1e3 {
        return count;
    }
    let grain = 10f64.powf(count.log10().floor() - 2.0);
    (count / grain).round() * grain
}

/// Where a luminaire is: a point, or the middle of its opening.
fn place_m(emission: &Emission) -> Option<glam::DVec3> {
    match emission {
        Emission::Isotropic { position_m, .. }
        | Emission::Lambertian { position_m, .. }
        | Emission::Photometric { position_m, .. } => Some(*position_m),
        Emission::Sphere { center_m, .. } => Some(*center_m),
        Emission::Area { .. } | Emission::Sky { .. } | Emission::Sun { .. } => None,
    }
}

/// Size of a luminous opening: along C0, along C90, and its height where it has one.
fn opening_words(opening: &Opening) -> String {
    match *opening {
        Opening::Rectangle { c0_m, c90_m } => format!("opening {} × {} m", ratio(c0_m), ratio(c90_m)),
        Opening::Box { c0_m, c90_m, height_m } => {
            format!("opening {} × {} × {} m", ratio(c0_m), ratio(c90_m), ratio(height_m))
        }
        Opening::Disk { diameter_m } => format!("opening {} m across", ratio(diameter_m)),
        _ => String::new(),
    }
}

fn percent_whole(fraction: f64) -> String {
    format!("{:.0}\u{a0}%", 100.0 * fraction)
}

/// Rays and computing time by what they were for.
fn spending_table(spending: &Spending) -> String {
    let caption = "What the rays and the computing time were for";
    let mut table = HtmlTable::new(caption, &[("", true), ("Rays", false), ("Time", false)]);
    if *spending == Spending::default() {
        return String::new();
    }
    let spent = |activity: &Activity| spending.rays(*activity) > 0 || spending.seconds(*activity) > 0.0;
    for activity in Activity::ALL.into_iter().filter(spent) {
        let rays = match spending.rays(activity) {
            0 => "–".to_owned(),
            rays => count_tick(round_count(rays)),
        };
        table.row(vec![activity.words().to_owned(), rays, duration(spending.seconds(activity))]);
    }
    table.markup()
}

fn result_table() -> HtmlTable {
    HtmlTable::new(
        "",
        &[
            ("Where", true),
            ("Average Ē<small>lx</small>", false),
            ("Minimum E<sub>min</sub><small>lx</small>", false),
            ("Maximum E<sub>max</sub><small>lx</small>", false),
            ("U<sub>0</sub><small>E<sub>min</sub>/Ē</small>", false),
            ("U<sub>d</sub><small>E<sub>min</sub>/E<sub>max</sub></small>", false),
            ("Stated<br>error", false),
        ],
    )
}

/// An illuminance as markup: see [`lux_with_error`].
fn lux_markup(estimate: Estimate, join: impl Fn(&str, &str) -> String) -> String {
    let text = lux_with_error(estimate, join);
    if estimate.is_known() { text } else { escaped(&text) }
}

/// A least or greatest illuminance as markup, where there are places to tell it of.
fn extreme_markup(row: &TableRow, extreme: Estimate, join: impl Fn(&str, &str) -> String) -> String {
    if row.knows_extremes() { lux_markup(extreme, join) } else { UNKNOWN.to_owned() }
}

/// A number without its error.
fn alone(number: &str, _: &str) -> String {
    number.to_owned()
}

fn result_cells(row: &TableRow, name: String) -> Vec<String> {
    let has_light = row.average_lx.is_known();
    let where_lit = |number: String| if has_light { number } else { UNKNOWN.to_owned() };
    vec![
        name,
        lux_markup(row.average_lx, with_error),
        extreme_markup(row, row.minimum_lx, with_error),
        extreme_markup(row, row.maximum_lx, with_error),
        uniformity_with_error(row, row.uniformity_u0, with_error),
        uniformity_with_error(row, row.uniformity_ud, with_error),
        where_lit(percent(row.estimated_error)),
    ]
}
