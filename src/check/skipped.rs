//! Mesh checks that may be skipped where a scene of many millions of triangles is known to be sound.

use std::sync::atomic::{AtomicU8, Ordering};

use serde::{Deserialize, Serialize};

/// A check of the scene's meshes that may be skipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MeshCheck {
    /// Open edges, edges of many triangles, doubled, reversed and overlapping triangles: warnings.
    Faults,
    /// Solids that intersect each other: warnings.
    Overlaps,
    /// Classic mistakes in a scene that gives poor results: warnings.
    Advice,
    /// Which receiver points lie inside of solids. Without it, all points count in tables and errors.
    Insides,
}

impl MeshCheck {
    /// All checks.
    pub const ALL: [MeshCheck; 4] = [MeshCheck::Faults, MeshCheck::Overlaps, MeshCheck::Advice, MeshCheck::Insides];

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            MeshCheck::Faults => "faults",
            MeshCheck::Overlaps => "overlaps",
            MeshCheck::Advice => "advice",
            MeshCheck::Insides => "insides",
        }
    }

    /// Whether the check is skipped.
    pub(super) fn is_skipped(self) -> bool {
        SKIPPED.load(Ordering::Relaxed) & self.bit() != 0
    }

    fn bit(self) -> u8 {
        1 << self as u8
    }
}

/// Checks that are skipped, one bit each.
static SKIPPED: AtomicU8 = AtomicU8::new(0);

/// Skips these checks whenever a scene is read from now on.
pub fn skip_checks(checks: &[MeshCheck]) {
    SKIPPED.fetch_or(checks.iter().fold(0, |bits, check| bits | check.bit()), Ordering::Relaxed);
}

/// Returns the warning that lists the skipped checks.
pub(super) fn words_on_skipped() -> Option<String> {
    let names: Vec<&str> = MeshCheck::ALL.into_iter().filter(|check| check.is_skipped()).map(MeshCheck::name).collect();
    let counts =
        if MeshCheck::Insides.is_skipped() { "; tables and errors include points inside of solids" } else { "" };
    (!names.is_empty())
        .then(|| format!("meshes were not fully checked: --skip-check left out {}{counts}", names.join(", ")))
}
