//! Sentences and tables of both reports, before they become HTML or Markdown.

use super::outcome::{CaseOutcome, ComparisonOutcome};
use super::statistics::{ComparedEntry, Statistics};
use super::words::{count, date, duration, grouped, percent, sigmas, signed_percent, whole_percent};

/// Results of a whole validation.
#[derive(Clone, Debug)]
pub struct Validation {
    /// Outcomes in order.
    pub cases: Vec<CaseOutcome>,
    /// Known groups that were requested and have no case.
    pub empty_groups: Vec<String>,
    /// Start time in seconds since 1970.
    pub unix_s: u64,
    /// Duration in seconds.
    pub wall_s: f64,
    /// Number of worker threads.
    pub threads: usize,
}

impl Validation {
    /// Names of the cases that fail.
    pub fn failures(&self) -> Vec<&str> {
        self.cases.iter().filter(|case| !case.passes()).map(|case| case.name.as_str()).collect()
    }

    /// The verdict in one sentence.
    pub fn verdict(&self) -> String {
        let failures = self.failures();
        match (failures.len(), self.cases.len()) {
            (0, 0) => "No case was run.".to_owned(),
            (0, 1) => "The case passes.".to_owned(),
            (0, all) => format!("All {all} cases pass."),
            (failed, all) => format!("{failed} of {all} cases fail: {}.", failures.join(", ")),
        }
    }

    /// Overview table with one row per case: its deviation and its verdict.
    pub fn overview(&self) -> Table {
        overview(self)
    }

    /// Version, date, machine and cost in one line.
    pub fn circumstances(&self) -> String {
        let rays: u64 = self.cases.iter().map(CaseOutcome::rays).sum();
        format!(
            "luxmc {}, {}, {} {}; {} of computing, {} rays",
            env!("CARGO_PKG_VERSION"),
            date(self.unix_s),
            self.threads,
            if self.threads == 1 { "thread" } else { "threads" },
            duration(self.cases.iter().map(CaseOutcome::seconds).sum()),
            count(rays as f64)
        )
    }
}

/// Instructions to read the report, for readers who do not know luxmc.
pub const HOW_TO_READ: [&str; 4] = [
    "Each case is a room whose illuminance is known exactly, from a formula or from a separate program. luxmc computes it like any other room, by random light paths, and states a standard error σ for every number. The report shows both beside the exact value.",
    "Deviation is the computed value minus the exact one, in per cent of the exact value. RMS deviation of a map or a set of points is in per cent of its mean. A deviation in σ is in units of the standard error that luxmc itself stated: if the error bars are right, about two thirds of the deviations lie within 1 σ and 94 % within 2 σ (Student's t with 15 degrees of freedom).",
    "Bias is the mean deviation with its sign and standard error: random errors average out in it, a systematic error does not.",
    "Every deviation is split into its known sources. Random is the part that chance explains by the stated standard errors; it decreases with more rays. Discretisation is the difference between a mesh of flat triangles and the ideal shape, or between an element's mean and the value at its centre. Model is the difference between a finite scene and an infinite one.",
];

/// A table: header, which columns are text, rows.
#[derive(Clone, Debug)]
pub struct Table {
    /// Headings of the columns.
    pub header: Vec<&'static str>,
    /// Indices of the left-aligned columns.
    pub text_columns: Vec<usize>,
    /// Cells.
    pub rows: Vec<Vec<String>>,
}

/// Heading of the column with the verdicts. Reports colour its cells.
pub const VERDICT: &str = "verdict";

fn verdict(passes: bool) -> String {
    if passes { "pass".to_owned() } else { "FAIL".to_owned() }
}

/// Overview table with one row per case.
fn overview(validation: &Validation) -> Table {
    let rows = validation.cases.iter().map(|case| {
        let largest = |of: fn(&Statistics) -> f64| {
            case.comparisons.iter().map(|comparison| of(&comparison.statistics)).fold(0.0, f64::max)
        };
        let values: usize = case.comparisons.iter().map(|comparison| comparison.statistics.count).sum();
        let worst_z = case
            .comparisons
            .iter()
            .filter_map(|comparison| comparison.statistics.worst_z.as_ref())
            .map(|worst| worst.value)
            .reduce(f64::max);
        vec![
            case.name.clone(),
            case.title.clone(),
            grouped(values as u64),
            percent(largest(|statistics| statistics.rms)),
            worst_z.map_or("exact".to_owned(), sigmas),
            duration(case.seconds()),
            verdict(case.passes()),
        ]
    });
    Table {
        header: vec!["case", "what", "values", "largest RMS deviation", "worst in σ", "time", VERDICT],
        text_columns: vec![0, 1],
        rows: rows.collect(),
    }
}

/// Deviations of every comparison of a case.
pub fn deviations(case: &CaseOutcome) -> Table {
    let rows = case.comparisons.iter().map(|comparison| {
        let statistics = &comparison.statistics;
        let [one, two] =
            statistics.within.map_or(["–".to_owned(), "–".to_owned()], |within| within.map(whole_percent));
        vec![
            comparison.heading(),
            grouped(statistics.count as u64),
            percent(statistics.worst.value),
            percent(statistics.rms),
            statistics.worst_z.as_ref().map_or("exact".to_owned(), |worst| sigmas(worst.value)),
            statistics.rms_z.map_or("–".to_owned(), sigmas),
            one,
            two,
            bias(statistics),
            verdict(comparison.passes()),
        ]
    });
    Table {
        header: vec![
            "comparison",
            "values",
            "worst",
            "RMS",
            "worst in σ",
            "RMS in σ",
            "within 1 σ",
            "within 2 σ",
            "bias",
            VERDICT,
        ],
        text_columns: vec![0],
        rows: rows.collect(),
    }
}

