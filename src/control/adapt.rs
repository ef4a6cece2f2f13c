//! Chooses which elements to cut, so that the loss (the light variation that elements cannot show) falls to a goal with as few new elements
//! as possible.

/// Cuts of one element in one round, at most. The loss of its pieces is known only after the next look at them.
const MOST_CUTS_A_ROUND: u32 = 2;
/// Expected loss of a piece over the loss of the whole, both as mean squares over the area. One cut makes four pieces. The value is that of
/// a smooth curve. Along an edge of light it is one half: the next round measures that and cuts more.
const LOSS_OF_A_PIECE: f64 = 1.0 / 16.0;

/// State of one element.
#[derive(Clone, Copy, Debug)]
pub struct ElementLoss {
    /// Area in m².
    pub area_m2: f64,
    /// Mean square over its area of the variation that it cannot show, in lx².
    pub lost_lx2: f64,
    /// How many more times it may be cut.
    pub cuts_left: u32,
}

/// Returns how often to cut each element, so that the mean square loss over all areas falls to `goal_lx2`, in lx². The number of elements
/// stays at or below `most_elements`.
///
/// Every element costs the same work, so the elements with the greatest area times loss are cut first. Those that would be cut more often
/// than a round allows leave the goal to the next round: the others are not cut in their place.
pub fn cuts_for(elements: &[ElementLoss], goal_lx2: f64, most_elements: usize) -> Vec<u32> {
    let area_m2: f64 = elements.iter().map(|element| element.area_m2).sum();
    let cuts_at = |threshold: f64| {
        move |element: &ElementLoss| {
            let mut loss = element.area_m2 * element.lost_lx2;
            let mut cuts = 0;
            while loss > threshold && cuts < element.cuts_left {
                loss *= 0.25 * LOSS_OF_A_PIECE;
                cuts += 1;
            }
            cuts
        }
    };
    let after = |threshold: f64| {
        let (mut loss, mut count) = (0.0, 0.0);
        // What cannot be cut loses what it loses, however finely the others are cut.
        for element in elements.iter().filter(|element| element.cuts_left > 0) {
            let cuts = cuts_at(threshold)(element);
            loss += element.area_m2 * element.lost_lx2 * LOSS_OF_A_PIECE.powi(cuts as i32);
            count += 4f64.powi(cuts as i32);
        }
        (loss, count)
    };
    let most_elements = most_elements as f64;
    let cuttable = elements.iter().filter(|element| element.cuts_left > 0);
    let most = cuttable.map(|element| element.area_m2 * element.lost_lx2).fold(0.0, f64::max);
    if most <= 0.0 || after(most).0 <= goal_lx2 * area_m2 {
        return vec![0; elements.len()];
    }
    // The highest threshold that reaches the goal, or the lowest that keeps to the number of elements.
    let (mut low, mut high) = (most * 1e-12, most);
    for _ in 0..60 {
        let middle = (low * high).sqrt();
        let (loss, count) = after(middle);
        if loss > goal_lx2 * area_m2 && count <= most_elements { high = middle } else { low = middle }
    }
    let threshold = if after(low).1 <= most_elements { low } else { high };
    let cuts = cuts_at(threshold);
    elements.iter().map(|element| cuts(element).min(MOST_CUTS_A_ROUND)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn element(area_m2: f64, lost_lx2: f64) -> ElementLoss {
        ElementLoss { area_m2, lost_lx2, cuts_left: 9 }
    }

    #[test]
    fn those_that_lose_most_are_cut_until_the_goal_is_near() {
        let elements = [element(1.0, 16.0), element(1.0, 0.1), element(4.0, 0.5), element(1e-6, 900.0)];
        assert_eq!(cuts_for(&elements, 100.0, 1000), [0, 0, 0, 0]);
        assert_eq!(cuts_for(&elements, 1.5, 1000), [1, 0, 0, 0]);
        let fine = cuts_for(&elements, 0.03, 1000);
        assert_eq!(fine, [2, 1, 2, 0]);
        let count = |cuts: &[u32]| cuts.iter().map(|cuts| 1usize << (2 * cuts)).sum::<usize>();
        assert!(count(&cuts_for(&elements, 1e-9, 20)) <= 20 + 12);
        let uncuttable = [ElementLoss { cuts_left: 0, ..elements[0] }];
        assert_eq!(cuts_for(&uncuttable, 1e-3, 1000), [0]);
        // What cannot be cut is no reason to cut the others more.
        let beside = [elements[0], ElementLoss { lost_lx2: 1e6, ..uncuttable[0] }];
        assert_eq!(
            cuts_for(&beside, 0.5, 1000),
            cuts_for(&elements[..1], 1.0, 1000).into_iter().chain([0]).collect::<Vec<_>>()
        );
    }

    /// A peak that needs five cuts among 999 elements that lose less than the goal. The round cuts the peak alone. Planted fault: if the
    /// goal had to be reached by two cuts, all would be cut.
    #[test]
    fn a_peak_does_not_cut_what_lies_around_it() {
        let mut elements = vec![element(1.0, 1.0); 1000];
        elements[500] = element(1.0, 1e8);
        let cuts = cuts_for(&elements, 2.0, 400_000);
        assert_eq!((cuts[500], cuts.iter().sum::<u32>()), (2, 2));
        elements[500].cuts_left = 2;
        assert!(cuts_for(&elements, 2.0, 400_000).iter().sum::<u32>() > 1000, "the planted fault passed");
    }
}
