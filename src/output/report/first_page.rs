//! The first page of a report: project, results in plain words, verdicts, plan and main map.

use super::Report;
use crate::control::Ruling;
use crate::maps::{MapKind, MapResult, TableKind, TableRow};
use crate::output::date::utc_date;
use crate::output::flat::grid_map;
use crate::output::html::{figure, terms};
use crate::output::map_plot::small_map;
use crate::output::numbers::{amount, percent, ratio, uniformity_with_error};
use crate::output::picture::escaped;
use crate::output::plan::small_plan;
use crate::output::plots::{PlotKind, maintenance_note};
use crate::output::schedule::{Power, floor_area_m2};
use crate::output::texts::say;
use crate::output::verdicts::{requirement_words, verdict_section, verdict_sentence, with_indices};
use crate::solver::{Verdict, verdicts};

/// Largest number of requirements that the first paragraph names.
const MOST_NAMED: usize = 4;
/// Largest number of averages that are shown as facts if there are no verdicts.
const MOST_AVERAGES: usize = 4;

impl Report<'_> {
    /// Title of the report: the scene's title, or the name of its file.
    pub(super) fn title(&self) -> &str {
        if self.scene.title.is_empty() { &self.context.scene } else { &self.scene.title }
    }

    /// The HTML head of the page.
    pub(super) fn head(&self) -> String {
        format!(
            "<!DOCTYPE html>\n<html lang=\"{}\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{} – {}</title>\n<style>\n{}</style>\n</head>\n",
            self.context.language.code(),
            escaped(self.title()),
            say!("Lighting report"),
            super::STYLE,
        )
    }

    /// The part that a client reads first.
    pub(super) fn first_page(&self) -> String {
        let verdicts = verdicts(self.scene, self.solution);
        let mut page = format!(
            "<header>\n<p class=\"kicker\">{}</p>\n<h1>{}</h1>\n",
            say!("Lighting report"),
            escaped(self.title())
        );
        page += &self.project();
        page += "</header>\n";
        page += &format!("<p class=\"lead\">{}</p>\n", self.result_words(&verdicts));
        if verdicts.is_empty() {
            page += &self.facts();
        }
        page += &verdict_section(self.scene, self.solution);
        page += &format!("<div class=\"pair\">\n<div>\n<h3>{}</h3>\n", say!("Plan"));
        page += &figure(
            &small_plan(self.scene, &self.schedule),
            say!(
                "Seen from above, to scale. Amber: luminaires, with the letters of the schedule. Blue: where light is computed."
            ),
        );
        page += "</div>\n";
        if let Some((map, flat)) = self.main_map().and_then(|map| Some((map, grid_map(self.scene, map)?))) {
            page += &format!("<div>\n<h3>{}</h3>\n", say!("Illuminance: {}", escaped(&map.name)));
            page +=
                &figure(&small_map(&flat), say!("Colours show every point's own value; lines join equal illuminance."));
            page += "</div>\n";
        }
        page += "</div>\n";
        page + &format!(
            "<div class=\"signatures\">\n<p class=\"soft small\">{}</p>\n<p class=\"soft small\">{}</p>\n</div>\n",
            say!("Place, date"),
            say!("Signature")
        )
    }

    /// Client, author, date and notes. Without a project's date, the day of the computation.
    fn project(&self) -> String {
        let project = &self.scene.project;
        let day = if project.date.is_empty() { utc_date(self.context.unix_time_s) } else { project.date.clone() };
        let given = [(say!("Client"), &project.client), (say!("Author"), &project.author), (say!("Date"), &day)];
        let data: Vec<(String, String)> = given
            .into_iter()
            .filter(|(_, text)| !text.is_empty())
            .map(|(term, text)| (term.to_owned(), escaped(text)))
            .collect();
        let notes: String = project
            .notes
            .lines()
            .filter(|line| !line.trim().is_empty())
            .map(|line| format!("<p>{}</p>\n", escaped(line)))
            .collect();
        terms("project", &data) + &notes
    }

    /// The main map: that of the first grid with requirements, else that of the first grid.
    fn main_map(&self) -> Option<&MapResult> {
        let is_drawn =
            |map: &MapResult| self.plots.iter().any(|plot| plot.kind == PlotKind::Grid && plot.subject == map.name);
        let is_required = |map: &MapResult| match map.kind {
            MapKind::Receivers(set) => !self.scene.receivers[set].requirements.is_empty(),
            MapKind::Elements => false,
        };
        let drawn = || self.solution.maps.iter().filter(|map| is_drawn(map));
        drawn().find(|map| is_required(map)).or_else(|| drawn().next())
    }

    /// The result in a few plain sentences.
    fn result_words(&self, verdicts: &[Verdict]) -> String {
        let mut sentences = Vec::new();
        if !verdicts.is_empty() {
            sentences.push(format!("<b>{}</b>", escaped(&verdict_sentence(verdicts))));
            for (ruling, words) in [(Ruling::NotMet, say!("Not met")), (Ruling::Undecided, say!("Undecided"))] {
                sentences.extend(self.named(verdicts, ruling).map(|names| say!("{}: {}.", words, names)));
            }
        }
        let main = self.main_map().map(|map| map.name.as_str());
        let rows = self.rows(|kind| matches!(kind, TableKind::Grid | TableKind::Points));
        let row = rows.iter().find(|row| Some(row.name.as_str()) == main).or(rows.first());
        if let Some(row) = row.filter(|row| row.average.is_known()) {
            sentences.push(say!("On {} the average illuminance is {}.", escaped(&row.name), light_words(row)));
        }
        sentences.push(match self.scene.daylight() {
            Some((outside_lx, _)) => {
                say!("All light comes from the sky, which gives {} lx on an open horizontal plane.", amount(outside_lx))
            }
            None => self.light_words(),
        });
        let warnings = self.scene.warnings.len() + self.solution.warnings.len();
        sentences.push(escaped(&maintenance_note(self.scene)));
        if warnings > 0 {
            sentences.push(say!("See the remarks on the computation under “Please note”.").to_owned());
        }
        sentences.join(" ")
    }

    /// Number and maintained flux in lm of the luminaires other than sky and sun, and whether these add light.
    pub(super) fn lamps(&self) -> (usize, String, bool) {
        let lamps = self.scene.lamps();
        let flux_lm = lamps.clone().map(|luminaire| luminaire.luminous_flux_lm).sum();
        let count = lamps.count();
        (count, amount(flux_lm), count < self.scene.luminaires.len())
    }

    /// In a sentence, where the light comes from.
    fn light_words(&self) -> String {
        let (count, flux_lm, has_daylight) = self.lamps();
        let power = self
            .power()
            .map_or(String::new(), |[power, specific]| say!(" with {} W ({} W/m² of floor)", power, specific));
        let daylight = if has_daylight { say!(" Daylight comes in as well.") } else { "" };
        match count {
            0 => say!("All light is daylight.").to_owned(),
            1 => say!("One luminaire emits {} lm in total{}.", flux_lm, power) + daylight,
            _ => say!("{} luminaires emit {} lm in total{}.", count, flux_lm, power) + daylight,
        }
    }

    /// The same as a fact of the page.
    fn light_fact(&self) -> String {
        match self.lamps() {
            (0, ..) => say!("daylight<small>from sun and sky</small>").to_owned(),
            (1, flux_lm, false) => say!("{} lm<small>maintained, from one luminaire</small>", flux_lm),
            (1, flux_lm, true) => say!("{} lm<small>maintained, from one luminaire; and daylight</small>", flux_lm),
            (count, flux_lm, false) => say!("{} lm<small>maintained, from {} luminaires</small>", flux_lm, count),
            (count, flux_lm, true) => {
                say!("{} lm<small>maintained, from {} luminaires; and daylight</small>", flux_lm, count)
            }
        }
    }

    /// Electric power in W and in W/m² of floor; `None` unless the power of all luminaires and the floor are known.
    fn power(&self) -> Option<[String; 2]> {
        let (power, floor_m2) = (Power::of(self.scene), floor_area_m2(self.scene));
        let is_known = power.unknown == 0 && power.known_w > 0.0 && floor_m2 > 0.0;
        is_known.then(|| [amount(power.known_w), ratio(power.known_w / floor_m2)])
    }

    /// Names of the requirements with a ruling; `None` if none has it.
    fn named(&self, verdicts: &[Verdict], ruling: Ruling) -> Option<String> {
        let of: Vec<&Verdict> = verdicts.iter().filter(|verdict| verdict.ruling() == ruling).collect();
        let name = |verdict: &&Verdict| {
            let name = &self.scene.receivers[verdict.set].name;
            format!("{} ({})", with_indices(&escaped(&requirement_words(&verdict.requirement))), escaped(name))
        };
        let names: Vec<String> = of.iter().take(MOST_NAMED).map(name).collect();
        let more = if of.len() > MOST_NAMED { say!(" and {} more", of.len() - MOST_NAMED) } else { String::new() };
        (!of.is_empty()).then(|| names.join(", ") + &more)
    }

    /// The most important numbers, for a page without a table of verdicts.
    fn facts(&self) -> String {
        let mut facts: Vec<(String, String)> = Vec::new();
        let rows = self.rows(|kind| matches!(kind, TableKind::Grid | TableKind::Points));
        for row in rows.into_iter().take(MOST_AVERAGES) {
            let uniformity = say!(
                "<small>from {} to {} lx, uniformity U<sub>0</sub> {}</small>",
                super::extreme_markup(row.least(), super::alone),
                super::extreme_markup(row.greatest(), super::alone),
                uniformity_with_error(row.u0(), super::alone)
            );
            facts.push((
                say!("Average on {}", escaped(&row.name)),
                format!("{} lx{uniformity}", super::lux_markup(row.average, super::alone)),
            ));
        }
        facts.push(match self.scene.daylight() {
            Some((outside_lx, _)) => (
                say!("Outside").to_owned(),
                say!("{} lx<small>on an open horizontal plane, from the sky</small>", amount(outside_lx)),
            ),
            None => (say!("Light in the room").to_owned(), self.light_fact()),
        });
        if let Some([power, specific]) = self.power() {
            facts.push((
                say!("Electric power").to_owned(),
                say!("{} W<small>{} W/m² of floor</small>", power, specific),
            ));
        }
        let target = self.solution.target_error.map_or(String::new(), |target| {
            let target = percent(target);
            let words = match self.solution.target_met {
                Some(false) => say!("target of {} not met", target),
                _ => say!("target of {} met", target),
            };
            format!("<small>{words}</small>")
        });
        facts.push((
            say!("Stated error").to_owned(),
            format!("{}{target}", self.solution.stated_error().map_or("–".to_owned(), percent)),
        ));
        terms("facts", &facts)
    }
}

/// Average, least, greatest and uniformity of a row in words, as markup.
fn light_words(row: &TableRow) -> String {
    let average = super::lux_markup(row.average, super::with_error);
    if !row.knows_extremes() {
        return format!("{average} lx");
    }
    say!(
        "{} lx, from {} to {} lx, with a uniformity U<sub>0</sub> of {}",
        average,
        super::extreme_markup(row.least(), super::alone),
        super::extreme_markup(row.greatest(), super::alone),
        uniformity_with_error(row.u0(), super::alone)
    )
}
