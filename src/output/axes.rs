//! The frame of a chart: scales, ticks and labels, in one style for all plots.

use super::color::{BLACK, FAINT, SOFT};
use super::numbers::{round_ticks, tick};
use super::picture::{PagePoint, Pen, Picture, TextAnchor, Words};

/// Type size of ticks and labels.
pub const TYPE: f64 = 12.0;
/// Length of a tick.
const TICK: f64 = 4.0;

/// Maps numbers to places along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Number at the beginning of the axis.
    pub low: f64,
    /// Number at the end of the axis.
    pub high: f64,
    /// Whether equal ratios take equal lengths; both ends are then above 0.
    pub logarithmic: bool,
}

impl Scale {
    /// A linear scale.
    pub fn linear(low: f64, high: f64) -> Scale {
        Scale { low, high, logarithmic: false }
    }

    /// A logarithmic scale between two numbers above 0.
    pub fn logarithmic(low: f64, high: f64) -> Scale {
        Scale { low, high, logarithmic: true }
    }

    /// Share of the axis' length at which a number lies; below 0 or above 1 if it lies beyond the ends.
    pub fn share(&self, number: f64) -> f64 {
        if self.logarithmic {
            return (number.max(f64::MIN_POSITIVE) / self.low).ln() / (self.high / self.low).ln();
        }
        (number - self.low) / (self.high - self.low)
    }

    /// The number at a share of the axis' length.
    pub fn number(&self, share: f64) -> f64 {
        if self.logarithmic {
            return self.low * (self.high / self.low).powf(share);
        }
        self.low + share * (self.high - self.low)
    }

    /// Round numbers along the axis, about `most` of them. On a logarithmic axis they are powers of ten, with intermediate
    /// multiples (2 and 5, or 2, 3, 5 and 7) if the axis spans few decades.
    pub fn ticks(&self, most: usize) -> Vec<f64> {
        if !self.logarithmic {
            return round_ticks(self.low, self.high, most);
        }
        let decades = (self.high / self.low).log10();
        let multiples: &[f64] = if decades < 1.2 {
            &[1.0, 2.0, 3.0, 5.0, 7.0]
        } else if decades < 3.0 {
            &[1.0, 2.0, 5.0]
        } else {
            &[1.0]
        };
        let (first, last) = (self.low.log10().floor() as i32, self.high.log10().ceil() as i32);
        let within = |number: &f64| (-1e-6..=1.0 + 1e-6).contains(&self.share(*number));
        let ticks: Vec<f64> = (first..=last)
            .flat_map(|power| multiples.iter().map(move |multiple| multiple * 10f64.powi(power)))
            .filter(within)
            .collect();
        if ticks.len() >= 2 { ticks } else { round_ticks(self.low, self.high, most) }
    }
}

/// The frame of a chart.
#[derive(Clone, Copy, Debug)]
pub struct ChartFrame {
    /// Left edge.
    pub left: f64,
    /// Upper edge.
    pub top: f64,
    /// Width.
    pub width: f64,
    /// Height.
    pub height: f64,
    /// Horizontal scale, low at the left.
    pub x: Scale,
    /// Vertical scale, low at the bottom.
    pub y: Scale,
}

impl ChartFrame {
    /// The point on the page for a pair of numbers.
    pub fn spot(&self, x: f64, y: f64) -> PagePoint {
        [self.left + self.x.share(x) * self.width, self.top + (1.0 - self.y.share(y)) * self.height]
    }

    /// Whether a point of the page lies within the frame.
    pub fn holds(&self, [x, y]: PagePoint) -> bool {
        (self.left - 0.5..=self.left + self.width + 0.5).contains(&x)
            && (self.top - 0.5..=self.top + self.height + 0.5).contains(&y)
    }

