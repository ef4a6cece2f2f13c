//! How `auto` compares methods for a map: counts or walks, gathering and local estimation, as far as each is expected to be worth its
//! pilot. It compares their work to the target. Work is counted in rays: those of a method, plus the cost of choosing among luminaires.

use std::ops::RangeInclusive;

use super::context::Context;
use super::job::{Engine, Job, Offer, Offered, SHARE_OF_A_LOOK};
use super::local::{Kernel, LocalPlan};
use super::{DEFAULT_TARGET_ERROR, Method};
use crate::control::needed_work;
use crate::maps::MapKind;
use crate::scene::Quantity;

/// Work by the cheapest other method below which local estimation is not considered. Its first looks take about the first number of rays.
/// Its pilot samples all points and is worth the second number of rays per point, up to the third number of points.
const LEAST_WORK: f64 = 6e4;
const LEAST_WORK_A_POINT: f64 = 2e3;
const MOST_POINTS: usize = 1024;
/// Work of a ray of local estimation relative to one of a walk. Measured in seven made-up rooms: 0.7 to 1.4; in rooms of a dozen triangles
/// half.
const WORK_OF_A_CONNECTION: f64 = 0.75;
/// Variance of a chain's scores relative to their squared mean, per chain of the pilot. Above this value the pilot is not trusted.
const MOST_SCATTER: f64 = 1.0 / 16.0;
/// Limits for the ratio of the light that the pilot's chains bring if unobstructed to what walks find. Beyond these limits either most
/// connections are blocked or chains seldom reach the surfaces that the light comes from.
const MOST_HIDDEN: f64 = 4.0;
const LEAST_FOUND: f64 = 0.5;
/// If a pilot is not trusted and at least this much work is at stake, a second one traces its connections. Its light must agree with that
/// of walks within the second factor.
const WORTH_TRACING: f64 = 1.5e6;
const MOST_APART: f64 = 2.0;
const MOST_SCATTER_TRACED: f64 = 0.125;
/// A map leaves local estimation or gathering if another method is cheaper by this factor by the latest look: early looks are uncertain.
const LEAVING: f64 = 1.5;

/// Writes an offer or its absence, and reads it again. The reason for the absence no longer matters and is not stored.
pub mod kept_offer {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::{Offer, Offered};

    pub fn serialize<S: Serializer>(offered: &Option<Offered>, serializer: S) -> Result<S::Ok, S::Error> {
        offered.as_ref().map(|offered| offered.as_ref().ok()).serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Offered>, D::Error> {
        let offered = Option::<Option<Offer>>::deserialize(deserializer)?;
        Ok(offered.map(|offer| offer.ok_or("considered before the run was resumed")))
    }
}

/// Reason: local estimation is not considered while little work is left.
const TOO_LITTLE_WORK: &str = "the target takes less work than its pilot and first error checks";
/// Reason: the pilot is not trusted. Local estimation is considered again if a look finds more work.
const UNSURE: &str = "its pilot's chains seldom reach the points";
/// Reason: elements are not connected to chains.
const POINTS_ONLY: Result<usize, &str> = Err("for points only");

/// Whether the cheapest other method takes so much work that local estimation is worth its pilot.
fn is_worth_a_pilot(job: &Job, at_best: f64) -> bool {
    at_best >= LEAST_WORK.max(LEAST_WORK_A_POINT * job.map.len().min(MOST_POINTS) as f64)
}

/// The receiver set whose points can be connected to chains, or the reason why there is none.
fn connectable(context: &Context, job: &Job) -> Result<usize, &'static str> {
    let MapKind::Receivers(set) = job.kind else {
        return POINTS_ONLY;
    };
    if !job.bound {
        return Err("the target does not bind this map");
    }
    let quantity = context.scene.receivers[set].quantity;
    if matches!(quantity, Quantity::Glare(_) | Quantity::Intensity { .. }) {
        return Err("for illuminances and luminances only");
    }
    // Lines of sight follow mirrors and panes themselves. Vertices on gloss cost a luminance more chains than they save.
    let is_view = quantity == Quantity::Luminance;
    if !is_view && !context.world.is_diffuse() {
        return Err("for diffuse surfaces only");
    }
    if is_view && context.world.has_lobes() {
        return Err("for scenes without gloss only");
    }
    Ok(set)
}

