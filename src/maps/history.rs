//! History of a map: its state at each check of its error.

use serde::{Deserialize, Serialize};

use super::REPLICAS;

/// State of a map at one check of its error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PastJudgement {
    /// Samples of every replica.
    pub samples: u64,
    /// Rays traced for the map.
    pub rays: u64,
    /// Expected squared error, in the squared unit of the map's quantity: only the part that falls with more samples.
    pub squared_error: f64,
    /// Effective degrees of freedom of the error.
    pub degrees_of_freedom: f64,
    /// Weighted mean of the map in each replica, in the unit of its quantity.
    pub means: [f64; REPLICAS],
}

/// All error checks of a map's present samples, in order.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct History {
    looks: Vec<PastJudgement>,
}

impl History {
    /// Adds a look (error check). A look with fewer samples than the last one shows that the map began anew, and clears the history. A look
    /// with the same number of samples is ignored.
    pub fn add(&mut self, look: PastJudgement) {
        match self.looks.last() {
            Some(last) if look.samples < last.samples => self.looks.clear(),
            Some(last) if look.samples == last.samples => return,
            _ => {}
        }
        self.looks.push(look);
    }

    /// Clears the history: the map begins anew.
    pub fn clear(&mut self) {
        self.looks.clear();
    }

    /// Returns the latest look.
    pub fn last(&self) -> Option<&PastJudgement> {
        self.looks.last()
    }

    /// Returns the look whose number of samples is nearest to `share` of the latest one's. Only looks with a share in the range `between`
    /// count.
    pub fn at_share(&self, share: f64, between: [f64; 2]) -> Option<&PastJudgement> {
        let all = self.last()?.samples as f64;
        let share_of = |look: &PastJudgement| look.samples as f64 / all;
        let within = self.looks.iter().filter(|look| (between[0]..=between[1]).contains(&share_of(look)));
        within.min_by(|a, b| (share_of(a) - share).abs().total_cmp(&(share_of(b) - share).abs()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_look_nearest_to_a_share_is_found_and_a_new_start_forgets() {
        let look =
            |samples| PastJudgement { samples, rays: 0, squared_error: 1.0, degrees_of_freedom: 1.0, means: [1.0; 16] };
        let mut history = History::default();
        [10, 20, 40, 80, 80].into_iter().for_each(|samples| history.add(look(samples)));
        assert_eq!(history.at_share(0.5, [0.3, 0.75]).map(|look| look.samples), Some(40));
        assert_eq!(history.at_share(0.9, [0.8, 0.95]), None);
        history.add(look(5));
        assert_eq!(history.at_share(0.5, [0.0, 0.9]), None);
    }
}
