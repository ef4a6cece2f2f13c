//! Settings of a run and its results.

use serde::{Deserialize, Serialize};

use super::glare_rating::GlareRating;
use super::spending::Spending;
use crate::control::Forecast;
use crate::maps::{Judgement, MapError, MapResult};
use crate::scene::Elements;

/// Method name of maps that gather.
const GATHERING: &str = "gather";
/// Target if the user sets no stop rule at all.
pub const DEFAULT_TARGET_ERROR: f64 = 0.01;

/// How maps are estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Method {
    /// For each map, the method that a short pilot finds the quickest.
    #[default]
    Auto,
    /// Elements by counting the packets of chains, receivers by walks. It is unbiased.
    Collision,
    /// Both by gathering through cells, with an error that independent walks measure.
    Gather,
    /// Receivers by local estimation: the vertices of chains score at all of them. Elements are counted.
    Local,
    /// Local estimation with the plain kernel, whose variance has no bound in corners. It serves to show this.
    LocalNaive,
}

impl Method {
    /// All methods.
    pub const ALL: [Method; 5] = [Method::Auto, Method::Collision, Method::Gather, Method::Local, Method::LocalNaive];

    /// Name as `summary.json` writes it.
    pub fn name(self) -> &'static str {
        match self {
            Method::Auto => "auto",
            Method::Collision => "collision",
            Method::Gather => "gather",
            Method::Local => "local",
            Method::LocalNaive => "local-naive",
        }
    }
}

/// Which elements the element map has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ElementChoice {
    /// The elements of the scene: its triangles, or the parts that `max_element_edge` cuts them into. Their true values are their means.
    #[default]
    Given,
    /// The elements of the scene, cut further and given slopes as far as the target requires, if the target binds the element map. The true
    /// value is the illuminance at every point.
    Adaptive,
}

/// What a run should do.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// How maps are estimated.
    pub method: Method,
    /// Which elements the element map has.
    pub elements: ElementChoice,
    /// Seed of all random streams.
    pub seed: u64,
    /// Target of the stated error as a fraction, if one is set.
    pub target_error: Option<f64>,
    /// Chains for every map, if fixed.
    pub chains: Option<u64>,
    /// Seconds from process start, if limited.
    pub time_limit_s: Option<f64>,
    /// Which maps are computed.
    pub maps: MapSelection,
    /// Worker threads; `None`: as many as the machine has.
    pub threads: Option<usize>,
}

/// The maps that a run computes and, if they are named, binds to the target.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum MapSelection {
    /// No `--maps`: all are computed; the target binds the receiver sets if there are any, else the element map.
    #[default]
    Default,
    /// All maps, all bound.
    All,
    /// The element map alone.
    Elements,
    /// All receiver sets.
    Receivers,
    /// Named sets (`elements` is the element map).
    Named(Vec<String>),
}

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The stop rule accepted every bound map.
    TargetMet,
    /// The requested chains are done.
    Chains,
    /// The time limit came first.
    TimeLimit,
    /// The user interrupted it.
    Interrupted,
    /// Every map is exact: there is nothing left to do.
    Exact,
    /// The finest mesh that a method with elements makes did not meet the target.
    FinestMesh,
    /// All shares are merged.
    Shares,
    /// Every requirement that the run had to decide is decided.
    VerdictsDecided,
    /// Requirements are closer to their limits than the smallest error of a run for verdicts.
    Undecided,
}

impl StopReason {
    /// Name as `summary.json` writes it.
    pub fn name(self) -> &'static str {
        match self {
            StopReason::TargetMet => "target_met",
            StopReason::Chains => "chains",
            StopReason::TimeLimit => "time_limit",
            StopReason::Interrupted => "interrupted",
            StopReason::Exact => "exact",
            StopReason::FinestMesh => "finest_mesh",
            StopReason::Shares => "shares",
            StopReason::VerdictsDecided => "verdicts_decided",
            StopReason::Undecided => "undecided",
        }
    }
}

/// Destinations of the flux of the forward chains, in lm, scaled to the luminaires' flux.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FluxBalance {
    /// Emitted.
    pub emitted_lm: f64,
    /// Absorbed on surfaces (and on bright balls).
    pub absorbed_lm: f64,
    /// Left the scene.
    pub escaped_lm: f64,
    /// Absorbed on the backs of one-sided surfaces.
    pub back_face_lm: f64,
    /// Followed no further, after very many reflections or past a time limit.
    pub truncated_lm: f64,
}

/// Comparison of Σ absorptance·E·A with the emitted flux, in a scene that no flux left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapCheck {
    /// Σ absorptance·E·A in lm.
    pub absorbed_by_map_lm: f64,
    /// Its standard error in lm.
    pub standard_error_lm: f64,
    /// Deviation from the emitted flux in standard errors.
    pub z_score: f64,
}

/// The state of a run at one time, and its forecast then.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ConvergenceRow {
    /// Seconds since process start.
    pub wall_s: f64,
    /// Rays so far, including those of pilots.
    pub rays: u64,
    /// Chains so far, all maps.
    pub chains: u64,
    /// Errors of the bound map with the worst stated error.
    pub error: ErrorParts,
    /// Whether all bound maps have been judged. Before that, maps not yet judged enter with the error that their pilot predicts.
    pub judged: bool,
    /// Forecast of the rays at the end.
    pub forecast_rays: Forecast,
    /// Forecast of the seconds from process start to the end.
    pub forecast_wall_s: Forecast,
}

