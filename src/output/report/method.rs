//! How a report's numbers were computed, how certain they are, and the evidence for that.

use super::super::lines::line_item;
use super::Report;
use crate::output::html::{HtmlTable, figure};
use crate::output::numbers::{amount, count, duration, grouped};
use crate::output::picture::escaped;
use crate::output::plots::PlotKind;
use crate::output::report_words::{method_words, stop_words, target_words};
use crate::output::texts::{said, say, words};
use crate::solver::{Activity, Spending};

const HALVES: &str = words!(
    "The two halves of the computation are independent. Where they differ by chance alone, the colours are pale and \
     scattered. Neighbouring points may share light paths, so small groups of them may have one colour; the stated \
     errors include this. Strong colours over wide areas would be an error that they do not include."
);
const HISTOGRAM: &str = words!(
    "Bars as wide as the curve: the halves differ as much as the stated errors say. Narrower bars: the stated errors \
     also include what is wrong in both halves alike, or are too large. Wider bars: the stated errors are too small."
);
const GATHERED_HALVES: &str = words!(
    "The two halves of the computation are independent. Within a half, neighbouring points take light from the same \
     cells, so patches and even a whole map may have one colour; the stated errors include this. Strong colours over \
     wide areas would be an error that they do not include."
);
const GATHERED_HISTOGRAM: &str = words!(
    "Bars as wide as the curve, or narrower: the halves differ by no more than the stated errors say. The bars may \
     lie to one side of the curve, since points that take light from the same cells differ alike. Bars far beyond \
     the curve, on one side or on both, would be a larger error than stated."
);

impl Report<'_> {
    pub(super) fn method(&self) -> String {
        let solution = self.solution;
        let mut page = format!("<h2 class=\"page\">{}</h2>\n", say!("How this was computed, and how certain it is"));
        page += &format!("<p>{}</p>\n", method_words(solution));
        page += &format!("<p>{}</p>\n<p>{}</p>\n", escaped(&target_words(solution)), escaped(&stop_words(solution)));
        let work = say!(
            "Computed in {} with {} {}: {} light paths (chains), {} rays, seed {}.",
            duration(self.context.wall_s),
            self.context.threads,
            if self.context.threads == 1 { say!("thread") } else { say!("threads") },
            grouped(solution.chains),
            count(solution.rays as f64),
            solution.seed
        );
        page += &format!("<p>{work}</p>\n");
        if let Ok(balance) = &solution.flux_balance {
            let balance = say!(
                "Of {} lm emitted, surfaces absorbed {} lm, {} lm left the scene, {} lm fell on the backs of \
                 one-sided surfaces and {} lm were not followed further.",
                amount(balance.emitted_lm),
                amount(balance.absorbed_lm),
                amount(balance.escaped_lm),
                amount(balance.back_face_lm),
                amount(balance.truncated_lm)
            );
            page += &format!("<p>{balance}</p>\n");
        }
        page += &format!(
            "<h3>{}</h3>\n<p>{} {}:</p>\n<pre>{}</pre>\n",
            say!("How to repeat this run"),
            say!("With luxmc {} and the scene file,", env!("CARGO_PKG_VERSION")),
            if self.context.repeats_digits {
                say!("this command gives the same digits again, with any number of threads")
            } else {
                say!(
                    "this command gives results of the same quality again (the same digits if <code>--chains</code> fixes the light paths)"
                )
            },
            escaped(&self.context.command)
        );
        page
    }

    /// The evidence for the stated errors: how the error fell, how much the halves differ, and where the time was spent.
    pub(super) fn evidence(&self) -> String {
        let mut page = format!("<h2 class=\"page\">{}</h2>\n", say!("Evidence"));
        let of = |kind: PlotKind| self.plots.iter().filter(move |plot| plot.kind == kind);
        for plot in of(PlotKind::Halves) {
            page += &figure(
                &plot.picture,
                said(if self.solution.is_gathered(&plot.subject) { GATHERED_HALVES } else { HALVES }),
            );
        }
        for plot in of(PlotKind::HalvesHistogram) {
            let words = if self.solution.is_gathered(&plot.subject) { GATHERED_HISTOGRAM } else { HISTOGRAM };
            page += &figure(&plot.picture, said(words));
        }
        for plot in of(PlotKind::Convergence) {
            page += &format!("<div class=\"tall\">\n{}</div>\n", figure(&plot.picture, ""));
        }
        page + &spending_table(&self.solution.spending) + &self.notes()
    }

    /// The notes on how the results were computed; empty if there are none.
    fn notes(&self) -> String {
        let items: String = self.solution.notes.iter().map(|line| line_item(line)).collect();
        if items.is_empty() {
            return items;
        }
        format!(
            "<div class=\"notes\">\n<p><b>{}</b></p>\n<ul>\n{items}</ul>\n</div>\n",
            say!("How these results came about")
        )
    }
}

/// Rays and computing time by activity.
fn spending_table(spending: &Spending) -> String {
    let caption = say!("What rays and computing time were used for");
    let mut table = HtmlTable::new(caption, &[("", true), (say!("Rays"), false), (say!("Time"), false)]);
    if *spending == Spending::default() {
        return String::new();
    }
    let spent = |activity: &Activity| spending.rays(*activity) > 0 || spending.seconds(*activity) > 0.0;
    for activity in Activity::ALL.into_iter().filter(spent) {
        let rays = match spending.rays(activity) {
            0 => "–".to_owned(),
            rays => count(rays as f64),
        };
        table.row(vec![said(activity.words()).to_owned(), rays, duration(spending.seconds(activity))]);
    }
    table.markup()
}
