//! Reports of speed against error: HTML page, Markdown, CSV.

use plotters::prelude::*;

use super::ladder::{LEVELS, Ladder, LadderFit, Rung};
use super::plots::{Drawn, EXACT, FAINT, MEASURED, Sign, TEXT, legend, legend_height, svg, tick};
use super::report::Table;
use super::report_html::{opening, table as html_table};
use super::report_md::table as md_table;
use super::words::{count, duration, escaped, percent, significant};
use crate::output::numbers::count_tick;

/// Colours that distinguish methods in plots, together with shapes, in print too (Okabe and Ito 2008).
///
/// Their number has no common divisor with the three shapes, so a combination does not repeat soon.
const COLOURS: [RGBColor; 7] = [
    MEASURED,
    EXACT,
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
    RGBColor(230, 159, 0),
];

const HOW_TO_READ: &str = "Every method computes the same map with more and more chains, to smaller and smaller targets, or on finer and finer meshes. Its true error is the root mean square of its deviations from the exact map, divided by the map's mean. With independent samples, half the error costs four times as much: a slope of −0.5. The figure of merit is 1/(error² × time): twice the figure means the same error in half the time. Times marked * are extrapolated beyond the measured range. Where the truth is a long run, its own error is subtracted in the mean of squares, and a ladder ends where a method is as exact as the truth. A method that differs only by rounding is exact, and its times are those of its cheapest run.";

/// Groups the ladders by map; each group has its own pictures.
fn by_map(ladders: &[Ladder]) -> Vec<(String, Vec<&Ladder>)> {
    let mut groups: Vec<(String, Vec<&Ladder>)> = Vec::new();
    for ladder in ladders {
        let name = format!("{}, {}: {}", ladder.case, ladder.run, ladder.comparison);
        match groups.iter_mut().find(|(known, _)| *known == name) {
            Some((_, group)) => group.push(ladder),
            None => groups.push((name, vec![ladder])),
        }
    }
    groups
}

fn name_of(ladder: &Ladder) -> String {
    if ladder.method == ladder.estimator {
        ladder.method.clone()
    } else {
        format!("{} ({})", ladder.method, ladder.estimator)
    }
}

/// The figure of merit in words; a dash if a rung has no error.
fn figure_of_merit(ladder: &Ladder) -> String {
    let figure = ladder.figure_of_merit();
    if ladder.exact_rung().is_some() {
        "exact".to_owned()
    } else if !figure.is_finite() {
        "–".to_owned()
    } else if figure < 1000.0 {
        significant(figure, 3)
    } else {
        count(figure)
    }
}

fn results(ladders: &[&Ladder]) -> Table {
    let rows = ladders.iter().map(|ladder| {
        let best = ladder.rungs.last();
        let slope =
            |fit: &Option<LadderFit>| fit.map_or("–".to_owned(), |fit| significant(fit.slope, 3).replace('-', "−"));
        let mut row = vec![
            name_of(ladder),
            best.map_or("–".to_owned(), |rung| percent(rung.true_error)),
            best.map_or("–".to_owned(), |rung| duration(rung.seconds)),
            slope(&ladder.by_time),
            slope(&ladder.by_rays),
            figure_of_merit(ladder),
        ];
        row.extend(LEVELS.iter().map(|level| match (ladder.exact_rung(), &ladder.by_time) {
            (Some(rung), _) => duration(rung.seconds),
            (None, None) => "–".to_owned(),
            (None, Some(fit)) => {
                let mark = if fit.extrapolates(*level) { "*" } else { "" };
                format!("{}{mark}", duration(fit.cost_at(*level)))
            }
        }));
        row
    });
    Table {
        header: vec![
            "method",
            "smallest error",
            "reached in",
            "slope by time",
            "slope by rays",
            "figure of merit, 1/s",
            "time to 3\u{a0}%",
            "time to 1\u{a0}%",
            "time to 0.3\u{a0}%",
        ],
        text_columns: vec![0],
        rows: rows.collect(),
    }
}

