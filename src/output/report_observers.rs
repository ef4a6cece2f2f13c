//! What observers see, for the report: luminances and glare ratings.

use super::html::{Table, figure, with_error};
use super::numbers::{lux, percent, uncertainty};
use super::picture::escaped;
use super::plan::glare_picture;
use crate::base::position_index::POSITION_INDEX;
use crate::maps::TableKind;
use crate::scene::{Background, Observer, Quantity, Scene};
use crate::solver::Solution;

/// Observers whose glare a report draws, at most.
const MOST_PICTURES: usize = 6;
/// Luminaires that a picture's caption names.
const MOST_NAMES: usize = 5;

/// The tables of luminance sets and glare ratings; empty where the scene asks for none.
pub(super) fn observer_tables(scene: &Scene, solution: &Solution) -> String {
    let mut page = String::new();
    let rows = || solution.maps.iter().flat_map(|map| &map.tables).filter(|row| row.kind == TableKind::Luminance);
    if rows().next().is_some() {
        let mut table = Table::new(
            "",
            &[
                ("Observer", true),
                ("Mean<small>cd/m²</small>", false),
                ("Darkest<small>cd/m²</small>", false),
                ("Brightest<small>cd/m²</small>", false),
                ("Error", false),
            ],
        );
        for row in rows() {
            table.row(vec![
                escaped(&row.name),
                with_error(&lux(row.average_lx.value), &uncertainty(row.average_lx.standard_error)),
                lux(row.minimum_lx.value),
                lux(row.maximum_lx.value),
                percent(row.estimated_error),
            ]);
        }
        page += &format!("<h2>Luminance</h2>\n{}", table.markup());
    }
    if !solution.glare.is_empty() {
        page += &glare_section(scene, solution);
    }
    page
}

fn glare_section(scene: &Scene, solution: &Solution) -> String {
    let mut table = Table::new(
        "",
        &[
            ("Observer", true),
            ("UGR", false),
            ("Background luminance<small>cd/m²</small>", false),
            ("taken", true),
            ("Luminaires<br>that count", false),
            ("in sight, but<br>not in the table", false),
        ],
    );
    for rating in &solution.glare {
        let background = rating.background_cd_m2;
        let set = &scene.receivers[rating.set];
        let taken = match set.quantity {
            Quantity::Glare(Observer { background: Background::Tabular, .. }) => "on the walls, mean",
            _ => "at the eye",
        };
        let ugr = match rating.ugr {
            _ if rating.is_low() => "&lt; 10".to_owned(),
            None => "–".to_owned(),
            Some(ugr) => with_error(&format!("{:.1}", ugr.value), &uncertainty(ugr.standard_error)),
        };
        table.row(vec![
            escaped(&set.name),
            ugr,
            with_error(&lux(background.value), &uncertainty(background.standard_error)),
            taken.to_owned(),
            rating.contributions.len().to_string(),
            rating.outside.len().to_string(),
        ]);
    }
    let mut section = format!(
        "<h2>Glare</h2>\n{}<p class=\"soft small\">Unified glare rating after CIE 117; position index: {}. Its error is \
         that of the background luminance and of partly hidden luminaires.</p>\n",
        table.markup(),
        escaped(POSITION_INDEX)
    );
    for rating in solution.glare.iter().filter(|rating| !rating.contributions.is_empty()).take(MOST_PICTURES) {
        let strongest: Vec<String> = rating
            .contributions
            .iter()
            .take(MOST_NAMES)
            .map(|(luminaire, sum)| {
                format!("{} {:.0}%", scene.luminaires[*luminaire].name, 100.0 * sum / rating.glare_sum.value)
            })
            .collect();
        let caption = format!(
            "{}: every luminaire's share of the glare, as a disk of its size ({}). Crosses: in sight, but without a position index.",
            scene.receivers[rating.set].name,
            strongest.join(", ")
        );
        section += &figure(&glare_picture(scene, rating), &caption);
    }
    section
}
