//! A run for all front ends: options as text, checked against a scene, solved, and written.

use std::path::Path;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use super::exit::Failure;
use super::memory::check_memory;
use super::method::{self, MethodChoice, Plots, method};
use super::proportions::check_proportions;
use super::results::stage_results;
use super::selection::{maps_of_part, select_maps};
use super::values;
use super::verdict_target::{self, Target, target};
use crate::base::memory::peak_bytes;
use crate::geometry::position_accuracy_m;
use crate::methods::{MeshChoice, check_light_mesh, solve_by_light_mesh, solve_by_radiosity};
use crate::output::{
    Language, PartOfRun, ReportContext, ResultDirectory, ResultFile, RunRecord, StreamedFile, summary_file,
};
use crate::radiosity::Radiosity;
use crate::scene::{ReceiversPart, Scene};
use crate::solver::{
    ElementChoice, GoingOn, MapSums, Method, Observer, Portion, Settings, ShareRecord, Solution, StopReason,
    VerdictLadder, resume, resume_share, solve_share, solve_to_verdicts,
};

/// The settings of a run: the options of `luxmc solve`.
///
/// ```
/// let mut options = luxmc::RunOptions::default();
/// options.set("target_error", "2%")?;
/// options.set("method", "light-mesh")?;
/// assert!(options.set("target_error", "200%").is_err_and(|failure| failure.to_string().contains("remedy")));
/// # Ok::<(), luxmc::Failure>(())
/// ```
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// How the maps are computed.
    pub method: MethodChoice,
    /// Which elements the element map has.
    pub elements: ElementChoice,
    /// How the mesh of [`MethodChoice::LightMesh`] is made.
    pub mesh: MeshChoice,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Target of the stated error as a fraction; 0.01 if no stop rule is given.
    pub target_error: Option<f64>,
    /// Further goal of the run. If it is set, `target_error` is the smallest error that the run goes to.
    pub target: Option<Target>,
    /// Number of chains for every map, if fixed.
    pub chains: Option<u64>,
    /// Time limit in s by the observer's clock, if any.
    pub time_limit_s: Option<f64>,
    /// Maps that are computed and bound to the target, as `--maps` names them.
    pub maps: Option<String>,
    /// Worker threads; `None`: all processors.
    pub threads: Option<usize>,
    /// The part of the receivers that is computed; `None`: all.
    pub receivers_part: Option<ReceiversPart>,
}

impl Default for RunOptions {
    fn default() -> RunOptions {
        RunOptions {
            method: MethodChoice::AUTO,
            elements: ElementChoice::Adaptive,
            mesh: MeshChoice::default(),
            seed: 0,
            target_error: None,
            target: None,
            chains: None,
            time_limit_s: None,
            maps: None,
            threads: None,
            receivers_part: None,
        }
    }
}

impl RunOptions {
    /// Names that [`RunOptions::set`] accepts.
    pub const NAMES: [&str; 9] =
        ["method", "elements", "seed", "target_error", "target", "chains", "time_limit", "maps", "threads"];

    /// Sets an option by its name, with underscores, to a value as the command line writes it: `1%`, `60s`, `1e6`.
    ///
    /// # Errors
    ///
    /// A name that is not in [`RunOptions::NAMES`], and a value that the command line refuses, with its message.
    pub fn set(&mut self, name: &str, text: &str) -> Result<(), Failure> {
        let refuse = |remedy: String| Failure::Usage {
            what: format!("invalid value for {name}"),
            got: format!("{text:?}"),
            expected: format!("a value that --{} of luxmc solve accepts", name.replace('_', "-")),
            remedy,
        };
        match name {
            "method" => self.method = method(text).map_err(refuse)?,
            "elements" => self.elements = method::elements(text).map_err(refuse)?,
            "seed" => self.seed = values::seed(text).map_err(refuse)?,
            "target_error" => self.target_error = Some(values::target_error(text).map_err(refuse)?),
            "target" => self.target = Some(target(text).map_err(refuse)?),
            "chains" => self.chains = Some(values::chains(text).map_err(refuse)?),
            "time_limit" => self.time_limit_s = Some(values::time_s(text).map_err(refuse)?),
            "maps" => self.maps = Some(text.to_owned()),
            "threads" => self.threads = Some(values::threads(text).map_err(refuse)?),
            _ => {
                return Err(Failure::Usage {
                    what: "a run has no such option".to_owned(),
                    got: format!("{name:?}"),
                    expected: RunOptions::NAMES.join(", "),
                    remedy: "use one of those".to_owned(),
                });
            }
        }
        Ok(())
    }

