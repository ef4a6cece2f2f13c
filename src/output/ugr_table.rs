//! A luminaire's UGR table as files: `ugr-table.csv`, `ugr-corrections.csv`, and `ugr-table.html` for a data sheet.

use super::html::{Heading, HtmlTable, figure};
use super::lines::line_item;
use super::picture::{Picture, escaped};
use super::report::STYLE;
use super::sheet::{Sheet, SheetCell};
use super::texts::{decimal, language, said, say};
use super::{OutputError, ResultFile};
use crate::base::glare::rating_text;
use crate::base::position_index::POSITION_INDEX;
use crate::base::standard_rooms::{HEIGHT_M, SpacingCorrection, UgrTable, Viewing};

const COLUMNS: &[&str] = &[
    "x_h",
    "y_h",
    "viewing",
    "ceiling",
    "walls",
    "reference_plane",
    "spacing_h",
    "ugr",
    "background_luminance_cd_m2",
    "glare_sum_cd2_sr_m4",
    "luminaires",
    "luminaires_counted",
];
const CORRECTION_COLUMNS: &[&str] = &["spacing_h", "x_h", "y_h", "viewing", "ugr_change"];

/// A gap before the columns of each viewing direction.
const OWN_STYLE: &str = ".first { padding-left: 1.6rem; }\n.group { text-align: center; }\n";

/// Facts on the luminaire for a page, besides its ratings.
#[derive(Clone, Debug)]
pub struct UgrTableHeading {
    /// Maker and name of the luminaire; the file's name if it states neither.
    pub luminaire: String,
    /// Terms, as the English keys of translations, and their values, both plain text.
    pub facts: Vec<(&'static str, String)>,
    /// Warnings for the reader.
    pub warnings: Vec<String>,
    /// Polar diagram.
    pub polar: Picture,
}

/// Makes the files of a table.
///
/// # Errors
///
/// A number that is not finite; no table may hold one.
pub fn ugr_table_files(
    heading: &UgrTableHeading,
    table: &UgrTable,
    corrections: &[SpacingCorrection],
) -> Result<Vec<ResultFile>, OutputError> {
    let page = page(heading, table, corrections).into_bytes();
    let page = ResultFile { name: "ugr-table.html".to_owned(), bytes: page };
    Ok(vec![table_sheet(table)?, correction_sheet(corrections)?, page])
}

/// One row for each room, viewing direction and set of reflectances. Cases in which no light reaches the eye have no row.
fn table_sheet(table: &UgrTable) -> Result<ResultFile, OutputError> {
    let mut sheet = Sheet::new("ugr-table.csv", COLUMNS);
    for room in &table.rooms {
        for viewing in Viewing::BOTH {
            let glare = room.glare[viewing as usize];
            for (place, [ceiling, walls, plane]) in table.reflectances.iter().enumerate() {
                let Some(ugr) = room.ugr(viewing, place) else {
                    continue;
                };
                sheet.row(&[
                    SheetCell::Number(room.size_h[0]),
                    SheetCell::Number(room.size_h[1]),
                    SheetCell::Text(viewing.name()),
                    SheetCell::Number(*ceiling),
                    SheetCell::Number(*walls),
                    SheetCell::Number(*plane),
                    SheetCell::Number(table.spacing_h),
                    SheetCell::Number(ugr),
                    SheetCell::Number(room.backgrounds_cd_m2[place]),
                    SheetCell::Number(glare.sum),
                    SheetCell::Count(u64::from(glare.luminaires)),
                    SheetCell::Count(u64::from(glare.counted)),
                ])?;
            }
        }
    }
    Ok(sheet.finish())
}

fn correction_sheet(corrections: &[SpacingCorrection]) -> Result<ResultFile, OutputError> {
    let mut sheet = Sheet::new("ugr-corrections.csv", CORRECTION_COLUMNS);
    for correction in corrections {
        for (size_h, changes) in &correction.rooms {
            for viewing in Viewing::BOTH {
                let Some(change) = changes[viewing as usize] else {
                    continue;
                };
                sheet.row(&[
                    SheetCell::Number(correction.spacing_h),
                    SheetCell::Number(size_h[0]),
                    SheetCell::Number(size_h[1]),
                    SheetCell::Text(viewing.name()),
                    SheetCell::Number(change),
                ])?;
            }
        }
    }
    Ok(sheet.finish())
}

fn page(heading: &UgrTableHeading, table: &UgrTable, corrections: &[SpacingCorrection]) -> String {
    let title = escaped(&heading.luminaire);
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"{}\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title} – {}</title>\n<style>\n{STYLE}{OWN_STYLE}</style>\n</head>\n<body>\n\
         <header>\n<p class=\"kicker\">{}</p>\n<h1>{title}</h1>\n</header>\n",
        language().code(),
        say!("UGR table"),
        say!("UGR table")
    );
    let facts: Vec<(String, String)> =
        heading.facts.iter().map(|(term, says)| (escaped(said(term)), escaped(says))).collect();
    page += &super::html::terms("facts", &facts);
    if !heading.warnings.is_empty() {
        let items: String = heading.warnings.iter().map(|line| line_item(line)).collect();
        page +=
            &format!("<div class=\"warning\">\n<p><b>{}</b></p>\n<ul>\n{items}</ul>\n</div>\n", say!("Please note"));
    }
    page += &rating_table(table);
    page += &format!(
        "<p class=\"soft small\">{}</p>\n",
        say!(
            "Unified glare rating after CIE 117 in the standard rooms of CIE 190:2010: X across the line of sight, Y along it, H = {} m from \
             eye to luminaires, luminaires {} H apart, the observer at the middle of a wall. Position index: {}.",
            HEIGHT_M,
            decimal(table.spacing_h.to_string()),
            escaped(said(POSITION_INDEX))
        )
    );
    if !corrections.is_empty() {
        page += &format!(
            "<h2>{}</h2>\n{}<p class=\"soft small\">{}</p>\n",
            say!("Corrections for spacing"),
            correction_table(corrections),
            say!(
                "Change of a rating if luminaires stand farther apart and give the same light for each m² of floor: \
                 the smallest and the largest over the rooms that the spacing fits. <code>ugr-corrections.csv</code> \
                 lists every room."
            )
        );
    }
    page += &format!("<h2>{}</h2>\n{}", say!("Luminous intensity"), figure(&heading.polar, ""));
    page += &format!(
        "<footer>luxmc {}; {}</footer>\n</body>\n</html>\n",
        env!("CARGO_PKG_VERSION"),
        say!("CIE 190:2010, by its formulas.")
    );
    page
}

