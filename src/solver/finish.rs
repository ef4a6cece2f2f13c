//! Converts finished jobs to a [`Solution`]: tables, flux balance and the check of the map.

use super::adapt::most_that_adapt;
use super::context::Context;
use super::ends::Ends;
use super::glare::{rate, words_on_outside};
use super::glare_rating::{GlareRating, worst_of_sets};
use super::job::{Engine, Job};
use super::sky_components::sky_components_lx;
use super::spending::{Activity, Spending};
use super::surface_tables::{receiver_table, surface_tables};
use super::{ConvergenceRow, ElementChoice, FluxBalance, MapCheck, Settings, Solution, StopReason};
use crate::base::memory::limit_bytes;
use crate::check::{luminaires_aimed_at_backs, luminaires_behind_surfaces};
use crate::estimators::walk::MOST_RAYS_OF_A_WALK;
use crate::maps::{
    MapError, MapKind, MapResult, PACKETS_OF_A_BOUND, REPLICAS, StatisticalCheck, TableRow, standard_error,
};
use crate::sampling::reflection::Bsdf;
use crate::transport::MOST_RAYS_OF_A_CHAIN;
use std::time::Instant;

/// Standard errors by which the flux that elements absorb may differ from the emitted flux. Student's t of 15 degrees of freedom exceeds it
/// once in 20,000 runs.
const MOST_DEVIATION: f64 = 5.6;

/// What a run leaves in addition to its jobs when no work is left.
pub(super) struct Ending {
    pub target_error: Option<f64>,
    pub convergence: Vec<ConvergenceRow>,
    pub spending: Spending,
    pub stop_reason: StopReason,
    pub begun_wall_s: f64,
    pub build_s: f64,
    pub compute_s: f64,
}

pub(super) fn finish(context: &Context, settings: &Settings, jobs: &mut [Job], ending: Ending) -> Solution {
    let Ending { target_error, convergence, mut spending, stop_reason, begun_wall_s, build_s, compute_s } = ending;
    let is_dark = context.world.emitters.list().is_empty();
    let ends = ends_of_chains(jobs, is_dark);
    let flux_balance = ends.map(|ends| flux_balance(context, ends));
    let map_check = ends_of_chains(jobs, is_dark).and_then(|ends| map_check(context, jobs, ends));
    if let (Ok(check), Some(target)) = (&map_check, target_error) {
        refuse_without_balance(context, jobs, check, target);
    }
    let walks = jobs.iter().any(|job| job.engine != Engine::Collision && !job.is_black());
    let paths_not_found = if walks { context.world.paths_not_found.clone() } else { Vec::new() };
    let glare: Vec<GlareRating> = jobs.iter().flat_map(|job| rate(context, job)).collect();
    let mut split_rays = 0;
    let maps = jobs.iter().map(|job| {
        let mut map = map_result(context, job, target_error);
        let started = Instant::now();
        let (components, rays) = sky_components_lx(context, job, &map.values);
        map.values.sky_components_lx = components;
        spending.add(Activity::Walks, rays, started.elapsed());
        split_rays += rays;
        map
    });
    let maps: Vec<MapResult> = maps.collect();
    let why_given =
        words_on_near_luminaires(context, settings, jobs).or_else(|| words_on_many_elements(context, settings, jobs));
    let mut notes: Vec<String> = why_given.into_iter().collect();
    notes.extend(worst_of_sets(&glare).into_iter().flat_map(|(rating, _)| words_on_outside(context, rating)));
    let mut warnings = flux_balance.as_ref().map_or(Vec::new(), |balance| warnings_of_flux(context, balance));
    warnings.extend(words_on_walks_given_up(context));
    warnings.extend(paths_not_found.iter().map(|paths| format!("not found: {paths}")));
    warnings.extend(warnings_of_glare(context, &glare));
    warnings.extend(warnings_of_maps(&maps, target_error));
    let elements = jobs.iter().find(|job| job.kind == MapKind::Elements).map(|job| job.elements.clone());
    Solution {
        method: settings.method.name().to_owned(),
        seed: settings.seed,
        target_error,
        chains: jobs.iter().map(Job::chains).sum(),
        rays: context.world.selection_rays() + split_rays + jobs.iter().map(Job::all_rays).sum::<u64>(),
        replicas: REPLICAS,
        elements: elements.unwrap_or_else(|| context.world.elements.clone()),
        glare,
        estimated_error: maps.iter().filter(|map| map.bound).map(|map| map.error.estimated).fold(0.0, f64::max),
        target_met: target_error.map(|_| jobs.iter().filter(|job| job.bound).all(is_met)),
        maps,
        stop_reason,
        flux_balance,
        map_check,
        convergence,
        spending,
        begun_wall_s,
        build_s,
        compute_s,
        paths_not_found,
        notes,
        warnings,
    }
}

