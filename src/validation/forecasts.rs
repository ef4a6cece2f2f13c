//! Compares the forecasts that runs made with the actual result.

use crate::solver::ConvergenceRow;

/// A forecast during a run, compared with the actual result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JudgedForecast {
    /// Share of the run's rays traced at the time of the forecast.
    pub share: f64,
    /// Forecast of the run's rays over their actual number.
    pub ratio: f64,
    /// Whether the forecast interval contains the actual number of rays.
    pub holds: bool,
    /// Forecast of the run's seconds over the actual seconds.
    pub seconds_ratio: f64,
    /// Whether the forecast interval contains the actual seconds.
    pub holds_seconds: bool,
}

/// Compares the forecasts of a finished run, in order.
pub fn judged_forecasts(rows: &[ConvergenceRow]) -> Vec<JudgedForecast> {
    let Some((end, before)) = rows.split_last() else {
        return Vec::new();
    };
    let (all, wall_s) = (end.rays.max(1) as f64, end.wall_s.max(f64::MIN_POSITIVE));
    let judged = |row: &ConvergenceRow| JudgedForecast {
        share: row.rays as f64 / all,
        ratio: row.forecast_rays.expected / all,
        holds: row.forecast_rays.holds(all),
        seconds_ratio: row.forecast_wall_s.expected / wall_s,
        holds_seconds: row.forecast_wall_s.holds(wall_s),
    };
    before.iter().filter(|row| row.rays > 0).map(judged).collect()
}

/// Statistics over the forecasts of many runs at a given share of each run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ForecastSums {
    /// Number of runs.
    pub runs: usize,
    /// Number of runs that had made a forecast by then.
    pub forecast_runs: usize,
    /// Relative error of the forecast rays, median.
    pub off: f64,
    /// Share of intervals that contained the actual rays.
    pub held: f64,
    /// Relative error of the forecast seconds, median.
    pub seconds_off: f64,
    /// Share of intervals that contained the actual seconds.
    pub seconds_held: f64,
}

impl ForecastSums {
    /// Computes the statistics of runs, each with its forecasts in order. The latest forecast of a run up to `share` counts.
    pub fn at<'a>(share: f64, runs: impl Iterator<Item = &'a [JudgedForecast]>) -> ForecastSums {
        let latest: Vec<Option<&JudgedForecast>> =
            runs.map(|forecasts| forecasts.iter().rfind(|forecast| forecast.share <= share)).collect();
        let forecasts = || latest.iter().flatten();
        let off =
            |of: fn(&JudgedForecast) -> f64| median(forecasts().map(|forecast| (of(forecast) - 1.0).abs()).collect());
        let held = |of: fn(&JudgedForecast) -> bool| {
            forecasts().filter(|forecast| of(forecast)).count() as f64 / forecasts().count().max(1) as f64
        };
        ForecastSums {
            runs: latest.len(),
            forecast_runs: forecasts().count(),
            off: off(|forecast| forecast.ratio),
            held: held(|forecast| forecast.holds),
            seconds_off: off(|forecast| forecast.seconds_ratio),
            seconds_held: held(|forecast| forecast.holds_seconds),
        }
    }
}

/// The median of the numbers; 0 if there are none.
pub fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Forecast;

    /// A run of 100 rays has forecasts at 1 and at 10 rays with errors of a half and a tenth. At 5 % of the run the first counts,
    /// at 20 % the second. The end of the run is not a forecast.
    #[test]
    fn the_latest_forecast_by_then_is_judged() {
        let row = |rays: u64, rays_to_come: Forecast| ConvergenceRow {
            rays,
            wall_s: 0.1 * rays as f64,
            forecast_rays: rays_to_come,
            forecast_wall_s: Forecast::known(10.0),
            ..ConvergenceRow::default()
        };
        let rows = [
            row(1, Forecast { expected: 50.0, low: 40.0, high: 60.0 }),
            row(10, Forecast { expected: 110.0, low: 90.0, high: 130.0 }),
            row(100, Forecast::known(100.0)),
        ];
        let forecasts = judged_forecasts(&rows);
        assert_eq!(forecasts.len(), 2);
        let at = |share: f64| ForecastSums::at(share, [forecasts.as_slice()].into_iter());
        assert_eq!((at(0.05).forecast_runs, at(0.05).off, at(0.05).held), (1, 0.5, 0.0));
        let late = at(0.2);
        assert!((late.off - 0.1).abs() < 1e-12 && late.held == 1.0 && late.seconds_off == 0.0, "{late:?}");
        assert_eq!((at(0.005).runs, at(0.005).forecast_runs), (1, 0));
    }
}
