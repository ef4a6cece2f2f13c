//! Reports of a proof: tables, HTML page, Markdown, CSV.

use super::acceptance::{failures, remarks};
use super::campaign::{Proof, ProofSettings, RoomProof};
use super::judgement::LEVEL;
use super::pictures::{cost_picture, error_picture, forecast_picture};
use super::summary::{Group, Sums, mean_and_worst};
use crate::control::FORECAST_SHARES;
use crate::validation::forecasts::ForecastSums;
use crate::validation::report::Table;
use crate::validation::report_html::{opening, table as html_table};
use crate::validation::report_md::table as md_table;
use crate::validation::words::{count, date, escaped, percent, significant};

const HOW_TO_READ: [&str; 6] = [
    "Every room is generated from a kind and a seed; luxmc new room writes its files. Methods may be tuned on rooms of even seeds. Rooms of odd seeds are used only to judge.",
    "The truth of a room is a long run of walks (method collision). Its own error is known from its replicas and is subtracted: the squared true error is the mean squared deviation minus the squared error of the reference. Where the reference is not accurate enough for a target, the report says so and judges nothing.",
    "Met counts the maps that said “target met” and truly are at or below their target; 95 % should be. Worst is the largest true error divided by the target. Held is the share of the single error bars (Student's t, nominally 95 %) that contain the truth.",
    "Seconds are processor seconds; they include building the tree of rays, but not reading files. The seconds of walks are those of the reference run, scaled to the target by seconds ∝ 1/error², set by set. Those of the rival are of one run, scaled to the target in the same way by its true error, which it does not know. Auto stops by itself, and its true error is mostly below the target.",
    "Forecasts are those of runs that took a second or more and met their target. For each share of its rays, the latest forecast that a run had made by then is compared with the run's actual total; held is the share of the 90 % intervals that contain it.",
    "A ratio is seconds of walks, or of the rival, divided by those of auto. Worst is the smallest: the room in which auto gains least. Rooms in which a run missed its target have no ratio.",
];

fn dash(number: Option<f64>) -> String {
    number.map_or("–".to_owned(), |number| significant(number, 3))
}

fn shares(sums: &Sums) -> [String; 4] {
    [
        format!("{}/{}", sums.truly_met, sums.said_met),
        significant(sums.worst, 3),
        significant(sums.true_over_stated(), 3),
        if sums.bars > 0 { percent(sums.coverage()) } else { "–".to_owned() },
    ]
}

/// Table with one row per target and group of rooms.
pub fn proof_table(proof: &Proof, settings: &ProofSettings) -> Table {
    let mut rows = Vec::new();
    for (target, target_error) in settings.targets.iter().enumerate() {
        for group in [Group::All, Group::Tuned, Group::Untuned] {
            let rooms: Vec<&RoomProof> = proof.rooms_of(group).collect();
            if rooms.is_empty() || (group != Group::All && rooms.len() == proof.rooms.len()) {
                continue;
            }
            let sums = proof.sums(group, Some(*target_error));
            let [met, worst, over_stated, held] = shares(&sums);
            let seconds = mean_and_worst(rooms.iter().map(|room| room.cost(*target_error).cpu_s));
            let ratios =
                |of: usize| mean_and_worst(rooms.iter().filter_map(|room| room.ratios(target, *target_error)[of]));
            let (walks, rival) = (ratios(0), ratios(1));
            rows.push(vec![
                percent(*target_error),
                group.name().to_owned(),
                rooms.len().to_string(),
                met,
                worst,
                over_stated,
                held,
                dash(seconds.map(|(mean, _)| mean)),
                dash(walks.map(|(mean, _)| mean)),
                dash(walks.map(|(_, worst)| worst)),
                dash(rival.map(|(mean, _)| mean)),
                dash(rival.map(|(_, worst)| worst)),
            ]);
        }
    }
    Table {
        header: vec![
            "target",
            "rooms",
            "number",
            "met",
            "worst true/target",
            "true/stated",
            "held",
            "auto, s (geometric mean)",
            "walks/auto",
            "worst",
            "rival/auto",
            "worst",
        ],
        text_columns: vec![1],
        rows,
    }
}

