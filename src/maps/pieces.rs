//! Elements as pieces of broader ones: what these show, on them.

use serde::{Deserialize, Serialize};

use super::basis::{BENDS, Linear, SLOPES, slopes_at};

/// Where an element lies in a broader one that is cut in four again and again.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Piece {
    /// Number of the broader element.
    pub above: u32,
    /// The linear polynomials of the broader element in the middle of the piece.
    slopes: [f64; SLOPES],
    /// Edge over that of the broader element, below 0 where the piece stands upside down in it.
    scale: f64,
}

impl Piece {
    /// The piece with these corners, each by the weights of the broader element's second and third corner.
    pub fn of(above: u32, [a, b, c]: [[f64; 2]; 3]) -> Piece {
        let middle = [0, 1].map(|k| (a[k] + b[k] + c[k]) / 3.0);
        Piece { above, slopes: slopes_at(middle), scale: b[0] - a[0] }
    }

    /// Mean and slopes on the piece of a linear function with these coefficients on the broader element.
    #[inline]
    fn linear(&self, [mean, first, second]: [f64; 1 + SLOPES]) -> [f64; 1 + SLOPES] {
        [mean + first * self.slopes[0] + second * self.slopes[1], first * self.scale, second * self.scale]
    }

    /// A linear function on the broader element, on the piece.
    pub fn on(&self, function: &Linear) -> Linear {
        Linear(self.linear(function.0))
    }

    /// What bends on the broader element are on the piece: slopes by its edge, curves by the square of that.
    pub fn bends(&self, bends: [f64; BENDS]) -> [f64; BENDS] {
        std::array::from_fn(|k| bends[k] * if k < SLOPES { self.scale } else { self.scale * self.scale })
    }
}

/// Coefficients of many elements that are pieces of broader ones, from those of the broader ones: means first, then the first
/// and the second slopes. Of a broader element that shows none (`sloped` false) the pieces have its mean alone.
pub fn on_pieces(broad: &[f64], sloped: &[bool], pieces: &[Piece]) -> Vec<f64> {
    let sites = pieces.len();
    let mut found = vec![0.0; (1 + SLOPES) * sites];
    for (site, piece) in pieces.iter().enumerate() {
        let above = piece.above as usize;
        let coefficient = |number: usize| broad[number * sloped.len() + above];
        if sloped[above] {
            let shown = piece.linear(std::array::from_fn(coefficient));
            (0..=SLOPES).for_each(|number| found[number * sites + site] = shown[number]);
        } else {
            found[site] = coefficient(0);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::basis::bends_at;
    use super::*;

    /// The middle child of the second child of a triangle.
    const CORNERS: [[f64; 2]; 3] = [[0.75, 0.25], [0.5, 0.25], [0.75, 0.0]];

    #[test]
    fn a_piece_shows_what_the_whole_shows_there() {
        let whole = Linear([3.0, -0.7, 1.9]);
        let piece = Piece::of(1, CORNERS);
        let expected = whole.on_piece(CORNERS).0;
        let broad = [0.0, 3.0, 0.0, -0.7, 0.0, 1.9];
        let shown = on_pieces(&broad, &[false, true], &[piece, Piece::of(0, CORNERS)]);
        for (number, expected) in expected.into_iter().enumerate() {
            assert!((shown[2 * number] - expected).abs() < 1e-12, "{shown:?} {expected:?}");
            assert_eq!(shown[2 * number + 1], 0.0);
        }
        assert_eq!(on_pieces(&broad, &[true, false], &[piece])[1..], [0.0, 0.0], "constant elements have no slopes");
    }

    #[test]
    fn curves_fall_with_the_square_of_the_edge() {
        // A quadratic function on a piece: its second differences tell its curves there.
        let curves = [0.0, 0.0, 0.4, -1.1, 0.8];
        let function = |at: [f64; 2], curves: [f64; BENDS]| -> f64 {
            bends_at(at).iter().zip(curves).map(|(bend, curve)| bend * curve).sum()
        };
        let [a, b, c] = CORNERS;
        let outer = |[u, v]: [f64; 2]| [0, 1].map(|k| a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]));
        let on_piece = Piece::of(0, CORNERS).bends(curves);
        let bent = |value: &dyn Fn([f64; 2]) -> f64| {
            [
                value([0.0, 0.0]) - 2.0 * value([0.5, 0.0]) + value([1.0, 0.0]),
                value([0.0, 0.0]) - 2.0 * value([0.0, 0.5]) + value([0.0, 1.0]),
                value([0.0, 0.0]) - value([0.5, 0.0]) - value([0.0, 0.5]) + value([0.5, 0.5]),
            ]
        };
        let (seen, told) = (bent(&|at| function(outer(at), curves)), bent(&|at| function(at, on_piece)));
        for (seen, told) in seen.iter().zip(told) {
            assert!((seen - told).abs() < 1e-12, "{seen} {told}");
        }
    }
}
