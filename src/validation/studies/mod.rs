//! Studies: cost and error of a method over a range of steps, luminaires or receivers, reported by tables and plots.
//!
//! `luxmc compare` runs them by name, like cases. Most studies measure the benefit of light meshes (Debelov and Sevastyanov, 2001;
//! Debelov and Novikov, 2009). Two others measure how cost grows with a scene and how well `auto` chooses. Times depend on the
//! machine and its load; rays and errors do not.

mod choice;
mod crossing;
mod forms;
mod indirect_forms;
mod interpolation;
pub mod open_air;
mod penumbra;
mod pictures;
mod report;
mod savings;
mod scaling;
pub mod shadow_rivals;
mod slopes;
mod sources;
mod steps;
pub mod study_scene;
pub mod wheel;

use super::report::Table;

pub use interpolation::{DirectForm, Interpolation};
pub use pictures::{PlotLine, log_log};
pub use report::{study_csv, study_md, study_section};

/// Options of a study, and its listener.
pub struct StudyWishes<'a> {
    /// Use small sizes: seconds instead of minutes, to test that the study works.
    pub quick: bool,
    /// Restriction of the studies of forms.
    pub only: Only,
    /// Receives a message at every step.
    pub tell: &'a mut dyn FnMut(&str),
}

/// Restriction of the studies of forms; `None` means no restriction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Only {
    /// Form in which a mesh point stores direct light.
    pub direct: Option<DirectForm>,
    /// Interpolation; both weights of a sphere count as one.
    pub interpolation: Option<Interpolation>,
}

impl Only {
    fn takes(self, form: DirectForm) -> bool {
        self.direct.is_none_or(|only| only == form)
    }

    fn interpolations(self) -> impl Iterator<Item = Interpolation> + Clone {
        let takes = move |way: &Interpolation| self.interpolation.is_none_or(|only| only.word() == way.word());
        Interpolation::ALL.into_iter().filter(takes)
    }
}

/// A study.
pub struct Study {
    /// Name for `luxmc compare`.
    pub name: &'static str,
    /// Subject in one line.
    pub title: &'static str,
    /// Runs the study; an error describes what could not be set up.
    pub run: fn(&mut StudyWishes) -> Result<Findings, String>,
}

/// The name of the group of all light-mesh studies.
pub const GROUP: &str = "light-mesh";

/// All studies.
pub const STUDIES: &[Study] = &[
    Study {
        name: "light-mesh-luminaires",
        title: "Light mesh and shadow rays: time against the number of luminaires",
        run: crossing::over_luminaires,
    },
    Study {
        name: "light-mesh-receivers",
        title: "Light mesh and shadow rays: time against the number of receivers",
        run: crossing::over_receivers,
    },
    Study {
        name: "light-mesh-savings",
        title: "Savings by each acceleration of the light mesh",
        run: savings::accelerations,
    },
    Study { name: "light-mesh-memory", title: "Memory of the light mesh, sparse against dense", run: savings::memory },
    Study { name: "light-mesh-steps", title: "Error of the light mesh against its step and radius", run: steps::steps },
    Study {
        name: "light-mesh-forms",
        title: "Direct light on the mesh as one number and as visibility, with four interpolations",
        run: forms::forms,
    },
    Study {
        name: "light-mesh-indirect",
        title: "Indirect light on the mesh as one number and by planes, with four interpolations",
        run: indirect_forms::indirect_forms,
    },
    Study {
        name: "light-mesh-penumbra",
        title: "Width of soft shadows: a ball's penumbra and the light mesh",
        run: penumbra::penumbra,
    },
    Study {
        name: "light-mesh-sources",
        title: "An area source as 1, 5, 25 and 225 point sources, and by the light mesh",
        run: sources::sources,
    },
    Study {
        name: "shadow-rivals",
        title: "Shadow methods of games compared with the light mesh and shadow rays",
        run: shadow_rivals::shadow_rivals,
    },
    Study {
        name: "scaling",
        title: "Cost against the number of triangles, luminaires and receivers",
        run: scaling::scaling,
    },
    Study { name: "choice", title: "Cost of the method auto compared with the best fixed method", run: choice::choice },
];

/// The studies with this name: one, all light-mesh studies, or none.
pub fn studies_named(name: &str) -> Vec<&'static Study> {
    let is_of_group = |study: &Study| name == GROUP && study.name.starts_with(GROUP);
    STUDIES.iter().filter(|study| study.name == name || is_of_group(study)).collect()
}

/// Note for readers of results with small sizes.
const QUICK: &str = "Small sizes: they show that the study works, not how good a method is.";

/// Results of a study.
#[derive(Clone, Debug)]
pub struct Findings {
    /// Name of the study.
    pub name: &'static str,
    /// Heading of the study.
    pub title: &'static str,
    /// Description of the setting, and how to read the tables.
    pub setting: String,
    /// Results in sentences with numbers.
    pub results: Vec<String>,
    /// Tables of numbers, each with its caption.
    pub tables: Vec<(String, Table)>,
    /// SVG pictures, each with its caption.
    pub pictures: Vec<(String, String)>,
}

impl Findings {
    /// Creates empty findings of a study.
    fn of(name: &'static str, setting: &str) -> Findings {
        let title = STUDIES.iter().find(|study| study.name == name).map_or("", |study| study.title);
        let (results, tables, pictures) = (Vec::new(), Vec::new(), Vec::new());
        Findings { name, title, setting: setting.to_owned(), results, tables, pictures }
    }

    /// Adds a note if the sizes are small.
    pub fn marked(mut self, quick: bool) -> Findings {
        if quick {
            self.results.insert(0, QUICK.to_owned());
        }
        self
    }
}