fn room_table(proof: &Proof, settings: &ProofSettings) -> Table {
    let mut rows = Vec::new();
    for room in &proof.rooms {
        for (target, target_error) in settings.targets.iter().enumerate() {
            let sums = room.sums(Some(*target_error));
            let [met, worst, _, held] = shares(&sums);
            let auto = room.cost(*target_error);
            let [walks, rival] = room.ratios(target, *target_error);
            rows.push(vec![
                room.name(),
                room.triangles.to_string(),
                room.luminaires.to_string(),
                percent(*target_error),
                percent(sums.stated_over_target() * target_error),
                percent(sums.true_over_target() * target_error),
                significant(sums.true_over_stated(), 3),
                held,
                met,
                worst,
                significant(auto.cpu_s, 3),
                count(auto.rays),
                significant(room.walks[target].cpu_s, 3),
                room.rival.as_ref().map_or("–".to_owned(), |costs| significant(costs[target].cpu_s, 3)),
                dash(walks),
                dash(rival),
            ]);
        }
    }
    Table {
        header: vec![
            "room",
            "triangles",
            "luminaires",
            "target",
            "stated",
            "true",
            "true/stated",
            "held",
            "met",
            "worst true/target",
            "auto, s",
            "auto, rays",
            "walks, s",
            "rival, s",
            "walks/auto",
            "rival/auto",
        ],
        text_columns: vec![0],
        rows,
    }
}

fn region_table(proof: &Proof) -> Table {
    let rows = proof.regions().into_iter().map(|region| {
        let sums = proof.sums_of_region(region, None);
        let mut row = vec![region.to_owned(), sums.bars.to_string()];
        row.extend(shares(&sums));
        row
    });
    Table {
        header: vec!["region", "error bars", "met", "worst true/target", "true/stated", "held"],
        text_columns: vec![0],
        rows: rows.collect(),
    }
}

/// Table with one row per group of rooms and share of the rays.
fn forecast_table(proof: &Proof) -> Table {
    let mut rows = Vec::new();
    for (group, share) in
        [Group::Tuned, Group::Untuned].into_iter().flat_map(|group| FORECAST_SHARES.map(|share| (group, share)))
    {
        let sums = ForecastSums::at(share, proof.forecasts(group));
        if sums.runs == 0 {
            continue;
        }
        let of_forecast = |fraction: f64| if sums.forecast_runs > 0 { percent(fraction) } else { "–".to_owned() };
        rows.push(vec![
            group.name().to_owned(),
            percent(share),
            sums.runs.to_string(),
            sums.forecast_runs.to_string(),
            of_forecast(sums.off),
            of_forecast(sums.held),
            of_forecast(sums.seconds_off),
            of_forecast(sums.seconds_held),
        ]);
    }
    Table {
        header: vec![
            "rooms",
            "share of the rays",
            "runs",
            "with a forecast by then",
            "rays off, median",
            "held",
            "seconds off, median",
            "held",
        ],
        text_columns: vec![0],
        rows,
    }
}

fn circumstances(proof: &Proof, settings: &ProofSettings, unix_s: u64) -> String {
    let runs = || proof.rooms.iter().flat_map(|room| &room.runs);
    let targets: Vec<String> = settings.targets.iter().map(|target| percent(*target)).collect();
    format!(
        "luxmc {}, {}: {} rooms of {} kinds, {} seeds to each of {}; {} runs, {} rays; references to {}",
        env!("CARGO_PKG_VERSION"),
        date(unix_s),
        proof.rooms.len(),
        settings.kinds.len(),
        settings.seeds,
        targets.join(", "),
        runs().count(),
        count(runs().map(|run| run.cost.rays).sum()),
        percent(settings.reference.target_error)
    )
}

fn verdict(proof: &Proof) -> &'static str {
    if failures(proof).is_empty() { "Accepted." } else { "Not accepted:" }
}

/// The target whose costs are drawn: the smallest one.
fn drawn_target(settings: &ProofSettings) -> Option<(usize, f64)> {
    settings.targets.iter().copied().enumerate().min_by(|one, other| one.1.total_cmp(&other.1))
}

/// The pictures with file name and caption.
fn pictures(proof: &Proof, settings: &ProofSettings) -> Vec<(&'static str, String, String)> {
    let mut pictures = vec![(
        "proving-ground-errors.svg",
        error_picture(proof),
        "True error against stated error of every map that said “target met”. For dots above the line the true error is larger than stated."
            .to_owned(),
    )];
    if let Some((target, target_error)) = drawn_target(settings) {
        let caption = format!(
            "Seconds of walks and of the rival to a true error of {}, divided by those of auto. To the right of the line auto is faster.",
            percent(target_error)
        );
        pictures.push(("proving-ground-costs.svg", cost_picture(proof, target, target_error), caption));
    }
    if proof.forecasts(Group::All).next().is_some() {
        let caption =
            "Forecast of a run's rays divided by their actual number, against the share of them that was done.";
        pictures.push(("proving-ground-forecasts.svg", forecast_picture(proof), caption.to_owned()));
    }
    pictures
}

/// The pictures by file name, for pages that store them separately.
pub fn proof_pictures(proof: &Proof, settings: &ProofSettings) -> Vec<(&'static str, String)> {
    pictures(proof, settings).into_iter().map(|(name, picture, _)| (name, picture)).collect()
}

