//! What observers see, for the report: luminances and glare ratings.

use super::html::{Table, with_error};
use super::numbers::{lux, percent, uncertainty};
use super::picture::escaped;
use crate::base::glare::POSITION_INDEX;
use crate::maps::TableKind;
use crate::scene::Scene;
use crate::solver::Solution;

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
                lux(row.maximum_lx),
                percent(row.estimated_error),
            ]);
        }
        page += &format!("<h2>Luminance</h2>\n{}", table.markup());
    }
    if !solution.glare.is_empty() {
        let mut table =
            Table::new("", &[("Observer", true), ("UGR", false), ("Background luminance<small>cd/m²</small>", false)]);
        for rating in &solution.glare {
            let background = rating.background_cd_m2;
            table.row(vec![
                escaped(&scene.receivers[rating.set].name),
                rating.ugr.map_or("none".to_owned(), |ugr| {
                    with_error(&format!("{:.1}", ugr.value), &uncertainty(ugr.standard_error))
                }),
                with_error(&lux(background.value), &uncertainty(background.standard_error)),
            ]);
        }
        page += &format!(
            "<h2>Glare</h2>\n{}<p class=\"soft small\">Unified glare rating after CIE 117; position index: {}. Its error is \
             that of the background luminance and of partly hidden luminaires.</p>\n",
            table.markup(),
            escaped(POSITION_INDEX)
        );
    }
    page
}
