//! The rays and seconds that a run spends.

use std::ops::AddAssign;
use std::time::Duration;

use serde::{Deserialize, Serialize};

/// Kinds of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activity {
    /// Pilots, whose samples enter no result, and the search for luminaires in sight.
    Pilots,
    /// Direct light of the maps' own entries.
    Direct,
    /// Gathering rays, which look cells up.
    Gathering,
    /// Rays that fill cells.
    Cells,
    /// Residual walks, which measure the error of cells.
    ResidualWalks,
    /// Walks from receivers, and from elements that chains seldom meet.
    Walks,
    /// Chains from luminaires, with their connections to receivers.
    Chains,
    /// Summing up, judging and planning.
    Judging,
}

impl Activity {
    /// All kinds of work.
    pub const ALL: [Activity; 8] = [
        Activity::Pilots,
        Activity::Direct,
        Activity::Gathering,
        Activity::Cells,
        Activity::ResidualWalks,
        Activity::Walks,
        Activity::Chains,
        Activity::Judging,
    ];

    /// Name in `summary.json`.
    pub fn name(self) -> &'static str {
        match self {
            Activity::Pilots => "pilots",
            Activity::Direct => "direct",
            Activity::Gathering => "gathering",
            Activity::Cells => "cells",
            Activity::ResidualWalks => "residual_walks",
            Activity::Walks => "walks",
            Activity::Chains => "chains",
            Activity::Judging => "judging",
        }
    }

    /// Name in words.
    pub fn words(self) -> &'static str {
        match self {
            Activity::Pilots => "pilots",
            Activity::Direct => "direct light",
            Activity::Gathering => "gathering rays",
            Activity::Cells => "filling cells",
            Activity::ResidualWalks => "walks that measure the cells' error",
            Activity::Walks => "walks",
            Activity::Chains => "chains from luminaires",
            Activity::Judging => "summing up and judging",
        }
    }
}

/// Rays and seconds by kind of work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spending {
    rays: [u64; Activity::ALL.len()],
    seconds: [f64; Activity::ALL.len()],
}

impl Spending {
    /// Adds work.
    pub fn add(&mut self, activity: Activity, rays: u64, time: Duration) {
        self.rays[activity as usize] += rays;
        self.seconds[activity as usize] += time.as_secs_f64();
    }

    /// Rays of one kind.
    pub fn rays(&self, activity: Activity) -> u64 {
        self.rays[activity as usize]
    }

    /// Seconds of computing of all kinds.
    pub fn all_seconds(&self) -> f64 {
        self.seconds.iter().sum()
    }

    /// Seconds per ray of some kinds of work, if at least `fewest_rays` of them were traced and timed.
    pub fn seconds_per_ray(&self, kinds: &[Activity], fewest_rays: u64) -> Option<f64> {
        let rays: u64 = kinds.iter().map(|kind| self.rays(*kind)).sum();
        let seconds: f64 = kinds.iter().map(|kind| self.seconds(*kind)).sum();
        (rays >= fewest_rays && seconds > 0.0).then(|| seconds / rays as f64)
    }

    /// Seconds of computing of one kind.
    pub fn seconds(&self, activity: Activity) -> f64 {
        self.seconds[activity as usize]
    }
}

impl AddAssign for Spending {
    fn add_assign(&mut self, other: Spending) {
        self.rays.iter_mut().zip(other.rays).for_each(|(sum, rays)| *sum += rays);
        self.seconds.iter_mut().zip(other.seconds).for_each(|(sum, seconds)| *sum += seconds);
    }
}
