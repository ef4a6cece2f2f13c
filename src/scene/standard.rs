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

/// What of a room an entry of EN 12464-1 is asked about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Area {
    /// Where the task is; observers belong to it.
    Task,
    /// The band about it.
    Surroundings,
    /// What lies beyond the band.
    Background,
    /// Walls.
    Walls,
    /// The ceiling.
    Ceiling,
    /// Small upright cylinders where people's heads are.
    Cylinders,
}

impl Area {
    /// Name in files, and in English for reading.
    pub fn name(self) -> &'static str {
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

/// What a receiver set is to keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Requirement {
    /// What it is about.
    pub measure: Measure,
    /// What of the room.
    pub area: Area,
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
    /// Colour rendering R_a at least; `None` where it asks for none. Luminaires keep it, which nothing here computes.
    pub colour_rendering_ra: Option<f64>,
    /// What it asks for about the task; `None` of other standards than EN 12464-1.
    pub space: Option<SpaceLimits>,
}

/// What an entry of EN 12464-1 asks for besides the task area, in lx of average illuminance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpaceLimits {
    /// Of the task area where people see worse or work needs more care; `None` in the edition of 2011.
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

/// How references of the edition of 2011 begin, as far as entries have them.
const BEFORE_2021: &str = "5.";

/// Keys of `requirements`: the measures in their order, the standards, and the share of the flux.
pub(super) const KEYS: [&str; 14] = [
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
    AREA,
    MODIFIED,
];
/// Keys that name an entry.
pub(super) const STANDARDS: [(&str, Standard); 3] =
    [("en_12464_1", Standard::WorkPlaces), ("en_12193", Standard::Sports), ("en_1838", Standard::Emergency)];
/// Key of what of the room is meant.
pub(super) const AREA: &str = "area";
/// What it can name.
pub(super) const AREAS: [Area; 5] = [Area::Task, Area::Surroundings, Area::Background, Area::Walls, Area::Ceiling];
/// Key by which the modified average is asked for.
pub(super) const MODIFIED: &str = "modified";
/// Key of the share of the flux that counts.
pub(super) const FLUX_FACTOR: &str = "flux_factor";

impl StandardEntry {
    /// What it asks of a measure of the task area.
    pub(super) fn limit(&self, measure: Measure) -> Option<f64> {
        self.limits.iter().find(|(of, _)| *of == measure).map(|(_, limit)| *limit)
    }

    /// What it asks of a measure of an area of the room, with the task's average in lx as asked for, if any is.
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

/// What is asked of a measure of what lies about the task, with its average.
pub(super) fn limit_about(area: Area, measure: Measure, average_lx: f64) -> Option<f64> {
    match measure {
        Measure::AverageLx => Some(average_lx),
        Measure::UniformityU0 if area == Area::Surroundings => Some(0.4),
        Measure::UniformityU0 => Some(0.1),
        _ => None,
    }
}

/// The scale of illuminances of EN 12464-1 in lx, from where surroundings are less bright than the task on.
const SCALE_LX: [f64; 5] = [150.0, 200.0, 300.0, 500.0, 750.0];

/// Average illuminance in lx of the immediate surroundings: the next lower step of the scale, 500 lx at most, and the task's own up to 150 lx.
///
/// Source: EN 12464-1, relationship of illuminances on immediate surrounding to task area.
pub(super) fn surroundings_lx(task_lx: f64) -> f64 {
    /// More is asked for nowhere.
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
        assert!(Measure::ALL.iter().zip(KEYS).all(|(measure, key)| measure.key() == key));
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
