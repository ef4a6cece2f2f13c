//! luxmc computes illuminance and luminance of a lit scene, with an error it can vouch for.
//!
//! `README.md` describes the program `luxmc`, and `docs/formats.md` its files. This page is for users who compute from Rust: read a
//! scene, solve it, use its maps.
//!
//! # Read a scene
//!
//! [`read_scene`] reads a scene file and all files that it names; [`scene_from_json`] reads the text of a scene. The result is a
//! [`Scene`] in SI units that is valid as a whole. A fault in a file is reported here, by a [`SceneError`] that states the position,
//! what was expected, and a remedy.
//!
//! ```
//! use std::path::Path;
//!
//! let text = r#"{ "version": 1,
//!   "materials": { "paint": { "type": "diffuse", "reflectance": 0.5 } },
//!   "geometry": [ { "name": "room", "type": "box", "min": [0, 0, 0], "max": [4, 3, 2.5], "facing": "inward", "material": "paint" } ],
//!   "luminaires": [ { "name": "lamp", "type": "point", "position": [2, 1.5, 2.2], "luminous_flux_lm": 3000 } ],
//!   "receivers": [ { "name": "desk", "type": "grid", "origin": [1, 1, 0.8], "u": [2, 0, 0], "v": [0, 1, 0],
//!     "columns": 8, "rows": 4 } ] }"#;
//! let scene = luxmc::scene_from_json(text, None, Path::new("."))?;
//! assert_eq!((scene.triangles.len(), scene.luminaires.len()), (12, 1));
//!
//! let error = luxmc::scene_from_json(&text.replace("0.5", "1.5"), None, Path::new(".")).expect_err("a reflectance over 1");
//! assert!(error.to_string().contains("remedy"));
//! # Ok::<(), luxmc::SceneError>(())
//! ```
//!
//! # Solve it
//!
//! [`solve`] computes the maps that [`Settings`] select. It ends when their target error is met, a limit is reached, or the
//! [`Observer`] interrupts it; [`Silent`] is an observer that does nothing. Without a time limit the same seed gives the same bytes on
//! any number of threads.
//!
//! ```
//! use luxmc::{MapSelection, Settings, Silent, solve};
//!
//! # let text = r#"{ "version": 1,
//! #   "materials": { "paint": { "type": "diffuse", "reflectance": 0.5 } },
//! #   "geometry": [ { "name": "room", "type": "box", "min": [0, 0, 0], "max": [4, 3, 2.5], "facing": "inward", "material": "paint" } ],
//! #   "luminaires": [ { "name": "lamp", "type": "point", "position": [2, 1.5, 2.2], "luminous_flux_lm": 3000 } ],
//! #   "receivers": [ { "name": "desk", "type": "grid", "origin": [1, 1, 0.8], "u": [2, 0, 0], "v": [0, 1, 0],
//! #     "columns": 8, "rows": 4 } ] }"#;
//! # let scene = luxmc::scene_from_json(text, None, std::path::Path::new("."))?;
//! let settings = Settings { target_error: Some(0.02), maps: MapSelection::Receivers, seed: 1, ..Settings::default() };
//! let solution = solve(&scene, &settings, &Silent);
//! assert_eq!(solution.target_met, Some(true));
//! assert!(solution.estimated_error <= 0.02);
//! # Ok::<(), luxmc::SceneError>(())
//! ```
//!
//! # Use its maps
//!
//! A [`Solution`] has a [`MapResult`] for the elements of all surfaces and for each set of receivers. It holds values, each with a
//! standard error, in the unit of its `quantity`: illuminances in lx, or for other receivers luminances in cd/m² or intensities in cd.
//! It also has table rows with average, least and greatest value and uniformity.
//!
//! ```
//! # use luxmc::{MapSelection, Settings, Silent, solve};
//! # let text = r#"{ "version": 1,
//! #   "materials": { "paint": { "type": "diffuse", "reflectance": 0.5 } },
//! #   "geometry": [ { "name": "room", "type": "box", "min": [0, 0, 0], "max": [4, 3, 2.5], "facing": "inward", "material": "paint" } ],
//! #   "luminaires": [ { "name": "lamp", "type": "point", "position": [2, 1.5, 2.2], "luminous_flux_lm": 3000 } ],
//! #   "receivers": [ { "name": "desk", "type": "grid", "origin": [1, 1, 0.8], "u": [2, 0, 0], "v": [0, 1, 0],
//! #     "columns": 8, "rows": 4 } ] }"#;
//! # let scene = luxmc::scene_from_json(text, None, std::path::Path::new("."))?;
//! # let settings = Settings { target_error: Some(0.02), maps: MapSelection::Receivers, seed: 1, ..Settings::default() };
//! # let solution = solve(&scene, &settings, &Silent);
//! let desk = &solution.maps[0];
//! assert_eq!((desk.name.as_str(), desk.values.value.len(), desk.quantity.unit()), ("desk", 8 * 4, "lx"));
//! let average = desk.tables[0].average;
//! println!("Ē = {:.0} ± {:.0} lx, U0 = {:.2}", average.value, average.standard_error, desk.tables[0].uniformity_u0.value);
//! assert!(average.value > 100.0 && average.standard_error < 0.02 * average.value);
//! # Ok::<(), luxmc::SceneError>(())
//! ```
//!
//! # Run it as the program does
//!
//! A [`SceneRun`] takes the options of `luxmc solve` as text ([`RunOptions`]) and checks them against the scene as the program does. It
//! offers all methods of the program, and [`RunStory`] writes the program's files. A [`Failure`] has the program's error message and
//! exit code.
//!
//! ```
//! use luxmc::{RunOptions, SceneRun, Silent};
//!
//! # let text = r#"{ "version": 1,
//! #   "materials": { "paint": { "type": "diffuse", "reflectance": 0.5 } },
//! #   "geometry": [ { "name": "room", "type": "box", "min": [0, 0, 0], "max": [4, 3, 2.5], "facing": "inward", "material": "paint" } ],
//! #   "luminaires": [ { "name": "lamp", "type": "point", "position": [2, 1.5, 2.2], "luminous_flux_lm": 3000 } ],
//! #   "receivers": [ { "name": "desk", "type": "grid", "origin": [1, 1, 0.8], "u": [2, 0, 0], "v": [0, 1, 0],
//! #     "columns": 8, "rows": 4 } ] }"#;
//! # let scene = luxmc::scene_from_json(text, None, std::path::Path::new("."))?;
//! let mut options = RunOptions::default();
//! options.set("target_error", "2%")?;
//! options.set("maps", "table")?;
//! let failure = SceneRun::new(scene.clone(), "office.json", options.clone()).expect_err("there is no such map");
//! assert!(failure.to_string().contains("desk") && failure.exit().number() == 2);
//!
//! options.set("maps", "desk")?;
//! let solution = SceneRun::new(scene, "office.json", options)?.solve(&Silent)?;
//! assert_eq!(solution.target_met, Some(true));
//! # Ok::<(), luxmc::Failure>(())
//! ```
//!
//! # An exact solution
//!
//! The illuminance of a point source between two infinite parallel planes is known exactly. [`sobolev`] computes it, direct and
//! reflected, to twelve digits.
//!
//! ```
//! use luxmc::{SobolevPlane, SobolevProblem, sobolev};
//!
//! // A source of 1 cd half-way between planes 1 m apart, with reflectance 0.5; 1 m beside the foot of its perpendicular.
//! let problem = SobolevProblem { h1: 0.5, rho1: 0.5, rho2: 0.5 };
//! let found = sobolev(&problem, SobolevPlane::One, 1.0).expect("a problem with a solution");
//! assert!((found.direct_lx - 0.5 / 1.25f64.powf(1.5)).abs() < 1e-12);
//! assert!(found.total_lx > found.direct_lx);
//! ```
//!
//! # All other types
//!
//! The other types on this page stand in the fields and signatures of those named above.
//!
//! # Internal modules
//!
//! The rest of the library is for developers of luxmc itself. It is not shown here, and changes without notice.
//! `docs/architecture.md` describes its rooms, and `CONTRIBUTING.md` lists the files that a new material, luminaire or estimator
//! touches.

