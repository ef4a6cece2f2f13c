//! Decides whether the results of a proof are accepted, with bounds that allow for random variation.

use super::campaign::Proof;
use super::judgement::LEVEL;
use super::summary::{Group, Sums};
use crate::validation::calibration::fewest_met;
use crate::validation::words::{percent, significant};

/// Maximum true error over the target for a map that reported "target met".
const MOST_OVER_TARGET: f64 = 1.3;
/// Maximum deviation of the coverage of all error bars from its level, and minimum coverage of one room.
const COVERAGE_ALLOWANCE: f64 = 0.01;
const LEAST_OF_A_ROOM: f64 = 0.91;
/// Number of standard errors by which a coverage may deviate randomly.
const BY_CHANCE: f64 = 3.0;

/// Failed conditions in words; empty if the proof is accepted.
pub fn failures(proof: &Proof) -> Vec<String> {
    let mut found = Vec::new();
    for group in [Group::Tuned, Group::Untuned] {
        let sums = proof.sums(group, None);
        found.extend(too_few(&sums).map(|what| format!("rooms {}: {what}", group.name())));
    }
    let all = proof.sums(Group::All, None);
    if all.worst > MOST_OVER_TARGET {
        let (worst, most) = (significant(all.worst, 3), significant(MOST_OVER_TARGET, 3));
        found.push(format!("{}: a true error of {worst} targets, more than {most}", all.worst_name));
    }
    let of_rooms: Vec<f64> = proof.rooms.iter().map(|room| room.sums(None).coverage()).collect();
    let by_chance = BY_CHANCE * standard_error(&of_rooms, all.coverage(), all.bars);
    if all.bars > 0 && (all.coverage() - LEVEL).abs() > COVERAGE_ALLOWANCE + by_chance {
        found.push(format!(
            "error bars of {} hold in {} (± {} by chance)",
            percent(LEVEL),
            percent(all.coverage()),
            percent(by_chance)
        ));
    }
    for room in &proof.rooms {
        let sums = room.sums(None);
        found.extend(covers_too_little(&sums).map(|what| format!("{}: {what}", room.name())));
    }
    found
}

/// Remarks for the reader that do not affect the acceptance.
pub fn remarks(proof: &Proof) -> Vec<String> {
    let mut found = Vec::new();
    for room in &proof.rooms {
        let sums = room.sums(None);
        if sums.missed > 0 {
            found.push(format!("{}: {} maps ended without meeting their target", room.name(), sums.missed));
        }
        if sums.unjudged > 0 {
            found.push(format!(
                "{}: the reference is not accurate enough to judge {} maps",
                room.name(),
                sums.unjudged
            ));
        }
    }
    let mut reasons: Vec<String> = Vec::new();
    for room in &proof.rooms {
        if let Err(reason) = &room.rival {
            reasons.push(format!("{}: no rival: {reason}", room.name()));
        }
    }
    // If all rooms have a reason, the reasons are left out.
    if reasons.len() < proof.rooms.len() {
        found.append(&mut reasons);
    }
    found
}

/// Reports if fewer maps meet their target than random variation of a 95% promise allows.
fn too_few(sums: &Sums) -> Option<String> {
    let fewest = fewest_met(sums.said_met);
    (sums.said_met > 0 && sums.truly_met < fewest)
        .then(|| format!("{} of {} maps truly met their target, fewer than {fewest}", sums.truly_met, sums.said_met))
}

fn covers_too_little(sums: &Sums) -> Option<String> {
    let by_chance = BY_CHANCE * standard_error(&sums.shares, sums.coverage(), sums.bars);
    (sums.bars > 0 && sums.coverage() + by_chance < LEAST_OF_A_ROOM).then(|| {
        format!(
            "error bars of {} hold in {}, less than {}",
            percent(LEVEL),
            percent(sums.coverage()),
            percent(LEAST_OF_A_ROOM)
        )
    })
}

