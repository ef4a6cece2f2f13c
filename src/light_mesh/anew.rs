//! Samples the light of an entry of a map without a mesh, with a new line of sight for each sample. Meshes are compared with it. It also
//! completes views whose gloss takes fewer rays this way.

use super::entries::Entries;
use super::exact::{MeshPlace, sample_all_emitters};
use super::eye::{Eye, GlossRays, SeenPlace, Shown};
use super::mesh::Surroundings;
use super::walks::{HALVES, in_halves, sample_at_place_lx};
use crate::estimators::receiver::Receiver;
use crate::estimators::sight::SMALL_SHARE;
use crate::maps::MapKind;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::Stream;
use crate::scene::ReceiverPoint;
use crate::transport::Traced;

/// Returns one unbiased sample of the direct light of an entry, and the number of rays. It uses no mesh and traces a new line of sight.
pub fn sample_direct(around: &Surroundings, entries: &Entries, entry: usize, stream: &mut Stream) -> Traced {
    sample(around, entries, entry, true, stream, |receiver, stream| sample_all_emitters(around.world, receiver, stream))
}

/// Returns one unbiased sample of the indirect light of an entry, with a walk from each of its points, and the number of rays.
pub fn sample_indirect(
    around: &Surroundings,
    entries: &Entries,
    entry: usize,
    cut: &mut Cut,
    stream: &mut Stream,
) -> Traced {
    let walk = |receiver: &Receiver, stream: &mut Stream| sample_at_place_lx(around, receiver, cut, stream);
    sample(around, entries, entry, false, stream, walk)
}

/// Returns one sample of an entry in the unit of the map, and the number of rays. `sample_at` samples the light at each of its points and
/// returns the rays for it.
/// With `with_luminaires`, an eye also sees luminaires.
fn sample(
    around: &Surroundings,
    entries: &Entries,
    entry: usize,
    with_luminaires: bool,
    stream: &mut Stream,
    mut sample_at: impl FnMut(&Receiver, &mut Stream) -> Traced,
) -> Traced {
    let mut sum = Traced::default();
    if let Some(point) = eye_of(around, entries, entry) {
        let (shown, places) = traced_anew(around, point, with_luminaires, stream);
        if with_luminaires {
            sum.value += shown.luminaires_cd_m2;
        }
        sum.rays += shown.rays;
        for place in places {
            sum += place.weight_per_sr * sample_at(&place.receiver(), stream);
        }
        return sum;
    }
    entries.each_drawn_spot(around, entry, stream, |spot: MeshPlace, weight, stream| {
        sum += weight * spot.with_receiver(around.world, |receiver| sample_at(receiver, stream));
    });
    sum
}

/// Returns what a new line of sight shows, with one ray along each gloss.
fn traced_anew(
    around: &Surroundings,
    point: &ReceiverPoint,
    with_luminaires: bool,
    stream: &mut Stream,
) -> (Shown, Vec<SeenPlace>) {
    let world = around.world;
    let mut places = Vec::new();
    let from = world.tracer.side_origin(point.position_m, point.normal);
    let eye = Eye {
        world,
        small_share: SMALL_SHARE,
        gloss: GlossRays::One,
        with_luminaires,
        samples_area_images: around.samples_area_images(),
    };
    let shown = eye.trace(&from, point.normal, stream, &mut places);
    (shown, places)
}

/// Returns the eye of an entry that is a direction of view.
fn eye_of<'a>(around: &Surroundings<'a>, entries: &Entries, entry: usize) -> Option<&'a ReceiverPoint> {
    match (entries.kind, &entries.lines_of_sight) {
        (MapKind::Receivers(set), Some(_)) => Some(&around.scene.receivers[set].points[entry]),
        _ => None,
    }
}

/// Returns the indirect light of an entry that is a direction of view, in two halves, and the number of rays. Each walk has a new line of
/// sight. `walks` holds the number of the first walk and the count.
pub fn walks_of_entry(
    around: &Surroundings,
    entries: &Entries,
    entry: usize,
    walks: [u32; 2],
    seed: u64,
    cut: &mut Cut,
) -> ([f64; HALVES], u64) {
    in_halves(entry as u64, walks, seed, |stream| sample_indirect(around, entries, entry, cut, stream))
}
