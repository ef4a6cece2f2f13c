//! Notes and warnings of a light-mesh run about its maps.

use crate::light_mesh::{DirectPlan, IndirectPlan, MapPlan, TracedMap, Why};

/// Warns that shadow rays or walks replace the given step, because the step misses the target that is given too.
pub(super) fn step_not_taken(map: &TracedMap, plan: &MapPlan) -> Vec<String> {
    let of = |part: &str, why: &Why| match why {
        Why::StepMisses(error) => Some(format!(
            "light mesh: \"{}\": the given step is not used for {part} light, since it leaves an error of {:.2} %; \
             without --target-error it is used",
            map.map.name,
            100.0 * error
        )),
        _ => None,
    };
    let direct = if let DirectPlan::Rays(why) = &plan.direct { of("direct", why) } else { None };
    let indirect = if let IndirectPlan::Walks(why) = &plan.indirect { of("indirect", why) } else { None };
    direct.into_iter().chain(indirect).collect()
}

/// Notes for the user on how a map was computed.
pub(super) fn said(map: &TracedMap, plan: &MapPlan, points_of_luminaires: usize, places: usize) -> Vec<String> {
    let name = &map.map.name;
    let rays_of_all = points_of_luminaires as f64 * places as f64;
    let mut said = Vec::new();
    match (&plan.direct, map.mesh) {
        (DirectPlan::Mesh(_), Some(facts)) => {
            let counts = &map.effort.mesh;
            said.push(format!(
                "light mesh: \"{name}\": step {:.4} m, radius {:.4} m: {} points, {} rays for direct light instead \
                 of {:.0} shadow rays from all places; {:.1} MB, {:.1} MB if dense",
                facts.step_m,
                facts.radius_m,
                counts.points,
                counts.rays(),
                rays_of_all,
                facts.bytes as f64 / 1e6,
                facts.dense_bytes / 1e6
            ));
            if counts.places_without_set > 0 {
                said.push(format!(
                    "light mesh: \"{name}\": {} of {} places saw no mesh point and sent {} shadow rays of their own",
                    counts.places_without_set, counts.places, counts.fallback_rays
                ));
            }
        }
        (DirectPlan::Rays(why), _) if *why != Why::Dark => said.push(format!(
            "light mesh: \"{name}\": {} shadow rays from all places computed direct light: {}",
            map.effort.exact_rays,
            why_in_words(why)
        )),
        _ => {}
    }
    if let Some(gathering) = &map.gathering {
        said.push(format!(
            "light mesh: \"{name}\": indirect light gathered at {} points {:.4} m apart by {} walks each",
            map.effort.gather.points, gathering.step_m, gathering.walks
        ));
    }
    if let IndirectPlan::Walks(why) = &plan.indirect {
        said.push(format!(
            "light mesh: \"{name}\": {} walks from every place, {} rays including the search, computed indirect \
             light: {}",
            map.rounds.walks,
            map.effort.gather.rays(),
            why_in_words(why)
        ));
    }
    said
}

/// States why no mesh is used.
pub(super) fn why_in_words(why: &Why) -> String {
    match why {
        Why::Cheaper(step_m) => {
            format!(
                "a mesh that is fine enough, of {step_m:.4} m or less, would take more rays than tracing from \
                 every place"
            )
        }
        Why::NotSmooth(step_m) => {
            format!("a mesh of {step_m:.4} m was no more accurate than one of twice the step")
        }
        Why::StepMisses(error) => format!("the given step leaves an error of {:.2} %", 100.0 * error),
        Why::TooFine(step_m) => {
            format!("a mesh of the given step, {step_m:e} m, has more points than can be numbered")
        }
        Why::Gloss => "a mesh would need more rays along glossy reflections".to_owned(),
        Why::Missed => "plans with a mesh missed the target".to_owned(),
        Why::NearLuminaires => {
            "a luminaire is close to a surface, and mesh points may miss the light that it gives there".to_owned()
        }
        Why::Cut => "the run ended before a mesh was found that is better than this few walks".to_owned(),
        Why::Dark => "there is none".to_owned(),
    }
}
