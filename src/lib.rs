//! luxmc computes illuminance and luminance of a lit scene, with an error it can vouch for.
//!
//! The program `luxmc` is described by the `README.md` and its files by `docs/formats.md`. This page is for those who compute from
//! Rust: read a scene, solve it, look at its maps.
//!
//! # Read a scene
//!
//! [`read_scene`] reads a scene file and all files that it names; [`scene_from_json`] reads its text. What is read is a [`Scene`]
//! in SI units that is valid as a whole: whatever is wrong with a file is told here, by a [`SceneError`] that says where, what was
//! expected, and a remedy.
//!
//! ```
//! use std::path::Path;
//!
//! let text = r#"{ "version": 1,
//!   "materials": { "paint": { "type": "diffuse", "reflectance": 0.5 } },
//!   "geometry": [ { "name": "room", "type": "box", "min": [0, 0, 0], "max": [4, 3, 2.5], "facing": "inward", "material": "paint" } ],
//!   "luminaires": [ { "name": "lamp", "type": "point", "position": [2, 1.5, 2.2], "luminous_flux_lm": 3000 } ],
//!   "receivers": [ { "name": "desk", "type": "grid", "origin": [1, 1, 0.8], "u": [2, 0, 0], "v": [0, 1, 0], "columns": 8, "rows": 4 } ] }"#;
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
//! [`solve`] computes the maps that [`Settings`] ask for, until their target error is met, a limit ends the run, or the
//! [`Observer`] that watches it interrupts; [`Silent`] watches nothing. Without a time limit the same seed gives the same bytes on any
//! number of threads.
//!
//! ```
//! use luxmc::{MapSelection, Settings, Silent, solve};
//!
//! # let text = r#"{ "version": 1,
//! #   "materials": { "paint": { "type": "diffuse", "reflectance": 0.5 } },
//! #   "geometry": [ { "name": "room", "type": "box", "min": [0, 0, 0], "max": [4, 3, 2.5], "facing": "inward", "material": "paint" } ],
//! #   "luminaires": [ { "name": "lamp", "type": "point", "position": [2, 1.5, 2.2], "luminous_flux_lm": 3000 } ],
//! #   "receivers": [ { "name": "desk", "type": "grid", "origin": [1, 1, 0.8], "u": [2, 0, 0], "v": [0, 1, 0], "columns": 8, "rows": 4 } ] }"#;
//! # let scene = luxmc::scene_from_json(text, None, std::path::Path::new("."))?;
//! let settings = Settings { target_error: Some(0.02), maps: MapSelection::Receivers, seed: 1, ..Settings::default() };
//! let solution = solve(&scene, &settings, &Silent);
//! assert_eq!(solution.target_met, Some(true));
//! assert!(solution.estimated_error <= 0.02);
//! # Ok::<(), luxmc::SceneError>(())
//! ```
//!
//! # Look at its maps
//!
//! A [`Solution`] has a [`MapResult`] for the elements of all surfaces and for each set of receivers: illuminances in lx (of a
//! luminance receiver luminances in cd/m²) with a standard error each, and rows of a table: average, least, greatest, uniformity.
//!
//! ```
//! # use luxmc::{MapSelection, Settings, Silent, solve};
//! # let text = r#"{ "version": 1,
//! #   "materials": { "paint": { "type": "diffuse", "reflectance": 0.5 } },
//! #   "geometry": [ { "name": "room", "type": "box", "min": [0, 0, 0], "max": [4, 3, 2.5], "facing": "inward", "material": "paint" } ],
//! #   "luminaires": [ { "name": "lamp", "type": "point", "position": [2, 1.5, 2.2], "luminous_flux_lm": 3000 } ],
//! #   "receivers": [ { "name": "desk", "type": "grid", "origin": [1, 1, 0.8], "u": [2, 0, 0], "v": [0, 1, 0], "columns": 8, "rows": 4 } ] }"#;
//! # let scene = luxmc::scene_from_json(text, None, std::path::Path::new("."))?;
//! # let settings = Settings { target_error: Some(0.02), maps: MapSelection::Receivers, seed: 1, ..Settings::default() };
//! # let solution = solve(&scene, &settings, &Silent);
//! let desk = &solution.maps[0];
//! assert_eq!((desk.name.as_str(), desk.values.illuminance_lx.len()), ("desk", 8 * 4));
//! let average = desk.tables[0].average_lx;
//! println!("Ē = {:.0} ± {:.0} lx, U0 = {:.2}", average.value, average.standard_error, desk.tables[0].uniformity_u0.value);
//! assert!(average.value > 100.0 && average.standard_error < 0.02 * average.value);
//! # Ok::<(), luxmc::SceneError>(())
//! ```
//!
//! # Run it as the program does
//!
//! A [`SceneRun`] takes the options of `luxmc solve` in its words ([`RunOptions`]), checks them against the scene as it does, solves
//! by every method that it has, and [`RunStory`] writes its files. A [`Failure`] says what was refused in the program's words, and
//! with which exit code.
//!
//! ```
//! use luxmc::{RunOptions, SceneRun, Silent};
//!
//! # let text = r#"{ "version": 1,
//! #   "materials": { "paint": { "type": "diffuse", "reflectance": 0.5 } },
//! #   "geometry": [ { "name": "room", "type": "box", "min": [0, 0, 0], "max": [4, 3, 2.5], "facing": "inward", "material": "paint" } ],
//! #   "luminaires": [ { "name": "lamp", "type": "point", "position": [2, 1.5, 2.2], "luminous_flux_lm": 3000 } ],
//! #   "receivers": [ { "name": "desk", "type": "grid", "origin": [1, 1, 0.8], "u": [2, 0, 0], "v": [0, 1, 0], "columns": 8, "rows": 4 } ] }"#;
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
//! Between two infinite parallel planes the illuminance of a point source is known exactly: [`sobolev`] has it to twelve digits,
//! direct and reflected.
//!
//! ```
//! use luxmc::{SobolevPlane, SobolevProblem, sobolev};
//!
//! // A source of 1 cd half-way between planes that are 1 m apart and reflect half; 1 m beside it.
//! let problem = SobolevProblem { h1: 0.5, rho1: 0.5, rho2: 0.5 };
//! let found = sobolev(&problem, SobolevPlane::One, 1.0).expect("a problem with a solution");
//! assert!((found.direct_lx - 0.5 / 1.25f64.powf(1.5)).abs() < 1e-12);
//! assert!(found.total_lx > found.direct_lx);
//! ```
//!
//! # The house behind it
//!
//! The rest of the library is for those who work on luxmc itself. It is not shown here, and changes without notice;
//! `docs/architecture.md` draws its rooms, and `CONTRIBUTING.md` says which files a new material, luminaire or estimator touches.

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

// The rooms stand on floors; a room uses only rooms on floors above it in this list.

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
pub mod chain;

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