/// Whether the settings let elements adapt.
fn are_to_adapt(settings: &Settings, jobs: &[Job]) -> bool {
    let is_bound = jobs.iter().find(|job| job.kind == MapKind::Elements).is_some_and(|job| job.bound);
    settings.elements == ElementChoice::Adaptive && is_bound
}

/// Reports that there are too many elements for them to adapt.
fn words_on_many_elements(context: &Context, settings: &Settings, jobs: &[Job]) -> Option<String> {
    let (count, most) = (context.world.elements.len(), most_that_adapt(settings.time_limit_s, limit_bytes()));
    (are_to_adapt(settings, jobs) && count > most).then(|| {
        format!(
            "elements stay as the scene gives them, with means as values: there are {count}, and the available time and \
             memory allow no more than {most} to adapt"
        )
    })
}

/// Reports which luminaires keep elements from being cut.
fn words_on_near_luminaires(context: &Context, settings: &Settings, jobs: &[Job]) -> Option<String> {
    let lights = context.world.near_luminaires.as_ref().filter(|lights| lights.touch())?;
    if !are_to_adapt(settings, jobs) {
        return None;
    }
    let names: Vec<&str> =
        lights.luminaires(context.world).map(|index| context.scene.luminaires[index].name.as_str()).collect();
    Some(format!(
        "elements stay as the scene gives them, with means as values: {} {} a spot from so near that no slope could show it",
        names[..names.len().min(3)].join(", "),
        if names.len() == 1 { "lights" } else { "light" }
    ))
}

/// Warnings about flux that the backs of surfaces absorb, and flux that is followed no further.
fn warnings_of_flux(context: &Context, balance: &FluxBalance) -> Vec<String> {
    let percent = |lm: f64| 100.0 * lm / balance.emitted_lm;
    let mut warnings = Vec::new();
    // The sky shines on roofs and outer walls, too.
    if balance.back_face_lm > 0.0 && context.world.emitters.list().iter().all(|emitter| !emitter.is_far()) {
        let part = luminaires_behind_surfaces(context.scene).map(|names| {
            format!(
                "part of the light-emitting area of {names} lies behind a surface; move it away from the \
                 surface, or turn its \"aim\""
            )
        });
        let whole = || {
            let names = luminaires_aimed_at_backs(context.scene)?;
            Some(format!(
                "{names} shines at it from behind; move the light-emitting area to the front of the surface, or \
                 turn its \"aim\""
            ))
        };
        let flipped = || "normals may be flipped; turn the faces round, or set \"two_sided\": true".to_owned();
        let why = part.or_else(whole).unwrap_or_else(flipped);
        let share = percent(balance.back_face_lm);
        warnings
            .push(format!("{share:.3} % of the flux hits the back of one-sided surfaces and is absorbed there: {why}"));
    }
    if balance.truncated_lm > 0.0 {
        let share = percent(balance.truncated_lm);
        warnings.push(format!(
            "{share:.3} % of the flux was cut off, after {MOST_RAYS_OF_A_CHAIN} reflections or past the time limit: \
             where surfaces are nearly white, almost nothing absorbs it"
        ));
    }
    warnings
}

fn words_on_walks_given_up(context: &Context) -> Option<String> {
    let count = context.world.patience.walks_given_up();
    (count > 0).then(|| {
        format!(
            "{} given up after {MOST_RAYS_OF_A_WALK} rays or past the time limit, since nearly white surfaces \
             absorb almost nothing: values lack the light that {} still have found",
            if count == 1 { "1 walk was".to_owned() } else { format!("{count} walks were") },
            if count == 1 { "it would" } else { "they would" },
        )
    })
}

/// Warnings about observers with a background that nothing lights.
fn warnings_of_glare(context: &Context, glare: &[GlareRating]) -> Vec<String> {
    let unlit = worst_of_sets(glare)
        .into_iter()
        .map(|(rating, _)| rating)
        .filter(|rating| rating.background_cd_m2.value <= 0.0);
    let name = |rating: &GlareRating| &context.scene.receivers[rating.set].name;
    unlit.map(|rating| format!("{}: no glare rating, since nothing lights the background", name(rating))).collect()
}

