//! Shares of a run and their merge: errors, bars, bias, and the number of shares that a target needs.

use std::convert::Infallible;
use std::sync::LazyLock;

use luxmc::maps::MapResult;
use luxmc::scene::{ReceiversPart, Scene};
use luxmc::solver::{
    ElementChoice, MapSelection, MapSums, Merged, Method, MoreShares, Portion, Settings, Share, ShareRecord, Solution,
    merge, solve_share,
};

use crate::common::{Silent, T15_QUANTILE_95_4, cube, with_chains};

/// Chains of a share: four walks from each of the cube's 64 points in every replica.
const CHAINS: u64 = 4096;

fn settings(method: Method, target_error: Option<f64>) -> Settings {
    Settings {
        method,
        elements: ElementChoice::Given,
        seed: 5,
        chains: Some(CHAINS),
        target_error,
        maps: MapSelection::All,
        ..Settings::default()
    }
}

struct Kept {
    solution: Solution,
    record: ShareRecord,
    sums: Vec<MapSums>,
}

fn share(scene: &Scene, number: u32, settings: &Settings) -> Kept {
    let (solution, record, sums) = solve_share(scene, settings, Share { number, of: number }, &Silent);
    Kept { solution, record, sums }
}

fn merged(scene: &Scene, settings: &Settings, shares: &[&Kept]) -> Merged {
    let records: Vec<ShareRecord> = shares.iter().map(|share| share.record.clone()).collect();
    let load = |index: usize| Ok::<_, Infallible>(shares[index].sums.clone());
    merge(scene, settings, &records, load).expect("sums in memory")
}

fn floor(solution: &Solution) -> &MapResult {
    solution.maps.iter().find(|map| map.name == "floor").expect("the receiver set")
}

/// The cube by a run (seed 900) with 512 times the work of one share.
static TRUTH: LazyLock<Solution> = LazyLock::new(|| with_chains(&cube(0.5, 2.0), 900, MapSelection::All, 512 * CHAINS));

/// 64 shares (seed 5) of counts and of walks at 64 points.
static SHARES: LazyLock<Vec<Kept>> = LazyLock::new(|| {
    let (scene, settings) = (cube(0.5, 2.0), settings(Method::Collision, None));
    (1..=64).map(|number| share(&scene, number, &settings)).collect()
});

/// Mean square deviation of one map from another, in lx².
fn mean_square_lx2(map: &MapResult, truth: &MapResult) -> f64 {
    let pairs = map.values.value.iter().zip(&truth.values.value);
    pairs.map(|(one, other)| (one - other).powi(2)).sum::<f64>() / map.values.value.len() as f64
}

/// Results of groups of merged shares.
#[derive(Default)]
struct Groups {
    /// Root mean square of the true error in lx.
    error_lx: f64,
    /// Shares of the bars that hold: all bars, and bars shorter by √2.
    held: [f64; 2],
    /// Mean of the true error in lx.
    drift_lx: f64,
}

