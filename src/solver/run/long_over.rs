//! What is given up when a time limit has long passed.

use std::time::{Duration, Instant};

use super::Observer;
use crate::chain::Stage;
use crate::solver::Settings;

/// A map that shows nothing yet is worked on until so many times the limit and so many seconds more have passed.
pub const LONG_OVER: f64 = 1.1;
pub const PATIENCE_S: f64 = 0.5;

/// Whether a time limit has passed so long ago that what shows nothing yet is left out.
pub fn is_long_over(settings: &Settings, observer: &dyn Observer) -> bool {
    settings.time_limit_s.is_some_and(|limit_s| observer.wall_s() > LONG_OVER * limit_s + PATIENCE_S)
}

/// Lets long paths be given up once that is so: a single one may take longer than all that a limit leaves. A clock that stands ends nothing.
pub fn give_up_long_paths(stage: &Stage, settings: &Settings, wall_s: f64) {
    let Some(limit_s) = settings.time_limit_s.filter(|_| wall_s > 0.0) else {
        return;
    };
    let left_s = (LONG_OVER * limit_s + PATIENCE_S - wall_s).max(0.0);
    let left = Duration::try_from_secs_f64(left_s).ok();
    if let Some(time) = left.and_then(|left| Instant::now().checked_add(left)) {
        stage.patience.end_at(time);
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

    use super::*;
    use crate::check::scene_from_json;
    use crate::solver::{MapSelection, Method, Progress, solve};

    /// Every ray takes a tenth of a millisecond by this clock, which is set after each slice.
    #[derive(Default)]
    struct SlowRays(AtomicU64);

    impl Observer for SlowRays {
        fn wall_s(&self) -> f64 {
            1e-4 * self.0.load(Relaxed) as f64
        }

        fn progress(&self, progress: &Progress) {
            self.0.store(progress.rays, Relaxed);
        }
    }

    /// Slices of a fixed number of chains grow whatever they take. One that would end long after the limit is not begun: of 4,000, 8,000,
    /// 16,000 and 32,000 rays, the pilots' apart, the fourth would end at 6 s of 3, and 3.8 are allowed.
    #[test]
    fn a_slice_that_would_end_long_after_the_limit_is_not_begun() {
        let text = r#"{ "version": 1, "materials": { "m": { "type": "diffuse", "reflectance": 0.5 } },
            "geometry": [ { "name": "r", "type": "box", "min": [0,0,0], "max": [4,3,2], "facing": "inward", "material": "m" } ],
            "luminaires": [ { "name": "a", "type": "point", "position": [1,1,1], "luminous_flux_lm": 100 } ],
            "receivers": [ { "name": "p", "type": "grid", "origin": [1,1,1], "u": [2,0,0], "v": [0,1,0], "columns": 2, "rows": 2 } ] }"#;
        let scene = scene_from_json(text, None, Path::new(".")).expect("a valid scene");
        let settings = |time_limit_s: f64| Settings {
            method: Method::Collision,
            chains: Some(1_000_000),
            time_limit_s: Some(time_limit_s),
            maps: MapSelection::Receivers,
            ..Settings::default()
        };
        for (limit_s, least) in [(3.0, 15_000), (6.0, 40_000)] {
            let solution = solve(&scene, &settings(limit_s), &SlowRays::default());
            let most = (LONG_OVER * limit_s + PATIENCE_S) / 1e-4;
            assert!(solution.rays > least && (solution.rays as f64) < most, "{} of {most}", solution.rays);
        }
    }
}
