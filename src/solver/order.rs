//! The order in which the entries of a map send rays and walks.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::allotment::Allotment;

/// The order in which the entries of a map send rays: scattered, so that the first ones come from all over the map.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Order {
    sites: usize,
    stride: usize,
}

impl Order {
    /// The order of `sites` entries.
    pub fn of(sites: usize) -> Order {
        // The golden section scatters best; the stride must share no divisor with the number of entries.
        let divides = |mut a: usize, mut b: usize| {
            while b > 0 {
                (a, b) = (b, a % b);
            }
            a > 1
        };
        let mut stride = ((sites as f64 * 0.618_034) as usize).max(1);
        while divides(stride, sites) {
            stride += 1;
        }
        Order { sites, stride }
    }

    /// Number of entries.
    pub fn sites(self) -> usize {
        self.sites
    }

    /// The entry at a position of a pass.
    #[inline]
    pub fn entry(self, place: u64) -> usize {
        ((u128::from(place) * self.stride as u128) % self.sites as u128) as usize
    }

    /// Pass and entry of a ray.
    #[inline]
    pub fn at(self, index: u64) -> (u64, usize) {
        (index / self.sites as u64, self.entry(index % self.sites as u64))
    }
}

/// The gathering rays of a map: in a pass every entry sends as many as it is allotted, one after another.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RayOrder {
    pub order: Order,
    pub allotment: Allotment,
    /// The entry of every ray of a pass, and the number of the ray among those of this entry. Empty if every entry sends one.
    places: Vec<(u32, u16)>,
}

impl RayOrder {
    pub fn new(order: Order, allotment: Allotment) -> RayOrder {
        let mut places = Vec::new();
        if !allotment.is_even() {
            let entries = (0..order.sites() as u64).map(|place| order.entry(place));
            places.extend(
                entries.flat_map(|entry| (0..allotment.of(entry) as u16).map(move |number| (entry as u32, number))),
            );
        }
        RayOrder { order, allotment, places }
    }

    /// Number of entries.
    pub fn sites(&self) -> usize {
        self.order.sites()
    }

    /// Rays of a pass.
    pub fn rays_of_a_pass(&self) -> u64 {
        (if self.places.is_empty() { self.order.sites() } else { self.places.len() }) as u64
    }

    /// Number of each ray of a range among those of its entry, and the entry.
    pub fn entries(&self, range: Range<u64>) -> impl Iterator<Item = (u64, usize)> {
        let rays = self.rays_of_a_pass();
        range.map(move |index| match self.places.get((index % rays) as usize) {
            None => self.order.at(index),
            Some((entry, number)) => {
                let entry = *entry as usize;
                (index / rays * self.allotment.of(entry) + u64::from(*number), entry)
            }
        })
    }
}

/// Passes over some positions of the order.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Stretch {
    places: Range<u64>,
    passes: Range<u64>,
}

impl Stretch {
    fn len(&self) -> u64 {
        (self.places.end - self.places.start) * (self.passes.end - self.passes.start)
    }
}

/// The walks of a map: at first only from the first entries in the order, later possibly from all.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct WalkOrder {
    order: Order,
    /// The stretches, one after another.
    stretches: Vec<Stretch>,
    /// Walks so far.
    pub done: u64,
    /// Entries that must walk.
    pub walkers: u64,
}

impl WalkOrder {
    /// Creates an order without walks, with `walkers` entries that walk at first.
    pub fn new(order: Order, walkers: usize) -> WalkOrder {
        let walkers = walkers.min(order.sites()) as u64;
        WalkOrder { order, stretches: Vec::new(), done: 0, walkers }
    }

    /// Lets all entries walk. The other entries first catch up with those that have walked.
    pub fn take_all(&mut self) {
        self.walkers = self.order.sites() as u64;
    }

    /// Entries, passes of them, and walks that the first `done` walks complete. Of the last stretch, whole passes count.
    fn reach(&self, done: u64) -> (u64, u64, u64) {
        let (mut entries, mut passes, mut used) = (0, 0, 0);
        for stretch in &self.stretches {
            let width = stretch.places.end - stretch.places.start;
            if used + stretch.len() <= done {
                (entries, passes) = (stretch.places.end, stretch.passes.end);
                used += stretch.len();
                continue;
            }
            if stretch.places.start == 0 && width > 0 {
                let whole = (done - used) / width;
                if whole > 0 {
                    (entries, passes) = (stretch.places.end, stretch.passes.start + whole);
                    used += whole * width;
                }
            }
            break;
        }
        (entries, passes, used)
    }

