//! The methods that `luxmc compare` tests on its ladder.

use super::rivals::{check_points, solve_by_points};
use crate::maps::MapKind;
use crate::methods::{MeshChoice, check_light_mesh, solve_by_light_mesh, solve_by_radiosity};
use crate::radiosity::Radiosity;
use crate::scene::Scene;
use crate::solver;
use crate::solver::{Observer, Settings, Solution, map_requests, solve};

/// A method to compute a scene.
pub struct ComparedMethod {
    /// Name as in `--method`.
    pub name: &'static str,
    /// One line for a reader.
    pub description: &'static str,
    /// Checks that it can compute the requested maps, or returns why not.
    pub applies: fn(&Scene, &Settings) -> Result<(), String>,
    /// Quantity that is increased to make it more accurate.
    pub climbs: Climb,
    /// Whether it can run a given number of chains.
    pub takes_chains: bool,
    /// Computes a solution, or returns why it cannot.
    pub solve: fn(&Scene, &Settings, &dyn Observer) -> Result<Solution, String>,
}

/// Quantity by which a method's ladder climbs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Climb {
    /// Number of chains, doubled on every rung.
    Chains,
    /// Target error, just below the stated error of the rung before. The method finds out by itself what that takes.
    Targets,
}

/// All methods. A method that is added here takes part in every comparison.
pub const METHODS: &[ComparedMethod] = &[
    ComparedMethod {
        name: "auto",
        description: "for each map the method that a short pilot finds fastest; changes it if a check during the run finds another one faster",
        applies: |_, _| Ok(()),
        climbs: Climb::Targets,
        takes_chains: true,
        solve: |scene, settings, observer| Ok(solve_with(solver::Method::Auto, scene, settings, observer)),
    },
    ComparedMethod {
        name: "collision",
        description: "element maps by counting the packets of forward chains, receivers by walks; direct light by formulas",
        applies: |_, _| Ok(()),
        climbs: Climb::Chains,
        takes_chains: true,
        solve: |scene, settings, observer| Ok(solve(scene, settings, observer)),
    },
    ComparedMethod {
        name: "gather",
        description: "indirect light by gathering rays that look up cells, which other rays have filled; residual walks measure the error of the cells; direct light computed",
        applies: |_, _| Ok(()),
        climbs: Climb::Targets,
        takes_chains: true,
        solve: |scene, settings, observer| Ok(solve_with(solver::Method::Gather, scene, settings, observer)),
    },
    ComparedMethod {
        name: "local",
        description: "receivers by local estimation: every vertex of every chain scores at all of them, near surfaces by walks",
        applies: |scene, settings| receivers_alone(scene, settings),
        climbs: Climb::Chains,
        takes_chains: true,
        solve: |scene, settings, observer| Ok(solve_with(solver::Method::Local, scene, settings, observer)),
    },
    ComparedMethod {
        name: "local-naive",
        description: "local estimation with the plain kernel, whose variance is infinite in corners",
        applies: |scene, settings| receivers_alone(scene, settings),
        climbs: Climb::Chains,
        takes_chains: true,
        solve: |scene, settings, observer| Ok(solve_with(solver::Method::LocalNaive, scene, settings, observer)),
    },
    ComparedMethod {
        name: "radiosity",
        description: "finite elements with exact form factors on closed rooms of rectangles, extrapolated over three meshes",
        applies: |scene, _| Radiosity::check(scene).map_err(|error| error.to_string()),
        climbs: Climb::Targets,
        takes_chains: false,
        solve: |scene, settings, observer| {
            solve_by_radiosity(scene, settings, observer).map_err(|error| error.to_string())
        },
    },
    ComparedMethod {
        name: "light-mesh",
        description: "visibility of the luminaires averaged over the points of a regular mesh near each point, indirect light gathered at the mesh points",
        applies: |scene, settings| check_light_mesh(scene, settings).map_err(|error| error.to_string()),
        climbs: Climb::Targets,
        takes_chains: false,
        solve: |scene, settings, observer| {
            solve_by_light_mesh(scene, settings, &MeshChoice::default(), observer).map_err(|error| error.to_string())
        },
    },
    ComparedMethod {
        name: "points-1",
        description: "one shadow ray to each luminaire, area luminaires replaced by one point: exact for point luminaires",
        applies: check_points,
        climbs: Climb::Targets,
        takes_chains: false,
        solve: |scene, settings, observer| solve_by_points(scene, settings, 1, observer),
    },
    ComparedMethod {
        name: "points-5",
        description: "each area luminaire replaced by 5 points, a shadow ray to each",
        applies: check_points,
        climbs: Climb::Targets,
        takes_chains: false,
        solve: |scene, settings, observer| solve_by_points(scene, settings, 5, observer),
    },
    ComparedMethod {
        name: "points-25",
        description: "each area luminaire replaced by 25 points, a shadow ray to each",
        applies: check_points,
        climbs: Climb::Targets,
        takes_chains: false,
        solve: |scene, settings, observer| solve_by_points(scene, settings, 25, observer),
    },
    ComparedMethod {
        name: "points-225",
        description: "each area luminaire replaced by 225 points, a shadow ray to each",
        applies: check_points,
        climbs: Climb::Targets,
        takes_chains: false,
        solve: |scene, settings, observer| solve_by_points(scene, settings, 225, observer),
    },
];

/// Accepts only receivers: local estimation computes values at points, but an element needs a mean.
fn receivers_alone(scene: &Scene, settings: &Settings) -> Result<(), String> {
    let mut requests = map_requests(scene, &settings.maps).into_iter();
    if requests.any(|(kind, _)| kind == MapKind::Elements) {
        return Err("local estimation scores at points, not on elements".to_owned());
    }
    Ok(())
}

fn solve_with(method: solver::Method, scene: &Scene, settings: &Settings, observer: &dyn Observer) -> Solution {
    solve(scene, &Settings { method, ..settings.clone() }, observer)
}
