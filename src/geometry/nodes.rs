//! Nodes of the tree: eight boxes side by side, made from a binary tree, with blocks of triangles as leaves.

use glam::Vec3;
use obvhs::bvh2::Bvh2;

use super::triangle::{Block, LANES};

/// This bit is set for a child that is a block of triangles. The other bits are the block's number.
const BLOCK_BIT: u32 = 1 << 31;
/// The primitive of an empty slot.
const NONE: u32 = u32::MAX;

/// Eight boxes and their contents.
#[derive(Clone)]
#[repr(C, align(32))]
pub(super) struct WideNode {
    /// Low and high planes across x, then y, then z. An empty box has its low planes above its high ones.
    pub planes: [[f32; LANES]; 6],
    pub children: [Child; LANES],
}

/// The content of a box.
#[derive(Clone, Copy, PartialEq, Eq)]
#[repr(transparent)]
pub(super) struct Child(u32);

impl Child {
    /// The root of a tree.
    pub const ROOT: Child = Child(0);

    /// Returns the kind and the number of the child.
    #[inline(always)]
    pub fn what(self) -> Below {
        if self.0 & BLOCK_BIT != 0 {
            Below::Block((self.0 & !BLOCK_BIT) as usize)
        } else {
            Below::Node(self.0 as usize)
        }
    }
}

/// A block of triangles or a node, with its number.
pub(super) enum Below {
    Block(usize),
    Node(usize),
}

/// An eight-wide tree.
pub(super) struct Nodes {
    pub nodes: Vec<WideNode>,
    pub blocks: Vec<Block>,
    /// The primitive in each slot, eight slots per block; [`NONE`] in empty slots. A triangle whose box was split is in several slots.
    pub primitives: Vec<u32>,
}

impl Nodes {
    /// Converts a binary tree to eight children per node. The largest box is opened again and again until there are eight. A subtree of at
    /// most eight primitives becomes a block.
    pub fn of(pairs: &Bvh2, corners: impl Fn(u32) -> [Vec3; 3]) -> Nodes {
        let mut nodes = Nodes { nodes: Vec::new(), blocks: Vec::new(), primitives: Vec::new() };
        if pairs.primitive_indices.is_empty() {
            return nodes;
        }
        let counts = counts_of(pairs);
        // The pair to convert, and the child entry that will receive its number.
        let mut open: Vec<(u32, Option<(usize, usize)>)> = vec![(0, None)];
        while let Some((pair, place)) = open.pop() {
            let is_block = counts[pair as usize] <= LANES as u32;
            let child = match is_block && place.is_some() {
                true => Child(BLOCK_BIT | nodes.push_block(pairs, pair, &corners)),
                false => Child(nodes.push_node(pairs, &counts, pair, &mut open)),
            };
            if let Some((node, lane)) = place {
                nodes.nodes[node].children[lane] = child;
            }
        }
        nodes.nodes.shrink_to_fit();
        nodes.blocks.shrink_to_fit();
        nodes.primitives.shrink_to_fit();
        nodes
    }

    fn push_block(&mut self, pairs: &Bvh2, pair: u32, corners: &impl Fn(u32) -> [Vec3; 3]) -> u32 {
        let number = self.blocks.len();
        let mut block = Block::EMPTY;
        let mut open = vec![pair];
        while let Some(pair) = open.pop() {
            let node = &pairs.nodes[pair as usize];
            if !node.is_leaf() {
                open.extend([node.first_index + 1, node.first_index]);
                continue;
            }
            for place in node.first_index..node.first_index + node.prim_count {
                let primitive = pairs.primitive_indices[place as usize];
                block.set(self.primitives.len() - number * LANES, corners(primitive));
                self.primitives.push(primitive);
            }
        }
        self.blocks.push(block);
        self.primitives.resize(self.blocks.len() * LANES, NONE);
        number as u32
    }

