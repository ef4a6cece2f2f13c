//! Entries of EN 12464-1, EN 12193 and EN 1838 that requirements can name.
//!
//! References that begin with 5 are those of EN 12464-1:2011, tables 5.1 to 5.49: Ē, R_UGL, U0 and R_a. Their values for walls, ceilings
//! and cylinders come from clauses 4.2.3 and 4.6.2 of that edition. These are 50 lx on walls, 30 lx on ceilings and 50 lx on cylinders
//! everywhere. In offices, schools, hospitals, entrances, corridors and stairs they are 75 lx on walls and 50 lx on ceilings. Where
//! people talk, they are 150 lx on cylinders. The other references are those of EN 12464-1:2021. Its tables contain all these values, and
//! a modified Ē. All entries were written from knowledge of the standards, not copied from their text. Uncertain entries were left out.
//! The standards themselves are the authority.

use super::standard::{Measure, SpaceLimits, Standard, StandardEntry};

/// An entry of EN 12464-1: Ē in lx, R_UGL, U0, R_a, limits for other areas than the task, and the task.
macro_rules! entry {
    ($reference:literal, $average_lx:literal, $ugr:literal, $uniformity_u0:literal, $ra:literal, $space:expr, $task:literal) => {
        StandardEntry {
            standard: Standard::WorkPlaces,
            reference: $reference,
            task: $task,
            limits: &[(Measure::AverageLx, $average_lx), (Measure::UniformityU0, $uniformity_u0), (Measure::Ugr, $ugr)],
            colour_rendering_ra: Some($ra),
            space: Some($space),
        }
    };
}

/// A class of EN 12193.
macro_rules! sports {
    ($reference:literal, $average_lx:literal, $uniformity_u0:literal) => {
        StandardEntry {
            standard: Standard::Sports,
            reference: $reference,
            task: "ball games in halls",
            limits: &[(Measure::AverageLx, $average_lx), (Measure::UniformityU0, $uniformity_u0)],
            colour_rendering_ra: None,
            space: None,
        }
    };
}

/// Limits for any room, by the clauses of 2011.
const PLAIN: SpaceLimits = SpaceLimits { modified_lx: None, cylindrical_lx: 50.0, walls_lx: 50.0, ceiling_lx: 30.0 };
/// Limits for rooms with brighter walls and ceilings.
const BRIGHT: SpaceLimits = SpaceLimits { walls_lx: 75.0, ceiling_lx: 50.0, ..PLAIN };
/// Limits for such rooms where people also talk.
const TALK: SpaceLimits = SpaceLimits { cylindrical_lx: 150.0, ..BRIGHT };

/// Limits of an entry of 2021 in lx: the modified average, and the averages of cylinders, walls and the ceiling.
const fn space_limits(modified_lx: f64, cylindrical_lx: f64, walls_lx: f64, ceiling_lx: f64) -> SpaceLimits {
    SpaceLimits { modified_lx: Some(modified_lx), cylindrical_lx, walls_lx, ceiling_lx }
}