fn bias(statistics: &Statistics) -> String {
    if statistics.noisy == 0 {
        return signed_percent(statistics.bias);
    }
    format!("{} ± {}", signed_percent(statistics.bias), percent(statistics.bias_error))
}

/// Table of the sources of every comparison's deviation.
pub fn sources(case: &CaseOutcome) -> Table {
    let rows = case.comparisons.iter().map(|comparison| {
        let statistics = &comparison.statistics;
        vec![
            comparison.heading(),
            percent(statistics.rms),
            percent(statistics.random),
            percent(statistics.discretisation),
            percent(statistics.truncation),
            percent(statistics.truth),
        ]
    });
    Table {
        header: vec!["comparison", "RMS deviation", "random", "discretisation", "model", "error of the exact value"],
        text_columns: vec![0],
        rows: rows.collect(),
    }
}

/// Table of every run's cost.
pub fn costs(case: &CaseOutcome) -> Table {
    let rows = case.runs.iter().map(|run| {
        let target = run.target_error.map_or("–".to_owned(), percent);
        vec![
            run.name.clone(),
            run.methods.join(", "),
            run.seed.to_string(),
            target,
            percent(run.stated_error),
            count(run.chains as f64),
            count(run.rays as f64),
            duration(run.seconds),
        ]
    });
    Table {
        header: vec!["run", "estimator", "seed", "target error", "stated error", "chains", "rays", "time"],
        text_columns: vec![0, 1],
        rows: rows.collect(),
    }
}

/// Table of measured and exact numbers, if there are few enough to read.
pub fn numbers(comparison: &ComparisonOutcome) -> Option<Table> {
    const MOST_ROWS: usize = 70;
    let entries = &comparison.set.entries;
    if entries.len() > MOST_ROWS {
        return None;
    }
    if comparison.comparison.what == super::comparison::What::Ugr {
        return Some(ratings(entries));
    }
    let beside = comparison.comparison.beside.is_some();
    let rows = entries.iter().map(|entry| {
        let size_lx = if entry.exact.value > 0.0 { entry.exact.value } else { f64::NAN };
        let relative = |lx: f64| if size_lx.is_nan() { "–".to_owned() } else { signed_percent(lx / size_lx) };
        let mut row = vec![
            entry.label.clone(),
            six_digits(entry.exact.value),
            six_digits(entry.measured),
            if entry.is_exact() { "exact".to_owned() } else { relative(entry.standard_error).replace('+', "") },
            relative(entry.deviation()),
            entry.z().map_or("–".to_owned(), |z| format!("{}{}", if z > 0.0 { "+" } else { "" }, sigmas(z))),
        ];
        if beside {
            let published = entry.beside;
            row.push(published.map_or("–".to_owned(), |lx| format!("{lx}")));
            row.push(published.map_or("–".to_owned(), |lx| relative(lx - entry.exact.value)));
        }
        row
    });
    let mut header = vec!["where", "exact, lx", "luxmc, lx", "standard error", "deviation", "in σ"];
    if beside {
        header.extend(["published, lx", "its deviation"]);
    }
    Some(Table { header, text_columns: vec![0], rows: rows.collect() })
}

/// Table of measured and exact ratings, with their differences instead of ratios.
fn ratings(entries: &[ComparedEntry]) -> Table {
    let signed = |difference: f64| format!("{difference:+.2}").replace('-', "−");
    let rows = entries.iter().map(|entry| {
        vec![
            entry.label.clone(),
            format!("{:.2}", entry.exact.value),
            format!("{:.2}", entry.measured),
            format!("{:.2}", entry.standard_error),
            signed(entry.deviation()),
            entry.z().map_or("–".to_owned(), |z| format!("{}{}", if z > 0.0 { "+" } else { "" }, sigmas(z))),
        ]
    });
    let header = vec!["where", "exact UGR", "luxmc", "standard error", "difference", "in σ"];
    Table { header, text_columns: vec![0], rows: rows.collect() }
}

fn six_digits(lx: f64) -> String {
    if lx != 0.0 && lx.abs() < 1e-3 {
        return super::words::scientific(lx);
    }
    super::words::significant(lx, 6)
}

/// Sentences under a comparison's heading: what is compared, and the truth.
pub fn subject(comparison: &ComparisonOutcome) -> String {
    let what = &comparison.comparison;
    let of = match what.what {
        super::comparison::What::Average => "averages",
        super::comparison::What::Points => "illuminances at points",
        super::comparison::What::Elements => "element means",
        super::comparison::What::Ugr => {
            return format!("Compared: glare ratings. Exact values: {}.", comparison.set.truth_in_words);
        }
    };
    format!("Compared: {} {of}. Exact values: {}.", what.light.name(), comparison.set.truth_in_words)
}