    /// Entries that have walked, complete passes of all of them, and the number of walks in these passes.
    pub fn complete(&self) -> (u64, u64, u64) {
        self.reach(self.done)
    }

    /// The next walks towards `passes` passes, at most `most`.
    pub fn next(&mut self, passes: u64, most: u64) -> Range<u64> {
        let all = self.stretches.iter().map(Stretch::len).sum::<u64>();
        let (entries, planned, _) = self.reach(all);
        if entries > 0 && entries < self.walkers {
            self.stretches.push(Stretch { places: entries..self.walkers, passes: 0..planned });
        }
        if planned < passes {
            self.stretches.push(Stretch { places: 0..self.walkers, passes: planned..passes });
        }
        let all = self.stretches.iter().map(Stretch::len).sum::<u64>();
        self.done..all.min(self.done + most.max(1))
    }

    /// Pass and entry of the walks of a range.
    pub fn entries(&self, range: Range<u64>) -> impl Iterator<Item = (u64, usize)> {
        let mut first = 0;
        self.stretches.iter().flat_map(move |stretch| {
            let own = first..first + stretch.len();
            first = own.end;
            let part = range.start.max(own.start)..range.end.min(own.end);
            let width = (stretch.places.end - stretch.places.start).max(1);
            part.map(move |index| {
                let number = index - own.start;
                let place = stretch.places.start + number % width;
                (stretch.passes.start + number / width, self.order.entry(place))
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pass_meets_every_entry_once() {
        for sites in [1, 2, 12, 97, 1000] {
            let order = RayOrder::new(Order::of(sites), Allotment::default());
            let mut met = vec![0; sites];
            order.entries(0..sites as u64).for_each(|(_, entry)| met[entry] += 1);
            assert!(met.iter().all(|times| *times == 1), "{sites}");
        }
    }

    /// Entries with variances of 1 and 400 send some twenty times as many rays, numbered without a gap over all passes.
    #[test]
    fn a_pass_meets_every_entry_as_often_as_it_is_allotted() {
        let variances: Vec<f64> = (0..12).map(|entry| if entry == 5 { 400.0 } else { 1.0 }).collect();
        let order = RayOrder::new(Order::of(12), Allotment::to_target(&variances, 50.0));
        let rays = order.rays_of_a_pass();
        assert!(order.allotment.of(5) >= 3 && rays == order.allotment.of_all(12), "{:?}", order.allotment);
        let mut next = [0; 12];
        for (number, entry) in order.entries(0..rays + 4).chain(order.entries(rays + 4..3 * rays)) {
            assert_eq!(number, next[entry]);
            next[entry] += 1;
        }
        assert!((0..12).all(|entry| next[entry] == 3 * order.allotment.of(entry)), "{next:?}");
    }

    #[test]
    fn walks_of_all_take_in_those_of_the_first() {
        let mut walks = WalkOrder::new(Order::of(10), 4);
        walks.done = walks.next(3, 100).end;
        assert_eq!((walks.done, walks.complete()), (12, (4, 3, 12)));
        walks.take_all();
        // The other six entries catch up first.
        walks.done = walks.next(5, 17).end;
        assert_eq!(walks.complete(), (4, 3, 12));
        walks.done = walks.next(5, 8).end;
        assert_eq!((walks.done, walks.complete()), (37, (10, 3, 30)));
        walks.done = walks.next(5, 100).end;
        assert_eq!(walks.complete(), (10, 5, 50));
        let mut times = [0; 10];
        let mut seen = std::collections::HashSet::new();
        for (pass, entry) in walks.entries(0..50) {
            times[entry] += 1;
            assert!(pass < 5 && seen.insert((pass, entry)));
        }
        assert_eq!(times, [5; 10]);
        // Consecutive ranges join without a gap.
        let parts: Vec<_> = walks.entries(7..13).chain(walks.entries(13..33)).collect();
        assert_eq!(parts, walks.entries(7..33).collect::<Vec<_>>());
    }
}