#[doc(inline)]
pub use analytic::sobolev::{SobolevPlane, SobolevProblem, sobolev};
#[doc(inline)]
pub use check::{read_scene, scene_from_json};
#[doc(inline)]
pub use cli::{Failure, MethodChoice, RunOptions, RunStory, SceneRun};
#[doc(inline)]
pub use maps::MapResult;
#[doc(inline)]
pub use scene::{Scene, SceneError};
#[doc(inline)]
pub use solver::{MapSelection, Observer, Settings, Silent, Solution, solve};

// Types that stand in the fields and signatures of those above, so that each has its page.
#[doc(inline)]
pub use analytic::{AnalyticError, sobolev::SobolevValue};
#[doc(inline)]
pub use base::harmonics::{HarmonicSeries, RadialBounds};
#[doc(inline)]
pub use base::{
    perez::SkyClass,
    position_index::Outside,
    sky::{Sky, SkyPattern},
    sun::Sun,
};
#[doc(inline)]
pub use cli::{Exit, Plots, Target};
#[doc(inline)]
pub use control::Forecast;
#[doc(inline)]
pub use light_mesh::{Accelerations, IndirectForm, NotForLightMesh};
#[doc(inline)]
pub use maps::{Estimate, Judgement, MapError, MapKind, MapValues, StatisticalCheck, TableKind, TableRow};
#[doc(inline)]
pub use methods::MeshChoice;
#[doc(inline)]
pub use output::{
    Language, OutputError, PartOfRun, ResultDirectory, ResultFile, SealedError, StagedFiles, StreamedFile,
};
#[doc(inline)]
pub use radiosity::NotARoom;
#[doc(inline)]
pub use scene::photometry::{IntensityWeb, Opening, PhotometricError, PhotometricType, WebError};
#[doc(inline)]
pub use scene::{
    Area, Background, Body, BsdfParameters, DaylightTargets, ElementSide, Elements, Emission, Energy, GlareObserver,
    IntensityTable, Luminaire, Material, MaterialId, Measure, Openings, Product, Project, Quantity, ReceiverLayout,
    ReceiverPoint, ReceiverSet, ReceiversPart, Refusal, Requirement, Side, SpaceLimits, Standard, StandardEntry,
    Surface, SurfaceId, TextPlace,
};
#[doc(inline)]
pub use solver::{
    Activity, ConvergenceRow, ElementChoice, ErrorParts, FluxBalance, GlareRating, Hindrance, Keeper, MapCheck, Method,
    MoreShares, Portion, Progress, RunState, Share, SlowestMap, Spending, StopReason,
};
#[doc(inline)]
pub use validation::CaseError;
#[doc(inline)]
pub use year::NotForYear;

// The modules ("rooms") form layers, separated by blank lines. A room uses only rooms of layers above its own in this list.

#[doc(hidden)]
pub mod base;

#[doc(hidden)]
pub mod scene;

#[doc(hidden)]
pub mod geometry;
#[doc(hidden)]
pub mod sampling;

#[doc(hidden)]
pub mod check;

#[doc(hidden)]
pub mod transport;

#[doc(hidden)]
pub mod caches;

#[doc(hidden)]
pub mod estimators;

#[doc(hidden)]
pub mod maps;

#[doc(hidden)]
pub mod control;

#[doc(hidden)]
pub mod light_mesh;
#[doc(hidden)]
pub mod radiosity;
#[doc(hidden)]
pub mod solver;
#[doc(hidden)]
pub mod year;

#[doc(hidden)]
pub mod analytic;
#[doc(hidden)]
pub mod methods;
#[doc(hidden)]
pub mod output;

#[doc(hidden)]
pub mod validation;

#[doc(hidden)]
pub mod cli;
