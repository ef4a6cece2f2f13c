//! Sorting by an integer first, for example vertex numbers of meshes. It counts, so the time is proportional to the number of items.

use rayon::prelude::*;

/// If the numbers span more than this many times the number of items, sorting by comparison is faster than counting.
const WIDEST_SPAN: usize = 4;

/// Returns the items in order. Their order must begin with `number_of`; `items` is called three times.
pub(super) fn sorted_by_number<T, I>(items: impl Fn() -> I, number_of: impl Fn(&T) -> u32) -> Vec<T>
where
    T: Copy + Ord + Send,
    I: Iterator<Item = T>,
{
    let Some(any) = items().next() else { return Vec::new() };
    let (mut count, mut lowest, mut highest) = (0, u32::MAX, 0);
    for item in items() {
        let number = number_of(&item);
        (count, lowest, highest) = (count + 1, lowest.min(number), highest.max(number));
    }
    let span = (highest - lowest) as usize + 1;
    if span > WIDEST_SPAN * count {
        let mut sorted: Vec<T> = items().collect();
        sorted.par_sort_unstable();
        return sorted;
    }

    // Position of the next item of each number: at first after all items of lower numbers, in the end after its own items.
    let mut next = vec![0; span];
    items().for_each(|item| next[(number_of(&item) - lowest) as usize] += 1);
    let mut before = 0;
    for place in &mut next {
        before += std::mem::replace(place, before);
    }
    let mut sorted = vec![any; count];
    for item in items() {
        let place = &mut next[(number_of(&item) - lowest) as usize];
        sorted[*place] = item;
        *place += 1;
    }
    let mut start = 0;
    for end in next {
        sorted[start..end].sort_unstable();
        start = end;
    }
    sorted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_are_in_the_order_of_a_plain_sort() {
        // Numbers near each other, far apart and all the same; the rest of each item in no order.
        for (factor, modulus) in [(7919, 500), (1 << 20, u64::from(u32::MAX)), (0, 1)] {
            let items: Vec<(u32, u64, bool)> = (0..1000u64)
                .map(|index| ((3 + index * factor % modulus) as u32, index * 104_729 % 997, index % 3 == 0))
                .collect();
            let mut plain = items.clone();
            plain.sort_unstable();
            assert_eq!(sorted_by_number(|| items.iter().copied(), |item| item.0), plain);
        }
        assert!(sorted_by_number(std::iter::empty::<(u32, u32)>, |item| item.0).is_empty());
    }
}