/// Standard error of a share: from the spread of its parts, and at least that of independent bars.
fn standard_error(parts: &[f64], share: f64, bars: usize) -> f64 {
    let of_bars = (share * (1.0 - share) / bars.max(1) as f64).sqrt();
    if parts.len() < 2 {
        return of_bars;
    }
    let count = parts.len() as f64;
    let mean = parts.iter().sum::<f64>() / count;
    let spread = parts.iter().map(|part| (part - mean).powi(2)).sum::<f64>();
    of_bars.max((spread / (count * (count - 1.0))).sqrt())
}

#[cfg(test)]
mod tests {
    use super::super::campaign::{MapProof, RoomProof, RunProof};
    use super::super::judgement::RoomJudgement;
    use super::super::reference::Cost;
    use super::super::summary::mean_and_worst;
    use super::*;

    /// Ten rooms with 20 runs of one map to 1%. In `off` of 20 runs the true error exceeds the target by the factor `over`. `held`
    /// of 200 error bars contain the truth.
    fn proof(off: usize, over: f64, held: usize) -> Proof {
        let run = |seed: u64| RunProof {
            target_error: 0.01,
            seed,
            cost: Cost { rays: 1e6, cpu_s: 1.0 },
            stop_reason: "target_met",
            forecasts: Vec::new(),
            maps: vec![MapProof {
                name: "work plane".to_owned(),
                estimator: "gather".to_owned(),
                said_met: true,
                stated_error: 0.009,
                judgement: RoomJudgement {
                    true_error: if seed < off as u64 { 0.01 * over } else { 0.008 },
                    reference_error: 0.003,
                    bars: 200,
                    held,
                },
            }],
        };
        let room = |seed: u64| RoomProof {
            kind: "furnished",
            seed,
            triangles: 12,
            luminaires: 1,
            reference: Cost::default(),
            walks: vec![Cost { rays: 1e8, cpu_s: 50.0 }],
            rival: Ok(vec![Cost { rays: 1e8, cpu_s: 20.0 }]),
            runs: (0..20).map(run).collect(),
        };
        Proof { rooms: (0..10).map(room).collect() }
    }

    /// 5% of the runs over the target are allowed. 15% of the runs are not, and neither is 1.35 times the target once.
    #[test]
    fn planted_faults_fail_and_sound_runs_do_not() {
        assert_eq!(failures(&proof(1, 1.1, 190)), Vec::<String>::new());
        assert!(failures(&proof(3, 1.1, 190)).iter().any(|failure| failure.contains("fewer than")));
        assert!(failures(&proof(1, 1.35, 190)).iter().any(|failure| failure.contains("1.35 targets")));
        // Error bars that hold in 92%: less than 94% over all, but enough for each room. With 88% both conditions fail.
        let low = failures(&proof(1, 1.1, 184));
        assert!(low.len() == 1 && low[0].contains("92"), "{low:?}");
        assert_eq!(failures(&proof(1, 1.1, 176)).len(), 11);
        assert!(failures(&proof(1, 1.1, 198)).iter().any(|failure| failure.contains("99")));
    }

    #[test]
    fn a_reference_that_is_no_more_exact_than_the_target_judges_nothing() {
        let mut proof = proof(20, 2.0, 190);
        for map in proof.rooms.iter_mut().flat_map(|room| &mut room.runs).flat_map(|run| &mut run.maps) {
            map.judgement.reference_error = 0.007;
        }
        assert_eq!(failures(&proof), Vec::<String>::new());
        assert_eq!(proof.sums(Group::All, Some(0.01)).unjudged, 200);
    }

    #[test]
    fn means_of_ratios_are_geometric() {
        let (mean, worst) = mean_and_worst([2.0, 8.0].into_iter()).unwrap();
        assert!((mean - 4.0).abs() < 1e-12 && worst == 2.0);
        assert_eq!(mean_and_worst(std::iter::empty()), None);
    }
}