/// Warnings about maps without light, and about maps with unreliable errors.
fn warnings_of_maps(maps: &[MapResult], target_error: Option<f64>) -> Vec<String> {
    let bounds = maps.iter().filter_map(|map| Some((map, map.dark_bound_words()?)));
    let dark = bounds.map(|(map, bound)| {
        format!("no light has reached \"{}\" yet: its mean is below {bound}; run more chains to see it", map.name)
    });
    let checks = maps.iter().flat_map(|map| map.checks.iter().map(move |check| (map, check)));
    let failed = checks.filter(|(_, check)| !check.passed).map(|(map, check)| {
        format!(
            "check \"{}\" of \"{}\" failed ({:.3} against {:.3}): {}; its error is unreliable{}",
            check.name,
            map.name,
            check.value.unwrap_or(f64::NAN),
            check.limit,
            check.explanation,
            if target_error.is_some() && map.bound { ", and the target does not count as met" } else { "" }
        )
    });
    let dark = few(dark.collect(), |more| format!("no light has reached {more} more maps yet, either"));
    let failed = few(failed.collect(), |more| format!("{more} more checks failed; summary.json lists them"));
    dark.into_iter().chain(failed).collect()
}

/// Shortens a list of warnings of one kind to the first ones and the number of the others. A scene of thousands of receiver sets may cause
/// many.
fn few(mut warnings: Vec<String>, of_more: impl Fn(usize) -> String) -> Vec<String> {
    const MOST_WARNINGS: usize = 16;
    if warnings.len() > MOST_WARNINGS {
        let more = warnings.len() - MOST_WARNINGS;
        warnings.truncate(MOST_WARNINGS);
        warnings.push(of_more(more));
    }
    warnings
}

/// Whether no light was found in a map that may get some. Its relative error is then unknown.
fn is_unlit(job: &Job) -> bool {
    job.judgement.dark && !job.is_black() && job.site_weights().iter().sum::<f64>() > 0.0
}

/// Whether a map meets the target, if there is one. A map in which nothing counts does.
fn is_met(job: &Job) -> bool {
    (job.met || job.is_exact() || job.judgement.dark) && !is_unlit(job)
}

fn map_result(context: &Context, job: &Job, target_error: Option<f64>) -> MapResult {
    let judgement = job.judgement;
    let weight_sum: f64 = job.site_weights().iter().sum();
    let dark = is_unlit(job);
    let samples = (job.map.indirect_samples.complete.max(1) * REPLICAS as u64) as f64;
    let error = MapError {
        random: judgement.halves_error,
        bias: judgement.bias,
        discretisation: judgement.discretisation,
        estimated: judgement.stated_error(),
        degrees_of_freedom: judgement.degrees_of_freedom,
        dark_upper_bound: dark
            .then(|| PACKETS_OF_A_BOUND * context.world.emitters.luminous_flux_lm() / (samples * weight_sum)),
    };
    MapResult {
        name: job.name.clone(),
        kind: job.kind,
        quantity: job.kind.quantity(context.scene),
        method: job.engine.name().to_owned(),
        method_reason: job.method_reason.clone(),
        chains: job.chains(),
        values: job.values(),
        error,
        bound: job.bound,
        refusals: job.looks.refusals,
        checks: job.looks.checks.clone(),
        target_met: target_error.map(|_| is_met(job)),
        tables: tables(context, job, error.dark_upper_bound),
    }
}

/// The table rows of a map. If no light was found, all replicas agree on 0 by chance. Then it is only known that the mean is below the
/// bound, which is set two standard errors away.
fn tables(context: &Context, job: &Job, dark_upper_bound: Option<f64>) -> Vec<TableRow> {
    let mut rows = match job.kind {
        MapKind::Elements => surface_tables(context, job),
        MapKind::Receivers(set) => vec![receiver_table(context.scene, set, job)],
    };
    if let Some(bound) = dark_upper_bound {
        for row in &mut rows {
            let least = 0.5 * bound;
            row.average.standard_error = row.average.standard_error.max(least);
            if row.places > 0 {
                row.minimum.standard_error = row.minimum.standard_error.max(least);
                row.maximum.standard_error = row.maximum.standard_error.max(least);
            }
        }
    }
    rows
}

