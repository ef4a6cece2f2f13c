//! Contact occlusion: nobody sees the part of an element on which something stands. The rest is its contact-free share.

use std::ops::Range;

use rayon::prelude::*;

use super::context::Context;
use crate::estimators::element::Element;
use crate::sampling::random::{Purpose, Stream};
use crate::scene::Elements;
use crate::transport::Traced;

/// Points of an element that test whether it is free of contact, where the pilot has no samples; and points that measure the share of one that is
/// partly free of contact.
pub const CONTACT_POINTS: u64 = 16;
const MOST_CONTACT_POINTS: u64 = 128;
/// Extra test points near the corners of an element, as weights of its second and third corner.
const NEAR_CORNERS: [[f64; 2]; 3] = [[0.02, 0.02], [0.96, 0.02], [0.02, 0.96]];

/// What is known of the contact-free share of an element.
pub enum KnownContact {
    /// The share is known.
    Known(f64),
    /// Nothing is known.
    Unknown,
    /// A part of it is hidden by contact.
    InPart,
    /// Nothing is known, and an element that is partly hidden counts as free of contact.
    AsAWhole,
    /// Nothing is known, and one point decides, even if the run has ended.
    AtAPlace,
}

/// Contact-free share of every element of a range, and the rays traced. It is measured by some points of each element of which nothing is known,
/// and by many points of those that are partly hidden.
pub fn contact_free_shares(
    context: &Context,
    elements: &Elements,
    range: Range<usize>,
    known: impl Fn(u32) -> KnownContact + Sync,
) -> (Vec<f64>, u64) {
    let share = |index: u32| {
        let known = known(index);
        let mut most = match known {
            KnownContact::Known(share) => return Traced { value: share, rays: 0 },
            KnownContact::AtAPlace => 1,
            // A run that has ended traces no more rays: nothing lies on most elements.
            _ if context.is_over() => return Traced { value: 1.0, rays: 0 },
            KnownContact::Unknown | KnownContact::AsAWhole => CONTACT_POINTS,
            KnownContact::InPart => MOST_CONTACT_POINTS,
        };
        let element = Element::of(context.world, context.scene, elements, index);
        let mut stream = Stream::new(context.seed, Purpose::Pilot, u32::MAX, 1);
        let (mut points, mut contact_free, mut rays) = (0, 0, 0);
        while points < most {
            stream.seek_quasi((u64::from(index) << 32) | points, u64::from(index), points);
            let at = element.draw(context.world, &mut stream);
            let (in_contact, tested_rays) = element.is_in_contact(context.world, at, &mut stream);
            points += 1;
            contact_free += u64::from(!in_contact);
            rays += tested_rays;
            if !in_contact && matches!(known, KnownContact::AsAWhole) {
                return Traced { value: 1.0, rays };
            }
            if points == CONTACT_POINTS && most == points {
                // What hides a part of an element mostly covers one of its corners. A few points may all miss it.
                let differs = (1..points).contains(&contact_free)
                    || NEAR_CORNERS.into_iter().any(|at| {
                        let (in_contact, tested_rays) = element.is_in_contact(context.world, at, &mut stream);
                        rays += tested_rays;
                        in_contact == (contact_free > 0)
                    });
                if differs {
                    most = MOST_CONTACT_POINTS;
                }
            }
        }
        Traced { value: contact_free as f64 / points as f64, rays }
    };
    let found: Vec<Traced> = (range.start as u32..range.end as u32).into_par_iter().map(share).collect();
    (found.iter().map(|share| share.value).collect(), found.iter().map(|share| share.rays).sum())
}
