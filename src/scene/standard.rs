//! Requirements of receivers, and entries of standards that name them.

/// What a requirement is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// Ē in lx, at least.
    AverageLx,
    /// Emin in lx, at least.
    MinimumLx,
    /// Emax in lx, at most.
    MaximumLx,
    /// U0 = Emin/Ē, at least.
    UniformityU0,
    /// Ud = Emin/Emax, at least.
    UniformityUd,
    /// Emin of direct light in lx, at least.
    DirectMinimumLx,
    /// Emin/Emax of direct light, at least.
    DirectUniformityUd,
    /// Unified glare rating, that of the worst observer, at most.
    Ugr,
}

impl Measure {
    /// All of them, in the order of tables.
    pub const ALL: [Measure; 8] = [
        Measure::AverageLx,
        Measure::MinimumLx,
        Measure::MaximumLx,
        Measure::UniformityU0,
        Measure::UniformityUd,
        Measure::DirectMinimumLx,
        Measure::DirectUniformityUd,
        Measure::Ugr,
    ];

    /// Key by which scene files and result files name it.
    pub fn key(self) -> &'static str {
        KEYS[self as usize]
    }

    /// Whether the value must be at least the limit; else at most.
    pub fn is_at_least(self) -> bool {
        !matches!(self, Measure::MaximumLx | Measure::Ugr)
    }

    /// Whether it is an illuminance in lx.
    pub fn is_illuminance(self) -> bool {
        matches!(self, Measure::AverageLx | Measure::MinimumLx | Measure::MaximumLx | Measure::DirectMinimumLx)
    }

    /// Whether it is about direct light alone.
    pub fn is_direct(self) -> bool {
        matches!(self, Measure::DirectMinimumLx | Measure::DirectUniformityUd)
    }
}

/// What a receiver set is to keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Requirement {
    /// What it is about.
    pub measure: Measure,
    /// The least or greatest value allowed.
    pub limit: f64,
    /// The entry that asks for it; `None` where the scene gives the number.
    pub entry: Option<&'static StandardEntry>,
    /// Share of the flux that counts; less than 1 on batteries.
    pub flux_factor: f64,
}

/// A standard that has entries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standard {
    /// EN 12464-1, indoor work places.
    WorkPlaces,
    /// EN 12193, sports.
    Sports,
    /// EN 1838, emergency lighting.
    Emergency,
}

/// An entry of a standard, as far as verdicts need it.
#[derive(Debug, PartialEq)]
pub struct StandardEntry {
    /// The standard.
    pub standard: Standard,
    /// Reference number, class or kind.
    pub reference: &'static str,
    /// Task or activity.
    pub task: &'static str,
    /// What it asks for, measure by measure.
    pub limits: &'static [(Measure, f64)],
}

impl StandardEntry {
    /// The standard with its edition, and the reference.
    pub fn name(&self) -> String {
        match self.standard {
            Standard::WorkPlaces => {
                let edition = if self.reference.starts_with(BEFORE_2021) { 2011 } else { 2021 };
                format!("EN 12464-1:{edition}, {}", self.reference)
            }
            Standard::Sports => format!("EN 12193, {}", self.reference),
            Standard::Emergency => "EN 1838".to_owned(),
        }
    }
}

/// How references of the edition of 2011 begin, as far as entries have them.
const BEFORE_2021: &str = "5.";

/// Keys of `requirements`: the measures in their order, the standards, and the share of the flux.
pub(super) const KEYS: [&str; 12] = [
    "average_lx",
    "minimum_lx",
    "maximum_lx",
    "uniformity",
    "uniformity_ud",
    "direct_minimum_lx",
    "direct_uniformity_ud",
    "ugr",
    "en_12464_1",
    "en_12193",
    "en_1838",
    FLUX_FACTOR,
];
/// Keys that name an entry.
pub(super) const STANDARDS: [(&str, Standard); 3] =
    [("en_12464_1", Standard::WorkPlaces), ("en_12193", Standard::Sports), ("en_1838", Standard::Emergency)];
/// Key of the share of the flux that counts.
pub(super) const FLUX_FACTOR: &str = "flux_factor";

/// An entry of EN 12464-1.
macro_rules! entry {
    ($reference:literal, $average_lx:literal, $ugr:literal, $uniformity_u0:literal, $task:literal) => {
        StandardEntry {
            standard: Standard::WorkPlaces,
            reference: $reference,
            task: $task,
            limits: &[(Measure::AverageLx, $average_lx), (Measure::UniformityU0, $uniformity_u0), (Measure::Ugr, $ugr)],
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
        }
    };
}

