//! The report's section for observers: luminances and glare ratings.

use glam::DVec3;

use super::glare_plot::{glare_grid_picture, glare_picture};
use super::html::{HtmlTable, figure, with_error};
use super::leaving_light::leaving_light;
use super::numbers::{amount, lux, percent, uncertainty, whole_percent};
use super::picture::escaped;
use super::texts::{decimal, said, say, separator};
use crate::base::glare::rating_text;
use crate::base::position_index::{Outside, POSITION_INDEX};
use crate::maps::TableKind;
use crate::scene::{Background, GlareObserver, Quantity, Scene};
use crate::solver::{GlareRating, Solution, worst_of_sets};

/// Largest number of observers whose glare a report draws.
const MOST_PICTURES: usize = 6;
/// Largest number of excluded luminaires that are named for each reason.
const MOST_OUTSIDE: usize = 40;
/// Largest number of luminaires that a picture's caption names.
const MOST_NAMES: usize = 5;

/// The tables of luminance sets and glare ratings; empty if the scene requests none.
pub(super) fn observer_tables(scene: &Scene, solution: &Solution) -> String {
    let mut page = String::new();
    let rows = || solution.maps.iter().flat_map(|map| &map.tables).filter(|row| row.kind == TableKind::Luminance);
    if rows().next().is_some() {
        let mut table = HtmlTable::new(
            "",
            &[
                (say!("Observer"), true),
                (say!("Mean<small>cd/m²</small>"), false),
                (say!("Darkest<small>cd/m²</small>"), false),
                (say!("Brightest<small>cd/m²</small>"), false),
                (say!("Error"), false),
            ],
        );
        for row in rows() {
            table.row(vec![
                escaped(&row.name),
                with_error(&lux(row.average.value), &uncertainty(row.average.standard_error)),
                lux(row.minimum.value),
                lux(row.maximum.value),
                percent(row.estimated_error),
            ]);
        }
        page += &format!("<h2>{}</h2>\n{}", say!("Luminance"), table.markup());
    }
    page += &intensity_section(scene, solution);
    if !solution.glare.is_empty() {
        page += &glare_section(scene, solution);
    }
    page
}

/// The intensity distributions of the light that leaves the scene; empty if none was requested.
fn intensity_section(scene: &Scene, solution: &Solution) -> String {
    let all = leaving_light(scene, solution);
    if all.is_empty() {
        return String::new();
    }
    let mut table = HtmlTable::new(
        "",
        &[
            (say!("Distribution"), true),
            (say!("Flux that leaves<small>lm</small>"), false),
            (say!("of the luminaires’"), false),
            (say!("Greatest intensity<small>cd</small>"), false),
            (say!("at C, γ"), false),
            (say!("Error"), false),
        ],
    );
    for light in &all {
        let [c_deg, gamma_deg] = light.maximum_at_deg;
        table.row(vec![
            escaped(&light.map.name),
            with_error(&amount(light.luminous_flux_lm.value), &uncertainty(light.luminous_flux_lm.standard_error)),
            percent(light.light_output_ratio),
            with_error(&amount(light.maximum_cd.value), &uncertainty(light.maximum_cd.standard_error)),
            format!("{c_deg}°, {gamma_deg}°"),
            percent(light.map.error.estimated),
        ]);
    }
    format!("<h2>{}</h2>\n{}", say!("Luminous intensity"), table.markup())
}

