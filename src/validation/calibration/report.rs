//! Reports of a calibration: table, HTML page, Markdown, CSV.

use super::campaign::{AT_NOMINAL, Campaign, CampaignSettings};
use super::pictures::{coverage_picture, error_picture, forecast_picture};
use super::{NOMINAL, fewest_met, most_cost};
use crate::validation::report::{Table, VERDICT};
use crate::validation::report_html::{opening, table as html_table};
use crate::validation::report_md::table as md_table;
use crate::validation::words::{count, date, duration, escaped, percent, significant};

const HOW_TO_READ: [&str; 5] = [
    "Every row summarises many runs of one map, each with its own seed, to the same target. The truth is exact, so each run's true error is known; a user never knows it.",
    "Covered is the share of the error bars (Student's t with 15 degrees of freedom, nominally 95.4 %) that contain the truth. Met is the number of runs that said “target met” and truly are at or below the target; at least 95 % should be, and the bound allows for chance.",
    "Bias is the mean error of a value over all runs, compared with the error that the value states. Given are the share of the values for which it is at most a third (with 300 seeds or more, 99 % must be), and the largest bias, less four of its own standard errors, divided by the stated error (at most a third). The mean bias is that of the whole map, in its own standard errors.",
    "Cost is the mean number of rays divided by that of an oracle that knows the expected error and stops where it equals the target. It may be 1.3 where the error has 200 degrees of freedom or more, otherwise 1.2·χ²(k, 95 %)/k.",
    "Forecasts predict the rays at the end of the run. A forecast is compared with the actual number, by the share of the run that was done when it was made. Refused counts the runs in which a statistical check held up a run that the stop rule would have ended.",
];

/// Table with one row per campaign.
pub fn calibration_table(campaigns: &[Campaign]) -> Table {
    let rows = campaigns.iter().map(|campaign| {
        let (met, said) = campaign.met();
        let (_, refused) = campaign.refusals();
        let forecast =
            |low, high| campaign.forecast_error(low, high).map_or("–".to_owned(), |(median, _)| percent(median));
        vec![
            format!("{}: {}", campaign.case, campaign.comparison),
            format!("{} ({})", campaign.method, campaign.estimators()),
            campaign.values.to_string(),
            significant(campaign.degrees_of_freedom(), 2),
            format!("{} ± {}", percent(campaign.coverage(AT_NOMINAL)), percent(campaign.coverage_error())),
            format!("{} ({})", percent(campaign.biases.share_within()), significant(campaign.biases.worst(), 2)),
            significant(campaign.bias_z(), 2),
            format!("{met}/{said} (≥ {})", fewest_met(said)),
            significant(campaign.true_over_target(), 3),
            format!(
                "{} (≤ {})",
                significant(campaign.cost(), 3),
                significant(most_cost(campaign.degrees_of_freedom()), 3)
            ),
            forecast(0.0, 0.05),
            forecast(0.2, 0.6),
            format!("{refused}/{}", campaign.runs.len()),
            if campaign.passes() { "pass".to_owned() } else { "FAIL".to_owned() },
        ]
    });
    Table {
        header: vec![
            "map",
            "method",
            "values",
            "k",
            "covered",
            "bias ≤ ⅓ (worst)",
            "mean bias in σ",
            "met",
            "true error / target",
            "cost / oracle",
            "forecast off, first 5 %",
            "forecast off, 20 to 60 %",
            "refused",
            VERDICT,
        ],
        text_columns: vec![0, 1],
        rows: rows.collect(),
    }
}

fn circumstances(campaigns: &[Campaign], settings: &CampaignSettings, unix_s: u64) -> String {
    let runs = || campaigns.iter().flat_map(|campaign| &campaign.runs);
    format!(
        "luxmc {}, {}: {} seeds to {}; {} runs, {} rays, {} of computing",
        env!("CARGO_PKG_VERSION"),
        date(unix_s),
        settings.seeds,
        percent(settings.target_error),
        runs().count(),
        count(runs().map(|run| run.rays as f64).sum()),
        duration(runs().map(|run| run.seconds).sum())
    )
}

