//! Requirements of receivers, and entries of the schedule of EN 12464-1 that name them.

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
    /// Unified glare rating, that of the worst observer, at most.
    Ugr,
}

impl Measure {
    /// All of them, in the order of tables.
    pub const ALL: [Measure; 6] = [
        Measure::AverageLx,
        Measure::MinimumLx,
        Measure::MaximumLx,
        Measure::UniformityU0,
        Measure::UniformityUd,
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
        matches!(self, Measure::AverageLx | Measure::MinimumLx | Measure::MaximumLx)
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
}

/// An entry of the schedule of EN 12464-1, as far as verdicts need it.
#[derive(Debug, PartialEq)]
pub struct StandardEntry {
    /// Reference number.
    pub reference: &'static str,
    /// Task or activity.
    pub task: &'static str,
    /// Maintained average illuminance in lx of the task area, at least.
    pub average_lx: f64,
    /// U0, at least.
    pub uniformity_u0: f64,
    /// Rating limit of glare, at most.
    pub ugr: f64,
}

impl StandardEntry {
    /// The standard with its edition, and the reference.
    pub fn name(&self) -> String {
        let edition = if self.reference.starts_with(BEFORE_2021) { 2011 } else { 2021 };
        format!("EN 12464-1:{edition}, {}", self.reference)
    }
}

/// How references of the edition of 2011 begin, as far as entries have them.
const BEFORE_2021: &str = "5.";

/// Keys of `requirements`: the measures in their order, and the standard.
pub(super) const KEYS: [&str; 7] =
    ["average_lx", "minimum_lx", "maximum_lx", "uniformity", "uniformity_ud", "ugr", STANDARD];
/// Key that names an entry.
pub(super) const STANDARD: &str = "en_12464_1";

const fn entry(
    reference: &'static str,
    average_lx: f64,
    ugr: f64,
    uniformity_u0: f64,
    task: &'static str,
) -> StandardEntry {
    StandardEntry { reference, task, average_lx, uniformity_u0, ugr }
}

/// Common entries: those that begin with 5 have the numbers of the edition of 2011, the others of that of 2021 (required values, not
/// modified ones). The standard itself is the authority.
pub(super) const ENTRIES: &[StandardEntry] = &[
    entry("5.1.1", 100.0, 28.0, 0.4, "circulation areas and corridors"),
    entry("5.1.2", 100.0, 25.0, 0.4, "stairs, escalators"),
    entry("5.2.1", 200.0, 22.0, 0.4, "canteens, pantries"),
    entry("5.2.2", 100.0, 22.0, 0.4, "rest rooms"),
    entry("5.2.3", 300.0, 22.0, 0.4, "rooms for physical exercise"),
    entry("5.2.4", 200.0, 25.0, 0.4, "cloakrooms, washrooms, toilets"),
    entry("5.4.1", 100.0, 25.0, 0.4, "store and stockrooms"),
    entry("5.4.2", 300.0, 25.0, 0.6, "dispatch, packing and handling areas"),
    entry("5.26.1", 300.0, 19.0, 0.4, "offices: filing, copying"),
    entry("5.26.2", 500.0, 19.0, 0.6, "offices: writing, typing, reading, data processing"),
    entry("5.26.3", 750.0, 16.0, 0.7, "offices: technical drawing"),
    entry("5.26.4", 500.0, 19.0, 0.6, "offices: CAD work stations"),
    entry("5.26.5", 500.0, 19.0, 0.6, "offices: conference and meeting rooms"),
    entry("5.26.6", 300.0, 22.0, 0.6, "offices: reception desk"),
    entry("5.26.7", 200.0, 25.0, 0.4, "offices: archives"),
    entry("5.27.1", 300.0, 22.0, 0.4, "retail: sales area"),
    entry("5.27.2", 500.0, 19.0, 0.6, "retail: till area"),
    entry("5.28.1", 100.0, 22.0, 0.4, "public areas: entrance halls"),
    entry("5.36.1", 300.0, 19.0, 0.6, "education: classrooms, tutorial rooms"),
    entry("5.36.2", 500.0, 19.0, 0.6, "education: classrooms for evening classes and adults"),
    entry("5.36.3", 500.0, 19.0, 0.6, "education: auditorium, lecture halls"),
    entry("34.1", 300.0, 19.0, 0.4, "offices: filing, copying"),
    entry("34.2", 500.0, 19.0, 0.6, "offices: writing, typing, reading, data processing"),
    entry("34.3", 750.0, 16.0, 0.7, "offices: technical drawing"),
    entry("34.4", 500.0, 19.0, 0.6, "offices: CAD work stations"),
    entry("34.5.1", 500.0, 19.0, 0.6, "offices: conference and meeting rooms"),
    entry("34.7", 200.0, 25.0, 0.4, "offices: archives"),
];

impl StandardEntry {
    /// What it asks of a measure.
    pub(super) fn limit(&self, measure: Measure) -> Option<f64> {
        match measure {
            Measure::AverageLx => Some(self.average_lx),
            Measure::UniformityU0 => Some(self.uniformity_u0),
            Measure::Ugr => Some(self.ugr),
            Measure::MinimumLx | Measure::MaximumLx | Measure::UniformityUd => None,
        }
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
            assert!([100.0, 200.0, 300.0, 500.0, 750.0].contains(&entry.average_lx), "{entry:?}");
            assert!([0.4, 0.6, 0.7].contains(&entry.uniformity_u0), "{entry:?}");
            assert!([16.0, 19.0, 22.0, 25.0, 28.0].contains(&entry.ugr), "{entry:?}");
        }
    }
}
