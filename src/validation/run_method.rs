//! The method that a case's run or the user requests.

use super::methods::{ComparedMethod, METHODS};
use crate::light_mesh::IndirectForm;
use crate::methods::{MeshChoice, solve_by_light_mesh};
use crate::scene::Scene;
use crate::solver::{Observer, Settings, Solution};

/// Name of the method that uses step and radius.
const LIGHT_MESH: &str = "light-mesh";

/// A method and, for light meshes, the settings of the mesh.
#[derive(Clone, Copy)]
pub struct RunMethod {
    method: &'static ComparedMethod,
    mesh: MeshChoice,
}

impl std::fmt::Debug for RunMethod {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("RunMethod").field("name", &self.method.name).field("mesh", &self.mesh).finish()
    }
}

impl RunMethod {
    /// Returns the method with this name; `None` if there is none.
    pub fn named(name: &str, mesh: MeshChoice) -> Option<RunMethod> {
        METHODS.iter().find(|method| method.name == name).map(|method| RunMethod { method, mesh })
    }

    /// Name of the method.
    pub fn name(&self) -> &'static str {
        self.method.name
    }

    /// Checks that it can compute the requested maps, or returns why not.
    pub fn applies(&self, scene: &Scene, settings: &Settings) -> Result<(), String> {
        (self.method.applies)(scene, settings)
    }

    /// Returns whether nothing in the settings ends the run: the method uses a target, and there is no target, time limit or given
    /// mesh.
    pub fn lacks_rule(&self, settings: &Settings) -> bool {
        let asked = settings.target_error.or(settings.time_limit_s).or(self.mesh.step_m).or(self.mesh.radius_m);
        !self.method.takes_chains && asked.is_none()
    }

    /// Computes a solution, or returns why it cannot. A method without chains uses only the target.
    pub fn solve(&self, scene: &Scene, settings: &Settings, observer: &dyn Observer) -> Result<Solution, String> {
        let chains = settings.chains.filter(|_| self.method.takes_chains);
        let settings = Settings { chains, ..settings.clone() };
        if self.method.name == LIGHT_MESH {
            return solve_by_light_mesh(scene, &settings, &self.mesh, observer).map_err(|error| error.to_string());
        }
        (self.method.solve)(scene, &settings, observer)
    }
}

/// Names of all methods, separated by commas.
pub fn method_names() -> String {
    METHODS.iter().map(|method| method.name).collect::<Vec<_>>().join(", ")
}

/// Converts a case's name for the form of indirect light.
pub(super) fn indirect_form(name: &str) -> Option<IndirectForm> {
    match name {
        "scalar" => Some(IndirectForm::Scalar),
        "directional" => Some(IndirectForm::Directional),
        _ => None,
    }
}