/// 64 shares (seed 5) of walks at 64 points against a run (seed 900) with 512 times the work of one share. They are merged in groups of 1,
/// 2, 4 and 8. This gives some 480 degrees of freedom or more, so that the root mean square is known to 3.3 %. At α = 0.002 it falls as
/// 1/√n within 10 %, and 95.4 % of the bars at 512 points or more hold within 2.5 %.
///
/// Planted faults: every other share comes twice, so that the error does not fall as it should; and bars shorter by √2, which a spread over
/// 16 n replicas would give for shares that come twice. Bars from sixteen merged replicas remain right for them.
#[test]
fn errors_fall_as_the_root_of_the_shares_and_bars_hold() {
    let scene = cube(0.5, 2.0);
    let settings = settings(Method::Collision, None);
    let (truth, shares) = (floor(&TRUTH), &*SHARES);
    let of_groups = |count: usize, step: usize| -> Groups {
        let all: Vec<&Kept> = (0..shares.len()).map(|index| &shares[index / step * step]).collect();
        let groups: Vec<&[&Kept]> = all.chunks(count).collect();
        let (mut found, mut square_lx2) = (Groups::default(), 0.0);
        let part = 1.0 / (64 * groups.len()) as f64;
        for group in &groups {
            let solution = merged(&scene, &settings, group).solution;
            let map = floor(&solution);
            square_lx2 += mean_square_lx2(map, truth) / groups.len() as f64;
            for (index, error_lx) in map.values.standard_error.iter().enumerate() {
                let off_lx = map.values.value[index] - truth.values.value[index];
                found.drift_lx += part * off_lx;
                for (held, factor) in found.held.iter_mut().zip([1.0, 0.5f64.sqrt()]) {
                    *held += part * f64::from(u8::from(off_lx.abs() <= factor * T15_QUANTILE_95_4 * error_lx));
                }
            }
        }
        Groups { error_lx: square_lx2.sqrt(), ..found }
    };
    let holds = |held: f64| (held - 0.954).abs() < 0.025;
    let single = of_groups(1, 1);
    assert!(holds(single.held[0]), "bars of single shares hold in {}", single.held[0]);
    for count in [2, 4, 8] {
        let found = of_groups(count, 1);
        let ratio = found.error_lx * (count as f64).sqrt() / single.error_lx;
        assert!((ratio - 1.0).abs() < 0.1, "{count} shares: {ratio} of what is expected");
        assert!(holds(found.held[0]) && !holds(found.held[1]), "{count} shares: bars hold in {:?}", found.held);
        // Mean over all points and groups: within four standard errors, calculated as if all points were independent.
        let drift_lx = found.drift_lx;
        assert!(drift_lx.abs() < 4.0 * single.error_lx / 64.0, "{count} shares: {drift_lx} lx off in the mean");
        println!("{count} shares: error {ratio:.3} of 1/√n, bars hold in {:.3}", found.held[0]);
    }
    let twice = of_groups(8, 2);
    let ratio = twice.error_lx * 8f64.sqrt() / single.error_lx;
    assert!((ratio - 1.0).abs() > 0.1, "a share that comes twice passed: {ratio}");
    assert!(holds(twice.held[0]) && !holds(twice.held[1]), "shares that come twice: bars hold in {:?}", twice.held);
}

/// A merge of 12 shares states how many more a target needs. The first number of shares that meets the target differs from the stated total
/// by a tenth at most.
#[test]
fn the_number_of_shares_that_a_target_takes_is_reported_within_a_tenth() {
    let scene = cube(0.5, 2.0);
    let few = settings(Method::Collision, None);
    let all: Vec<&Kept> = SHARES[..60].iter().collect();
    let of_twelve = merged(&scene, &few, &all[..12]).solution;
    let bound = of_twelve.maps.iter().filter(|map| map.bound).map(|map| map.error.estimated).fold(0.0, f64::max);
    let settings = Settings { target_error: Some(0.56 * bound), ..few };
    let more = merged(&scene, &settings, &all[..12]).more;
    let Some(MoreShares::About(more)) = more else { panic!("{more:?}") };
    assert!(more.low <= more.expected && more.expected <= more.high);
    let needed = 12 + more.expected as usize;
    assert!((24..=54).contains(&needed), "{more:?}");
    let first = (13..=60).find(|count| merged(&scene, &settings, &all[..*count]).more == Some(MoreShares::None));
    let first = first.unwrap_or_else(|| panic!("60 shares do not meet what was to take {needed}"));
    assert!((first as f64 / needed as f64 - 1.0).abs() <= 0.1, "{first} shares, not {needed}");
    println!("told: {needed} shares; the first merge that meets the target has {first}");
    let met = merged(&scene, &settings, &all[..first]).solution;
    assert_eq!((met.target_met, met.stop_reason.name()), (Some(true), "target_met"));
}

/// One share merged alone does not change: values are the same to the last bit, errors to 10⁻⁹, and counts of packets stay counts.
#[test]
fn one_share_alone_is_what_it_was() {
    let scene = cube(0.5, 2.0);
    for method in [Method::Collision, Method::Local, Method::Gather] {
        let settings = settings(method, None);
        let kept = share(&scene, 3, &settings);
        let merged = merged(&scene, &settings, &[&kept]).solution;
        for (one, other) in kept.solution.maps.iter().zip(&merged.maps) {
            assert_eq!(one.values.value, other.values.value, "{method:?} {}", one.name);
            assert_eq!(one.values.halves, other.values.halves, "{method:?} {}", one.name);
            let errors = one.values.standard_error.iter().zip(&other.values.standard_error);
            assert!(errors.clone().all(|(one, other)| (one / other - 1.0).abs() < 1e-9), "{method:?} {}", one.name);
            assert!((one.error.estimated / other.error.estimated - 1.0).abs() < 1e-9, "{method:?} {}", one.name);
            assert_eq!((one.chains, &one.method), (other.chains, &other.method));
        }
        assert_eq!((kept.solution.chains, kept.solution.rays), (merged.chains, merged.rays));
        assert_eq!(kept.solution.flux_balance, merged.flux_balance, "{method:?}");
        assert_ne!(kept.solution.maps[1].values.value, share(&scene, 4, &settings).solution.maps[1].values.value);
    }
}

