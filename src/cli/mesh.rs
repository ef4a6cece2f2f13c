//! The options of `--method light-mesh`.

use clap::{Args, ValueEnum};

use super::exit::Failure;
use crate::light_mesh::{Accelerations, IndirectForm};
use crate::methods::MeshChoice;

/// Options of the light mesh.
#[derive(Debug, Default, Args)]
pub struct MeshArguments {
    /// With --method light-mesh: distance of mesh points in m [default: found by refining to the target]
    #[arg(long, value_name = "STEP", value_parser = length_m, allow_hyphen_values = true)]
    mesh_step: Option<f64>,
    /// With --method light-mesh: radius in m of the sets that are averaged [default: 1.25 steps]
    #[arg(long, value_name = "RADIUS", value_parser = length_m, allow_hyphen_values = true)]
    mesh_radius: Option<f64>,
    /// With --method light-mesh: what mesh points store of indirect light [default: directional]
    #[arg(long, value_name = "FORM", value_enum)]
    mesh_indirect: Option<KeptForm>,
    /// With --method light-mesh: accelerations to turn off, separated by commas; maps stay the same within their errors, the run takes
    /// longer (for comparisons)
    #[arg(long, value_name = "WHAT", value_enum, value_delimiter = ',')]
    mesh_without: Vec<Saving>,
}

/// What mesh points keep of indirect light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum KeptForm {
    /// One number, the same for every direction of a surface
    Scalar,
    /// Spherical harmonics of low order
    Directional,
}

/// An acceleration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Saving {
    /// The tree of rays from mesh points (MU1); without it every ray is traced separately
    Tree,
    /// Templates of the mesh points near a place (MU2)
    Templates,
    /// Outer points of a set first; inner points count as visible where the outer ones are (MU3)
    OuterFirst,
    /// Flags of the points inside of solids (MU4)
    InsideFlags,
}

/// Longest step and radius in m: no coordinate is larger.
const LONGEST_M: f64 = 1e15;

fn length_m(text: &str) -> Result<f64, String> {
    const REMEDY: &str = "write a length above 0 and up to 1e15 in metres, such as 0.25";
    let length_m = text.trim().parse::<f64>().map_err(|_| format!("not a number; {REMEDY}"))?;
    if length_m > 0.0 && length_m <= LONGEST_M { Ok(length_m) } else { Err(REMEDY.to_owned()) }
}

impl MeshArguments {
    /// Returns the mesh that the options describe.
    ///
    /// # Errors
    ///
    /// Options of a mesh without `--method light-mesh`, and a radius that does not fit the step.
    pub fn choice(&self, is_mesh: bool) -> Result<MeshChoice, Failure> {
        if !is_mesh && !self.again().is_empty() {
            return Err(Failure::Usage {
                what: "only light meshes have a step and a radius".to_owned(),
                got: self.again().trim().to_owned(),
                expected: "these options with --method light-mesh".to_owned(),
                remedy: "add --method light-mesh, or leave them out".to_owned(),
            });
        }
        let has = |saving: Saving| !self.mesh_without.contains(&saving);
        let choice = MeshChoice {
            step_m: self.mesh_step,
            radius_m: self.mesh_radius,
            form: match self.mesh_indirect {
                Some(KeptForm::Scalar) => IndirectForm::Scalar,
                Some(KeptForm::Directional) | None => IndirectForm::Directional,
            },
            accelerations: Accelerations {
                tree: has(Saving::Tree),
                templates: has(Saving::Templates),
                outer_first: has(Saving::OuterFirst),
                inside_flags: has(Saving::InsideFlags),
            },
        };
        choice.check().map_err(|(got, expected)| Failure::Usage {
            what: "the radius does not fit the step".to_owned(),
            got: format!("{}: {got}", self.again().trim()),
            expected,
            remedy: "1.25 is exact for its cost, 2.1 and 3.1 make smooth pictures".to_owned(),
        })?;
        Ok(choice)
    }

    /// The options as text for a command that repeats the run.
    pub fn again(&self) -> String {
        let mut again = String::new();
        if let Some(step_m) = self.mesh_step {
            again += &format!(" --mesh-step {step_m}");
        }
        if let Some(radius_m) = self.mesh_radius {
            again += &format!(" --mesh-radius {radius_m}");
        }
        let name = |value: &dyn Fn() -> Option<String>| value().unwrap_or_default();
        if let Some(form) = self.mesh_indirect {
            let form = name(&|| form.to_possible_value().map(|value| value.get_name().to_owned()));
            again += &format!(" --mesh-indirect {form}");
        }
        for saving in &self.mesh_without {
            let saving = name(&|| saving.to_possible_value().map(|value| value.get_name().to_owned()));
            again += &format!(" --mesh-without {saving}");
        }
        again
    }
}