/// Failed conditions and excessive costs, in words.
fn failures(campaigns: &[Campaign]) -> Vec<String> {
    let mut found = Vec::new();
    for campaign in campaigns {
        let name = format!("{}: {}, {}", campaign.case, campaign.comparison, campaign.method);
        let (met, said) = campaign.met();
        if !campaign.covers() {
            let coverage = percent(campaign.coverage(AT_NOMINAL));
            found.push(format!("{name}: error bars contain the truth in {coverage} instead of {}", percent(NOMINAL)));
        }
        if !campaign.biases.is_small() {
            let (share, worst) = (percent(campaign.biases.share_within()), significant(campaign.biases.worst(), 2));
            found.push(format!(
                "{name}: the mean error is at most a third of the stated one at {share} of the values; the largest, beyond chance, is {worst} of it"
            ));
        }
        if said < campaign.runs.len() {
            found.push(format!("{name}: {} runs ended without meeting their target", campaign.runs.len() - said));
        }
        if met < fewest_met(said) {
            found.push(format!("{name}: {met} of {said} runs truly met their target, fewer than {}", fewest_met(said)));
        }
        if !campaign.is_thrifty() {
            let most = significant(most_cost(campaign.degrees_of_freedom()), 3);
            let cost = significant(campaign.cost(), 3);
            found.push(format!("{name}: {cost} times an oracle's rays, more than {most} (reported, not a failure)"));
        }
    }
    found
}

/// The report as an HTML page.
pub fn calibration_html(campaigns: &[Campaign], settings: &CampaignSettings, unix_s: u64) -> String {
    let mut page = opening("luxmc calibration");
    page.push_str("<h1>Calibration of error bars, stop rule and forecast</h1>\n");
    page.push_str(&format!("<p class=\"soft\">{}</p>\n", escaped(&circumstances(campaigns, settings, unix_s))));
    page.push_str(&html_table(&calibration_table(campaigns), false));
    page.push_str("<ul>\n");
    for failure in failures(campaigns) {
        page.push_str(&format!("<li>{}</li>\n", escaped(&failure)));
    }
    page.push_str("</ul>\n<h3>How to read this report</h3>\n");
    for paragraph in HOW_TO_READ {
        page.push_str(&format!("<p>{}</p>\n", escaped(paragraph)));
    }
    let pictures = [
        (
            coverage_picture(campaigns),
            "Share of the error bars of a nominal level that contain the truth, minus that level, in percentage points. If the error bars are right, the points lie on the line.",
        ),
        (
            error_picture(campaigns),
            "True error of every run at the moment it said “target met”, divided by its target: one dot per run. At most one in twenty should lie to the right of the line.",
        ),
        (
            forecast_picture(campaigns),
            "Forecast of the rays at the end divided by their actual number, against the share of the run that was done.",
        ),
    ];
    for (picture, caption) in pictures {
        page.push_str(&format!("<figure>\n{picture}\n<figcaption>{}</figcaption>\n</figure>\n", escaped(caption)));
    }
    page.push_str("</body>\n</html>\n");
    page
}

/// The pictures by file name, for pages that store them separately.
pub fn calibration_pictures(campaigns: &[Campaign]) -> Vec<(&'static str, String)> {
    vec![
        ("calibration-coverage.svg", coverage_picture(campaigns)),
        ("calibration-errors.svg", error_picture(campaigns)),
        ("calibration-forecasts.svg", forecast_picture(campaigns)),
    ]
}

/// The report as Markdown.
pub fn calibration_md(campaigns: &[Campaign], settings: &CampaignSettings, unix_s: u64) -> String {
    let mut text = format!("# Calibration\n\n{}\n\n", circumstances(campaigns, settings, unix_s));
    text.push_str(&md_table(&calibration_table(campaigns)));
    for failure in failures(campaigns) {
        text.push_str(&format!("\n- {failure}"));
    }
    text.push('\n');
    for paragraph in HOW_TO_READ {
        text.push_str(&format!("\n{paragraph}\n"));
    }
    text
}

/// CSV with one row per run.
pub fn calibration_csv(campaigns: &[Campaign]) -> String {
    let mut text = String::from(
        "case,comparison,method,estimator,seed,target_error,target_met,true_error,stated_error,degrees_of_freedom,values,covered,bias,rays,chains,refusals,compute_s\n",
    );
    for campaign in campaigns {
        for run in &campaign.runs {
            text.push_str(&format!(
                "{},\"{}\",{},{},{},{},{},{:.9e},{:.9e},{:.9e},{},{},{:.9e},{},{},{},{:.9e}\n",
                campaign.case,
                campaign.comparison,
                campaign.method,
                run.estimator,
                run.seed,
                campaign.target_error,
                run.target_met,
                run.true_error,
                run.stated_error,
                run.degrees_of_freedom,
                run.noisy,
                run.within[AT_NOMINAL],
                run.bias,
                run.rays,
                run.chains,
                run.refusals,
                run.seconds
            ));
        }
    }
    text
}
