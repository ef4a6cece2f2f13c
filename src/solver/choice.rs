//! What `auto` weighs for a map: the work to the target by counts or walks, by gathering and by local estimation, as far as each
//! can be expected to pay for its pilot. Work is counted, in rays: those of a method, and what choosing among luminaires
//! takes beside them.

use super::Method;
use super::job::{Context, Job};
use super::local::{Kernel, LocalPlan};
use super::pilot::is_over;
use crate::control::needed_work;
use crate::maps::MapKind;
use crate::scene::Quantity;

/// Work by walks below which local estimation is not weighed: its first looks take about as many.
const LEAST_WORK: f64 = 6e4;
/// Points up to which local estimation is weighed before gathering. Where there are more, gathering is the cheaper wherever
/// it applies (docs/performance.md), and is asked first.
const FEW_POINTS: usize = 256;
/// Variance of a chain's scores over their squared mean above which a pilot of some hundred chains is not believed.
const MOST_SCATTER: f64 = 16.0;
/// What the chains of the pilot bring, were nothing in the way, over what walks say that they do: beyond these bounds either
/// most connections are blocked or chains seldom come to where the light comes from.
const MOST_HIDDEN: f64 = 2.0;
const LEAST_FOUND: f64 = 0.5;
/// A map leaves local estimation for what is so many times cheaper by all that a look tells: early looks are unsure.
const LEAVING: f64 = 2.0;

/// Error at which methods are weighed against each other where no target is set.
const USUAL_ERROR: f64 = 0.01;

/// Local estimation as a map could have it.
pub struct Offer {
    plan: LocalPlan,
    /// Work to the target: rays alone, since its chains begin at luminaires and choose none.
    pub work: f64,
}

/// Local estimation, or why it was not weighed.
pub type Offered = Result<Offer, &'static str>;

/// Elements are not connected to chains.
const POINTS_ONLY: Offered = Err("for points only");

/// When a map is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// Before gathering is piloted: maps of few points.
    First,
    /// After it: maps of many, which it does not suit.
    Last,
}

/// Why a map of many points is not asked at first.
const NOT_YET: &str = "dearer than gathering for so many points";

/// Pilots local estimation for a map, if it can pay: the pilot's samples enter no result, and its rays are counted.
///
/// Without a target nothing tells how far a run will go, and it is not weighed.
pub fn offer(context: &Context, job: &mut Job, target: Option<f64>, turn: Turn) -> Offered {
    let MapKind::Receivers(set) = job.kind else {
        return POINTS_ONLY;
    };
    let Some(target) = target.filter(|_| job.bound && context.method == Method::Auto) else {
        return Err("without a target");
    };
    if matches!(context.scene.receivers[set].quantity, Quantity::Luminance | Quantity::Glare(_)) {
        return Err("for illuminances only");
    }
    if is_over(context) {
        return Err("the run is over");
    }
    if !context.stage.is_diffuse() {
        return Err("for diffuse surfaces only");
    }
    let error_lx = target * job.mean_without_gathering_lx();
    if job.work_without_gathering(context, error_lx) < LEAST_WORK {
        return Err("walks take less work than its first looks");
    }
    if turn == Turn::First && job.map.len() > FEW_POINTS {
        return Err(NOT_YET);
    }
    let plan = LocalPlan::of(context, set, Kernel::Bounded);
    job.pilot_rays += plan.pilot_rays;
    if !(LEAST_FOUND..=MOST_HIDDEN).contains(&plan.found) || plan.scatter(&job.weights) > MOST_SCATTER {
        return Err("its chains seldom reach the points");
    }
    let work = job.rays_by_connecting(&plan, error_lx);
    Ok(Offer { plan, work })
}

/// Work to the target by gathering, or why that was not weighed.
type Gathering = Result<f64, &'static str>;

/// Takes the cheapest way for a map and says what was weighed; whether it gathers. A method that was asked for stays.
pub fn settle(
    context: &Context,
    job: &mut Job,
    mut offered: Offered,
    gathering: Gathering,
    target: Option<f64>,
) -> bool {
    if context.method != Method::Auto {
        return gathering.is_ok();
    }
    let error = target.unwrap_or(USUAL_ERROR);
    let without = job.work_without_gathering(context, error * job.mean_without_gathering_lx());
    if !gathering.is_ok_and(|work| work < without) && matches!(offered, Err(NOT_YET)) {
        offered = offer(context, job, target, Turn::Last);
    }
    job.method_reason = reason(job.kind, error, gathering, without, &offered);
    let at_best = offered.as_ref().map_or(without, |offer| offer.work.min(without));
    if gathering.is_ok_and(|work| work < at_best) {
        return true;
    }
    if let Ok(offer) = offered
        && offer.work < without
    {
        job.start_connecting(offer.plan);
    }
    false
}

/// What was weighed for a map: work to the target.
fn reason(kind: MapKind, error: f64, gathering: Gathering, without: f64, offered: &Offered) -> String {
    let of = |work: Result<f64, &str>, name: &str| match work {
        Ok(work) => format!("{work:.1e} by {name}"),
        Err(why) => format!("{name} not weighed ({why})"),
    };
    let (target, gathering) = ((error * 1e4).round() / 100.0, of(gathering, "gathering"));
    if kind == MapKind::Elements {
        return format!("by the pilot, work in rays to {target} %: {without:.1e} by counts, {gathering}");
    }
    let local = of(offered.as_ref().map(|offer| offer.work).map_err(|why| *why), "local estimation");
    format!("by the pilot, work in rays to {target} %: {without:.1e} by walks, {local}, {gathering}")
}

/// After a look: leaves local estimation, or cells, for walks, where these would be done with far less work than it still takes.
pub fn reconsider(context: &Context, job: &mut Job, target: f64) {
    if job.met || job.refused {
        return;
    }
    let walks = job.work_without_gathering(context, target * job.judgement.mean_lx);
    if let Some(more) = job.rays_to_ask() {
        if more > LEAVING * walks {
            job.stop_asking(context);
            job.method_reason =
                format!("by a look in the run, {more:.1e} rays more by gathering and {walks:.1e} by walks or counts");
            job.next_judgement = job.first_samples();
        }
    } else if job.connects() {
        let needed = needed_work(target, &job.judgement, job.error_exponent());
        let more = (needed - 1.0).max(0.0) * job.rays as f64;
        if more > LEAVING * walks {
            job.stop_connecting();
            job.method_reason =
                format!("by a look in the run, {more:.1e} rays more by local estimation and {walks:.1e} by walks");
            job.next_judgement = job.first_samples();
        }
    }
}
