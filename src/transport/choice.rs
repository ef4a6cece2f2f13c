//! Chooses the luminaire for a light sample.

use glam::DVec3;

use super::selection_by_cell::CellChoice;
use super::selection_by_region::RegionSelection;
use super::{NearLuminaires, TriangleSide, World};
use crate::sampling::emitter_tree::Cut;

/// Share of the choices that go to luminaires seen from the region, where most light is hidden (docs/methods.md (6)).
const SEEN: f64 = 0.5;
/// Share of the choices that go to any luminaire in that case.
const ANY: f64 = 0.05;

/// Choice among emitters at one point, about in proportion to the illuminance that each gives there.
pub struct Choices<'a> {
    world: &'a World,
    place: [DVec3; 2],
    selection: Selection<'a>,
}

/// How emitters are chosen.
enum Selection<'a> {
    /// No luminaire can light the point.
    Unlit,
    /// There is only one emitter.
    Only,
    /// By unshadowed illuminance.
    Unshadowed(&'a Cut),
    /// Most light is hidden: by what is visible, with a share for all emitters.
    InSight(&'a RegionSelection, &'a Cut),
    /// By the probabilities counted in a cell.
    OfCell(CellChoice<'a>),
}

impl World {
    /// Prepares the choice at a point with a unit normal on a side of a triangle. `cut` is scratch memory for it.
    #[inline]
    pub fn choices<'a>(&'a self, spot: TriangleSide, point_m: DVec3, normal: DVec3, cut: &'a mut Cut) -> Choices<'a> {
        self.choices_beside_packets(spot, [point_m, normal], || 0.0, cut)
    }

    /// The same where light of near luminaires is also found by packets, whose density over that of walks is `packets_per_lx` times the
    /// illuminance (computed only where it matters): a light sample of illuminance E then counts E/(1 + E `packets_per_lx`), and near
    /// luminaires are chosen in proportion to that (docs/methods.md (59)).
    #[inline]
    pub fn choices_beside_packets<'a>(
        &'a self,
        spot: TriangleSide,
        [point_m, normal]: [DVec3; 2],
        packets_per_lx: impl FnOnce() -> f64,
        cut: &'a mut Cut,
    ) -> Choices<'a> {
        let selection = if self.is_unlit(spot) {
            Selection::Unlit
        } else if self.emitters.list().len() == 1 {
            Selection::Only
        } else if let Some(cell) = self.selection_by_cell().and_then(|map| map.of_place(point_m, normal)) {
            Selection::OfCell(cell)
        } else {
            self.emitters.open(point_m, normal, cut);
            if let Some(mask) = self.near_luminaires.as_ref().and_then(NearLuminaires::beacons) {
                let per_lx = packets_per_lx();
                if per_lx > 0.0 {
                    cut.lessen(mask, per_lx);
                }
            }
            self.selection_by_region
                .selection_at(spot)
                .map_or(Selection::Unshadowed(cut), |selection| Selection::InSight(selection, cut))
        };
        Choices { world: self, place: [point_m, normal], selection }
    }
}

impl Choices<'_> {
    /// Whether there is more than one emitter to choose from.
    #[inline]
    pub fn has_choice(&self) -> bool {
        !matches!(self.selection, Selection::Unlit | Selection::Only)
    }

    /// Chooses one emitter by a variate in [0, 1). Returns its number and the probability of the choice. `None`: this choice contributes
    /// nothing.
    #[inline]
    pub fn choose(&self, variate: f64) -> Option<(u32, f64)> {
        let ([point_m, normal], emitters) = (self.place, &self.world.emitters);
        match &self.selection {
            Selection::Unlit => None,
            Selection::Only => Some((0, 1.0)),
            Selection::Unshadowed(cut) => emitters.choose(point_m, normal, variate, cut),
            Selection::OfCell(cell) => Some(cell.choose(variate)),
            Selection::InSight(selection, cut) => {
                let emitter = if variate < SEEN {
                    selection.choose(variate / SEEN)
                } else if variate < 1.0 - ANY {
                    emitters.choose(point_m, normal, (variate - SEEN) / (1.0 - ANY - SEEN), cut)?.0
                } else {
                    let count = emitters.list().len();
                    ((((variate - 1.0 + ANY) / ANY) * count as f64) as usize).min(count - 1) as u32
                };
                Some((emitter, self.probability(emitter)))
            }
        }
    }

    /// Probability with which [`Choices::choose`] chooses an emitter.
    pub fn probability(&self, emitter: u32) -> f64 {
        let ([point_m, normal], emitters) = (self.place, &self.world.emitters);
        match &self.selection {
            Selection::Unlit => 0.0,
            Selection::Only => 1.0,
            Selection::Unshadowed(cut) => emitters.probability(emitter, point_m, normal, cut),
            Selection::OfCell(cell) => cell.probability(emitter),
            Selection::InSight(selection, cut) => {
                SEEN * selection.probability(emitter)
                    + (1.0 - SEEN - ANY) * emitters.probability(emitter, point_m, normal, cut)
                    + ANY / emitters.list().len() as f64
            }
        }
    }
}