/// The random numbers of a share depend on its number, not on how many shares there are.
#[test]
fn a_share_does_not_depend_on_their_number() {
    let scene = cube(0.5, 2.0);
    let settings = settings(Method::Collision, None);
    let of = |number: u32, of: u32| solve_share(&scene, &settings, Share { number, of }, &Silent).2;
    let third = of(3, 3);
    assert!(third == of(3, 800) && third != of(4, 800));
}

/// Shares by different methods, as `auto` can choose. Rays are their weights, and the mean is right. Six shares (seed 5) of gathering and
/// six of counts and walks are compared with a run (seed 900) with 512 times the work. No surface of the cube is off by more than 4.5
/// combined standard errors, and the stated error covers the deviation of the points (α = 10⁻⁴, 15 degrees of freedom).
#[test]
fn shares_by_different_methods_join() {
    let scene = cube(0.5, 2.0);
    let by = |method: Method| Settings { chains: Some(8 * CHAINS), ..settings(method, None) };
    let shares: Vec<Kept> = (1..=12)
        .map(|number| share(&scene, number, &by(if number % 2 == 0 { Method::Gather } else { Method::Collision })))
        .collect();
    let solution = merged(&scene, &by(Method::Auto), &shares.iter().collect::<Vec<_>>()).solution;
    assert_eq!(
        solution.maps.iter().map(|map| map.method.as_str()).collect::<Vec<_>>(),
        ["collision, gather", "gather, walk"]
    );
    for (map, truth) in solution.maps.iter().zip(&TRUTH.maps) {
        for (row, truth) in map.tables.iter().zip(&truth.tables) {
            let error_lx = row.average.standard_error.hypot(truth.average.standard_error);
            let off_lx = row.average.value - truth.average.value;
            let share = map.error.bias * row.average.value;
            assert!(off_lx.abs() < 4.5 * error_lx + share, "{}: {off_lx} ± {error_lx} lx", row.name);
        }
    }
    let (map, truth) = (floor(&solution), floor(&TRUTH));
    let off = mean_square_lx2(map, truth).sqrt() / map.tables[0].average.value;
    assert!(off < 1.6 * map.error.estimated.hypot(truth.error.estimated), "{off} {:?}", map.error);
}

/// The parts of the receivers, each computed separately with its share of the chains.
fn parts(scene: &Scene, of: u32, share: Option<Share>, settings: &Settings) -> Vec<Kept> {
    let settings = Settings {
        chains: settings.chains.map(|chains| chains / u64::from(of)),
        maps: MapSelection::Receivers,
        ..settings.clone()
    };
    let part = |number: u32| {
        let part = ReceiversPart { number, of };
        let mut of_part = scene.clone();
        of_part.keep_part(part);
        let (solution, record, sums) = solve_share(&of_part, &settings, Portion { share, part: Some(part) }, &Silent);
        Kept { solution, record, sums }
    };
    (1..=of).map(part).collect()
}