/// All entries. Those of EN 12193 are the classes of basketball, handball, volleyball and indoor football. Those of EN 1838 refer to
/// direct light.
pub(super) const ENTRIES: &[StandardEntry] = &[
    // Traffic zones, rest rooms and sanitary rooms, control rooms, stores: edition of 2011.
    entry!("5.1.1", 100.0, 28.0, 0.4, 40.0, BRIGHT, "circulation areas and corridors"),
    entry!("5.1.2", 100.0, 25.0, 0.4, 40.0, BRIGHT, "stairs, escalators"),
    entry!("5.1.3", 100.0, 25.0, 0.4, 40.0, PLAIN, "lifts"),
    entry!("5.1.4", 150.0, 25.0, 0.4, 40.0, PLAIN, "loading ramps and bays"),
    entry!("5.2.1", 200.0, 22.0, 0.4, 80.0, PLAIN, "canteens, pantries"),
    entry!("5.2.2", 100.0, 22.0, 0.4, 80.0, PLAIN, "rest rooms"),
    entry!("5.2.3", 300.0, 22.0, 0.4, 80.0, PLAIN, "rooms for physical exercise"),
    entry!("5.2.4", 200.0, 25.0, 0.4, 80.0, PLAIN, "cloakrooms, washrooms, toilets"),
    entry!("5.2.5", 500.0, 19.0, 0.6, 80.0, PLAIN, "sick bays"),
    entry!("5.2.6", 500.0, 16.0, 0.6, 90.0, PLAIN, "rooms for medical attention"),
    entry!("5.3.1", 200.0, 25.0, 0.4, 60.0, PLAIN, "plant rooms, switch gear rooms"),
    entry!("5.3.2", 500.0, 19.0, 0.6, 80.0, PLAIN, "post rooms, switchboards"),
    entry!("5.4.1", 100.0, 25.0, 0.4, 60.0, PLAIN, "store and stockrooms"),
    entry!("5.4.2", 300.0, 25.0, 0.6, 60.0, PLAIN, "dispatch, packing and handling areas"),
    // Industry and crafts: edition of 2011.
    entry!("5.11.1", 300.0, 25.0, 0.6, 80.0, PLAIN, "electrical industry: cable and wire manufacture"),
    entry!("5.11.2 large coils", 300.0, 25.0, 0.6, 80.0, PLAIN, "electrical industry: winding large coils"),
    entry!("5.11.2 medium coils", 500.0, 22.0, 0.6, 80.0, PLAIN, "electrical industry: winding medium-sized coils"),
    entry!("5.11.2 small coils", 750.0, 19.0, 0.7, 80.0, PLAIN, "electrical industry: winding small coils"),
    entry!("5.11.3", 300.0, 25.0, 0.6, 80.0, PLAIN, "electrical industry: coil impregnating"),
    entry!("5.11.4", 300.0, 25.0, 0.6, 80.0, PLAIN, "electrical industry: galvanising"),
    entry!(
        "5.11.5 rough",
        300.0,
        25.0,
        0.6,
        80.0,
        PLAIN,
        "electrical industry: rough assembly, such as large transformers"
    ),
    entry!(
        "5.11.5 medium",
        500.0,
        22.0,
        0.6,
        80.0,
        PLAIN,
        "electrical industry: medium assembly, such as switchboards"
    ),
    entry!("5.11.5 fine", 750.0, 19.0, 0.7, 80.0, PLAIN, "electrical industry: fine assembly, such as telephones"),
    entry!(
        "5.11.5 precision",
        1000.0,
        16.0,
        0.7,
        80.0,
        PLAIN,
        "electrical industry: precision assembly, such as measuring equipment"
    ),
    entry!("5.11.6", 1500.0, 16.0, 0.7, 80.0, PLAIN, "electronic workshops, testing, adjusting"),
    entry!("5.14.1", 500.0, 19.0, 0.6, 90.0, PLAIN, "hairdressing"),
    entry!("5.18.1", 200.0, 25.0, 0.6, 80.0, PLAIN, "metal working: open die forging"),
    entry!("5.18.2", 300.0, 25.0, 0.6, 80.0, PLAIN, "metal working: drop forging"),
    entry!("5.18.3", 300.0, 25.0, 0.6, 80.0, PLAIN, "metal working: welding"),
    entry!(
        "5.18.4",
        300.0,
        22.0,
        0.6,
        80.0,
        PLAIN,
        "metal working: rough and average machining, tolerances of 0.1 mm and more"
    ),
    entry!(
        "5.18.5",
        500.0,
        19.0,
        0.7,
        80.0,
        PLAIN,
        "metal working: precision machining, grinding, tolerances below 0.1 mm"
    ),
    entry!("5.18.6", 750.0, 19.0, 0.7, 80.0, PLAIN, "metal working: scribing, inspection"),
    entry!("5.18.7", 300.0, 25.0, 0.6, 80.0, PLAIN, "metal working: wire and pipe drawing, cold forming"),
    entry!("5.18.8", 200.0, 25.0, 0.6, 80.0, PLAIN, "metal working: plate machining, 5 mm and more"),
    entry!("5.18.9", 300.0, 22.0, 0.6, 80.0, PLAIN, "metal working: sheet metalwork, below 5 mm"),
    entry!("5.18.10", 750.0, 19.0, 0.7, 80.0, PLAIN, "metal working: tool making, cutting equipment"),
    entry!("5.18.11 rough", 200.0, 25.0, 0.6, 80.0, PLAIN, "metal working: rough assembly"),
    entry!("5.18.11 medium", 300.0, 25.0, 0.6, 80.0, PLAIN, "metal working: medium assembly"),
    entry!("5.18.11 fine", 500.0, 22.0, 0.6, 80.0, PLAIN, "metal working: fine assembly"),
    entry!("5.18.11 precision", 750.0, 19.0, 0.7, 80.0, PLAIN, "metal working: precision assembly"),
    entry!("5.18.12", 300.0, 25.0, 0.6, 80.0, PLAIN, "metal working: galvanising"),
    entry!("5.18.13", 750.0, 25.0, 0.7, 80.0, PLAIN, "metal working: surface preparation and painting"),
    entry!(
        "5.18.14",
        1000.0,
        19.0,
        0.7,
        80.0,
        PLAIN,
        "metal working: tool, template and jig making, precision and micro-mechanics"
    ),
    // Offices, shops, public areas, restaurants, libraries: edition of 2011.
    entry!("5.26.1", 300.0, 19.0, 0.4, 80.0, TALK, "offices: filing, copying"),
    entry!("5.26.2", 500.0, 19.0, 0.6, 80.0, TALK, "offices: writing, typing, reading, data processing"),
    entry!("5.26.3", 750.0, 16.0, 0.7, 80.0, TALK, "offices: technical drawing"),
    entry!("5.26.4", 500.0, 19.0, 0.6, 80.0, TALK, "offices: CAD work stations"),
    entry!("5.26.5", 500.0, 19.0, 0.6, 80.0, TALK, "offices: conference and meeting rooms"),
    entry!("5.26.6", 300.0, 22.0, 0.6, 80.0, TALK, "offices: reception desk"),
    entry!("5.26.7", 200.0, 25.0, 0.4, 80.0, BRIGHT, "offices: archives"),
    entry!("5.27.1", 300.0, 22.0, 0.4, 80.0, PLAIN, "retail: sales area"),
    entry!("5.27.2", 500.0, 19.0, 0.6, 80.0, PLAIN, "retail: till area"),
    entry!("5.27.3", 500.0, 19.0, 0.6, 80.0, PLAIN, "retail: wrapper table"),
    entry!("5.28.1", 100.0, 22.0, 0.4, 80.0, BRIGHT, "public areas: entrance halls"),
    entry!("5.28.2", 200.0, 25.0, 0.4, 80.0, PLAIN, "public areas: cloakrooms"),
    entry!("5.28.3", 200.0, 22.0, 0.4, 80.0, PLAIN, "public areas: lounges"),
    entry!("5.28.4", 300.0, 22.0, 0.6, 80.0, PLAIN, "public areas: ticket offices"),
    entry!("5.29.1", 300.0, 22.0, 0.6, 80.0, PLAIN, "restaurants and hotels: reception, cashier, porter"),
    entry!("5.29.2", 500.0, 22.0, 0.6, 80.0, PLAIN, "restaurants and hotels: kitchens"),
    entry!("5.29.4", 200.0, 22.0, 0.4, 80.0, PLAIN, "restaurants and hotels: self-service restaurants"),
    entry!("5.29.5", 300.0, 22.0, 0.6, 80.0, PLAIN, "restaurants and hotels: buffets"),
    entry!("5.29.6", 500.0, 19.0, 0.6, 80.0, TALK, "restaurants and hotels: conference rooms"),
    entry!("5.29.7", 100.0, 25.0, 0.4, 80.0, BRIGHT, "restaurants and hotels: corridors"),
    entry!("5.33.1", 200.0, 19.0, 0.4, 80.0, PLAIN, "libraries: bookshelves"),
    entry!("5.33.2", 500.0, 19.0, 0.6, 80.0, PLAIN, "libraries: reading areas"),
    entry!("5.33.3", 500.0, 19.0, 0.6, 80.0, PLAIN, "libraries: counters"),
    // Education: edition of 2011.
    entry!("5.35.1", 300.0, 22.0, 0.4, 80.0, TALK, "nursery schools: play rooms"),
    entry!("5.35.2", 300.0, 22.0, 0.4, 80.0, TALK, "nursery schools: nurseries"),
    entry!("5.35.3", 300.0, 19.0, 0.6, 80.0, TALK, "nursery schools: handicraft rooms"),
    entry!("5.36.1", 300.0, 19.0, 0.6, 80.0, TALK, "education: classrooms, tutorial rooms"),
    entry!("5.36.2", 500.0, 19.0, 0.6, 80.0, TALK, "education: classrooms for evening classes and adults"),
    entry!("5.36.3", 500.0, 19.0, 0.6, 80.0, TALK, "education: auditorium, lecture halls"),
    entry!("5.36.4", 500.0, 19.0, 0.7, 80.0, TALK, "education: boards"),
    entry!("5.36.5", 500.0, 19.0, 0.7, 80.0, TALK, "education: demonstration tables"),
    entry!("5.36.6", 500.0, 19.0, 0.6, 80.0, TALK, "education: art rooms"),
    entry!("5.36.7", 750.0, 19.0, 0.7, 90.0, TALK, "education: art rooms in art schools"),
    entry!("5.36.8", 750.0, 16.0, 0.7, 80.0, TALK, "education: technical drawing rooms"),
    entry!("5.36.9", 500.0, 19.0, 0.6, 80.0, TALK, "education: practical rooms and laboratories"),
    entry!("5.36.10", 500.0, 19.0, 0.6, 80.0, TALK, "education: handicraft rooms"),
    entry!("5.36.11", 500.0, 19.0, 0.6, 80.0, TALK, "education: teaching workshops"),
    entry!("5.36.12", 300.0, 19.0, 0.6, 80.0, TALK, "education: music practice rooms"),
    entry!("5.36.13", 300.0, 19.0, 0.6, 80.0, TALK, "education: computer practice rooms"),
    entry!("5.36.14", 300.0, 19.0, 0.6, 80.0, TALK, "education: language laboratories"),
    entry!("5.36.15", 500.0, 22.0, 0.6, 80.0, BRIGHT, "education: preparation rooms and workshops"),
    entry!("5.36.16", 200.0, 22.0, 0.4, 80.0, BRIGHT, "education: entrance halls"),
    entry!("5.36.17", 100.0, 25.0, 0.4, 80.0, BRIGHT, "education: circulation areas, corridors"),
    entry!("5.36.18", 150.0, 25.0, 0.4, 80.0, BRIGHT, "education: stairs"),
    entry!("5.36.19", 200.0, 22.0, 0.4, 80.0, BRIGHT, "education: common rooms and assembly halls"),
    entry!("5.36.20", 300.0, 19.0, 0.6, 80.0, TALK, "education: teachers' rooms"),
    entry!("5.36.21", 200.0, 19.0, 0.6, 80.0, BRIGHT, "education: libraries, bookshelves"),
    entry!("5.36.22", 500.0, 19.0, 0.6, 80.0, BRIGHT, "education: libraries, reading areas"),
    entry!("5.36.23", 100.0, 25.0, 0.4, 80.0, BRIGHT, "education: stock rooms for teaching materials"),
    entry!("5.36.24", 300.0, 22.0, 0.6, 80.0, BRIGHT, "education: sports halls, gymnasiums, swimming pools"),
    entry!("5.36.25", 200.0, 22.0, 0.4, 80.0, BRIGHT, "education: canteens"),
    entry!("5.36.26", 500.0, 22.0, 0.6, 80.0, BRIGHT, "education: kitchens"),
    // Health care: edition of 2011.
    entry!("5.37.1", 200.0, 22.0, 0.4, 80.0, BRIGHT, "health care: waiting rooms"),
    entry!("5.37.2", 100.0, 22.0, 0.4, 80.0, BRIGHT, "health care: corridors during the day"),
    entry!("5.37.4", 50.0, 22.0, 0.4, 80.0, BRIGHT, "health care: corridors during the night"),
    entry!("5.37.5", 200.0, 22.0, 0.6, 80.0, BRIGHT, "health care: corridors of several uses"),
    entry!("5.37.6", 200.0, 22.0, 0.6, 80.0, BRIGHT, "health care: day rooms"),
    entry!("5.38.1", 500.0, 19.0, 0.6, 80.0, BRIGHT, "health care: staff offices"),
    entry!("5.38.2", 300.0, 19.0, 0.6, 80.0, BRIGHT, "health care: staff rooms"),
    entry!("5.39.1", 100.0, 19.0, 0.4, 80.0, BRIGHT, "health care: wards, general lighting"),
    entry!("5.39.2", 300.0, 19.0, 0.7, 80.0, BRIGHT, "health care: wards, reading"),
    entry!("5.39.3", 300.0, 19.0, 0.6, 80.0, BRIGHT, "health care: wards, simple examinations"),
    entry!("5.39.4", 1000.0, 19.0, 0.7, 90.0, BRIGHT, "health care: wards, examination and treatment"),
    entry!("5.39.6", 200.0, 22.0, 0.4, 80.0, BRIGHT, "health care: bathrooms and toilets for patients"),
    entry!("5.40.1", 500.0, 19.0, 0.6, 90.0, BRIGHT, "health care: examination rooms, general lighting"),
    entry!("5.40.2", 1000.0, 19.0, 0.7, 90.0, BRIGHT, "health care: examination and treatment"),
    entry!("5.46.1", 500.0, 19.0, 0.6, 90.0, BRIGHT, "health care: pre-op and recovery rooms"),
    entry!("5.46.2", 1000.0, 19.0, 0.6, 90.0, BRIGHT, "health care: operating theatres"),
    entry!("5.47.1", 100.0, 19.0, 0.6, 90.0, BRIGHT, "health care: intensive care, general lighting"),
    entry!("5.47.2", 300.0, 19.0, 0.6, 90.0, BRIGHT, "health care: intensive care, simple examinations"),
    entry!("5.47.3", 1000.0, 19.0, 0.7, 90.0, BRIGHT, "health care: intensive care, examination and treatment"),
    entry!("5.48.1", 500.0, 19.0, 0.6, 90.0, BRIGHT, "health care: dentists, general lighting"),
    entry!("5.49.1", 500.0, 19.0, 0.6, 80.0, BRIGHT, "health care: laboratories and pharmacies"),
    // The edition of 2021, with the average for greater need of light (modified), and those of cylinders, walls and the ceiling.
    entry!("9.1", 100.0, 28.0, 0.4, 40.0, space_limits(150.0, 50.0, 50.0, 30.0), "circulation areas and corridors"),
    entry!("9.2", 100.0, 25.0, 0.4, 40.0, space_limits(150.0, 50.0, 50.0, 30.0), "stairs, escalators"),
    entry!("10.1", 200.0, 22.0, 0.4, 80.0, space_limits(300.0, 75.0, 75.0, 50.0), "canteens, pantries"),
    entry!("10.4", 200.0, 25.0, 0.4, 80.0, space_limits(300.0, 75.0, 75.0, 50.0), "cloakrooms, washrooms, toilets"),
    entry!("34.1", 300.0, 19.0, 0.4, 80.0, space_limits(500.0, 100.0, 100.0, 75.0), "offices: filing, copying"),
    entry!(
        "34.2",
        500.0,
        19.0,
        0.6,
        80.0,
        space_limits(1000.0, 150.0, 150.0, 100.0),
        "offices: writing, typing, reading, data processing"
    ),
    entry!("34.3", 750.0, 16.0, 0.7, 80.0, space_limits(1500.0, 150.0, 150.0, 100.0), "offices: technical drawing"),
    entry!("34.4", 500.0, 19.0, 0.6, 80.0, space_limits(1000.0, 150.0, 150.0, 100.0), "offices: CAD work stations"),
    entry!(
        "34.5.1",
        500.0,
        19.0,
        0.6,
        80.0,
        space_limits(1000.0, 150.0, 150.0, 100.0),
        "offices: conference and meeting rooms"
    ),
    entry!("34.5.2", 500.0, 19.0, 0.6, 80.0, space_limits(1000.0, 150.0, 150.0, 100.0), "offices: conference tables"),
    entry!("34.6", 300.0, 22.0, 0.6, 80.0, space_limits(750.0, 100.0, 100.0, 75.0), "offices: reception desk"),
    entry!("34.7", 200.0, 25.0, 0.4, 80.0, space_limits(300.0, 75.0, 75.0, 50.0), "offices: archives"),
    entry!("44.1", 500.0, 19.0, 0.6, 80.0, space_limits(1000.0, 150.0, 150.0, 100.0), "education: classrooms"),
    sports!("I", 750.0, 0.7),
    sports!("II", 500.0, 0.7),
    sports!("III", 200.0, 0.5),
    StandardEntry {
        standard: Standard::Emergency,
        reference: "escape route",
        task: "emergency lighting: escape route",
        limits: &[(Measure::DirectMinimumLx, 1.0), (Measure::DirectUniformityUd, 1.0 / 40.0)],
        colour_rendering_ra: None,
        space: None,
    },
    StandardEntry {
        standard: Standard::Emergency,
        reference: "open area",
        task: "emergency lighting: open area",
        limits: &[(Measure::DirectMinimumLx, 0.5), (Measure::DirectUniformityUd, 1.0 / 40.0)],
        colour_rendering_ra: None,
        space: None,
    },
];

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn entries_are_named_once_and_hold_numbers_of_the_standards_own_steps() {
        let references: BTreeSet<(u8, &str)> =
            ENTRIES.iter().map(|entry| (entry.standard as u8, entry.reference)).collect();
        assert_eq!(references.len(), ENTRIES.len());
        for entry in ENTRIES {
            for (measure, limit) in entry.limits {
                let steps: &[f64] = match measure {
                    Measure::AverageLx => &[50.0, 100.0, 150.0, 200.0, 300.0, 500.0, 750.0, 1000.0, 1500.0],
                    Measure::UniformityU0 => &[0.4, 0.5, 0.6, 0.7],
                    Measure::Ugr => &[16.0, 19.0, 22.0, 25.0, 28.0],
                    Measure::DirectMinimumLx => &[0.5, 1.0],
                    Measure::DirectUniformityUd => &[0.025],
                    Measure::MinimumLx | Measure::MaximumLx | Measure::UniformityUd => &[],
                };
                assert!(steps.contains(limit), "{entry:?}");
            }
            let is_of_work_places = entry.standard == Standard::WorkPlaces;
            assert_eq!(entry.space.is_some(), is_of_work_places, "{entry:?}");
            assert!(entry.colour_rendering_ra.is_none_or(|ra| [40.0, 60.0, 80.0, 90.0].contains(&ra)), "{entry:?}");
            let Some(space) = entry.space else { continue };
            // Ceilings may be darker than walls, as they are farther from people's eyes. The modified average is greater than the normal
            // one.
            assert!(space.ceiling_lx < space.walls_lx && space.cylindrical_lx >= 50.0, "{entry:?}");
            let average_lx = entry.limit(Measure::AverageLx).expect("an average");
            assert!(space.modified_lx.is_none_or(|modified_lx| modified_lx > average_lx), "{entry:?}");
            assert_eq!(space.modified_lx.is_some(), !entry.reference.starts_with("5."), "{entry:?}");
        }
    }
}
