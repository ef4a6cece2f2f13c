//! The method that a case's run, or the user, asks for.

use super::methods::{Climb, ComparedMethod, METHODS};
use crate::light_mesh::IndirectForm;
use crate::methods::{MeshChoice, solve_by_light_mesh};
use crate::scene::Scene;
use crate::solver::{Observer, Settings, Solution};

/// Name of the method that has a step and a radius.
const LIGHT_MESH: &str = "light-mesh";

/// A method, and for light meshes what the mesh is like.
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
    /// The method of a name; `None` if there is none.
    pub fn named(name: &str, mesh: MeshChoice) -> Option<RunMethod> {
        METHODS.iter().find(|method| method.name == name).map(|method| RunMethod { method, mesh })
    }

    /// Its name.
    pub fn name(&self) -> &'static str {
        self.method.name
    }

    /// Whether it can compute the maps of the settings, or why not.
    pub fn applies(&self, scene: &Scene, settings: &Settings) -> Result<(), String> {
        (self.method.applies)(scene, settings)
    }

    /// Whether nothing of the settings ends it: it goes by a target, and there is neither one nor a limit nor a mesh to take.
    pub fn lacks_rule(&self, settings: &Settings) -> bool {
        let asked = settings.target_error.or(settings.time_limit_s).or(self.mesh.step_m).or(self.mesh.radius_m);
        self.method.climbs == Climb::Targets && asked.is_none()
    }

    /// Computes, or says why it cannot. A method without chains goes by the target alone.
    pub fn solve(&self, scene: &Scene, settings: &Settings, observer: &dyn Observer) -> Result<Solution, String> {
        let chains = settings.chains.filter(|_| self.method.climbs == Climb::Chains);
        let settings = Settings { chains, ..settings.clone() };
        if self.method.name == LIGHT_MESH {
            return solve_by_light_mesh(scene, &settings, &self.mesh, observer).map_err(|error| error.to_string());
        }
        (self.method.solve)(scene, &settings, observer)
    }
}

/// Names of all methods, with commas between.
pub fn method_names() -> String {
    METHODS.iter().map(|method| method.name).collect::<Vec<_>>().join(", ")
}

/// Reads the form of indirect light as a case names it.
pub(super) fn indirect_form(name: &str) -> Option<IndirectForm> {
    match name {
        "scalar" => Some(IndirectForm::Scalar),
        "directional" => Some(IndirectForm::Directional),
        _ => None,
    }
}
