//! Which surfaces reports and the terminal tell of: all but those that say `"report": false` and what luminaires are made of.

use std::collections::BTreeSet;

use super::model::{Luminaire, Surface};

/// What a surface's geometry says of reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reporting {
    /// What the file asks for.
    Asked(bool),
    /// Nothing; a room that is seen from inside is reported, whatever shines in it.
    Room,
    /// Nothing; where a part of the geometry shines all of it is a luminaire.
    Housing,
    /// Nothing; of a mesh the part that shines is a luminaire.
    Part,
}

/// Names of the surfaces that stay out of reports; where luminaires are all that there is, they are reported.
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
