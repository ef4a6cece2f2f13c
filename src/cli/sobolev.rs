//! `luxmc sobolev`: the exact illuminance between two parallel diffuse planes.

use clap::Args;

use super::exit::Exit;
use super::values::{self, Distances};
use super::{Outcome, console};
use crate::analytic::sobolev::{SobolevPlane, SobolevProblem, sobolev_at_radii};
use crate::output::shortest;

/// Long help text of the command.
pub const ABOUT: &str = "\
Exact illuminance on one of two infinite parallel diffuse planes, lit by an isotropic point source of 1 cd between
them. The distance between the planes is 1; r is the distance from the foot of the source's perpendicular. For planes
at distance h and a source of I cd, give h1/h and r/h and multiply the illuminances by I/h².

Standard output carries CSV: r,direct,reflected,total,estimated_error, in lx, in the order asked, in the shortest
decimals that read back to the same f64.";

const EXAMPLES: &str = "\
Examples:
  luxmc sobolev --h1 0.5 --rho1 0.5 --rho2 0.5 --r 0,0.5,1
  luxmc sobolev --h1 0.25 --rho1 0.2 --rho2 0.7 --r 0:3:31 --plane 2 > plane2.csv";

/// Arguments of `luxmc sobolev`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct SobolevArguments {
    /// Height of the source above plane 1, over the distance between the planes: between 0 and 1
    #[arg(long, value_name = "H1", allow_negative_numbers = true)]
    h1: f64,
    /// Reflectance of plane 1: 0 to 1
    #[arg(long, value_name = "RHO1", allow_negative_numbers = true)]
    rho1: f64,
    /// Reflectance of plane 2: 0 to 1, not both 1
    #[arg(long, value_name = "RHO2", allow_negative_numbers = true)]
    rho2: f64,
    /// Distances: 0,0.5,1 or from:to:count, both ends included
    #[arg(long, value_name = "R", value_parser = values::distances, allow_hyphen_values = true)]
    r: Distances,
    /// Plane on which the illuminance is computed: 1 or 2
    #[arg(long, value_name = "PLANE", default_value = "1", value_parser = plane)]
    plane: SobolevPlane,
}

fn plane(text: &str) -> Result<SobolevPlane, String> {
    match text {
        "1" => Ok(SobolevPlane::One),
        "2" => Ok(SobolevPlane::Two),
        _ => Err("write 1 or 2".to_owned()),
    }
}

/// Prints the table.
pub fn run(arguments: &SobolevArguments) -> Outcome {
    let problem = SobolevProblem { h1: arguments.h1, rho1: arguments.rho1, rho2: arguments.rho2 };
    let Distances(radii) = &arguments.r;
    let values = sobolev_at_radii(&problem, arguments.plane, radii)?;

    let mut text = String::from("r,direct,reflected,total,estimated_error\n");
    for (r, value) in radii.iter().zip(&values) {
        let numbers = [*r, value.direct_lx, value.reflected_lx, value.total_lx, value.estimated_error_lx];
        text.push_str(&numbers.map(shortest).join(","));
        text.push('\n');
    }
    console::result(&text)?;
    Ok(Exit::Done)
}
