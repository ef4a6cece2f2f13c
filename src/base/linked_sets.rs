//! Sets of things that are linked to one another, directly or through others.

use serde::{Deserialize, Serialize};

use crate::base::memory::bytes_of_list;

/// Things from 0 on, and which of them are linked (the union-find algorithm; Tarjan, 1975, "Efficiency of a good but not linear set union
/// algorithm").
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct LinkedSets {
    /// For each thing, another one of its set, or itself: following them leads to the root of the set.
    parents: Vec<u32>,
}

impl LinkedSets {
    /// Sets of one thing each.
    pub fn new(things: usize) -> LinkedSets {
        LinkedSets { parents: (0..things as u32).collect() }
    }

    /// Adds things up to a number of them, each in a set of its own.
    pub fn extend_to(&mut self, things: usize) {
        self.parents.extend(self.parents.len() as u32..things as u32);
    }

    /// The root of a thing's set: the same for all that are linked with it. Halves the path to it.
    pub fn root(&mut self, thing: u32) -> u32 {
        let mut root = thing;
        while self.parents[root as usize] != root {
            let next = self.parents[self.parents[root as usize] as usize];
            self.parents[root as usize] = next;
            root = next;
        }
        root
    }

    /// Links two things.
    pub fn link(&mut self, one: u32, other: u32) {
        let [root, other] = [one, other].map(|thing| self.root(thing));
        self.parents[other as usize] = root;
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        bytes_of_list(&self.parents)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_linked_has_one_root() {
        let mut sets = LinkedSets::new(4);
        sets.extend_to(6);
        [(0, 1), (2, 3), (4, 5), (1, 2)].into_iter().for_each(|(one, other)| sets.link(one, other));
        let roots: Vec<u32> = (0..6).map(|thing| sets.root(thing)).collect();
        assert!(roots[..4].iter().all(|root| *root == roots[0]) && roots[4] == roots[5] && roots[0] != roots[5]);
    }
}
