//! Which elements to cut, so that what they cannot show comes down to a goal with as few new ones as possible.

/// How often one round cuts an element, at most: what its pieces lose is known only after a look at them.
const MOST_CUTS_A_ROUND: u32 = 2;
/// One cut makes four pieces. Each is expected to lose a sixteenth of what the whole lost in the mean over its area, as of
/// a smooth curve. Along an edge of light it will be half: the next round, which sees that, cuts more.
const LOSS_OF_A_PIECE: f64 = 1.0 / 16.0;

/// An element as it stands.
#[derive(Clone, Copy, Debug)]
pub struct ElementLoss {
    /// Area in m².
    pub area_m2: f64,
    /// Mean square over its area of what it cannot show, in lx².
    pub lost_lx2: f64,
    /// How often it may still be cut.
    pub cuts_left: u32,
}

/// How often to cut each element, so that the mean square over all areas comes down to a goal in lx², with no more than
/// so many elements.
///
/// Every element costs the same work, so those that lose most, area times loss, are cut first.
pub fn cuts_for(elements: &[ElementLoss], goal_lx2: f64, most_elements: usize) -> Vec<u32> {
    let area_m2: f64 = elements.iter().map(|element| element.area_m2).sum();
    let cuts_at = |threshold: f64| {
        move |element: &ElementLoss| {
            let mut loss = element.area_m2 * element.lost_lx2;
            let mut cuts = 0;
            while loss > threshold && cuts < element.cuts_left.min(MOST_CUTS_A_ROUND) {
                loss *= 0.25 * LOSS_OF_A_PIECE;
                cuts += 1;
            }
            cuts
        }
    };
    let after = |threshold: f64| {
        let (mut loss, mut count) = (0.0, 0usize);
        for element in elements {
            let cuts = cuts_at(threshold)(element);
            loss += element.area_m2 * element.lost_lx2 * LOSS_OF_A_PIECE.powi(cuts as i32);
            count += 1 << (2 * cuts);
        }
        (loss, count)
    };
    let most = elements.iter().map(|element| element.area_m2 * element.lost_lx2).fold(0.0, f64::max);
    if most <= 0.0 || after(most).0 <= goal_lx2 * area_m2 {
        return vec![0; elements.len()];
    }
    // The highest threshold that reaches the goal, or the lowest that keeps the number of elements.
    let (mut low, mut high) = (most * 1e-12, most);
    for _ in 0..60 {
        let middle = (low * high).sqrt();
        let (loss, count) = after(middle);
        if loss > goal_lx2 * area_m2 && count <= most_elements { high = middle } else { low = middle }
    }
    let threshold = if after(low).1 <= most_elements { low } else { high };
    elements.iter().map(cuts_at(threshold)).collect()
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
    }
}