/// The report as an HTML page.
pub fn proof_html(proof: &Proof, settings: &ProofSettings, unix_s: u64) -> String {
    let mut page = opening("luxmc proving ground");
    page.push_str("<h1>Proving ground</h1>\n");
    page.push_str(&format!("<p class=\"soft\">{}</p>\n", escaped(&circumstances(proof, settings, unix_s))));
    page.push_str(&format!("<p>{}</p>\n<ul>\n", verdict(proof)));
    for failure in failures(proof) {
        page.push_str(&format!("<li>{}</li>\n", escaped(&failure)));
    }
    page.push_str("</ul>\n");
    page.push_str(&html_table(&proof_table(proof, settings), false));
    for (_, picture, caption) in pictures(proof, settings) {
        page.push_str(&format!("<figure>\n{picture}\n<figcaption>{}</figcaption>\n</figure>\n", escaped(&caption)));
    }
    // In a quick proof no run may have taken a second.
    let forecasts = forecast_table(proof);
    if !forecasts.rows.is_empty() {
        page.push_str("<h3>Forecasts</h3>\n");
        page.push_str(&html_table(&forecasts, false));
    }
    page.push_str("<h3>Rooms</h3>\n");
    page.push_str(&html_table(&room_table(proof, settings), false));
    page.push_str("<h3>Regions, all targets</h3>\n");
    page.push_str(&html_table(&region_table(proof), false));
    page.push_str("<ul>\n");
    for remark in remarks(proof) {
        page.push_str(&format!("<li>{}</li>\n", escaped(&remark)));
    }
    page.push_str("</ul>\n<h3>How to read this report</h3>\n");
    for paragraph in HOW_TO_READ {
        page.push_str(&format!("<p>{}</p>\n", escaped(paragraph)));
    }
    page.push_str("</body>\n</html>\n");
    page
}

/// The report as Markdown.
pub fn proof_md(proof: &Proof, settings: &ProofSettings, unix_s: u64) -> String {
    let mut text = format!("# Proving ground\n\n{}\n\n", circumstances(proof, settings, unix_s));
    text.push_str(verdict(proof));
    text.push('\n');
    for failure in failures(proof) {
        text.push_str(&format!("\n- {failure}"));
    }
    text.push_str("\n\n");
    text.push_str(&md_table(&proof_table(proof, settings)));
    let forecasts = forecast_table(proof);
    if !forecasts.rows.is_empty() {
        text.push_str("\n## Forecasts\n\n");
        text.push_str(&md_table(&forecasts));
    }
    text.push_str("\n## Rooms\n\n");
    text.push_str(&md_table(&room_table(proof, settings)));
    text.push_str("\n## Regions, all targets\n\n");
    text.push_str(&md_table(&region_table(proof)));
    for remark in remarks(proof) {
        text.push_str(&format!("\n- {remark}"));
    }
    text.push_str(&format!("\n\nError bars are held to {}.\n", percent(LEVEL)));
    for paragraph in HOW_TO_READ {
        text.push_str(&format!("\n{paragraph}\n"));
    }
    text
}

/// CSV with one row per map of a run. Rays and seconds are those of the whole run.
pub fn proof_csv(proof: &Proof, settings: &ProofSettings) -> String {
    let mut text = String::from(
        "room,kind,room_seed,tuned_on,target_error,seed,stop_reason,rays,cpu_s,map,estimator,target_met,stated_error,true_error,reference_error,bars,bars_held,walks_cpu_s,walks_rays,rival_cpu_s\n",
    );
    for room in &proof.rooms {
        for run in &room.runs {
            let target = settings.targets.iter().position(|target| *target == run.target_error).unwrap_or(0);
            let walks = room.walks[target];
            // 0 if there was no rival, so that no cell is empty.
            let rival_s = room.rival.as_ref().map_or(0.0, |costs| costs[target].cpu_s);
            for map in &run.maps {
                let judgement = &map.judgement;
                text.push_str(&format!(
                    "{},{},{},{},{},{},{},{},{:.9e},\"{}\",{},{},{:.9e},{:.9e},{:.9e},{},{},{:.9e},{:.9e},{:.9e}\n",
                    room.name(),
                    room.kind,
                    room.seed,
                    room.is_for_tuning(),
                    run.target_error,
                    run.seed,
                    run.stop_reason,
                    run.cost.rays,
                    run.cost.cpu_s,
                    map.name,
                    map.estimator,
                    map.said_met,
                    map.stated_error,
                    judgement.true_error,
                    judgement.reference_error,
                    judgement.bars,
                    judgement.held,
                    walks.cpu_s,
                    walks.rays,
                    rival_s
                ));
            }
        }
    }
    text
}