fn rungs(ladder: &Ladder) -> Table {
    let rows = ladder.rungs.iter().map(|rung| {
        vec![
            count(rung.chains as f64),
            count(rung.rays as f64),
            duration(rung.seconds),
            percent(rung.true_error),
            percent(rung.stated_error),
            rung.runs.to_string(),
        ]
    });
    Table {
        header: vec!["chains", "rays", "time", "true error", "stated error", "runs"],
        text_columns: Vec::new(),
        rows: rows.collect(),
    }
}

/// Sign of a method in plots: its colour and shape.
fn sign(index: usize) -> Sign {
    let colour = COLOURS[index % COLOURS.len()];
    match index % 3 {
        0 => Sign::Dot(colour),
        1 => Sign::Triangle(colour),
        _ => Sign::Cross(colour),
    }
}

fn plot(ladders: &[&Ladder], axis: &str, cost: fn(&Rung) -> f64, fit: fn(&Ladder) -> Option<LadderFit>) -> String {
    // A rung without error or without rays (radiosity) cannot be shown on logarithmic axes.
    let is_shown = |rung: &&Rung| rung.true_error > 0.0 && cost(rung) > 0.0;
    let all = || ladders.iter().flat_map(|ladder| &ladder.rungs).filter(is_shown);
    let (least, most) =
        all().fold((f64::INFINITY, 0.0f64), |(low, high), rung| (low.min(cost(rung)), high.max(cost(rung))));
    let (smallest, largest) = all().fold((f64::INFINITY, 0.0f64), |(low, high), rung| {
        (low.min(100.0 * rung.true_error), high.max(100.0 * rung.true_error))
    });
    if most <= 0.0 {
        return "<p>There is nothing to plot: every value is exact or has no cost of this kind.</p>".to_owned();
    }
    let signs: Vec<(Sign, String)> = ladders
        .iter()
        .enumerate()
        .filter(|(_, ladder)| ladder.rungs.iter().any(|rung| is_shown(&rung)))
        .map(|(index, ladder)| (sign(index), name_of(ladder)))
        .collect();
    let legend_height = legend_height(&signs);
    svg(364 + legend_height, |area| -> Drawn {
        let (top, below) = area.split_vertically(legend_height);
        legend(&top, &signs)?;
        let mut chart = ChartBuilder::on(&below)
            .margin(8)
            .margin_right(18)
            .x_label_area_size(46)
            .y_label_area_size(72)
            .build_cartesian_2d((least / 1.5..most * 1.5).log_scale(), (smallest / 1.6..largest * 1.6).log_scale())?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(FAINT)
            .x_labels(8)
            .y_labels(8)
            .x_desc(axis)
            .y_desc("true relative RMS error, %")
            .label_style(TEXT)
            .x_label_formatter(&|value| if *value < 1000.0 { tick(*value) } else { count_tick(*value) })
            .y_label_formatter(&|value| tick(*value))
            .draw()?;
        for (index, ladder) in ladders.iter().enumerate() {
            let colour = COLOURS[index % COLOURS.len()];
            let places: Vec<(f64, f64)> =
                ladder.rungs.iter().filter(is_shown).map(|rung| (cost(rung), 100.0 * rung.true_error)).collect();
            if let Some(fit) = fit(ladder) {
                let ends = [fit.covers[0], fit.covers[1]].map(|error| (fit.cost_at(error), 100.0 * error));
                chart.draw_series(LineSeries::new(ends, colour.stroke_width(2)))?;
            }
            match sign(index) {
                Sign::Dot(_) => chart.draw_series(places.iter().map(|at| Circle::new(*at, 5, colour.filled())))?,
                Sign::Triangle(_) => {
                    chart.draw_series(places.iter().map(|at| TriangleMarker::new(*at, 7, colour.filled())))?
                }
                _ => chart.draw_series(places.iter().map(|at| Cross::new(*at, 5, colour.stroke_width(2))))?,
            };
        }
        Ok(())
    })
}