/// Common entries of EN 12464-1: those that begin with 5 have the numbers of the edition of 2011, the others of that of 2021 (required values,
/// not modified ones); classes of EN 12193 of basketball, handball, volleyball and indoor football; and what EN 1838 asks of direct light.
/// The standards themselves are the authority.
pub(super) const ENTRIES: &[StandardEntry] = &[
    entry!("5.1.1", 100.0, 28.0, 0.4, "circulation areas and corridors"),
    entry!("5.1.2", 100.0, 25.0, 0.4, "stairs, escalators"),
    entry!("5.2.1", 200.0, 22.0, 0.4, "canteens, pantries"),
    entry!("5.2.2", 100.0, 22.0, 0.4, "rest rooms"),
    entry!("5.2.3", 300.0, 22.0, 0.4, "rooms for physical exercise"),
    entry!("5.2.4", 200.0, 25.0, 0.4, "cloakrooms, washrooms, toilets"),
    entry!("5.4.1", 100.0, 25.0, 0.4, "store and stockrooms"),
    entry!("5.4.2", 300.0, 25.0, 0.6, "dispatch, packing and handling areas"),
    entry!("5.26.1", 300.0, 19.0, 0.4, "offices: filing, copying"),
    entry!("5.26.2", 500.0, 19.0, 0.6, "offices: writing, typing, reading, data processing"),
    entry!("5.26.3", 750.0, 16.0, 0.7, "offices: technical drawing"),
    entry!("5.26.4", 500.0, 19.0, 0.6, "offices: CAD work stations"),
    entry!("5.26.5", 500.0, 19.0, 0.6, "offices: conference and meeting rooms"),
    entry!("5.26.6", 300.0, 22.0, 0.6, "offices: reception desk"),
    entry!("5.26.7", 200.0, 25.0, 0.4, "offices: archives"),
    entry!("5.27.1", 300.0, 22.0, 0.4, "retail: sales area"),
    entry!("5.27.2", 500.0, 19.0, 0.6, "retail: till area"),
    entry!("5.28.1", 100.0, 22.0, 0.4, "public areas: entrance halls"),
    entry!("5.36.1", 300.0, 19.0, 0.6, "education: classrooms, tutorial rooms"),
    entry!("5.36.2", 500.0, 19.0, 0.6, "education: classrooms for evening classes and adults"),
    entry!("5.36.3", 500.0, 19.0, 0.6, "education: auditorium, lecture halls"),
    entry!("34.1", 300.0, 19.0, 0.4, "offices: filing, copying"),
    entry!("34.2", 500.0, 19.0, 0.6, "offices: writing, typing, reading, data processing"),
    entry!("34.3", 750.0, 16.0, 0.7, "offices: technical drawing"),
    entry!("34.4", 500.0, 19.0, 0.6, "offices: CAD work stations"),
    entry!("34.5.1", 500.0, 19.0, 0.6, "offices: conference and meeting rooms"),
    entry!("34.7", 200.0, 25.0, 0.4, "offices: archives"),
    sports!("I", 750.0, 0.7),
    sports!("II", 500.0, 0.7),
    sports!("III", 200.0, 0.5),
    StandardEntry {
        standard: Standard::Emergency,
        reference: "escape route",
        task: "emergency lighting: escape route",
        limits: &[(Measure::DirectMinimumLx, 1.0), (Measure::DirectUniformityUd, 1.0 / 40.0)],
    },
    StandardEntry {
        standard: Standard::Emergency,
        reference: "open area",
        task: "emergency lighting: open area",
        limits: &[(Measure::DirectMinimumLx, 0.5), (Measure::DirectUniformityUd, 1.0 / 40.0)],
    },
];

impl StandardEntry {
    /// What it asks of a measure.
    pub(super) fn limit(&self, measure: Measure) -> Option<f64> {
        self.limits.iter().find(|(of, _)| *of == measure).map(|(_, limit)| *limit)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn entries_are_named_once_and_hold_numbers_of_the_standards_own_steps() {
        let references: BTreeSet<&str> = ENTRIES.iter().map(|entry| entry.reference).collect();
        assert_eq!(references.len(), ENTRIES.len());
        for entry in ENTRIES {
            for (measure, limit) in entry.limits {
                let steps: &[f64] = match measure {
                    Measure::AverageLx => &[100.0, 200.0, 300.0, 500.0, 750.0],
                    Measure::UniformityU0 => &[0.4, 0.5, 0.6, 0.7],
                    Measure::Ugr => &[16.0, 19.0, 22.0, 25.0, 28.0],
                    Measure::DirectMinimumLx => &[0.5, 1.0],
                    Measure::DirectUniformityUd => &[0.025],
                    Measure::MinimumLx | Measure::MaximumLx | Measure::UniformityUd => &[],
                };
                assert!(steps.contains(limit), "{entry:?}");
            }
        }
        assert!(Measure::ALL.iter().zip(KEYS).all(|(measure, key)| measure.key() == key));
    }
}