fn glare_section(scene: &Scene, solution: &Solution) -> String {
    let mut table = HtmlTable::new(
        "",
        &[
            (say!("Observer"), true),
            ("UGR", false),
            (say!("Background luminance<small>cd/m²</small>"), false),
            (say!("determined"), true),
            (say!("Luminaires<br>that count"), false),
            (say!("in sight, but<br>not in the table"), false),
        ],
    );
    let worst = worst_of_sets(&solution.glare);
    for (rating, observers) in &worst {
        let background = rating.background_cd_m2;
        let set = &scene.receivers[rating.set];
        let taken = match set.quantity {
            Quantity::Glare(Background::Tabular) => say!("on the walls, mean"),
            _ => say!("at the eye"),
        };
        let ugr = match rating.ugr {
            _ if rating.is_low() => escaped(&rating_text(None)),
            None => "–".to_owned(),
            Some(ugr) => with_error(&decimal(format!("{:.1}", ugr.value)), &uncertainty(ugr.standard_error)),
        };
        table.row(vec![
            escaped(&set.name) + &place_of_worst(scene, rating, *observers),
            ugr,
            with_error(&lux(background.value), &uncertainty(background.standard_error)),
            taken.to_owned(),
            rating.contributions.len().to_string(),
            rating.outside.len().to_string(),
        ]);
    }
    let mut section = format!(
        "<h2>{}</h2>\n{}<p class=\"soft small\">{}</p>\n",
        say!("Glare"),
        table.markup(),
        say!(
            "Unified glare rating after CIE 117; position index: {}. Its error is that of the background luminance and of partly hidden \
             luminaires.",
            escaped(said(POSITION_INDEX))
        )
    );
    for (number, (rating, observers)) in worst.iter().enumerate() {
        if number < MOST_PICTURES && *observers > 1 {
            let of_set: Vec<GlareRating> =
                solution.glare.iter().filter(|other| other.set == rating.set).cloned().collect();
            let words = say!(
                "{}: {} observers, each a wedge along the line of sight; the darker, the more glare.",
                scene.receivers[rating.set].name,
                observers
            );
            section += &glare_grid_picture(scene, &of_set).map_or(String::new(), |picture| figure(&picture, &words));
        }
        if number < MOST_PICTURES && !rating.contributions.is_empty() {
            section += &glare_figure(scene, rating);
        }
        section += &outside_words(scene, rating);
    }
    section
}

/// Every luminaire's contribution to the glare of an observer, drawn in plan.
fn glare_figure(scene: &Scene, rating: &GlareRating) -> String {
    let strongest: Vec<String> = rating
        .contributions
        .iter()
        .take(MOST_NAMES)
        .map(|(luminaire, sum)| {
            format!("{}: {}", scene.luminaires[*luminaire].name, whole_percent(sum / rating.glare_sum.value))
        })
        .collect();
    let set = &scene.receivers[rating.set];
    let who = match set.observers.len() {
        1 => set.name.clone(),
        _ => format!("{}, {}", set.name, observer_words(&set.observers[rating.observer])),
    };
    let caption = say!(
        "{}: every luminaire's share of the glare, as a disk of its size ({}). Crosses: in sight, but without a position index.",
        who,
        strongest.join(", ")
    );
    figure(&glare_picture(scene, rating), &caption)
}

/// The luminaires that do not count for an observer, by name and reason, as markup.
fn outside_words(scene: &Scene, rating: &GlareRating) -> String {
    let mut reasons: Vec<Outside> = rating.outside.iter().map(|(_, reason)| *reason).collect();
    reasons.sort();
    reasons.dedup();
    let items = reasons.into_iter().map(|reason| {
        let members = rating.outside.iter().filter(|(_, other)| *other == reason);
        let names: Vec<&str> = members.map(|(index, _)| scene.luminaires[*index].name.as_str()).collect();
        let rest = match names.len().saturating_sub(MOST_OUTSIDE) {
            0 => String::new(),
            more => say!(" and {} more, see summary.json", more),
        };
        let listed = names[..names.len().min(MOST_OUTSIDE)].join(", ");
        format!("<li>{}: {}</li>\n", escaped(said(reason.explanation())), escaped(&(listed + &rest)))
    });
    let items: String = items.collect();
    if items.is_empty() {
        return items;
    }
    let name = escaped(&scene.receivers[rating.set].name);
    let words = say!("{}: in sight, but not counted:", name);
    format!("<p class=\"small\">{words}</p>\n<ul class=\"small\">\n{items}</ul>\n")
}

/// Position and direction of the worst of several observers, as markup.
fn place_of_worst(scene: &Scene, rating: &GlareRating, observers: usize) -> String {
    let all = &scene.receivers[rating.set].observers;
    if all.len() < 2 {
        return String::new();
    }
    format!(
        "<small>{}</small>",
        say!(", the worst of {}: {}", observers, escaped(&observer_words(&all[rating.observer])))
    )
}

/// Position and direction of an observer: `at (2, 3, 1.2) m, towards (1, 0, 0)`.
pub fn observer_words(observer: &GlareObserver) -> String {
    let rounded = |vector: DVec3, scale: f64| {
        vector.to_array().map(|x| decimal(((scale * x).round() / scale + 0.0).to_string())).join(separator())
    };
    say!("at ({}) m, towards ({})", rounded(observer.eye_m, 1000.0), rounded(observer.view, 100.0))
}
