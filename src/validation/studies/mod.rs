//! Studies: what a method costs and changes over a range of steps, luminaires or receivers, told by tables and plots.
//!
//! `luxmc compare` runs them by name beside cases. Those of light meshes ask what these are worth (Debelov and Sevastyanov,
//! 2001; Debelov and Novikov, 2009), two more how cost grows with a scene and how well `auto` chooses. Times are of the machine and its load; rays and errors are not.

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
pub mod world;

use super::report::Table;

pub use interpolation::{DirectForm, Interpolation};
pub use pictures::{PlotLine, log_log};
pub use report::{study_csv, study_md, study_section};

/// What a study is told to do, and whom it tells.
pub struct StudyWishes<'a> {
    /// Small sizes: seconds instead of minutes, to see that it works.
    pub quick: bool,
    /// Forms that the studies of forms leave it at.
    pub only: Only,
    /// Hears of every step.
    pub tell: &'a mut dyn FnMut(&str),
}

/// What the studies of forms leave it at; all of what is `None`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Only {
    /// What a mesh point keeps of direct light.
    pub direct: Option<DirectForm>,
    /// How places take it; both weights of a sphere go together.
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
    /// Name, as `luxmc compare` takes it.
    pub name: &'static str,
    /// What it asks, in one line.
    pub title: &'static str,
    /// Runs it; an error says what could not be made.
    pub run: fn(&mut StudyWishes) -> Result<Findings, String>,
}

/// The name that stands for all studies of light meshes.
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
        title: "What each acceleration of the light mesh saves",
        run: savings::accelerations,
    },
    Study { name: "light-mesh-memory", title: "Memory of the light mesh, sparse against dense", run: savings::memory },
    Study { name: "light-mesh-steps", title: "Error of the light mesh against its step and radius", run: steps::steps },
    Study {
        name: "light-mesh-forms",
        title: "Direct light on the mesh as one number and as visibility, by four ways of taking it",
        run: forms::forms,
    },
    Study {
        name: "light-mesh-indirect",
        title: "Indirect light on the mesh as one number and by planes, by four ways of taking it",
        run: indirect_forms::indirect_forms,
    },
    Study {
        name: "light-mesh-penumbra",
        title: "Width of soft shadows: a ball's penumbra and the light mesh",
        run: penumbra::penumbra,
    },
    Study {
        name: "light-mesh-sources",
        title: "An area as 1, 5, 25 and 225 point sources, and by the light mesh",
        run: sources::sources,
    },
    Study {
        name: "shadow-rivals",
        title: "Shadows as games make them beside the light mesh and shadow rays",
        run: shadow_rivals::shadow_rivals,
    },
    Study {
        name: "scaling",
        title: "Cost against the number of triangles, luminaires and receivers",
        run: scaling::scaling,
    },
    Study { name: "choice", title: "What the method auto costs beside the best fixed choice", run: choice::choice },
];

/// The studies that a name stands for: one, or all of light meshes; none if it is no study's.
pub fn studies_named(name: &str) -> Vec<&'static Study> {
    let is_of_group = |study: &Study| name == GROUP && study.name.starts_with(GROUP);
    STUDIES.iter().filter(|study| study.name == name || is_of_group(study)).collect()
}

/// What a reader must know of small sizes.
const QUICK: &str = "Small sizes: they show that the study works, not what a method is worth.";

/// What a study found.
#[derive(Clone, Debug)]
pub struct Findings {
    /// Name of the study.
    pub name: &'static str,
    /// Its heading.
    pub title: &'static str,
    /// What was set up, and how to read the tables.
    pub setting: String,
    /// What came out, in sentences with numbers.
    pub results: Vec<String>,
    /// Numbers, each table with its caption.
    pub tables: Vec<(String, Table)>,
    /// SVG pictures, each with its caption.
    pub pictures: Vec<(String, String)>,
}

impl Findings {
    /// Nothing found yet.
    fn of(name: &'static str, setting: &str) -> Findings {
        let title = STUDIES.iter().find(|study| study.name == name).map_or("", |study| study.title);
        let (results, tables, pictures) = (Vec::new(), Vec::new(), Vec::new());
        Findings { name, title, setting: setting.to_owned(), results, tables, pictures }
    }

    /// Says that the sizes are small, where they are.
    pub fn marked(mut self, quick: bool) -> Findings {
        if quick {
            self.results.insert(0, QUICK.to_owned());
        }
        self
    }
}
