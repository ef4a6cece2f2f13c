//! The exposed share of an element: nobody sees the part on which something stands.

use std::ops::Range;

use rayon::prelude::*;

use super::context::Context;
use crate::estimators::element::Element;
use crate::sampling::random::{Purpose, Stream};
use crate::scene::Elements;

/// Points of an element that test whether it is exposed, where the pilot has no samples; and points that measure the share of one that is
/// partly exposed.
pub const COVER_POINTS: u64 = 16;
const MOST_COVER_POINTS: u64 = 128;
/// Extra test points near the corners of an element, as weights of its second and third corner.
const NEAR_CORNERS: [[f64; 2]; 3] = [[0.02, 0.02], [0.96, 0.02], [0.02, 0.96]];

/// What is known of the exposed share of an element.
pub enum Exposure {
    /// The share is known.
    Known(f64),
    /// Nothing is known.
    Unknown,
    /// A part of it is hidden by contact.
    InPart,
    /// Nothing is known, and an element that is partly hidden counts as fully exposed.
    AsAWhole,
    /// Nothing is known, and one point decides, even if the run has ended.
    AtAPlace,
}

/// Exposed share of every element of a range, and the rays traced. It is measured by some points of each element of which nothing is known,
/// and by many points of those that are partly hidden.
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
            // A run that has ended traces no more rays: nothing lies on most elements.
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
                // What hides a part of an element mostly covers one of its corners. A few points may all miss it.
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