    fn settings(&self, scene: &Scene) -> Result<Settings, Failure> {
        if let (Some(method), Some(chains)) = (self.method.name_without_chains(), self.chains) {
            return Err(Failure::Usage {
                what: format!("{method} traces no chains"),
                got: format!("--chains {chains} with --method {method}"),
                expected: "--target-error, --time-limit, or neither".to_owned(),
                remedy: "leave out --chains, or use --method collision, which traces them".to_owned(),
            });
        }
        let mut settings = Settings {
            method: match self.method {
                MethodChoice::By(method) => method,
                MethodChoice::Radiosity | MethodChoice::LightMesh => Method::Collision,
            },
            elements: self.elements,
            seed: self.seed,
            target_error: self.target_error,
            chains: self.chains,
            time_limit_s: self.time_limit_s,
            maps: select_maps(self.maps.as_deref(), scene)?,
            threads: self.threads,
        };
        if self.target.is_some() {
            verdict_target::settle(&mut settings, scene)?;
        }
        Ok(settings)
    }
}

/// A scene and the options of a run, checked against each other. After that, only a lack of memory or disk can stop the run.
#[derive(Debug)]
pub struct SceneRun {
    scene: Scene,
    options: RunOptions,
    settings: Settings,
    pool: rayon::ThreadPool,
    /// Digest of the scene with all its receivers, if the run has only a part of them.
    digest_of_whole: Option<String>,
}

impl SceneRun {
    /// Checks options against a scene; `file` names the scene in messages. Doubts about the scene are added to its warnings.
    ///
    /// # Errors
    ///
    /// As `luxmc solve`: maps that the scene does not have, a method that cannot compute it, a scene that rays cannot resolve, or
    /// more memory than there is.
    pub fn new(mut scene: Scene, file: &str, options: RunOptions) -> Result<SceneRun, Failure> {
        check_proportions(&mut scene, file)?;
        let mut settings = options.settings(&scene)?;
        match options.method {
            MethodChoice::Radiosity => Radiosity::check(&scene)?,
            MethodChoice::LightMesh => check_light_mesh(&scene, &settings)?,
            _ => {}
        }
        let digest_of_whole = options.receivers_part.map(|_| scene.digest());
        if let Some(part) = options.receivers_part {
            settings.maps = maps_of_part(part, &settings.maps, &scene)?;
            scene.keep_part(part);
        }
        check_memory(&scene, &settings)?;
        let pool = thread_pool(options.threads)?;
        Ok(SceneRun { scene, options, settings, pool, digest_of_whole })
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The digest of the scene as it was read, with all its receivers.
    pub fn scene_digest(&self) -> String {
        self.digest_of_whole.clone().unwrap_or_else(|| self.scene.digest())
    }

    /// Ends computing before the time limit, so that the work after it ends in time.
    pub fn compute_until(&mut self, limit_s: f64) {
        self.settings.time_limit_s = Some(limit_s);
    }

    /// The settings for the solver.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Worker threads of the run.
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Runs work on the run's threads.
    pub fn on_its_threads<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.pool.install(work)
    }

    /// Computes the maps by the chosen method, on the run's threads.
    ///
    /// # Errors
    ///
    /// Radiosity and light meshes without time for any result.
    pub fn solve(&self, observer: &dyn Observer) -> Result<Solution, Failure> {
        self.solve_from(None, observer)
    }

    /// The same, from the beginning or resumed from a checkpoint. Methods without chains cannot be resumed.
    pub(super) fn solve_from(&self, going_on: Option<GoingOn>, observer: &dyn Observer) -> Result<Solution, Failure> {
        let (scene, settings) = (&self.scene, &self.settings);
        self.on_its_threads(|| match (self.options.target, going_on) {
            (Some(Target::Verdicts), _) => {
                let ladder = VerdictLadder::down_to(settings.target_error);
                solve_to_verdicts(scene, settings, ladder, |settings| self.solve_once(settings, observer))
            }
            (None, Some(going_on)) => Ok(resume(scene, settings, going_on, observer)),
            (None, None) => self.solve_once(settings, observer),
        })
    }

    /// Computes one run from the beginning by the chosen method.
    fn solve_once(&self, settings: &Settings, observer: &dyn Observer) -> Result<Solution, Failure> {
        let scene = &self.scene;
        match self.options.method {
            MethodChoice::Radiosity => solve_by_radiosity(scene, settings, observer).map_err(Failure::from),
            MethodChoice::LightMesh => {
                solve_by_light_mesh(scene, settings, &self.options.mesh, observer).map_err(Failure::from)
            }
            _ => Ok(crate::solver::solve(scene, settings, observer)),
        }
    }