/// The HTML page: a table and two pictures for every map, then `sections`.
pub fn ladder_html(ladders: &[Ladder], sections: &str) -> String {
    let mut page = opening("luxmc: speed against error");
    page.push_str("<h1>luxmc: speed against error</h1>\n");
    if !ladders.is_empty() {
        page.push_str(&format!("<p>{}</p>\n", escaped(HOW_TO_READ)));
    }
    for (name, group) in by_map(ladders) {
        page.push_str(&format!("<h2>{}</h2>\n{}", escaped(&name), html_table(&results(&group), false)));
        let by_time = plot(&group, "wall time, s", |rung| rung.seconds, |ladder| ladder.by_time);
        let by_rays = plot(&group, "rays", |rung| rung.rays as f64, |ladder| ladder.by_rays);
        for (picture, caption) in
            [(by_time, "True error against wall time, with the fitted lines."), (by_rays, "True error against rays.")]
        {
            page.push_str(&format!("<figure>\n{picture}\n<figcaption>{caption}</figcaption>\n</figure>\n"));
        }
        for ladder in group {
            page.push_str(&format!("<h3>{}</h3>\n{}", escaped(&name_of(ladder)), html_table(&rungs(ladder), false)));
        }
    }
    page.push_str(sections);
    page.push_str("</body>\n</html>\n");
    page
}

/// The same report as Markdown, without pictures.
pub fn ladder_md(ladders: &[Ladder], sections: &str) -> String {
    let mut page = "# luxmc: speed against error\n\n".to_owned();
    if !ladders.is_empty() {
        page.push_str(&format!("{HOW_TO_READ}\n\n"));
    }
    for (name, group) in by_map(ladders) {
        page.push_str(&format!("## {name}\n\n{}\n", md_table(&results(&group))));
        for ladder in group {
            page.push_str(&format!("### {}\n\n{}\n", name_of(ladder), md_table(&rungs(ladder))));
        }
    }
    page.push_str(sections);
    page
}

/// CSV with one row for every rung.
pub fn ladder_csv(ladders: &[Ladder]) -> String {
    let mut text =
        String::from("case,run,comparison,method,estimator,chains,rays,wall_s,true_error,stated_error,runs\n");
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    for ladder in ladders {
        for rung in &ladder.rungs {
            let names = [&ladder.case, &ladder.run, &ladder.comparison, &ladder.method, &ladder.estimator];
            let names: Vec<String> = names.iter().map(|name| quoted(name)).collect();
            text.push_str(&format!(
                "{},{},{},{:?},{:?},{:?},{}\n",
                names.join(","),
                rung.chains,
                rung.rays,
                rung.seconds,
                rung.true_error,
                rung.stated_error,
                rung.runs
            ));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A method with only rounding errors is called exact, with its time. A method with larger errors has a figure (planted fault:
    /// calling it exact too).
    #[test]
    fn exact_methods_are_called_exact() {
        let ladder = |true_error: f64| {
            let rung = Rung { chains: 0, rays: 1000, seconds: 0.5, true_error, stated_error: 0.0, runs: 1 };
            let [case, run, comparison, method, estimator] = ["a", "b", "c", "d", "d"].map(str::to_owned);
            Ladder { case, run, comparison, method, estimator, rungs: vec![rung], by_time: None, by_rays: None }
        };
        let row = |true_error: f64| results(&[&ladder(true_error)]).rows[0].clone();
        let exact = row(3e-15);
        assert_eq!(exact[5], "exact");
        assert!(exact[6..].iter().all(|time| *time == duration(0.5)), "{exact:?}");
        let off = row(1e-4);
        assert!(off[5] != "exact" && off[6..].iter().all(|time| time == "–"), "{off:?}");
    }
}
