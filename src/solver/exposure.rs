//! How much of an element is exposed: where something stands on it nobody sees it.

use std::ops::Range;

use rayon::prelude::*;

use super::context::Context;
use crate::estimators::element::Element;
use crate::sampling::random::{Purpose, Stream};
use crate::scene::Elements;

/// Points of an element, where the pilot has not looked, that tell whether it is exposed, and of one that is in part how much.
pub const COVER_POINTS: u64 = 16;
const MOST_COVER_POINTS: u64 = 128;
/// Points near the corners of an element that are asked too, by the weights of its second and third corner.
const NEAR_CORNERS: [[f64; 2]; 3] = [[0.02, 0.02], [0.96, 0.02], [0.02, 0.96]];

/// What is known of how much of an element is exposed.
pub enum Exposure {
    /// This share.
    Known(f64),
    /// Nothing.
    Unknown,
    /// Something covers a part of it.
    InPart,
    /// Nothing, and what is covered in part counts as if nothing were.
    AsAWhole,
    /// Nothing, and one place is to tell, even where the run has ended.
    AtAPlace,
}

/// Share of every element of a range that is exposed, by some points of each of which nothing is known, and by many of those that
/// are covered in part; with the rays that it took.
pub fn exposed_shares(
    context: &Context,
    elements: &Elements,
    range: Range<usize>,
    known: impl Fn(u32) -> Exposure + Sync,
) -> (Vec<f64>, u64) {
    let share = |index: u32| {
        let known = known(index);
        let mut most = match known {
            Exposure::Known(share) => return (share, 0),
            Exposure::AtAPlace => 1,
            // A run that has ended asks no more: nothing lies on most elements.
            _ if context.is_over() => return (1.0, 0),
            Exposure::Unknown | Exposure::AsAWhole => COVER_POINTS,
            Exposure::InPart => MOST_COVER_POINTS,
        };
        let element = Element::of(context.stage, context.scene, elements, index);
        let mut stream = Stream::new(context.seed, Purpose::Pilot, u32::MAX, 1);
        let (mut points, mut exposed, mut rays) = (0, 0, 0);
        while points < most {
            stream.seek_quasi((u64::from(index) << 32) | points, u64::from(index), points);
            let at = element.draw(context.stage, &mut stream);
            let (covered, asked) = element.is_covered(context.stage, at, &mut stream);
            points += 1;
            exposed += u64::from(!covered);
            rays += asked;
            if !covered && matches!(known, Exposure::AsAWhole) {
                return (1.0, rays);
            }
            if points == COVER_POINTS && most == points {
                // What covers an element in part mostly reaches over one of its corners; a few points may all lie beside it.
                let differs = (1..points).contains(&exposed)
                    || NEAR_CORNERS.into_iter().any(|at| {
                        let (covered, asked) = element.is_covered(context.stage, at, &mut stream);
                        rays += asked;
                        covered == (exposed > 0)
                    });
                if differs {
                    most = MOST_COVER_POINTS;
                }
            }
        }
        (exposed as f64 / points as f64, rays)
    };
    let found: Vec<(f64, u64)> = (range.start as u32..range.end as u32).into_par_iter().map(share).collect();
    (found.iter().map(|(share, _)| *share).collect(), found.iter().map(|(_, rays)| rays).sum())
}
