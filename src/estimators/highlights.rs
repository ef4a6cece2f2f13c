//! Highlights of point-like luminaires on flat glossy surfaces.
//!
//! A walk rarely meets a narrow lobe where it sends a luminaire's light back along the walk, and this light is strong. So points also draw
//! directions near the one in which a mirror would show the luminaire ([`Highlight`]). Both find the same light, and share it by their
//! densities (docs/methods.md (56)).

use glam::DVec3;

use super::direct::{SampleCost, Sight, light_sample_of};
use super::images::{ImageResponse, Trail};
use super::receiver::Receiver;
use crate::geometry::{Meeting, SurfaceHit};
use crate::sampling::beam::Beam;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::highlight::Highlight;
use crate::sampling::random::Stream;
use crate::sampling::reflection::{LobeKind, Pair};
use crate::transport::{GlossyFacets, Traced, World};

/// A direction to a highlight.
struct ToHighlight {
    /// Number of the facet.
    facet: usize,
    /// Number of the emitter.
    number: u32,
    /// Unit direction.
    direction: DVec3,
    /// Density of the draw per sr, with the choices of the facet and of the emitter.
    per_sr: f64,
}

/// One unbiased sample of the highlights that a point sees, without the part that is left to walks, weighted by the point's responses to
/// light from a direction; and the number of rays. The search is made with a probability of `chance` (1: always). Walks from the point must
/// have a trail made with the same probability.
pub fn sample_highlights(
    (world, gloss): (&World, &GlossyFacets),
    receiver: &Receiver,
    chance: f64,
    responses: impl Fn(DVec3) -> [ImageResponse; 2],
    cut: &mut Cut,
    stream: &mut Stream,
) -> Traced {
    if chance < 1.0 && !stream.happens(chance) {
        return Traced::default();
    }
    let Some(drawn) = draw(world, gloss, receiver, cut, stream) else {
        return Traced::default();
    };
    let direction = drawn.direction;
    let nothing = Traced { value: 0.0, rays: 1 };
    let Meeting::Surface(hit) = world.tracer.first_hit(receiver.origin, direction) else {
        return nothing;
    };
    if gloss.number(hit.triangle, hit.side) != Some(drawn.facet) {
        return nothing;
    }
    let normal = world.normal_at(&hit);
    let origin = world.leave(&hit, LobeKind::Spread);
    let lit = Receiver { point_m: world.tracer.position_m(&origin), normal, origin: &origin };
    let Some(sight) = light_sample_of(world, (drawn.number, 1.0), &lit, SampleCost::Full, stream) else {
        return nothing;
    };
    let lobe_per_sr =
        world.bsdf(hit.triangle).lobe_per_sr(&Pair { normal, towards: sight.towards, leaving: -direction });
    let luminance_cd_m2 = lobe_per_sr * sight.direct_lx();
    if luminance_cd_m2 == 0.0 {
        return Traced { value: 0.0, rays: 2 };
    }
    let choices = world.choices((hit.triangle, hit.side), lit.point_m, normal, cut);
    let cosine = direction.dot(receiver.normal);
    let walked = cosine * choices.probability(drawn.number);
    let searched_per_sr = chance * drawn.per_sr;
    let of_part = |part: &ImageResponse| part.factor / (searched_per_sr + part.ray_per_sr * walked);
    let value = responses(direction).iter().map(of_part).sum::<f64>() * cosine * luminance_cd_m2;
    Traced { value, rays: 2 }
}

/// Draws a facet, an emitter, and a direction to the emitter's highlight there. `None` if the direction misses the facet.
fn draw(
    world: &World,
    gloss: &GlossyFacets,
    from: &Receiver,
    cut: &mut Cut,
    stream: &mut Stream,
) -> Option<ToHighlight> {
    let (facet, chosen_facet) = Beam::above(from.point_m, from.normal).choose(&gloss.facets, stream.fine_unit())?;
    let mirror = &gloss.facets[facet];
    let variate = stream.fine_unit();
    let (number, chosen) = gloss.points.choose_number(mirror.image_m(from.point_m), mirror.normal, variate, cut)?;
    let highlight = highlight(world, gloss, facet, from.point_m, number)?;
    let direction = highlight.draw(stream.pair());
    let per_sr = chosen_facet * chosen * highlight.per_sr(direction);
    let may_meet = direction.dot(from.normal) > 0.0 && mirror.is_met(from.point_m, direction);
    (may_meet && per_sr > 0.0).then_some(ToHighlight { facet, number, direction, per_sr })
}