/// 16 runs (seeds 20 to 35) that divide the cube's 64 points into four parts. They are compared with 16 runs of the same work as a whole;
/// the truth is one run (seed 900) with 512 times the work. There are some 1000 values each. Parts have at most 1.3 times the error of a
/// whole run, whose points are neighbours and share more. 95.4 % of the bars hold within 2.5 %; bars shorter by √2 (the planted fault) do
/// not. The mean square error of all points is that of the parts together.
#[test]
fn parts_of_the_receivers_come_to_the_errors_of_one_run() {
    let scene = cube(0.5, 2.0);
    let (mut squares_lx2, mut held) = ([0.0; 2], [0.0; 2]);
    let mut drift = 0.0;
    for seed in 20..36 {
        let settings = Settings { seed, maps: MapSelection::Receivers, ..settings(Method::Collision, None) };
        let parts = parts(&scene, 4, None, &settings);
        let solution = merged(&scene, &settings, &parts.iter().collect::<Vec<_>>()).solution;
        let whole = share(&scene, 1, &settings).solution;
        let (map, of_truth) = (floor(&solution), floor(&TRUTH));
        for (sum, map) in squares_lx2.iter_mut().zip([map, floor(&whole)]) {
            *sum += mean_square_lx2(map, of_truth) / 16.0;
        }
        for (index, error_lx) in map.values.standard_error.iter().enumerate() {
            let off_lx = (map.values.value[index] - of_truth.values.value[index]).abs();
            for (held, factor) in held.iter_mut().zip([1.0, 0.5f64.sqrt()]) {
                *held += f64::from(u8::from(off_lx <= factor * T15_QUANTILE_95_4 * error_lx)) / 1024.0;
            }
        }
        let row = |map: &MapResult| map.tables[0].average;
        drift += (row(map).value - row(of_truth).value) / row(map).standard_error / 16.0;
        // Every point has the value of its part, to the last digits.
        let absolute = |map: &MapResult| (map.error.random * row(map).value).powi(2);
        let of_parts = parts.iter().map(|part| absolute(floor(&part.solution))).sum::<f64>() / 4.0;
        assert!((absolute(map) / of_parts - 1.0).abs() < 1e-9, "{} {of_parts}", absolute(map));
        for (number, part) in parts.iter().enumerate() {
            for (local, illuminance_lx) in floor(&part.solution).values.value.iter().enumerate() {
                let merged_lx = map.values.value[number + 4 * local];
                assert!((merged_lx / illuminance_lx - 1.0).abs() < 1e-12, "part {number}, point {local}");
            }
        }
        assert_eq!(solution.chains, parts.iter().map(|part| part.solution.chains).sum::<u64>());
    }
    let ratio = (squares_lx2[0] / squares_lx2[1]).sqrt();
    // Points of a part are twice as far apart, and their walks have less in common.
    assert!((0.95..1.3).contains(&ratio), "parts have {ratio} of the error of a whole run");
    assert!((held[0] - 0.954).abs() < 0.025 && (held[1] - 0.954).abs() > 0.025, "bars hold in {held:?}");
    // The mean of 16 deviations of Student's t with 15 degrees of freedom has a standard deviation of 0.27 standard errors. The limit is
    // four times that.
    assert!(drift.abs() < 1.08, "averages are off by {drift} standard errors");
    println!("parts: error {ratio:.3} of a whole run's, bars hold in {:.3}", held[0]);
}

/// Each part stops by its own points. The merge judges all of them anew and states their error. Each part has its own cells.
#[test]
fn parts_that_meet_the_target_meet_it_together_and_shares_of_parts_join() {
    let scene = cube(0.5, 2.0);
    let truth = floor(&TRUTH);
    for method in [Method::Collision, Method::Gather, Method::Auto] {
        let target = Some(0.01);
        let to_target = Settings { chains: None, maps: MapSelection::Receivers, ..settings(method, target) };
        let of_four = parts(&scene, 4, None, &to_target);
        assert!(of_four.iter().all(|part| part.solution.target_met == Some(true)), "{method:?}");
        let Merged { solution, more } = merged(&scene, &to_target, &of_four.iter().collect::<Vec<_>>());
        let map = floor(&solution);
        assert!(map.error.estimated < 0.0105, "{method:?} {:?}", map.error);
        assert_eq!(solution.target_met == Some(true), more == Some(MoreShares::None), "{method:?}");
        let worst = of_four.iter().map(|part| floor(&part.solution).error.estimated).fold(0.0, f64::max);
        let least = of_four.iter().map(|part| floor(&part.solution).error.estimated).fold(1.0, f64::min);
        assert!(map.error.estimated < 1.02 * worst && map.error.estimated > 0.8 * least, "{method:?} {:?}", map.error);
        let mean_lx = map.tables[0].average.value;
        let off = mean_square_lx2(map, truth).sqrt() / mean_lx;
        assert!(off < 1.6 * map.error.estimated.hypot(truth.error.estimated), "{method:?} {off} {:?}", map.error);

        // A second share of each part halves the square of the error, approximately.
        let by_chains = settings(method, target);
        let shares: Vec<Kept> =
            (1..=2).flat_map(|number| parts(&scene, 4, Some(Share { number, of: 2 }), &by_chains)).collect();
        let [one, both] = [4, 8].map(|count| {
            let solution = merged(&scene, &by_chains, &shares[..count].iter().collect::<Vec<_>>()).solution;
            floor(&solution).error.random
        });
        assert!((both / one * 2f64.sqrt() - 1.0).abs() < 0.35, "{method:?}: {one} {both}");
    }
}
