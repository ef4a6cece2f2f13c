//! The progress of every map, stored from slice to slice. Of thousands of maps only one changes in a slice, and only that one is evaluated.

use std::cmp::Ordering;
use std::collections::BTreeSet;

/// Up to this number of maps, all are evaluated after every slice to report the state of the run. With more maps, all are evaluated once a
/// run has traced this many rays per map since the last time. Evaluating one map takes about the time of ten rays.
const FEW_MAPS: usize = 64;
const RAYS_OF_A_LOOK: u64 = 100;

/// The state of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MapState {
    /// Whether the target binds the map.
    pub bound: bool,
    /// Whether the map still has work.
    pub open: bool,
    /// Order of turns, lowest first. It is used only for bound maps that are open.
    pub turn: f64,
    /// Rays of the map, without and with those of its pilots.
    pub rays: u64,
    pub all_rays: u64,
    /// Bytes of what it has gathered.
    pub bytes: usize,
}

/// A turn as a sort key.
#[derive(Clone, Copy, Debug, PartialEq)]
struct TurnKey(f64);

impl Eq for TurnKey {}

impl PartialOrd for TurnKey {
    fn partial_cmp(&self, other: &TurnKey) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for TurnKey {
    fn cmp(&self, other: &TurnKey) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// The states of all maps. Nothing is known until all have been recorded.
#[derive(Debug, Default)]
pub(super) struct MapStates {
    states: Vec<MapState>,
    bound: BTreeSet<(TurnKey, u64, usize)>,
    unbound: BTreeSet<(u64, usize)>,
    /// Sums over the unbound maps and over the bound maps.
    rays: [u64; 2],
    all_rays: u64,
    bytes: usize,
    /// Number of evaluations of maps so far.
    evaluations: u64,
}

impl MapStates {
    /// Whether all maps have been recorded.
    pub fn is_known(&self) -> bool {
        !self.states.is_empty()
    }

    /// Forgets all states, because more than one map may have changed.
    pub fn forget(&mut self) {
        *self = MapStates { evaluations: self.evaluations, ..MapStates::default() };
    }

    /// Records all maps anew.
    pub fn note_all(&mut self, states: impl Iterator<Item = MapState>) {
        self.forget();
        for state in states {
            self.evaluations += 1;
            self.states.push(state);
            self.add(self.states.len() - 1, true);
        }
    }

    /// Records a map that has changed, if all maps are known.
    pub fn note(&mut self, index: usize, state: MapState) {
        if !self.is_known() {
            return;
        }
        self.evaluations += 1;
        self.add(index, false);
        self.states[index] = state;
        self.add(index, true);
    }

    /// Adds a map to the sums and queues, or removes it.
    fn add(&mut self, index: usize, counts: bool) {
        let MapState { bound, open, turn, rays, all_rays, bytes } = self.states[index];
        let of_kind = &mut self.rays[usize::from(bound)];
        (*of_kind, self.all_rays, self.bytes) = match counts {
            true => (*of_kind + rays, self.all_rays + all_rays, self.bytes + bytes),
            false => (*of_kind - rays, self.all_rays - all_rays, self.bytes - bytes),
        };
        match (open, bound, counts) {
            (false, ..) => false,
            (_, true, true) => self.bound.insert((TurnKey(turn), rays, index)),
            (_, true, false) => self.bound.remove(&(TurnKey(turn), rays, index)),
            (_, false, true) => self.unbound.insert((rays, index)),
            (_, false, false) => self.unbound.remove(&(rays, index)),
        };
    }

    /// The bound map with work left whose turn is first, and the unbound map with work left that has the fewest rays.
    pub fn next(&self) -> [Option<usize>; 2] {
        [self.bound.first().map(|(_, _, index)| *index), self.unbound.first().map(|(_, index)| *index)]
    }

    /// Rays of all bound, or of all unbound maps, if all are known.
    pub fn rays_of(&self, bound: bool) -> Option<u64> {
        self.is_known().then(|| self.rays[usize::from(bound)])
    }

    /// Rays of all maps and their pilots, if all are known.
    pub fn all_rays(&self) -> Option<u64> {
        self.is_known().then_some(self.all_rays)
    }

    /// Bytes of what all maps have gathered, if all are known.
    pub fn bytes(&self) -> Option<usize> {
        self.is_known().then_some(self.bytes)
    }

    /// Number of evaluations of maps so far.
    #[cfg(test)]
    pub fn evaluations(&self) -> u64 {
        self.evaluations
    }
}

/// Whether all `maps` maps may be evaluated again at `rays` rays, if they were last evaluated at `evaluated_at` rays.
pub(super) fn may_evaluate_all(maps: usize, rays: u64, evaluated_at: Option<u64>) -> bool {
    let next = |evaluated_at: u64| evaluated_at + RAYS_OF_A_LOOK * maps as u64;
    maps <= FEW_MAPS || evaluated_at.is_none_or(|evaluated_at| rays >= next(evaluated_at))
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::atomic::AtomicU64;
    use std::sync::atomic::Ordering::Relaxed;

    use super::super::observer::Observer;
    use super::super::progress::Progress;
    use super::super::state::Run;
    use super::*;
    use crate::check::scene_from_json;
    use crate::sampling::random::{Purpose, Stream};
    use crate::solver::context::Context;
    use crate::solver::{MapSelection, Method, Settings};
    use crate::transport::World;

    /// The stored states equal those from an evaluation of all maps: 2,000 changes of 40 maps (seed 4).
    #[test]
    fn what_is_kept_is_what_an_evaluation_of_all_maps_finds() {
        let mut stream = Stream::new(4, Purpose::Pilot, 0, 0);
        stream.seek(0);
        let mut state = || {
            let mut number = |most: f64| (stream.unit() * most) as u64;
            let (rays, more) = (number(6.0), number(3.0));
            MapState {
                bound: number(4.0) > 0,
                open: number(3.0) > 0,
                turn: number(5.0) as f64 / 5.0,
                rays,
                all_rays: rays + more,
                bytes: more as usize,
            }
        };
        let mut states: Vec<MapState> = (0..40).map(|_| state()).collect();
        let mut map_states = MapStates::default();
        assert_eq!((map_states.next(), map_states.all_rays()), ([None; 2], None));
        map_states.note_all(states.iter().copied());
        for change in 0..2000 {
            let index = change * 7 % 40;
            states[index] = state();
            map_states.note(index, states[index]);
            let open = || states.iter().enumerate().filter(|(_, state)| state.open);
            let bound = open()
                .filter(|(_, state)| state.bound)
                .min_by(|(_, one), (_, other)| one.turn.total_cmp(&other.turn).then(one.rays.cmp(&other.rays)));
            let unbound = open().filter(|(_, state)| !state.bound).min_by_key(|(_, state)| state.rays);
            assert_eq!(map_states.next(), [bound, unbound].map(|one| one.map(|(index, _)| index)));
            let sum = |of: &dyn Fn(&MapState) -> u64| states.iter().map(of).sum::<u64>();
            assert_eq!(map_states.all_rays(), Some(sum(&|state| state.all_rays)));
            assert_eq!(map_states.bytes(), Some(sum(&|state| state.bytes as u64) as usize));
            for bound in [false, true] {
                assert_eq!(
                    map_states.rays_of(bound),
                    Some(sum(&|state| if state.bound == bound { state.rays } else { 0 }))
                );
            }
        }
        assert_eq!(map_states.evaluations(), 2040);
    }

    /// Counts the progress reports.
    #[derive(Default)]
    struct Counting(AtomicU64);

    impl Observer for Counting {
        fn progress(&self, _: &Progress) {
            self.0.fetch_add(1, Relaxed);
        }
    }

    /// Counts slices, rays, evaluations of maps and progress reports of a run of `maps` one-point sets that ends by its target. Planted
    /// fault: if everything is forgotten after every slice, all maps are evaluated for each slice.
    fn counts(maps: usize, forgets: bool) -> [u64; 4] {
        let point = |number: usize| {
            let x_m = 0.2 + 3.6 * number as f64 / maps as f64;
            format!(
                r#"{{ "name": "p{number}", "type": "grid", "origin": [{x_m},1,1], "u": [0.01,0,0], "v": [0,0.01,0], "columns": 1, "rows": 1 }}"#
            )
        };
        let points: Vec<String> = (0..maps).map(point).collect();
        let text = format!(
            r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.5 }} }},
            "geometry": [ {{ "name": "r", "type": "box", "min": [0,0,0], "max": [4,3,2], "facing": "inward", "material": "m" }} ],
            "luminaires": [ {{ "name": "a", "type": "point", "position": [1,1,1.5], "luminous_flux_lm": 100 }} ],
            "receivers": [ {} ] }}"#,
            points.join(",")
        );
        let scene = scene_from_json(&text, None, Path::new(".")).expect("a valid scene");
        let world = World::new(&scene);
        let settings = Settings {
            method: Method::Collision,
            target_error: Some(0.1),
            maps: MapSelection::Receivers,
            ..Settings::default()
        };
        let context = Context { target_error: 0.1, ..Context::of_a_test(&scene, &world, 0) };
        let observer = Counting::default();
        let mut run = Run::new(&context, &settings, Some(0.1), &observer, 0);
        run.begin();
        let mut slices = 0;
        while let Some(index) = run.next_job() {
            run.slice(index);
            run.record(false);
            run.tell();
            slices += 1;
            if forgets {
                run.map_states.forget();
            }
        }
        [slices, run.jobs.iter().map(|job| job.work.rays).sum(), run.map_states.evaluations(), observer.0.into_inner()]
    }

    /// A slice evaluates its own map twice. All maps are evaluated only once per `RAYS_OF_A_LOOK` rays per map.
    #[test]
    fn a_slice_of_one_map_evaluates_no_others() {
        let maps = 200;
        let [slices, rays, evaluations, rows] = counts(maps, false);
        let of_all = rays / (RAYS_OF_A_LOOK * maps as u64) + 2;
        assert!(
            slices > 100 && evaluations <= 2 * slices + of_all * maps as u64 && rows <= of_all,
            "{slices} {rays} {evaluations} {rows}"
        );
        let [slices, rays, evaluations, _] = counts(maps, true);
        let of_all = rays / (RAYS_OF_A_LOOK * maps as u64) + 2;
        assert!(
            evaluations > 2 * slices + of_all * maps as u64,
            "the planted fault passed: {slices} {rays} {evaluations}"
        );
        // With few maps all are evaluated every time, and once when the run begins.
        let [slices, _, _, rows] = counts(3, false);
        assert_eq!(slices + 1, rows);
    }

    #[test]
    fn few_maps_are_all_evaluated_every_time_and_many_for_some_work() {
        assert!(may_evaluate_all(64, 5, Some(5)) && may_evaluate_all(10_000, 5, None));
        assert!(!may_evaluate_all(10_000, 999_999, Some(0)) && may_evaluate_all(10_000, 1_000_000, Some(0)));
    }
}