/// Whether a pilot found as much light as walks, and had enough chains for a reliable variance.
fn is_believed(plan: &LocalPlan, weights: &[f64], found: RangeInclusive<f64>, scatter: f64) -> bool {
    found.contains(&plan.found) && plan.scatter(weights) <= scatter * plan.pilot_chains as f64
}

/// Runs the pilot of local estimation for a map, if it can pay. The pilot's samples enter no result, and its rays are counted.
/// `at_best` is the work by the cheapest other method.
fn offer(context: &Context, job: &mut Job, set: usize, target: f64, at_best: f64) -> Offered {
    if context.is_over() {
        return Err("the run is over");
    }
    let absolute_error = target * job.mean_without_gathering();
    let mut plan = LocalPlan::of(context, set, Kernel::Bounded, at_best);
    job.work.pilot_rays += plan.pilot_rays;
    if !is_believed(&plan, &job.weights, LEAST_FOUND..=MOST_HIDDEN, MOST_SCATTER) {
        if at_best < WORTH_TRACING || context.is_over() {
            return Err(UNSURE);
        }
        plan = LocalPlan::by_tracing(context, set, at_best);
        job.work.pilot_rays += plan.pilot_rays;
        if !is_believed(&plan, &job.weights, 1.0 / MOST_APART..=MOST_APART, MOST_SCATTER_TRACED) {
            return Err("its chains seldom reach the points");
        }
    }
    let work = WORK_OF_A_CONNECTION * job.rays_by_connecting(&plan, absolute_error);
    Ok(Offer { plan, work })
}

/// Work to the target by gathering, or the reason why it was not considered.
type GatheringWork = Result<f64, &'static str>;

/// Rays of a walk from which on points gather as soon as the pilot predicts less work than for other methods. For shorter walks the
/// predicted work must be less in proportion. Pilots of walks contain no information about errors of cells, and shorter walks leave less to
/// save. (In 18 sets of eight made-up rooms with walks of 3 to 10 rays, the first look found three to twelve times the prediction. In four
/// white rooms, with some 50 rays, 32 takes 0.67 to 1.06 of the time of 64, and 128 takes 1.05 to 1.25. Elsewhere they choose the same.)
const RAYS_OF_A_WALK_WORTH_GATHERING: f64 = 32.0;

/// Chooses the cheapest method for a map and records the comparison. Returns whether the map gathers. A method that was requested is kept.
/// Without a target the length of the run is unknown, and local estimation is not considered.
/// If a first look at elements by cells is cheap, it is taken in any case; [`reconsider`] decides what follows from it.
pub fn settle(context: &Context, job: &mut Job, gathering: GatheringWork, target: Option<f64>) -> bool {
    if context.method != Method::Auto {
        return gathering.is_ok();
    }
    let error = target.unwrap_or(DEFAULT_TARGET_ERROR);
    let without = job.work_without_gathering(context, error * job.mean_without_gathering());
    let at_best = match gathering {
        Ok(work) if job.kind == MapKind::Elements => work.min(without),
        _ => without,
    };
    let offered = match (connectable(context, job), target) {
        (Err(why), _) => Err(why),
        (_, None) => Err("no target is set"),
        _ if !is_worth_a_pilot(job, at_best) => Err(TOO_LITTLE_WORK),
        (Ok(set), Some(target)) => offer(context, job, set, target, at_best),
    };
    job.method_reason = reason(job.engine == Engine::Collision, error, gathering, without, &offered);
    let of_local = offered.as_ref().map_or(f64::INFINITY, |offer| offer.work);
    let gathers = |work: f64| {
        if job.kind != MapKind::Elements {
            return points_gather(job, work, without.min(of_local));
        }
        let is_cheap = job.rays_to_first_look(error) < SHARE_OF_A_LOOK * of_local.min(work);
        work < without && is_cheap || work < without.min(of_local)
    };
    if gathering.is_ok_and(gathers) {
        job.connecting.offered = Some(offered).filter(|offered| !matches!(offered, Err(TOO_LITTLE_WORK | UNSURE)));
        return true;
    }
    if let Ok(offer) = offered
        && offer.work < without
    {
        job.start_connecting(offer.plan);
    }
    false
}