    fn push_node(
        &mut self,
        pairs: &Bvh2,
        counts: &[u32],
        pair: u32,
        open: &mut Vec<(u32, Option<(usize, usize)>)>,
    ) -> u32 {
        let number = self.nodes.len();
        let mut node = WideNode { planes: [[0.0; LANES]; 6], children: [Child::ROOT; LANES] };
        for (plane, lanes) in node.planes.iter_mut().enumerate() {
            *lanes = [if plane % 2 == 0 { f32::INFINITY } else { f32::NEG_INFINITY }; LANES];
        }
        let (children, count) = children_of(pairs, counts, pair);
        for (lane, child) in children[..count].iter().enumerate() {
            let bounds = pairs.nodes[*child as usize].aabb();
            for axis in 0..3 {
                node.planes[2 * axis][lane] = bounds.min[axis];
                node.planes[2 * axis + 1][lane] = bounds.max[axis];
            }
        }
        open.extend((0..count).rev().map(|lane| (children[lane], Some((number, lane)))));
        self.nodes.push(node);
        number as u32
    }

    /// Returns the numbers of the filled slots and the primitive in each.
    pub fn filled(&self) -> impl Iterator<Item = (usize, u32)> {
        self.primitives.iter().copied().enumerate().filter(|(_, primitive)| *primitive != NONE)
    }

    /// Renumbers the primitives.
    pub fn renumber(&mut self, number: impl Fn(u32) -> u32) {
        for primitive in self.primitives.iter_mut().filter(|primitive| **primitive != NONE) {
            *primitive = number(*primitive);
        }
    }

    /// Returns the number of levels.
    pub fn depth(&self) -> usize {
        let mut deepest = 0;
        let mut open = if self.nodes.is_empty() { vec![] } else { vec![(0, 1)] };
        while let Some((index, level)) = open.pop() {
            deepest = deepest.max(level);
            let node: &WideNode = &self.nodes[index];
            let inner = (0..LANES).filter(|lane| node.planes[0][*lane] <= node.planes[1][*lane]);
            open.extend(inner.filter_map(|lane| match node.children[lane].what() {
                Below::Node(node) => Some((node, level + 1)),
                Below::Block(_) => None,
            }));
        }
        deepest
    }
}

/// Returns the number of primitives under each node of a binary tree.
fn counts_of(pairs: &Bvh2) -> Vec<u32> {
    let mut order = vec![0];
    let mut next = 0;
    while let Some(pair) = order.get(next).copied() {
        next += 1;
        let node = &pairs.nodes[pair as usize];
        if !node.is_leaf() {
            order.extend([node.first_index, node.first_index + 1]);
        }
    }
    let mut counts = vec![0; pairs.nodes.len()];
    for pair in order.into_iter().rev() {
        let node = &pairs.nodes[pair as usize];
        counts[pair as usize] = match node.is_leaf() {
            true => node.prim_count,
            false => counts[node.first_index as usize] + counts[node.first_index as usize + 1],
        };
    }
    counts
}

/// Returns up to eight nodes of a binary tree that become the children of one node.
fn children_of(pairs: &Bvh2, counts: &[u32], pair: u32) -> ([u32; LANES], usize) {
    let node_of = |pair: u32| &pairs.nodes[pair as usize];
    let half_area = |pair: u32| node_of(pair).aabb().half_area();
    let mut children = [pair; LANES];
    let mut count = 1;
    while count < LANES {
        let all = 0..count;
        let can_open = |place: &usize| !node_of(children[*place]).is_leaf();
        // Boxes that will be nodes are opened before those that can be blocks. Of the latter, the one that saves the most area is opened.
        let inner = all.clone().filter(|place| counts[children[*place] as usize] > LANES as u32);
        let largest = inner.max_by(|one, other| half_area(children[*one]).total_cmp(&half_area(children[*other])));
        let saved = |place: usize| {
            let first = node_of(children[place]).first_index;
            half_area(children[place]) - half_area(first) - half_area(first + 1)
        };
        let blocks = all.filter(can_open).map(|place| (place, saved(place))).filter(|(_, saved)| *saved > 0.0);
        let best_saved = || blocks.max_by(|one, other| one.1.total_cmp(&other.1)).map(|(place, _)| place);
        let Some(place) = largest.or_else(best_saved) else {
            break;
        };
        let first = node_of(children[place]).first_index;
        (children[place], children[count]) = (first, first + 1);
        count += 1;
    }
    (children, count)
}
