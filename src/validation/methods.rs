//! The methods that `luxmc compare` climbs its ladder with.

use crate::scene::Scene;
use crate::solver::{Observer, Settings, Solution, solve};

/// A way to compute a scene.
pub struct Method {
    /// Name, as `--method` takes it.
    pub name: &'static str,
    /// One line for a reader.
    pub description: &'static str,
    /// Whether it can compute the maps of the settings, or why not.
    pub applies: fn(&Scene, &Settings) -> Result<(), String>,
    /// Computes.
    pub solve: fn(&Scene, &Settings, &dyn Observer) -> Solution,
}

/// All methods; one that is added here joins every comparison.
pub const METHODS: &[Method] = &[Method {
    name: "collision",
    description: "element maps by counting the packets of forward chains, receivers by walks; direct light by formula",
    applies: |_, _| Ok(()),
    solve,
}];