/// Returns the highlight of an emitter on a facet as a point sees it.
fn highlight(world: &World, gloss: &GlossyFacets, facet: usize, point_m: DVec3, number: u32) -> Option<Highlight> {
    let ball = world.emitters.list()[number as usize].bounding_ball();
    Highlight::new(&gloss.facets[facet], gloss.widths_rad[facet], point_m, ball)
}

/// Share of the light by a lobe that a walk counts where it takes a light sample. It is z/(1 + z), with z the density of the walk and its
/// light sample over that of the search at the walk's last point.
pub fn share_of_walk(
    world: &World,
    trail: &Option<Trail>,
    (hit, direction): (&SurfaceHit, DVec3),
    sight: &Sight,
    cut: &mut Cut,
) -> f64 {
    let (Some(gloss), Some((point_m, normal, ray_per_sr))) = (&world.gloss, trail.as_ref().and_then(Trail::straight))
    else {
        return 1.0;
    };
    let to = ((hit, direction), sight.index);
    searched_per_sr(world, gloss, (point_m, normal), to, cut).map_or(1.0, |searched_per_sr| {
        let walked_per_sr = ray_per_sr * direction.dot(normal) * sight.probability;
        walked_per_sr / (walked_per_sr + searched_per_sr)
    })
}

/// Density per sr with which a search from a point with a unit normal draws a direction to an emitter's highlight. `None` where it never
/// does.
fn searched_per_sr(
    world: &World,
    gloss: &GlossyFacets,
    (point_m, normal): (DVec3, DVec3),
    ((hit, direction), number): ((&SurfaceHit, DVec3), u32),
    cut: &mut Cut,
) -> Option<f64> {
    let facet = gloss.number(hit.triangle, hit.side)?;
    let per_sr = highlight(world, gloss, facet, point_m, number)?.per_sr(direction);
    if per_sr == 0.0 {
        return None;
    }
    let chosen_facet = Beam::above(point_m, normal).probability(&gloss.facets, facet)?;
    let mirror = &gloss.facets[facet];
    let chosen = gloss.points.probability(number, mirror.image_m(point_m), mirror.normal, cut)?;
    Some(chosen_facet * chosen * per_sr)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_1_PI;
    use std::path::Path;

    use super::*;
    use crate::check::scene_from_json;
    use crate::estimators::walk::{evenly, sample_arriving_share_lx, sample_indirect_lx, trail_from};
    use crate::estimators::walks_in_a_box::EmptyBox;
    use crate::sampling::random::Purpose;
    use crate::sampling::warp::cosine_hemisphere;

    const EDGE_M: f64 = 3.0;
    const REFLECTANCE: f64 = 0.6;
    const LM: f64 = 1000.0;

    /// A cube of one reflectance, with lobes on its floor and on a wall, a point and a ring.
    fn world() -> World {
        let text = format!(
            r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": {REFLECTANCE} }},
                "floor": {{ "type": "phong", "diffuse_reflectance": 0.2, "specular_reflectance": {}, "exponent": 150 }},
                "wall": {{ "type": "blinn", "diffuse_reflectance": 0.3, "specular_reflectance": {}, "exponent": 400 }} }},
            "geometry": [ {{ "name": "r", "type": "box", "min": [0,0,0], "max": [{EDGE_M},{EDGE_M},{EDGE_M}], "facing": "inward",
                "material": "m", "materials": {{ "floor": "floor", "x_max": "wall" }} }} ],
            "luminaires": [ {{ "name": "a", "type": "point", "position": [0.8,1.9,2.1], "luminous_flux_lm": {} }},
                {{ "name": "b", "type": "ring", "center": [1.9,1.1,2.3], "inner_radius": 0.1, "outer_radius": 0.2, "aim": [0.2,0,-1],
                   "luminous_flux_lm": {} }} ] }}"#,
            REFLECTANCE - 0.2,
            REFLECTANCE - 0.3,
            0.6 * LM,
            0.4 * LM
        );
        let world = World::new(&scene_from_json(&text, None, Path::new(".")).expect("a valid scene"));
        assert_eq!(world.gloss.as_ref().map(|gloss| gloss.facets.len()), Some(2));
        world
    }

    /// The mean over all faces of a closed room of one reflectance is Φ ρ/(A (1 − ρ)), whatever the lobes. 400,000 walks, seed 3, α = 1e-5
    /// (4.4 σ). A mean without half of what a search finds is rejected (below, at a point).
    #[test]
    fn highlights_move_no_mean() {
        let cube = EmptyBox([EDGE_M; 3]);
        let world = world();
        let walk =
            |receiver: &Receiver, cut: &mut Cut, stream: &mut Stream| sample_indirect_lx(&world, receiver, cut, stream);
        let walks = 400_000;
        let [mean_lx, variance, _] = cube.walks(&world, (walks, 3), walk);
        let exact_lx = LM * REFLECTANCE / (cube.area_m2() * (1.0 - REFLECTANCE));
        let off = (mean_lx - exact_lx) / (variance / walks as f64).sqrt();
        assert!(off.abs() < 4.4, "{mean_lx} lx for {exact_lx} lx, {off} σ");
    }

    /// Mean and variance of the indirect illuminance in lx at a point of the ceiling, by 200,000 samples: searches for highlights, and
    /// walks that know of them by their trail or do not.
    fn at_the_ceiling_lx(world: &World, searches: bool, have_trails: bool, seed: u64) -> [f64; 2] {
        let (point_m, normal) = (DVec3::new(1.2, 1.7, EDGE_M), -DVec3::Z);
        let origin = world.tracer.side_origin(point_m, normal);
        let receiver = Receiver { point_m, normal, origin: &origin };
        let (mut cut, mut stream) = (Cut::default(), Stream::new(seed, Purpose::Pilot, 0, 0));
        let [mut sum, mut squares, count] = [0.0, 0.0, 200_000.0];
        for sample in 0..count as u64 {
            stream.seek(sample);
            let direction = cosine_hemisphere(normal, stream.pair());
            let trail = trail_from(world, 1.0, || (point_m, normal, FRAC_1_PI)).filter(|_| have_trails);
            let mut found =
                sample_arriving_share_lx(world, (origin, trail), direction, |_, _| [1.0; 2], &mut cut, &mut stream);
            if let Some(gloss) = world.gloss.as_ref().filter(|_| searches) {
                let responses = |_| evenly(1.0, FRAC_1_PI);
                found += sample_highlights((world, gloss), &receiver, 1.0, responses, &mut cut, &mut stream);
            }
            sum += found.value;
            squares += found.value * found.value;
        }
        let mean = sum / count;
        [mean, (squares / count - mean * mean) / count]
    }

    /// Searches and walks share the light of highlights by their densities: the mean at a point is that of walks alone, with a third of the
    /// variance or less. Seeds 4 to 7, α = 1e-5 each (4.4 σ). Rejected: walks that count highlights in full beside a search, and walks that
    /// leave a part to a search that is not made.
    #[test]
    fn searches_and_walks_share_highlights() {
        let with_search = world();
        let mut alone = world();
        alone.gloss = None;
        let plain = at_the_ceiling_lx(&alone, false, false, 4);
        let off = |found: [f64; 2]| (found[0] - plain[0]) / (found[1] + plain[1]).sqrt();
        let shared = at_the_ceiling_lx(&with_search, true, true, 5);
        assert!(off(shared).abs() < 4.4, "{shared:?} {plain:?}");
        assert!(shared[1] < plain[1] / 3.0, "{shared:?} {plain:?}");
        let twice = at_the_ceiling_lx(&with_search, true, false, 6);
        let lost = at_the_ceiling_lx(&with_search, false, true, 7);
        assert!(off(twice) > 4.4 && off(lost) < -4.4, "{twice:?} {lost:?} {plain:?}");
    }
}
