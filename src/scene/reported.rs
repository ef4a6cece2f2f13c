//! Selects the surfaces for reports and the terminal: all except those with `"report": false` and those that luminaires are made of.

use std::collections::BTreeSet;

use super::model::{Luminaire, Surface};

/// How the geometry of a surface decides whether reports show it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reporting {
    /// The file gives `report`.
    Asked(bool),
    /// No `report`. The geometry is a room seen from inside: reports show it, even if parts of it emit.
    Room,
    /// No `report`. If a part of the geometry emits, the whole geometry is a luminaire.
    Housing,
    /// No `report`. The geometry is a mesh: only the part that emits is a luminaire.
    Part,
}

/// Names of the surfaces that reports leave out. If the scene has only luminaires, reports show them.
pub(super) fn unreported(surfaces: &[Surface], reporting: &[Reporting], luminaires: &[Luminaire]) -> BTreeSet<String> {
    let shining: BTreeSet<u32> =
        luminaires.iter().flat_map(|luminaire| luminaire.emission.surfaces()).copied().collect();
    let housings: BTreeSet<&str> = shining.iter().map(|id| surfaces[*id as usize].geometry.as_str()).collect();
    let is_luminaire = |id: u32| match reporting[id as usize] {
        Reporting::Housing => housings.contains(surfaces[id as usize].geometry.as_str()),
        Reporting::Part => shining.contains(&id),
        Reporting::Room | Reporting::Asked(_) => false,
    };
    let ids = 0..surfaces.len() as u32;
    let asked = |id: u32| reporting[id as usize] == Reporting::Asked(false);
    let is_all = ids.clone().all(|id| is_luminaire(id) || asked(id));
    ids.filter(|id| asked(*id) || (is_luminaire(*id) && !is_all)).map(|id| surfaces[id as usize].name.clone()).collect()
}