/// Ends of the packets of chains for each replica: from chains that elements counted, or from chains traced only for the flux balance.
fn ends_of_chains(jobs: &[Job], is_dark: bool) -> Result<&[Ends; REPLICAS], String> {
    let ends = jobs.iter().map(|job| &job.ends).find(|ends| ends[0].packets() > 0);
    ends.ok_or_else(|| {
        if is_dark {
            "no luminaire gives light, so no chains were traced".to_owned()
        } else if jobs.iter().any(Job::is_black) {
            "no surface reflects, so no chains were traced".to_owned()
        } else {
            "the element map was not requested, so no chains were traced from the luminaires".to_owned()
        }
    })
}

fn flux_balance(context: &Context, ends: &[Ends; REPLICAS]) -> FluxBalance {
    let mut all = Ends::default();
    for replica in ends {
        all += *replica;
    }
    let emitted_lm = context.world.emitters.luminous_flux_lm();
    let share = |packets: u64| emitted_lm * packets as f64 / all.packets().max(1) as f64;
    FluxBalance {
        emitted_lm,
        absorbed_lm: share(all.absorbed + all.panes + all.balls),
        escaped_lm: share(all.escaped),
        back_face_lm: share(all.back_faces),
        truncated_lm: share(all.cut_off),
    }
}

/// Removes the target from an element map if its elements absorb another flux than luminaires emit. The difference must exceed both random
/// error and target.
fn refuse_without_balance(context: &Context, jobs: &mut [Job], check: &MapCheck, target_error: f64) {
    let emitted_lm = context.world.emitters.luminous_flux_lm();
    let deviation = (check.absorbed_by_map_lm / emitted_lm - 1.0).abs();
    let passed = check.z_score.abs() <= MOST_DEVIATION || deviation <= target_error;
    for job in jobs.iter_mut().filter(|job| job.kind == MapKind::Elements && !job.looks.checks.is_empty()) {
        job.looks.checks.push(StatisticalCheck {
            name: "flux",
            passed,
            value: Some(check.z_score.abs()),
            limit: MOST_DEVIATION,
            explanation: "the flux that the elements absorb differs from the flux that the luminaires emit".to_owned(),
        });
        job.met &= passed;
        job.looks.refused |= !passed;
    }
}

/// Compares Σ absorptance·E·A with the emitted flux. It detects a wrong map, which the balance of counted packets cannot.
fn map_check(context: &Context, jobs: &[Job], ends: &[Ends; REPLICAS]) -> Result<MapCheck, String> {
    let job = jobs.iter().find(|job| job.kind == MapKind::Elements).ok_or("the element map was not requested")?;
    if ends.iter().any(|ends| ends.escaped > 0) {
        return Err("the scene is open: flux escaped".to_owned());
    }
    if ends.iter().any(|ends| ends.cut_off > 0) {
        return Err("packets were cut off, so the map may absorb less than the emitted flux".to_owned());
    }
    if ends.iter().any(|ends| ends.back_faces > 0) {
        return Err("flux hits the back of one-sided surfaces".to_owned());
    }
    let emitted_lm = context.world.emitters.luminous_flux_lm();
    let absorptance: Vec<f64> = (0..job.map.len() as u32)
        .map(|index| match context.world.bsdf(job.elements.element(index).triangle) {
            // The absorption of panes depends on the angle and is counted instead.
            Bsdf::Glass(_) => 0.0,
            bsdf => 1.0 - bsdf.total(1.0),
        })
        .collect();
    let absorbed_lm: Vec<f64> = (0..REPLICAS)
        .map(|replica| {
            let ends = &ends[replica];
            let counted_lm = emitted_lm * (ends.balls + ends.panes) as f64 / ends.packets().max(1) as f64;
            let elements_lm: f64 = (0..job.map.len())
                .map(|entry| absorptance[entry] * job.weights[entry] * job.map.value(replica, entry))
                .sum();
            counted_lm + elements_lm
        })
        .collect();
    let absorbed_by_map_lm = absorbed_lm.iter().sum::<f64>() / REPLICAS as f64;
    let standard_error_lm = standard_error(|replica| absorbed_lm[replica]);
    let deviation_lm = absorbed_by_map_lm - emitted_lm;
    // A map without any spread is exact up to the rounding of its sums.
    let rounding_lm = 1e-9 * emitted_lm;
    Ok(MapCheck { absorbed_by_map_lm, standard_error_lm, z_score: deviation_lm / standard_error_lm.max(rounding_lm) })
}
