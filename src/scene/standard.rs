//! Requirements of receivers, and entries of standards that contain them.

use super::keys::{ABOVE_ZERO, BOOLEAN, Key, SHARE_ABOVE_ZERO, TEXT, ValueShape, from_to, optional};

/// Quantity that a requirement limits.
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
    /// Unified glare rating of the worst observer, at most.
    Ugr,
}

impl Measure {
    /// All measures, in the order of tables.
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

    /// Key in scene files and result files.
    pub fn key(self) -> &'static str {
        KEYS[self as usize].name
    }

    /// Whether the limit is a least value; otherwise it is a greatest value.
    pub fn is_at_least(self) -> bool {
        !matches!(self, Measure::MaximumLx | Measure::Ugr)
    }

    /// Whether it is an illuminance in lx.
    pub fn is_illuminance(self) -> bool {
        matches!(self, Measure::AverageLx | Measure::MinimumLx | Measure::MaximumLx | Measure::DirectMinimumLx)
    }

    /// Whether only direct light counts.
    pub fn is_direct(self) -> bool {
        matches!(self, Measure::DirectMinimumLx | Measure::DirectUniformityUd)
    }
}

/// Area of a room that an entry of EN 12464-1 refers to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Area {
    /// The task area; observers belong to it.
    Task,
    /// The band about the task area.
    Surroundings,
    /// The area beyond the band.
    Background,
    /// Walls.
    Walls,
    /// The ceiling.
    Ceiling,
    /// Small upright cylinders at the height of people's heads.
    Cylinders,
}

impl Area {
    /// Name as in files, an English word.
    pub const fn name(self) -> &'static str {
        match self {
            Area::Task => "task",
            Area::Surroundings => "surroundings",
            Area::Background => "background",
            Area::Walls => "walls",
            Area::Ceiling => "ceiling",
            Area::Cylinders => "cylindrical",
        }
    }
}

/// A requirement of a receiver set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Requirement {
    /// Limited quantity.
    pub measure: Measure,
    /// Area of the room.
    pub area: Area,
    /// The least or greatest value allowed.
    pub limit: f64,
    /// The entry that contains it; `None` if the scene gives the number.
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

/// An entry of a standard, with the data for verdicts.
#[derive(Debug, PartialEq)]
pub struct StandardEntry {
    /// The standard.
    pub standard: Standard,
    /// Reference number, class or kind.
    pub reference: &'static str,
    /// Task or activity.
    pub task: &'static str,
    /// Limits by measure, for the task area.
    pub limits: &'static [(Measure, f64)],
    /// Least colour rendering R_a; `None` if none is required. Luminaires must meet it; it is not computed here.
    pub colour_rendering_ra: Option<f64>,
    /// Limits for other areas of the room; `None` for standards other than EN 12464-1.
    pub space: Option<SpaceLimits>,
}

/// Limits of an entry of EN 12464-1 for other areas than the task, in lx of average illuminance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpaceLimits {
    /// For the task area if people see worse or the work needs more care; `None` in the edition of 2011.
    pub modified_lx: Option<f64>,
    /// On small upright cylinders.
    pub cylindrical_lx: f64,
    /// On the walls.
    pub walls_lx: f64,
    /// On the ceiling.
    pub ceiling_lx: f64,
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

/// Beginning of the references of the 2011 edition, among the entries here.
const BEFORE_2021: &str = "5.";

/// Keys of `requirements`: the measures in order, the standards, and the others.
#[rustfmt::skip]
pub(super) const KEYS: [Key; 14] = [
    optional("average_lx", ABOVE_ZERO, "Least average, in lx."),
    optional("minimum_lx", ABOVE_ZERO, "Least minimum, in lx."),
    optional("maximum_lx", ABOVE_ZERO, "Greatest maximum, in lx."),
    optional("uniformity", SHARE_ABOVE_ZERO, "Least uniformity U0, minimum over average."),
    optional("uniformity_ud", SHARE_ABOVE_ZERO, "Least uniformity Ud, minimum over maximum."),
    optional("direct_minimum_lx", ABOVE_ZERO, "Required minimum of the direct illuminance times `flux_factor`, in lx."),
    optional("direct_uniformity_ud", SHARE_ABOVE_ZERO, "Required minimum over maximum of the direct illuminance."),
    optional("ugr", from_to(10.0, 40.0), "Greatest glare rating of any observer."),
    optional("en_12464_1", TEXT,
        "Reference of an entry of EN 12464-1, such as \"34.2\" (2021) or \"5.26.2\" (2011). Numbers beside it replace those of the entry."),
    optional("en_12193", TEXT, "Class of EN 12193 of ball games in halls: \"I\", \"II\" or \"III\"."),
    optional("en_1838", TEXT, "Emergency lighting by EN 1838: \"escape route\" or \"open area\"; direct light only."),
    optional(FLUX_FACTOR, SHARE_ABOVE_ZERO, "Share of the luminous flux that remains on batteries, for requirements on direct light; 1 by default."),
    optional(AREA, ValueShape::Choice(&AREA_NAMES), "Part of the room to which the entry of EN 12464-1 applies; the task area by default."),
    IS_MODIFIED,
];
/// Key that selects the modified average.
pub(super) const IS_MODIFIED: Key =
    optional(MODIFIED, BOOLEAN, "Whether the entry's modified average is required; false by default.");
