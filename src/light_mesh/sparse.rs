//! A sparse tree over a mesh: it allocates memory only where a point is requested.
//!
//! It has three levels: a root of nodes of 32³ points, nodes of 8³ leaves, leaves of 4³ points. The data of a leaf depend only on its
//! position, so it does not matter which thread creates it.

use std::mem::size_of;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use super::lattice::{Index, Lattice};

/// Points along a leaf's edge, as a power of two.
const LEAF_BITS: u32 = 2;
/// Leaves along a node's edge, as a power of two.
const NODE_BITS: u32 = 3;
/// Number of points of a leaf.
pub const LEAF_POINTS: usize = 1 << (3 * LEAF_BITS);
/// Number of leaves of a node.
const NODE_LEAVES: usize = 1 << (3 * NODE_BITS);
/// Largest number of nodes of a root: 64 MB.
const MOST_NODES: usize = 1 << 22;

/// Leaves of one node.
type LeavesOfNode<L> = Box<[OnceLock<Box<L>>]>;

/// A tree of leaves. Each leaf is created when it is first requested.
pub struct SparseTree<L> {
    sizes: [usize; 3],
    root: Vec<OnceLock<LeavesOfNode<L>>>,
    nodes: AtomicU64,
    leaves: AtomicU64,
}

impl<L> SparseTree<L> {
    /// Creates an empty tree over a mesh; `None` if even the root would be too large.
    pub fn over(lattice: &Lattice) -> Option<SparseTree<L>> {
        let sizes = lattice.counts.map(|count| (count as usize >> (LEAF_BITS + NODE_BITS)) + 1);
        let nodes: usize = sizes.iter().product();
        (nodes <= MOST_NODES).then(|| SparseTree {
            sizes,
            root: std::iter::repeat_with(OnceLock::new).take(nodes).collect(),
            nodes: AtomicU64::new(0),
            leaves: AtomicU64::new(0),
        })
    }

    /// Returns the leaf that contains a point of the mesh, and the point's number in it.
    #[inline]
    pub fn leaf(&self, index: Index, new: impl FnOnce() -> L) -> (&L, usize) {
        let [i, j, k] = index.map(|number| number as usize);
        let shift = LEAF_BITS + NODE_BITS;
        let place = ((k >> shift) * self.sizes[1] + (j >> shift)) * self.sizes[0] + (i >> shift);
        let node = self.root[place].get_or_init(|| {
            self.nodes.fetch_add(1, Ordering::Relaxed);
            std::iter::repeat_with(OnceLock::new).take(NODE_LEAVES).collect()
        });
        let low = |number: usize| (number >> LEAF_BITS) & ((1 << NODE_BITS) - 1);
        let leaf = node[(((low(k) << NODE_BITS) | low(j)) << NODE_BITS) | low(i)].get_or_init(|| {
            self.leaves.fetch_add(1, Ordering::Relaxed);
            Box::new(new())
        });
        let last = |number: usize| number & ((1 << LEAF_BITS) - 1);
        (leaf, (((last(k) << LEAF_BITS) | last(j)) << LEAF_BITS) | last(i))
    }

    /// Returns the number of leaves created so far.
    pub fn leaves(&self) -> u64 {
        self.leaves.load(Ordering::Relaxed)
    }

    /// Returns the memory of the tree itself in bytes. `leaf_bytes` is the memory of a leaf beyond its own size.
    pub fn bytes(&self, leaf_bytes: u64) -> u64 {
        let node = (NODE_LEAVES * size_of::<OnceLock<Box<L>>>()) as u64;
        (self.root.len() * size_of::<OnceLock<LeavesOfNode<L>>>()) as u64
            + self.nodes.load(Ordering::Relaxed) * node
            + self.leaves() * (size_of::<L>() as u64 + leaf_bytes)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;
    use std::sync::atomic::AtomicU64;

    use glam::DVec3;

    use super::*;

    #[test]
    fn every_point_has_a_place_of_its_own_and_finds_it_again() {
        let lattice = Lattice::over([DVec3::ZERO, DVec3::new(40.0, 3.0, 9.0)], 1.0, 1.0).expect("a small mesh");
        let tree: SparseTree<Vec<AtomicU64>> = SparseTree::over(&lattice).expect("a small root");
        let new = || std::iter::repeat_with(AtomicU64::default).take(LEAF_POINTS).collect::<Vec<_>>();
        let mut written = HashMap::new();
        for i in 0..lattice.counts[0] as i32 {
            for j in 0..lattice.counts[1] as i32 {
                for k in (0..lattice.counts[2] as i32).step_by(5) {
                    let (leaf, place) = tree.leaf([i, j, k], new);
                    assert_eq!(leaf[place].fetch_add(1, Ordering::Relaxed), 0, "{i} {j} {k} is taken");
                    written.insert((i, j, k), std::ptr::from_ref(&leaf[place]));
                }
            }
        }
        for ((i, j, k), at) in written {
            let (leaf, place) = tree.leaf([i, j, k], new);
            assert!(std::ptr::eq(at, &leaf[place]));
        }
        assert!(tree.leaves() > 0 && tree.bytes(0) > 0);
    }
}
