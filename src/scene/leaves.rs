//! Leaves: parts of triangles cut into quadtrees, so that elements are small where the light changes and large elsewhere.
//!
//! The middles of a triangle's edges cut it into four congruent triangles. Those at the corners have the numbers 0 to 2 of the corners.
//! The middle one has number 3 and stands upside down. The path of a leaf holds two bits per cut behind a leading 1.

use serde::{Deserialize, Serialize};

/// Most cuts above one another: the limit of a path of 32 bits.
pub const MOST_CUTS: u32 = 15;
/// Flag of a leaf among the references of a quadtree.
const LEAF: u32 = 1 << 31;

/// The leaves of a list of parts.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Leaves {
    /// For every part: the number of its leaf with [`LEAF`] set, or the number of its node.
    roots: Vec<u32>,
    /// The four children of each node, in the same form.
    nodes: Vec<[u32; 4]>,
    /// First leaf of every part, then the total number of leaves.
    first_leaf: Vec<u32>,
    /// Part and path of every leaf.
    leaves: Vec<(u32, u32)>,
}

/// The path of a part that is not cut.
pub const UNCUT: u32 = 1;

/// Number of cuts that lead to the piece at the end of a path.
#[inline]
pub fn cuts_of(path: u32) -> u32 {
    path.ilog2() / 2
}

/// Corners of the piece at the end of a path, from the corners of the whole part.
pub fn corners_of(mut corners: [[f64; 2]; 3], path: u32) -> [[f64; 2]; 3] {
    for cut in (0..cuts_of(path)).rev() {
        let [a, b, c] = corners;
        let middle = |p: [f64; 2], q: [f64; 2]| [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        corners = match (path >> (2 * cut)) & 3 {
            0 => [a, ab, ca],
            1 => [ab, b, bc],
            2 => [ca, bc, c],
            _ => [bc, ca, ab],
        };
    }
    corners
}

/// Returns the child of a triangle that contains `(a, b)`, the weights of the second and third corner, and the weights within the child.
#[inline]
fn child_at([a, b]: [f64; 2]) -> (usize, [f64; 2]) {
    if a >= 0.5 {
        (1, [2.0 * a - 1.0, 2.0 * b])
    } else if b >= 0.5 {
        (2, [2.0 * a, 2.0 * b - 1.0])
    } else if a + b < 0.5 {
        (0, [2.0 * a, 2.0 * b])
    } else {
        (3, [1.0 - 2.0 * a, 1.0 - 2.0 * b])
    }
}

impl Leaves {
    /// Makes the leaves of `parts` parts. `is_cut` says whether the piece at the end of a path in a part is cut.
    pub fn of(parts: usize, mut is_cut: impl FnMut(u32, u32) -> bool) -> Leaves {
        let mut leaves = Leaves::default();
        for part in 0..parts as u32 {
            leaves.first_leaf.push(leaves.leaves.len() as u32);
            let root = leaves.grow(part, UNCUT, &mut is_cut);
            leaves.roots.push(root);
        }
        leaves.first_leaf.push(leaves.leaves.len() as u32);
        leaves
    }

    fn grow(&mut self, part: u32, path: u32, is_cut: &mut impl FnMut(u32, u32) -> bool) -> u32 {
        if cuts_of(path) >= MOST_CUTS || !is_cut(part, path) {
            self.leaves.push((part, path));
            return (self.leaves.len() as u32 - 1) | LEAF;
        }
        let children: [u32; 4] = std::array::from_fn(|child| self.grow(part, (path << 2) | child as u32, is_cut));
        self.nodes.push(children);
        self.nodes.len() as u32 - 1
    }

    /// Number of leaves.
    pub fn len(&self) -> usize {
        self.leaves.len()
    }

    /// First leaf of a part. For the number behind the last part: the total number of leaves.
    pub fn first_of(&self, part: u32) -> u32 {
        self.first_leaf[part as usize]
    }

    /// Part and path of a leaf.
    pub fn part_and_path(&self, leaf: u32) -> (u32, u32) {
        self.leaves[leaf as usize]
    }

    /// Returns the leaf of a part at `(a, b)`, the weights of its second and third corner, and the weights within the leaf.
    #[inline]
    pub fn at(&self, part: u32, mut at: [f64; 2]) -> (u32, [f64; 2]) {
        let mut place = self.roots[part as usize];
        while place & LEAF == 0 {
            let (child, inner) = child_at(at);
            place = self.nodes[place as usize][child];
            at = inner;
        }
        (place & !LEAF, at)
    }

    /// Returns the leaf that holds a piece which is not cut, and the number of cuts that lead to the leaf.
    pub fn holder(&self, part: u32, path: u32) -> (u32, u32) {
        let mut place = self.roots[part as usize];
        let cuts = cuts_of(path);
        for cut in (0..cuts).rev() {
            if place & LEAF != 0 {
                break;
            }
            place = self.nodes[place as usize][((path >> (2 * cut)) & 3) as usize];
        }
        let leaf = place & !LEAF;
        (leaf, cuts_of(self.leaves[leaf as usize].1))
    }

    /// Whether a piece of a part is cut.
    pub fn is_cut(&self, part: u32, path: u32) -> bool {
        let mut place = self.roots[part as usize];
        for cut in (0..cuts_of(path)).rev() {
            if place & LEAF != 0 {
                return false;
            }
            place = self.nodes[place as usize][((path >> (2 * cut)) & 3) as usize];
        }
        place & LEAF == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaves_hold_their_own_middles_and_fill_the_part() {
        // Part 0 whole, part 1 cut twice at its first corner, part 2 cut evenly.
        let leaves = Leaves::of(3, |part, path| match part {
            0 => false,
            1 => path == UNCUT || path == (UNCUT << 2),
            _ => cuts_of(path) < 3,
        });
        assert_eq!(leaves.len(), 1 + 7 + 64);
        assert!(leaves.is_cut(1, UNCUT << 2) && !leaves.is_cut(1, (UNCUT << 2) | 3) && !leaves.is_cut(0, UNCUT));
        let whole = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        for part in 0..3 {
            let mut area = 0.0;
            for leaf in leaves.first_of(part)..leaves.first_of(part + 1) {
                let (of, path) = leaves.part_and_path(leaf);
                assert_eq!(of, part);
                let [a, b, c] = corners_of(whole, path);
                area += (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
                let (u, v) = (0.3, 0.2);
                let at = [0, 1].map(|k| a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]));
                let (found, inner) = leaves.at(part, at);
                assert_eq!(found, leaf);
                assert!((inner[0] - u).abs() < 1e-12 && (inner[1] - v).abs() < 1e-12, "{inner:?}");
            }
            assert!((area - 1.0).abs() < 1e-12, "the turned pieces keep their turn: {area}");
        }
    }
}
