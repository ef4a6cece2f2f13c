//! Loss of smooth light on the two sides of surfaces. It is pooled over the elements of a side, since single elements show too little.

use std::collections::HashMap;

use crate::maps::Variation;
use crate::scene::Elements;
use crate::solver::context::Context;
use crate::solver::empty_maps::Shows;

/// The smooth part of the loss of the elements on one side of a surface. It grows with the square of the area if they show slopes, and with
/// the area if they do not.
#[derive(Clone, Copy, Debug, Default)]
struct SideOfSurface {
    bent_m2_lx2: f64,
    bent_m6: f64,
    sloping_m2_lx2: f64,
    sloping_m4: f64,
    /// The sums for all elements, including those that show their slopes: the loss where an element partly hidden by contact shows no
    /// slopes.
    any_slope_m2_lx2: f64,
    any_slope_m4: f64,
}

/// Loss of smooth light on the sides of all surfaces.
pub struct SideLosses(HashMap<(u32, &'static str), SideOfSurface>);

impl SideLosses {
    /// Computes the losses from the variation of light within elements with these areas, which show slopes or not.
    pub fn of(
        context: &Context,
        elements: &Elements,
        areas_m2: &[f64],
        (sloped, contact_free): Shows,
        variations: &[Variation],
    ) -> SideLosses {
        let mut sides: HashMap<(u32, &'static str), SideOfSurface> = HashMap::new();
        for (index, (variation, area_m2)) in variations.iter().zip(areas_m2).enumerate() {
            let side = sides.entry(side_of(context, elements, index)).or_default();
            if contact_free[index] == 1.0 {
                side.add(variation, *area_m2, sloped[index]);
            }
        }
        SideLosses(sides)
    }

    /// Mean square in lx² over one of the elements.
    pub fn lx2(
        &self,
        context: &Context,
        elements: &Elements,
        index: usize,
        area_m2: f64,
        (sloped, contact_free): Shows,
    ) -> f64 {
        let side = self.0.get(&side_of(context, elements, index));
        side.map_or(0.0, |side| side.lx2(area_m2, sloped[index], contact_free[index] == 1.0))
    }
}

fn side_of(context: &Context, elements: &Elements, index: usize) -> (u32, &'static str) {
    let element = elements.element(index as u32);
    (context.scene.surface_id_of(element.triangle), element.side.name())
}

impl SideOfSurface {
    fn add(&mut self, variation: &Variation, area_m2: f64, sloped: bool) {
        self.bent_m2_lx2 += area_m2 * variation.indirect_lx2;
        self.bent_m6 += area_m2.powi(3);
        self.any_slope_m2_lx2 += area_m2 * variation.slope_lx2;
        self.any_slope_m4 += area_m2.powi(2);
        if !sloped {
            self.sloping_m2_lx2 += area_m2 * variation.slope_lx2;
            self.sloping_m4 += area_m2.powi(2);
        }
    }

    fn lx2(&self, area_m2: f64, sloped: bool, whole: bool) -> f64 {
        let bent_lx2 = self.bent_m2_lx2 / self.bent_m6.max(f64::MIN_POSITIVE) * area_m2 * area_m2;
        if !whole {
            return bent_lx2 + self.any_slope_m2_lx2 / self.any_slope_m4.max(f64::MIN_POSITIVE) * area_m2;
        }
        let sloping_lx2 = self.sloping_m2_lx2 / self.sloping_m4.max(f64::MIN_POSITIVE) * area_m2;
        bent_lx2 + if sloped { 0.0 } else { sloping_lx2 }
    }
}