    /// Computes a share with its own settings, for a run in rounds.
    #[cfg(feature = "mpi")]
    pub(super) fn solve_share_by(
        &self,
        settings: &Settings,
        portion: Portion,
        observer: &dyn Observer,
    ) -> (Solution, ShareRecord, Vec<MapSums>) {
        self.on_its_threads(|| solve_share(&self.scene, settings, portion, observer))
    }

    /// Computes a portion of the run, from the beginning or resumed from a checkpoint.
    pub(super) fn solve_share(
        &self,
        portion: Portion,
        going_on: Option<GoingOn>,
        observer: &dyn Observer,
    ) -> (Solution, ShareRecord, Vec<MapSums>) {
        let (scene, settings) = (&self.scene, &self.settings);
        self.on_its_threads(|| match going_on {
            Some(going_on) => resume_share(scene, settings, portion, going_on, observer),
            None => solve_share(scene, settings, portion, observer),
        })
    }
}

/// Starts a pool of threads: as many as there are processors if `None`.
pub fn thread_pool(threads: Option<usize>) -> Result<rayon::ThreadPool, Failure> {
    // Rayon takes 0 as all processors.
    let wanted = threads.unwrap_or(0);
    rayon::ThreadPoolBuilder::new().num_threads(wanted).build().map_err(|error| Failure::Usage {
        what: "the threads cannot be started".to_owned(),
        got: format!("--threads {wanted}: {error}"),
        expected: "a number of threads that the system grants".to_owned(),
        remedy: "ask for fewer threads".to_owned(),
    })
}

/// Facts on a run, besides its scene and solution, for its files.
#[derive(Clone, Debug)]
pub struct RunStory {
    /// The scene file, as named by the user.
    pub scene: String,
    /// The command that reproduces the run.
    pub command: String,
    /// Worker threads.
    pub threads: usize,
    /// Seconds from the start until the scene was read.
    pub read_s: f64,
    /// Seconds from the start until computing ended.
    pub computed_s: f64,
    /// Formats of plots; `None`: SVG.
    pub plots: Option<Plots>,
    /// Language of report and plots.
    pub language: Language,
    /// Whether this is a whole run or a part of one.
    pub part: PartOfRun,
}

impl RunStory {
    /// The file `summary.json` of a run with these files.
    pub fn summary(&self, scene: &Scene, solution: &Solution, files: Vec<String>, write_s: f64) -> ResultFile {
        let record = RunRecord {
            scene: self.scene.clone(),
            read_s: self.read_s,
            write_s,
            wall_s: self.computed_s + write_s,
            threads: self.threads,
            peak_memory_bytes: peak_bytes(),
            position_accuracy_m: position_accuracy_m(scene),
            files,
            part: self.part,
        };
        summary_file(scene, solution, &record)
    }

    /// Writes all files of a run and the file `more` into a directory. They appear together or not at all. Returns `summary.json`.
    ///
    /// # Errors
    ///
    /// Files that cannot be written.
    pub fn write(
        &self,
        scene: &Scene,
        solution: &Solution,
        more: Option<StreamedFile>,
        mut directory: ResultDirectory,
    ) -> Result<ResultFile, Failure> {
        let write_started = Instant::now();
        let context = ReportContext {
            scene: self.scene.clone(),
            command: self.command.clone(),
            repeats_digits: solution.stop_reason == StopReason::Chains,
            unix_time_s: SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs()),
            wall_s: self.computed_s,
            threads: self.threads,
            language: self.language,
        };
        stage_results(scene, solution, &context, self.plots, &mut directory)?;
        if let Some(file) = more {
            directory.stage_streamed(&file)?;
        }
        let summary = self.summary(scene, solution, directory.names(), write_started.elapsed().as_secs_f64());
        directory.stage(&summary)?;
        directory.commit()?;
        Ok(summary)
    }

    /// The same into a directory given by its path, which is made if it is missing.
    ///
    /// # Errors
    ///
    /// As [`RunStory::write`], and a directory that cannot be made or written to.
    pub fn save(&self, scene: &Scene, solution: &Solution, directory: &Path) -> Result<ResultFile, Failure> {
        self.write(scene, solution, None, ResultDirectory::open(directory)?)
    }
}
