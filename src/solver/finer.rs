//! Finer elements within the elements that they are cut from.

use super::context::Context;
use crate::control::{ElementLoss, cuts_for};
use crate::estimators::basis::Linear;
use crate::scene::elements::MOST_CUTS;
use crate::scene::{Elements, body_of};

/// How often to cut each element, given its loss in lx², so that all together lose no more than a goal.
pub fn cuts_of(
    context: &Context,
    elements: &Elements,
    lost_lx2: impl Iterator<Item = f64>,
    goal_lx2: f64,
    most_elements: usize,
) -> Vec<u32> {
    let loss = |(index, lost_lx2): (usize, f64)| {
        let element = elements.element(index as u32);
        ElementLoss {
            area_m2: elements.area_m2(context.scene, element),
            lost_lx2: lost_lx2.max(0.0),
            // Leaves of smooth bodies are not cut.
            cuts_left: if body_of(&context.scene.bodies, element.triangle).is_some() {
                0
            } else {
                MOST_CUTS - element.cuts()
            },
        }
    };
    let losses: Vec<ElementLoss> = lost_lx2.enumerate().map(loss).collect();
    cuts_for(&losses, goal_lx2, most_elements)
}

/// The element from which one of the finer ones was cut.
pub fn parent_of(elements: &Elements, finer: &Elements, index: u32) -> u32 {
    let element = finer.element(index);
    let [a, b, c] = finer.corners(&element);
    let middle = [0, 1].map(|k| (a[k] + b[k] + c[k]) / 3.0);
    elements.element_at(element.triangle, middle, element.side).unwrap_or(0)
}

/// Corners of a finer element within the element that it was cut from, as weights of that element's second and third corner.
pub fn corners_within(elements: &Elements, finer: &Elements, index: u32, parent: u32) -> [[f64; 2]; 3] {
    let [a, b, c] = elements.corners(&elements.element(parent));
    let (p, q) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
    let inverse = 1.0 / (p[0] * q[1] - p[1] * q[0]);
    finer.corners(&finer.element(index)).map(|corner| {
        let at = [corner[0] - a[0], corner[1] - a[1]];
        [(at[0] * q[1] - at[1] * q[0]) * inverse, (p[0] * at[1] - p[1] * at[0]) * inverse]
    })
}

/// A function on a child of its element, as a reference for samples. It is constant if the child is only partly free of contact, since samples are
/// not evenly distributed in it then.
pub fn reference_on(function: Linear, corners: [[f64; 2]; 3], contact_free: f64) -> Linear {
    let Linear([mean, first, second]) = function.on_piece(corners);
    if contact_free < 1.0 { Linear::even(mean) } else { Linear([mean, first, second]) }
}
