//! The luminaires of a report: kinds, mounting, number, power and polar diagrams.

use super::Report;
use crate::maps::TableKind;
use crate::output::energy::energy_words;
use crate::output::html::{HtmlTable, figure};
use crate::output::numbers::{UNKNOWN, amount, ratio, whole_percent};
use crate::output::picture::escaped;
use crate::output::plots::{Plot, PlotKind};
use crate::output::schedule::{Power, floor_area_m2};
use crate::output::texts::{said, say};
use crate::scene::Luminaire;
use crate::scene::photometry::Opening;

impl Report<'_> {
    pub(super) fn luminaires(&self) -> String {
        let head = [
            (say!("Type"), true),
            (say!("Luminaires"), true),
            (say!("Light"), true),
            (say!("Pieces"), false),
            (say!("Flux each<small>lm, maintained</small>"), false),
            (say!("Maintenance<br>factor"), false),
            (say!("Dimmed<br>to"), false),
            (say!("Power each<small>W</small>"), false),
            (say!("Total flux<small>lm</small>"), false),
        ];
        let mut table = HtmlTable::new("", &head);
        for row in &self.schedule.rows {
            let luminaire = &self.scene.luminaires[row.members[0]];
            let count = row.members.len();
            let fluxes_lm = row.members.iter().map(|index| self.scene.luminaires[*index].luminous_flux_lm);
            let all_lm =
                if row.is_one_kind { luminaire.luminous_flux_lm * count as f64 } else { fluxes_lm.sum::<f64>() };
            // A value that differs between the luminaires of a row is not shown.
            let of_each = |number: String| if row.is_one_kind { number } else { UNKNOWN.to_owned() };
            table.row(vec![
                format!("<b>{}</b>", row.letter),
                self.names(&row.members),
                match row.is_one_kind {
                    true => format!("{}{}{}", said(row.kind), product_markup(luminaire), self.mounting(&row.members)),
                    false => said(row.kind).to_owned(),
                },
                count.to_string(),
                of_each(amount(luminaire.luminous_flux_lm)),
                of_each(ratio(luminaire.maintenance_factor)),
                of_each(whole_percent(luminaire.dimming)),
                of_each(luminaire.power_w.map_or(say!("unknown").to_owned(), amount)),
                amount(all_lm),
            ]);
        }
        let mut total = vec![String::new(); head.len()];
        let (lamps, all_lm, _) = self.lamps();
        (total[1], total[3], total[8]) = (say!("Total").to_owned(), lamps.to_string(), all_lm);
        if lamps > 0 {
            table.total(total);
        }
        let mut page = format!(
            "<h2 class=\"page\">{}</h2>\n{}{}",
            say!("Luminaire schedule"),
            table.markup(),
            self.power_words() + &energy_words(self.scene)
        );
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

    /// Mounting height of luminaires, and size of their openings or luminous surfaces, in small type.
    fn mounting(&self, members: &[usize]) -> String {
        let (low_m, high_m) = members
            .iter()
            .map(|index| self.heights_m(*index))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low_m, high_m), (lowest_m, highest_m)| {
                (low_m.min(lowest_m), high_m.max(highest_m))
            });
        let height = match () {
            () if low_m > high_m => String::new(),
            () if high_m - low_m < 0.005 => say!("at z = {} m", ratio(low_m)),
            () => say!("at z = {} to {} m", ratio(low_m), ratio(high_m)),
        };
        let emission = &self.scene.luminaires[members[0]].emission;
        let luminous_m2: f64 =
            self.luminous_triangles(members[0]).map(|triangle| self.scene.triangle_area_m2(triangle)).sum();
        let size = match emission.opening() {
            Some(opening) => opening_words(&opening),
            None if luminous_m2 > 0.0 => say!("luminous area {} m²", ratio(luminous_m2)),
            None => String::new(),
        };
        let parts: Vec<String> = [height, size].into_iter().filter(|part| !part.is_empty()).collect();
        if parts.is_empty() { String::new() } else { format!("<br><small class=\"soft\">{}</small>", parts.join(", ")) }
    }

    /// Triangles of a luminaire's luminous surfaces.
    fn luminous_triangles(&self, luminaire: usize) -> impl Iterator<Item = u32> {
        let surfaces = self.scene.luminaires[luminaire].emission.surfaces();
        surfaces.iter().flat_map(move |surface| self.scene.surfaces[*surface as usize].triangles.clone())
    }

    /// Lowest and highest height of the luminous parts, in m. If there are none, as for the sky, the first is above the second.
    fn heights_m(&self, luminaire: usize) -> (f64, f64) {
        if let Some(place_m) = self.scene.luminaires[luminaire].emission.place_m() {
            return (place_m.z, place_m.z);
        }
        let corners_m = self.luminous_triangles(luminaire).flat_map(|triangle| self.scene.corners_m(triangle));
        corners_m.fold((f64::INFINITY, f64::NEG_INFINITY), |(low_m, high_m), corner_m| {
            (low_m.min(corner_m.z), high_m.max(corner_m.z))
        })
    }

    fn power_words(&self) -> String {
        let power = Power::of(self.scene);
        let floor_m2 = floor_area_m2(self.scene);
        if power.known_w == 0.0 && power.unknown == 0 {
            return String::new();
        }
        if power.known_w == 0.0 || floor_m2 <= 0.0 {
            let words = say!(
                "The electric power of the luminaires is unknown, so no specific power can be given. The scene file \
                 can state the power of each luminaire with \"power_w\"."
            );
            return format!("<p class=\"soft small\">{words}</p>\n");
        }
        let per_m2 = power.known_w / floor_m2;
        let grids = self.rows(|kind| kind == TableKind::Grid);
        let per_100_lx: Vec<String> = grids
            .iter()
            .filter(|row| row.average.value > 0.0)
            .map(|row| {
                let specific = per_m2 * 100.0 / row.average.value;
                say!("{} W/m² for every 100 lx on {}", ratio(specific), escaped(&row.name))
            })
            .collect();
        let unknown = match power.unknown {
            0 => String::new(),
            n => say!(
                " The power of {} of the {} luminaires is unknown and not included in these numbers.",
                n,
                self.scene.luminaires.len()
            ),
        };
        let by_light = if per_100_lx.is_empty() { String::new() } else { format!(", {}", per_100_lx.join(", ")) };
        let words = say!(
            "Electric power {} W (not dimmed) on {} m² of floor: {} W/m²{}.",
            amount(power.known_w),
            ratio(floor_m2),
            ratio(per_m2),
            by_light
        );
        format!("<p>{words}{unknown}</p>\n")
    }
}

/// The product named by a luminaire's photometric file, in small type.
fn product_markup(luminaire: &Luminaire) -> String {
    let words = luminaire.product.as_ref().map_or(String::new(), |product| product.words());
    if words.is_empty() { words } else { format!("<br><small>{}</small>", escaped(&words)) }
}

/// Size of a luminous opening: along C0, along C90 and along the axis, without extents of 0. A round opening has a diameter.
fn opening_words(opening: &Opening) -> String {
    let extents_m: Vec<f64> = opening.extents_m().into_iter().filter(|extent_m| *extent_m > 0.0).collect();
    match (opening, &extents_m[..]) {
        (Opening::Disk { diameter_m } | Opening::Sphere { diameter_m }, _) => {
            say!("opening {} m across", ratio(*diameter_m))
        }
        (_, [one_m, other_m]) => say!("opening {} × {} m", ratio(*one_m), ratio(*other_m)),
        (_, [c0_m, c90_m, height_m]) => say!("opening {} × {} × {} m", ratio(*c0_m), ratio(*c90_m), ratio(*height_m)),
        _ => String::new(),
    }
}