/// Whether points gather, by the work for it and that of the cheapest other method.
fn points_gather(job: &Job, work: f64, at_best: f64) -> bool {
    work < (job.rays_of_a_walk() / RAYS_OF_A_WALK_WORTH_GATHERING).min(1.0) * at_best
}

/// Whether points will gather by what their pilot of walks shows, before local estimation is considered.
pub fn is_about_to_gather(context: &Context, job: &Job, target: f64) -> bool {
    if job.kind == MapKind::Elements || !job.has_light_to_gather(context) {
        return false;
    }
    let without = job.work_without_gathering(context, target * job.mean_without_gathering());
    context.method == Method::Gather || points_gather(job, job.work_by_gathering(context, target), without)
}

/// The comparison for a map, as text: work to the target.
fn reason(counts: bool, error: f64, gathering: GatheringWork, without: f64, offered: &Offered) -> String {
    let of = |work: Result<f64, &str>, name: &str| match work {
        Ok(work) => format!("{work:.1e} by {name}"),
        Err(why) => format!("{name} not considered ({why})"),
    };
    let (target, gathering) = ((error * 1e4).round() / 100.0, of(gathering, "gathering"));
    if counts {
        return format!("work to reach {target} %, estimated by the pilot: {without:.1e} by counting, {gathering}");
    }
    let local = of(offered.as_ref().map(|offer| offer.work).map_err(|why| *why), "local estimation");
    format!("work to reach {target} %, estimated by the pilot: {without:.1e} by walks, {local}, {gathering}")
}

/// Reconsiders the method after a look. The map changes from cells to local estimation, or from either to walks. It does so if the new
/// method needs far less work than is still to come.
pub fn reconsider(context: &Context, job: &mut Job, target: f64) {
    if job.met || job.looks.refused {
        return;
    }
    let absolute_error = target * job.judgement.mean;
    let walks = job.work_without_gathering(context, absolute_error);
    // Counts on the finer elements that are needed would take far more than on the present ones.
    if let Some(more) = job.work_left_to_gather(absolute_error).filter(|_| !job.may_be_cut()) {
        let at_best = more.min(walks);
        if job.connecting.offered.is_none() && is_worth_a_pilot(job, at_best) {
            let offered = connectable(context, job).and_then(|set| offer(context, job, set, target, at_best));
            job.connecting.offered = Some(offered).filter(|offered| !matches!(offered, Err(UNSURE)));
        }
        let is_far_cheaper = |offer: &mut Offer| LEAVING * offer.work < at_best;
        if let Some(Ok(offer)) = job.connecting.offered.take_if(|offered| offered.as_mut().is_ok_and(is_far_cheaper)) {
            job.method_reason = format!(
                "remaining work, estimated by an error check in the run: {more:.1e} by gathering, {walks:.1e} by \
                 walks, {:.1e} by local estimation",
                offer.work
            );
            job.stop_gathering(context);
            job.start_connecting(offer.plan);
            job.next_judgement = job.first_samples();
        } else if more > LEAVING * walks {
            job.stop_gathering(context);
            job.method_reason = format!(
                "{}; remaining work, estimated by an error check in the run: {more:.1e} by gathering, {walks:.1e} \
                 by walks or counting",
                job.method_reason
            );
            job.next_judgement = job.first_samples();
        }
    } else if job.connects() {
        let needed = needed_work(target, &job.judgement, job.error_exponent());
        let more = WORK_OF_A_CONNECTION * (needed - 1.0).max(0.0) * job.work.rays as f64;
        if more > LEAVING * walks {
            job.stop_connecting();
            job.method_reason = format!(
                "remaining work, estimated by an error check in the run: {more:.1e} by local estimation, \
                 {walks:.1e} by walks"
            );
            job.next_judgement = job.first_samples();
        }
    }
}