fn rating_table(table: &UgrTable) -> String {
    let sets = table.reflectances.len();
    // The first column of each viewing direction has a gap before it.
    let of_a_viewing = (0..sets).map(|place| if place == 0 { "first" } else { "" });
    let of_ratings: Vec<&str> = Viewing::BOTH.iter().flat_map(|_| of_a_viewing.clone()).collect();
    let names = [say!("Reflectances: ceiling"), say!("walls"), say!("reference plane")];
    let reflectances = names.into_iter().enumerate().map(|(place, name)| {
        let name = Heading { markup: name.to_owned(), columns: 2, class: "text", scope: "row" };
        let sets = table.reflectances.iter().cycle().zip(&of_ratings);
        let sets = sets.map(|(set, class)| Heading::column(percents(set[place]), class));
        std::iter::once(name).chain(sets).collect::<Vec<Heading>>()
    });
    let viewing =
        |name: &str| Heading { markup: name.to_owned(), columns: sets, class: "first group", scope: "colgroup" };
    let sizes = vec![
        Heading::column("X", ""),
        Heading::column("Y", ""),
        viewing(say!("viewed crosswise")),
        viewing(say!("viewed endwise")),
    ];
    let head = reflectances.chain([sizes]).collect();
    let mut ratings = HtmlTable::with_head(head, [&["", ""], &of_ratings[..]].concat());
    let mut above = None;
    for room in &table.rooms {
        let [x_h, y_h] = room.size_h;
        let across = if above == Some(x_h) { String::new() } else { format!("{x_h}H") };
        above = Some(x_h);
        let of_viewing = |viewing: Viewing| (0..sets).map(move |place| room.ugr(viewing, place));
        let of_room = Viewing::BOTH.into_iter().flat_map(of_viewing);
        let of_room = of_room.map(|ugr| escaped(&decimal(rating_text(ugr))));
        ratings.row([across, format!("{y_h}H")].into_iter().chain(of_room).collect());
    }
    ratings.markup()
}

/// A reflectance in percent, without the sign, to a tenth.
fn percents(reflectance: f64) -> String {
    format!("{}", (1000.0 * reflectance).round() / 10.0)
}

fn correction_table(corrections: &[SpacingCorrection]) -> String {
    let mut table = HtmlTable::new(
        "",
        &[
            (say!("Spacing"), true),
            (say!("Rooms"), false),
            (say!("viewed crosswise"), false),
            (say!("viewed endwise"), false),
        ],
    );
    for correction in corrections {
        let mut cells = vec![decimal(format!("{} H", correction.spacing_h)), correction.rooms.len().to_string()];
        cells.extend(Viewing::BOTH.map(|viewing| range_text(correction.range(viewing))));
        table.row(cells);
    }
    table.markup()
}

/// A range of changes: `−0.2 … +0.4`.
pub fn range_text(range: Option<[f64; 2]>) -> String {
    let signed = |change: f64| decimal(format!("{:+.1}", (10.0 * change).round() / 10.0 + 0.0).replace('-', "−"));
    range.map_or("–".to_owned(), |[least, most]| format!("{} … {}", signed(least), signed(most)))
}
