//! Elements as children of coarser elements: expresses the coarser elements' functions on the children.

use serde::{Deserialize, Serialize};

use crate::estimators::basis::{BENDS, Linear, SLOPES, slopes_at};

/// Position of an element in a coarser one that is cut in four repeatedly.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChildElement {
    /// Number of the coarser element.
    pub parent: u32,
    /// Values of the coarser element's linear polynomials at the centre of the child.
    slopes: [f64; SLOPES],
    /// Edge length of the child divided by that of the coarser element. It is negative where the child stands upside down.
    scale: f64,
}

impl ChildElement {
    /// Creates the child with these corners. Each corner is given by the weights of the coarser element's second and third corner.
    pub fn of(parent: u32, [a, b, c]: [[f64; 2]; 3]) -> ChildElement {
        let middle = [0, 1].map(|k| (a[k] + b[k] + c[k]) / 3.0);
        ChildElement { parent, slopes: slopes_at(middle), scale: b[0] - a[0] }
    }

    /// Returns mean and slopes on the child of a linear function with these coefficients on the coarser element.
    #[inline]
    fn linear(&self, [mean, first, second]: [f64; 1 + SLOPES]) -> [f64; 1 + SLOPES] {
        [mean + first * self.slopes[0] + second * self.slopes[1], first * self.scale, second * self.scale]
    }

    /// Returns a linear function on the coarser element, expressed on the child.
    pub fn on(&self, function: &Linear) -> Linear {
        Linear(self.linear(function.0))
    }

    /// Converts bend coefficients of the coarser element to the child: slopes scale with the edge, curves with its square.
    pub fn bends(&self, bends: [f64; BENDS]) -> [f64; BENDS] {
        std::array::from_fn(|k| bends[k] * if k < SLOPES { self.scale } else { self.scale * self.scale })
    }
}

/// Returns the coefficients of many child elements, computed from those of their coarser elements. The order is: all means, then all first
/// slopes, then all second slopes. Children of a coarser element without slopes (`sloped` false) get its mean alone.
pub fn on_children(coarse: &[f64], sloped: &[bool], children: &[ChildElement]) -> Vec<f64> {
    let sites = children.len();
    let mut found = vec![0.0; (1 + SLOPES) * sites];
    for (site, child) in children.iter().enumerate() {
        let parent = child.parent as usize;
        let coefficient = |number: usize| coarse[number * sloped.len() + parent];
        if sloped[parent] {
            let shown = child.linear(std::array::from_fn(coefficient));
            (0..=SLOPES).for_each(|number| found[number * sites + site] = shown[number]);
        } else {
            found[site] = coefficient(0);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimators::basis::bends_at;

    /// The middle child of the second child of a triangle.
    const CORNERS: [[f64; 2]; 3] = [[0.75, 0.25], [0.5, 0.25], [0.75, 0.0]];

    #[test]
    fn a_piece_shows_what_the_whole_shows_there() {
        let whole = Linear([3.0, -0.7, 1.9]);
        let child = ChildElement::of(1, CORNERS);
        let expected = whole.on_piece(CORNERS).0;
        let coarse = [0.0, 3.0, 0.0, -0.7, 0.0, 1.9];
        let shown = on_children(&coarse, &[false, true], &[child, ChildElement::of(0, CORNERS)]);
        for (number, expected) in expected.into_iter().enumerate() {
            assert!((shown[2 * number] - expected).abs() < 1e-12, "{shown:?} {expected:?}");
            assert_eq!(shown[2 * number + 1], 0.0);
        }
        assert_eq!(on_children(&coarse, &[true, false], &[child])[1..], [0.0, 0.0], "constant elements have no slopes");
    }

    #[test]
    fn curves_fall_with_the_square_of_the_edge() {
        // A quadratic function on a child: its second differences give its curves there.
        let curves = [0.0, 0.0, 0.4, -1.1, 0.8];
        let function = |at: [f64; 2], curves: [f64; BENDS]| -> f64 {
            bends_at(at).iter().zip(curves).map(|(bend, curve)| bend * curve).sum()
        };
        let [a, b, c] = CORNERS;
        let outer = |[u, v]: [f64; 2]| [0, 1].map(|k| a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]));
        let on_piece = ChildElement::of(0, CORNERS).bends(curves);
        let bent = |value: &dyn Fn([f64; 2]) -> f64| {
            [
                value([0.0, 0.0]) - 2.0 * value([0.5, 0.0]) + value([1.0, 0.0]),
                value([0.0, 0.0]) - 2.0 * value([0.0, 0.5]) + value([0.0, 1.0]),
                value([0.0, 0.0]) - value([0.5, 0.0]) - value([0.0, 0.5]) + value([0.5, 0.5]),
            ]
        };
        let (seen, expected) = (bent(&|at| function(outer(at), curves)), bent(&|at| function(at, on_piece)));
        for (seen, expected) in seen.iter().zip(expected) {
            assert!((seen - expected).abs() < 1e-12, "{seen} {expected}");
        }
    }
}
