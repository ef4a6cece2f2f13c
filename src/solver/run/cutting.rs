//! Elements are cut before a run. Cutting takes long itself, so a first forecast comes before it, and more forecasts during it.

use super::state::Run;
use crate::solver::job::RAYS_PER_SLICE;

/// Share of the forecast run that is cut between two reports, and fewest rays of such a step.
const SHARE_OF_A_STEP: f64 = 0.01;
const LEAST_RAYS: f64 = 20_000.0;

impl Run<'_> {
    /// Cuts the elements of the map that adapts, if there is one, and reports progress meanwhile.
    pub(super) fn cut_elements(&mut self) {
        let Some(index) = self.jobs.iter().position(|job| job.is_to_be_cut()) else {
            return;
        };
        let (gathers, error) = (self.may_gather(), self.error_to_plan_for());
        let job = &mut self.jobs[index];
        if gathers && job.has_light_to_gather(self.context) {
            job.prepare_gathering(self.context, error);
        }
        loop {
            self.record(false);
            self.tell();
            let forecast_rays = self.convergence.last().map_or(0.0, |row| row.forecast_rays.expected);
            let rays = (SHARE_OF_A_STEP * forecast_rays).clamp(LEAST_RAYS, RAYS_PER_SLICE);
            if !self.jobs[index].cut_on(self.context, rays) {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Mutex;

    use super::super::observer::Observer;
    use super::super::progress::Progress;
    use super::*;
    use crate::check::scene_from_json;
    use crate::scene::Scene;
    use crate::solver::context::Context;
    use crate::solver::job::Job;
    use crate::solver::{Method, Settings};
    use crate::transport::World;

    const TARGET: f64 = 0.02;

    /// A room with a table and six lamps, without receivers.
    fn room() -> Scene {
        let lamp = |number: u32| {
            let (x_m, y_m) = (1.0 + 2.0 * f64::from(number % 3), 1.0 + 2.0 * f64::from(number / 3));
            format!(
                r#"{{ "name": "l{number}", "type": "point", "position": [{x_m},{y_m},2], "luminous_flux_lm": 900 }}"#
            )
        };
        let lamps: Vec<String> = (0..6).map(lamp).collect();
        let text = format!(
            r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.5 }} }},
            "geometry": [ {{ "name": "r", "type": "box", "min": [0,0,0], "max": [6,4,2.8], "facing": "inward", "material": "m", "max_element_edge": 0.5 }},
                          {{ "name": "table", "type": "box", "min": [2,1,0.7], "max": [4,2,0.75], "material": "m" }} ],
            "luminaires": [ {} ] }}"#,
            lamps.join(",")
        );
        scene_from_json(&text, None, Path::new(".")).expect("a valid scene")
    }

    /// Records the rays and the forecast of each progress report.
    #[derive(Default)]
    struct Recorder(Mutex<Vec<(u64, Option<f64>)>>);

    impl Observer for Recorder {
        fn progress(&self, progress: &Progress) {
            let forecast = progress.forecast_rays.map(|forecast| forecast.expected);
            self.0.lock().expect("no test panics").push((progress.rays, forecast));
        }
    }

    fn with_run<T>(look: impl FnOnce(&mut Run, &Recorder) -> T) -> T {
        let scene = room();
        let world = World::new(&scene);
        let settings = Settings { target_error: Some(TARGET), ..Settings::default() };
        let context = Context {
            target_error: TARGET,
            adapt_to: Some(TARGET),
            method: Method::Auto,
            ..Context::of_a_test(&scene, &world, 0)
        };
        let recorder = Recorder::default();
        let mut run = Run::new(&context, &settings, Some(TARGET), &recorder, u64::MAX);
        run.jobs = vec![Job::elements(&context, true)];
        look(&mut run, &recorder)
    }

    /// Continues to the target.
    fn rays_of_the_whole(run: &mut Run) -> f64 {
        run.prepare();
        while let Some(index) = run.next_job() {
            run.slice(index);
        }
        run.all_rays() as f64
    }

    /// The first row, with a forecast, comes within 2 % of the rays of the run. While elements are cut, further rows come after at most 5 %
    /// more each. Planted fault: if the elements are cut in one step, most of the cutting passes without a row.
    #[test]
    fn a_forecast_comes_before_elements_are_cut_and_more_on_the_way() {
        with_run(|run, recorder| {
            run.cut_elements();
            let cut = run.all_rays();
            let all = rays_of_the_whole(run);
            let mut rows: Vec<u64> = run.convergence.iter().map(|row| row.rays).filter(|rays| *rays <= cut).collect();
            assert!(rows[0] as f64 <= 0.02 * all, "{} of {all}", rows[0]);
            assert!(run.convergence.iter().all(|row| row.forecast_rays.expected > row.rays as f64));
            rows.push(cut);
            let widest = rows.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or(0);
            assert!(widest as f64 <= 0.05 * all, "{widest} of {all}: {rows:?}");
            let recorder = recorder.0.lock().expect("no test panics");
            assert!(recorder.len() >= rows.len() - 1 && recorder.iter().all(|(_, forecast)| forecast.is_some()));
        });
        with_run(|run, _| {
            run.record(false);
            let first = run.all_rays();
            while run.jobs[0].cut_on(run.context, f64::INFINITY) {}
            let cut = run.all_rays();
            let all = rays_of_the_whole(run);
            assert!((cut - first) as f64 > 0.05 * all, "the planted fault passed: {} of {all}", cut - first);
        });
    }

    /// The elements and what is known of them do not depend on the size of the cutting steps.
    #[test]
    fn elements_are_the_same_in_however_many_steps_they_are_cut() {
        let cut_by = |rays: f64| {
            with_run(|run, _| {
                let mut steps = 0;
                while run.jobs[0].cut_on(run.context, rays) {
                    steps += 1;
                }
                let job = &run.jobs[0];
                let elements: Vec<_> =
                    (0..job.elements.len() as u32).map(|index| job.elements.element(index)).collect();
                (steps, (elements, job.weights.clone(), job.work.pilot_rays))
            })
        };
        let (few, whole) = cut_by(f64::INFINITY);
        let (many, small) = cut_by(3_000.0);
        assert!(many > 3 * few && whole == small, "{many} steps, {few} steps");
    }
}