    /// Draws grid lines, ticks, their numbers and the axes' labels. `show` formats the numbers of each axis.
    pub fn draw(&self, picture: &mut Picture, labels: [&str; 2], show: [&dyn Fn(f64) -> String; 2]) {
        self.draw_x(picture, Some((labels[0], show[0])));
        self.draw_y(picture, labels[1], show[1]);
        self.draw_rim(picture);
    }

    /// The same without the numbers and label of the horizontal axis, which another frame below shows.
    pub fn draw_upper(&self, picture: &mut Picture, label: &str, show: &dyn Fn(f64) -> String) {
        self.draw_x(picture, None);
        self.draw_y(picture, label, show);
        self.draw_rim(picture);
    }

    /// The same with a horizontal axis only.
    pub fn draw_lower(&self, picture: &mut Picture, label: &str, show: &dyn Fn(f64) -> String) {
        self.draw_x(picture, Some((label, show)));
        self.draw_rim(picture);
    }

    fn draw_x(&self, picture: &mut Picture, numbers: Option<(&str, &dyn Fn(f64) -> String)>) {
        let bottom = self.top + self.height;
        for number in self.x.ticks((self.width / 70.0) as usize) {
            let [x, _] = self.spot(number, self.y.low);
            picture.line(vec![[x, self.top], [x, bottom]], Pen::new(FAINT, 0.8));
            picture.line(vec![[x, bottom], [x, bottom + TICK]], Pen::new(BLACK, 0.8));
            if let Some((_, show)) = numbers {
                let spot = [x, bottom + TICK + TYPE];
                picture.words(Words::new(show(number), spot, TYPE).anchored(TextAnchor::Middle));
            }
        }
        if let Some((label, _)) = numbers {
            let below = [self.left + 0.5 * self.width, bottom + TICK + 2.5 * TYPE];
            picture.words(Words::new(label, below, TYPE).anchored(TextAnchor::Middle).ink(SOFT));
        }
    }

    fn draw_y(&self, picture: &mut Picture, label: &str, show: &dyn Fn(f64) -> String) {
        let mut widest = 0.0f64;
        for number in self.y.ticks((self.height / 40.0) as usize) {
            let [_, y] = self.spot(self.x.low, number);
            picture.line(vec![[self.left, y], [self.left + self.width, y]], Pen::new(FAINT, 0.8));
            picture.line(vec![[self.left - TICK, y], [self.left, y]], Pen::new(BLACK, 0.8));
            let text = show(number);
            widest = widest.max(super::font::text_width(&text, TYPE, false));
            picture.words(Words::new(text, [self.left - TICK - 3.0, y + 4.0], TYPE).anchored(TextAnchor::End));
        }
        let beside = [self.left - TICK - widest - 12.0, self.top + 0.5 * self.height];
        picture.words(Words::new(label, beside, TYPE).anchored(TextAnchor::Middle).ink(SOFT).turned(-90.0));
    }

    fn draw_rim(&self, picture: &mut Picture) {
        let (bottom, right) = (self.top + self.height, self.left + self.width);
        let corners = vec![[self.left, self.top], [right, self.top], [right, bottom], [self.left, bottom]];
        picture.ring(corners, Pen::new(BLACK, 1.0));
    }

    /// The same with plain numbers on both axes.
    pub fn draw_plain(&self, picture: &mut Picture, labels: [&str; 2]) {
        self.draw(picture, labels, [&tick, &tick]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_and_their_inverses_agree() {
        for scale in [Scale::linear(-2.0, 6.0), Scale::logarithmic(0.01, 30.0)] {
            for share in [0.0, 0.3, 1.0] {
                assert!((scale.share(scale.number(share)) - share).abs() < 1e-12);
            }
        }
        assert_eq!(Scale::logarithmic(0.01, 30.0).ticks(5), [0.01, 0.1, 1.0, 10.0]);
        assert_eq!(Scale::logarithmic(1.0, 30.0).ticks(5), [1.0, 2.0, 5.0, 10.0, 20.0]);
    }
}