/// The stated error of a map and its parts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorParts {
    /// The stated error: its parts in quadrature.
    pub estimated: f64,
    /// Random error.
    pub random: f64,
    /// Error that even and odd halves share.
    pub bias: f64,
    /// Error of what elements cannot show.
    pub discretisation: f64,
}

impl ErrorParts {
    /// Parts of a purely random error.
    pub fn random(error: f64) -> ErrorParts {
        ErrorParts { estimated: error, random: error, ..ErrorParts::default() }
    }

    /// Parts of an error without a random part.
    pub fn bias(error: f64) -> ErrorParts {
        ErrorParts { estimated: error, bias: error, ..ErrorParts::default() }
    }

    /// Parts of the error of a judgement.
    pub fn of(judgement: &Judgement) -> ErrorParts {
        ErrorParts {
            estimated: judgement.stated_error(),
            random: judgement.halves_error,
            bias: judgement.bias,
            discretisation: judgement.discretisation,
        }
    }
}

/// All results of a run.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The requested method.
    pub method: String,
    /// Seed used.
    pub seed: u64,
    /// Target, if one was set.
    pub target_error: Option<f64>,
    /// Chains traced, all maps.
    pub chains: u64,
    /// Rays traced, all kinds.
    pub rays: u64,
    /// Independent replicas, even and odd together.
    pub replicas: usize,
    /// One entry for each computed map: elements first, then receivers in file order.
    pub maps: Vec<MapResult>,
    /// The elements of the element map: those of the scene, or those adapted to the light.
    pub elements: Elements,
    /// Glare ratings of observers, in the order of their maps.
    pub glare: Vec<GlareRating>,
    /// Worst stated error of the bound maps.
    pub estimated_error: f64,
    /// Whether the stop rule accepted all bound maps; `None` without a target.
    pub target_met: Option<bool>,
    /// Why the run ended.
    pub stop_reason: StopReason,
    /// Flux balance of the chains, or the reason why there is none.
    pub flux_balance: Result<FluxBalance, String>,
    /// Check of the element map, or the reason why there is none.
    pub map_check: Result<MapCheck, String>,
    /// The states of the run and its forecasts, in order.
    pub convergence: Vec<ConvergenceRow>,
    /// Rays and seconds by kind of work.
    pub spending: Spending,
    /// Seconds from process start to the start of computing: starting, reading and building.
    pub begun_wall_s: f64,
    /// Seconds for building the ray accelerator.
    pub build_s: f64,
    /// Seconds of computing.
    pub compute_s: f64,
    /// Classes of light paths that a map's method cannot find, in words.
    pub paths_not_found: Vec<String>,
    /// Warnings for the user.
    pub warnings: Vec<String>,
    /// How the results were made: facts that need no action.
    pub notes: Vec<String>,
}

impl Solution {
    /// Whether the entries of the map with this name took their light from cells.
    pub fn is_gathered(&self, name: &str) -> bool {
        self.maps.iter().any(|map| map.name == name && map.method == GATHERING)
    }

    /// Worst stated error of the bound maps. `None` if light has not reached one of them, or if all are left out, since then the error is
    /// unknown.
    pub fn stated_error(&self) -> Option<f64> {
        Some(self.estimated_error).filter(|error| error.is_finite() && !self.is_unlit())
    }

    /// Whether light has not reached one of the bound maps.
    pub fn is_unlit(&self) -> bool {
        self.maps.iter().any(|map| map.bound && map.error.dark_upper_bound.is_some())
    }

    /// Why a target was not met, if more work is not the only thing missing: words that follow "since". `None` if the target was met, if
    /// none was set, or if the error explains it.
    pub fn why_unmet(&self) -> Option<String> {
        let target = self.target_error?;
        let map = self.maps.iter().find(|map| map.bound && map.target_met == Some(false))?;
        if let Some(check) = map.checks.iter().find(|check| !check.passed) {
            return Some(format!("the check \"{}\" of \"{}\" failed: {}", check.name, map.name, check.explanation));
        }
        if map.error.dark_upper_bound.is_some() {
            return Some(format!("no light has reached \"{}\" yet", map.name));
        }
        let worst = |of: fn(&MapError) -> f64| {
            let unmet = self.maps.iter().filter(|map| map.bound && map.target_met == Some(false));
            unmet.filter(|map| of(&map.error) >= target).max_by(|a, b| of(&a.error).total_cmp(&of(&b.error)))
        };
        if let Some(map) = worst(|error| error.discretisation) {
            let more = match self.stop_reason {
                StopReason::FinestMesh => {
                    ": smaller elements at the start (max_element_edge) may resolve more, and --elements given \
                     computes only their means"
                }
                _ => ", and the run ended before they were subdivided further",
            };
            return Some(format!(
                "the discretisation error of the elements of \"{}\", {} of its mean, exceeds the target by \
                 itself{more}",
                map.name,
                percent(map.error.discretisation)
            ));
        }
        if let Some(map) = worst(|error| error.bias).filter(|map| self.is_gathered(&map.name)) {
            return Some(format!(
                "the error that the cells of \"{}\" have in common, {}, exceeds the target by itself, and walks had \
                 not removed it yet",
                map.name,
                percent(map.error.bias)
            ));
        }
        (self.estimated_error <= target).then(|| {
            format!(
                "the halves of \"{}\" agree well by luck: judged by the spread of all replicas, its error may be \
                 above the target in more than one run of twenty",
                map.name
            )
        })
    }
}

/// A share as a percentage for sentences.
fn percent(share: f64) -> String {
    format!("{:.3} %", 100.0 * share)
}