/// Keys that name an entry.
pub(super) const STANDARDS: [(&str, Standard); 3] =
    [("en_12464_1", Standard::WorkPlaces), ("en_12193", Standard::Sports), ("en_1838", Standard::Emergency)];
/// Key of the area of the room.
pub(super) const AREA: &str = "area";
/// Values of that key.
pub(super) const AREAS: [Area; 5] = [Area::Task, Area::Surroundings, Area::Background, Area::Walls, Area::Ceiling];
const AREA_NAMES: [&str; AREAS.len()] =
    [AREAS[0].name(), AREAS[1].name(), AREAS[2].name(), AREAS[3].name(), AREAS[4].name()];
/// Name of the key that selects the modified average.
pub(super) const MODIFIED: &str = "modified";
/// Key of the share of the flux that counts.
pub(super) const FLUX_FACTOR: &str = "flux_factor";

impl StandardEntry {
    /// Limit of a measure for the task area.
    pub(super) fn limit(&self, measure: Measure) -> Option<f64> {
        self.limits.iter().find(|(of, _)| *of == measure).map(|(_, limit)| *limit)
    }

    /// Limit of a measure for an area of the room. `task_lx` is the required average of the task in lx, if there is one.
    pub(super) fn limit_of(&self, area: Area, measure: Measure, task_lx: Option<f64>) -> Option<f64> {
        let average_lx = match (area, self.space) {
            (Area::Task, _) => return if measure == Measure::AverageLx { task_lx } else { self.limit(measure) },
            (Area::Surroundings, _) => surroundings_lx(task_lx?),
            (Area::Background, _) => background_lx(task_lx?),
            (Area::Walls, space) => space?.walls_lx,
            (Area::Ceiling, space) => space?.ceiling_lx,
            (Area::Cylinders, space) => space?.cylindrical_lx,
        };
        limit_about(area, measure, average_lx)
    }
}

/// Limit of a measure for another area than the task. `average_lx` is the required average of that area.
pub(super) fn limit_about(area: Area, measure: Measure, average_lx: f64) -> Option<f64> {
    match measure {
        Measure::AverageLx => Some(average_lx),
        Measure::UniformityU0 if area == Area::Surroundings => Some(0.4),
        Measure::UniformityU0 => Some(0.1),
        _ => None,
    }
}

/// The scale of illuminances of EN 12464-1 in lx. It begins where surroundings may be darker than the task.
const SCALE_LX: [f64; 5] = [150.0, 200.0, 300.0, 500.0, 750.0];

/// Average illuminance in lx for the immediate surroundings: the next lower step of the scale, at most 500 lx. Up to 150 lx it is the
/// task's own.
///
/// Source: EN 12464-1, relationship of illuminances on immediate surrounding to task area.
pub(super) fn surroundings_lx(task_lx: f64) -> f64 {
    /// Greatest value in lx for surroundings.
    const MOST_LX: f64 = 500.0;
    let lower = SCALE_LX.into_iter().rev().find(|step_lx| *step_lx < task_lx);
    lower.unwrap_or(task_lx).min(MOST_LX)
}

/// Average illuminance in lx of the background: a third of that of the immediate surroundings.
pub(super) fn background_lx(task_lx: f64) -> f64 {
    surroundings_lx(task_lx) / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measures_have_the_keys_of_their_places() {
        assert!(Measure::ALL.iter().zip(KEYS).all(|(measure, key)| measure.key() == key.name));
    }

    /// The table of EN 12464-1, and an average between its steps.
    #[test]
    fn surroundings_are_a_step_darker_than_the_task() {
        let table = [
            (1000.0, 500.0),
            (750.0, 500.0),
            (500.0, 300.0),
            (400.0, 300.0),
            (300.0, 200.0),
            (200.0, 150.0),
            (150.0, 150.0),
            (100.0, 100.0),
            (50.0, 50.0),
        ];
        for (task_lx, about_lx) in table {
            assert_eq!(surroundings_lx(task_lx), about_lx, "{task_lx}");
        }
        assert_eq!(background_lx(500.0), 100.0);
    }
}
